# SPDX-License-Identifier: GPL-3.0-or-later
"""Hostile and broken clients, each with its expected outcome."""

import collections
import contextlib
import json
import pathlib
import random
import select
import socket
import struct
import sys
import time
import typing
import zlib

from cases import ENDLESS, JSON, LARGE, LARGER, LETTER, RECTANGLE, TORUS, essence, grey_png, picture, small
from load import TIME_LIMIT, ServerGone, Tally, pause, repeat, run_threads

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
from harness import wait_until  # pylint: disable=wrong-import-position
from raw import Raw, statuses  # pylint: disable=wrong-import-position

# Flags of the server under load. Each slow client takes this many seconds.
HEADER_TIMEOUT = 3
BODY_TIMEOUT = 3
FLAGS = (f"--header-timeout={HEADER_TIMEOUT}", f"--body-timeout={BODY_TIMEOUT}", "--max-body=8MiB", "--timeout=300")

PATIENCE = TIME_LIMIT / 2
LISTENERS = 100
HEALTH = b"GET /health HTTP/1.1\r\nHost: localhost\r\n\r\n"
BUSY = {429, 503}  # statuses if the queue is full


class Address(typing.NamedTuple):
    """The part of a server's interface that Raw needs."""
    port: int
    path: str | None = None


class Unexpected(Exception):
    """The outcome of a client is not the expected one."""


class Abuser:
    """A client with an address of its own."""

    def __init__(self, port, number, known):
        self.server = Address(port)
        self.number = number
        self.source = f"127.0.4.{number}"
        self.known = known
        self.random = random.Random(number)

    @contextlib.contextmanager
    def connect(self, data=b""):
        try:
            raw = Raw(self.server, self.source)
        except ConnectionRefusedError as error:
            raise ServerGone from error
        raw.socket.settimeout(PATIENCE)
        with raw:
            raw.try_send(data)
            yield raw

    def expect(self, data, *wanted):
        """Sends data in one piece. The answers must have these statuses, in order, and then the connection must end."""
        with self.connect(data) as raw:
            expect(raw, [wanted])

    def ask(self, path, body, *wanted):
        """Sends an ordinary request, whose answer must have one of these statuses."""
        with self.connect(post(path, body)) as raw:
            status, _, received = raw.answer()
        if status not in {*wanted, *BUSY}:
            raise Unexpected(f"{status} in place of {wanted}: {received[:200]}")


def post(path, body, *headers):
    kind = "application/octet-stream" if path.startswith("/halftone") else JSON["Content-Type"]
    lines = (f"POST {path} HTTP/1.1", "Host: localhost", f"Content-Type: {kind}", f"Content-Length: {len(body)}", *headers)
    return "\r\n".join(lines).encode() + b"\r\n\r\n" + body


def expect(raw, allowed):
    received = raw.rest()
    if tuple(statuses(received)) not in allowed:
        raise Unexpected(f"{received[:200]} in place of {allowed}")


def wait_for_news(raw, seconds=PATIENCE):
    return bool(select.select([raw.socket], [], [], seconds)[0])


def drip(raw, piece, seconds):
    """Sends a piece repeatedly, with pauses, until the server answers."""
    end = time.monotonic() + PATIENCE
    while not wait_for_news(raw, seconds) and time.monotonic() < end:
        if not raw.try_send(piece):
            return


def send_until_answered(raw, piece):
    """Sends a piece repeatedly until the server answers or accepts no more data."""
    wait_until(lambda: raw.has_news() or not raw.try_send(piece), "the server to refuse an endless request")


def leave(raw, abruptly):
    if abruptly:  # resets the connection, which discards data in transfer
        raw.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    raw.socket.close()


def say_nothing(me):
    with me.connect(b"GET /health HT") as raw:
        expect(raw, [(), (408,)])


def slow_head(me):
    with me.connect(b"GET /health HTTP/1.1\r\nHost: localhost\r\nX: ") as raw:
        drip(raw, b"x", 0.1)
        expect(raw, [(408,)])


def slow_body(me):
    with me.connect(b"POST /halftone HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000\r\n\r\n") as raw:
        drip(raw, b"x", 0.1)
        expect(raw, [(408,), (429,), (503,)])


def slow_chunks(me):
    with me.connect(b"POST /sample HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n") as raw:
        drip(raw, b"1\r\n \r\n", 0.1)
        expect(raw, [(408,), (429,), (503,)])


def leave_while_it_computes(me):
    with me.connect(post("/sample", ENDLESS.body)) as raw:
        wait_for_news(raw, me.random.uniform(0, 0.4))
        leave(raw, me.random.random() < 0.5)


def leave_while_it_decodes(me):
    with me.connect(post("/halftone", picture("astronaut.png"))) as raw:
        wait_for_news(raw, me.random.uniform(0, 0.05))
        leave(raw, me.random.random() < 0.5)


def leave_while_it_answers(me):
    with me.connect(post("/sample", LARGE.body)) as raw:
        raw.socket.recv(me.random.randint(1, 20_000))
        leave(raw, me.random.random() < 0.5)


def leave_while_sending(me):
    data = post("/halftone", picture("camera.png"))
    with me.connect(data[:me.random.randint(1, len(data) - 1)]) as raw:
        leave(raw, me.random.random() < 0.5)


def read_slowly(me):
    """Receives slowly, but above the minimum rate: the whole answer must arrive and be right."""
    with me.connect() as raw:
        raw.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 65_536)
        raw.send(post("/sample", LARGE.body, "Connection: close"))
        received = b""
        while piece := raw.socket.recv(65_536):
            received += piece
            time.sleep(0.02)
    if statuses(received[:100]) == [200] and essence(received).endswith(me.known[LARGE.name]):
        return
    if statuses(received[:100])[:1] != [503] and statuses(received[:100])[:1] != [429]:
        raise Unexpected(f"{received[:200]} and {len(received)} bytes in all")


def stop_reading(me):
    with me.connect() as raw:
        raw.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 65_536)
        raw.send(post("/sample", LARGER.body))
        wait_for_news(raw)
        time.sleep(2 * BODY_TIMEOUT + 1)
        received = raw.rest()
    if statuses(received[:100])[:1] == [200] and received.endswith(b"}"):
        raise Unexpected("all was delivered to a client that did not read")


def speak_garbage(me):
    with me.connect(b"\x16\x03\x01" + me.random.randbytes(me.random.randint(1, 5000)) + b"\r\n\r\n") as raw:
        raw.socket.shutdown(socket.SHUT_WR)
        expect(raw, [(400,), (431,), (414,), (), (505,)])


def smuggle(me):
    hidden = b"GET /smuggled HTTP/1.1\r\nHost: localhost\r\n\r\n"
    for headers in (b"Content-Length: 4\r\nTransfer-Encoding: chunked", b"Content-Length: 4\r\nContent-Length: 5",
                    b"Content-Length: +4", b"Content-Length: 4, 5", b"Content-Length: 0x4", b"Content-Length : 4",
                    b"Transfer-Encoding: xchunked", b"Transfer-Encoding: chunked\r\nTransfer-Encoding: identity"):
        with me.connect(b"POST /sample HTTP/1.1\r\nHost: localhost\r\n" + headers + b"\r\n\r\n0\r\n\r\n" + hidden) as raw:
            expect(raw, [(400,), (501,)])


def send_huge_heads(me):
    me.expect(b"GET /health HTTP/1.1\r\nHost: localhost\r\nX: " + b"x" * 300_000, 431)
    me.expect(b"GET /health HTTP/1.1\r\nHost: localhost\r\n" + b"X: y\r\n" * 50_000, 431)


def send_too_much(me):
    head = b"POST /halftone HTTP/1.1\r\nHost: localhost\r\n"
    for length in (9 << 20, 100 << 30, (1 << 64) - 1):
        me.expect(head + b"Content-Length: %d\r\n\r\n" % length, 413)
    me.expect(head + b"Transfer-Encoding: chunked\r\n\r\nffffffff\r\n", 413)
    with me.connect(head + b"Transfer-Encoding: chunked\r\n\r\n") as raw:
        send_until_answered(raw, b"40000\r\n" + bytes(0x40000) + b"\r\n")
        expect(raw, [(413,), (429,), (503,)])


def send_chunks_of_framing(me):
    with me.connect(b"POST /halftone HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n1;") as raw:
        send_until_answered(raw, b"x" * 1000 + b"\r\nx\r\n1;")
        expect(raw, [(400,), (429,), (503,)])


def send_broken_pictures(me):
    good = picture("camera.png")
    me.ask("/halftone", good[:me.random.randint(200, len(good) - 200)], 422)
    me.ask("/halftone", b"no picture at all", 415, 422)
    at = me.random.randint(100, len(good) - 100)
    me.ask("/halftone?sites=10&scale=1", good[:at] + me.random.randbytes(8) + good[at + 8:], 200, 422)


def send_bombs(me):
    def header(width, height):
        size = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
        return b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + size + struct.pack(">I", zlib.crc32(size))

    me.ask("/halftone", header(60_000, 60_000) + grey_png(1, 1)[33:], 413)
    me.ask("/halftone", header((1 << 31) - 1, (1 << 31) - 1) + grey_png(1, 1)[33:], 413, 422)
    me.ask("/halftone", header(7000, 7000) + grey_png(1, 1)[33:], 422)


def send_bad_polygons(me):
    tangle = [[me.random.random(), me.random.random()] for _ in range(200)]
    for ring in ([[0, 0], [1, 1], [1, 0], [0, 1]], tangle):
        me.ask("/sample", json.dumps({"sites": 9, "polygon": ring, "invalid": "reject"}).encode(), 422)
    for ring in ([[0, 0], [1, 0], [2, 0]], [[0, 0], [1, 0]]):
        me.ask("/sample", json.dumps({"sites": 9, "polygon": ring}).encode(), 400, 422)
    me.ask("/sample", json.dumps({"sites": 9, "polygon": tangle}).encode(), 200)


def send_deep_json(me):
    me.ask("/sample", b'{"polygon":' + b"[" * 500_000, 400)
    me.ask("/sample", b'{"a":' * 100_000 + b"1" + b"}" * 100_000, 400)
    me.ask("/sample", b"[" * 100_000 + b"]" * 100_000, 400)
    me.ask("/analyze", b'{"points":[' + b"[0,1e999]," * 1000 + b"[0,0]]}", 400)


def pipeline(me):
    me.expect(HEALTH * 20 + b"GET /nothing HTTP/1.0\r\n\r\n", *[200] * 20, 404)


def crowd(me):
    """Opens more connections than one address may have: the last ones must be refused, the others answered."""
    with contextlib.ExitStack() as stack:
        clients = [stack.enter_context(me.connect()) for _ in range(80)]
        answered = collections.Counter()
        for client in clients:
            client.try_send(HEALTH)
        for client in clients:
            answered[client.answer()[0]] += 1
    if answered[503] < 80 - 64 or answered[200] + answered[503] != 80:
        raise Unexpected(str(answered))


def bare_line_feeds(me):
    me.expect(HEALTH.replace(b"\r\n", b"\n"), 400)
    me.expect(b"GET /health HTTP/1.1\r\nHost: localhost\nX: y\r\n\r\n", 400)
    chunked = b"POST /sample HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n"
    for body in (b"2;a\n\r\n{}\r\n0\r\n\r\n", b"2;a\rb\r\n{}\r\n0\r\n\r\n", b"2;a\0b\r\n{}\r\n0\r\n\r\n",
                 b"2\n{}\r\n0\r\n\r\n", b"2\r\n{}\n0\r\n\r\n", b"2\r\n{}\r\n0\r\nX: a\nb\r\n\r\n",
                 b"2\r\n{}\r\n0\r\nX: a\0\r\n\r\n", b"2\r\n{}\r\n0\r\nno trailer\r\n\r\n"):
        with me.connect(chunked + body + HEALTH) as raw:
            expect(raw, [(400,), (429,), (503,)])


def name_strange_targets(me):
    for target in (b"foo?x://y/metrics", b"x://metrics/health/live", b"http:///health", b"http:/health", b"//h/health?",
                   b"ftp://h/health"):
        with me.connect(b"GET " + target + b" HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n") as raw:
            expect(raw, [(400,), (404,)])
    me.expect(b"GET http://localhost/health HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n", 200)


def flood_preflights(me):
    """Sends many preflights, which must be answered unless a rate limit refuses them."""
    count = 200
    preflight = (b"OPTIONS /sample HTTP/1.1\r\nHost: localhost\r\nOrigin: https://a.example\r\n"
                 b"Access-Control-Request-Method: POST\r\n")
    with me.connect((preflight + b"\r\n") * (count - 1) + preflight + b"Connection: close\r\n\r\n") as raw:
        answered = statuses(raw.rest())
    if len(answered) != count or not {*answered} <= {204, 429}:
        raise Unexpected(str(collections.Counter(answered)))


def send_dashes(me):
    """Sends a boundary of dashes, and a body of dashes that is searched for it."""
    for length, wanted in ((30_000, (400,)), (71, (400,)), (70, (400, 422))):
        boundary = b"-" * (length - 1) + b"x"
        head = b"POST /halftone HTTP/1.1\r\nHost: localhost\r\nContent-Type: multipart/form-data; boundary=" + boundary
        body = b"-" * 4_000_000
        with me.connect() as raw:
            raw.try_send(head + b"\r\nContent-Length: %d\r\n\r\n" % len(body) + body)
            status, _, received = raw.answer()
        if status not in {*wanted, *BUSY}:
            raise Unexpected(f"{status} in place of {wanted} for a boundary of {length}: {received[:200]}")


def send_tiny_chunks(me):
    """Sends chunks of one byte: a short request must be answered, a long one may be refused for its framing."""
    case = small()[0]
    for body, wanted in ((case.body, (200,)), (bytes(500_000), (400, 415))):
        with me.connect(b"POST %s HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n" %
                        (b"/sample" if body is case.body else b"/halftone")) as raw:
            raw.try_send(b"".join(b"1\r\n%c\r\n" % byte for byte in body) + b"0\r\n\r\n")
            status, _, received = raw.answer()
        if status not in {*wanted, *BUSY} or (status == 200 and essence(received) != me.known[case.name]):
            raise Unexpected(f"{status} in place of {wanted}: {received[:200]}")


def ask_for_tiny_densities(me):
    """Sends extremely small densities, which must be valid because only their ratios matter."""
    domains = ({"domain": TORUS}, {"domain": RECTANGLE}, {"polygon": LETTER})
    for values in ([1e-300, 1e-300], [0, 5e-324], [1e-200, 3e-200]):
        body = {"sites": 64, "density": {"width": 2, "height": 1, "values": values}, **me.random.choice(domains)}
        with me.connect(post("/sample", json.dumps(body).encode())) as raw:
            status, _, received = raw.answer()
        if status not in {200, *BUSY} or b"null" in received:
            raise Unexpected(f"{status} for {body}: {received[:200]}")


def listen_in_crowds(me):
    """Opens many event streams of a job. Each must be admitted or refused with a time to retry; no other client may be
    refused."""
    with me.connect(post("/sample", ENDLESS.body, "Prefer: respond-async", "Connection: close")) as raw:
        status, headers, received = raw.answer()
    if status in BUSY:
        return
    if status != 202:
        raise Unexpected(f"{status} for a job: {received[:200]}")
    path = headers["Location"].encode()
    try:
        with contextlib.ExitStack() as stack:
            clients = [stack.enter_context(Raw(me.server, f"127.0.6.{i + 1}")) for i in range(LISTENERS)]
            for client in clients:
                client.send(b"GET %s/events HTTP/1.1\r\nHost: localhost\r\n\r\n" % path)
                client.socket.settimeout(PATIENCE)
            begun = collections.Counter(client.socket.recv(12) for client in clients)
            me.expect(HEALTH.replace(b"\r\n\r\n", b"\r\nConnection: close\r\n\r\n"), 200)
        if not {*begun} <= {b"HTTP/1.1 200", b"HTTP/1.1 503"}:
            raise Unexpected(str(begun))
    finally:
        me.expect(b"DELETE %s HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n" % path, 204)


SLOW = (say_nothing, slow_head, slow_body, slow_chunks)
READERS = (read_slowly, stop_reading)
VANISHING = (leave_while_it_computes, leave_while_it_decodes, leave_while_it_answers, leave_while_sending)
NONSENSE = (speak_garbage, smuggle, send_huge_heads, send_too_much, send_chunks_of_framing, pipeline, crowd)
UNUSABLE = (send_broken_pictures, send_bombs, send_bad_polygons, send_deep_json, ask_for_tiny_densities)
FRAMING = (bare_line_feeds, name_strange_targets, flood_preflights, send_dashes, send_tiny_chunks)
LISTENING = (listen_in_crowds,)
# Number of simultaneous clients, their acts, and the pause between acts in seconds.
GROUPS = ((8, SLOW, 0), (2, READERS, 0), (2, VANISHING, 0.2), (1, NONSENSE, 0.1), (4, UNUSABLE, 0.1), (1, FRAMING, 0.1),
          (1, LISTENING, 1))


def abuse(me, acts, rest, until, tally):
    turn = iter(range(me.number, 1 << 60))  # so that the clients of a group begin with different acts

    def step():
        act = acts[next(turn) % len(acts)]
        try:
            act(me)
            tally.count(act.__name__)
        except Unexpected as found:
            tally.fail("outcome", f"{act.__name__}: {found}")
        except OSError as error:
            tally.fail("outcome", f"{act.__name__}: {error!r}")
        pause(rest, until)

    repeat(until, tally, step)


def hostile(port, known, until):
    tally = Tally()
    groups = [(acts, rest) for count, acts, rest in GROUPS for _ in range(count)]
    return run_threads(tally, *((abuse, Abuser(port, i + 1, known), acts, rest, until, tally)
                                for i, (acts, rest) in enumerate(groups)))


def everyone_at_once(port, count):
    """Opens the largest number of simultaneous connections of the test. The server creates a thread for each and keeps
    it for a while, so this must precede the warm-up."""
    with contextlib.ExitStack() as stack:
        clients = [stack.enter_context(Raw(Address(port), f"127.0.5.{i % 250 + 1}")) for i in range(count)]
        for client in clients:
            client.send(HEALTH)
        if any(client.answer()[0] != 200 for client in clients):
            raise Unexpected("a client of a crowd was not answered")
