# SPDX-License-Identifier: GPL-3.0-or-later
"""Large answers, which are sent in pieces while they are written."""

import gzip
import json
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import unittest

from harness import Call, Server, ServerCase, ask, post_json
from raw import SANITIZED
from test_computing import children, figure, fork_server, wait_until

TORUS = {"type": "torus", "width": 1, "height": 1}
JSON = ("--header", "Content-Type: application/json")
MANY = 400_000
LARGER = 1_000_000  # more of an answer than server, sockets and curl hold


def points(form, sites=MANY, **members):
    """Returns a request for points by a method that takes no time."""
    return json.dumps({"sites": sites, "domain": TORUS, "method": "random", "format": form, **members})


def figure_of(process, name):
    """Returns a figure of a process in bytes; 0 if the process has ended."""
    try:
        found = re.search(rf"{name}:\s+(\d+) kB", pathlib.Path(f"/proc/{process}/status").read_text())
    except (FileNotFoundError, ProcessLookupError):
        return 0
    return int(found.group(1)) << 10 if found else 0


def peak(process):
    """Returns the peak resident memory of a process in bytes."""
    return figure_of(process, "VmHWM")


def of_computing(server, name):
    """Returns the largest figure of all computation processes in bytes; 0 if there is none."""
    return max((figure_of(process, name) for process in children(fork_server(server))), default=0)


def resident_at_rest(server):
    """Returns the resident memory of a process that has computed an answer, and waits for the next request.

    On a busy machine, the server lowers the priority of a computation that lasts, and does not keep its process.
    """
    def compute_few():
        post_json(server, "/sample", points("csv", 100))
        return of_computing(server, "VmRSS")

    return wait_until(compute_few)


def peak_during(call, server):
    """Waits for the end of a call, and returns the peak resident memory of all computation processes meanwhile."""
    highest = 0
    while True:
        highest = max(highest, of_computing(server, "VmHWM"))
        try:
            call.process.wait(0.02)
            return highest
        except subprocess.TimeoutExpired:
            continue


class Streams(ServerCase):
    flags = ("--workers=2", "--timeout=120", "--job-bytes=256MiB", "--memory=4GiB")

    def whole(self, body):
        """Returns the same answer as the result of a job, whose length is known."""
        job = post_json(self.server, "/sample", body, "--header", "Prefer: respond-async").headers["location"]
        wait_until(lambda: self.ask(job).json()["status"] == "succeeded")
        return self.ask(job + "/result")

    def test_equal_whole_answers(self):
        for form in ("npy", "csv", "geojson"):
            body = points(form, 300_000)
            streamed, whole = post_json(self.server, "/sample", body), self.whole(body)
            self.assertEqual(streamed.status, 200)
            self.assertEqual(streamed.headers["transfer-encoding"], "chunked", form)
            self.assertNotIn("content-length", streamed.headers)
            self.assertEqual(whole.headers["content-length"], str(len(whole.body)))
            self.assertEqual(streamed.body, whole.body)

    def test_are_compressed_in_pieces(self):
        body = points("csv", 300_000)
        answer = post_json(self.server, "/sample", body, "--header", "Accept-Encoding: gzip")
        self.assertEqual(answer.headers["content-encoding"], "gzip")
        self.assertEqual(answer.headers["transfer-encoding"], "chunked")
        self.assertTrue(answer.headers["etag"].endswith('-gzip"'))
        plain = post_json(self.server, "/sample", body)
        self.assertEqual(gzip.decompress(answer.body), plain.body)
        for each in (answer, plain):
            self.assertIn("Accept-Encoding", each.headers["vary"])

    def test_have_entity_tags(self):
        body = points("npy", 300_000)
        tag = post_json(self.server, "/sample", body).headers["etag"]
        self.assertEqual(post_json(self.server, "/sample", body, "--header", f"If-None-Match: {tag}").status, 304)

    def test_end_with_the_connection_for_http_1_0_clients(self):
        body = points("csv", 300_000)
        old = post_json(self.server, "/sample", body, "--http1.0")
        self.assertNotIn("transfer-encoding", old.headers)
        self.assertEqual(old.body, post_json(self.server, "/sample", body).body)

    def test_are_cached_if_they_fit(self):
        with Server("--cache=64MiB") as server:
            body = points("csv", 300_000)
            first, second = (post_json(server, "/sample", body) for _ in range(2))
            self.assertEqual(first.headers["transfer-encoding"], "chunked")
            self.assertEqual(second.headers["content-length"], str(len(first.body)))
            self.assertEqual((second.headers["etag"], second.body), (first.headers["etag"], first.body))

    def test_stop_the_computation_when_the_client_leaves(self):
        with Server("--workers=1", "--timeout=120") as server:
            call = Call(server.url("/sample"), *JSON, "--limit-rate", "1M", data=points("geojson", LARGER))
            wait_until(lambda: call.body.is_file() and call.body.stat().st_size > 0)
            call.abandon()
            wait_until(lambda: figure(server, "ccdt_workers_busy") == 0)
            server.wait_for_log(" 499 ")
            self.assertEqual(post_json(server, "/sample", points("csv", 100)).status, 200)

    def test_are_visibly_incomplete_after_a_failure(self):
        with Server("--workers=1", "--timeout=120") as server:
            call = Call(server.url("/sample"), *JSON, "--limit-rate", "8M", data=points("geojson", LARGER))
            wait_until(lambda: call.body.is_file() and call.body.stat().st_size > 0)
            for process in children(fork_server(server)):
                os.kill(process, signal.SIGKILL)
            with call.folder:
                call.process.communicate()
                self.assertEqual(call.process.returncode, 18)  # only a part
                self.assertIn(b" 200 ", call.head.read_bytes())
            server.wait_for_log("the process that computed it was killed")
            self.assertEqual(post_json(server, "/sample", points("csv", 100)).status, 200)


PREFER = ("--header", "Prefer: respond-async")


def finished(server, body):
    """Returns the path of a job that has succeeded."""
    job = post_json(server, "/sample", body, *PREFER).headers["location"]
    wait_until(lambda: ask(server, job).json()["status"] not in ("queued", "running"))
    assert ask(server, job).json()["status"] == "succeeded", ask(server, job)
    return job


class Results(unittest.TestCase):
    """Large results of jobs, which are stored and sent in pieces."""

    def test_outlive_the_server(self):
        with tempfile.TemporaryDirectory() as folder:
            with Server(f"--data-dir={folder}", "--timeout=120") as server:
                job = finished(server, points("csv"))
                expected = post_json(server, "/sample", points("csv")).body
                self.assertEqual(ask(server, job + "/result").body, expected)
                self.assertEqual(server.stop(), 0)
            with Server(f"--data-dir={folder}") as server:
                answer = ask(server, job + "/result", "--http1.0")
                self.assertEqual((answer.status, answer.body), (200, expected))
                head = ask(server, job + "/result", "--head")
                self.assertEqual(head.headers["content-length"], str(len(expected)))
                self.assertEqual(server.stop(), 0)

    def test_are_visibly_incomplete_once_deleted(self):
        with Server("--timeout=120", "--job-bytes=256MiB") as server:
            job = finished(server, points("geojson", LARGER))
            call = Call(server.url(job + "/result"), "--limit-rate", "8M")
            wait_until(lambda: call.body.is_file() and call.body.stat().st_size > 0)
            self.assertEqual(ask(server, job, "--request", "DELETE").status, 204)
            with call.folder:
                call.process.communicate()
                self.assertIn(call.process.returncode, (18, 56))  # only a part, or a connection that was reset
                self.assertIn(b" 200 ", call.head.read_bytes())

    def test_that_are_too_large_are_refused_as_early_as_possible(self):
        with Server("--timeout=120", "--job-bytes=6MiB") as server:
            known = post_json(server, "/sample", points("npy"), *PREFER)
            self.assertEqual(known.status, 413)
            self.assertIn("(job-bytes)", known.json()["detail"])
            job = post_json(server, "/sample", points("csv"), *PREFER).headers["location"]
            wait_until(lambda: ask(server, job).json()["status"] == "failed")
            answer = ask(server, job + "/result")
            self.assertEqual(answer.status, 507)
            self.assertIn("(job-bytes)", answer.json()["detail"])
            self.assertEqual(ask(server, finished(server, points("csv", 100)) + "/result").status, 200)


@unittest.skipIf(SANITIZED, "sanitizers take memory of their own")
class Memory(unittest.TestCase):
    def test_of_the_server_excludes_results_of_jobs(self):
        with tempfile.TemporaryDirectory() as folder:
            with Server("--workers=1", "--timeout=120", f"--data-dir={folder}") as server:
                finished(server, points("npy"))
                before = peak(server.process.pid)
                result = ask(server, finished(server, points("geojson")) + "/result")
                self.assertGreater(len(result.body), 16 * MANY)
                self.assertLess(peak(server.process.pid) - before, 16 * MANY)
                self.assertEqual(server.stop(), 0)

    def test_of_a_computation_is_bounded_by_its_points(self):
        many = 262_144
        with Server("--workers=1", "--timeout=120") as server:
            before = resident_at_rest(server)
            call = Call(server.url("/sample"), *JSON, data=points("csv", many, method="ccdt"))
            highest = peak_during(call, server)
            self.assertEqual(call.answer().status, 200)
            self.assertGreater(highest - before, 16 * many)
            self.assertLess(highest - before, 340 * many)
            self.assertEqual(server.stop(), 0)

    def test_of_writing_is_bounded_by_the_points(self):
        for form in ("csv", "geojson"):
            with Server("--workers=1", "--timeout=120") as server:
                before = resident_at_rest(server)
                call = Call(server.url("/sample"), *JSON, "--limit-rate", "1M", data=points(form, LARGER))
                wait_until(lambda call=call: call.body.is_file() and call.body.stat().st_size > 0)
                taken = of_computing(server, "VmRSS") - before
                call.abandon()
                self.assertGreater(taken, 16 * LARGER)
                self.assertLess(taken, 16 * LARGER + (14 << 20))  # neither the points twice nor their text

    def test_of_the_server_excludes_the_answer(self):
        with Server("--workers=1", "--timeout=120") as server:
            post_json(server, "/sample", points("npy"))
            before = peak(server.process.pid)
            answer = post_json(server, "/sample", points("geojson"))
            self.assertGreater(len(answer.body), 16 * MANY)
            self.assertLess(peak(server.process.pid) - before, len(answer.body) / 4)
            self.assertEqual(server.stop(), 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
