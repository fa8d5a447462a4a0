# SPDX-License-Identifier: GPL-3.0-or-later
"""GET /docs/{path}: the folder of documentation, and malicious paths."""

import gzip
import os
import pathlib
import subprocess
import tempfile
import unittest

from harness import PATIENCE, Server, ask, figures_at_rest

HOME = b"<!doctype html>\n<title>Home</title>\n" + b"<p>Text\n" * 300
SECRET = b"what nobody may read"
FILES = {"index.html": HOME, "page.css": b"p {}", "main.js": b"export {};", "pictures/dots.svg": b"<svg/>",
         "pictures/dots.png": b"\x89PNG", "pictures/dots.webp": b"RIFF", "pictures/deep/a b.jpg": b"\xff\xd8",
         "tables.json": b"{}", "notes.txt": b"notes", "archive.tar": b"\0"}
TYPES = {"html": "text/html; charset=utf-8", "css": "text/css; charset=utf-8", "js": "text/javascript; charset=utf-8",
         "svg": "image/svg+xml", "png": "image/png", "webp": "image/webp", "jpg": "image/jpeg",
         "json": "application/json", "txt": "text/plain; charset=utf-8", "tar": "application/octet-stream"}


class Documents(unittest.TestCase):
    def setUp(self):
        root = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.folder = root / "site"
        for name, content in FILES.items():
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            (self.folder / name).write_bytes(content)
        (root / "secret.html").write_bytes(SECRET)
        (root / "keys").write_text("alice:alice-0123456789abcdef\n")
        # Documents need neither a key nor, like the page, count for the rate.
        self.server = self.enterContext(Server(f"--docs={self.folder}", f"--api-key-file={root / 'keys'}",
                                               "--rate-limit=0.001", "--rate-burst=1", "--max-body=1MiB"))

    def ask(self, path, *arguments, status=200, data=None):
        answer = ask(self.server, path, "--path-as-is", "--globoff", *arguments, data=data)
        self.assertEqual(answer.status, status, answer)
        if status >= 400 and "--head" not in arguments:
            self.assertEqual(answer.type, "application/problem+json")
        return answer

    def test_are_served_with_their_types(self):
        for name, content in FILES.items():
            answer = self.ask("/docs/" + name.replace(" ", "%20"))
            self.assertEqual((answer.body, answer.type), (content, TYPES[name.rsplit(".")[-1]]), name)
            self.assertEqual(answer.headers["x-content-type-options"], "nosniff")
            self.assertEqual(answer.headers["cache-control"], "no-cache")
            self.assertIn("script-src 'self'", answer.headers["content-security-policy"])
        self.assertEqual(self.ask("/docs/").body, HOME)
        self.assertEqual(self.ask("/docs/?a=b").body, HOME)

    def test_are_compressed_and_revalidated(self):
        answer = self.ask("/docs/", "--header", "Accept-Encoding: gzip")
        self.assertEqual(answer.headers["content-encoding"], "gzip")
        self.assertEqual(gzip.decompress(answer.body), HOME)
        again = self.ask("/docs/", "--header", "If-None-Match: " + answer.headers["etag"], status=304)
        self.assertEqual((again.body, again.headers["etag"]), (b"", answer.headers["etag"]))
        status = (self.folder / "index.html").stat()
        (self.folder / "new").write_bytes(HOME.upper())
        (self.folder / "new").rename(self.folder / "index.html")
        os.utime(self.folder / "index.html", ns=(status.st_atime_ns, status.st_mtime_ns))
        changed = self.ask("/docs/", "--header", "If-None-Match: " + answer.headers["etag"])
        self.assertEqual(changed.body, HOME.upper())

    def test_accept_get_and_head(self):
        head = self.ask("/docs/", "--head")
        self.assertEqual((head.body, head.headers["content-length"]), (b"", str(len(HOME))))
        key = ("--header", "Authorization: Bearer alice-0123456789abcdef")
        self.assertEqual(self.ask("/docs/", *key, status=405, data=b"x").headers["allow"], "GET, HEAD, OPTIONS")
        self.ask("/docs/", status=401, data=b"x")

    def test_cannot_be_outside_the_folder(self):
        folder = self.folder
        (folder / ".hidden").write_bytes(SECRET)
        (folder / ".git").mkdir()
        (folder / ".git" / "config").write_bytes(SECRET)
        (folder / "link-out").symlink_to(folder.parent / "secret.html")
        (folder / "link-to-folder").symlink_to(folder.parent)
        (folder / "pictures" / "link-up").symlink_to("..")
        os.mkfifo(folder / "fifo")
        paths = [".", "..", "../secret.html", "..%2fsecret.html", "%2e%2e/secret.html", "%2e%2e%2fsecret.html",
                 "..%252fsecret.html", "..%5csecret.html", "pictures/../../secret.html", "pictures/..%2f../secret.html",
                 "../site/index.html", "./index.html", "pictures/../index.html", "pictures", "pictures/",
                 "pictures//dots.svg", "/index.html", "//index.html", "index.html/", "index.html%00", "index.html%0a",
                 ".hidden", "%2ehidden", ".git/config", "link-out", "link-to-folder/secret.html",
                 "pictures/link-up/index.html", "fifo", "%2fetc%2fpasswd", "/etc/passwd", "INDEX.HTML", "x" * 256,
                 "x/" * 3000, "pictures/deep", "%ff", "unknown.html"]
        for path in paths:
            with self.subTest(path=path[:40]):
                answer = self.ask("/docs/" + path, status=404)
                self.assertNotIn(SECRET, answer.body)
                self.assertEqual(answer.json()["detail"], "there is no document of this name")
        self.ask("/docs", status=401)  # an unknown path needs a key

    def test_have_a_size_limit(self):
        with (self.folder / "large.html").open("wb") as file:
            file.truncate(1 << 20)
        self.assertEqual(len(self.ask("/docs/large.html").body), 1 << 20)
        with (self.folder / "large.html").open("wb") as file:
            file.truncate((1 << 20) + 1)
        self.assertIn("max-body", self.ask("/docs/large.html", status=413).json()["detail"])

    def test_are_counted_as_one_route(self):
        with Server(f"--docs={self.folder}") as server:
            for path in ("/docs/", "/docs/page.css", "/docs/pictures/dots.svg", "/docs/unknown"):
                ask(server, path)
            figures = figures_at_rest(server)
        self.assertIn('ccdt_http_requests_total{route="/docs/{path}",status="200"} 3', figures)
        self.assertIn('ccdt_http_requests_total{route="/docs/{path}",status="404"} 1', figures)

    def test_are_listed_in_capabilities(self):
        self.assertIs(self.ask("/capabilities").json()["documentation"], True)


class Folder(unittest.TestCase):
    def test_is_optional(self):
        with Server() as server:
            answer = ask(server, "/docs/")
            self.assertEqual(answer.status, 404)
            self.assertIn("(docs)", answer.json()["detail"])
            self.assertIs(ask(server, "/capabilities").json()["documentation"], False)

    def test_must_exist(self):
        done = subprocess.run([os.environ["CCDT_SERVER"], "--port=0", "--docs=/nowhere"], capture_output=True,
                              text=True, timeout=PATIENCE, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("/nowhere: No such file", done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
