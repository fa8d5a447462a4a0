# SPDX-License-Identifier: GPL-3.0-or-later
"""The memory that a server takes, and its behaviour when all memory is reserved."""

import io
import json
import os
import pathlib
import random
import re
import subprocess
import threading
import unittest

import numpy
from PIL import Image

from harness import PATIENCE, Call, Server, ask, file_of, join, post_json, wait_until
from raw import SANITIZED

MEBIBYTE = 1 << 20
TORUS = {"type": "torus", "width": 1, "height": 1}
JSON = ("--header", "Content-Type: application/json")


def family(process):
    """Yields a process and its descendants."""
    ids = [process]
    for folder in pathlib.Path("/proc").iterdir():
        if not folder.name.isdigit():
            continue
        try:
            parent = int((folder / "stat").read_text().rsplit(")", 1)[1].split()[1])
        except (OSError, IndexError):
            continue  # gone in the meantime
        if parent == process:
            ids += family(int(folder.name))
    return ids


def resident(process):
    """Returns the resident bytes of a process and its descendants. Shared pages count once."""
    total = 0
    for member in family(process):
        try:
            status = pathlib.Path(f"/proc/{member}/smaps_rollup").read_text()
        except OSError:
            continue
        total += sum(int(size) for size in re.findall(r"^Pss:\s+(\d+) kB", status, re.MULTILINE)) << 10
    return total


class Watch:
    """Records the largest memory of a server within a block."""

    def __init__(self, server):
        self.most = 0
        self.process = server.process.pid
        self.over = threading.Event()
        self.thread = threading.Thread(target=self._look)

    def _look(self):
        while not self.over.wait(0.02):
            self.most = max(self.most, resident(self.process))

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.over.set()
        join(self.thread, "the end of the watch")


def noise(side, form="png", **options):
    """Returns a picture that cannot be compressed much."""
    values = numpy.random.default_rng(side).integers(0, 256, (side, side), dtype=numpy.uint8)
    file = io.BytesIO()
    Image.fromarray(values).save(file, form, **options)
    return file.getvalue()


class Budget(unittest.TestCase):
    @unittest.skipIf(SANITIZED, "sanitizers take memory of their own")
    def test_is_never_exceeded(self):
        budget = 800
        pictures = [noise(1800), noise(1500, "jpeg", progressive=True), noise(1200, "webp", lossless=True)]
        requests = []
        for index in range(3):
            requests.append(("/sample", JSON, json.dumps({"sites": 120_000, "iterations": 1, "domain": TORUS})))
            requests.append(("/sample", JSON, json.dumps({"sites": 200_000, "method": "random", "domain": TORUS})))
            requests.append(("/halftone?sites=5000&iterations=1&scale=2", (), pictures[index % 3]))
            requests.append(("/halftone?sites=5000&iterations=1&scale=2&color=rgb", (), pictures[2]))
            values = ",".join(["0.5"] * 1_000_000)
            requests.append(("/sample", JSON, '{"sites":500,"domain":{"type":"rectangle","width":1,"height":1},'
                                              '"density":{"width":1000,"height":1000,"values":[' + values + ']}}'))
            requests.append(("/sample", JSON, '{"x":[' + "[]," * 1_000_000 + "0]}"))
        random.Random(1).shuffle(requests)
        with Server(f"--memory={budget}MiB", "--workers=8", "--queue=64", "--timeout=600") as server:
            idle = resident(server.process.pid)
            with Watch(server) as watch:
                calls = [Call(server.url(path), *arguments, "--interface", f"127.0.2.{index + 1}", data=data)
                         for index, (path, arguments, data) in enumerate(requests)]
                statuses = [call.answer().status for call in calls]
            self.assertLessEqual(set(statuses), {200, 400, 429, 503})
            self.assertGreaterEqual(statuses.count(200), 6)
            self.assertLess(watch.most, budget * MEBIBYTE)
            self.assertGreater(watch.most, idle + 48 * MEBIBYTE)  # otherwise the test requested too little
            self.assertEqual(server.stop(), 0)

    @unittest.skipIf(SANITIZED, "sanitizers take memory of their own")
    def test_is_not_exceeded_by_waiting_forms(self):
        budget = 640
        boundary = "-" * 69 + "x"
        form = ("--header", f"Content-Type: multipart/form-data; boundary={boundary}")
        part = f'--{boundary}\r\nContent-Disposition: form-data; name="image"\r\n\r\n'.encode()
        dashes = b"-" * 20_000_000  # a form without an end
        picture = part + noise(1000) + f"\r\n--{boundary}--\r\n".encode()
        with Server(f"--memory={budget}MiB", "--workers=2", "--queue=64", "--timeout=600") as server:
            idle = resident(server.process.pid)
            with Watch(server) as watch:
                calls = [Call(server.url("/halftone?sites=100&scale=0.1&iterations=0"), *form,
                              data=part + dashes if index % 2 else picture) for index in range(60)]
                statuses = [call.answer().status for call in calls]
            self.assertLessEqual(set(statuses), {200, 400, 429, 503})
            self.assertIn(200, statuses)
            self.assertLess(watch.most, budget * MEBIBYTE)
            self.assertGreater(watch.most, idle + 20 * MEBIBYTE)  # otherwise the test requested too little
            self.assertEqual(server.stop(), 0)

    def test_refuses_requests_that_need_too_much(self):
        with Server("--memory=1GiB", "--workers=1", "--max-sites=5000000") as server:
            answer = post_json(server, "/sample", {"sites": 5_000_000, "domain": TORUS})
            self.assertEqual((answer.status, answer.type), (413, "application/problem+json"))
            self.assertIn("(memory)", answer.json()["detail"])
            self.assertEqual(post_json(server, "/sample", {"sites": 100, "domain": TORUS}).status, 200)

    def test_refuses_large_pictures_by_their_header(self):
        with Server("--memory=1GiB", "--workers=1") as server:
            self.assertEqual(ask(server, "/halftone?sites=100&scale=1", data=file_of(numpy.zeros((300, 300), "u1"))).status,
                             200)
            large = file_of(numpy.zeros((7500, 8000), "u1"))
            answer = ask(server, "/halftone?sites=100", data=large)
            self.assertEqual(answer.status, 413)
            self.assertIn("(memory)", answer.json()["detail"])

    def test_must_leave_memory_for_computations(self):
        done = subprocess.run([os.environ["CCDT_SERVER"], "--port=0", "--memory=100MiB"], capture_output=True, text=True,
                              timeout=PATIENCE, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("leaves too little to compute with: ", done.stderr)
        enough = re.search(r": (\d+) MiB suffice \(--memory", done.stderr)[1]
        with Server(f"--memory={enough}MiB") as server:
            self.assertEqual(post_json(server, "/sample", {"sites": 1000, "domain": TORUS}).status, 200)


class Scheduling(unittest.TestCase):
    def test_short_requests_run_before_long_ones(self):
        endless = json.dumps({"sites": 50_000, "iterations": 1000, "passes": 100, "domain": TORUS})
        with Server("--workers=2", "--queue=8", "--timeout=300") as server:
            calls = [Call(server.url("/sample"), *JSON, data=endless) for _ in range(8)]
            wait_until(lambda: "\nccdt_workers_busy 2\n" in ask(server, "/metrics").body.decode())
            for _ in range(20):
                self.assertEqual(post_json(server, "/sample", {"sites": 500, "domain": TORUS}).status, 200)
            self.assertTrue(all(call.process.poll() is None for call in calls))
            for call in calls:
                call.abandon()


if __name__ == "__main__":
    unittest.main(verbosity=2)
