# SPDX-License-Identifier: GPL-3.0-or-later
"""Signals, threads, processes, progress and memory."""

import concurrent.futures
import gc
import multiprocessing
import pathlib
import signal
import subprocess
import sys

import ccdt
import numpy as np
import pytest
from harness import PATIENCE

# More than a minute of work, which tests interrupt.
LONG = {"domain": ccdt.Torus(), "sites": 50_000, "iterations": 1000, "passes": 100, "threads": 1}

INTERRUPTED = """
import ccdt, time
def report(share):
    print("running", flush=True)
try:
    ccdt.sample(ccdt.Torus(), 50_000, iterations=1000, passes=100, threads=1, progress=report)
except KeyboardInterrupt:
    print("interrupted", ccdt.sample(ccdt.Torus(), 10).shape, flush=True)
"""


def test_an_interrupt_ends_the_computation():
    with subprocess.Popen([sys.executable, "-c", INTERRUPTED], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "running\n"
        process.send_signal(signal.SIGINT)
        output = process.communicate(timeout=PATIENCE)[0]
    assert output.splitlines()[-1] == "interrupted (10, 2)"
    assert process.returncode == 0


def test_progress_grows_to_the_end():
    shares = []
    ccdt.sample(ccdt.Torus(), 20_000, progress=shares.append)
    assert shares == sorted(set(shares)) and 0 < shares[0] and shares[-1] <= 1


def test_an_exception_in_progress_ends_the_computation():
    def refuse(share):
        raise LookupError(share)

    with pytest.raises(LookupError):
        ccdt.sample(**LONG, progress=refuse)


# The other thread can only end the computation if the computation does not hold the interpreter's lock.
OBSERVED = """
import ccdt, os, signal, threading
def observe():
    for seed in range(50):
        ccdt.sample(ccdt.Torus(), 10, seed=seed)
    os.kill(os.getpid(), signal.SIGINT)
thread = threading.Thread(target=observe)
try:
    thread.start()
    ccdt.sample(ccdt.Torus(), 50_000, iterations=1000, passes=100, threads=1)
except KeyboardInterrupt:
    thread.join()
    print("interrupted")
"""


def test_other_threads_run_meanwhile():
    done = subprocess.run([sys.executable, "-c", OBSERVED], capture_output=True, text=True, timeout=PATIENCE,
                          check=False)
    assert (done.stdout, done.returncode) == ("interrupted\n", 0)


def test_several_threads_compute_at_once():
    def points(seed):
        return ccdt.sample(ccdt.Torus(), 2000, seed=seed)

    expected = [points(seed) for seed in range(6)]
    with concurrent.futures.ThreadPoolExecutor(3) as pool:
        found = list(pool.map(points, range(6), timeout=PATIENCE))
    assert all(np.array_equal(one, other) for one, other in zip(expected, found))


def test_the_number_of_threads_does_not_matter(ramp):
    assert ccdt.halftone(ramp, threads=1).write() == ccdt.halftone(ramp, threads=3).write()


def points_of(seed):
    return ccdt.sample(ccdt.Torus(), 1000, seed=seed)


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_processes_compute(method):
    expected = [points_of(seed) for seed in range(2)]
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=multiprocessing.get_context(method)) as pool:
        found = list(pool.map(points_of, range(2), timeout=PATIENCE))
    assert all(np.array_equal(one, other) for one, other in zip(expected, found))


def resident():
    """Returns the memory of this process in bytes."""
    return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * 4096


def test_no_memory_is_lost():
    picture = np.tile(np.linspace(0, 255, 512).astype(np.uint8), (256, 1))

    def work():
        halftone = ccdt.halftone(picture, 200, quality="draft", scale=2)
        halftone.image()
        ccdt.sample(ccdt.Torus(), 2000, quality="draft").write("csv")
        with pytest.raises(ccdt.Error):
            ccdt.halftone(picture, 0)

    for _ in range(5):
        work()
    gc.collect()
    before = resident()
    for _ in range(50):
        work()
    gc.collect()
    # The picture as floats has half a mebibyte. Losing it, the drawing or the points in each call would exceed this.
    assert resident() - before < 5 << 20
