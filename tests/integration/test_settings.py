# SPDX-License-Identifier: GPL-3.0-or-later
"""The file of settings: read, printed, reloaded."""

import os
import pathlib
import signal
import tempfile
import unittest

from harness import Server, ask, execute, wait_until

ALICE = "alice-0123456789abcdef"
ORIGIN = ("--header", "Origin: https://a.example")


class Settings(unittest.TestCase):
    def setUp(self):
        folder = self.enterContext(tempfile.TemporaryDirectory())
        self.file = pathlib.Path(folder) / "server.conf"

    def reload(self, server, text, message):
        """Writes the file, sends SIGHUP, and waits for a message, which must be new."""
        self.assertNotIn(message, server.log())
        self.file.write_text(text)
        server.signal(signal.SIGHUP)
        server.wait_for_log(message)

    def test_are_reloaded_on_sighup(self):
        self.file.write_text("max-sites = 500\n")
        with Server(f"--config={self.file}") as server:
            answer = ask(server, "/capabilities", *ORIGIN)
            self.assertEqual((answer.status, answer.headers.get("access-control-allow-origin")), (200, None))
            self.assertEqual(answer.json()["limits"]["max_sites"], 500)
            self.reload(server, "max-sites = 600\ncors-origin = https://a.example\n",
                        "need a restart: --max-sites")
            answer = ask(server, "/capabilities", *ORIGIN)
            self.assertEqual(answer.headers["access-control-allow-origin"], "https://a.example")
            self.assertEqual(answer.json()["limits"]["max_sites"], 500)
            self.reload(server, "max-sites = x\n", "settings and keys stay as they were: "
                        f"{self.file}:1: max-sites: 'x' is not a whole number from 1 to 100000000")
            self.assertEqual(ask(server, "/capabilities", *ORIGIN).headers["access-control-allow-origin"],
                             "https://a.example")
            self.file.write_text("max-sites = 500\nrate-limit = 0.001\nrate-burst = 2\nallowed-host = dots.example\n")
            server.signal(signal.SIGHUP)
            host = ("--header", "Host: dots.example")
            wait_until(lambda: ask(server, "/capabilities", *host).status == 200)
            self.assertEqual([ask(server, "/jobs/x").status for _ in range(3)], [404, 404, 429])
            self.assertEqual(server.stop(), 0)

    def test_survive_a_missing_key_file(self):
        keys = self.file.with_name("keys")
        keys.write_text(f"alice:{ALICE}\n")
        self.file.write_text(f"api-key-file = {keys}\n")
        with Server(f"--config={self.file}") as server:
            keys.unlink()
            self.reload(server, f"api-key-file = {keys}\nrate-limit = 0.001\nrate-burst = 1\n",
                        f"settings and keys stay as they were: {keys}: cannot be read")
            header = ("--header", f"Authorization: Bearer {ALICE}")
            self.assertEqual([ask(server, "/jobs/x", *header).status for _ in range(3)], [404] * 3)

    def test_are_printed_as_a_file(self):
        command = [os.environ["CCDT_SERVER"], "--print-config", "--port=81", "--max-sites=7"]
        done = execute(command, capture_output=True, text=True, check=True)
        self.file.write_text(done.stdout)
        self.assertIn("\nport = 81\n", done.stdout)
        self.assertIn("\n#rate-burst = 20\n", done.stdout)
        with Server(f"--config={self.file}") as server:
            self.assertEqual(ask(server, "/capabilities").json()["limits"]["max_sites"], 7)


if __name__ == "__main__":
    unittest.main(verbosity=2)
