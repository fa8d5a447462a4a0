# SPDX-License-Identifier: GPL-3.0-or-later
"""GET /: the page, over HTTP."""

import gzip
import pathlib
import re
import tempfile
import unittest

from harness import ROOT, Server, ServerCase, ask

SITE = ROOT / "server" / "page" / "site"


def path_of(file):
    name = file.relative_to(SITE).as_posix()
    return "/" if name == "index.html" else "/assets/" + name


FILES = {path_of(file): file.read_bytes() for file in SITE.rglob("*") if file.is_file()}


def loaded_first():
    """Returns the files that a browser loads with the page, before any file that a script imports later."""
    loaded, waiting = set(), ["/"]
    while waiting:
        path = waiting.pop()
        if path in loaded:
            continue
        loaded.add(path)
        names = re.findall(rb'<(?:script|link)[^>]* (?:src|href)="([^"]+)"', FILES[path]) if path == "/" else []
        if path.endswith(".js"):
            names = [b"/assets/" + name for name in re.findall(rb' from "\./([^"]+)"', FILES[path])]
        waiting += [name.decode() for name in names]
    return loaded


class Page(ServerCase):
    flags = ("--cors-origin=https://a.example",)

    def test_serves_all_files(self):
        self.assertGreater(len(FILES), 10)
        for path, content in FILES.items():
            answer = self.ask(path)
            self.assertEqual((answer.status, answer.body), (200, content), path)
            self.assertEqual(answer.headers["x-content-type-options"], "nosniff")
            self.assertEqual(answer.headers["cache-control"], "no-cache")

    def test_refers_only_to_existing_files(self):
        for path, content in FILES.items():
            if path.endswith((".js", "/")):
                for name in re.findall(rb'(?:src|href)="([^"]+)"', content):
                    if name != b"/docs/":  # only if the server has a folder of documentation
                        self.assertIn(name.decode(), FILES, path)
                for name in re.findall(rb'(?:from |await import\()"\./([^"]+)"', content):
                    self.assertIn("/assets/" + name.decode(), FILES, path)

    def test_refers_to_no_other_host(self):
        for path, content in FILES.items():
            if not path.endswith(".jpg"):
                hosts = set(re.findall(rb"https?://[^\s\"'`)]+", content)) - {b"http://www.w3.org/2000/svg"}
                self.assertEqual(hosts, set(), path)

    def test_is_small(self):
        own = {path: content for path, content in FILES.items() if not path.startswith("/assets/samples/")}
        packed = {path: len(gzip.compress(content)) for path, content in own.items()}
        # Other pages load the element and the module that it imports.
        self.assertLess(packed["/assets/element.js"] + packed["/assets/connection.js"], 9_600)
        # The page loads these modules only when it draws a surface, points in space or a mask.
        for name in ("surface_", "volume_", "mask."):
            self.assertLess(sum(size for path, size in packed.items() if path.startswith("/assets/" + name)), 9_200)
        first = loaded_first()
        self.assertIn("/assets/halftone.js", first)
        for name in ("devices", "sample", "analyze"):  # panels that are loaded when they are opened
            self.assertNotIn(f"/assets/{name}.js", first)
        self.assertLess(sum(packed[path] for path in first), 80_000)
        for path, content in own.items():
            self.assertLess(len(content), 60_000, path)
        for path in FILES.keys() - own.keys():  # pictures cannot be compressed further, maps are sent compressed
            content = FILES[path] if path.endswith(".jpg") else gzip.compress(FILES[path])
            self.assertLess(len(content), 60_000, path)

    def test_is_compressed_and_revalidated(self):
        answer = self.ask("/", "--header", "Accept-Encoding: gzip")
        self.assertEqual(answer.headers["content-encoding"], "gzip")
        self.assertEqual(gzip.decompress(answer.body), FILES["/"])
        again = self.ask("/", "--header", "If-None-Match: " + answer.headers["etag"])
        self.assertEqual((again.status, again.body), (304, b""))
        self.assertEqual(again.headers["etag"], answer.headers["etag"])
        self.assertNotIn("content-length", again.headers)
        self.assertNotIn("content-type", again.headers)

    def test_accepts_get_and_head(self):
        head = self.ask("/", "--head")
        self.assertEqual((head.status, head.headers["content-length"]), (200, str(len(FILES["/"]))))
        self.assertEqual(self.ask("/", data=b"x").status, 405)
        self.assert_problem(self.ask("/assets/nothing.js"), 404)
        self.assert_problem(self.ask("/index.html"), 404)

    def test_allows_configured_origins(self):
        answer = self.ask("/", "--header", "Origin: https://a.example")
        self.assertEqual(answer.headers["access-control-allow-origin"], "https://a.example")


class Keys(unittest.TestCase):
    def test_are_not_required_for_the_page(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "keys"
            file.write_text("alice:alice-0123456789abcdef\n")
            with Server(f"--api-key-file={file}") as server:
                for path, content in FILES.items():
                    self.assertEqual(ask(server, path).body, content)
                self.assertEqual(ask(server, "/", data=b"x").status, 401)


if __name__ == "__main__":
    unittest.main(verbosity=2)
