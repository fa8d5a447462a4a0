# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs on a faulty disk: with flipped bits, or full."""

import contextlib
import http.client
import json
import os
import pathlib
import random
import re
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import unittest

from harness import PATIENCE, Server, ask, wait_until
from raw import SANITIZED

TORUS = {"type": "torus", "width": 1, "height": 1}
LATER = {"Prefer": "respond-async"}
JOBS = 16  # together more than SQLite keeps in memory
KEPT = 5 << 20  # maximum number of bytes in free pages, for jobs to come
SEEDS = 4 if SANITIZED else 10


def exchange(server, method, path, body=None, headers=None):
    """Sends a request over a new connection. Returns the status, the type and the body of the answer."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE)
    try:
        connection.request(method, path, body, headers or {})
        answer = connection.getresponse()
        return answer.status, answer.getheader("Content-Type"), answer.read()
    finally:
        connection.close()


def try_to_submit(server, **body):
    """Returns the path of the job; none if there is no space for it."""
    status, _, document = exchange(server, "POST", "/sample", json.dumps(body), LATER)
    assert status in (202, 507), document
    return "/jobs/" + json.loads(document)["id"] if status == 202 else None


def submit(server, **body):
    job = try_to_submit(server, **body)
    assert job, "there is no space"
    return job


def wait_for_end(server, job):
    def find():
        document = json.loads(exchange(server, "GET", job)[2])
        return None if document["status"] in ("queued", "running") else document

    document = wait_until(find, f"the end of {job}")
    if not isinstance(document["status"], str):
        raise AssertionError(f"{job} was answered with a problem: {document}")
    return document["status"]


def figure(server, name):
    return float(re.search(rf"^{name} (\S+)$", ask(server, "/metrics").body.decode(), re.MULTILINE)[1])


class Upgrades(unittest.TestCase):
    """Jobs that a server of release 1.0.0 has stored."""

    def test_run_waiting_jobs(self):
        with tempfile.TemporaryDirectory() as folder:
            with contextlib.closing(sqlite3.connect(f"{folder}/jobs.sqlite")) as store:
                store.executescript((pathlib.Path(__file__).parent / "jobs-1.0.0.sql").read_text())
                waiting = store.execute("SELECT '/jobs/' || id, path, body FROM jobs JOIN questions USING (row)")
                waiting = waiting.fetchall()
            self.assertEqual(len(waiting), 2)
            with Server(f"--data-dir={folder}") as server:
                for job, path, body in waiting:
                    self.assertEqual(wait_for_end(server, job), "succeeded")
                    self.assertEqual(exchange(server, "GET", job + "/result"), exchange(server, "POST", path, body))
                self.assertEqual(figure(server, "ccdt_job_store_damages_total"), 0)
                self.assertEqual(server.stop(), 0)


class Bits(unittest.TestCase):
    """Flipped bits, which must not cause wrong answers."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.known = {}
        with Server("--workers=2", f"--data-dir={cls.folder / 'sound'}") as server:
            jobs = [submit(server, sites=5000 + 500 * i, seed=i, domain=TORUS, iterations=0,
                           format=("csv", "json", "npy")[i % 3]) for i in range(JOBS)]
            for job in jobs:
                assert wait_for_end(server, job) == "succeeded"
                cls.known[job] = exchange(server, "GET", job + "/result")
            assert server.stop() == 0
        assert [file.name for file in (cls.folder / "sound").iterdir()] == ["jobs.sqlite"]

    def setUp(self):
        self.place = self.folder / self.id()
        shutil.copytree(self.folder / "sound", self.place)
        self.file = self.place / "jobs.sqlite"

    def start(self):
        """Starts a server; returns none if it refuses the file and gives the reason."""
        try:
            return Server(f"--data-dir={self.place}")
        except AssertionError as error:
            self.assertIn("jobs.sqlite cannot be used: ", str(error))
            return None

    def check(self, server):
        """Returns the number of correct results, and the number of results reported as damaged or missing."""
        right = reported = 0
        for job, answer in self.known.items():
            found = exchange(server, "GET", job + "/result")
            if found == answer:
                right += 1
                continue
            self.assertIn(found[0], (404, 500), found[2][:300])
            if found[0] == 500:
                self.assertRegex(json.loads(found[2])["detail"], "damaged|malformed")
            reported += 1
        return right, reported

    def test_flipped_while_no_server_runs(self):
        right = reported = refused = 0
        for seed in range(SEEDS):
            chance = random.Random(seed)
            shutil.copy(self.folder / "sound" / "jobs.sqlite", self.file)
            data = bytearray(self.file.read_bytes())
            for _ in range(10):
                data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
            self.file.write_bytes(data)
            with self.subTest(seed=seed):
                server = self.start()
                if server is None:
                    refused += 1
                    continue
                with server:
                    found = self.check(server)
                    right, reported = right + found[0], reported + found[1]
                    if found[1]:
                        self.assertGreater(figure(server, "ccdt_job_store_damages_total"), 0)
                    self.assertEqual(exchange(server, "GET", "/health/ready")[0], 200)
                    server.stop()
                    if found[1]:
                        self.assertRegex(server.log(), "is damaged|malformed")
        print(f"  {SEEDS} files: {refused} refused; {right} results right, {reported} reported to be damaged", flush=True)
        self.assertGreater(right, 0)
        self.assertGreater(reported, 0)

    def test_flipped_while_a_server_runs(self):
        right = reported = 0
        for seed in range(SEEDS):
            chance = random.Random(seed)
            shutil.copy(self.folder / "sound" / "jobs.sqlite", self.file)
            with self.subTest(seed=seed), Server(f"--data-dir={self.place}") as server:
                with self.file.open("r+b") as file:
                    size = os.fstat(file.fileno()).st_size
                    for _ in range(40):
                        file.seek(chance.randrange(4096, size - 8))
                        file.write(chance.randbytes(8))
                found = self.check(server)
                right, reported = right + found[0], reported + found[1]
                self.assertEqual(exchange(server, "GET", "/health/live")[0], 200)
                self.assertIsNone(server.process.poll())
        print(f"  {right} results right, {reported} reported to be damaged", flush=True)
        self.assertGreater(right, 0)
        self.assertGreater(reported, 0)


class FullDisk(unittest.TestCase):
    """A small separate disk, which jobs and other files fill to the last byte."""

    SIZE = 64 << 20
    LARGE = {"sites": 200_000, "iterations": 0, "domain": TORUS}  # about 8 MB

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.disk = pathlib.Path(folder.name)
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={self.SIZE}", "tmpfs", self.disk],
                                 capture_output=True, text=True, timeout=PATIENCE, check=False)
        if mounted.returncode != 0:
            self.skipTest("no disk of its own: " + mounted.stderr.strip())
        self.addCleanup(subprocess.run, ["umount", self.disk], check=True)
        self.flags = ("--workers=2", f"--data-dir={self.disk / 'jobs'}")

    def free_space(self):
        found = os.statvfs(self.disk)
        return found.f_bavail * found.f_frsize

    def fill(self):
        """Fills the disk with jobs, then with other files. Returns the jobs that have a result."""
        done = []
        while job := try_to_submit(self.server, **self.LARGE):
            self.assertEqual(wait_for_end(self.server, job), "succeeded")
            done.append(job)
            self.assertLess(len(done), 1000, "jobs on a small disk")
        with (self.disk / "others").open("wb", buffering=0) as file, contextlib.suppress(OSError):
            while file.write(bytes(4096)):
                pass
        self.assertEqual(self.free_space(), 0)
        self.assertGreater(len(done), 1)
        return done

    def test_accepted_jobs_are_stored(self):
        kinds = [{"format": name, "mesh": mesh, "sites": 20_000, "iterations": 0, "domain": TORUS}
                 for name, mesh in (("json", False), ("json", True), ("csv", False), ("ndjson", False), ("npy", False),
                                    ("svg", False), ("png", False))]
        with Server(*self.flags, "--job-bytes=1GiB") as server:
            answers = [try_to_submit(server, **kinds[i % len(kinds)], seed=i) for i in range(300)]
            jobs = [job for job in answers if job]
            self.assertGreater(len(jobs), 10)
            self.assertLess(len(jobs), len(answers))
            self.assertEqual({wait_for_end(server, job) for job in jobs}, {"succeeded"})
            print(f"  {len(jobs)} of {len(answers)} jobs accepted; {self.free_space()} bytes free", flush=True)

    def test_deleted_jobs_free_space(self):
        with Server(*self.flags) as self.server:
            done = self.fill()
            results = [exchange(self.server, "GET", job + "/result")[2] for job in done]
            free = [0]
            for job in done:
                self.assertEqual(exchange(self.server, "DELETE", job)[0], 204)
                free.append(self.free_space())
            self.assertEqual(free, sorted(free))
            self.assertGreater(free[-1], sum(map(len, results)) - KEPT)
            print(f"  {len(done)} results of {len(results[0])} bytes; free after each: {free}", flush=True)
            self.assertEqual(wait_for_end(self.server, submit(self.server, **self.LARGE)), "succeeded")
            self.assertEqual(self.server.stop(), 0)
        self.assertEqual([file.name for file in (self.disk / "jobs").iterdir()], ["jobs.sqlite"])

    def test_a_server_starts_and_removes_expired_jobs(self):
        with Server(*self.flags) as self.server:
            self.fill()
            self.server.signal(signal.SIGKILL)
            self.server.wait()
        with Server(*self.flags, "--job-ttl=0.001") as self.server:
            wait_until(lambda: self.free_space() >= self.SIZE / 4 or self.server.process.poll() is not None,
                       "free space on the disk")
            self.assertIsNone(self.server.process.poll())
            self.assertEqual(self.server.stop(), 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
