# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of a release that need no further build: source archive, bill of materials, notes and checksums."""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile
import tempfile
import unittest

import jsonschema

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "integration"))

from harness import ROOT, TOOLS, execute  # pylint: disable=wrong-import-position

FOLDER = pathlib.Path(os.environ["CCDT_SERVER"]).parent
SCHEMAS = TOOLS / "deploy" / "node_modules" / "@cyclonedx" / "cyclonedx-library" / "res" / "schema"
VERSION = json.loads((ROOT / "api" / "openapi.json").read_text())["info"]["version"]


def release(*arguments, root=ROOT, **options):
    return execute([root / "docker" / "release", *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                   text=True, check=False, **options)


def git(*arguments, root=ROOT):
    return execute(["git", "-C", root, *arguments], capture_output=True, text=True, check=True).stdout


def is_checkout():
    return execute(["git", "-C", ROOT, "rev-parse", "--quiet", "--verify", "HEAD"], capture_output=True,
                   check=False).returncode == 0


def reject_additional_items(_, allowed, instance, schema):
    """Replaces a check of jsonschema 4.10, which fails if the items are objects."""
    if allowed is False and isinstance(instance, list) and len(instance) > len(schema["items"]):
        yield jsonschema.ValidationError("additional items")


Validator = jsonschema.validators.extend(jsonschema.Draft7Validator, {"additionalItems": reject_additional_items})


@unittest.skipUnless(is_checkout(), "the source is not a git checkout with a commit")
@unittest.skipIf(os.geteuid() != 0, "only root may make files of another user")
class Files(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, folder)
        cls.once, cls.again = folder / "once", folder / "again"
        cls.build(cls.once)
        cls.build(cls.again, cwd="/", umask=0o077, env={**os.environ, "TZ": "Asia/Kolkata", "LC_ALL": "C"})

    @classmethod
    def build(cls, out, **options):
        done = release("--build", FOLDER, out, "source", "sbom", "notes", **options)
        if done.returncode != 0:
            raise AssertionError(done.stdout)

    def test_are_the_same_bytes_again(self):
        self.assertEqual((self.once / "SHA256SUMS").read_text(), (self.again / "SHA256SUMS").read_text())

    def test_checksums_are_those_of_all_files(self):
        done = execute(["sha256sum", "--check", "--strict", "SHA256SUMS"], cwd=self.again, capture_output=True,
                       text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([line.split("  ")[1] for line in (self.once / "SHA256SUMS").read_text().splitlines()],
                         [f"ccdt-{VERSION}-notes.md", f"ccdt-{VERSION}-source.tar.xz", f"ccdt-{VERSION}.cdx.json"])

    def test_source_archive_has_the_files_of_the_commit(self):
        with tarfile.open(self.once / f"ccdt-{VERSION}-source.tar.xz") as archive:
            files = [entry for entry in archive if not entry.isdir()]
            licence = archive.extractfile(f"ccdt-{VERSION}/LICENSE").read()
        names = git("ls-tree", "-r", "--name-only", "HEAD").splitlines()
        self.assertEqual({entry.name for entry in files}, {f"ccdt-{VERSION}/{name}" for name in names})
        self.assertEqual({entry.mtime for entry in files}, {int(git("log", "-1", "--format=%ct"))})
        self.assertEqual({entry.mode for entry in files if entry.isfile()}, {0o644, 0o755})
        self.assertEqual(licence, (ROOT / "LICENSE").read_bytes())

    def test_notes_are_those_of_the_version(self):
        notes = (self.once / f"ccdt-{VERSION}-notes.md").read_text()
        section = (ROOT / "CHANGELOG.md").read_text().split(f"\n## [{VERSION}]")[1].split("\n## ")[0]
        self.assertEqual(notes.strip(), section.partition("\n")[2].strip())

    def test_bill_matches_its_schema(self):
        if not SCHEMAS.exists():
            self.skipTest("tests/deploy/install has not run")
        schemas = {path.name: json.loads(path.read_text()) for path in SCHEMAS.glob("*.schema.json")}
        schema = schemas["bom-1.5.SNAPSHOT.schema.json"]
        resolver = jsonschema.RefResolver(schema["$id"], schema, {
            f"http://cyclonedx.org/schema/{name}": content for name, content in schemas.items()})
        validator = Validator(schema, resolver=resolver)
        validator.validate(self.bill())
        wrong = self.bill()
        wrong["components"][0]["licenses"] = [{"license": {"id": "Expat"}}]
        self.assertFalse(validator.is_valid(wrong))

    def bill(self):
        return json.loads((self.once / f"ccdt-{VERSION}.cdx.json").read_text())

    def test_bill_lists_packages_of_image_and_build(self):
        bill = self.bill()
        self.assertEqual((bill["metadata"]["component"]["name"], bill["metadata"]["component"]["version"]),
                         ("ccdt", VERSION))
        components = {component["name"]: component for component in bill["components"]}
        self.assertEqual(len(components), len(bill["components"]))
        for name, scope in (("libopenimageio2.4", "required"), ("fonts-dejavu-core", "required"),
                            ("libcgal-dev", "required"), ("gemmi-dev", "required"), ("cmake", "excluded"),
                            ("ninja-build", "excluded")):
            self.assertEqual(components[name]["scope"], scope, name)
        self.assertNotIn("libgtest-dev", components)
        listed = execute([ROOT / "docker" / "packages", "build", "package", "site"], capture_output=True, text=True,
                         check=True).stdout
        self.assertLessEqual(set(listed.split()), set(components))
        self.assertIn({"license": {"id": "Zlib"}}, components["zlib1g"]["licenses"])


class Scripts(unittest.TestCase):
    """The scripts that list packages for the bill of materials."""

    def run_script(self, name, *arguments, **options):
        done = execute([ROOT / "docker" / name, *arguments], capture_output=True, text=True, check=False, **options)
        return done.returncode, done.stdout, done.stderr

    def test_owners_need_files_that_exist(self):
        self.assertEqual(self.run_script("owners", "/etc/debian_version", "/usr/bin/env"),
                         (0, "base-files\ncoreutils\n", ""))
        for files, text in ((("/usr/bin/env", "/usr/bin/snowflake"), "/usr/bin/snowflake"), ((), "missing operand")):
            status, names, error = self.run_script("owners", *files)
            self.assertEqual((status, names), (1, ""))
            self.assertIn(text, error)

    def test_a_bill_needs_packages(self):
        arguments = ("sbom", "thing", "application", "")
        status, bill, _ = self.run_script(*arguments, input="coreutils excluded\n")
        self.assertEqual((status, [part["name"] for part in json.loads(bill)["components"]]), (0, ["coreutils"]))
        for text in ("", "\n"):
            self.assertEqual(self.run_script(*arguments, input=text),
                             (1, "", "docker/sbom: the input names no package\n"))


class Refusals(unittest.TestCase):
    """docker/release in a small repository of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name) / "checkout"
        self.out = pathlib.Path(folder.name) / "out"
        (self.root / "docker").mkdir(parents=True)
        shutil.copy(ROOT / "docker" / "release", self.root / "docker")
        (self.root / "CMakeLists.txt").write_text("project(ccdt VERSION 3.2.1 LANGUAGES CXX)\n")
        self.write_changelog("3.2.1")
        git("init", "--quiet", root=self.root)
        git("add", ".", root=self.root)
        git("-c", "user.name=nobody", "-c", "user.email=nobody@example.org", "commit", "--quiet", "--message=all",
            root=self.root)

    def write_changelog(self, version):
        (self.root / "CHANGELOG.md").write_text(
            "# Changelog\n\n## [Unreleased]\n\n- Later.\n\n"
            f"## [{version}] - 2026-01-05\n\n- Now.\n\n## [0.1.0] - 2026-01-04\n\n- Once.\n")

    def fails(self, *arguments, status=1):
        done = release(*arguments, root=self.root)
        self.assertEqual(done.returncode, status, done.stdout)
        return done.stdout

    def test_notes_are_one_section_of_the_changelog(self):
        self.assertEqual(release(self.out, "notes", root=self.root).returncode, 0)
        self.assertEqual((self.out / "ccdt-3.2.1-notes.md").read_text(), "- Now.\n\n")

    def test_replaces_an_earlier_release(self):
        for parts in (("notes", "source"), ("notes",)):
            self.assertEqual(release(self.out, *parts, root=self.root).returncode, 0)
        self.assertEqual(sorted(path.name for path in self.out.iterdir()), ["SHA256SUMS", "ccdt-3.2.1-notes.md"])

    def test_keeps_other_files(self):
        for earlier in (False, True):
            with self.subTest(earlier=earlier):
                if earlier:
                    (self.out / "letter").unlink()
                    self.assertEqual(release(self.out, "notes", root=self.root).returncode, 0)
                self.out.mkdir(exist_ok=True)
                (self.out / "letter").write_text("dear")
                self.assertIn(f"{self.out} contains files that do not belong to a release:\nletter\n",
                              self.fails(self.out, "notes"))
                self.assertEqual((self.out / "letter").read_text(), "dear")

    def test_needs_a_section_in_the_changelog(self):
        self.write_changelog("3.2.10")
        self.assertIn("CHANGELOG.md has no section for version 3.2.1", self.fails(self.out, "notes"))

    def test_needs_known_options(self):
        for arguments in (("--help",), ("--build",)):
            self.assertIn("usage: docker/release", self.fails(*arguments, status=2))

    def test_needs_known_parts(self):
        self.assertRegex(self.fails(self.out, "image", "snowflake"), "no part snowflake; there are: .*source")
        self.assertFalse(self.out.exists())

    def test_builds_all_parts_only_from_a_commit(self):
        (self.root / "draft.cpp").write_text("\n")
        self.assertIn("?? draft.cpp", self.fails(self.out))
        self.assertFalse(self.out.exists())


if __name__ == "__main__":
    unittest.main(verbosity=2)
