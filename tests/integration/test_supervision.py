# SPDX-License-Identifier: GPL-3.0-or-later
"""Time limits of the tests, and tests/support/supervise.py, which runs tests that start other programs."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

from harness import NODE, NODE_MODULES, PATIENCE, ROOT, execute, read_line, wait_until

SUPERVISE = [sys.executable, str(ROOT / "tests" / "support" / "supervise.py")]

# Starts a process in a session of its own, prints its id, and waits.
PARENT = """
import os, subprocess, time
orphan = subprocess.Popen(["sleep", "1000"], start_new_session=True)
print(orphan.pid, os.getpid(), flush=True)
def wait_forever():
    time.sleep(1000)
"""

BROKEN_SET_UP = """
import sys
sys.path.insert(0, "FOLDER")
from harness import ServerCase, unittest
class Broken(ServerCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        raise ValueError("in the set-up")
    def test_nothing(self):
        pass
unittest.main()
"""

HANGING_PAGE = """
import { test } from "node:test";
import "HARNESS";
test("a test that hangs", () => new Promise(() => setInterval(() => {}, 1000)));
"""


def supervise(limit, *command):
    return subprocess.run([*SUPERVISE, str(limit), *command], capture_output=True, text=True, timeout=PATIENCE,
                          check=False)


def is_running(process):
    try:
        status = pathlib.Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return False
    return status.rpartition(")")[2].split()[0] != "Z"


class Supervision(unittest.TestCase):
    def start(self, *command):
        """Starts PARENT by a command. Returns the process of the command, and the ids of the orphan-to-be and of
        PARENT."""
        process = subprocess.Popen([*command, sys.executable, "-c", PARENT + "wait_forever()"],
                                   stdout=subprocess.PIPE, text=True)
        self.addCleanup(process.stdout.close)
        return process, *map(int, read_line(process, "the ids of two processes").split())

    def test_returns_the_exit_status(self):
        self.assertEqual(supervise(60, "true").returncode, 0)
        self.assertEqual(supervise(60, "sh", "-c", "exit 3").returncode, 3)
        self.assertEqual(supervise(60, "sh", "-c", "kill -9 $$").returncode, 128 + signal.SIGKILL)

    def test_prints_where_python_hangs(self):
        done = supervise(2, sys.executable, "-c", PARENT + "wait_forever()")
        self.assertEqual(done.returncode, 1)
        self.assertIn("time limit of 2 s exceeded", done.stderr)
        self.assertIn("in wait_forever", done.stderr)
        self.assertFalse(any(map(is_running, map(int, done.stdout.split()))))

    def test_prints_which_test_of_the_page_hangs(self):
        if not NODE.exists():
            self.skipTest("tests/page/install has not run")
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "hanging.test.mjs"
            file.write_text(HANGING_PAGE.replace("HARNESS", str(ROOT / "tests" / "page" / "harness.js")))
            os.environ.setdefault("CCDT_NODE_MODULES", str(NODE_MODULES))
            done = supervise(5, str(NODE), str(file))
        self.assertEqual(done.returncode, 1)
        self.assertIn("running: a test that hangs", done.stderr)

    def test_ends_when_a_set_up_fails(self):
        done = supervise(60, sys.executable, "-c", BROKEN_SET_UP.replace("FOLDER", str(ROOT / "tests" / "integration")))
        self.assertEqual(done.returncode, 1)
        self.assertIn("ValueError: in the set-up", done.stderr)
        self.assertNotIn("time limit", done.stderr)

    def test_kills_processes_that_outlive_the_program(self):
        process, orphan, program = self.start(*SUPERVISE, "60")
        os.kill(program, signal.SIGKILL)
        self.assertEqual(process.wait(PATIENCE), 128 + signal.SIGKILL)
        self.assertFalse(is_running(orphan))

    def test_kills_all_processes_on_sigterm(self):
        process, *others = self.start(*SUPERVISE, "60")
        process.terminate()
        self.assertEqual(process.wait(PATIENCE), 128 + signal.SIGTERM)
        self.assertFalse(any(map(is_running, others)))

    def test_kills_all_processes_when_its_parent_ends(self):
        process, *others = self.start("sh", "-c", '"$@"; true', "sh", *SUPERVISE, "60")
        process.kill()
        process.wait(PATIENCE)
        wait_until(lambda: not any(map(is_running, others)))


class Limits(unittest.TestCase):
    def test_every_test_has_one(self):
        build = pathlib.Path(os.environ["CCDT_SERVER"]).resolve().parent
        # ctest starts a new log in its working directory, even if it only lists tests.
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "CTestTestfile.cmake").write_text(f'subdirs("{build}")\n')
            output = execute(["ctest", "--show-only=json-v1"], cwd=folder, capture_output=True, check=True).stdout
        names = {test["name"]: {one["name"] for one in test["properties"]} for test in json.loads(output)["tests"]}
        self.assertGreater(len(names), 50)
        self.assertEqual([name for name, properties in names.items()
                          if "TIMEOUT" not in properties and not name.endswith("_NOT_BUILT")], [])


if __name__ == "__main__":
    unittest.main(verbosity=2)
