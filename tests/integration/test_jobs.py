# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs: requests that run while their clients do not wait."""

import io
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import tempfile
import unittest

import numpy
from PIL import Image

from harness import PATIENCE, PICTURES, Call, Server, ServerCase, ask, file_of, flat, wait_until

TORUS = {"type": "torus", "width": 1, "height": 1}
JSON = ("--header", "Content-Type: application/json")
LATER = ("--header", "Prefer: respond-async")
SMALL = {"sites": 200, "domain": TORUS}
# Takes a few seconds, longer than a request to the server.
LONG = {"sites": 20_000, "iterations": 50, "domain": TORUS}
# Takes longer than any test; ends when it is cancelled.
ENDLESS = {"sites": 100_000, "iterations": 1000, "passes": 100, "domain": TORUS}


def submit(server, body, *arguments, path="/sample"):
    """Returns the path of the submitted job."""
    data = body if isinstance(body, bytes) else json.dumps(body)
    answer = ask(server, path, *LATER, *arguments, data=data)
    assert answer.status == 202, answer
    return answer.headers["location"]


def status(server, job, *arguments):
    answer = ask(server, job, *arguments)
    assert answer.status == 200, answer
    return answer.json()


def wait_for(server, job, *wanted):
    wait_until(lambda: status(server, job)["status"] in wanted, f"{job} to be {' or '.join(wanted)}")
    return status(server, job)


def wait_for_end(server, job):
    return wait_for(server, job, "succeeded", "failed", "cancelled")


def events(body):
    """Returns names and documents of the events in a stream; other lines are comments."""
    found = []
    for block in body.decode().split("\n\n"):
        lines = dict(line.split(": ", 1) for line in block.splitlines() if not line.startswith(":"))
        if lines:
            found.append((lines["event"], json.loads(lines["data"])))
    return found


def wait_for_event(stream):
    """Waits until a curl that follows a job has received an event."""
    wait_until(lambda: stream.body.is_file() and b"event: " in stream.body.read_bytes(), "an event of the job")


def begin_stream(server, job):
    """Returns a connection on which a first event has arrived, and the received data."""
    client = socket.create_connection(("127.0.0.1", server.port), timeout=PATIENCE)
    client.sendall(f"GET {job}/events HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
    received = b""

    def has_begun():
        nonlocal received
        chunk = client.recv(65536)
        assert chunk, f"the stream ended before an event: {received}"
        received += chunk
        return b"event: progress" in received

    wait_until(has_begun, "the first event of the job")
    return client, received


def rest_of(client, received):
    with client:
        while chunk := client.recv(65536):
            received += chunk
    return received


def without_time(answer):
    return {name: value for name, value in answer.json().items() if name != "elapsed_ms"}


class Jobs(ServerCase):
    flags = ("--workers=2",)

    def submit_endless(self):
        """Submits a job that is cancelled after the test, because jobs of other tests would wait behind it."""
        job = submit(self.server, ENDLESS)
        self.addCleanup(ask, self.server, job, "--request", "DELETE")
        return job

    def test_are_accepted_and_report_their_state(self):
        answer = ask(self.server, "/sample", *LATER, data=json.dumps(SMALL))
        self.assertEqual((answer.status, answer.type), (202, "application/json"))
        self.assertEqual(answer.headers["preference-applied"], "respond-async")
        self.assertRegex(answer.headers["location"], r"^/jobs/[0-9a-f]{32}$")
        accepted = answer.json()
        self.assertEqual("/jobs/" + accepted["id"], answer.headers["location"])
        self.assertEqual((accepted["status"], accepted["started"], accepted["finished"]), ("queued", None, None))
        found = wait_for_end(self.server, answer.headers["location"])
        self.assertEqual(list(found), ["id", "status", "progress", "iteration", "variation", "created", "started",
                                       "finished", "error"])
        self.assertEqual((found["status"], found["progress"], found["iteration"], found["error"]),
                         ("succeeded", 1, 5, None))
        self.assertLessEqual(found["created"], found["started"])
        self.assertLessEqual(found["started"], found["finished"])
        self.assertGreater(found["variation"], 0)

    def test_return_the_synchronous_answer(self):
        picture = (PICTURES / "chelsea.png").read_bytes()
        points = json.dumps({"points": [[0, 0], [0.5, 0.5], [0.2, 0.7]]})
        for path, data, arguments in (
                ("/halftone?sites=500", picture, ()),
                ("/halftone?sites=500&format=json", picture, ()),
                ("/halftone?sites=500", picture, ("--header", "Accept: application/json")),
                ("/sample", json.dumps({**SMALL, "mesh": True}), JSON),
                ("/sample", json.dumps({**SMALL, "polygon": [[i, i * i] for i in range(2000)], "domain": None}), JSON),
                ("/analyze", points, JSON),
                ("/analyze", points, ("--header", "Accept: image/png")),
                ("/analyze", points, ("--header", "Accept: image/svg+xml"))):
            with self.subTest(path=path, arguments=arguments):
                now = ask(self.server, path, *arguments, data=data)
                if now.status == 400:  # refused at once, also as a job
                    later = ask(self.server, path, *LATER, *arguments, data=data)
                    self.assertEqual((later.status, later.json()["detail"]), (400, now.json()["detail"]))
                    continue
                self.assertEqual(now.status, 200, now)
                job = submit(self.server, data if isinstance(data, bytes) else data.encode(), *arguments, path=path)
                self.assertEqual(wait_for_end(self.server, job)["status"], "succeeded")
                later = ask(self.server, job + "/result")
                self.assertEqual((later.status, later.type), (200, now.type))
                if now.type == "application/json":
                    self.assertEqual(without_time(later), without_time(now))
                else:
                    self.assertEqual(later.body, now.body)

    def test_accept_forms(self):
        with tempfile.NamedTemporaryFile(suffix=".png") as file:
            file.write(file_of(flat(100)))
            file.flush()
            form = ("--form", f"image=@{file.name}", "--form", "sites=50")
            now = ask(self.server, "/halftone", *form)
            accepted = ask(self.server, "/halftone", *LATER, *form)
        self.assertEqual(accepted.status, 202, accepted)
        wait_for_end(self.server, accepted.headers["location"])
        self.assertEqual(ask(self.server, accepted.headers["location"] + "/result").body, now.body)

    def test_invalid_requests_are_refused_at_once(self):
        for path, data, code in (("/sample", '{"sites":0}', 400), ("/sample", "nonsense", 400),
                                 ("/halftone", b"nonsense", 415), ("/sample", '{"sites":99999999}', 413)):
            self.assert_problem(ask(self.server, path, *LATER, data=data), code)

    def test_failures_equal_the_synchronous_errors(self):
        crossing = json.dumps({"sites": 9, "polygon": [[0, 0], [1, 1], [1, 0], [0, 1]], "invalid": "reject"})
        now = self.assert_problem(ask(self.server, "/sample", data=crossing), 422)
        job = submit(self.server, crossing.encode())
        found = wait_for_end(self.server, job)
        self.assertEqual(found["status"], "failed")
        later = self.assert_problem(ask(self.server, job + "/result"), 422)
        for problem in (found["error"], later):
            self.assertEqual((problem["status"], problem["detail"], problem["errors"]),
                             (422, now["detail"], now["errors"]))

    def test_results_report_repairs(self):
        crossing = json.dumps({"sites": 9, "polygon": [[0, 0], [1, 1], [1, 0], [0, 1]], "format": "csv"}).encode()
        job = submit(self.server, crossing)
        self.assertEqual(wait_for_end(self.server, job)["status"], "succeeded")
        now, later = ask(self.server, "/sample", data=crossing), ask(self.server, job + "/result")
        self.assertEqual((now.body, now.headers["x-repaired"]), (later.body, later.headers["x-repaired"]))

    def test_results_report_the_size_of_dots(self):
        picture = (PICTURES / "camera.png").read_bytes()
        for query in ("sites=900", "sites=900&dot=2&dots=ink", "sites=900&tone=density"):
            path = "/halftone?" + query
            now = ask(self.server, path, data=picture)
            job = ask(self.server, path, *LATER, data=picture).headers["location"]
            self.assertEqual(wait_for_end(self.server, job)["status"], "succeeded")
            later = ask(self.server, job + "/result")
            self.assertEqual(later.body, now.body)
            for header in ("x-radius", "x-tone"):
                self.assertEqual(later.headers.get(header), now.headers.get(header), query)
            self.assertEqual("x-radius" in later.headers, "density" not in query)

    def test_results_report_the_time_of_a_plot(self):
        picture = (PICTURES / "camera.png").read_bytes()
        for query in ("format=hpgl", "format=svg&style=path"):
            path = f"/halftone?sites=500&dots=ink&width_mm=90&{query}"
            job = ask(self.server, path, *LATER, data=picture).headers["location"]
            wait_for(self.server, job, "succeeded")
            now, later = ask(self.server, path, data=picture), ask(self.server, job + "/result")
            self.assertGreater(float(later.headers["x-plot-seconds"]), 0, query)
            self.assertEqual(later.headers["x-plot-seconds"], now.headers["x-plot-seconds"], query)

    def test_documents_keep_their_options_and_warnings(self):
        document = {"type": "Polygon", "coordinates": [[[0, 0], [9, 0], [9, 60], [0, 60]]]}
        path, body = "/sample?sites=9&format=csv", json.dumps(document).encode()
        job = submit(self.server, body, path=path)
        self.assertEqual(wait_for_end(self.server, job)["status"], "succeeded")
        now, later = ask(self.server, path, data=body), ask(self.server, job + "/result")
        self.assertEqual((now.body, now.headers["x-warnings"]), (later.body, later.headers["x-warnings"]))

    def test_events_report_each_step_and_the_end(self):
        before = [self.submit_endless(), self.submit_endless()]
        job = submit(self.server, {**SMALL, "iterations": 9})
        stream = Call(self.server.url(job + "/events"), "--no-buffer")
        wait_for_event(stream)
        for other in before:
            self.assertEqual(ask(self.server, other, "--request", "DELETE").status, 204)
        answer = stream.answer()
        self.assertEqual((answer.status, answer.type), (200, "text/event-stream"))
        self.assertEqual((answer.headers["cache-control"], answer.headers["x-accel-buffering"]), ("no-store", "no"))
        received = events(answer.body)
        self.assertEqual([name for name, _ in received[:-1]], ["progress"] * (len(received) - 1))
        self.assertEqual(received[-1][0], "succeeded")
        self.assertEqual(received[-1][1], status(self.server, job))
        iterations = [document["iteration"] for _, document in received]
        self.assertEqual(iterations, sorted(iterations))
        self.assertEqual(set(iterations), set(range(10)))
        fractions = [document["progress"] for _, document in received]
        self.assertEqual(fractions, sorted(fractions))
        self.assertEqual(fractions[-1], 1)
        self.assertLess(0.9, fractions[-2])
        self.assertLess(fractions[-2], 1)

        late = ask(self.server, job + "/events", "--header", "Last-Event-ID: 7")
        self.assertEqual(events(late.body), received[-1:])
        old = ask(self.server, job + "/events", "--http1.0")
        self.assertEqual(events(old.body), received[-1:])
        self.assertNotIn("transfer-encoding", old.headers)
        head = ask(self.server, job + "/events", "--head")
        self.assertEqual((head.status, head.type), (200, "text/event-stream"))

    def test_progress_moves_while_a_picture_is_decoded(self):
        before = [self.submit_endless(), self.submit_endless()]
        noise = numpy.random.default_rng(54).integers(0, 256, (1500, 2000), dtype=numpy.uint8)
        file = io.BytesIO()
        Image.fromarray(noise).save(file, "JPEG")
        job = submit(self.server, file.getvalue(), path="/halftone?sites=2000")
        stream = Call(self.server.url(job + "/events"), "--no-buffer")
        wait_for_event(stream)
        for other in before:
            self.assertEqual(ask(self.server, other, "--request", "DELETE").status, 204)
        received = events(stream.answer().body)
        self.assertEqual(received[-1][0], "succeeded")
        early = [document["progress"] for _, document in received if document["iteration"] == 0]
        self.assertGreater(len([done for done in early if done > 0]), 10, early)
        fractions = [document["progress"] for _, document in received]
        self.assertEqual(fractions, sorted(fractions))

    def test_streams_end_when_their_client_leaves(self):
        job = self.submit_endless()
        client, _ = begin_stream(self.server, job)
        client.close()
        self.server.wait_for_log(f"GET {job}/events 499")

    def test_are_cancelled_while_they_run_or_wait(self):
        running = self.submit_endless()
        wait_for(self.server, running, "running")
        waiting = self.submit_endless()
        self.assertEqual(status(self.server, waiting)["status"], "queued")
        stream = Call(self.server.url(running + "/events"))
        for job in (waiting, running):
            early = ask(self.server, job + "/result")
            self.assert_problem(early, 409)
            deleted = ask(self.server, job, "--request", "DELETE")
            self.assertEqual((deleted.status, deleted.body), (204, b""))
            found = status(self.server, job)
            self.assertEqual(found["status"], "cancelled")
            self.assertIsNotNone(found["finished"])
            self.assert_problem(ask(self.server, job + "/result"), 410)
        self.assertEqual(events(stream.answer().body)[-1][0], "cancelled")
        self.assertEqual(wait_for_end(self.server, submit(self.server, SMALL))["status"], "succeeded")

    def test_are_deleted_on_request(self):
        job = submit(self.server, SMALL)
        wait_for_end(self.server, job)
        self.assertEqual(ask(self.server, job, "--request", "DELETE").status, 204)
        for path, arguments in ((job, ()), (job + "/result", ()), (job + "/events", ()),
                                (job, ("--request", "DELETE"))):
            self.assert_problem(ask(self.server, path, *arguments), 404)

    def test_methods_and_paths(self):
        job = submit(self.server, SMALL)
        wait_for_end(self.server, job)
        for path, allow in ((job, "GET, HEAD, DELETE, OPTIONS"), (job + "/result", "GET, HEAD, OPTIONS"),
                            (job + "/events", "GET, HEAD, OPTIONS")):
            refused = ask(self.server, path, "--request", "POST")
            self.assert_problem(refused, 405)
            self.assertEqual(refused.headers["allow"], allow)
            options = ask(self.server, path, "--request", "OPTIONS")
            self.assertEqual((options.status, options.headers["allow"]), (204, allow))
        result = ask(self.server, job + "/result")
        head = ask(self.server, job + "/result", "--head")
        self.assertEqual((head.status, head.headers["content-length"]), (200, str(len(result.body))))
        self.assertEqual(ask(self.server, job, "--head").status, 200)
        for path in ("/jobs", "/jobs/", "/jobs//result", job + "/", job + "/nothing", job[:-1], job.upper(),
                     "/jobs/" + "x" * 5000):
            self.assertEqual(ask(self.server, path).status, 404, path)

    def test_results_are_compressed_on_request(self):
        job = submit(self.server, SMALL)
        wait_for_end(self.server, job)
        plain = ask(self.server, job + "/result")
        squeezed = ask(self.server, job + "/result", "--compressed")
        self.assertEqual(squeezed.headers["content-encoding"], "gzip")
        self.assertEqual(squeezed.body, plain.body)

    def test_results_have_entity_tags(self):
        jobs = [submit(self.server, SMALL) for _ in range(2)]
        for job in jobs:
            wait_for_end(self.server, job)
        tags = [ask(self.server, job + "/result").headers["etag"] for job in jobs]
        packed = ask(self.server, jobs[0] + "/result", "--compressed").headers["etag"]
        self.assertEqual(packed, tags[0][:-1] + '-gzip"')
        for tag in (tags[0], packed):
            again = ask(self.server, jobs[0] + "/result", "--header", "If-None-Match: " + tag)
            self.assertEqual((again.status, again.body, again.headers["etag"]), (304, b"", tag))
        other = ask(self.server, jobs[0] + "/result", "--header", "If-None-Match: " + tags[1])
        self.assertEqual(other.status, 200, "results of different jobs have different tags")


class Limits(unittest.TestCase):
    def test_too_many_waiting_jobs_are_refused(self):
        with Server("--workers=1", "--job-queue=1") as server:
            running = submit(server, ENDLESS)
            wait_for(server, running, "running")
            submit(server, ENDLESS)
            refused = ask(server, "/sample", *LATER, data=json.dumps(ENDLESS))
            self.assertEqual((refused.status, refused.type), (429, "application/problem+json"))
            self.assertIn("job-queue", refused.json()["detail"])
            self.assertGreaterEqual(int(refused.headers["retry-after"]), 1)

    def test_one_worker_is_left_for_waiting_clients(self):
        with Server("--workers=2") as server:
            for _ in range(3):
                submit(server, ENDLESS)
            self.assertEqual(ask(server, "/sample", data=json.dumps({**LONG, "iterations": 1})).status, 200)

    def test_jobs_have_their_own_timeout(self):
        with Server("--timeout=0.001", "--job-timeout=1") as server:
            self.assertEqual(wait_for_end(server, submit(server, SMALL))["status"], "succeeded")
            late = submit(server, ENDLESS)
            self.assertEqual(wait_for_end(server, late)["error"]["status"], 504)
            self.assertEqual(ask(server, late + "/result").status, 504)
            partial = submit(server, {"sites": 5000, "iterations": 1000, "passes": 100, "domain": TORUS,
                                      "on_deadline": "partial"})
            self.assertEqual(wait_for_end(server, partial)["status"], "succeeded")
            answer = ask(server, partial + "/result")
            self.assertEqual((answer.headers["x-partial"], answer.json()["partial"]), ("deadline", True))

    def test_jobs_expire(self):
        with Server("--job-ttl=0.5") as server:
            job = submit(server, SMALL)
            answer = wait_until(lambda: (now := ask(server, job)).status != 200 and now)
            self.assertEqual(answer.status, 404)
            self.assertIn("expired", answer.json()["detail"])

    def test_the_oldest_results_are_dropped(self):
        with Server("--job-bytes=300KiB") as server:
            jobs = []
            for _ in range(4):
                jobs.append(submit(server, {**SMALL, "sites": 2000}))  # about 80 kB
                wait_for_end(server, jobs[-1])
            first = ask(server, jobs[0] + "/result")
            self.assertEqual(first.status, 410)
            self.assertIn("job-bytes", first.json()["detail"])
            self.assertEqual(status(server, jobs[0])["status"], "succeeded")
            self.assertEqual(ask(server, jobs[-1] + "/result").status, 200)
            large = submit(server, {**SMALL, "sites": 20_000, "iterations": 1})
            self.assertEqual(wait_for_end(server, large)["error"]["status"], 507)


class Keys(unittest.TestCase):
    def test_a_job_belongs_to_its_key(self):
        with tempfile.TemporaryDirectory() as folder:
            keys = pathlib.Path(folder) / "keys"
            keys.write_text("alice:alice-0123456789abcdef\nbob:bob-0123456789abcdefgh\n")
            alice, bob = (("--header", "Authorization: Bearer " + key)
                          for key in ("alice-0123456789abcdef", "bob-0123456789abcdefgh"))
            with Server(f"--api-key-file={keys}") as server:
                job = submit(server, ENDLESS, *alice)
                for path, arguments in ((job, ()), (job + "/result", ()), (job + "/events", ()),
                                        (job, ("--request", "DELETE"))):
                    self.assertEqual(ask(server, path, *arguments).status, 401)
                    self.assertEqual(ask(server, path, *bob, *arguments).status, 404)
                self.assertEqual(ask(server, job, *alice).status, 200)
                self.assertEqual(ask(server, job, *alice, "--request", "DELETE").status, 204)
                server.wait_for_log(" cancelled ")
                server.wait_for_log("key=alice")


class Lasting(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name) / "jobs"
        self.flags = ("--workers=2", f"--data-dir={self.folder}")

    def test_jobs_of_a_killed_server_continue_on_the_next(self):
        with Server(*self.flags) as server:
            done = submit(server, SMALL)
            wait_for_end(server, done)
            result = ask(server, done + "/result").body
            running = submit(server, LONG)
            wait_for(server, running, "running")
            waiting = submit(server, SMALL)
            self.assertEqual(status(server, waiting)["status"], "queued")
            server.signal(signal.SIGKILL)
            server.wait()
        with Server(*self.flags) as server:
            self.assertEqual(ask(server, done + "/result").body, result)
            for job, sites in ((running, 20_000), (waiting, 200)):
                self.assertEqual(wait_for_end(server, job)["status"], "succeeded")
                self.assertEqual(len(ask(server, job + "/result").json()["points"]), sites)
            again = ask(server, waiting + "/result").json()
            self.assertEqual(again["points"], json.loads(result)["points"], "points must be reproducible")

    def test_jobs_of_a_stopped_server_continue_on_the_next(self):
        with Server(*self.flags) as server:
            job = submit(server, {**LONG, "iterations": 100})
            wait_for(server, job, "running")
            stream = begin_stream(server, job)
            server.signal()
            received = rest_of(*stream)
            self.assertEqual(set(re.findall(rb"event: (\w+)", received)), {b"progress"})
            self.assertTrue(received.endswith(b"0\r\n\r\n"), "the stream must end regularly, with the last chunk")
            self.assertEqual(server.wait(), 0)
        with Server(*self.flags) as server:
            self.assertEqual(wait_for_end(server, job)["status"], "succeeded")

    def test_files_are_private_and_exclusive(self):
        with Server(*self.flags) as server:
            submit(server, SMALL)
            self.assertEqual(self.folder.stat().st_mode & 0o777, 0o700)
            self.assertTrue(any(self.folder.iterdir()))
            for file in self.folder.iterdir():
                self.assertEqual(file.stat().st_mode & 0o777, 0o600, file)
            second = self.run_program()
            self.assertEqual(second.returncode, 1)
            self.assertIn("another server uses it", second.stderr)

    def test_foreign_files_are_refused(self):
        self.folder.mkdir()
        (self.folder / "jobs.sqlite").write_bytes(b"x" * 5000)
        result = self.run_program()
        self.assertEqual(result.returncode, 1)
        self.assertIn("jobs.sqlite", result.stderr)
        self.assertEqual((self.folder / "jobs.sqlite").read_bytes(), b"x" * 5000)

    def run_program(self):
        return subprocess.run([os.environ["CCDT_SERVER"], "--port=0", *self.flags], capture_output=True, text=True,
                              timeout=PATIENCE, check=False)


class Passing(unittest.TestCase):
    """Jobs that are stored in memory."""

    def test_event_streams_of_a_stopped_server_end_with_failure(self):
        with Server("--workers=1") as server:
            job = submit(server, ENDLESS)
            stream = begin_stream(server, job)
            server.signal()
            received = rest_of(*stream)
            self.assertIn(b"event: failed\n", received)
            self.assertIn(b'"status":503', received)
            self.assertEqual(server.wait(), 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
