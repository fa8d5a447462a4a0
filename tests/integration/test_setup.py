"""Scripts and image: one list of packages, read by all that set up a machine."""

import pathlib
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SCRIPTS = ("server/run", "tests/run", ".ci/run", "docker/packages", "docker/install")
LIST = ROOT / "docker" / "packages.txt"


def sections():
    """The list, read in a way of our own."""
    found = {}
    for line in LIST.read_text().splitlines():
        line = line.split("#")[0].strip()
        if line.startswith("["):
            current = found.setdefault(line.strip("[]"), [])
        elif line:
            current.append(line)
    return found


class Setup(unittest.TestCase):
    def test_scripts_are_sound_and_executable(self):
        for name in SCRIPTS:
            path = ROOT / name
            with self.subTest(name=name):
                self.assertTrue(path.stat().st_mode & 0o100)
                text = path.read_text()
                self.assertTrue(text.startswith("#!/bin/bash\n"))
                self.assertIn("set -euo pipefail", text)
                subprocess.run(["bash", "-n", str(path)], check=True)

    def test_the_list_has_its_sections(self):
        self.assertEqual(set(sections()), {"build", "run", "test"})

    def test_sections_are_printed_as_listed(self):
        for name, packages in sections().items():
            told = subprocess.run([ROOT / "docker" / "packages", name], capture_output=True, text=True, check=True)
            self.assertEqual(told.stdout.split(), packages)
        both = subprocess.run([ROOT / "docker" / "packages", "build", "test"], capture_output=True, text=True, check=True)
        self.assertEqual(both.stdout.split(), sections()["build"] + sections()["test"])

    def test_an_unknown_section_is_an_error(self):
        self.assertNotEqual(
            subprocess.run([ROOT / "docker" / "packages", "nonsense"], capture_output=True, check=False).returncode, 0)

    def test_packages_are_named_nowhere_else(self):
        packages = {name for listed in sections().values() for name in listed if name.startswith("lib")}
        self.assertGreater(len(packages), 5)
        for name in (*SCRIPTS, "docker/Dockerfile", "docker/compose.yaml"):
            text = (ROOT / name).read_text()
            with self.subTest(name=name):
                self.assertEqual([package for package in packages if package in text], [])

    def test_the_image_installs_from_the_list(self):
        text = (ROOT / "docker" / "Dockerfile").read_text()
        self.assertIn("docker/install build", text)
        self.assertIn("docker/install run", text)
        self.assertNotIn("apt-get", text)


if __name__ == "__main__":
    unittest.main(verbosity=2)
