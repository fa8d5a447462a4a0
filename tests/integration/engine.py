# SPDX-License-Identifier: GPL-3.0-or-later
"""A Redis server for tests."""

import contextlib
import os
import pathlib
import signal
import socket
import subprocess
import tempfile
import threading
import time

from harness import PATIENCE, join, wait_until

# Program that behaves as redis-server if its first argument has this name. Debian's redis-server is a link to it. Its
# package starts no daemon, unlike the package redis-server.
PROGRAM = "/usr/bin/redis-check-rdb"


def free_port():
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        return other.getsockname()[1]


class Redis:
    """A Redis server on a free port, with an append-only file in a temporary folder."""

    def __init__(self, *flags, certificate=None):
        self.folder = tempfile.TemporaryDirectory()
        self.port = free_port()
        self.certificate = certificate
        self.command = ["redis-server", "--bind", "127.0.0.1", "--dir", self.folder.name, "--save", "",
                        "--appendonly", "yes", "--logfile", "log", *flags]
        if certificate:
            self.command += ["--port", "0", "--tls-port", str(self.port), "--tls-auth-clients", "no",
                             "--tls-cert-file", certificate[0], "--tls-key-file", certificate[1],
                             "--tls-ca-cert-file", certificate[0]]
        else:
            self.command += ["--port", str(self.port)]
        self.start()

    @property
    def url(self):
        return f"redis://127.0.0.1:{self.port}"

    def start(self):
        self.process = subprocess.Popen(self.command, executable=PROGRAM, stdout=subprocess.DEVNULL)
        wait_until(self._replies, "redis-server to reply")

    def _replies(self):
        try:
            with socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE) as connection:
                if self.certificate:
                    return True
                connection.sendall(b"PING\r\n")
                return not connection.recv(100).startswith(b"-LOADING")
        except OSError:
            if self.process.poll() is not None:
                raise AssertionError(pathlib.Path(self.folder.name, "log").read_text()) from None
            return False

    def cli(self, *arguments):
        result = subprocess.run(["redis-cli", "-p", str(self.port), *arguments], capture_output=True, text=True,
                              timeout=PATIENCE, check=True)
        return result.stdout.strip()

    def kill(self):
        self.process.kill()
        self.process.wait(PATIENCE)

    def pause(self):
        os.kill(self.process.pid, signal.SIGSTOP)

    def resume(self):
        os.kill(self.process.pid, signal.SIGCONT)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.kill()
        self.folder.cleanup()


class SlowWay:
    """A proxy that delays each reply of a Redis."""

    def __init__(self, redis, seconds):
        self.redis, self.seconds = redis, seconds
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"redis://127.0.0.1:{self.listener.getsockname()[1]}"
        self.thread = threading.Thread(target=self._accept)
        self.thread.start()

    def _accept(self):
        with contextlib.suppress(OSError):
            while True:
                client = self.listener.accept()[0]
                server = socket.create_connection(("127.0.0.1", self.redis.port))
                threading.Thread(target=self._pass_on, args=(client, server, 0), daemon=True).start()
                threading.Thread(target=self._pass_on, args=(server, client, self.seconds), daemon=True).start()

    @staticmethod
    def _pass_on(source, target, late):
        with contextlib.suppress(OSError), source, target:
            while data := source.recv(65536):
                time.sleep(late)
                target.sendall(data)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.listener.shutdown(socket.SHUT_RDWR)
        join(self.thread, "the end of a proxy")
        self.listener.close()
