# SPDX-License-Identifier: GPL-3.0-or-later
"""Clients behind proxies: which headers about addresses count, and the limits for these addresses."""

import json
import pathlib
import tempfile
import unittest

from harness import Call, Server, ask, wait_until
from raw import Raw, statuses
from test_lifecycle import ENDLESS, JSON

TRUSTED = "--trusted-proxy=127.0.0.1,10.0.0.0/8"
STRANGER = "127.0.0.9"  # not trusted

SIGNATURE = b"\r\n\r\n\x00\r\nQUIT\n"


def request(path="/nothing", *headers):
    return "".join(f"{line}\r\n" for line in (f"GET {path} HTTP/1.1", "Host: localhost", *headers, "")).encode()


def line(client):
    """Returns a PROXY header, version 1."""
    family = "TCP6" if ":" in client else "TCP4"
    return f"PROXY {family} {client} {client} 4711 80\r\n".encode()


def message(client):
    """Returns a PROXY header, version 2, of an IPv4 address."""
    addresses = bytes(map(int, client.split("."))) * 2 + (4711).to_bytes(2, "big") + (80).to_bytes(2, "big")
    return SIGNATURE + b"\x21\x11" + len(addresses).to_bytes(2, "big") + addresses


def statuses_of(server, *requests, source=None):
    """Sends requests one after another over one connection, and returns the statuses of the answers."""
    found = []
    with Raw(server, source) as raw:
        for one in requests:
            raw.send(one)
            found.append(raw.answer()[0])
    return found


class Named(unittest.TestCase):
    """Addresses in the log."""

    def seen(self, server, *parts, source=None):
        """Sends a request as bytes, and returns the client in its log line."""
        path = f"/seen-{len(server.log())}"
        with Raw(server, source) as raw:
            for part in parts:
                raw.send(part.replace(b"/nothing", path.encode()))
            self.assertEqual(raw.answer()[0], 404)
        return server.wait_for_log(f"GET {path} ").split(" GET ")[0].split()[-1]

    def test_by_headers(self):
        with Server(TRUSTED) as server:
            for expected, *headers in (("203.0.113.7", "X-Forwarded-For: 203.0.113.7"),
                                       ("203.0.113.7", "x-forwarded-for: 1.2.3.4, 203.0.113.7, 10.1.1.1"),
                                       ("203.0.113.7", "X-Forwarded-For: 1.2.3.4", "X-Forwarded-For: 203.0.113.7"),
                                       ("2001:db8::7", "Forwarded: for=1.2.3.4, for=\"[2001:db8::7]:80\";proto=https"),
                                       ("203.0.113.7", "Forwarded: for=203.0.113.7", "X-Forwarded-For: 203.0.113.7"),
                                       ("10.1.1.1", "X-Forwarded-For: 203.0.113.7, nonsense, 10.1.1.1")):
                with self.subTest(headers=headers):
                    self.assertEqual(self.seen(server, request("/nothing", *headers)), expected)
            for headers in (["X-Forwarded-For: nonsense"], ["Forwarded: for=unknown"], ["X-Real-IP: 1.2.3.4"],
                            ["Forwarded: for=1.2.3.4", "X-Forwarded-For: 203.0.113.7"]):
                with self.subTest(headers=headers):
                    self.assertRegex(self.seen(server, request("/nothing", *headers)), r"^127\.0\.0\.1(:\d+)?$")

    def test_by_the_proxy_protocol(self):
        with Server(TRUSTED) as server:
            plain = request()
            self.assertEqual(self.seen(server, line("203.0.113.7") + plain), "203.0.113.7:4711")
            self.assertEqual(self.seen(server, line("2001:db8::7"), plain), "[2001:db8::7]:4711")
            self.assertEqual(self.seen(server, message("203.0.113.7") + plain), "203.0.113.7:4711")
            self.assertEqual(self.seen(server, message("203.0.113.7")[:9], message("203.0.113.7")[9:], plain),
                             "203.0.113.7:4711")
            for check in (b"PROXY UNKNOWN\r\n", SIGNATURE + b"\x20\x00\x00\x00"):
                self.assertRegex(self.seen(server, check, plain), r"^127\.0\.0\.1:\d+$")

    def test_by_the_proxy_protocol_before_headers(self):
        with Server(TRUSTED) as server:
            spoof = request("/nothing", "X-Forwarded-For: 1.2.3.4")
            self.assertEqual(self.seen(server, line("203.0.113.7"), spoof), "203.0.113.7:4711")
            self.assertEqual(self.seen(server, line("10.1.1.1"), spoof), "1.2.3.4", "of a proxy behind the proxy")

    def test_not_by_untrusted_peers(self):
        with Server(TRUSTED) as server:
            headers = ("X-Forwarded-For: 203.0.113.7", "Forwarded: for=203.0.113.7")
            self.assertRegex(self.seen(server, request("/nothing", *headers), source=STRANGER), r"^127\.0\.0\.9:\d+$")
            for start in (line("203.0.113.7"), message("203.0.113.7")):
                with Raw(server, STRANGER) as raw:
                    raw.send(start + request())
                    self.assertEqual(statuses(raw.rest()), [400])
        with Server() as server:
            self.assertRegex(self.seen(server, request("/nothing", *headers)), r"^127\.0\.0\.1:\d+$")
            with Raw(server) as raw:
                raw.send(line("203.0.113.7") + request())
                self.assertEqual(statuses(raw.rest()), [400])

    def test_over_a_unix_socket(self):
        with tempfile.TemporaryDirectory() as folder:
            bind = f"--bind=unix:{pathlib.Path(folder) / 'socket'}"
            headers = request("/nothing", "X-Forwarded-For: 203.0.113.7")
            with Server(bind, "--trusted-proxy=unix") as server:
                self.assertEqual(self.seen(server, headers), "203.0.113.7")
                self.assertEqual(self.seen(server, line("203.0.113.7"), request()), "203.0.113.7:4711")
            with Server(bind, TRUSTED) as server:
                self.assertEqual(self.seen(server, headers), "unix")

    def test_not_by_a_malformed_proxy_header(self):
        with Server(TRUSTED) as server:
            for broken in (b"PROXY TCP4 203.0.113.7\r\n", b"PROXY TCP4 " + b"1" * 200, SIGNATURE + b"\x41\x11\x00\x00",
                           SIGNATURE + b"\x21\x11\x00\x01x"):
                with Raw(server) as raw:
                    raw.send(broken + request())
                    self.assertEqual(statuses(raw.rest()), [400])
            twice = line("203.0.113.7") + line("203.0.113.8") + request()
            with Raw(server) as raw:
                raw.send(twice)
                self.assertEqual(statuses(raw.rest()), [400])


class Counted(unittest.TestCase):
    def test_rates_apply_per_client(self):
        with Server(TRUSTED, "--rate-limit=0.001", "--rate-burst=2") as server:
            for client in ("203.0.113.7", "203.0.113.8"):
                requests = [request("/nothing", f"X-Forwarded-For: {invented}, {client}")
                            for invented in ("1.2.3.4", "1.2.3.5", "1.2.3.6")]
                self.assertEqual(statuses_of(server, *requests), [404, 404, 429])
            self.assertEqual(statuses_of(server, line("203.0.113.9") + request(), request(), request()), [404, 404, 429])
            spoofed = [request("/nothing", f"X-Forwarded-For: 1.2.3.{last}") for last in range(3)]
            self.assertEqual(statuses_of(server, *spoofed, source=STRANGER), [404, 404, 429])
            network = [request("/nothing", f"X-Forwarded-For: 2001:db8::{last}") for last in (1, 2, 3)]
            self.assertEqual(statuses_of(server, *network), [404, 404, 429], "one client has a network of 64 bits")

    def test_concurrent_requests_are_limited_per_client(self):
        def request_of(client):
            return request("/health", f"X-Forwarded-For: {client}")

        slow = (b"POST /halftone HTTP/1.1\r\nHost: localhost\r\nX-Forwarded-For: 1.2.3.4, 203.0.113.7\r\nContent-Length: 9\r\n"
                b"Expect: 100-continue\r\n\r\n")
        with Server(TRUSTED, "--max-connections-per-address=1") as server, Raw(server) as first, Raw(server) as second:
            first.send(slow)
            self.assertIn(b"100 Continue", first.socket.recv(100))
            for client, status in (("203.0.113.8", 200), ("203.0.113.7", 503)):
                second.send(request_of(client))
                self.assertEqual(second.answer()[0], status)
            with Raw(server) as third:
                third.send(request_of("203.0.113.7"))
                self.assertIn("max-connections-per-address", json.loads(third.answer()[2])["detail"])
            first.send(b"x" * 9)
            self.assertEqual(first.answer()[0], 415)
            # The connection counts until the server has noticed the end of the answer.
            wait_until(lambda: statuses_of(server, request_of("203.0.113.7")) == [200])

    def test_connections_are_limited_per_client(self):
        with Server(TRUSTED, "--max-connections-per-address=1") as server, Raw(server) as first:
            first.send(line("203.0.113.7") + request("/health"))
            self.assertEqual(first.answer()[0], 200)
            for header, status in ((line("203.0.113.7"), 503), (message("203.0.113.7"), 503), (line("203.0.113.8"), 200),
                                   (b"", 200)):
                self.assertEqual(statuses_of(server, header + request("/health")), [status])

    def test_proxies_are_not_limited(self):
        with Server(TRUSTED, "--max-connections-per-address=1") as server, Raw(server) as one, Raw(server) as two:
            for raw in (one, two):
                raw.send(request("/health"))
                self.assertEqual(raw.answer()[0], 200)

    def test_queueing_is_fair_per_client(self):
        def probe(client):
            return ask(server, "/halftone?nonsense=1", "--header", f"X-Forwarded-For: {client}", data=b"x" * 70_000)

        with Server(TRUSTED, "--workers=1", "--queue=6", "--timeout=300") as server:
            calls = [Call(server.url("/sample"), *JSON, "--header", "X-Forwarded-For: 203.0.113.7", data=ENDLESS)
                     for _ in range(7)]
            wait_until(lambda: probe("203.0.113.7").status == 429)
            self.assertEqual(probe("203.0.113.8").status, 400, "another client must be admitted")
            self.assertEqual(probe("1.2.3.4, 203.0.113.7").status, 429, "a forged address must not be used")
            for call in calls:
                call.abandon()


if __name__ == "__main__":
    unittest.main(verbosity=2)
