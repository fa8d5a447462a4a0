# SPDX-License-Identifier: GPL-3.0-or-later
"""Time-outs of clients, limits on their number, and the Unix socket."""

import contextlib
import json
import os
import pathlib
import re
import select
import socket
import subprocess
import tempfile
import threading
import time
import unittest

from harness import PATIENCE, Call, Server, ServerCase, ask, execute, file_of, flat, join, wait_until
from raw import AT_ONCE, MAX_MEMORY_RISE, SANITIZED, Memory, Raw, crowd, ping, sources, statuses

GREY = file_of(flat(128))
HEALTH = b"GET /health HTTP/1.1\r\nHost: localhost\r\n\r\n"
INCOMPLETE_BODY = b"POST /sample HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000\r\n\r\n{"
RECTANGLE = {"type": "rectangle", "width": 2, "height": 1}


def post(path, body):
    return b"POST %s HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\n\r\n%s" % (path, len(body), body)


def shrink(raw):
    """Shrinks the buffers of a connection for answers in transfer."""
    raw.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 65_536)


class Deadlines(ServerCase):
    flags = ("--header-timeout=1", "--body-timeout=1", "--idle-timeout=1")

    def test_a_silent_connection_is_closed(self):
        start = time.monotonic()
        with Raw(self.server) as raw:
            self.assertEqual(raw.rest(), b"")
        self.assertGreater(time.monotonic() - start, 0.9)

    def test_an_idle_connection_is_closed(self):
        with Raw(self.server) as raw:
            raw.send(HEALTH)
            self.assertEqual(raw.answer()[0], 200)
            start = time.monotonic()
            self.assertEqual(raw.rest(), b"")
            self.assertGreater(time.monotonic() - start, 0.9)

    def test_a_stalled_body_gets_a_408(self):
        with Raw(self.server) as raw:
            raw.send(post(b"/halftone", GREY)[:-1])
            self.assertEqual(statuses(raw.rest()), [408])

    def test_a_client_that_reads_nothing_loses_its_answer(self):
        body = json.dumps({"sites": 200_000, "iterations": 0, "domain": RECTANGLE}).encode()
        with Raw(self.server) as raw:
            shrink(raw)
            raw.send(post(b"/sample", body))
            self.server.wait_for_log("POST /sample 499")
            self.assertFalse(raw.rest().endswith(b"}"))

    def test_an_answer_waits_for_a_slow_client(self):
        body = json.dumps({"sites": 100_000, "iterations": 0, "domain": RECTANGLE}).encode()
        with Raw(self.server) as raw:
            shrink(raw)
            raw.send(post(b"/sample", body))
            status, _, received = raw.answer()
        self.assertEqual((status, len(json.loads(received)["points"])), (200, 100_000))


class Caps(unittest.TestCase):
    def assert_refused(self, raw):
        status, headers, body = raw.answer()
        self.assertEqual(status, 503)
        self.assertGreaterEqual(int(headers["Retry-After"]), 1)
        self.assertEqual(headers["Connection"], "close")
        self.assertIn("max-connections", json.loads(body)["detail"])
        self.assertEqual(raw.rest(), b"")

    def test_total_connections_are_limited(self):
        with Server("--max-connections=8", "--body-timeout=300") as server, Memory(server) as memory:
            with crowd(server, 8, INCOMPLETE_BODY) as clients:
                for _ in range(20):
                    start = time.monotonic()
                    with Raw(server) as raw:
                        raw.send(b"GET /openapi.json HTTP/1.1\r\nHost: localhost\r\n\r\n")
                        self.assert_refused(raw)
                    self.assertLess(time.monotonic() - start, AT_ONCE)
                server.wait_for_log(" 503 ")
                self.assertEqual([statuses(client.rest()) for client in clients], [[408]] * 8, "their time-outs must have shrunk")
            wait_until(lambda: ask(server, "/openapi.json").status == 200)
        self.assertLess(memory.rise, MAX_MEMORY_RISE)

    def test_a_refused_client_may_send_first(self):
        with Server("--max-connections=1", "--body-timeout=300") as server, Raw(server) as first:
            first.send(INCOMPLETE_BODY)
            answer = ask(server, "/halftone", data=b"x" * 200_000)
            self.assertEqual((answer.status, answer.type), (503, "application/problem+json"))

    def test_connections_per_address_are_limited(self):
        with Server("--max-connections-per-address=3") as server:
            with Raw(server) as one, Raw(server) as two, Raw(server) as three:
                for raw in (one, two, three):
                    raw.send(HEALTH)
                    self.assertEqual(raw.answer()[0], 200)
                with Raw(server) as fourth:
                    status, _, body = fourth.answer()
                    self.assertEqual(status, 503)
                    self.assertIn("max-connections-per-address", json.loads(body)["detail"])
                with Raw(server, "127.0.0.9") as other:
                    other.send(HEALTH)
                    self.assertEqual(other.answer()[0], 200)
            # Connections count until the server has noticed that their clients left.
            wait_until(lambda: ask(server, "/health").status == 200)

    def test_bodies_share_their_memory(self):
        # The minimum is 256 MiB: eight clients have sent 40 MiB each and stopped.
        head = b"POST /halftone HTTP/1.1\r\nHost: localhost\r\nContent-Length: 60000000\r\n\r\n"
        with Server("--body-timeout=300") as server, Memory(server) as memory:
            with crowd(server, 8, head) as clients:
                for client in clients:
                    client.try_send(b"x" * (40 << 20))
                self.assertTrue(any(statuses(client.rest())[-1:] in ([503], [408]) for client in clients))
                self.assertEqual(ask(server, "/halftone?sites=9&scale=1", data=GREY).status, 200)
        self.assertLess(memory.rise, 256 + 2 * MAX_MEMORY_RISE)

    def test_many_slow_clients_block_nobody(self):
        with Server("--workers=1", "--queue=1") as server, crowd(server, 200, INCOMPLETE_BODY), crowd(server, 150, b"GET /"):
            self.assertLess(ping(server), AT_ONCE)
            self.assertEqual(ask(server, "/halftone?sites=10&scale=1", data=GREY).status, 200)


class ConnectionClasses(unittest.TestCase):
    """Health checks, metrics and event streams have connections reserved for them."""

    def begin_job(self, server):
        body = json.dumps({"sites": 100_000, "iterations": 1000, "domain": RECTANGLE})
        answer = ask(server, "/sample", "--header", "Prefer: respond-async", data=body)
        self.assertEqual(answer.status, 202, answer)
        return answer.headers["location"]

    def test_event_streams_take_no_other_connections(self):
        with Server("--max-connections=8", "--max-streams=100") as server:
            job = self.begin_job(server)
            listen = b"GET %s/events HTTP/1.1\r\nHost: localhost\r\n\r\n" % job.encode()
            with contextlib.ExitStack() as stack:
                for _, source in zip(range(100), sources()):
                    listener = stack.enter_context(Raw(server, source))
                    listener.send(listen)
                    self.assertTrue(listener.socket.recv(12).endswith(b" 200"))
                with Raw(server) as late:
                    late.send(listen)
                    status, _, body = late.answer()
                    self.assertEqual(status, 503)
                    self.assertIn("max-streams", json.loads(body)["detail"])
                for path in ("/health/live", "/health/ready", "/metrics", "/openapi.json", job):
                    self.assertEqual(ask(server, path).status, 200)
                figures = ask(server, "/metrics").body.decode()
                self.assertIn("ccdt_event_streams_open 100\n", figures)
                self.assertIn('ccdt_connections_refused_total{reason="streams"} 1\n', figures)
            ask(server, job, "--request", "DELETE")

    def test_health_checks_pass_when_all_connections_are_taken(self):
        # Connections with running computations, which are not closed under pressure.
        endless = json.dumps({"sites": 100_000, "iterations": 1000, "domain": RECTANGLE}).encode()
        with Server("--max-connections=4", "--workers=1", "--queue=4", "--timeout=300") as server:
            job = self.begin_job(server)
            # Connections count until the server has noticed that their clients left. All four must be free.
            wait_until(lambda: "ccdt_connections_open 1\n" in ask(server, "/metrics").body.decode())
            with crowd(server, 4, post(b"/sample", endless)):
                # The server has read all four requests: a connection that is about to be closed takes no place.
                wait_until(lambda: "ccdt_queue_requests 4\n" in ask(server, "/metrics").body.decode())
                self.assertEqual(ask(server, "/openapi.json").status, 503)
                for _ in range(20):
                    for path in ("/health", "/health/live", "/metrics"):
                        answer = ask(server, path)
                        self.assertEqual((answer.status, answer.headers["connection"]), (200, "close"))
                    self.assertEqual(ask(server, job).status, 503)
                with Raw(server) as listener:
                    listener.send(b"GET %s/events HTTP/1.1\r\nHost: localhost\r\n\r\n" % job.encode())
                    self.assertTrue(listener.socket.recv(12).endswith(b" 200"), "streams are not crowded")
            wait_until(lambda: ask(server, job).status == 200)
            ask(server, job, "--request", "DELETE")


class Idle(unittest.TestCase):
    """Connections without a complete request head must not keep other clients out."""

    def test_health_checks_pass_during_a_flood_of_idle_connections(self):
        self.flood(b"")

    def test_health_checks_pass_during_a_flood_of_incomplete_heads(self):
        self.flood(HEALTH[:-2])

    def flood(self, sent):
        # Repeatedly opens far more connections than the limit. The limit per address is off.
        over = threading.Event()

        def flood(server):
            while not over.is_set():
                with contextlib.ExitStack() as stack:
                    for _ in range(300):
                        stack.enter_context(Raw(server)).try_send(sent)

        with Server("--max-connections=100", "--max-connections-per-address=0") as server:
            thread = threading.Thread(target=flood, args=(server,))
            thread.start()
            try:
                answers = [ask(server, "/health").status for _ in range(30)]
                answers += [ask(server, "/capabilities").status for _ in range(10)]
            finally:
                over.set()
                join(thread, "the end of the flood")
            self.assertEqual(answers, [200] * len(answers))

    def test_one_is_closed_for_a_new_connection(self):
        with Server("--max-connections=4", "--max-connections-per-address=0", "--idle-timeout=300") as server:
            with contextlib.ExitStack() as stack:
                kept = [stack.enter_context(Raw(server)) for _ in range(4)]
                for client in kept:
                    client.send(HEALTH)
                    self.assertEqual(client.answer()[0], 200)
                with Raw(server) as newcomer:
                    newcomer.send(HEALTH)
                    self.assertEqual(newcomer.answer()[0], 200)
                    closed, _, _ = select.select([client.socket for client in kept], [], [], PATIENCE)
                    self.assertEqual([connection.recv(1) for connection in closed], [b""])


class FewFiles(unittest.TestCase):
    """A low limit of open files also limits the number of connections."""

    def test_idle_connections_delay_nobody(self):
        with Server("--workers=2", "--max-connections-per-address=0", limit="--nofile=90") as server:
            server.wait_for_log("(ulimit -n) is 90")
            with crowd(server, 120), crowd(server, 120, HEALTH):
                for _ in range(5):
                    self.assertLess(ping(server), AT_ONCE)
                self.assertEqual(ask(server, "/halftone?sites=10&scale=1", data=GREY).status, 200)
                self.assertEqual(ask(server, "/sample", data=json.dumps({"sites": 9, "domain": RECTANGLE})).status, 200)
            self.assertEqual(server.log().count("ulimit"), 1)
            self.assertNotIn("could not be accepted", server.log())
            self.assertEqual(server.stop(), 0)

    def test_running_out_of_them_is_logged_once(self):
        with Server("--max-connections-per-address=0", "--idle-timeout=300") as server:
            server.wait_for_log("pictures are decoded")
            execute(["prlimit", f"--pid={server.process.pid}", "--nofile=30"], check=True)
            with crowd(server, 60):
                self.assertLess(ping(server), AT_ONCE)
                server.wait_for_log("could not be accepted")
            self.assertEqual(server.log().count("could not be accepted"), 1)
            self.assertEqual(server.stop(), 0)


class LittleAddressSpace(unittest.TestCase):
    """With a limit of the address space, there is space for the stacks of only a few threads."""

    @unittest.skipIf(SANITIZED, "sanitizers need more")
    def test_idle_connections_delay_neither_others_nor_the_shutdown(self):
        # A stack takes 8 MiB, so one of the limits leaves almost nothing beside the last stack that fits.
        for limit in range(872, 880):
            with self.subTest(limit=limit), Server("--workers=2", "--memory=700MiB", "--max-connections-per-address=0",
                                                   "--idle-timeout=300", limit=f"--as={limit << 20}") as server:
                with crowd(server, 200):
                    for _ in range(5):
                        ping(server)
                    server.signal()
                    server.wait_for_log("shutting down")
                self.assertEqual(server.wait(), 0)



class Rest(unittest.TestCase):
    def test_idle_threads_end(self):
        with Server("--idle-timeout=0.5") as server:
            def threads():
                # A listing of /proc/PID/task may miss some threads while others end.
                status = pathlib.Path(f"/proc/{server.process.pid}/status").read_text()
                return int(re.search(r"^Threads:\s+(\d+)$", status, re.MULTILINE)[1])

            # The thread that accepts connections is created last, after the server has logged its address.
            self.assertEqual(ask(server, "/health").status, 200)
            before = threads()
            with crowd(server, 300, HEALTH) as clients:
                for client in clients:
                    self.assertEqual(client.answer()[0], 200)
                self.assertGreaterEqual(threads(), 300)
            wait_until(lambda: threads() <= before + 1, "the end of idle threads")
            self.assertEqual(ask(server, "/health").status, 200)


class UnixSocket(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name) / "socket"
        self.bind = f"--bind=unix:{self.path}"

    def start_another(self):
        return subprocess.run([os.environ["CCDT_SERVER"], self.bind], capture_output=True, text=True, timeout=PATIENCE,
                              check=False)

    def test_answers_and_is_removed_at_the_end(self):
        with Server(self.bind, "--max-connections-per-address=1") as server:
            calls = [Call("http://localhost/halftone?sites=5&scale=1", "--unix-socket", str(self.path), data=GREY)
                     for _ in range(3)]
            self.assertEqual([call.answer().status for call in calls], [200] * 3)
            server.wait_for_log(" unix POST ")
            second = self.start_another()
            self.assertEqual(second.returncode, 1)
            self.assertIn("in use", second.stderr)
            with Raw(server) as raw:
                raw.send(HEALTH)
                self.assertEqual(raw.answer()[0], 200)
            self.assertEqual(server.stop(), 0)
        self.assertFalse(self.path.exists())

    def test_a_stale_socket_is_replaced(self):
        with Server(self.bind) as server:
            server.process.kill()
            server.wait()
        self.assertTrue(self.path.is_socket())
        with Server(self.bind) as server:
            self.assertEqual(Call("http://localhost/health", "--unix-socket", str(self.path)).answer().status, 200)
            self.assertEqual(server.stop(), 0)

    def test_other_files_are_not_replaced(self):
        self.path.write_text("precious")
        self.assertEqual(self.start_another().returncode, 1)
        self.assertEqual(self.path.read_text(), "precious")


if __name__ == "__main__":
    unittest.main(verbosity=2)
