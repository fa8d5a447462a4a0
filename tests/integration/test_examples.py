"""The README's examples, as they stand there, against a server of their own."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from harness import PATIENCE, ROOT, Server

PAGE = (ROOT / "README.md").read_text()
API = PAGE[PAGE.index("## The API by example"):PAGE.index("## Configuration")]
ADDRESS = "localhost:8080"

# The one that shows an error.
CROSSING = "[[0,0],[1,1],[1,0],[0,1]]"


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", API, re.MULTILINE | re.DOTALL)


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--cache=64MiB")
        cls.folder = tempfile.TemporaryDirectory()
        folder = pathlib.Path(cls.folder.name)
        (folder / "tests").symlink_to(ROOT / "tests")
        (folder / ".curlrc").write_text("fail-with-body\nsilent\n")

    @classmethod
    def tearDownClass(cls):
        with cls.server, cls.folder:
            pass

    def run_it(self, *command, code):
        self.assertIn(ADDRESS, code)
        code = code.replace(ADDRESS, f"127.0.0.1:{self.server.port}")
        environment = {**os.environ, "CURL_HOME": self.folder.name}
        done = subprocess.run([*command, code], cwd=self.folder.name, env=environment, capture_output=True,
                              timeout=PATIENCE, check=False)
        return done.returncode, done.stdout, done.stderr

    def test_for_python(self):
        self.assertEqual(len(blocks("python")), 1)
        self.assertEqual(self.run_it(sys.executable, "-c", code=blocks("python")[0]), (0, b"1000 points\n", b""))

    def test_for_javascript(self):
        self.assertEqual(len(blocks("js")), 1)
        code, told, errors = self.run_it("node", "--input-type=module", "--eval", code=blocks("js")[0])
        self.assertEqual((code, told), (0, b"1000 points\n"), errors)

    def test_for_the_shell(self):
        self.assertGreater(len(blocks("sh")), 7)
        for block in blocks("sh"):
            with self.subTest(block=block):
                code, told, errors = self.run_it("bash", "-euo", "pipefail", "-c", code=block)
                self.assertEqual(code, 22 if CROSSING in block else 0, (told[:500], errors))
                if "%{http_code}" in block:
                    self.assertEqual(told, b"304\n")


if __name__ == "__main__":
    unittest.main(verbosity=2)
