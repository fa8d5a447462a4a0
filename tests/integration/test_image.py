# SPDX-License-Identifier: GPL-3.0-or-later
"""The container image: its contents, and its service with only the documented rights. Skipped if no container can be
run."""

import io
import json
import os
import pathlib
import shutil
import tarfile
import tempfile
import unittest

from harness import PATIENCE, ROOT, Server, execute
from image_contents import BASE, EPOCH, REVISION, VERSION, ImageContents, strip_programs
from raw import SANITIZED

IMAGE = "ccdt-server:test"

# Uses the network of the machine, since podman may lack what it needs for a network of its own.
RUN = ("--rm", "--network=host", "--no-healthcheck", "--ulimit=nofile=4096:4096", "--ulimit=nproc=4096:4096",
       "--read-only", "--cap-drop=ALL", "--security-opt=no-new-privileges")


def podman(*arguments, check=True):
    runtime = ("--runtime=runc",) if shutil.which("runc") else ()
    done = execute(["podman", *runtime, *arguments], 2 * PATIENCE, capture_output=True, check=False)
    if check and done.returncode != 0:
        raise AssertionError(f"podman {arguments[0]} failed:\n{done.stderr.decode()[-3000:]}")
    return done


def why_not():
    """Returns the reason why no image can be tested; empty if tests are possible."""
    if shutil.which("podman") is None:
        return "podman is missing"
    if SANITIZED:
        return "sanitizers need more than the image has"
    if podman("image", "exists", BASE, check=False).returncode != 0 and \
            podman("pull", "--quiet", f"docker.io/library/{BASE}", check=False).returncode != 0:
        return f"{BASE} is neither here nor to be had"
    tried = podman("run", *RUN, BASE, "true", check=False)
    return "" if tried.returncode == 0 else f"no container can be run: {tried.stderr.decode().strip()[-200:]}"


def build():
    """Builds the image from the programs under test: a folder with these programs replaces the stage that compiles."""
    with tempfile.TemporaryDirectory() as folder:
        strip_programs(pathlib.Path(folder) / "programs")
        podman("build", "--network=host", "--format=docker", "--file", ROOT / "docker" / "Dockerfile", "--tag", IMAGE,
               "--build-context", f"build={folder}", "--build-arg", f"SOURCE_DATE_EPOCH={EPOCH}",
               "--build-arg", f"VERSION={VERSION}", "--build-arg", f"REVISION={REVISION}", ROOT)


class Image(ImageContents, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if reason := why_not():
            raise unittest.SkipTest(reason)
        build()
        settings = json.loads(podman("image", "inspect", IMAGE).stdout)[0]
        cls.size = settings["Size"]
        cls.config = {**settings["Config"], "Healthcheck": settings["Healthcheck"]}
        container = podman("create", "--no-healthcheck", IMAGE).stdout.decode().strip()
        try:
            cls.files = tarfile.open(fileobj=io.BytesIO(podman("export", container).stdout))
        finally:
            podman("rm", container)
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.name = f"ccdt-test-{os.getpid()}"
        cls.program = pathlib.Path(folder.name) / "run"
        runtime = "--runtime=runc" if shutil.which("runc") else ""
        cls.program.write_text(
            f'#!/bin/sh\nexec podman {runtime} run --name={cls.name} {" ".join(RUN)} {IMAGE} "$@"\n')
        cls.program.chmod(0o755)

    def test_answers_like_the_programs_outside(self):
        with Server() as outside, Server(program=self.program) as inside:
            self.compare_answers(outside, inside)
            result = podman("exec", self.name, "/usr/local/bin/ccdt-server", "--health", f"--port={inside.port}",
                           check=False)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("by user 10001; in force: no root, no capabilities",
                          inside.wait_for_log("are decoded by user"))
            self.assertIn("system call filter", inside.log())
            self.assertEqual(inside.stop(), 0)

    def test_passes_its_own_check(self):
        checked = podman("run", *RUN, IMAGE, "--check")
        self.assertNotIn(b"WRONG", checked.stdout)
        self.assertIn(b"BIND", checked.stdout)

    def test_stores_jobs_in_a_volume(self):
        checked = podman("run", *RUN, "--volume=/data", IMAGE, "--check", "--data-dir=/data").stdout.decode()
        self.assertRegex(checked, r"jobs +good +stored in /data")


class Collected(unittest.TestCase):
    """The result of docker/collect."""

    def setUp(self):
        if os.geteuid() != 0:
            self.skipTest("only root may make files of another user")
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_fails_if_a_library_is_missing(self):
        program = self.folder / "program"
        library = self.folder / "libnowhere.so"
        compiler = ["cc", "-shared", "-x", "c", "/dev/null", "-o", library]
        execute(compiler, check=True)
        (self.folder / "main.c").write_text("int main(void) { return 0; }\n")
        execute(["cc", self.folder / "main.c", "-Wl,--no-as-needed", library, "-o", program], check=True)
        library.unlink()
        root = self.folder / "root"
        root.mkdir()
        done = execute([ROOT / "docker" / "collect", root, program], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("libnowhere.so => not found", done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
