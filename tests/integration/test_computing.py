# SPDX-License-Identifier: GPL-3.0-or-later
"""Computations that crash, hang or are killed: each affects only its own request."""

import contextlib
import http.client
import json
import os
import pathlib
import re
import shutil
import signal
import tempfile
import time
import unittest

from harness import PATIENCE, Call, Server, ServerCase, ask, figures_at_rest, file_of, post_json, wait_until

TORUS = {"type": "torus", "width": 1, "height": 1}
JSON = ("--header", "Content-Type: application/json")
CRASHING = os.environ["CCDT_CRASHING_SERVER"]
CRASH, HANG, SLOW = 1300000001, 1300000002, 1300000003


def sample(sites=100, **members):
    return json.dumps({"sites": sites, "domain": TORUS, "format": "csv", **members})


def parent_and_state(process):
    """Returns the parent and the state of a process; none if the process does not exist."""
    try:
        fields = pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    except (OSError, IndexError):
        return None
    return int(fields[1]), fields[0]


def children(process):
    """Returns ids and states of the children of a process."""
    found = {}
    for folder in pathlib.Path("/proc").iterdir():
        found_state = parent_and_state(folder.name) if folder.name.isdigit() else None
        if found_state and found_state[0] == process:
            found[int(folder.name)] = found_state[1]
    return found


def fork_server(server):
    for child in children(server.process.pid):
        if pathlib.Path(f"/proc/{child}/comm").read_text().strip() == "ccdt-worker":
            return child
    raise AssertionError("there is no worker")


def figure(server, name):
    metrics = ask(server, "/metrics").body.decode()
    return float(re.search(rf"^{name} (\S+)$", metrics, re.MULTILINE).group(1))


def resume(process):
    """Resumes a process, which may have ended."""
    try:
        os.kill(process, signal.SIGCONT)
    except ProcessLookupError:
        pass


class Crashes(ServerCase):
    flags = ("--workers=2", "--timeout=120")
    program = CRASHING

    def test_fail_only_their_own_request(self):
        crashes = figure(self.server, "ccdt_computation_crashes_total")
        honest = sample(20_000)
        expected = post_json(self.server, "/sample", honest).body
        calls = [Call(self.server.url("/sample"), *JSON, data=honest) for _ in range(6)]
        crashed = [Call(self.server.url("/sample"), *JSON, data=sample(seed=CRASH)) for _ in range(3)]
        for call in crashed:
            problem = self.assert_problem(call.answer(), 500)
            self.assertIn("log", problem["detail"])
            self.server.wait_for_log(problem["instance"].removeprefix("urn:request:"))
        for call in calls:
            answer = call.answer()
            self.assertEqual((answer.status, answer.body), (200, expected))
        self.server.wait_for_log("the process that computed it ")
        self.assertEqual(figure(self.server, "ccdt_computation_crashes_total"), crashes + 3)
        self.assertEqual(self.ask("/health/ready").status, 200)


class Hangs(ServerCase):
    flags = ("--workers=1", "--timeout=1")
    program = CRASHING

    def test_end_at_the_deadline(self):
        self.assert_problem(post_json(self.server, "/sample", sample(seed=HANG)), 504)
        wait_until(lambda: figure(self.server, "ccdt_workers_busy") == 0)
        self.assertEqual(figure(self.server, "ccdt_computation_crashes_total"), 0)
        self.assertEqual(figure(self.server, "ccdt_computations_overdue_total"), 1)
        self.assertEqual(post_json(self.server, "/sample", sample()).status, 200)


class HangsOfAbandonedRequests(unittest.TestCase):
    def test_end_soon_and_are_not_counted_as_crashes(self):
        prefer = ("--header", "Prefer: respond-async")
        with Server("--workers=1", "--timeout=120", program=CRASHING) as server:
            job = post_json(server, "/sample", sample(seed=HANG), *prefer).headers["location"]
            wait_until(lambda: ask(server, job).json()["status"] == "running")
            self.assertEqual(ask(server, job, "--request", "DELETE").status, 204)
            wait_until(lambda: figure(server, "ccdt_workers_busy") == 0)
            call = Call(server.url("/sample"), *JSON, data=sample(seed=HANG))
            wait_until(lambda: figure(server, "ccdt_workers_busy") == 1)
            call.abandon()
            wait_until(lambda: figure(server, "ccdt_workers_busy") == 0)
            self.assertEqual(figure(server, "ccdt_computation_crashes_total"), 0)
            self.assertEqual(post_json(server, "/sample", sample()).status, 200)


class CrashesOfJobs(unittest.TestCase):
    def test_fail_only_their_own_job_and_stay_failed(self):
        with tempfile.TemporaryDirectory() as folder:
            flags = ("--workers=1", f"--data-dir={folder}")
            with Server(*flags, program=CRASHING) as server:
                prefer = ("--header", "Prefer: respond-async")
                seeds = [1, CRASH, 2, CRASH, 3]
                jobs = [post_json(server, "/sample", sample(seed=seed), *prefer).headers["location"] for seed in seeds]
                for job, seed in zip(jobs, seeds):
                    wait_until(lambda job=job: ask(server, job).json()["status"] in ("succeeded", "failed"))
                    self.assertEqual(ask(server, job).json()["status"], "failed" if seed == CRASH else "succeeded")
                self.assertEqual(server.stop(), 0)
            with Server(*flags, program=CRASHING) as server:
                for job, seed in zip(jobs, seeds):
                    answer = ask(server, job + "/result")
                    self.assertEqual(answer.status, 500 if seed == CRASH else 200, answer)
                    if seed != CRASH:
                        self.assertEqual(answer.body, post_json(server, "/sample", sample(seed=seed)).body)
                self.assertEqual(server.stop(), 0)


class Overruns(unittest.TestCase):
    """Requests that are taken for short ones and take long: two in the workers, two beside them, and others that are
    displaced and wait for a worker."""

    liars = 8
    limit = 0.1  # of the 99th percentile of the time of short requests, in seconds

    def start(self, server, seed):
        """Starts the long requests, and returns them once two of them run beside the workers."""
        calls = [Call(server.url("/sample"), *JSON, data=sample(seed=seed)) for _ in range(self.liars)]
        wait_until(lambda: figure(server, "ccdt_workers_busy") >= 4)
        return calls

    @staticmethod
    def percentile_of_short_requests(server):
        """Returns the 99th percentile of the time of a hundred short requests of one client, in seconds."""
        connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE)
        times = []
        with contextlib.closing(connection):
            for _ in range(100):
                start = time.monotonic()
                connection.request("POST", "/sample", sample(50), {"Content-Type": "application/json"})
                answer = connection.getresponse()
                assert answer.status == 200, answer.read()
                answer.read()
                times.append(time.monotonic() - start)
        return sorted(times)[98]

    def test_do_not_delay_short_requests(self):
        with Server("--workers=2", program=CRASHING) as server:
            for call in self.start(server, HANG):
                self.addCleanup(call.abandon)
            # Other programs may delay some of the rounds.
            wait_until(lambda: self.percentile_of_short_requests(server) < self.limit)
            self.assertLessEqual(figure(server, "ccdt_workers_busy"), 5)

    def test_are_answered(self):
        with Server("--workers=2", program=CRASHING) as server:
            expected = post_json(server, "/sample", sample(seed=SLOW)).body
            for answer in [call.answer() for call in self.start(server, SLOW)]:
                self.assertEqual((answer.status, answer.body), (200, expected))
            self.assertEqual(figure(server, "ccdt_computation_crashes_total"), 0)


class Threads(unittest.TestCase):
    """Large requests get as many threads as idle workers leave."""

    flags = ("--workers=4", "--threads-per-request=4", "--timeout=120")
    picture = file_of([[(x * y) % 256 for x in range(1500)] for y in range(1100)])

    def threads_of(self, server):
        """Returns the number of threads of a large request, and its processor time."""
        answer = ask(server, "/halftone?sites=5000&quality=draft", data=self.picture)
        self.assertEqual(answer.status, 200, answer)
        threads = re.search(r'cpu;dur=([\d.]+), threads;desc="(\d+)"$', answer.headers["server-timing"])
        self.assertGreater(float(threads[1]), 0)
        return int(threads[2])

    def test_are_lent_and_returned(self):
        with Server(*self.flags) as server:
            self.assertEqual(self.threads_of(server), 4)
            for busy, left in ((1, 2), (2, 1)):
                wait_until(lambda busy=busy: figure(server, "ccdt_workers_busy") == busy - 1)
                call = Call(server.url("/sample"), *JSON, data=sample(100_000, iterations=1000))
                self.addCleanup(call.abandon)
                wait_until(lambda busy=busy: figure(server, "ccdt_workers_busy") == busy)
                self.assertEqual(figure(server, "ccdt_computation_threads_lent"), 4 // busy)
                self.assertEqual(self.threads_of(server), left)
            self.doCleanups()
            wait_until(lambda: figure(server, "ccdt_workers_busy") == 0)
            self.assertEqual(self.threads_of(server), 4)
            self.assertIn(f"\nccdt_computation_threads_sum {4 + 2 + 1 + 4}\n", figures_at_rest(server))
            self.assertGreater(figure(server, "ccdt_computation_cpu_seconds_total"), 0)
            self.assertEqual(server.stop(), 0)

    def test_are_not_lent_if_so_configured(self):
        with Server("--workers=4", "--threads-per-request=1") as server:
            self.assertEqual(self.threads_of(server), 1)

    def test_are_limited_by_the_number_of_workers(self):
        with Server("--workers=1", "--threads-per-request=4") as server:
            self.assertEqual(self.threads_of(server), 1)

    def test_end_with_their_computation(self):
        with Server(*self.flags) as server:
            self.threads_of(server)
            for process in children(fork_server(server)):
                wait_until(lambda process=process: len(os.listdir(f"/proc/{process}/task")) == 2)


class Kills(unittest.TestCase):
    def test_of_computing_processes_lose_no_request(self):
        with Server("--workers=2", "--timeout=120") as server:
            bodies = [sample(30_000, seed=seed) for seed in range(6)]
            expected = [post_json(server, "/sample", body).body for body in bodies]
            for _ in range(3):
                calls = [Call(server.url("/sample"), *JSON, data=body) for body in bodies]
                wait_until(lambda: figure(server, "ccdt_workers_busy") == 2)
                for process in children(fork_server(server)):
                    os.kill(process, signal.SIGKILL)
                answers = [call.answer() for call in calls]
                self.assertEqual([answer.status for answer in answers], [200] * 6)
                self.assertEqual([answer.body for answer in answers], expected)
            self.assertGreaterEqual(figure(server, "ccdt_computation_crashes_total"), 3)
            self.assertEqual(server.stop(), 0)

    def test_of_the_fork_server_are_logged_counted_and_repaired(self):
        with Server("--workers=1", "--timeout=120") as server:
            expected = post_json(server, "/sample", sample()).body
            for kill in range(1, 4):
                running = Call(server.url("/sample"), *JSON, data=sample(100_000))
                wait_until(lambda: figure(server, "ccdt_workers_busy") == 1)
                first = fork_server(server)
                os.kill(first, signal.SIGKILL)
                wait_until(lambda kill=kill: figure(server, "ccdt_worker_restarts_total") == kill)
                wait_until(lambda: ask(server, "/health/ready").status == 200)
                self.assertNotEqual(fork_server(server), first)
                self.assertEqual(post_json(server, "/sample", sample()).body, expected)
                self.assertEqual(running.answer().status, 200)
                self.assertNotIn("Z", children(server.process.pid).values())
            self.assertEqual(server.stop(), 0)
            self.assertIn("the worker was killed by signal 9 (Killed), and is started again", server.log())

    def test_of_the_fork_server_and_its_process_lose_no_request_and_no_worker(self):
        with Server("--workers=1") as server:
            running = Call(server.url("/sample"), *JSON, data=sample(100_000, iterations=1000))
            wait_until(lambda: children(fork_server(server)))
            maker = fork_server(server)
            orphans = children(maker)
            os.kill(maker, signal.SIGKILL)
            wait_until(lambda: figure(server, "ccdt_worker_restarts_total") == 1)
            for process in orphans:
                os.kill(process, signal.SIGKILL)
            wait_until(lambda: ask(server, "/health/ready").status == 200)
            wait_until(lambda: children(fork_server(server)))
            running.abandon()
            wait_until(lambda: figure(server, "ccdt_workers_busy") == 0)
            self.assertEqual(server.stop(), 0)

    def test_of_the_server_leave_no_processes(self):
        with Server("--workers=1") as server:
            running = Call(server.url("/sample"), *JSON, data=sample(100_000, iterations=1000))
            wait_until(lambda: figure(server, "ccdt_workers_busy") == 1)
            maker = fork_server(server)
            wait_until(lambda: children(maker))
            family = [maker, *children(maker)]
            server.signal(signal.SIGKILL)
            server.wait()
            running.abandon()
            wait_until(lambda: all((parent_and_state(process) or (0, "Z"))[1] == "Z" for process in family))


class Silence(unittest.TestCase):
    """Programs that run but do not answer."""

    def test_ends_readiness_while_it_lasts(self):
        with Server("--workers=2") as server:
            server.wait_for_log("pictures are decoded by user")
            keeper = next(child for child in children(server.process.pid) if child != fork_server(server))
            self.assertEqual(len(children(keeper)), 1)
            programs = (("worker", fork_server(server)), ("decoder", next(iter(children(keeper)))))
            for name, process in programs:
                os.kill(process, signal.SIGSTOP)
                self.addCleanup(resume, process)
                wait_until(lambda: ask(server, "/health/ready").status == 503)
                self.assertIn(b"does not answer", ask(server, "/health/ready").body)
                self.assertEqual(ask(server, "/health/live").status, 200)
                server.wait_for_log(f"the {name} does not answer")
                self.assertEqual(figure(server, f"ccdt_{name}_silences_total"), 1)
                os.kill(process, signal.SIGCONT)
                wait_until(lambda: ask(server, "/health/ready").status == 200)
                server.wait_for_log(f"the {name} answers again")
            self.assertEqual(server.stop(), 0)

    @contextlib.contextmanager
    def server_whose_program_is_stopped(self, name):
        """Starts a server, and stops one of its programs before the program is ready. Yields the server and the
        process."""
        server_program = pathlib.Path(os.environ["CCDT_SERVER"]).resolve()
        with tempfile.TemporaryDirectory() as folder:
            for program in ("ccdt-decoder", "ccdt-worker"):
                (pathlib.Path(folder) / program).symlink_to(server_program.parent / program)
            stopped = pathlib.Path(folder) / name
            real = stopped.readlink()
            stopped.unlink()
            stopped.write_text(f'#!/bin/sh\nkill -STOP $$\nexec "{real}" "$@"\n')
            stopped.chmod(0o755)
            copy = shutil.copy(server_program, folder)
            with Server("--workers=1", program=copy) as server:
                (process,) = wait_until(
                    lambda: [child for child, state in children(server.process.pid).items() if state == "T"])
                self.addCleanup(resume, process)
                yield server, process

    def test_of_starting_programs_ends_readiness(self):
        for name in ("ccdt-decoder", "ccdt-worker"):
            with self.subTest(name), self.server_whose_program_is_stopped(name) as (server, process):
                wait_until(lambda: ask(server, "/health/ready").status == 503)
                self.assertIn(b"does not answer", ask(server, "/health/ready").body)
                os.kill(process, signal.SIGCONT)
                wait_until(lambda: ask(server, "/health/ready").status == 200)
                self.assertEqual(post_json(server, "/sample", sample()).status, 200)
                self.assertEqual(server.stop(), 0)

    def test_of_starting_programs_does_not_delay_the_end(self):
        for name in ("ccdt-decoder", "ccdt-worker"):
            with self.subTest(name), self.server_whose_program_is_stopped(name) as (server, process):
                self.assertEqual(server.stop(), 0)
                wait_until(lambda: not pathlib.Path(f"/proc/{process}").exists())

    def test_of_programs_that_are_killed_ends_with_another_start(self):
        for name in ("ccdt-decoder", "ccdt-worker"):
            with self.subTest(name), self.server_whose_program_is_stopped(name) as (server, process):
                os.kill(process, signal.SIGKILL)
                server.wait_for_log("it was killed by signal 9 (Killed); it is started again")
                (again,) = wait_until(
                    lambda: [child for child, state in children(server.process.pid).items() if state == "T"])
                os.kill(again, signal.SIGCONT)
                self.assertEqual(post_json(server, "/sample", sample()).status, 200)
                server.wait_for_log("pictures are decoded by user")
                self.assertEqual(server.stop(), 0)

    def test_is_not_reported_for_busy_workers(self):
        with Server("--workers=1") as server:
            endless = {"sites": 100_000, "iterations": 1000, "passes": 100, "domain": TORUS}
            call = Call(server.url("/sample"), data=json.dumps(endless))
            wait_until(lambda: figure(server, "ccdt_workers_busy") == 1)
            worker = next(iter(children(fork_server(server))))
            os.kill(worker, signal.SIGSTOP)
            until = time.monotonic() + 6
            while time.monotonic() < until:
                self.assertEqual(ask(server, "/health/ready").status, 200)
            os.kill(worker, signal.SIGCONT)
            call.abandon()


if __name__ == "__main__":
    unittest.main(verbosity=2)
