# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the examples of all READMEs that name the address of a server, unchanged, against a separate server."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from harness import NODE, PATIENCE, PICTURES, ROOT, Server

# Folders of builds contain Markdown of other projects.
PAGES = [page for page in sorted(ROOT.rglob("*.md")) if page.relative_to(ROOT).parts[0] not in ("build", "dist")]
# Tests of the Python package and of the npm package run the examples of their READMEs.
READMES = [page for page in PAGES if page.name == "README.md" and page.parent.name not in ("python", "package")]
ADDRESS = "localhost:8080"

# The example that shows an error.
CROSSING = "[[0,0],[1,1],[1,0],[0,1]]"


def blocks(page, language):
    found = re.findall(rf"^```{language}\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)
    return [block for block in found if ADDRESS in block]


def prose(page):
    """Returns the text of a page without its blocks of code."""
    return re.sub(r"^```.*?^```", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)


def anchor(title):
    """Returns the anchor that Markdown renderers make for a heading."""
    return re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-")


class Links(unittest.TestCase):
    def test_have_existing_targets(self):
        for page in PAGES:
            for link in re.findall(r"\]\(([^)]+)\)", prose(page)):
                if re.match(r"\w+:", link):
                    continue
                with self.subTest(page=page, link=link):
                    name, _, place = link.partition("#")
                    file = page.parent / name if name else page
                    self.assertTrue(file.exists())
                    if place:
                        titles = re.findall(r"^#+ (.*)", prose(file), re.MULTILINE)
                        self.assertIn(place, [anchor(title) for title in titles])


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--cache=64MiB", f"--pictures={PICTURES}")
        cls.folder = tempfile.TemporaryDirectory()
        folder = pathlib.Path(cls.folder.name)
        for name in ("server", "tests"):
            (folder / name).symlink_to(ROOT / name)
        (folder / "photo.jpg").symlink_to(PICTURES / "chelsea.png")  # recognised by its first bytes
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

    def examples(self, language, least):
        """Returns the examples of a language, each with its page. There must be at least `least`."""
        found = [(page, block) for page in READMES for block in blocks(page, language)]
        self.assertGreaterEqual(len(found), least)
        return found

    def test_run_in_python(self):
        for page, block in self.examples("python", 1):
            with self.subTest(page=page):
                self.assertEqual(self.run_it(sys.executable, "-c", code=block), (0, b"1000 points\n", b""))

    def test_run_in_javascript(self):
        for page, block in self.examples("js", 1):
            with self.subTest(page=page):
                code, output, errors = self.run_it(NODE, "--input-type=module", "--eval", code=block)
                self.assertEqual((code, output), (0, b"1000 points\n"), errors)

    def test_run_in_the_shell(self):
        for page, block in self.examples("sh", 10):
            with self.subTest(page=page, block=block):
                code, output, errors = self.run_it("bash", "-euo", "pipefail", "-c", code=block)
                self.assertEqual(code, 22 if CROSSING in block else 0, (output[:500], errors))
                if "%{http_code}" in block:
                    self.assertEqual(output, b"304\n")


if __name__ == "__main__":
    unittest.main(verbosity=2)
