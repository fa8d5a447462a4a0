# SPDX-License-Identifier: GPL-3.0-or-later
"""The contents of the container image, whatever program built it."""

import json
import os
import pathlib
import re

from harness import DATA, PICTURES, ask, execute, post_json

PROGRAMS = ("ccdt-decoder", "ccdt-server", "ccdt-worker")
FOLDER = pathlib.Path(os.environ["CCDT_SERVER"]).parent

BASE = "debian:12-slim"
MAX_BYTES = 420_000_000
EPOCH = "1767225600"
VERSION = "1.2.3"
REVISION = "abc"


def strip_programs(folder):
    """Writes the programs under test, without symbols, to a new folder."""
    folder.mkdir()
    for name in PROGRAMS:
        execute(["strip", "-o", folder / name, FOLDER / name], check=True)


class ImageContents:
    """Tests of an image of VERSION and REVISION with the times of EPOCH.

    Test cases inherit this class and set `files` (the files of the image as a tar archive), `size` in bytes, and
    `config` (what the program starts with, as in the configuration of an image for Docker).
    """

    def read(self, path):
        return self.files.extractfile(path).read()

    def test_is_no_larger_than_documented(self):
        self.assertLess(self.size, MAX_BYTES)

    def test_has_its_settings(self):
        self.assertEqual(self.config["User"], "10001:10001")
        self.assertEqual(self.config["Entrypoint"], ["/usr/local/bin/ccdt-server"])
        self.assertEqual(self.config["Healthcheck"]["Test"], ["CMD", "/usr/local/bin/ccdt-server", "--health"])
        labels = {name.removeprefix("org.opencontainers.image."): value for name, value in self.config["Labels"].items()
                  if name.startswith("org.opencontainers.image.")}
        self.assertEqual((labels["title"], labels["version"], labels["revision"], labels["base.name"]),
                         ("ccdt-server", VERSION, REVISION, BASE))

    def test_has_no_other_programs(self):
        executable = [entry.name for entry in self.files if entry.isfile() and entry.mode & 0o111]
        self.assertEqual(sorted(name for name in executable if "/lib" not in name),
                         [f"usr/local/bin/{name}" for name in PROGRAMS])
        self.assertTrue(all(re.search(r"\.so(\.|$)", name) for name in executable if "/lib" in name))
        self.assertFalse([entry.name for entry in self.files if entry.mode & 0o6000], "set-user-id")

    def test_contains_no_build_time(self):
        made_by_podman = ("etc/hosts", "etc/hostname", "etc/resolv.conf", "dev", "proc", "sys", "run", "etc")
        times = {entry.mtime for entry in self.files if not entry.name.startswith(made_by_podman) and entry.name}
        self.assertEqual(times, {int(EPOCH)})

    def test_lists_its_packages(self):
        bill = json.loads(self.read("usr/share/ccdt/sbom.cdx.json"))
        self.assertEqual((bill["bomFormat"], bill["specVersion"]), ("CycloneDX", "1.5"))
        listed = {component["name"]: component["version"] for component in bill["components"]}
        self.assertEqual(len(listed), len(bill["components"]))
        for component in bill["components"]:
            self.assertRegex(component["purl"],
                             r"^pkg:deb/debian/[a-z0-9.%B-]+@[^ @:+]+\?arch=[a-z0-9]+&distro=debian-12$")
        folder = "var/lib/dpkg/status.d/"
        installed = {entry.name.removeprefix(folder):
                     re.search("^Version: (.*)$", self.read(entry.name).decode(), re.M)[1]
                     for entry in self.files if entry.isfile() and entry.name.startswith(folder)}
        self.assertEqual(installed, listed)
        for name in ("libc6", "libopenimageio2.4", "libsqlite3-0", "fonts-dejavu-core", "ca-certificates"):
            self.assertIn(name, listed)
            self.assertTrue(self.read(f"usr/share/doc/{name}/copyright"))
        for tool in ("bash", "dash", "curl", "apt", "coreutils"):
            self.assertNotIn(tool, listed)
        self.assertEqual([name for name in listed if name.startswith("fonts-")], ["fonts-dejavu-core"])

    def test_has_ca_certificates(self):
        certificates = self.read("usr/lib/ssl/cert.pem").decode()
        self.assertGreater(certificates.count("BEGIN CERTIFICATE"), 100)
        for path in pathlib.Path("/usr/local/share/ca-certificates").rglob("*.crt"):
            self.assertNotIn(path.read_text().strip(), certificates, "a certificate of this machine only")

    def compare_answers(self, outside, inside):
        """Checks that a server in the image gives the same bytes as a server of the programs under test."""
        picture = (PICTURES / "camera.png").read_bytes()
        points = (DATA / "analysis" / "torus.json").read_bytes()
        domain = {"type": "rectangle", "width": 1, "height": 1}

        def answers(server):
            return [ask(server, "/halftone?sites=500&scale=1", data=picture),
                    post_json(server, "/sample", {"sites": 100, "domain": domain}, "--header", "Accept: text/csv"),
                    ask(server, "/analyze", "--header", "Accept: image/png", data=points)]

        for here, there in zip(answers(outside), answers(inside)):
            self.assertEqual((here.status, there.status), (200, 200))
            self.assertEqual(here.body, there.body)
