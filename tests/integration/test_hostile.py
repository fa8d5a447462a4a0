# SPDX-License-Identifier: GPL-3.0-or-later
"""Hostile and faulty clients, some of which cpp-httplib alone does not withstand: their answers, delay and cost."""

import gzip
import json
import os
import pathlib
import re
import resource
import signal
import subprocess
import time
import unittest
import zlib

import numpy

from harness import PATIENCE, Call, Server, ServerCase, ask, file_of, flat, post_json, wait_until
from raw import AT_ONCE, MAX_MEMORY_RISE, SANITIZED, Memory, Raw, crowd, ping, statuses

GREY = file_of(flat(128))
RECTANGLE = {"type": "rectangle", "width": 2, "height": 1}
LONG = b"x" * 70_000  # too long for the queue of short requests
ENDLESS = json.dumps({"sites": 100_000, "iterations": 1000, "domain": RECTANGLE})
HALFTONE = b"POST /halftone?sites=10&scale=1 HTTP/1.1\r\nHost: localhost\r\n"


class HostileCase(ServerCase):
    def assert_cheap(self, memory):
        self.assertLess(memory.rise, MAX_MEMORY_RISE)

    def assert_at_once(self, start):
        self.assertLess(time.monotonic() - start, AT_ONCE)

    def assert_refused_at_once(self, data, status):
        start = time.monotonic()
        with Raw(self.server) as raw:
            raw.send(data)
            self.assertEqual(raw.answer()[0], status)
            self.assert_at_once(start)


class SlowClients(HostileCase):
    flags = ("--header-timeout=2", "--body-timeout=1", "--max-body=100MiB")

    def test_silent_connections_delay_nobody(self):
        with Memory(self.server) as memory, crowd(self.server, 200) as clients:
            self.assertLess(ping(self.server), AT_ONCE)
            for client in clients:
                self.assertEqual(client.rest(), b"")
        self.assert_cheap(memory)

    def drip(self, clients):
        """Sends a byte to each client in turn, with a ping in between, until all have been refused."""
        longest = 0
        waiting = list(clients)

        def are_refused():
            nonlocal longest, waiting
            longest = max(longest, ping(self.server))
            waiting = [client for client in waiting if not client.has_news() and client.try_send(b"x")]
            return not waiting

        wait_until(are_refused, "all slow clients to be refused")
        self.assertLess(longest, AT_ONCE)
        for client in clients:
            self.assertEqual(statuses(client.rest()), [408])

    def test_slow_heads_get_a_408(self):
        head = b"GET /health HTTP/1.1\r\nHost: localhost\r\nX: "
        with Memory(self.server) as memory, crowd(self.server, 150, head) as clients:
            self.drip(clients)
        self.assert_cheap(memory)

    def test_slow_bodies_get_a_408(self):
        head = HALFTONE + b"Content-Length: 100000000\r\n\r\n"
        with Memory(self.server) as memory, crowd(self.server, 150, head) as clients:
            self.drip(clients)
        self.assert_cheap(memory)

    def test_slow_chunks_get_a_408(self):
        head = HALFTONE + b"Transfer-Encoding: chunked\r\n\r\n5000000\r\n"
        with crowd(self.server, 10, head) as clients:
            self.drip(clients)

    def test_chunks_of_mostly_framing_are_refused(self):
        with Raw(self.server) as raw:
            raw.send(HALFTONE + b"Transfer-Encoding: chunked\r\n\r\n1;")
            wait_until(lambda: raw.has_news() or not raw.try_send(b"x" * 1000 + b"\r\nx\r\n1;"),
                       "chunks of mostly framing to be refused")
            self.assertEqual(statuses(raw.rest()), [400])


class Bodies(HostileCase):
    flags = ("--max-body=1MiB",)

    def test_a_body_over_the_limit_is_refused_before_it_arrives(self):
        for length in (3 << 20, 100 << 30, (1 << 64) - 1):
            self.assert_refused_at_once(HALFTONE + b"Content-Length: %d\r\n\r\n" % length, 413)

    def test_chunks_count_against_the_limit(self):
        with Memory(self.server) as memory, Raw(self.server) as raw:
            raw.send(HALFTONE + b"Transfer-Encoding: chunked\r\n\r\n")
            sent = 0
            while sent < 500 and not raw.has_news() and raw.try_send(b"40000\r\n" + b"x" * 0x40000 + b"\r\n"):
                sent += 0.25
            self.assertEqual(raw.answer()[0], 413)
            self.assertLess(sent, 20, "MiB that the server took")
        self.assert_cheap(memory)
        self.assert_refused_at_once(HALFTONE + b"Transfer-Encoding: chunked\r\n\r\nffffffff\r\n", 413)

    def test_a_compressed_body_is_refused(self):
        squeezer = zlib.compressobj(wbits=31)
        bomb = b"".join(squeezer.compress(bytes(1 << 20)) for _ in range(300)) + squeezer.flush()
        with Memory(self.server) as memory:
            answer = self.ask("/halftone", "--header", "Content-Encoding: gzip", data=bomb)
            self.assert_problem(answer, 415)
        self.assert_cheap(memory)

    def test_ambiguous_lengths_are_refused(self):
        for headers in (b"Content-Length: abc", b"Content-Length: 10abc", b"Content-Length: 3\r\nContent-Length: 4",
                        b"Content-Length: 3\r\nTransfer-Encoding: chunked"):
            self.assert_refused_at_once(HALFTONE + headers + b"\r\n\r\n", 400)

    def test_a_missing_length_is_refused(self):
        self.assert_refused_at_once(HALFTONE + b"\r\n", 411)

    def test_a_large_body_without_a_type_is_read(self):
        picture = file_of(numpy.random.default_rng(1).integers(0, 256, (200, 200)))
        self.assertGreater(len(picture), 8192)
        self.assertEqual(self.ask("/halftone?sites=10&scale=1", data=picture).status, 200)


class Heads(HostileCase):
    def send_until_refused(self, start, piece):
        with Memory(self.server) as memory, Raw(self.server) as raw:
            raw.send(start)
            wait_until(lambda: raw.has_news() or not raw.try_send(piece), "an endless head to be refused")
            self.assertEqual(statuses(raw.rest()), [431])
        self.assert_cheap(memory)

    def test_a_header_line_without_end_is_refused(self):
        self.send_until_refused(b"GET /health HTTP/1.1\r\nHost: localhost\r\nX: ", b"x" * 65536)

    def test_headers_without_end_are_refused(self):
        self.send_until_refused(b"GET /health HTTP/1.1\r\nHost: localhost\r\n", b"X: y\r\n" * 10_000)

    def test_large_heads_of_many_clients_are_cheap(self):
        head = b"GET /health HTTP/1.1\r\nHost: localhost\r\nX: " + b"x" * 32_000
        with Memory(self.server) as memory, crowd(self.server, 200, head) as clients:
            self.assertLess(ping(self.server), AT_ONCE)
            for client in clients:
                client.send(b"\r\n\r\n")
                self.assertEqual(client.answer()[0], 200)
        self.assert_cheap(memory)

    def test_many_ranges_are_ignored(self):
        body = json.dumps({"sites": 20_000, "iterations": 0, "domain": RECTANGLE})
        ranges = "Range: bytes=" + ",".join(f"{i}-" for i in range(2000))
        whole = post_json(self.server, "/sample", body)
        with Memory(self.server) as memory:
            answer = post_json(self.server, "/sample", body, "--header", ranges)
        self.assertEqual(answer.status, 200)
        self.assertEqual(answer.json()["points"], whole.json()["points"])
        self.assert_cheap(memory)

    def test_long_paths_and_parameters_do_not_overflow_the_stack(self):
        self.assert_problem(self.ask("/" + "a/" * 4000), 404)
        self.assert_problem(self.ask("/" + "a" * 9000), 414)
        kind = "Content-Type: multipart/form-data; boundary=" + "b" * 20_000
        self.assert_problem(self.ask("/halftone", "--header", kind, data=b"x"), 400)
        answer = self.ask("/health", "--header", "Range: bytes=" + "0-1," * 5000)
        self.assertEqual(answer.status, 200)

    def test_request_ids_with_line_ends_are_replaced(self):
        answer = self.ask("/health", "--header", "X-Request-ID: a%0d%0aEvil: 1")
        self.assertRegex(answer.headers["x-request-id"], r"^[0-9a-f]+-[0-9a-f]+$")
        self.assertNotIn("evil", answer.headers)


class Connections(HostileCase):
    def test_an_unread_body_is_not_parsed_as_a_request(self):
        with Server("--workers=1", "--queue=0", "--timeout=300") as server:
            busy = Call(server.url("/sample"), "--header", "Content-Type: application/json", data=ENDLESS)
            wait_until(lambda: ask(server, "/halftone?nonsense=1", data=LONG).status == 429)
            hidden = b"GET /health HTTP/1.1\r\nHost: localhost\r\n\r\n"
            with Raw(server) as raw:
                count = len(LONG) // len(hidden)
                raw.send(HALFTONE + b"Content-Length: %d\r\n\r\n" % (count * len(hidden)) + hidden * (count + 1))
                self.assertEqual(statuses(raw.rest()), [429])
            busy.abandon()

    def test_pipelined_requests_are_all_answered(self):
        with Raw(self.server) as raw:
            raw.send(b"GET /health HTTP/1.1\r\nHost: localhost\r\n\r\n" * 30 + b"GET /no HTTP/1.0\r\n\r\n")
            self.assertEqual(statuses(raw.rest()), [200] * 30 + [404])

    def test_small_answers_are_not_delayed(self):
        with Raw(self.server) as raw:
            durations = []
            for _ in range(101):
                start = time.monotonic()
                raw.send(b"GET /health HTTP/1.1\r\nHost: localhost\r\n\r\n")
                self.assertEqual(raw.answer()[0], 200)
                durations.append(time.monotonic() - start)
        self.assertLess(sorted(durations)[50], 0.02)

    def test_a_connection_serves_a_hundred_requests(self):
        with Raw(self.server) as raw:
            for _ in range(100):
                raw.send(b"GET /health HTTP/1.1\r\nHost: localhost\r\n\r\n")
                self.assertEqual(raw.answer()[0], 200)

    def test_connections_queue_while_the_server_is_busy(self):
        self.server.signal(signal.SIGSTOP)
        start = time.monotonic()
        with crowd(self.server, 300, b"GET /health HTTP/1.1\r\nHost: localhost\r\n\r\n") as clients:
            self.assert_at_once(start)
            self.server.signal(signal.SIGCONT)
            for client in clients:
                self.assertEqual(client.answer()[0], 200)

    def test_a_second_instance_does_not_start(self):
        second = subprocess.run([os.environ["CCDT_SERVER"], f"--port={self.server.port}"], capture_output=True,
                                timeout=PATIENCE, check=False)
        self.assertEqual(second.returncode, 1)
        self.assertIn(b"in use", second.stderr)

    def test_wrong_methods_get_the_allowed_ones(self):
        answer = self.ask("/halftone", "--request", "PUT", data=GREY)
        self.assert_problem(answer, 405)
        self.assertEqual(answer.headers["allow"], "POST, OPTIONS")
        self.assertEqual(self.ask("/halftone", "--request", "OPTIONS").status, 204)

    def test_a_leaving_client_frees_its_worker(self):
        with Server("--workers=1", "--queue=0", "--timeout=300") as server:
            call = Call(server.url("/sample"), "--header", "Content-Type: application/json", data=ENDLESS)
            wait_until(lambda: ask(server, "/halftone?nonsense=1", data=LONG).status == 429)
            call.abandon()
            server.wait_for_log(" 499 ")
            wait_until(lambda: ask(server, "/halftone?nonsense=1", data=LONG).status != 429)

    def test_a_client_that_leaves_during_its_body_affects_no_other(self):
        body = b'{"sites":10,"polygon":[' + b"[0,0]," * 1_000_000 + b"0]}"
        head = b"POST /sample HTTP/1.1\r\nHost: localhost\r\nAccept: application/json;q=0.9, text/plain;q=0.5\r\n"
        with Server("--workers=2", "--timeout=300") as server:
            for _ in range(5):
                with Raw(server) as raw:
                    raw.send(head + b"Content-Length: %d\r\n\r\n" % len(body) + body)
            wait_until(lambda: server.process.poll() is not None or len(re.findall(" (?:499|400) ", server.log())) >= 5,
                       "five abandoned or refused requests in the log")
            self.assertIn(" 499 ", server.log(), "no client left while a worker parsed its body")
            # This request is queued behind the bodies that are still being parsed.
            self.assertEqual(post_json(server, "/sample", {"sites": 10, "domain": RECTANGLE}).status, 200)
            self.assertEqual(server.stop(), 0)

    def test_stopping_does_not_wait_for_idle_connections(self):
        with Server() as server, crowd(server, 20), Raw(server) as kept:
            kept.send(b"GET /health HTTP/1.1\r\nHost: localhost\r\n\r\n")
            self.assertEqual(kept.answer()[0], 200)
            start = time.monotonic()
            self.assertEqual(server.stop(), 0)
            self.assertLess(time.monotonic() - start, 3)


class Failures(HostileCase):
    @unittest.skipIf(SANITIZED, "sanitizers end the program when memory is short")
    def test_exceptions_are_neither_shown_nor_fatal(self):
        with Server("--workers=1") as server:
            pid = server.process.pid
            ask(server, "/halftone?sites=10&scale=1", data=GREY)
            pages = pathlib.Path(f"/proc/{pid}/statm").read_text().split()[0]
            size = int(pages) * resource.getpagesize()
            limit = resource.prlimit(pid, resource.RLIMIT_AS)
            resource.prlimit(pid, resource.RLIMIT_AS, (size + (16 << 20), limit[1]))
            # Answers of any size are streamed, but a request must be parsed as a whole.
            values = {"width": 2000, "height": 2000, "values": [1] * 4_000_000}
            answer = post_json(server, "/sample", {"sites": 10, "domain": RECTANGLE, "density": values})
            resource.prlimit(pid, resource.RLIMIT_AS, limit)
            self.assert_problem(answer, 500)
            self.assertNotIn("alloc", str(answer))
            self.assertNotIn("exception_what", answer.headers)
            server.wait_for_log("bad_alloc")
            self.assertEqual(ask(server, "/halftone?sites=10&scale=1", data=GREY).status, 200)


class Encodings(HostileCase):
    def test_compression_is_never_brotli_and_costs_little(self):
        body = {"sites": 50_000, "iterations": 0, "domain": RECTANGLE}
        plain = post_json(self.server, "/sample", body)
        for wanted, coding in (("br", None), ("gzip, deflate, br, zstd", "gzip")):
            answer = post_json(self.server, "/sample", body, "--header", "Accept-Encoding: " + wanted)
            self.assertEqual(answer.headers.get("content-encoding"), coding)
            unpacked = gzip.decompress(answer.body) if coding else answer.body
            self.assertEqual(json.loads(unpacked)["points"], plain.json()["points"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
