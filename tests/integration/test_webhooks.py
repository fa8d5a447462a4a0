# SPDX-License-Identifier: GPL-3.0-or-later
"""Webhooks: messages about the ends of jobs to URLs of the clients."""

import base64
import contextlib
import hashlib
import hmac
import http.server
import json
import pathlib
import signal
import tempfile
import threading
import unittest

from engine import Redis, free_port
from harness import Server, ask, wait_until
from test_jobs import ENDLESS, LONG, SMALL, status, wait_for, wait_for_end

SECRETS = [base64.b64encode(bytes([i]) * 24).decode() for i in range(2)]


class Receiver:
    """A host that accepts webhooks, and keeps their headers and bodies."""

    def __init__(self, port=0):
        received = self.received = []

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(self):  # pylint: disable=invalid-name
                body = self.rfile.read(int(self.headers["Content-Length"]))
                received.append((self.path, {name.lower(): value for name, value in self.headers.items()}, body))
                self.send_response(204)
                self.end_headers()

            def log_message(self, *_):  # pylint: disable=arguments-differ
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", port), Handler)
        self.thread = threading.Thread(target=self.server.serve_forever, daemon=True)
        self.thread.start()
        self.url = f"http://127.0.0.1:{self.server.server_port}/hook?token=a,b"

    def wait_for(self, count):
        wait_until(lambda: len(self.received) >= count, f"{count} webhooks")
        return self.received

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.server.shutdown()
        self.server.server_close()


def later(url):
    return ("--header", f'Prefer: respond-async, callback; url="{url}"')


def submit(server, body, url):
    answer = ask(server, "/sample", *later(url), data=json.dumps(body))
    assert answer.status == 202, answer
    assert answer.headers["preference-applied"] == "respond-async, callback", answer.headers
    return answer.headers["location"]


def signature(secret, headers, body):
    text = f"{headers['webhook-id']}.{headers['webhook-timestamp']}.".encode() + body
    return "v1," + base64.b64encode(hmac.digest(base64.b64decode(secret), text, hashlib.sha256)).decode()


class Webhooks(unittest.TestCase):
    def setUp(self):
        stack = contextlib.ExitStack()
        self.addCleanup(stack.close)
        self.stack = stack
        self.folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory()))
        self.keys = self.folder / "keys"
        self.keys.write_text(f"main:whsec_{SECRETS[0]}\n")

    def start(self, *flags):
        return self.stack.enter_context(
            Server("--workers=2", "--webhook-host=127.0.0.1", f"--webhook-key-file={self.keys}", *flags))

    def receiver(self, port=0):
        return self.stack.enter_context(Receiver(port))

    def test_tell_the_ends_of_jobs(self):
        server, receiver = self.start(), self.receiver()
        job = submit(server, SMALL, receiver.url)
        ((path, headers, body),) = receiver.wait_for(1)
        self.assertEqual((path, headers["content-type"], "/jobs/" + headers["webhook-id"]),
                         ("/hook?token=a,b", "application/json", job))
        self.assertEqual(headers["webhook-signature"], signature(SECRETS[0], headers, body))
        self.assertEqual(json.loads(body), status(server, job))
        cancelled = submit(server, ENDLESS, receiver.url)
        wait_for(server, cancelled, "running")
        ask(server, cancelled, "--request", "DELETE")
        self.assertEqual(json.loads(receiver.wait_for(2)[1][2])["status"], "cancelled")
        self.keys.write_text(f"main:whsec_{SECRETS[0]}\nnew:whsec_{SECRETS[1]}\n")
        server.signal(signal.SIGHUP)
        server.wait_for_log("keys were reloaded")
        submit(server, SMALL, receiver.url)
        _, headers, body = receiver.wait_for(3)[2]
        self.assertEqual(headers["webhook-signature"].split(),
                         [signature(secret, headers, body) for secret in SECRETS])
        wait_until(lambda: b"ccdt_webhooks_sent_total 3" in ask(server, "/metrics").body, "the metric")
        self.assertNotIn("token", server.log())

    def test_are_refused_unless_they_are_permitted(self):
        server, without = self.start(), self.stack.enter_context(Server())
        for one, prefer, words in (
                (server, 'respond-async, callback; url="http://localhost:1/"', "the host localhost is not"),
                (server, "respond-async, callback", "the URL must be absolute"),
                (server, 'callback; url="http://127.0.0.1/"', "needs respond-async"),
                (without, 'respond-async, callback; url="http://127.0.0.1/"', "(webhook-host)")):
            answer = ask(one, "/sample", "--header", "Prefer: " + prefer, data=json.dumps(SMALL))
            self.assertEqual(answer.status, 400, answer)
            self.assertIn(words, answer.json()["detail"])

    def test_outlive_a_restart(self):
        port, folder = free_port(), self.folder / "jobs"
        server = self.start(f"--data-dir={folder}")
        job = submit(server, SMALL, f"http://127.0.0.1:{port}/")
        wait_for_end(server, job)
        server.wait_for_log("attempt 1 of 5 to send the webhook of job")
        running = submit(server, LONG, f"http://127.0.0.1:{port}/")
        server.signal(signal.SIGKILL)
        server.wait()
        receiver = self.receiver(port)
        self.start(f"--data-dir={folder}")
        self.assertEqual({"/jobs/" + headers["webhook-id"] for _, headers, _ in receiver.wait_for(2)}, {job, running})

    def test_are_sent_by_one_of_several_servers(self):
        redis, receiver = self.stack.enter_context(Redis()), self.receiver()
        servers = [self.start(f"--redis={redis.url}") for _ in range(2)]
        for server in servers:
            server.wait_for_log("jobs are stored in Redis")
        jobs = [submit(servers[i % 2], {**SMALL, "seed": i}, receiver.url) for i in range(20)]
        receiver.wait_for(20)
        for job in jobs:
            wait_for_end(servers[0], job)
        wait_until(lambda: redis.cli("ZCARD", "ccdt:1:webhooks") == "0", "all webhooks to be settled")
        self.assertEqual(sorted("/jobs/" + headers["webhook-id"] for _, headers, _ in receiver.received), sorted(jobs))


if __name__ == "__main__":
    unittest.main(verbosity=2)
