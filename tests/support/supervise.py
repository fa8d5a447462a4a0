# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a test program, stops it at a time limit, and kills all processes that it leaves behind.

    supervise.py SECONDS PROGRAM [ARGUMENT...]

At the limit, the program receives SIGABRT: Python then prints the stacks of its threads, and tests/page/harness.js the
name of the running test. Processes that outlive the program are killed, however it ends. If the parent of this process
ends, all of them are killed. At the end, prints the processor time of the program and of all its descendants.
"""

import contextlib
import ctypes
import os
import pathlib
import resource
import signal
import subprocess
import sys

PR_SET_PDEATHSIG = 1
PR_SET_CHILD_SUBREAPER = 36
SECONDS_TO_REPORT = 15
HANDLED = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)

libc = ctypes.CDLL(None, use_errno=True)


def control(option, value):
    if libc.prctl(option, value, 0, 0, 0) != 0:
        raise OSError(ctypes.get_errno(), "prctl")


def children():
    """Yields the children of this process: the program, and its descendants that have lost their parent."""
    for file in pathlib.Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            if int(file.read_text(errors="replace").rpartition(")")[2].split()[1]) == os.getpid():
                yield int(file.parent.name)


def kill_all():
    """Kills children until none is left. When a child ends, its own children become children of this process."""
    with contextlib.suppress(ChildProcessError):
        while True:
            for child in children():
                os.kill(child, signal.SIGKILL)
            os.waitpid(-1, 0)


def run(limit, command):
    """Runs a command. Returns its exit status in the form of a shell, or 1 if it exceeded the limit."""
    control(PR_SET_CHILD_SUBREAPER, 1)
    control(PR_SET_PDEATHSIG, signal.SIGTERM)
    program = subprocess.Popen(command, env={**os.environ, "PYTHONFAULTHANDLER": "1"},
                               preexec_fn=lambda: control(PR_SET_PDEATHSIG, signal.SIGKILL))
    try:
        status = program.wait(limit)
        return status if status >= 0 else 128 - status
    except subprocess.TimeoutExpired:
        print(f"\ntime limit of {limit:g} s exceeded", file=sys.stderr, flush=True)
        program.send_signal(signal.SIGABRT)
        with contextlib.suppress(subprocess.TimeoutExpired):
            program.wait(SECONDS_TO_REPORT)
        return 1
    finally:
        kill_all()


def report_processor_time():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"\nprocessor time {used.ru_utime + used.ru_stime:.1f} s", file=sys.stderr, flush=True)


def leave(number, _):
    for handled in HANDLED:
        signal.signal(handled, signal.SIG_IGN)
    sys.exit(128 + number)


if __name__ == "__main__":
    for handled in HANDLED:
        signal.signal(handled, leave)
    result = run(float(sys.argv[1]), sys.argv[2:])
    report_processor_time()
    sys.exit(result)
