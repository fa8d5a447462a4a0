# SPDX-License-Identifier: GPL-3.0-or-later
"""Connections that send arbitrary bytes, including malformed requests, and measurements of their cost."""

import contextlib
import http.client
import os
import pathlib
import re
import select
import socket
import time

from harness import PATIENCE

# Time limit for immediate answers, in seconds. It is generous: only an answer that waits for some time-out exceeds it.
AT_ONCE = 1.0

SANITIZED = re.search(rb"__(a|t)san_init", pathlib.Path(os.environ["CCDT_SERVER"]).read_bytes()) is not None

# Maximum memory that clients may take in addition to accepted work, in MiB. Sanitizers keep freed memory.
MAX_MEMORY_RISE = 1024 if SANITIZED else 64


class Raw:
    """A connection to the server."""

    def __init__(self, server, source=None):
        if server.path is None:
            self.socket = socket.create_connection(("127.0.0.1", server.port), timeout=PATIENCE,
                                                   source_address=source and (source, 0))
        else:
            self.socket = socket.socket(socket.AF_UNIX)
            self.socket.settimeout(PATIENCE)
            self.socket.connect(str(server.path))

    def send(self, data):
        self.socket.sendall(data)

    def try_send(self, data):
        """Returns False if the server accepts no more data."""
        try:
            self.socket.sendall(data)
        except OSError:
            return False
        return True

    def has_news(self):
        """Returns whether an answer or the end of the connection has arrived."""
        return bool(select.select([self.socket], [], [], 0)[0])

    def answer(self):
        """Returns status, headers and body of the next answer."""
        response = http.client.HTTPResponse(self.socket)
        response.begin()
        return response.status, response.headers, response.read()

    def rest(self):
        """Returns everything that arrives until the server closes the connection."""
        received = b""
        try:
            while chunk := self.socket.recv(65536):
                received += chunk
        except ConnectionResetError:
            pass
        return received

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()


def sources():
    """Yields different addresses of this machine, so that limits per address do not apply."""
    return (f"127.0.{i // 250 + 1}.{i % 250 + 1}" for i in range(60_000))


@contextlib.contextmanager
def crowd(server, count, data=b""):
    """Connects many clients, each from a different address, which send `data` and nothing else."""
    with contextlib.ExitStack() as stack:
        clients = [stack.enter_context(Raw(server, source)) for _, source in zip(range(count), sources())]
        for client in clients:
            client.send(data)
        yield clients


def statuses(received):
    """Returns the statuses of the answers in received bytes."""
    return [int(status) for status in re.findall(rb"HTTP/1\.1 (\d{3}) ", received)]


def ping(server):
    """Requests a health check, and returns the time until the answer in seconds."""
    start = time.monotonic()
    with Raw(server) as raw:
        raw.send(b"GET /health HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
        assert statuses(raw.rest()) == [200]
    return time.monotonic() - start


class Memory:
    """Measures the increase of the server's peak resident memory within a block, in MiB."""

    def __init__(self, server):
        self.folder = pathlib.Path(f"/proc/{server.process.pid}")
        self.rise = None

    def _read(self, name):
        return int(re.search(name + r":\s+(\d+) kB", (self.folder / "status").read_text()).group(1)) / 1024

    def __enter__(self):
        (self.folder / "clear_refs").write_text("5")  # resets the peak
        self.before = self._read("VmRSS")
        return self

    def __exit__(self, *_):
        self.rise = self._read("VmHWM") - self.before
        print(f"  memory rose by {self.rise:.1f} MiB", flush=True)
