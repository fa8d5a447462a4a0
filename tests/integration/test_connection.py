# SPDX-License-Identifier: GPL-3.0-or-later
"""Traffic on one connection: keep-alive, pipelining, unread bodies, malformed requests."""

import http.client
import unittest

from harness import PATIENCE, ServerCase, file_of, flat
from raw import Raw, statuses

GREY = file_of(flat(128))


class KeepAlive(ServerCase):
    def test_many_requests_on_one_connection(self):
        connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=PATIENCE)
        connection.connect()
        client = connection.sock
        for i in range(200):
            if i % 2:
                connection.request("POST", "/halftone?sites=5&scale=1", GREY)
            else:
                connection.request("GET", "/health")
            answer = connection.getresponse()
            self.assertEqual(answer.status, 200)
            answer.read()
            self.assertIs(connection.sock, client, "the server closed the connection")
        connection.close()

    def test_pipelined_requests_are_all_answered_in_order(self):
        post = b"POST /halftone?sites=0 HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\n\r\n%s" % (len(GREY), GREY)
        chunked = b"POST /sample HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n"
        with Raw(self.server) as raw:
            raw.send(b"GET /health HTTP/1.1\r\nHost: localhost\r\n\r\n" + post + chunked +
                     b"GET /no HTTP/1.1\r\nHost: localhost\r\n\r\n"
                     b"GET /health/ready HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\nGET /health HTTP/1.1\r\n\r\n")
            self.assertEqual(statuses(raw.rest()), [200, 400, 400, 404, 200])

    def test_http_1_0_is_closed_after_the_answer(self):
        with Raw(self.server) as raw:
            raw.send(b"GET /health HTTP/1.0\r\n\r\n")
            self.assertEqual(statuses(raw.rest()), [200])

    def test_http_1_0_may_request_keep_alive(self):
        with Raw(self.server) as raw:
            for _ in range(3):
                raw.send(b"GET /health HTTP/1.0\r\nConnection: keep-alive\r\n\r\n")
                status, headers, _ = raw.answer()
                self.assertEqual((status, headers["Connection"]), (200, "keep-alive"))
            raw.send(b"GET /health HTTP/1.0\r\n\r\n")
            self.assertIn(b"\r\nConnection: close\r\n", raw.rest())

    def test_head_and_errors_keep_the_framing(self):
        with Raw(self.server) as raw:
            raw.send(b"HEAD /health HTTP/1.1\r\nHost: localhost\r\n\r\nDELETE /health HTTP/1.1\r\nHost: localhost\r\n\r\n"
                     b"OPTIONS /sample HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n"
                     b"GET /health HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
            received = raw.rest()
        self.assertEqual(statuses(received), [200, 405, 204, 200])
        self.assertEqual(received.count(b'{"status":"live"}'), 1)


class UnreadBodies(ServerCase):
    flags = ("--max-body=1000",)

    def test_are_never_parsed_as_requests(self):
        smuggled = b"GET /health HTTP/1.1\r\nHost: localhost\r\n\r\n"
        for head in (b"POST /no HTTP/1.1\r\nContent-Length: 5000\r\n", b"GET /halftone HTTP/1.1\r\nContent-Length: 5000\r\n",
                     b"POST /halftone HTTP/1.1\r\nContent-Length: 5000\r\n",
                     b"GET /health HTTP/1.1\r\nTransfer-Encoding: chunked\r\n",
                     b"POST /halftone HTTP/1.1\r\nContent-Encoding: gzip\r\nContent-Length: 500\r\n",
                     b"POST /halftone HTTP/1.1\r\nExpect: 100-continue\r\nContent-Length: 5000\r\n"):
            with self.subTest(head=head), Raw(self.server) as raw:
                raw.send(head + b"Host: localhost\r\n\r\n" + smuggled * 3)
                received = raw.rest()
                self.assertEqual(len(statuses(received)), 1)
                self.assertIn(b"\r\nConnection: close\r\n", received)


class Malformed(ServerCase):
    def check(self, request, status=400):
        with Raw(self.server) as raw:
            raw.send(request)
            received = raw.rest()
        self.assertEqual(statuses(received), [status], request[:60])
        self.assertIn(b"application/problem+json", received)
        self.assertIn(b"X-Request-ID: ", received)

    def test_requests_are_refused(self):
        for request in (b"nonsense\r\n\r\n", b"GET /health\r\n\r\n", b"GET /health HTTP/3.0\r\n\r\n",
                        b"GET /health HTTP/1.1\r\nNo colon\r\n\r\n", b"GET /health HTTP/1.1\r\nA: b\r\n c\r\n\r\n",
                        b"GET /health HTTP/1.1\nHost: localhost\n\n\r\n\r\n"):
            with self.subTest(request=request):
                self.check(request)

    def test_lines_without_crlf_are_refused_before_the_end_of_the_head(self):
        for head in (b"GET /health HTTP/1.1\n", b"GET /health HTTP/1.1\r\nHost: localhost\n", b"GET /health HTTP/1.1\r\nA: b\rC",
                     b"GET /health HTTP/1.1\r\nA: \0"):
            with self.subTest(head=head):
                self.check(head)

    def test_targets_must_be_paths_or_urls(self):
        for target in (b"foo?x://y/metrics", b"x://metrics/health/live", b"http:///health", b"http://:80/health", b"health",
                       b"*"):
            with self.subTest(target=target):
                self.check(b"GET " + target + b" HTTP/1.1\r\nHost: localhost\r\n\r\n")
        with Raw(self.server) as raw:
            raw.send(b"GET HTTP://h/health HTTP/1.1\r\nHost: localhost\r\n\r\nOPTIONS * HTTP/1.1\r\nHost: localhost\r\n"
                     b"Connection: close\r\n\r\n")
            self.assertEqual(statuses(raw.rest()), [200, 204])

    def test_ambiguous_lengths_are_refused(self):
        for headers in (b"Content-Length: abc", b"Content-Length: 10abc", b"Content-Length: 1\r\nContent-Length: 1",
                        b"Content-Length: 1\r\nTransfer-Encoding: chunked", b"Transfer-Encoding: gzip"):
            with self.subTest(headers=headers):
                self.check(b"POST /halftone HTTP/1.1\r\nHost: localhost\r\n" + headers + b"\r\n\r\nx")

    def test_malformed_chunks_are_refused(self):
        for chunks in (b"x\r\n", b"-1\r\n", b"1\r\nab\r\n", b"1\n", b"1;a\n\r\n", b"1;a\0\r\n", b"1;a\rb\r\n", b"1;\r\n",
                       b"0\r\nnonsense\r\n\r\n", b"0\r\nA: b\nC: d\r\n\r\n", b"0\r\nContent-Length: 1\r\n\r\n",
                       b"0\r\n\n"):
            with self.subTest(chunks=chunks):
                self.check(b"POST /halftone HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n" + chunks)

    def test_exactly_one_host_is_required(self):
        for hosts in (b"", b"Host: a\r\nHost: a\r\n", b"Host: a b\r\n", b"Host: a/b\r\n", b"Host: u@a\r\n"):
            with self.subTest(hosts=hosts):
                self.check(b"GET /health HTTP/1.1\r\n" + hosts + b"\r\n")

    def test_expectations_other_than_100_continue_are_refused(self):
        self.check(b"POST /halftone HTTP/1.1\r\nHost: localhost\r\nExpect: tea\r\nContent-Length: 1\r\n\r\n", 417)

    def test_long_targets_are_refused(self):
        self.check(b"GET /" + b"x" * 10_000 + b" HTTP/1.1\r\nHost: localhost\r\n\r\n", 414)

    def test_large_heads_are_refused(self):
        for head in (b"GET /" + b"x" * 40_000 + b" HTTP/1.1\r\n", b"GET / HTTP/1.1\r\n" + b"A: b\r\n" * 10_000):
            with self.subTest(head=head[:20]):
                self.check(head + b"\r\n", 431)


if __name__ == "__main__":
    unittest.main(verbosity=2)
