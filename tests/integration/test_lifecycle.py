# SPDX-License-Identifier: GPL-3.0-or-later
"""Load, deadlines, clients that leave, start and shutdown."""

import contextlib
import http.client
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import tempfile
import time
import unittest

from harness import PATIENCE, Call, Server, ask, descendants, file_of, flat, post_json, wait_until
from raw import SANITIZED, Raw

RECTANGLE = {"type": "rectangle", "width": 2, "height": 1}
JSON = ("--header", "Content-Type: application/json")

# Maximum number of seconds from the last answer to the end of the process.
SOON = 5

# Takes longer than any test, and is ended by cancelling it.
ENDLESS = json.dumps({"sites": 100_000, "iterations": 1000, "domain": RECTANGLE})
# Takes at most a few seconds: longer than a request to the server, but less than the timeout.
SHORT = json.dumps({"sites": 20_000, "iterations": 50, "domain": RECTANGLE})


def start(server, body, count):
    return [Call(server.url("/sample"), *JSON, data=body) for _ in range(count)]


def probe(server):
    """Sends a request that is refused before it reaches a worker: 429 if the queue is full, else 400.

    Its body is too long for the queue of short requests.
    """
    return ask(server, "/halftone?nonsense=1", data=b"x" * 70_000)


def wait_for_status(server, status):
    """Probes until the answer has a status, and returns that answer."""
    return wait_until(lambda: (answer := probe(server)).status == status and answer, f"status {status}")


def wait_until_accepted(server, count):
    """Waits until `count` requests are computed or queued."""
    def accepted():
        metrics = ask(server, "/metrics").body.decode()
        return sum(map(float, re.findall(r"^ccdt_(?:workers_busy|queue_requests) (\S+)$", metrics, re.MULTILINE)))

    wait_until(lambda: accepted() == count, f"{count} accepted requests")


def lasting_programs(server):
    """Returns the processes of a server that end with it. Others wait for a single order, or start another process."""
    names = "ccdt-worker\n", "decoder-keeper\n", "decoder-helper\n"
    found = []
    for process in descendants(server.process.pid):
        with contextlib.suppress(OSError):
            if pathlib.Path(f"/proc/{process}/comm").read_text() in names:
                found.append(process)
    return found


@contextlib.contextmanager
def service_manager():
    """A socket that receives what a server tells systemd."""
    with tempfile.TemporaryDirectory() as folder, socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(f"{folder}/notify")
        manager.settimeout(PATIENCE)
        yield manager


class Load(unittest.TestCase):
    def test_full_queue_rejects_requests_while_health_answers(self):
        with Server("--workers=2", "--queue=1", "--timeout=300") as server:
            calls = start(server, ENDLESS, 3)
            answer = wait_for_status(server, 429)
            self.assertEqual(answer.type, "application/problem+json")
            self.assertGreaterEqual(int(answer.headers["retry-after"]), 1)
            self.assertEqual(answer.headers["connection"], "close")
            large = ask(server, "/halftone", data=b"x" * 5_000_000)
            self.assertEqual(large.status, 429, "refused without reading the body")
            for path in ("/health", "/health/live", "/health/ready"):
                self.assertEqual(ask(server, path).status, 200)
            for call in calls:
                call.abandon()

    def test_simultaneous_requests_are_answered_or_rejected(self):
        with Server("--workers=2", "--queue=4") as server:
            picture = file_of(flat(100))
            calls = [Call(server.url("/halftone?sites=5000"), data=picture) for _ in range(40)]
            answers = [call.answer() for call in calls]
            good = [answer.body for answer in answers if answer.status == 200]
            self.assertEqual({answer.status for answer in answers} - {200, 429}, set())
            self.assertGreaterEqual(len(good), 6)
            self.assertEqual(len(set(good)), 1)

    def test_disconnecting_client_frees_its_worker(self):
        with Server("--workers=1", "--queue=0", "--timeout=300") as server:
            (call,) = start(server, ENDLESS, 1)
            wait_for_status(server, 429)
            call.abandon()
            wait_for_status(server, 400)
            server.wait_for_log(" 499 ")

    def test_disconnecting_client_frees_its_place_in_the_queue(self):
        with Server("--workers=1", "--queue=1", "--timeout=300") as server:
            calls = start(server, ENDLESS, 2)
            wait_for_status(server, 429)
            calls.pop().abandon()
            wait_for_status(server, 400)
            calls.pop().abandon()


class Deadline(unittest.TestCase):
    def test_status_is_504_if_it_expires_during_the_work_and_503_before(self):
        with Server("--workers=1", "--queue=1", "--timeout=0.1") as server:
            during = post_json(server, "/sample", json.loads(ENDLESS))
            # Jobs have a separate time limit. This job occupies the worker until the deadline of the next request.
            job = ask(server, "/sample", *JSON, "--header", "Prefer: respond-async", data=ENDLESS).headers["location"]
            wait_until(lambda: ask(server, job).json()["status"] == "running")
            answers = [post_json(server, "/sample", json.loads(ENDLESS)), during]
            self.assertEqual([answer.status for answer in answers], [503, 504])
            for answer in answers:
                self.assertEqual(answer.type, "application/problem+json")
            self.assertGreaterEqual(int(answers[0].headers["retry-after"]), 1)
            ask(server, job, "--request", "DELETE")
            picture, small = file_of(flat(9)), "/halftone?sites=10&width=50"
            answer = wait_until(lambda: (now := ask(server, small, data=picture)).status not in (503, 504) and now)
            self.assertEqual(answer.status, 200)

    def test_partial_result_is_sent_on_request(self):
        # Starts quickly, and takes longer than any test.
        endless = {"sites": 5000, "iterations": 1000, "passes": 100, "domain": RECTANGLE}
        with Server("--workers=1", "--timeout=2") as server:
            partial = post_json(server, "/sample", {**endless, "on_deadline": "partial"})
            self.assertEqual((partial.status, partial.headers.get("x-partial")), (200, "deadline"))
            points = partial.json()
            self.assertIs(points["partial"], True)
            self.assertLess(points["iterations"], 1000)
            self.assertEqual(len({tuple(point) for point in points["points"]}), 5000)
            squeezed = post_json(server, "/sample", {**endless, "on_deadline": "partial"}, "--compressed")
            self.assertEqual((squeezed.status, len(squeezed.json()["points"])), (200, 5000))

            picture = file_of(flat(100, 512, 512))
            query = "iterations=1000&passes=100&on_deadline=partial&scale=1"
            dots = ask(server, f"/halftone?sites=5000&{query}", data=picture)
            self.assertEqual((dots.status, dots.headers.get("x-partial")), (200, "deadline"))
            self.assertEqual(dots.picture().shape, (512, 512))
            whole = ask(server, "/halftone?sites=50&on_deadline=partial&scale=1", data=picture)
            self.assertEqual((whole.status, "x-partial" in whole.headers), (200, False))
            self.assertEqual(post_json(server, "/sample", endless).status, 504)


class Fairness(unittest.TestCase):
    def test_one_client_does_not_block_another(self):
        with Server("--workers=1", "--queue=6", "--timeout=300") as server:
            calls = start(server, SHORT, 7)
            wait_for_status(server, 429)
            other = Call(server.url("/sample"), *JSON, "--interface", "127.0.0.2", data=SHORT)
            self.assertEqual(other.answer().status, 200)
            waiting = sum(call.process.poll() is None for call in calls)
            self.assertGreaterEqual(waiting, 5)
            for call in calls:
                call.abandon()


class Stopping(unittest.TestCase):
    def test_accepted_requests_are_answered(self):
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGQUIT):
            with self.subTest(number=number), Server("--workers=2", "--queue=2", "--timeout=300") as server:
                calls = start(server, SHORT, 4)
                wait_for_status(server, 429)
                server.signal(number)
                for call in calls:
                    answer = call.answer()
                    self.assertEqual(answer.status, 200)
                    self.assertEqual(len(answer.json()["points"]), 20_000)
                self.assertEqual(server.wait(), 0)

    def test_pending_connections_are_served(self):
        with Server("--max-connections-per-address=0") as server, contextlib.ExitStack() as stack:
            server.wait_for_log("pictures are decoded")
            server.signal(signal.SIGSTOP)
            clients = [stack.enter_context(Raw(server)) for _ in range(400)]
            for client in clients:
                client.send(b"GET /capabilities HTTP/1.1\r\nHost: localhost\r\n\r\n")
            server.signal()
            server.signal(signal.SIGCONT)
            self.assertEqual([client.socket.recv(12) for client in clients], [b"HTTP/1.1 200"] * len(clients))
            self.assertEqual(server.wait(), 0)

    def test_new_requests_are_rejected(self):
        with Server("--workers=1", "--queue=0", "--timeout=300") as server:
            open_connections = [http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE)
                                for _ in range(3)]
            for connection in open_connections:
                connection.request("GET", "/health/ready")
                answer = connection.getresponse()
                self.assertEqual((answer.status, answer.read()), (200, b'{"status":"ready"}'))
            (call,) = start(server, ENDLESS, 1)
            wait_for_status(server, 429)
            server.signal()
            server.wait_for_log("shutting down")

            with self.assertRaises(ConnectionRefusedError):
                http.client.HTTPConnection("127.0.0.1", server.port).connect()
            ready, live, work = open_connections
            ready.request("GET", "/health/ready")
            answer = ready.getresponse()
            self.assertEqual((answer.status, answer.headers["Connection"]), (503, "close"))
            self.assertGreaterEqual(int(answer.headers["Retry-After"]), 1)
            answer.read()
            live.request("GET", "/health/live")
            answer = live.getresponse()
            self.assertEqual((answer.status, len(answer.read()) > 0), (200, True))
            work.request("POST", "/sample", SHORT, {"Content-Type": "application/json"})
            answer = work.getresponse()
            self.assertEqual(answer.status, 503)
            self.assertIn("Retry-After", answer.headers)
            answer.read()
            for connection in open_connections:
                connection.close()
            call.abandon()
            self.assertEqual(server.wait(), 0)

    def test_idle_connections_do_not_delay_it(self):
        with Server() as server:
            connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE)
            connection.request("GET", "/health")
            connection.getresponse().read()
            silent = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE)
            silent.connect()
            self.assertEqual(server.stop(), 0)
            connection.close()
            silent.close()

    def test_second_signal_ends_it_at_once(self):
        for number in (signal.SIGTERM, signal.SIGQUIT):
            with self.subTest(number=number), Server("--workers=1", "--queue=0", "--timeout=300") as server:
                calls = start(server, ENDLESS, 1)
                wait_for_status(server, 429)
                server.signal(number)
                server.wait_for_log("shutting down")
                server.signal(number)
                self.assertEqual(server.wait(), 128 + number)
                calls[0].abandon()

    def test_drain_timeout_ends_unfinished_requests(self):
        with Server("--workers=1", "--queue=1", "--timeout=300", "--drain-timeout=3") as server:
            calls = start(server, ENDLESS, 2)
            wait_for_status(server, 429)
            server.signal()
            for call in calls:
                answer = call.answer()
                self.assertEqual((answer.status, answer.type), (503, "application/problem+json"))
            self.assertEqual(server.wait(), 0)

    def test_slow_clients_do_not_delay_it(self):
        large = json.dumps({"sites": 1_000_000, "iterations": 0, "domain": RECTANGLE}).encode()
        post = b"POST /sample HTTP/1.1\r\nHost: localhost\r\n"
        head = post + b"Content-Length: %d\r\n\r\n" % len(large)
        beginnings = (b"", b"GET /health HT", post + b"X: ", post + b"Content-Length: 1000\r\n\r\n{",
                      post + b"Transfer-Encoding: chunked\r\n\r\n5\r\n{", head + large[:-1])
        with Server("--workers=2", "--queue=8", "--timeout=300") as server, contextlib.ExitStack() as stack:
            slow = [stack.enter_context(Raw(server)) for _ in range(4 * len(beginnings))]
            for i, client in enumerate(slow):
                client.send(beginnings[i % len(beginnings)])
            for _ in range(2):  # clients that read no more than the beginning of their answers
                client = stack.enter_context(Raw(server))
                client.send(head + large)
                self.assertEqual(client.socket.recv(12), b"HTTP/1.1 200")
            wait_until_accepted(server, 0)
            calls = start(server, SHORT, 4)
            wait_until_accepted(server, 4)
            server.signal()
            self.assertEqual([call.answer().status for call in calls], [200] * 4)
            answered = time.monotonic()
            self.assertEqual(server.wait(), 0)
            self.assertLess(time.monotonic() - answered, SOON)

    def test_drain_timeout_ends_unread_answers(self):
        body = json.dumps({"sites": 1_000_000, "iterations": 0, "domain": RECTANGLE}).encode()
        with Server("--drain-timeout=3") as server, socket.create_connection(("127.0.0.1", server.port)) as client:
            client.sendall(b"POST /sample HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\n\r\n%s" % (len(body), body))
            self.assertEqual(client.recv(12), b"HTTP/1.1 200")
            server.signal()
            self.assertEqual(server.wait(), 0)


class Signals(unittest.TestCase):
    """Signals that do not ask the server to end."""

    # SIGHUP is not among them: the fork server and the decoder ignore it, the server logs it.
    meaningless = (signal.SIGUSR1, signal.SIGUSR2, signal.SIGALRM, signal.SIGVTALRM, signal.SIGPROF, signal.SIGIO,
                   signal.SIGPWR, signal.SIGPIPE, signal.SIGXFSZ)

    def test_sighup_without_a_key_file_is_ignored(self):
        with Server("--workers=1", "--queue=0", "--timeout=300") as server:
            (call,) = start(server, SHORT, 1)
            wait_for_status(server, 429)
            server.signal(signal.SIGHUP)
            server.wait_for_log("SIGHUP is ignored")
            self.assertEqual(call.answer().status, 200)
            self.assertEqual(server.stop(), 0)

    def send_unused_signals(self, server, family):
        """Sends them to all processes that exist, and checks that the server still works."""
        for process in family:
            for number in self.meaningless + (() if process == server.process.pid else (signal.SIGHUP,)):
                with contextlib.suppress(ProcessLookupError):
                    os.kill(process, number)
        self.assertEqual(post_json(server, "/sample", {"sites": 6, "domain": RECTANGLE}).status, 200)
        self.assertEqual(ask(server, "/halftone?sites=5&scale=1", data=file_of(flat(9))).status, 200)
        self.assertNotIn("started again", server.log())

    def test_unused_signals_end_no_process(self):
        with service_manager() as manager, Server(environment={"NOTIFY_SOCKET": manager.getsockname()}) as server:
            self.assertIn("READY=1", manager.recv(1000).decode())
            family = wait_until(lambda: len(found := lasting_programs(server)) == 3 and found,
                                "the fork server, the keeper and the helper")
            self.send_unused_signals(server, [server.process.pid, *family])
            for process in family:
                os.kill(process, 0)
            self.assertEqual(server.stop(), 0)

    def test_unused_signals_end_no_process_that_is_being_started(self):
        with Server() as server:
            family = wait_until(lambda: descendants(server.process.pid), "the first processes of the server")
            self.send_unused_signals(server, family)
            self.assertEqual(server.stop(), 0)


class FileSizes(unittest.TestCase):
    """Servers with a limit of file sizes (ulimit -f)."""

    def test_a_log_beyond_the_limit_ends_nothing(self):
        most = 4096
        with tempfile.TemporaryDirectory() as folder:
            log = pathlib.Path(folder) / "log"
            limited = pathlib.Path(folder) / "limited"
            limited.write_text(f'#!/bin/sh\nexec prlimit --fsize={most} "$CCDT_SERVER" "$@" 2>"{log}"\n')
            limited.chmod(0o755)
            address = pathlib.Path(folder) / "socket"
            curl = ["curl", "--silent", "--retry", "100", "--retry-delay", "1", "--retry-all-errors", "--fail",
                    "--unix-socket", address, "http://localhost/sample", "--data",
                    json.dumps({"sites": 6, "domain": RECTANGLE})]
            with subprocess.Popen([limited, f"--bind=unix:{address}", "--workers=1"]) as process:
                try:
                    subprocess.run(curl, check=True, stdout=subprocess.DEVNULL, timeout=PATIENCE)
                    curl.remove("--retry-all-errors")

                    def is_full():
                        subprocess.run(curl, check=True, stdout=subprocess.DEVNULL, timeout=PATIENCE)
                        return log.stat().st_size >= most

                    wait_until(is_full, "the log to reach its limit")
                    for _ in range(20):
                        subprocess.run(curl, check=True, stdout=subprocess.DEVNULL, timeout=PATIENCE)
                    process.terminate()
                    self.assertEqual(process.wait(PATIENCE), 0)
                finally:
                    process.kill()
            self.assertEqual(log.stat().st_size, most)


class Starting(unittest.TestCase):
    def run_program(self, *flags, environment=None):
        return subprocess.run([os.environ["CCDT_SERVER"], *flags], capture_output=True, text=True, timeout=PATIENCE,
                              env={**os.environ, **(environment or {})}, check=False)

    def test_port_in_use_is_reported(self):
        with Server() as server:
            second = self.run_program(f"--port={server.port}")
            self.assertEqual(second.returncode, 1)
            self.assertIn(f"cannot listen on 127.0.0.1 port {server.port}", second.stderr)
            self.assertIn("in use", second.stderr)
            self.assertEqual(ask(server, "/health").status, 200)

    def test_port_can_be_reused_at_once(self):
        with Server() as server:
            port = server.port
            ask(server, "/health")
            self.assertEqual(server.stop(), 0)
        with Server(f"--port={port}") as server:
            self.assertEqual(server.port, port)
            self.assertEqual(ask(server, "/health").status, 200)

    def test_unknown_address_is_reported(self):
        second = self.run_program("--bind=192.0.2.1", "--port=0")
        self.assertEqual(second.returncode, 1)
        self.assertIn("cannot listen on 192.0.2.1", second.stderr)

    def test_wrong_usage_is_reported(self):
        for flags, word in ((("--nonsense",), "--nonsense"), (("--workers=0",), "--workers"), (("--port",), "--port")):
            result = self.run_program(*flags)
            self.assertEqual((result.returncode, result.stdout), (2, ""))
            self.assertIn(word, result.stderr)
        self.assertEqual(self.run_program(environment={"PORT": "x"}).returncode, 2)

    def test_help_and_version_are_printed(self):
        result = self.run_program("--help")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertIn("--max-body", result.stdout)
        self.assertRegex(self.run_program("--version").stdout, r"^ccdt-server \d+\.\d+\.\d+\n$")

    def test_the_service_manager_is_notified(self):
        with (service_manager() as manager,
              Server("--drain-timeout=20", environment={"NOTIFY_SOCKET": manager.getsockname()}) as server):
            self.assertEqual(manager.recv(1000).decode().splitlines(),
                             ["READY=1", f"STATUS=listening on http://127.0.0.1:{server.port}"])
            self.assertEqual(ask(server, "/health/ready").status, 200)
            self.assertEqual(server.stop(), 0)
            self.assertEqual(manager.recv(1000).decode().splitlines(), ["STOPPING=1", "EXTEND_TIMEOUT_USEC=21000000"])

    def test_limit_of_open_files_is_reported_if_too_low(self):
        result = subprocess.run(["prlimit", "--nofile=64", os.environ["CCDT_SERVER"], "--port=0", "--workers=2"],
                                capture_output=True, text=True, timeout=PATIENCE, check=False)
        self.assertEqual(result.returncode, 1)
        self.assertRegex(result.stderr, r"open files \(ulimit -n\) is 64: at least \d+ are needed")

    def test_environment_sets_options(self):
        with Server(environment={"CCDT_MAX_SITES": "5"}) as server:
            answer = post_json(server, "/sample", {"sites": 6, "domain": RECTANGLE})
            self.assertEqual(answer.status, 413)


class Memory(unittest.TestCase):
    @unittest.skipIf(SANITIZED, "sanitizers keep what is freed")
    def test_memory_is_released_after_a_burst(self):
        def held(server):
            status = pathlib.Path(f"/proc/{server.process.pid}/status").read_text()
            return int(re.search(r"RssAnon:\s+(\d+) kB", status).group(1)) / 1024

        large = json.dumps({"x": "y" * 6_000_000})
        with Server("--queue=32") as server:
            before = held(server)
            calls = [Call(server.url("/sample"), "--interface", f"127.0.1.{i + 1}", *JSON, data=large) for i in range(24)]
            self.assertEqual([call.answer().status for call in calls], [400] * 24)
            # Workers free bodies after they have answered.
            wait_until(lambda: held(server) - before < 48, "less than 48 MiB more than before the burst")


if __name__ == "__main__":
    unittest.main(verbosity=2)
