# SPDX-License-Identifier: GPL-3.0-or-later
"""Honest clients, and clients that measure latencies. They run in separate processes until a given time.

Times are values of time.monotonic(), which is the same in all processes of a machine.
"""

import collections
import contextlib
import http.client
import multiprocessing
import pathlib
import re
import subprocess
import tempfile
import threading
import time
import typing

from cases import analyses, essence, medium, picture, pictures, small, swift

TIME_LIMIT = 120   # time limit of an answer, and of the end of clients, in seconds
MAX_DESCRIBED = 5  # number of failures of one kind that are described


class Wait(typing.NamedTuple):
    """The time from when a measured request was due to its answer, and parts of it, in milliseconds."""
    taken: float
    late: float       # until it was sent, because the previous one was not answered yet
    queue: float      # waiting for a worker
    computing: float

    @property
    def rest(self):
        return self.taken - self.late - self.queue - self.computing


class Tally:
    """Counts of the outcomes of requests, descriptions of failures, and measured waits. Thread-safe."""

    def __init__(self):
        self.lock = threading.Lock()
        self.counts = collections.Counter()
        self.details = collections.defaultdict(list)
        self.waits = []

    def count(self, what):
        with self.lock:
            self.counts[what] += 1

    def fail(self, what, detail):
        with self.lock:
            self.counts["failed " + what] += 1
            if len(self.details[what]) < MAX_DESCRIBED:
                self.details[what].append(str(detail)[:300])

    def add(self, other):
        self.counts.update(other.counts)
        for what, details in other.details.items():
            self.details[what] = (self.details[what] + details)[:MAX_DESCRIBED]
        self.waits += other.waits

    def failures(self):
        return sum(count for what, count in self.counts.items() if what.startswith("failed "))

    def take_waits(self):
        waits, self.waits = self.waits, []
        return waits

    def __getstate__(self):
        return {name: value for name, value in self.__dict__.items() if name != "lock"}

    def __setstate__(self, state):
        self.__dict__.update(state, lock=threading.Lock())


class Answer(typing.NamedTuple):
    status: int
    headers: dict
    body: bytes


class ServerGone(Exception):
    """The server refuses connections."""


class Client:
    """A client with a persistent connection from a given address, because queueing is fair between addresses."""

    def __init__(self, port, source):
        self.connection = http.client.HTTPConnection("127.0.0.1", port, timeout=TIME_LIMIT, source_address=(source, 0))
        self.fresh = True

    def ask(self, case):
        """Sends a request. If the server has closed the idle connection, a new one is opened, as browsers do."""
        try:
            return self._ask(case)
        except (http.client.RemoteDisconnected, ConnectionResetError, BrokenPipeError):
            if self.fresh:
                raise
            self.close()
            return self._ask(case)

    def _ask(self, case):
        try:
            self.connection.request("POST", case.path, case.body, case.headers)
        except ConnectionRefusedError as error:
            raise ServerGone from error
        response = self.connection.getresponse()
        answer = Answer(response.status, {name.lower(): value for name, value in response.getheaders()},
                        response.read())
        self.fresh = False
        return answer

    def close(self):
        self.connection.close()
        self.fresh = True


def judge(answer, case, known, tally):
    """Counts the outcome of a request.
    @returns  number of seconds after which the server asks the client to retry; 0 if it does not"""
    if answer.status in (429, 503) and re.fullmatch(r"[1-9]\d*", answer.headers.get("retry-after", "")):
        tally.count("put off")
        return int(answer.headers["retry-after"])
    if answer.status != case.status:
        tally.fail("status", f"{case.name}: {answer.status} {answer.body[:200]}")
    elif essence(answer.body) != known[case.name]:
        tally.fail("answer", f"{case.name}: {len(answer.body)} bytes that differ from the known ones")
    else:
        tally.count("right")
    return 0


def repeat(until, tally, step):
    """Repeats a step until the given time, or until the server refuses connections."""
    while time.monotonic() < until:
        try:
            step()
        except ServerGone:
            tally.fail("connect", "the server refuses connections")
            return
        except (OSError, http.client.HTTPException) as error:
            tally.fail("exchange", repr(error))


def pause(seconds, until):
    time.sleep(max(0.0, min(seconds, until - time.monotonic())))


def ask_in_turn(port, source, cases, known, until, tally):
    client = Client(port, source)
    turn = iter(range(1 << 60))

    def step():
        case = cases[next(turn) % len(cases)]
        try:
            pause(judge(client.ask(case), case, known, tally), until)
        except (OSError, http.client.HTTPException):
            client.close()
            raise

    with contextlib.closing(client):
        repeat(until, tally, step)


def curl_in_turn(port, source, known, until, tally):
    """Sends forms by curl, each over a new connection."""
    camera = next(case for case in pictures() if case.name == "camera")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "sent").write_bytes(picture("camera.png"))

        def step():
            done = subprocess.run(
                ["curl", "--silent", "--max-time", str(TIME_LIMIT), "--interface", source, "--form",
                 f"image=@{folder / 'sent'}", "--output", str(folder / "body"), "--write-out",
                 "%{http_code} %header{retry-after}", f"http://127.0.0.1:{port}{camera.path}"],
                capture_output=True, text=True, check=False)
            if done.returncode == 7:
                raise ServerGone
            if done.returncode != 0:
                raise OSError(f"curl ended with {done.returncode}")
            status, *retry = done.stdout.split()
            answer = Answer(int(status), {"retry-after": "".join(retry)}, (folder / "body").read_bytes())
            pause(judge(answer, camera, known, tally), until)

        repeat(until, tally, step)


def stages(answer):
    """Returns the milliseconds of each stage in Server-Timing."""
    return {name: float(value) for name, value in
            re.findall(r"(\w+);dur=([\d.]+)", answer.headers.get("server-timing", ""))}


def measure(port, source, first, period, known, until, tally):
    """Sends a small request in each period. Delays by the server do not reduce the number of measurements, except when
    a whole period is missed, which is counted."""
    client = Client(port, source)
    cases = small()
    turn = iter(range(1 << 60))
    due = time.monotonic() + first

    def step():
        nonlocal due
        late = time.monotonic() - due
        if late > period:
            tally.count("missed")
            due += period * (late // period)
        pause(due - time.monotonic(), until)
        if due > until:
            return
        case = cases[next(turn) % len(cases)]
        sent = time.monotonic()
        try:
            answer = client.ask(case)
        except (OSError, http.client.HTTPException):
            client.close()
            raise
        taken, late = 1000 * (time.monotonic() - due), 1000 * (sent - due)
        due += period
        if not judge(answer, case, known, tally):
            spent = stages(answer)
            tally.waits.append(Wait(taken, late, spent["queue"], spent["optimise"]))

    with contextlib.closing(client):
        repeat(until, tally, step)


def run_threads(tally, *calls):
    threads = [threading.Thread(target=call[0], args=call[1:]) for call in calls]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return tally


def honest(port, known, until):
    """Runs five clients, each of which always has one request for a worker."""
    tally = Tally()
    return run_threads(
        tally, (ask_in_turn, port, "127.0.2.1", medium(), known, until, tally),
        (ask_in_turn, port, "127.0.2.2", medium()[::-1], known, until, tally),
        (ask_in_turn, port, "127.0.2.3", pictures(), known, until, tally),
        (ask_in_turn, port, "127.0.2.4", analyses(), known, until, tally),
        (curl_in_turn, port, "127.0.2.5", known, until, tally))


def probe(port, known, until):
    """Runs eight clients with separate addresses, which together send ten small requests per second."""
    clients, period = 8, 0.8
    tally = Tally()
    return run_threads(tally, *((measure, port, f"127.0.3.{i + 1}", 0.2 + period * i / clients, period, known, until,
                                 tally) for i in range(clients)))


class Process:
    """Runs one of the functions above in another process."""

    _context = multiprocessing.get_context("spawn")

    def __init__(self, target, *arguments):
        self.pipe, theirs = self._context.Pipe(duplex=False)
        self.process = self._context.Process(target=_send, args=(theirs, target, *arguments), daemon=True)
        self.process.start()
        theirs.close()

    def end(self, patience):
        """Waits for the end of the process, for at most `patience` seconds, and returns its tally."""
        try:
            tally = self.pipe.recv() if self.pipe.poll(patience) else None
        except EOFError:
            tally = None
        if tally is None:
            tally = Tally()
            tally.fail("client", f"waited {patience} s for the end of a process of clients")
            self.process.kill()
        self.process.join()
        return tally


def _send(pipe, target, *arguments):
    pipe.send(target(*arguments))


class Hammer:
    """A process of wrk that sends short requests over persistent connections; see hammer.lua."""

    def __init__(self, port, known, connections, seconds):
        self.folder = tempfile.TemporaryDirectory()
        folder = pathlib.Path(self.folder.name)
        for i, case in enumerate(swift()):
            headers = "".join(f"{name}: {value}\r\n" for name, value in case.headers.items())
            head = f"POST {case.path} HTTP/1.1\r\nHost: localhost\r\nContent-Length: {len(case.body)}\r\n{headers}\r\n"
            (folder / f"{i}.request").write_bytes(head.encode() + case.body)
            (folder / f"{i}.answer").write_bytes(known[case.name])
            (folder / f"{i}.status").write_text(str(case.status))
        script = pathlib.Path(__file__).resolve().parent / "hammer.lua"
        self.process = subprocess.Popen(
            ["wrk", "--threads", str(connections), "--connections", str(connections), "--duration", f"{seconds}s",
             "--timeout", f"{TIME_LIMIT}s", "--script", str(script), f"http://127.0.0.1:{port}", "--", str(folder)],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def end(self, patience):
        tally = Tally()
        with self.folder:
            try:
                output = self.process.communicate(timeout=patience)[0]
            except subprocess.TimeoutExpired:
                self.process.kill()
                output = self.process.communicate()[0]
        found = re.search(r"right (\d+) wrong (\d+) put off (\d+) lost (\d+) first (.*)", output)
        if found is None:
            tally.fail("client", "wrk: " + output[-250:])
            return tally
        tally.counts.update({"right": int(found[1]), "put off": int(found[3])})
        for count, what in ((int(found[2]), "answer"), (int(found[4]), "exchange")):
            if count:
                tally.fail(what, "wrk: " + found[5])
                tally.counts["failed " + what] += count - 1
        return tally
