# SPDX-License-Identifier: GPL-3.0-or-later
"""Set-up scripts and image: all of them read one list of packages."""

import ast
import importlib.util
import json
import os
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

from harness import NODE, ROOT, execute

SCRIPTS = ("server/run", "tests/run", "tests/style/check", "tests/style/lint", "tests/bench/service/run",
           "tests/fuzz/run", "tests/page/install", "tests/deploy/install", "tests/soak/run", ".ci/run",
           "server/page/package/pack", "docker/collect", "docker/packages", "docker/install", "docker/snapshot",
           "docker/owners", "docker/sbom", "docker/release", "docker/site", "tests/packages/boot")
LIST = ROOT / "docker" / "packages.txt"


def sections():
    """Reads the list independently of the scripts."""
    found = {}
    for line in LIST.read_text().splitlines():
        line = line.split("#")[0].strip()
        if line.startswith("["):
            current = found.setdefault(line.strip("[]"), [])
        elif line:
            current.append(line)
    return found


def imports(path):
    """Returns the top-level modules that a Python file imports."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module.split(".")[0]


def package_of(module):
    """Returns the package that installed a Python module; none if no package did."""
    found = importlib.util.find_spec(module)
    if found is None:
        return None
    result = execute(["dpkg", "--search", found.origin], capture_output=True, text=True, check=False)
    return result.stdout.split(":")[0] or None


class Setup(unittest.TestCase):
    def test_scripts_are_valid_and_executable(self):
        for name in SCRIPTS:
            path = ROOT / name
            with self.subTest(name=name):
                self.assertTrue(path.stat().st_mode & 0o100)
                text = path.read_text()
                self.assertTrue(text.startswith("#!/bin/bash\n"))
                self.assertIn("set -euo pipefail", text)
                execute(["bash", "-n", str(path)], check=True)

    def test_the_version_is_the_same_everywhere(self):
        version = re.search(r"^project\(ccdt VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE)[1]
        self.assertEqual(json.loads((ROOT / "api" / "openapi.json").read_text())["info"]["version"], version)
        package = ROOT / "server" / "page" / "package" / "package.json"
        self.assertEqual(json.loads(package.read_text())["version"], version)
        chart = (ROOT / "docker" / "chart" / "Chart.yaml").read_text()
        self.assertIn(f"\nversion: {version}\n", chart)
        self.assertIn(f"\nappVersion: {version}\n", chart)
        released = re.search(r"^## \[(\d\S*)\] - \d{4}-\d\d-\d\d$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
        self.assertEqual(released[1], version, "the first released version in CHANGELOG.md")

    def test_the_list_has_its_sections(self):
        self.assertEqual(set(sections()), {"build", "run", "package", "test", "site", "wasm", "fuzz", "tools"})

    def test_sections_are_printed_as_listed(self):
        for name, packages in sections().items():
            result = execute([ROOT / "docker" / "packages", name], capture_output=True, text=True, check=True)
            self.assertEqual(result.stdout.split(), packages)
        both = execute([ROOT / "docker" / "packages", "build", "test"], capture_output=True, text=True, check=True)
        self.assertEqual(both.stdout.split(), sections()["build"] + sections()["test"])

    def test_an_unknown_section_is_an_error(self):
        self.assertNotEqual(
            execute([ROOT / "docker" / "packages", "nonsense"], capture_output=True, check=False).returncode, 0)

    def test_packages_are_named_nowhere_else(self):
        packages = {name for listed in sections().values() for name in listed if name.startswith("lib")}
        self.assertGreater(len(packages), 5)
        for name in (*SCRIPTS, "docker/Dockerfile", "docker/compose.yaml"):
            text = (ROOT / name).read_text()
            with self.subTest(name=name):
                self.assertEqual([package for package in packages if package in text], [])

    def test_modules_come_from_listed_packages(self):
        files = [*(ROOT / "tests").rglob("*.py"), *(ROOT / "docker").rglob("*.py")]
        taken = {module for path in files for module in imports(path)}
        own = {path.stem for path in [*files, *(ROOT / "api" / "python").glob("*.py")]} | {"ccdt"}
        modules = taken - own - set(sys.stdlib_module_names)
        self.assertIn("numpy", modules)
        packages = {module: package_of(module) for module in modules}
        self.assertEqual({module: package for module, package in packages.items()
                          if package not in sections()["test"] + sections()["site"]}, {})

    def test_the_image_installs_from_the_list(self):
        text = (ROOT / "docker" / "Dockerfile").read_text()
        self.assertIn("docker/install build", text)
        self.assertIn("docker/install run", text)
        self.assertNotIn("apt-get", text)
        self.assertNotIn("tools", text)

    def test_the_image_can_be_built_from_a_snapshot(self):
        snapshot = ROOT / "docker" / "snapshot"
        with tempfile.TemporaryDirectory() as folder:
            sources = pathlib.Path(folder) / "sources.list.d" / "debian.sources"
            sources.parent.mkdir()
            today = "URIs: http://deb.debian.org/debian\n"
            sources.write_text(today)
            environment = {**os.environ, "CCDT_SOURCES": str(sources)}
            for time, code in (("", 0), ("yesterday", 1), ("2026-01-05", 1)):
                self.assertEqual(execute([snapshot, time], env=environment, capture_output=True,
                                         check=False).returncode, code)
                self.assertEqual(sources.read_text(), today)
            execute([snapshot, "20260105T000000Z"], env=environment, check=True)
            uris = [line.split()[1] for line in sources.read_text().splitlines() if line.startswith("URIs:")]
            self.assertEqual(uris, [f"http://snapshot.debian.org/archive/{archive}/20260105T000000Z"
                                    for archive in ("debian", "debian-security")])
        for stage in ("build", "run"):
            self.assertIn(f'RUN docker/snapshot "$SNAPSHOT" && docker/install {stage}\n',
                          (ROOT / "docker" / "Dockerfile").read_text())

    def test_node_is_pinned(self):
        if not NODE.exists():
            self.skipTest("tests/page/install has not run")
        pinned = json.loads((ROOT / "tests" / "page" / "package.json").read_text())["optionalDependencies"]
        output = execute([NODE, "--version"], capture_output=True, text=True, check=True).stdout
        self.assertEqual({f"v{version}\n" for version in pinned.values()}, {output})

    def test_tests_unpack_their_tools(self):
        self.assertIn("docker/install --unpack tools", (ROOT / "tests" / "run").read_text())


class Unpacking(unittest.TestCase):
    """Unpacking with a fake apt-get, which has the package `widget` once its lists are updated, and a fake sudo."""

    APT_GET = """#!/bin/bash
while [[ $1 == -* ]]; do [[ $1 == -o ]] && shift; shift; done
echo "$*" >> "$FAKE/calls"
case $1 in
    update) touch "$FAKE/lists" ;;
    download) [[ -e $FAKE/lists && $2 == widget ]] && cp "$FAKE/widget.deb" widget_1.0_all.deb ;;
esac
"""
    SUDO = """#!/bin/bash
exec "$@"
"""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        (self.root / "docker").mkdir()
        for name in ("install", "packages"):
            shutil.copy(ROOT / "docker" / name, self.root / "docker" / name)
        self.fake = self.root / "fake"
        self.fake.mkdir()
        for name, text in (("apt-get", self.APT_GET), ("sudo", self.SUDO)):
            (self.fake / name).write_text(text)
            (self.fake / name).chmod(0o755)
        package = self.fake / "widget"
        control = "Package: widget\nVersion: 1.0\nArchitecture: all\nMaintainer: nobody\nDescription: none\n"
        for path, text in (("DEBIAN/control", control), ("usr/bin/widget", "whirr\n")):
            (package / path).parent.mkdir(parents=True)
            (package / path).write_text(text)
        execute(["dpkg-deb", "--build", package, self.fake / "widget.deb"], check=True, capture_output=True)

    def unpack(self, package):
        (self.root / "docker" / "packages.txt").write_text(f"[tools]\n{package}\n")
        return execute([self.root / "docker" / "install", "--unpack", "tools"], capture_output=True, text=True,
                       check=False, env={**os.environ, "PATH": f"{self.fake}:{os.environ['PATH']}",
                                         "FAKE": str(self.fake)})

    def calls(self):
        return (self.fake / "calls").read_text().splitlines()

    def tools(self):
        return sorted(path.name for path in (self.root / "build" / "tools").iterdir())

    def test_updates_the_lists_if_necessary_and_installs_nothing(self):
        done = self.unpack("widget")
        self.assertEqual((done.returncode, done.stderr), (0, "unpacking: widget\n"))
        self.assertEqual(self.calls(), ["download widget", "update", "download widget"])
        self.assertEqual((self.root / "build/tools/widget/usr/bin/widget").read_text(), "whirr\n")
        self.assertEqual(self.tools(), ["widget"])

    def test_does_nothing_when_repeated(self):
        self.unpack("widget")
        calls = self.calls()
        again = self.unpack("widget")
        self.assertEqual((again.returncode, again.stdout, again.stderr), (0, "", ""))
        self.assertEqual(self.calls(), calls)

    def test_fails_for_unknown_packages(self):
        self.assertNotEqual(self.unpack("gadget").returncode, 0)
        self.assertEqual(self.tools(), [])


if __name__ == "__main__":
    unittest.main(verbosity=2)
