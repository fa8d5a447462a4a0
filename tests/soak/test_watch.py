# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests the detection of leaks, on series with and without leaks."""

import random
import subprocess
import unittest

from watch import NOTHING, Held, Level, held, judge, slope

MIB = 1 << 20


def series(requests_a_round, rounds=6, memory=0.0, files=0.0, threads=0.0, processes=0.0, step=0, started=0,
           seed=1):
    """Returns levels of a server that leaks these amounts per request, with noise of up to 3 MiB, a step of memory
    after two rounds, and a number of computation processes that start in the first round."""
    noise = random.Random(seed)
    levels = []
    for i in range(rounds + 1):
        requests = i * requests_a_round
        grown = int(memory * requests) + (step if i > 1 else 0) + noise.randint(0, 3 * MIB)
        kept = started if i > 0 else 0
        levels.append(Level(5000 + requests, Held(200 * MIB + grown, 20 + 9 * kept + int(files * requests),
                                                  300 + 3 * kept + int(threads * requests),
                                                  4 + kept + int(processes * requests))))
    return levels


def leaking(levels):
    return {name for name, found in judge(levels).items() if found.leaks}


class Judge(unittest.TestCase):
    def test_finds_a_kilobyte_per_request(self):
        for requests_a_round in (5000, 20_000, 100_000):
            for seed in range(20):
                self.assertEqual(leaking(series(requests_a_round, memory=1024, seed=seed)), {"memory"})

    def test_finds_a_leak_in_few_rounds(self):
        for seed in range(20):
            self.assertEqual(leaking(series(15_000, rounds=2, memory=1024, seed=seed)), {"memory"})

    def test_ignores_noise_and_a_single_step(self):
        for seed in range(50):
            self.assertEqual(leaking(series(5000, seed=seed)), set())
            self.assertEqual(leaking(series(5000, step=5 * MIB, seed=seed)), set())
            self.assertEqual(leaking(series(5000, step=-40 * MIB, seed=seed)), set())

    def test_reports_the_smallest_detectable_leak(self):
        self.assertEqual(judge(series(100_000))["memory"].least, 512)
        few = judge(series(100))["memory"]
        self.assertGreater(few.least, 10_000)
        self.assertEqual(leaking(series(100, memory=few.least / 2)), set())

    def test_finds_descriptors_threads_and_processes(self):
        self.assertEqual(leaking(series(5000, files=0.002)), {"files"})
        self.assertEqual(leaking(series(5000, threads=0.002)), {"threads"})
        self.assertEqual(leaking(series(5000, processes=0.0002)), {"processes"})

    def test_ignores_what_a_further_process_holds(self):
        self.assertEqual(leaking(series(5000, started=2)), set())
        self.assertEqual(leaking(series(5000, started=1, files=0.002)), {"files"})

    def test_a_slope_ignores_outliers(self):
        self.assertEqual(slope([(0, 0), (1, 2), (2, 400), (3, 6), (4, 8), (5, 10)]), 2)


class Proc(unittest.TestCase):
    def test_counts_children(self):
        with subprocess.Popen(["sh", "-c", "exec 3<&0; cat <&3 & echo started; wait"], stdin=subprocess.PIPE,
                              stdout=subprocess.PIPE) as process:
            process.stdout.readline()
            found = held(process.pid)
            process.stdin.close()
        self.assertEqual((found.processes, found.threads), (2, 2))
        self.assertGreaterEqual(found.files, 4)
        self.assertGreater(found.memory, 0)

    def test_ended_processes_hold_nothing(self):
        with subprocess.Popen(["true"]) as process:
            process.wait()
        self.assertEqual(held(process.pid), NOTHING)


if __name__ == "__main__":
    unittest.main(verbosity=2)
