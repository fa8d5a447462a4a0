# SPDX-License-Identifier: GPL-3.0-or-later
"""GET /halftone/{name}: the server's own pictures, signed URLs, and malicious names and files."""

import base64
import hmac
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

from harness import NODE, PATIENCE, ROOT, Server, ask, data_uri, figures_at_rest, file_of, flat, join
from raw import Raw

GREY = file_of(flat(128))
DARK = file_of(flat(40))
OPTIONS = "?sites=50&scale=1"
CAT = "/halftone/cat.png" + OPTIONS
SECRET = b"what nobody may read"

# Accept headers of Chromium, Firefox and Safari for an <img>.
BROWSERS = ("image/avif,image/webp,image/apng,image/svg+xml,image/*,*/*;q=0.8",
            "image/avif,image/webp,image/png,image/svg+xml,image/*;q=0.8,*/*;q=0.5",
            "image/webp,image/avif,image/jxl,image/heic,image/heic-sequence,video/*;q=0.8,image/png,image/svg+xml,image/*;q=0.8,*/*;q=0.5")

ALICE = ("--header", "Authorization: Bearer alice-0123456789abcdef")
OLD = "old-signing-key-0123456789abcdef0123456789"
NEW = "new-signing-key-0123456789abcdef0123456789"


def folder_of_pictures(case):
    """Returns a folder with a picture. Its parent folder contains a secret file."""
    root = pathlib.Path(case.enterContext(tempfile.TemporaryDirectory()))
    root.chmod(0o755)
    folder = root / "pictures"
    folder.mkdir()
    (root / "secret").write_bytes(SECRET)
    (folder / "cat.png").write_bytes(GREY)
    return folder


def signed(key, text):
    """Returns the URL of a path and query, signed as the README describes."""
    signature = base64.urlsafe_b64encode(hmac.digest(key.encode(), text.encode(), "sha256")).decode().rstrip("=")
    return text + ("&" if "?" in text else "?") + "signature=" + signature


class PicturesCase(unittest.TestCase):
    flags = ()
    environment = {}

    def setUp(self):
        self.folder = folder_of_pictures(self)
        self.server = self.enterContext(Server(f"--pictures={self.folder}", *self.flags, environment=self.environment))

    def ask(self, path, *arguments, status=200, data=None):
        answer = ask(self.server, path, "--path-as-is", *arguments, data=data)
        self.assertEqual(answer.status, status, answer)
        if status >= 400 and "--head" not in arguments:
            self.assertEqual(answer.type, "application/problem+json")
        return answer

    def sites(self):
        return float(re.search(r"^ccdt_sites_total (\S+)$", figures_at_rest(self.server), re.MULTILINE)[1])


class Answers(PicturesCase):
    flags = ("--cache=16MiB",)

    def test_equal_those_for_the_same_picture_in_a_body(self):
        for query in (OPTIONS, OPTIONS + "&format=svg", OPTIONS + "&color=cmyk&format=webp", OPTIONS + "&format=npy",
                      "?sites=9&format=csv&invert=true&seed=7", "?sites=9&foreground=%23c30"):
            with self.subTest(query=query):
                named, sent = self.ask("/halftone/cat.png" + query), self.ask("/halftone" + query, data=GREY)
                self.assertEqual((named.body, named.type), (sent.body, sent.type))
                for header in ("x-radius", "x-tone"):
                    self.assertEqual(named.headers.get(header), sent.headers.get(header))

    def test_to_browsers_are_pngs(self):
        tags = set()
        for accept in BROWSERS:
            answer = self.ask(CAT, "--header", "Accept: " + accept)
            self.assertEqual(answer.type, "image/png")
            self.assertIn("Accept", answer.headers["vary"].split(", ")[0])
            self.assertEqual(answer.picture().shape, (64, 64))
            tags.add(self.ask(CAT + "&format=webp", "--header", "Accept: " + accept).headers["etag"])
        self.assertEqual(len(tags), 1, "requests with a format must share one answer")

    def test_for_images_need_no_cors_headers(self):
        answer = self.ask(CAT, "--header", "Origin: https://a.example", "--header", "Sec-Fetch-Mode: no-cors", "--header",
                          "Sec-Fetch-Site: cross-site")
        self.assertNotIn("access-control-allow-origin", answer.headers)
        self.assertNotIn("cross-origin-resource-policy", answer.headers)
        self.ask(CAT, "--header", "Host: evil.example", status=421)

    def test_have_strong_tags_that_avoid_the_computation(self):
        tag = self.ask(CAT + "&seed=1").headers["etag"]
        self.assertRegex(tag, r'^"[^"]+"$')
        before = self.sites()
        again = self.ask(CAT + "&seed=1", "--header", "If-None-Match: " + tag, status=304)
        self.assertEqual((again.body, again.headers["etag"]), (b"", tag))
        self.assertEqual(again.headers["cache-control"], "public, max-age=60")
        self.ask(CAT + "&seed=1", "--head", "--header", "If-None-Match: " + tag, status=304)
        self.assertEqual(self.sites(), before)
        self.assertNotEqual(self.ask(CAT + "&seed=2").headers["etag"], tag)

    def test_may_be_kept_for_a_configured_time(self):
        for seconds in (0, 86400):
            with Server(f"--pictures={self.folder}", f"--pictures-max-age={seconds}") as server:
                self.assertEqual(ask(server, CAT).headers["cache-control"], f"public, max-age={seconds}")

    def test_are_cached(self):
        first = self.ask(CAT, "--header", "X-Request-ID: first")
        before = self.sites()
        again = self.ask(CAT, "--header", "X-Request-ID: second")
        self.assertEqual((again.body, self.sites()), (first.body, before))
        self.assertNotIn("cache=", self.server.wait_for_log("first "))
        self.assertIn(" cache=hit", self.server.wait_for_log("second "))
        self.assertEqual(first.headers["cache-control"], "public, max-age=60")

    def test_change_with_the_file(self):
        file = self.folder / "cat.png"
        first = self.ask(CAT)
        status = file.stat()
        with tempfile.NamedTemporaryFile(dir=self.folder, delete=False) as other:
            other.write(DARK)
        os.replace(other.name, file)
        os.utime(file, ns=(status.st_atime_ns, status.st_mtime_ns))
        second = self.ask(CAT, "--header", "If-None-Match: " + first.headers["etag"])
        self.assertNotEqual((second.headers["etag"], second.body), (first.headers["etag"], first.body))
        file.write_bytes(GREY)
        self.assertEqual(self.ask(CAT).headers["etag"], first.headers["etag"], "the same on all servers")

    def test_to_head_have_the_same_headers_without_a_body(self):
        large = "/halftone/cat.png?sites=100000&iterations=0&format=svg"  # is streamed
        for path in (CAT, large):
            head, whole = self.ask(path, "--head"), self.ask(path)
            self.assertEqual((head.body, head.headers["content-length"]), (b"", str(len(whole.body))))
            for name in ("etag", "content-type", "cache-control", "vary", "x-radius"):
                self.assertEqual(head.headers[name], whole.headers[name], name)
        self.assertGreater(len(whole.body), 4 << 20)
        self.ask("/halftone/other.png", "--head", status=404)

    def test_to_other_methods_are_405(self):
        for method in ("POST", "PUT", "PATCH", "DELETE", "BREW"):
            answer = self.ask(CAT, "--request", method, status=405, data=GREY)
            self.assertEqual(answer.headers["allow"], "GET, HEAD, OPTIONS")
        self.assertEqual(self.ask(CAT, "--request", "OPTIONS", status=204).headers["allow"], "GET, HEAD, OPTIONS")

    def test_depend_only_on_the_query(self):
        answer = self.ask(CAT)
        for header in ("Prefer: respond-async", "Content-Type: application/json", "Content-Encoding: br",
                       "Content-Type: multipart/form-data; boundary=b"):
            self.assertEqual(self.ask(CAT, "--header", header).body, answer.body, header)
        self.assertEqual(self.ask(CAT, "--request", "GET", data=DARK).body, answer.body)

    def test_have_the_same_errors_as_for_pictures_in_bodies(self):
        (self.folder / "white.png").write_bytes(file_of(flat(255)))
        (self.folder / "broken.png").write_bytes(GREY[:60])
        (self.folder / "notes.txt").write_bytes(b"no picture at all")
        (self.folder / "request.json").write_text(f'{{"image":"{data_uri(GREY)}","sites":5}}')
        (self.folder / "empty.png").touch()
        for path, status, word in ((CAT + "&nonsense=1", 400, "nonsense"), ("/halftone/cat.png?sites=0", 400, "sites"),
                                   ("/halftone/cat.png?signature=a&sites=5", 400, "signature"),
                                   ("/halftone/cat.png?sites=5&expires=x", 400, "expires"),
                                   ("/halftone/cat.png?sites=99999999", 413, "sites"),
                                   ("/halftone/white.png", 422, ""), ("/halftone/broken.png", 422, ""),
                                   ("/halftone/notes.txt", 415, ""), ("/halftone/request.json", 415, ""),
                                   ("/halftone/empty.png", 400, "")):
            self.assertIn(word, self.ask(path, status=status).json()["detail"], path)
        self.ask("/halftone/cat.png?sites=5&expires=1&signature=whatever")  # ignored, since there are no signing keys

    def test_are_counted_and_logged_like_others(self):
        self.ask(CAT, "--header", "X-Request-ID: named")
        for i in range(5):
            self.ask(f"/halftone/unknown-{i}", status=404)
        figures = figures_at_rest(self.server)
        self.assertIn('ccdt_http_requests_total{route="/halftone/{name}",status="200"} 1', figures)
        self.assertIn('ccdt_http_requests_total{route="/halftone/{name}",status="404"} 5', figures)
        self.assertNotIn("unknown", figures)
        self.assertIn(" GET " + CAT + " 200 ", self.server.wait_for_log("named "))

    def test_are_listed_in_capabilities(self):
        self.assertEqual(self.ask("/capabilities").json()["halftone"]["pictures"], "unsigned")

    def test_that_are_partial_are_not_cacheable(self):
        with Server(f"--pictures={self.folder}", "--timeout=4") as server:
            answer = ask(server, "/halftone/cat.png?sites=5000&iterations=1000&passes=100&on_deadline=partial")
        self.assertEqual((answer.status, answer.headers["x-partial"]), (200, "deadline"))
        self.assertEqual(answer.headers["cache-control"], "no-store")
        self.assertNotIn("etag", answer.headers)


class Names(PicturesCase):
    def test_cannot_leave_the_folder(self):
        folder = self.folder
        (folder / "sub").mkdir()
        (folder / "sub" / "cat.png").write_bytes(GREY)
        (folder / ".hidden.png").write_bytes(GREY)
        (folder / "link-out").symlink_to(folder.parent / "secret")
        (folder / "link-in").symlink_to("cat.png")
        (folder / "link-to-folder").symlink_to(folder.parent)
        os.mkfifo(folder / "fifo")
        names = ["", ".", "..", "../secret", "..%2fsecret", "..%2Fsecret", "%2e%2e%2fsecret", "%2e%2e/secret",
                 "%252e%252e%252fsecret", "..%252fsecret", "..%c0%afsecret", "..%5csecret", "%00", "cat.png%00",
                 "cat.png%00.jpg", "%00cat.png", "cat.png/", "cat.png%2f", "./cat.png", "%2e%2fcat.png", "sub",
                 "sub/cat.png", "sub%2fcat.png", ".hidden.png", "%2ehidden.png", "link-out", "link-in", "link-to-folder",
                 "link-to-folder%2fsecret", "fifo", "%2fetc%2fpasswd", "/etc/passwd", "%2f%2fetc%2fpasswd", "CAT.PNG",
                 "cat.png%0d%0aX:1", "cat.png%0a", "cat.png%20", "%20cat.png", "cat.png%3f", "%c3%a4.png", "%ff%fe", "*",
                 "%2a", "~root", "x" * 255, "x" * 256, "x" * 8000, "%78" * 2600, "proc%2fself%2fenviron",
                 "file:%2f%2f%2fetc%2fpasswd", "http:%2f%2f127.0.0.1%2fa.png", "\u00e4.png", "cat.png;x", "-", "%", "%2"]
        for name in names:
            with self.subTest(name=name[:40]):
                answer = self.ask("/halftone/" + name, "--globoff", status=404)
                self.assertNotIn(SECRET, answer.body)
                for word in (str(folder), folder.name, "secret"):
                    self.assertNotIn(word, answer.json()["detail"])
        self.ask(CAT)

    def test_may_contain_any_characters_of_file_names(self):
        for name, encoded in (("\u00e4 b.png", "%C3%A4%20b.png"), ("%2e%2e%2fsecret", "%252e%252e%252fsecret"),
                              ("a&b=c?d#e.png", "a&b=c%3Fd%23e.png"), ("x" * 255, "x" * 255), ("cat", "cat"),
                              ("signature=x", "signature=x"), ("-rf", "-rf"), ("a\\b", "a%5Cb")):
            (self.folder / name).write_bytes(GREY)
            self.assertEqual(self.ask("/halftone/" + encoded + OPTIONS).body, self.ask(CAT).body, name)
        (self.folder / os.fsdecode(b"\xff")).write_bytes(GREY)
        with Raw(self.server) as raw:
            raw.send(b"GET /halftone/\xff?sites=5 HTTP/1.1\r\nHost: localhost\r\n\r\n")
            self.assertEqual(raw.answer()[0], 200)
            raw.send(b"GET http://localhost/halftone/cat.png?sites=5#fragment HTTP/1.1\r\nHost: localhost\r\n\r\n")
            self.assertEqual(raw.answer()[0], 200)

    def test_are_unknown_without_a_folder(self):
        with Server() as server:
            self.assertEqual(ask(server, CAT).status, 404)
            self.assertEqual(ask(server, "/capabilities").json()["halftone"]["pictures"], "none")

    def test_require_an_existing_folder(self):
        for folder in (self.folder / "cat.png", self.folder / "nowhere"):
            done = subprocess.run([os.environ["CCDT_SERVER"], "--port=0", f"--pictures={folder}"], capture_output=True,
                                  text=True, timeout=PATIENCE, check=False)
            self.assertEqual(done.returncode, 1)
            self.assertIn(str(folder), done.stderr)


class Files(PicturesCase):
    flags = ("--max-body=64KiB",)

    def ask_meanwhile(self, change, allowed):
        """Sends requests while something changes the file; the server must continue."""
        over = threading.Event()

        def work():
            try:
                change()
            finally:
                over.set()

        thread = threading.Thread(target=work)
        thread.start()
        seen = {ask(self.server, CAT).status}
        while not over.is_set():
            seen.add(ask(self.server, CAT).status)
        join(thread, "the changes of the file")
        self.assertLessEqual(seen, allowed)
        self.assertEqual(self.ask("/health/ready").json(), {"status": "ready"})

    def test_that_grow_are_refused_at_the_limit(self):
        def grow():
            with open(self.folder / "cat.png", "ab", buffering=0) as file:
                for _ in range(300):
                    file.write(bytes(256))

        self.ask_meanwhile(grow, {200, 422, 503, 413})
        self.assertIn("max-body", self.ask(CAT, status=413).json()["detail"])

    def test_that_are_replaced_or_removed_are_whole_or_404(self):
        def replace():
            for i in range(300):
                with tempfile.NamedTemporaryFile(dir=self.folder, delete=False) as other:
                    other.write(DARK if i % 2 else GREY)
                os.replace(other.name, self.folder / "cat.png")
                if i % 3 == 0:
                    os.remove(self.folder / "cat.png")

        self.ask_meanwhile(replace, {200, 404})

    def test_that_are_too_large_are_refused(self):
        (self.folder / "large.png").write_bytes(bytes(64 * 1024 + 1))
        self.assertIn("65536 bytes (max-body)", self.ask("/halftone/large.png", status=413).json()["detail"])
        with open(self.folder / "sparse.png", "wb") as file:
            file.truncate(1 << 40)
        self.ask("/halftone/sparse.png", status=413)

    def test_that_are_unreadable_are_404(self):
        (self.folder / "cat.png").chmod(0)
        # Without these capabilities, not even root can read such a file. Another user might not reach the programs.
        program = self.folder.parent / "without-override"
        program.write_text('#!/bin/sh\n'
                           'exec setpriv --bounding-set=-dac_override,-dac_read_search "$CCDT_SERVER" "$@"\n')
        program.chmod(0o755)
        with Server(f"--pictures={self.folder}", program=program if os.geteuid() == 0 else None) as server:
            refused, unknown = (ask(server, path, "--header", "X-Request-ID: same")
                                for path in (CAT, "/halftone/unknown"))
            self.assertEqual((refused.status, refused.body), (404, unknown.body))
            self.assertIn("Permission denied", server.wait_for_log(" 404 "))
            (self.folder / "cat.png").chmod(0o644)
            self.assertEqual(ask(server, CAT).status, 200)

    def test_in_a_removed_folder_are_500(self):
        self.folder.rename(self.folder.parent / "elsewhere")
        self.assertNotIn(self.folder.name, self.ask(CAT, status=500).json()["detail"])
        self.server.wait_for_log("folder of pictures: No such file")
        (self.folder.parent / "elsewhere").rename(self.folder)
        self.ask(CAT)


class SignedUrls(PicturesCase):
    """URLs of a server with API keys and two signing keys."""

    flags = ("--cache=16MiB",)

    def setUp(self):
        keys = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.signing = keys / "signing"
        self.signing.write_text(f"# of the site\nold:{OLD}\nnew {NEW}\n")
        (keys / "api").write_text("alice:alice-0123456789abcdef\n")
        self.flags = (*self.flags, f"--api-key-file={keys / 'api'}")
        self.environment = {"CCDT_SIGNING_KEY_FILE": str(self.signing)}
        super().setUp()

    def refuse(self, path, *words, arguments=()):
        detail = self.ask(path, *arguments, status=403).json()["detail"]
        for word in words:
            self.assertIn(word, detail)

    def test_replace_api_keys(self):
        for key in (OLD, NEW):
            self.ask(signed(key, CAT))
            self.ask(signed(key, "/halftone/cat.png"))
            self.ask(signed(key, CAT), "--head")
            self.ask(signed(key, CAT), *ALICE)
        self.ask(signed(OLD, CAT), "--header", "Authorization: Bearer wrong")
        self.ask(CAT, status=403)
        self.ask(CAT, *ALICE, status=403)
        self.ask("/halftone" + OPTIONS, data=GREY, status=401)
        self.ask(signed(OLD, "/halftone" + OPTIONS), data=GREY, status=401)
        self.ask(signed(OLD, "/metrics"), status=401)
        self.assertEqual(self.ask("/capabilities").json()["halftone"]["pictures"], "signed")

    def test_are_refused_with_the_reason(self):
        good = signed(OLD, CAT)
        self.refuse(CAT, "must be signed", "`signature`")
        self.refuse("/halftone/cat.png", "must be signed")
        self.refuse(good + "&seed=1", "must be signed")
        self.refuse(signed("x" * 40, CAT), "the signature does not match")
        self.refuse(good[:-1], "the signature does not match")
        self.refuse(good + "=", "the signature does not match")
        self.refuse(good.replace("sites=50", "sites=51"), "the signature does not match")
        self.refuse(good.replace("cat", "dog"), "the signature does not match")
        self.refuse(good.replace("cat", "c%61t"), "the signature does not match")
        self.refuse(good.replace("&signature=", "&signature=&signature="), "the signature does not match")
        self.refuse(good, "must be signed", arguments=("--request-target", good.replace("signature", "%73ignature")))
        self.refuse("/halftone/unknown.png", "must be signed")
        self.ask(signed(OLD, "/halftone/unknown.png"), status=404)
        self.ask(signed(OLD, CAT + "&nonsense=1"), status=400)
        self.ask(signed(OLD, CAT), "--request", "POST", status=405)
        self.ask(CAT, "--request", "OPTIONS", "--header", "Origin: https://a.example", "--header",
                 "Access-Control-Request-Method: GET", status=204)

    def test_expire(self):
        now = int(time.time())
        answer = self.ask(signed(OLD, f"{CAT}&expires={now + 30}"))
        self.assertLessEqual(int(answer.headers["cache-control"].removeprefix("public, max-age=")), 30)
        answer = self.ask(signed(OLD, f"{CAT}&expires={now + 3600}"))
        self.assertEqual(answer.headers["cache-control"], "public, max-age=60")
        self.assertEqual(answer.body, self.ask(signed(OLD, CAT)).body)
        self.refuse(signed(OLD, f"{CAT}&expires={now}"), "expired")
        self.refuse(signed(OLD, f"{CAT}&expires={now + 3600}").replace(str(now + 3600), str(now + 7200)), "the signature")
        self.ask(signed(OLD, f"{CAT}&expires=soon"), status=400)

    def test_share_the_cache(self):
        self.ask(signed(OLD, CAT))
        self.ask(signed(NEW, f"{CAT}&expires={int(time.time()) + 3600}"), "--header", "X-Request-ID: second")
        self.assertIn(" cache=hit", self.server.wait_for_log("second "))

    def test_leave_no_signature_in_the_log(self):
        url = signed(NEW, CAT)
        self.ask(url, "--header", "X-Request-ID: good")
        self.ask(url + "x", "--header", "X-Request-ID: bad", status=403)
        self.assertIn(" signer=new", self.server.wait_for_log("good "))
        self.assertNotIn("signer", self.server.wait_for_log("bad "))
        self.assertEqual(self.server.stop(), 0)
        for secret in (url.rpartition("=")[2], OLD, NEW):
            self.assertNotIn(secret, self.server.log())

    def test_follow_reloaded_signing_keys(self):
        self.signing.write_text(f"new:{NEW}\n")
        self.server.signal(signal.SIGHUP)
        self.server.wait_for_log("were reloaded")
        self.refuse(signed(OLD, CAT), "the signature does not match")
        self.ask(signed(NEW, CAT))
        self.signing.write_text("new:short\n")
        self.server.signal(signal.SIGHUP)
        self.assertIn("line 1: a key must have 32 to 256", self.server.wait_for_log("stay as they were"))
        self.ask(signed(NEW, CAT))


class Snippets(PicturesCase):
    """Snippets of the README that sign a URL with the key in the environment."""

    environment = {"CCDT_SIGNING_KEY": OLD}

    def snippet(self, language, word):
        text = (ROOT / "server" / "files" / "README.md").read_text()
        found = [block for block in re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
                 if word in block]
        self.assertEqual(len(found), 1)
        self.assertEqual(found[0].count("\n"), 3, "lines")
        return found[0]

    def test_produce_the_same_signature(self):
        expected = signed(OLD, CAT)
        for command, code in (((sys.executable, "-c"), self.snippet("python", "hmac")),
                              ((NODE, "--input-type=module", "--eval"), self.snippet("js", "createHmac")),
                              (("bash", "-euo", "pipefail", "-c"), self.snippet("sh", "openssl"))):
            with self.subTest(command=command[0]):
                done = subprocess.run([*command, code], env={**os.environ, **self.environment}, capture_output=True,
                                      text=True, timeout=PATIENCE, check=True)
                self.assertEqual(done.stdout.strip(), expected)
                self.ask(done.stdout.strip())
        self.ask(CAT, status=403)


class Keys(unittest.TestCase):
    def setUp(self):
        self.folder = folder_of_pictures(self)
        self.flag = f"--pictures={self.folder}"

    def test_in_the_environment_are_hidden_from_child_processes(self):
        with Server(self.flag, environment={"CCDT_SIGNING_KEY": OLD}) as server:
            self.assertEqual(ask(server, signed(OLD, "/halftone/unknown")).status, 404)
            processes = [path for path in pathlib.Path("/proc").glob("[0-9]*")
                         if self.is_below(path, server.process.pid)]
            names = {(path / "comm").read_text().strip() for path in processes}
            self.assertLessEqual({"ccdt-decoder", "ccdt-worker"}, names)
            for path in processes:
                self.assertNotIn(OLD.encode(), (path / "environ").read_bytes())
            self.assertNotIn(OLD.encode(), pathlib.Path(f"/proc/{server.process.pid}/cmdline").read_bytes())
            server.signal(signal.SIGHUP)
            server.wait_for_log("SIGHUP is ignored")
            self.assertEqual(server.stop(), 0)
            self.assertIn("signer=CCDT_SIGNING_KEY", server.log())
            self.assertNotIn(OLD, server.log())

    @staticmethod
    def is_below(path, ancestor):
        """Returns whether a process is a descendant of another."""
        while path.name not in ("0", "1"):
            try:
                parent = re.search(r"^PPid:\s(\d+)", (path / "status").read_text(), re.MULTILINE)[1]
            except OSError:
                return False
            if int(parent) == ancestor:
                return True
            path = path.parent / parent
        return False

    def refuse(self, code, *flags, **environment):
        done = subprocess.run([os.environ["CCDT_SERVER"], "--port=0", self.flag, *flags], capture_output=True, text=True,
                              timeout=PATIENCE, check=False, env={**os.environ, **environment})
        self.assertEqual(done.returncode, code)
        self.assertNotIn("0123456789", done.stderr)
        return done.stderr

    def test_that_are_invalid_prevent_the_start(self):
        self.assertIn("CCDT_SIGNING_KEY", self.refuse(2, "--signing-key=" + OLD))
        self.assertIn("32 to 256", self.refuse(1, CCDT_SIGNING_KEY="short-0123456789"))
        self.assertIn("/none", self.refuse(1, "--signing-key-file=/none"))
        self.assertIn("only one", self.refuse(2, "--signing-key-file=/none", CCDT_SIGNING_KEY=OLD))

    def test_of_clients_are_required_without_a_signature(self):
        with tempfile.NamedTemporaryFile("w") as keys:
            keys.write("alice:alice-0123456789abcdef\n")
            keys.flush()
            with Server(self.flag, "--api-key-file=" + keys.name) as server:
                self.assertEqual(ask(server, CAT).status, 401)
                answer = ask(server, CAT, *ALICE)
                self.assertEqual((answer.status, answer.headers["cache-control"]), (200, "private, max-age=60"))

    def test_are_rate_limited_by_address(self):
        with Server(self.flag, "--rate-limit=0.001", "--rate-burst=2", environment={"CCDT_SIGNING_KEY": OLD}) as server:
            for url, statuses in ((signed(OLD, CAT), [200, 200, 429]), (CAT, [403, 403, 429])):
                source = "127.0.0.1" if "signature" in url else "127.0.0.2"
                found = []
                for _ in statuses:
                    with Raw(server, source) as raw:
                        raw.send(f"GET {url} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
                        found.append(raw.answer()[0])
                self.assertEqual(found, statuses)


if __name__ == "__main__":
    unittest.main(verbosity=2)
