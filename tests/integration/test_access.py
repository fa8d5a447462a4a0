# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys, origins, rates, compression, and what reaches the log."""

import gzip
import json
import os
import pathlib
import signal
import subprocess
import tempfile
import unittest

from harness import PATIENCE, Server, ServerCase, ask, file_of, flat, post_json
from raw import Raw, statuses

GREY = file_of(flat(128))
ALICE = "alice-0123456789abcdef"
BOB = "bob-0123456789abcdefgh"
HALFTONE = "/halftone?sites=5&scale=1"


def bearer(key):
    return ("--header", "Authorization: Bearer " + key)


class Keys(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = pathlib.Path(folder.name) / "keys"
        self.file.write_text(f"# who may ask\nalice:{ALICE}\n\nbob {BOB}\n")

    def test_are_required_except_for_health_checks_and_preflights(self):
        with Server(environment={"CCDT_API_KEY_FILE": str(self.file)}) as server:
            for path in ("/halftone", "/sample", "/nothing"):
                for header in ((), bearer(""), bearer(ALICE[:-1]), bearer(ALICE + "x"), bearer("x" * 5000),
                               ("--header", "Authorization: Basic " + ALICE)):
                    answer = ask(server, path, *header, data=GREY)
                    self.assertEqual((answer.status, answer.type), (401, "application/problem+json"))
                    self.assertEqual(answer.headers["www-authenticate"], "Bearer")
            self.assertEqual(ask(server, HALFTONE, *bearer(ALICE), data=GREY).status, 200)
            self.assertEqual(ask(server, HALFTONE, "--header", "authorization: bearer " + BOB, data=GREY).status, 200)
            for path in ("/capabilities", "/health", "/health/live", "/health/ready"):
                self.assertEqual(ask(server, path).status, 200)
            options = ("/halftone", "--request", "OPTIONS")
            self.assertEqual(ask(server, *options).status, 401)
            self.assertEqual(ask(server, *options, "--request-target", "*").status, 401)
            self.assertEqual(ask(server, *options, "--request-target", "*", *bearer(ALICE)).status, 204)
            self.assertEqual(ask(server, *options, "--header", "Origin: https://a.example", "--header",
                                 "Access-Control-Request-Method: POST").status, 204)
            self.assertEqual(server.stop(), 0)
            for name in ("alice", "bob"):
                self.assertIn("key=" + name, server.log())
            for key in (ALICE, BOB):
                self.assertNotIn(key, server.log())

    def test_several_in_one_request_are_refused(self):
        with Server(f"--api-key-file={self.file}") as server:
            for first, second in ((ALICE, BOB), (ALICE, ALICE), ("unknown", ALICE)):
                answer = ask(server, HALFTONE, *bearer(first), *bearer(second), data=GREY)
                self.assertEqual((answer.status, answer.type), (400, "application/problem+json"))
                self.assertIn("Authorization", answer.json()["detail"])

    def test_in_the_url_are_redacted_in_the_log(self):
        names = ("key", "api_key", "apikey", "token", "access_token", "Authorization", "kye")
        for form in ("text", "json"):
            with Server(f"--api-key-file={self.file}", f"--log-format={form}") as server:
                for name in names:
                    for path in ("/metrics?", "/jobs/1?x=1&", HALFTONE + "&"):
                        ask(server, f"{path}{name}={ALICE}")
                        ask(server, f"{path}{name}={ALICE}", *bearer(ALICE), data=GREY)
                ask(server, "/metrics?" + ALICE)
                ask(server, HALFTONE, *bearer(ALICE), data=GREY)
                server.wait_for_log(HALFTONE)
                self.assertEqual(server.stop(), 0)
                self.assertNotIn(ALICE, server.log())

    def test_are_reloaded_on_sighup(self):
        with Server(f"--api-key-file={self.file}") as server:
            self.file.write_text("carol:carol-0123456789abcdef\n")
            server.signal(signal.SIGHUP)
            server.wait_for_log("were reloaded")
            self.assertEqual(ask(server, HALFTONE, *bearer(ALICE), data=GREY).status, 401)
            self.assertEqual(ask(server, HALFTONE, *bearer("carol-0123456789abcdef"), data=GREY).status, 200)
            self.file.write_text("dave:short\n")
            server.signal(signal.SIGHUP)
            self.assertIn("line 1", server.wait_for_log("stay as they were"))
            self.assertEqual(ask(server, HALFTONE, *bearer("carol-0123456789abcdef"), data=GREY).status, 200)
            self.assertEqual(server.stop(), 0)

    def test_files_without_keys_prevent_the_start(self):
        for text in ("", "# none\n", "alice\n", "alice:short\n", f"a/b:{ALICE}\n", f"alice:{ALICE}\nbob:{ALICE}\n"):
            self.file.write_text(text)
            self.check_refused()
        self.file.unlink()
        self.check_refused()

    def check_refused(self):
        result = subprocess.run([os.environ["CCDT_SERVER"], "--port=0", f"--api-key-file={self.file}"],
                                capture_output=True, text=True, timeout=PATIENCE, check=False)
        self.assertEqual(result.returncode, 1)
        self.assertIn(str(self.file), result.stderr)
        self.assertNotIn(ALICE, result.stderr)

    def test_have_separate_rate_limits(self):
        with Server(f"--api-key-file={self.file}", "--rate-limit=0.001", "--rate-burst=3") as server:
            for key in (ALICE, BOB):
                answers = [ask(server, HALFTONE, *bearer(key), data=GREY) for _ in range(5)]
                self.assertEqual([answer.status for answer in answers], [200] * 3 + [429] * 2)
                self.assertGreaterEqual(int(answers[-1].headers["retry-after"]), 1)
            guesses = [ask(server, HALFTONE, *bearer("guess-0123456789abcdef"), data=GREY).status for _ in range(5)]
            self.assertEqual(guesses, [401] * 3 + [429] * 2)
            for _ in range(10):
                self.assertEqual(ask(server, "/health").status, 200)


class Rates(unittest.TestCase):
    def test_apply_per_address_without_keys(self):
        request = b"GET /nothing HTTP/1.1\r\nHost: localhost\r\n\r\n"
        with Server("--rate-limit=0.001", "--rate-burst=2") as server:
            for source in ("127.0.0.1", "127.0.0.2"):
                with Raw(server, source) as raw:
                    found = []
                    for _ in range(4):
                        raw.send(request)
                        found.append(raw.answer()[0])
                self.assertEqual(found, [404, 404, 429, 429])

    def test_include_preflights(self):
        preflight = (b"OPTIONS /sample HTTP/1.1\r\nHost: localhost\r\nOrigin: https://a.example\r\n"
                     b"Access-Control-Request-Method: POST\r\n\r\n")
        with Server("--rate-limit=0.001", "--rate-burst=2", "--cors-origin=https://a.example") as server:
            with Raw(server) as raw:
                found = []
                for _ in range(4):
                    raw.send(preflight)
                    status, headers, _ = raw.answer()
                    self.assertEqual(headers["Access-Control-Allow-Origin"], "https://a.example")
                    found.append(status)
            self.assertEqual(found, [204, 204, 429, 429])
            self.assertEqual(ask(server, "/health").status, 200)

    def test_are_off_by_default(self):
        with Server() as server, Raw(server) as raw:
            raw.send(b"GET /nothing HTTP/1.1\r\nHost: localhost\r\n\r\n" * 500 + b"GET /nothing HTTP/1.0\r\n\r\n")
            self.assertEqual(statuses(raw.rest()), [404] * 501)


class Origins(ServerCase):
    flags = ("--cors-origin=https://a.example,https://b.example:8443",)

    def from_origin(self, origin, *arguments):
        return self.ask("/halftone", "--header", "Origin: " + origin, *arguments)

    def test_that_are_allowed_are_echoed(self):
        for origin in ("https://a.example", "https://b.example:8443"):
            answer = self.from_origin(origin)
            self.assertEqual(answer.headers["access-control-allow-origin"], origin)
            self.assertEqual(answer.headers["vary"], "Origin")

    def test_that_are_not_allowed_get_no_cors_headers(self):
        for origin in ("https://c.example", "http://a.example", "https://a.example.evil", "null", "*"):
            answer = self.from_origin(origin)
            self.assertNotIn("access-control-allow-origin", answer.headers)
            self.assertEqual(answer.headers["vary"], "Origin")

    def test_may_send_keys(self):
        answer = self.from_origin("https://a.example", "--request", "OPTIONS", "--header",
                                  "Access-Control-Request-Method: POST")
        self.assertEqual(answer.status, 204)
        self.assertIn("Authorization", answer.headers["access-control-allow-headers"])
        self.assertEqual(answer.headers["access-control-allow-origin"], "https://a.example")


class Hosts(unittest.TestCase):
    """Host names of requests. The server checks them, because foreign names may resolve to loopback, too."""

    def statuses(self, server, *hosts):
        return [ask(server, "/capabilities", "--header", f"Host: {host}").status for host in hosts]

    def test_must_be_loopback_if_bound_to_loopback(self):
        with Server() as server:
            port = server.port
            good = (f"localhost:{port}", f"127.0.0.1:{port}", f"[::1]:{port}", "localhost", "127.0.0.1")
            self.assertEqual(self.statuses(server, *good), [200] * len(good))
            bad = (f"evil.example:{port}", "evil.example", f"127.0.0.1.evil.example:{port}", "10.0.0.1", "localhost:x")
            self.assertEqual(self.statuses(server, *bad), [421] * len(bad))
            answer = post_json(server, "/sample", {"sites": 2}, "--header", "Host: evil.example")
            self.assertEqual((answer.status, answer.type), (421, "application/problem+json"))
            self.assertIn("allowed-host", answer.json()["detail"])
            self.assertEqual(ask(server, "/health", "--header", "Host: balancer").status, 200)
            with Raw(server) as raw:
                raw.send(b"GET /capabilities HTTP/1.0\r\n\r\n")
                self.assertEqual(statuses(raw.rest()), [200])
            server.wait_for_log("--allowed-host")
            self.assertEqual(server.log().count("--allowed-host"), 1)

    def test_must_be_listed_if_names_are_configured(self):
        with Server(environment={"CCDT_ALLOWED_HOST": "dots.example,b.example"}) as server:
            self.assertEqual(self.statuses(server, "dots.example", "B.example:80", "localhost", "a.dots.example"),
                             [200, 200, 200, 421])
        with Server("--allowed-host=*") as server:
            self.assertEqual(self.statuses(server, "evil.example"), [200])

    def test_are_unrestricted_on_other_addresses_by_default(self):
        with Server("--bind=0.0.0.0") as server:
            self.assertEqual(self.statuses(server, "evil.example"), [200])
        with Server("--bind=0.0.0.0", "--allowed-host=dots.example") as server:
            self.assertEqual(self.statuses(server, "dots.example", "localhost", "evil.example"), [200, 200, 421])


class OriginsOfThisMachine(ServerCase):
    def preflight(self, origin):
        return self.ask("/halftone", "--request", "OPTIONS", "--header", "Origin: " + origin, "--header",
                        "Access-Control-Request-Method: POST")

    def test_are_allowed_if_bound_to_loopback(self):
        for origin in ("http://localhost:5500", "http://127.0.0.1:3000", "http://[::1]", "https://app.localhost"):
            answer = self.preflight(origin)
            self.assertEqual(answer.headers["access-control-allow-origin"], origin)
            self.assertEqual(answer.headers["access-control-allow-methods"], "POST, OPTIONS")

    def test_others_are_refused_and_logged_once(self):
        for origin in ("https://a.example", "http://127.0.0.1.example", "null"):
            self.assertNotIn("access-control-allow-origin", self.preflight(origin).headers)
        self.server.wait_for_log("--cors-origin https://a.example would allow it")
        self.assertEqual(self.server.log().count("would allow it"), 1)

    def test_are_refused_if_bound_to_other_addresses(self):
        with Server("--bind=0.0.0.0") as server:
            answer = ask(server, "/halftone", "--request", "OPTIONS", "--header", "Origin: http://localhost:5500",
                         "--header", "Access-Control-Request-Method: POST")
            self.assertNotIn("access-control-allow-origin", answer.headers)
            server.wait_for_log("--cors-origin http://localhost:5500 would allow it")


class Compression(ServerCase):
    body = {"sites": 2000, "iterations": 1, "domain": {"type": "torus", "width": 1, "height": 1}}

    def get(self, accepted, body=None):
        header = ("--header", "Accept-Encoding: " + accepted) if accepted else ()
        return post_json(self.server, "/sample", body or self.body, *header)

    def test_is_applied_on_request(self):
        plain = self.get(None)
        self.assertNotIn("content-encoding", plain.headers)
        for accepted in ("gzip", "deflate, gzip;q=0.5", "*", "GZIP", "gzip;q=1.0, identity;q=0.5"):
            answer = self.get(accepted)
            self.assertEqual(answer.headers["content-encoding"], "gzip", accepted)
            self.assertEqual(answer.headers["vary"], "Accept, Accept-Encoding, Origin")
            self.assertLess(len(answer.body), 0.6 * len(plain.body))
            self.assertEqual(json.loads(gzip.decompress(answer.body))["points"], plain.json()["points"])

    def test_is_not_applied_otherwise(self):
        for accepted in ("", "br", "gzip;q=0", "*;q=0", "identity", "gzip;q=0.1, identity", "gzip;q=x", "deflate"):
            answer = self.get(accepted)
            self.assertNotIn("content-encoding", answer.headers, accepted)
            self.assertEqual(answer.headers["vary"], "Accept, Accept-Encoding, Origin")

    def test_skips_small_answers_and_pictures(self):
        for answer in (self.ask("/health", "--header", "Accept-Encoding: gzip"),
                       self.ask("/halftone?sites=5000", "--header", "Accept-Encoding: gzip", data=GREY)):
            self.assertEqual(answer.status, 200)
            self.assertNotIn("content-encoding", answer.headers)
            self.assertNotIn("Accept-Encoding", answer.headers["vary"])


class Log(unittest.TestCase):
    trace = "0af7651916cd43dd8448eb211c80319c"
    parent = "b7ad6b7169203331"

    def ask_all(self, server):
        server.wait_for_log("pictures are decoded")
        ask(server, "/health", "--header", f"traceparent: 00-{self.trace}-{self.parent}-01")
        for bad in ("00-" + "0" * 32 + f"-{self.parent}-01", f"00-{self.trace.upper()}-{self.parent}-01",
                    f"ff-{self.trace}-{self.parent}-01", "evil\x1b[31m\t\"}", f"00-{self.trace}-{self.parent}-01-x"):
            ask(server, "/health", "--header", "traceparent: " + bad)
        with Raw(server) as raw:
            raw.send(b'GET /a"\\b?\xff%0a%1b[1m HTTP/1.1\r\nHost: localhost\r\nX-Request-ID: evil"\r\nUser-Agent: evil\r\n'
                     b"Authorization: Bearer evil\r\n\r\nevil HTTP\r\n\r\n")
            raw.rest()
        ask(server, "/sample", data=b'{"evil\x1b[31m\n":1}')

    def test_has_traces_and_escapes_everything(self):
        with Server() as server:
            self.ask_all(server)
            self.assertEqual(server.stop(), 0)
            lines = server.log().splitlines()
        self.assertEqual([line for line in lines if "trace" in line],
                         [line for line in lines if f" trace={self.trace} parent={self.parent}" in line])
        self.assertEqual(sum("trace=" in line for line in lines), 1)
        self.check_clean(server.log(), lines)

    def test_has_traces_in_json(self):
        with Server("--log-format=json") as server:
            self.ask_all(server)
            self.assertEqual(server.stop(), 0)
            lines = [json.loads(line) for line in server.log().splitlines()]
        requests = [line for line in lines if line["message"] == "request"]
        self.assertEqual((requests[0]["trace"], requests[0]["parent"]), (self.trace, self.parent))
        self.assertTrue(all("trace" not in line for line in requests[1:]))
        self.check_clean(server.log(), lines)

    def check_clean(self, log, lines):
        self.assertEqual(len(lines), 13, "two lines at the start, two at the end, and one for each request")
        self.assertNotRegex(log, r"[^\x20-\x7e\n]")
        self.assertNotIn("evil\"", log)
        self.assertNotIn("Bearer", log)


if __name__ == "__main__":
    unittest.main(verbosity=2)
