# SPDX-License-Identifier: GPL-3.0-or-later
"""The archive of the container image: its contents, and its service without a container engine."""

import hashlib
import json
import os
import pathlib
import shlex
import shutil
import sys
import tarfile
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "integration"))

from harness import ROOT, Server, execute  # pylint: disable=wrong-import-position
from image_contents import (  # pylint: disable=wrong-import-position
    EPOCH, FOLDER, REVISION, VERSION, ImageContents, strip_programs)
from raw import SANITIZED  # pylint: disable=wrong-import-position


def collect(stage, programs, umask=0o022):
    """Creates a stage that contains the root folder of an image."""
    (stage / "image").mkdir(parents=True)
    execute([ROOT / "docker" / "collect", stage / "image", *programs], check=True, umask=umask,
            env={**os.environ, "SOURCE_DATE_EPOCH": EPOCH})


def write_archive(stage, path, **environment):
    with path.open("wb") as file:
        execute([sys.executable, ROOT / "docker" / "image_archive.py", stage, VERSION, REVISION], check=True,
                stdout=file, env={**os.environ, "SOURCE_DATE_EPOCH": EPOCH, **environment})


@unittest.skipIf(os.geteuid() != 0, "only root may make files of another user")
class ImageArchive(ImageContents, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if SANITIZED:
            raise unittest.SkipTest("sanitizers need more than the image has")
        folder = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, folder)
        strip_programs(folder / "programs")
        collect(folder / "stage", sorted((folder / "programs").iterdir()))
        cls.archive = folder / "image.tar"
        write_archive(folder / "stage", cls.archive)
        shutil.rmtree(folder / "stage")
        with tarfile.open(cls.archive) as archive:
            [cls.manifest] = json.load(archive.extractfile("manifest.json"))
            cls.settings = archive.extractfile(cls.manifest["Config"]).read()
            [layer] = cls.manifest["Layers"]
            archive.extract(layer, folder)
        cls.layer = folder / layer
        cls.files = cls.enterClassContext(tarfile.open(cls.layer))
        cls.size = cls.layer.stat().st_size
        cls.config = json.loads(cls.settings)["config"]
        cls.root = folder / "root"
        cls.root.mkdir()
        execute(["tar", "--extract", "--preserve-permissions", "--numeric-owner", "--file", cls.layer, "--directory",
                 cls.root], check=True)
        cls.program = folder / "run"
        cls.program.write_text(cls.script())
        cls.program.chmod(0o755)

    @classmethod
    def script(cls):
        """Returns a script that starts the program in the files of the image, with the image's user and environment."""
        for name in ("dev", "proc"):  # container engines create these folders
            (cls.root / name).mkdir()
        enter = ["chroot", f"--userspec={cls.config['User']}", "--groups=", str(cls.root), *cls.config["Entrypoint"]]
        return (f'#!/bin/sh\nROOT={shlex.quote(str(cls.root))} exec unshare --mount sh -euc \'\n'
                'mount --bind --read-only "$ROOT" "$ROOT"\nmount -t proc proc "$ROOT/proc"\n'
                'mount --rbind /dev "$ROOT/dev"\nmount -t tmpfs -o uid=10001 volume "$ROOT/data"\n'
                f'exec env -i {shlex.join(cls.config["Env"])} {shlex.join(enter)} "$@"\' sh "$@"\n')

    def test_digests_are_those_of_the_contents(self):
        self.assertEqual(self.manifest["RepoTags"], [f"ccdt-server:{VERSION}", "ccdt-server:latest"])
        self.assertEqual(self.manifest["Config"], f"{hashlib.sha256(self.settings).hexdigest()}.json")
        with self.layer.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
        self.assertEqual(json.loads(self.settings)["rootfs"]["diff_ids"], [f"sha256:{digest}"])

    def test_is_read_by_skopeo(self):
        done = execute(["skopeo", "inspect", f"docker-archive:{self.archive}"], capture_output=True, check=True)
        image = json.loads(done.stdout)
        self.assertEqual((image["Os"], image["Labels"]["org.opencontainers.image.version"]), ("linux", VERSION))
        self.assertIn("PORT=8080", image["Env"])

    def test_data_belongs_to_its_user(self):
        entry = self.files.getmember("data")
        self.assertEqual((entry.uid, entry.gid, entry.mode & 0o7777), (10001, 10001, 0o755))
        self.assertEqual({entry.uid for entry in self.files if entry.name != "data"}, {0})

    def require_mounts(self):
        if execute(["unshare", "--mount", "true"], capture_output=True, check=False).returncode != 0:
            self.skipTest("this machine allows no mount namespaces")

    def test_answers_like_the_programs_outside(self):
        self.require_mounts()
        with Server() as outside, Server("--bind=127.0.0.1", program=self.program) as inside:
            self.compare_answers(outside, inside)
            health = execute([self.program, "--health", f"--port={inside.port}"], capture_output=True, check=False)
            self.assertEqual(health.returncode, 0, health.stderr)
            self.assertEqual(inside.stop(), 0)

    def test_stores_jobs_in_a_volume(self):
        self.require_mounts()
        checked = execute([self.program, "--check", "--data-dir=/data"], capture_output=True, text=True, check=False)
        self.assertNotIn("WRONG", checked.stdout)
        self.assertRegex(checked.stdout, r"jobs +good +stored in /data")


@unittest.skipIf(os.geteuid() != 0, "only root may make files of another user")
class Again(unittest.TestCase):
    def test_gives_the_same_bytes_again(self):
        digests = []
        with tempfile.TemporaryDirectory() as folder:
            for name, umask, zone in (("once", 0o022, "UTC"), ("again", 0o077, "Asia/Kolkata")):
                stage = pathlib.Path(folder) / name
                collect(stage, [FOLDER / "ccdt-worker"], umask)
                write_archive(stage, stage / "image.tar", TZ=zone)
                digests.append(hashlib.sha256((stage / "image.tar").read_bytes()).hexdigest())
        self.assertEqual(digests[0], digests[1])


if __name__ == "__main__":
    unittest.main(verbosity=2)
