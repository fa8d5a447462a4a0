# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures that the server fetches from permitted origins."""

import contextlib
import http.server
import os
import pathlib
import signal
import ssl
import subprocess
import tempfile
import threading
import unittest
from urllib.parse import quote

from harness import PATIENCE, PICTURES, Call, Server, ask, descendants, execute, wait_until
from raw import SANITIZED

PICTURE = (PICTURES / "camera.png").read_bytes()


class Host:
    """A host of pictures, on 127.0.0.1. `certificate` names files of a certificate and its key."""

    def __init__(self, certificate=None):
        host = self
        self.requests = []
        self.release = threading.Event()

        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self):  # pylint: disable=invalid-name
                host.requests.append((self.path, dict(self.headers)))
                status, headers, body = host.answer(self.path)
                self.send_response(status)
                for name, value in headers.items():
                    self.send_header(name, value)
                self.end_headers()
                with contextlib.suppress(OSError):
                    self.wfile.write(body)
                self.close_connection = True

            def log_message(self, *_):  # pylint: disable=arguments-differ
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.origin = f"http://127.0.0.1:{self.server.server_port}"
        if certificate:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            context.load_cert_chain(*certificate)
            self.server.socket = context.wrap_socket(self.server.socket, server_side=True)
            self.origin = f"https://localhost:{self.server.server_port}"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def answer(self, path):
        if path.startswith("/to?"):
            return 302, {"Location": path[4:], "Content-Length": "0"}, b""
        if path == "/again":
            return 302, {"Location": "/again", "Content-Length": "0"}, b""
        if path == "/large":
            return 200, {"Content-Length": str(1 << 40)}, b""
        if path == "/endless":
            return 200, {}, bytes(3 << 20)
        if path == "/slow":
            self.release.wait(PATIENCE)
        if path == "/unsized":
            return 200, {}, PICTURE
        if path == "/missing":
            return 404, {"Content-Length": "0"}, b""
        return 200, {"Content-Length": str(len(PICTURE))}, PICTURE

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.release.set()
        self.server.shutdown()
        self.server.server_close()


def fetch(server, url, query="sites=300", *arguments):
    return ask(server, f"/halftone?{query}&image_url={quote(url, safe='')}", "--request", "POST", *arguments)


def has_ended(process):
    """Returns whether a process has ended, even if its parent has not reaped it."""
    try:
        return "State:\tZ" in pathlib.Path(f"/proc/{process}/status").read_text()
    except OSError:
        return True


class Origins(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.stack = contextlib.ExitStack()
        cls.addClassCleanup(cls.stack.close)
        cls.host, cls.other = (cls.stack.enter_context(Host()) for _ in range(2))
        cls.server = cls.stack.enter_context(
            Server(f"--origin={cls.host.origin},http://localhost:{cls.host.server.server_port}", "--max-body=2MiB",
                   "--body-timeout=3"))

    def assert_problem(self, answer, status, words):
        self.assertEqual(answer.status, status, answer)
        self.assertIn(words, answer.json()["detail"])

    def test_are_answered_like_their_pictures(self):
        tags = set()
        direct = ask(self.server, "/halftone?sites=300", data=PICTURE)
        for path in ("/a.png?b=c&d=e", "/unsized", "/to?/a.png", f"/to?{self.host.origin}/a.png"):
            answer = fetch(self.server, self.host.origin + path)
            self.assertEqual((answer.status, answer.body), (200, direct.body), path)
            tags.add(answer.headers["etag"])
        self.assertEqual(len(tags), 1)
        self.assertIn("/a.png?b=c&d=e", [path for path, _ in self.host.requests])
        self.assertEqual(fetch(self.server, self.host.origin + "/a.png", "sites=300", "--header",
                               "Prefer: respond-async").status, 202)
        self.assertEqual(fetch(self.server, self.host.origin + "/a.png", "sitez=300").status, 400)

    def test_are_refused_unless_they_are_permitted(self):
        port = self.host.server.server_port
        before = len(self.host.requests)
        for url in (self.other.origin, f"https://127.0.0.1:{port}", "http://127.0.0.1/", f"http://127.0.0.2:{port}/",
                    f"http://user@127.0.0.1:{port}/", "file:///etc/passwd", "a", "",
                    f"http://127.0.0.1:{port}@127.0.0.1:{self.other.server.server_port}/"):
            self.assert_problem(fetch(self.server, url), 400, "image_url: ")
        self.assertEqual(len(self.host.requests), before)
        self.assert_problem(fetch(self.server, f"{self.host.origin}/to?{self.other.origin}/"), 400, "(origin)")
        self.assert_problem(fetch(self.server, f"{self.host.origin}/to?file:///etc/passwd"), 400, "image_url: ")
        self.assertEqual(self.other.requests, [])
        with Server() as without:
            self.assert_problem(fetch(without, self.host.origin), 400, "(origin)")
        answer = ask(self.server, f"/halftone?image_url={self.host.origin}/", data=PICTURE)
        self.assert_problem(answer, 400, "must be empty")

    def test_come_from_private_addresses_only_if_these_are_listed(self):
        port = self.host.server.server_port
        with Server(f"--origin=http://localhost:{port}") as server:
            self.assert_problem(fetch(server, f"http://localhost:{port}/"), 422, "not public and not permitted")
        self.assertEqual(fetch(self.server, f"http://localhost:{port}/").status, 200)

    def test_are_limited(self):
        for path, status, words in (("/large", 413, "too large"), ("/endless", 413, "too large"),
                                    ("/missing", 422, "404"), ("/again", 422, "too many redirects"),
                                    ("/slow", 422, "too long")):
            self.assert_problem(fetch(self.server, self.host.origin + path), status, words)

    @unittest.skipIf(SANITIZED, "sanitizers make system calls that the filter would deny")
    def test_are_fetched_by_a_confined_process(self):
        host = self.stack.enter_context(Host())
        with Server(f"--origin={host.origin}", "--body-timeout=60") as server:
            client = subprocess.Popen(["curl", "--silent", "--request", "POST",
                                       server.url(f"/halftone?image_url={host.origin}/slow")])

            def find():
                for process in descendants(server.process.pid):
                    with contextlib.suppress(OSError):
                        status = pathlib.Path(f"/proc/{process}/status").read_text()
                        if "Name:\tccdt-fetcher" in status and "Seccomp:\t2" in status:
                            return process, dict(line.split(":\t", 1) for line in status.splitlines() if ":\t" in line)
                return None

            wait_until(lambda: host.requests, "a request")
            process, status = wait_until(find, "a confined fetcher")
            self.assertEqual((status["CapEff"], status["NoNewPrivs"], status["Threads"]), (16 * "0", "1", "1"))
            for namespace in ("net", "mnt", "ipc", "uts"):
                self.assertNotEqual(os.readlink(f"/proc/{process}/ns/{namespace}"),
                                    os.readlink(f"/proc/self/ns/{namespace}"), namespace)
            self.assertEqual(os.listdir(f"/proc/{process}/root"), [])
            client.kill()
            client.wait(PATIENCE)
            wait_until(lambda: has_ended(process), "the end of the fetcher")
            with subprocess.Popen(client.args):
                process, _ = wait_until(find, "another fetcher")
                wait_until(lambda: len(host.requests) == 2, "another request")
                server.signal(signal.SIGKILL)
                server.wait()
            wait_until(lambda: has_ended(process), "the end of the other fetcher")

    def test_are_fetched_sixteen_at_a_time(self):
        host = self.stack.enter_context(Host())
        with Server(f"--origin={host.origin}", "--body-timeout=60") as server:
            path = f"/halftone?sites=20&image_url={host.origin}/slow"
            calls = [Call(server.url(path), "--request", "POST") for _ in range(16)]
            wait_until(lambda: len(host.requests) == 16, "16 requests")
            self.assert_problem(fetch(server, host.origin), 503, "too many pictures")
            host.release.set()
            self.assertEqual({call.answer().status for call in calls}, {200})
            self.assertEqual(fetch(server, host.origin).status, 200)

    def test_come_over_tls(self):
        folder = pathlib.Path(self.stack.enter_context(tempfile.TemporaryDirectory()))
        certificate = (str(folder / "certificate"), str(folder / "key"))
        execute(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-subj", "/CN=localhost", "-addext",
                 "subjectAltName=DNS:localhost", "-keyout", certificate[1], "-out", certificate[0]], check=True,
                capture_output=True)
        host = self.stack.enter_context(Host(certificate))
        flag = f"--origin={host.origin},127.0.0.1"
        with Server(flag, environment={"SSL_CERT_FILE": certificate[0]}) as server:
            self.assertEqual(fetch(server, host.origin + "/a.png").status, 200)
        with Server(flag) as server:
            self.assert_problem(fetch(server, host.origin + "/a.png"), 422, "certificate")


if __name__ == "__main__":
    unittest.main(verbosity=2)
