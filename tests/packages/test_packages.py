# SPDX-License-Identifier: GPL-3.0-or-later
"""Debian packages: their contents, and their use on a bare Debian 12 that systemd has booted."""

import contextlib
import datetime
import gzip
import hashlib
import io
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tarfile
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "integration"))
from harness import (  # pylint: disable=wrong-import-position
    PICTURES, TOOLS, Server, ask, descendants, execute, wait_until)

HERE = pathlib.Path(__file__).parent
BUILD = pathlib.Path(os.environ["CCDT_BUILD"])
PICTURE = (PICTURES / "camera.png").read_bytes()
STATE = "/var/lib/ccdt-server"
DEFAULTS = "/etc/default/ccdt-server"
KEYS = "/etc/ccdt.keys"

# Time limit of a step that installs packages, in seconds.
PATIENCE_TO_INSTALL = 300

# The highest accepted exposure of the unit, by `systemd-analyze security`: from 0 to 10.
MAX_EXPOSURE = 2.1

# Maps the name of each package to the packages of this project that it needs.
NEEDED = {"ccdt": ["ccdt-decoder"], "ccdt-decoder": [], "ccdt-server": ["ccdt-decoder"], "libccdt-dev": ["libccdt2"],
          "libccdt2": [], "python3-ccdt": []}

# Maps the name of each package to its file.
PACKAGES = {}

ENVIRONMENT = {"HOME": "/root", "LANG": "C.UTF-8", "DEBIAN_FRONTEND": "noninteractive",
               "PATH": "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"}


@contextlib.contextmanager
def timed(what):
    """Prints the duration of a step."""
    start = time.monotonic()
    yield
    print(f"{what}: {time.monotonic() - start:.1f} s", file=sys.stderr)


def make_packages(folder, **environment):
    """Makes the packages from the build, and returns their files. Compresses them by gzip, which is faster than xz."""
    done = execute([os.environ["CCDT_CPACK"], "--config", BUILD / "CPackConfig.cmake", "-B", folder,
                    "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=gzip"], PATIENCE_TO_INSTALL,
                   capture_output=True, text=True, check=False, env={**os.environ, **environment})
    if done.returncode != 0:
        raise AssertionError(f"cpack exited with {done.returncode}:\n{done.stdout}{done.stderr}")
    return sorted(pathlib.Path(folder).glob("*.deb"))


def field(package, name):
    return execute(["dpkg-deb", "--field", package, name], check=True, capture_output=True, text=True).stdout.strip()


def digests(packages):
    return {package.name: hashlib.sha256(package.read_bytes()).hexdigest() for package in packages}


def bare_debian():
    """Returns the archive of a bare Debian 12, which is created once a day."""
    archive = TOOLS / f"debian-{datetime.date.today()}.tar"
    if not archive.exists():
        for old in TOOLS.glob("debian-*.tar"):
            old.unlink()
        TOOLS.mkdir(parents=True, exist_ok=True)
        folder = pathlib.Path("/etc/apt")
        sources = [*folder.glob("sources.list"), *folder.glob("sources.list.d/*.sources")]
        new = archive.with_suffix(".new.tar")
        execute(["mmdebstrap", "--quiet", "--variant=minbase", "--include=ca-certificates,systemd", "bookworm", new,
                 *sources], PATIENCE_TO_INSTALL, check=True)
        new.rename(archive)
    return archive


class Machine:
    """A bare Debian 12 that systemd has booted in namespaces without a network. The packages are in its /root."""

    def __init__(self, packages):
        archive = bare_debian()
        self.folder = tempfile.TemporaryDirectory()
        self.log = tempfile.TemporaryFile("w+")
        self.process = subprocess.Popen(  # pylint: disable=consider-using-with
            [HERE / "boot", archive, self.folder.name, *packages], stderr=self.log, start_new_session=True)
        try:
            self.manager = wait_until(self.find_manager, "the start of systemd")
            if self.process.poll() is None:
                wait_until(lambda: self.run("systemctl", "is-system-running", "--wait", check=False) == "running",
                           "the end of the boot")
        except BaseException:
            self.close()
            raise

    def errors(self):
        """Returns the messages of the boot, which has ended."""
        self.log.seek(0)
        return self.log.read()

    def find_manager(self):
        """Returns the process of systemd; -1 if the machine has ended."""
        if self.process.poll() is not None:
            return -1
        with contextlib.suppress(OSError):
            for process in descendants(self.process.pid):
                if pathlib.Path(f"/proc/{process}/comm").read_text() == "systemd\n":
                    return process
        return None

    def run(self, *command, check=True, **options):
        """Runs a command in the machine, and returns its output."""
        done = execute(["nsenter", f"--target={self.manager}", "--all", *command], PATIENCE_TO_INSTALL, text=True,
                       check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=ENVIRONMENT, **options)
        if check and done.returncode != 0:
            raise AssertionError(f"{command} exited with {done.returncode}:\n{done.stdout}")
        return done.stdout.strip()

    def file(self, path):
        """Returns the path by which this process sees a file of the machine."""
        return pathlib.Path(f"/proc/{self.manager}/root{path}")

    def ask(self, path, *arguments, data=None):
        """Sends a request to the server in the machine by the curl of this machine, and returns the body."""
        sent = ["--data-binary", "@-"] if data else []
        return execute(["nsenter", f"--target={self.manager}", "--net", "curl", "--silent", "--show-error",
                        "--fail-with-body", "--max-time", "60", *arguments, *sent, f"http://127.0.0.1:8080{path}"],
                       input=data, stdout=subprocess.PIPE, check=True).stdout

    def main_process(self):
        return int(self.run("systemctl", "show", "--property=MainPID", "--value", "ccdt-server"))

    def journal(self):
        return self.run("journalctl", "--no-pager", "--output=cat", "--unit=ccdt-server")

    def close(self):
        # During the preparations for the boot, there are other processes in the same group.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        self.log.close()
        self.folder.cleanup()
        # The control groups can be removed as soon as the kernel has ended their processes.
        wait_until(lambda: execute(["find", "/sys/fs/cgroup", "-depth", "-path", f"*/ccdt-packages-{self.process.pid}*",
                                    "-type", "d", "-exec", "rmdir", "{}", "+"], stderr=subprocess.DEVNULL,
                                   check=False).returncode == 0, "the removal of the control groups")


def setUpModule():  # pylint: disable=invalid-name
    folder = tempfile.TemporaryDirectory()
    unittest.addModuleCleanup(folder.cleanup)
    with timed("cpack"):
        PACKAGES.update({field(package, "Package"): package for package in make_packages(folder.name)})


class Packages(unittest.TestCase):

    def test_are_the_same_bytes_in_another_environment(self):
        with tempfile.TemporaryDirectory() as folder:
            with timed("cpack again"):
                again = make_packages(folder, TZ="Asia/Tokyo", LC_ALL="C", SOURCE_DATE_EPOCH="")
            self.assertEqual(digests(again), digests(PACKAGES.values()))

    def test_lintian_finds_no_fault(self):
        with timed("lintian"):
            # Only the preset `package` installs libraries in the folder of the architecture.
            done = execute(["lintian", "--allow-root", "--fail-on=error,warning", "--tag-display-limit=0",
                            "--suppress-tags=pkg-config-unavailable-for-cross-compilation", *PACKAGES.values()],
                           PATIENCE_TO_INSTALL, capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout), (0, ""), done.stderr)

    def test_contain_documents_without_links_to_files_of_the_source(self):
        for name, package in PACKAGES.items():
            archive = execute(["dpkg-deb", "--fsys-tarfile", package], check=True, capture_output=True).stdout
            with tarfile.open(fileobj=io.BytesIO(archive)) as files:
                texts = {member.name: gzip.decompress(files.extractfile(member).read()).decode()
                         for member in files if member.name.endswith(".md.gz")}
            with self.subTest(package=name):
                self.assertTrue(texts)
                links = re.findall(r"\]\((?!#|https?:)([^)]+)\)", "".join(texts.values()))
                self.assertEqual(links, [])

    def test_depend_on_each_other_by_the_same_version(self):
        self.assertEqual(set(PACKAGES), set(NEEDED))
        for name, package in PACKAGES.items():
            needed = re.findall(r"(\S*ccdt\S*) \((.*?)\)", field(package, "Depends"))
            with self.subTest(package=name):
                self.assertEqual(needed, [(other, f"= {field(package, 'Version')}") for other in NEEDED[name]])


@unittest.skipIf(os.geteuid() != 0, "installing packages in a bare Debian needs root")
class Installed(unittest.TestCase):
    """The life of the packages. Each step needs the steps before."""

    def test_install_use_upgrade_remove_purge(self):
        with timed("bare Debian, with downloads of apt"):
            self.machine = Machine(PACKAGES.values())
        self.addCleanup(self.machine.close)
        if self.machine.process.poll() == 77:
            self.skipTest(f"systemd cannot be booted here: {self.machine.errors()}")
        if self.machine.process.poll() is not None:
            self.fail(f"the boot failed: {self.machine.errors()}")
        with timed("install"):
            self.install()
        self.check_unit()
        self.check_settings()
        self.check_use()
        with timed("upgrade"):
            self.check_upgrade()
        self.check_restart()
        with timed("removal"):
            self.check_removal()

    def install(self):
        self.machine.run("sh", "-c", "apt-get -qq install --yes --no-install-recommends /root/*.deb")

    def wait_until_active(self):
        wait_until(lambda: self.machine.run("systemctl", "is-active", "ccdt-server", check=False) == "active",
                   "the start of the unit")

    def layers(self, text):
        return set(re.search(r"in force: ([^;\n]*)", text)[1].split(", "))

    def check_unit(self):
        self.wait_until_active()
        self.assertEqual(self.machine.run("systemctl", "is-enabled", "ccdt-server"), "enabled")
        self.assertEqual(self.machine.run("systemd-analyze", "verify", "--man=no", "ccdt-server.service"), "")
        exposure = self.machine.run("systemd-analyze", "security", "--no-pager", "ccdt-server.service")
        print(exposure.splitlines()[-1], file=sys.stderr)
        self.assertLessEqual(float(re.search(r"exposure level .*: ([0-9.]+)", exposure)[1]), MAX_EXPOSURE)
        # The restrictions of the unit take away no layer of the decoders' sandbox.
        unrestricted = self.machine.run("setpriv", "--reuid=ccdt", "--regid=ccdt", "--clear-groups", "ccdt-server",
                                        "--check", "--port=0")
        self.assertEqual(self.layers(self.machine.journal()), self.layers(unrestricted))
        self.assertNotIn("arning", self.machine.journal())

    def check_settings(self):
        """Compares the variables of the file of settings with those that the server knows, and sets one."""
        text = self.machine.file(DEFAULTS).read_text()
        known = re.findall(r"^  --\S+ +[A-Z]+ +([A-Z_]+) ", self.machine.run("ccdt-server", "--help"), re.MULTILINE)
        self.assertIn("CCDT_MAX_SITES", known)
        self.assertEqual(re.findall(r"^#([A-Z_]+)=$", text, re.MULTILINE), known)
        self.machine.file(DEFAULTS).write_text(text.replace("#CCDT_API_KEY_FILE=", f"CCDT_API_KEY_FILE={KEYS}"))
        self.machine.file(KEYS).write_text("tester:0123456789abcdef\n")
        self.machine.run("systemctl", "restart", "ccdt-server")
        self.machine.run("systemctl", "reload", "ccdt-server")
        wait_until(lambda: "keys were reloaded" in self.machine.journal(), "the reload")
        self.key = ("--header", "Authorization: Bearer 0123456789abcdef")

    def check_use(self):
        """Compares the answers of the server, of the command and of the module to those of the build's server."""
        with Server() as server:
            expected = ask(server, "/halftone?sites=500", data=PICTURE).body
        self.assertEqual(self.machine.ask("/halftone?sites=500", *self.key, data=PICTURE), expected)
        self.assertEqual(self.machine.run("stat", "--format=%U %a", STATE), "ccdt 700")
        self.machine.file("/root/photo.png").write_bytes(PICTURE)
        self.machine.run("ccdt", "halftone", "/root/photo.png", "-o", "/root/command.png", "--sites=500")
        self.machine.run("python3", "-c", "import ccdt\n"
                         "ccdt.halftone('/root/photo.png', sites=500).save('/root/module.png')")
        for name in ("command.png", "module.png"):
            self.assertEqual(self.machine.file(f"/root/{name}").read_bytes(), expected, name)
        self.machine.run("python3", "-c", "import ctypes\nctypes.CDLL('libccdt.so.2')\nctypes.CDLL('libccdt-api.so.2')")

    def check_upgrade(self):
        """Upgrades the packages to themselves, which restarts the server. Jobs and settings survive."""
        job = json.loads(self.machine.ask("/halftone", *self.key, "--header", "Prefer: respond-async", data=PICTURE))
        settings = self.machine.file(DEFAULTS).read_text()
        before = self.machine.main_process()
        self.machine.run("sh", "-c", "dpkg --install /root/*.deb")
        self.wait_until_active()
        self.assertNotEqual(self.machine.main_process(), before)
        self.assertEqual(self.machine.file(DEFAULTS).read_text(), settings)
        path = f"/jobs/{job['id']}"
        wait_until(lambda: json.loads(self.machine.ask(path, *self.key))["status"] == "succeeded", "the job")
        self.assertEqual(self.machine.ask(path + "/result", *self.key)[:4], b"\x89PNG")

    def check_restart(self):
        killed = self.machine.main_process()
        self.machine.run("systemctl", "kill", "--kill-whom=main", "--signal=KILL", "ccdt-server")
        wait_until(lambda: self.machine.main_process() not in (0, killed), "the restart")
        self.wait_until_active()

    def check_removal(self):
        self.machine.run("apt-get", "-qq", "remove", "--yes", *PACKAGES)
        self.assertEqual(self.machine.run("sh", "-c", "grep -ls ccdt /proc/[0-9]*/comm", check=False), "", "processes")
        self.assertEqual(self.machine.run("find", "/usr", "-name", "*ccdt*"), "")
        for kept in (DEFAULTS, f"{STATE}/jobs.sqlite"):
            self.assertTrue(self.machine.file(kept).exists(), f"{kept} must survive the removal")
        # dpkg has forgotten the other packages, which have neither settings nor a script for their purge.
        self.machine.run("apt-get", "-qq", "purge", "--yes", "ccdt-server", "libccdt2")
        self.machine.run("sh", "-c", f"rm /root/*.* {KEYS}")
        self.assertEqual(self.machine.run("find", "/", "-xdev", "-name", "*ccdt*", "-o", "-xdev", "-user", "ccdt"), "")
        # Debian keeps system users, because files may belong to them.
        mentions = self.machine.run("grep", "--recursive", "--files-with-matches", "ccdt", "/etc").split()
        self.assertEqual({name.rstrip("-") for name in mentions},
                         {f"/etc/{name}" for name in ("group", "gshadow", "passwd", "shadow")})
        self.assertEqual(self.machine.run("systemctl", "list-units", "--all", "--quiet", "*ccdt*"), "")


if __name__ == "__main__":
    unittest.main(verbosity=2)
