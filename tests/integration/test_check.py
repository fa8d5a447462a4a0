# SPDX-License-Identifier: GPL-3.0-or-later
"""Output of --check, before a server is started."""

import os
import pathlib
import re
import shutil
import socket
import subprocess
import tempfile
import threading
import unittest

from engine import Redis
from harness import PATIENCE, Server, ask, execute, join

PARTS = ["decoder", "worker", "keys", "signing", "pictures", "docs", "memory", "files", "jobs", "answers", "rates", "address",
         "metrics", "webhooks", "origins"]
MAY_BE_WRONG = [part for part in PARTS if part not in ("files", "answers", "rates", "metrics")]


class Check(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def check(self, *flags, program=None, max_files=None, **environment):
        """Returns the exit code, value and origin of each flag, and state and text of each part."""
        limit = ["prlimit", f"--nofile={max_files}"] if max_files else []
        done = subprocess.run([*limit, program or os.environ["CCDT_SERVER"], "--check", *flags], capture_output=True, text=True,
                              timeout=PATIENCE, check=False, env={**os.environ, **environment})
        self.assertEqual(done.stderr, "")
        values, found = done.stdout.split("and finds\n")
        rows = [re.match(r"  (\S+) +(.+?) +(\S+)$", line).groups() for line in values.splitlines()[1:]]
        parts = [line.split(maxsplit=2) for line in found.splitlines()]
        self.assertEqual([part for part, _, _ in parts if part != "variables"], PARTS)
        return (done.returncode, {flag: (value, origin) for flag, value, origin in rows},
                {part: (state, words) for part, state, words in parts})

    def wrong(self, *flags, **more):
        code, _, parts = self.check("--port=0", *flags, **more)
        wrong = {part: words for part, (state, words) in parts.items() if state == "WRONG"}
        self.assertEqual(code, 1 if wrong else 0)
        return wrong

    def test_reports_the_settings(self):
        code, values, parts = self.check("--workers=3", f"--data-dir={self.folder / 'jobs'}", PORT="0",
                                         CCDT_MEMORY="4GiB")
        self.assertEqual(code, 0)
        self.assertEqual(values["--workers"], ("3", "--workers"))
        self.assertEqual(values["--port"], ("0", "PORT"))
        self.assertEqual(values["--memory"], ("4GiB", "CCDT_MEMORY"))
        self.assertEqual(values["--queue"], ("48", "default"))
        output = execute([os.environ["CCDT_SERVER"], "--help"], capture_output=True, text=True, check=True).stdout
        self.assertEqual(list(values), re.findall(r"^  (--[a-z-]+) [A-Z]", output, re.MULTILINE))
        self.assertIn("in force: ", parts["decoder"][1])
        self.assertEqual(parts["worker"][0], "good")
        self.assertRegex(parts["memory"][1], r"^\d+ MiB of 4096 ")
        self.assertRegex(parts["files"][1], r"\d+ connections, \d+ in reserve")
        self.assertIn(str(self.folder / "jobs"), parts["jobs"][1])
        self.assertEqual(list(self.folder.iterdir()), [], "no file may be created")

    def test_reports_unknown_variables(self):
        code, _, parts = self.check("--port=0", CCDT_QUEU="3")
        self.assertEqual((code, parts["variables"]),
                         (0, ("weak", "the variable CCDT_QUEU has no effect; did you mean CCDT_QUEUE?")))
        with Server(environment={"CCDT_QUEU": "3"}) as server:
            self.assertIn(" warning the variable CCDT_QUEU has no effect; did you mean CCDT_QUEUE?", server.log())

    def test_reports_all_faults_at_once(self):
        (self.folder / "file").touch()
        alone = self.folder / "ccdt-server"
        shutil.copy(os.environ["CCDT_SERVER"], alone)
        with socket.create_server(("127.0.0.1", 0)) as taken:
            wrong = self.wrong(f"--port={taken.getsockname()[1]}", "--memory=1MiB", "--api-key-file=/none",
                               "--signing-key-file=/none", "--pictures=/none", "--docs=/none",
                               "--webhook-host=a", "--webhook-key-file=/none", "--origin=a",
                               f"--data-dir={self.folder / 'file' / 'jobs'}", program=alone)
        self.assertEqual(list(wrong), MAY_BE_WRONG)
        self.assertIn("ccdt-decoder", wrong["decoder"])
        self.assertIn("ccdt-worker", wrong["worker"])
        self.assertIn("ccdt-fetcher", wrong["origins"])
        for part in ("keys", "signing", "pictures", "docs", "webhooks"):
            self.assertIn("/none", wrong[part])
        self.assertIn("MiB suffice", wrong["memory"])
        self.assertIn("Not a directory", wrong["jobs"])
        self.assertIn("in use", wrong["address"])

    def test_reports_each_fault_by_itself(self):
        (self.folder / "file").touch()
        for part, flag in (("keys", f"--api-key-file={self.folder / 'file'}"),
                           ("signing", f"--signing-key-file={self.folder / 'file'}"),
                           ("pictures", f"--pictures={self.folder / 'file'}"),
                           ("docs", f"--docs={self.folder / 'file'}"), ("memory", "--memory=200MiB"),
                           ("jobs", f"--data-dir={self.folder / 'file'}"), ("address", "--bind=no.such.host.invalid")):
            with self.subTest(part=part):
                self.assertEqual(list(self.wrong(flag)), [part])
        self.assertEqual(self.wrong(), {})

    def test_reports_the_port_of_metrics(self):
        self.assertEqual(self.check("--port=0")[2]["metrics"], ("good", "on the same port"))
        with socket.create_server(("127.0.0.1", 0)) as taken:
            flag = f"--metrics-port={taken.getsockname()[1]}"
            self.assertIn("in use", self.wrong(flag)["metrics"])
        self.assertEqual(self.wrong(flag, f"--bind=unix:{self.folder / 'socket'}"), {})

    def test_reports_how_many_connections_fit(self):
        for most, state, words in ((60, "WRONG", "(ulimit -n) is 60: at least"), (200, "weak", "(ulimit -n) is 200"),
                                   (4096, "good", "connections")):
            code, _, parts = self.check("--port=0", "--workers=2", max_files=most)
            self.assertEqual(code, 1 if state == "WRONG" else 0)
            self.assertEqual(parts["files"][0], state)
            self.assertIn(words, parts["files"][1])

    def test_reports_whether_redis_is_reachable_and_suitable(self):
        with Redis() as redis:
            _, _, parts = self.check("--port=0", f"--redis={redis.url}")
            self.assertEqual(parts["jobs"], ("good", f"stored in Redis at 127.0.0.1:{redis.port}"))
            redis.cli("CONFIG", "SET", "maxmemory-policy", "allkeys-lru")
            self.assertIn("noeviction", self.check("--port=0", f"--redis={redis.url}")[2]["jobs"][1])
        _, values, parts = self.check("--port=0", CCDT_REDIS=f"redis://:secret@127.0.0.1:{redis.port}")
        self.assertEqual(parts["jobs"][0], "weak")
        self.assertIn("refused", parts["jobs"][1])
        self.assertNotIn("secret", str(values))

    def test_reports_where_answers_and_rates_are_stored(self):
        _, _, parts = self.check("--port=0", "--cache=0")
        self.assertEqual((parts["answers"], parts["rates"]), (("good", "not kept"), ("good", "not limited")))
        _, _, parts = self.check("--port=0", "--rate-limit=1")
        self.assertEqual((parts["answers"], parts["rates"]), (("good", "kept here"), ("good", "counted here")))
        with Redis() as redis:
            flags = (f"--cache-redis={redis.url}", f"--rate-redis={redis.url}", "--rate-limit=1")
            redis.cli("CONFIG", "SET", "maxmemory-policy", "volatile-lru")
            _, _, parts = self.check("--port=0", *flags)
            self.assertEqual(parts["answers"], ("good", f"kept here and in Redis at 127.0.0.1:{redis.port}"))
            self.assertEqual(parts["rates"], ("good", f"counted in Redis at 127.0.0.1:{redis.port}"))
            redis.cli("CONFIG", "SET", "maxmemory-policy", "noeviction")
            self.assertEqual(self.check("--port=0", *flags)[2]["answers"][0], "weak")
        code, _, parts = self.check("--port=0", *flags)
        self.assertEqual(code, 0, "the server starts without them")
        for part in ("answers", "rates"):
            self.assertEqual(parts[part][0], "weak")
            self.assertIn("refused", parts[part][1])

    def test_does_not_disturb_a_running_server(self):
        flag = f"--data-dir={self.folder}"
        with Server(flag) as server:
            before = sorted(self.folder.iterdir())
            self.assertEqual(self.wrong(flag), {})
            self.assertEqual(list(self.wrong(flag, f"--port={server.port}")), ["address"])
            self.assertEqual(sorted(self.folder.iterdir()), before)
            self.assertEqual(ask(server, "/health/ready").status, 200)
            self.assertEqual(server.stop(), 0)

    def test_wrong_usage_exits_with_2(self):
        done = subprocess.run([os.environ["CCDT_SERVER"], "--check", "--workers=0"], capture_output=True, text=True,
                              timeout=PATIENCE, check=False)
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("--workers", done.stderr)


class Health(unittest.TestCase):
    def health(self, *flags, **environment):
        done = subprocess.run([os.environ["CCDT_SERVER"], "--health", *flags], capture_output=True, text=True,
                              timeout=PATIENCE, check=False, env={**os.environ, **environment})
        self.assertEqual(done.stdout, "")
        self.assertEqual(done.returncode, 1 if done.stderr else 0)
        return done.stderr

    def test_reports_a_running_server(self):
        for bind in ("127.0.0.1", "0.0.0.0", "::"):
            with self.subTest(bind=bind), Server(f"--bind={bind}", "--max-connections-per-address=1") as server:
                self.assertEqual(self.health(f"--bind={bind}", f"--port={server.port}"), "")
                self.assertEqual(self.health(BIND=bind, PORT=str(server.port)), "")
                self.assertEqual(server.stop(), 0)
                self.assertIn("Connection refused", self.health(f"--port={server.port}"))

    def test_works_over_unix_sockets(self):
        with tempfile.TemporaryDirectory() as folder:
            bind = f"--bind=unix:{folder}/socket"
            self.assertIn("No such file", self.health(bind))
            with Server(bind) as server:
                self.assertEqual(self.health(bind), "")
                self.assertEqual(server.stop(), 0)

    def test_detects_other_programs_on_the_port(self):
        with socket.create_server(("127.0.0.1", 0)) as listener:
            listener.settimeout(PATIENCE)

            def answer():
                for words in (b"SSH-2.0-OpenSSH_9.2\r\n", b"HTTP/1.1 503 Service Unavailable\r\n\r\n", b""):
                    client = listener.accept()[0]
                    with client:
                        client.recv(1000)
                        client.sendall(words)

            thread = threading.Thread(target=answer)
            thread.start()
            port = f"--port={listener.getsockname()[1]}"
            self.assertIn("SSH", self.health(port))
            self.assertIn("HTTP/1.1 503", self.health(port))
            self.assertIn("unhealthy", self.health(port))
            join(thread, "the last of three health checks")


if __name__ == "__main__":
    unittest.main(verbosity=2)
