# SPDX-License-Identifier: GPL-3.0-or-later
"""Kills a server at random moments while it accepts and runs jobs, and reports whether any job was lost or changed.

A job counts once its 202 has arrived. After the last kill, a server runs until all jobs have ended. Each must have the
result that an idle server returned for the same request before the first kill.
"""

import argparse
import contextlib
import http.client
import itertools
import json
import pathlib
import random
import signal
import sqlite3
import sys
import tempfile
import threading
import time

import cases
from load import TIME_LIMIT

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
from harness import Server  # pylint: disable=wrong-import-position

MAX_LIFETIME = 0.5  # maximum number of seconds from the first job of a server until it is killed
MAX_STARTS = 3      # number of starts after which a job that does not end fails
PATIENCE = 600      # time limit for a server to finish all remaining jobs, in seconds
LATER = {"Prefer": "respond-async"}
LAST = cases.sample("longer than a life", sites=60_000, iterations=300, domain=cases.RECTANGLE)


def ask(server, method, path, body=None, headers=None):
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=TIME_LIMIT)
    with contextlib.closing(connection):
        connection.request(method, path, body, headers or {})
        answer = connection.getresponse()
        return answer.status, answer.read()


def questions():
    """Returns cases of all kinds, without those that are refused before they become jobs."""
    return [case for case in [*cases.small(), *cases.swift(), *cases.medium(), *cases.pictures(), *cases.analyses(),
                              cases.LARGE] if case.status != 400]


def learn(flags):
    """Returns the essence of an idle server's synchronous answer to each case, by name."""
    with Server(*flags) as server:
        known = {}
        for case in [*questions(), LAST]:
            status, body = ask(server, "POST", case.path, case.body, case.headers)
            if status != case.status:
                raise AssertionError(f"{case.name} is answered {status} before any kill: {body[:300]}")
            known[case.name] = cases.essence(body)
        return known


class Accepted:
    """The jobs that servers have accepted, with the case of each."""

    def __init__(self, wanted):
        self.turn = itertools.islice(itertools.cycle(questions()), wanted - 1)
        self.case = None
        self.jobs = {}

    def prefer(self, case):
        """Makes a case the next one to be submitted."""
        self.turn = itertools.chain([case], [self.case] if self.case else [], self.turn)
        self.case = None

    def submit_next(self, server):
        """Submits the next case, or again the one that was not answered. Returns False if none is left."""
        if self.case is None:
            self.case = next(self.turn, None)
        if self.case is None:
            return False
        status, body = ask(server, "POST", self.case.path, self.case.body, {**self.case.headers, **LATER})
        if status != 202:
            raise AssertionError(f"{self.case.name} is answered {status}: {body[:300]}")
        self.jobs["/jobs/" + json.loads(body)["id"]] = self.case
        self.case = None
        return True


def submit_until_killed(server, seconds, accepted):
    """Submits jobs until the server is killed, after the given time."""
    killer = threading.Timer(seconds, server.signal, [signal.SIGKILL])
    killer.start()
    with contextlib.suppress(OSError, http.client.HTTPException):
        while accepted.submit_next(server):
            pass
    killer.join()
    server.wait()


def status_of(server, job):
    status, body = ask(server, "GET", job)
    return json.loads(body)["status"] if status == 200 else f"answered {status}"


def wait_for_all(server, jobs):
    """Waits until all jobs have ended. Returns the status of those that have not, or that have an invalid one."""
    end = time.monotonic() + PATIENCE
    left = dict.fromkeys(jobs, "queued")
    while left and time.monotonic() < end:
        left = {job: status for job in left
                if (status := status_of(server, job)) not in ("succeeded", "failed")}
        if any(status not in ("queued", "running") for status in left.values()):
            break
        time.sleep(0.1)
    return left


def on_their_last_start(folder):
    """Returns the jobs in the store of the killed server that may be started only once more."""
    with contextlib.closing(sqlite3.connect(f"{folder}/jobs/jobs.sqlite")) as store:
        rows = store.execute("SELECT id FROM jobs WHERE finished IS NULL AND starts >= ?", (MAX_STARTS - 1,))
        return ["/jobs/" + job for job, in rows]


def check(server, accepted, known):
    """Returns all faults, as texts."""
    wrong = [f"{job} ({accepted.jobs[job].name}) is {status}"
             for job, status in wait_for_all(server, accepted.jobs).items()]
    for job, case in accepted.jobs.items():
        status, body = ask(server, "GET", job + "/result")
        if (status, cases.essence(body)) != (case.status, known[case.name]):
            wrong.append(f"{job} ({case.name}) is answered {status}, with {len(body)} bytes: {body[:200]}")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=20, help="at least 2")
    parser.add_argument("--jobs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    print(f"seed {arguments.seed}")
    chance = random.Random(arguments.seed)
    start = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        flags = ("--workers=2", "--timeout=300", "--job-ttl=3600", f"--data-dir={folder}/jobs")
        known = learn(flags)
        accepted = Accepted(arguments.jobs)
        last_chances = []
        for left in range(arguments.kills, 0, -1):
            if left == MAX_STARTS - 1:
                accepted.prefer(LAST)
            with Server(*flags) as server:
                wait_for_all(server, last_chances)
                submit_until_killed(server, chance.uniform(0, MAX_LIFETIME), accepted)
            last_chances = on_their_last_start(folder)
        with Server(*flags) as server:
            unfinished = sum(status_of(server, job) in ("queued", "running") for job in accepted.jobs)
            while accepted.submit_next(server):
                pass
            wrong = check(server, accepted, known)
            ended = server.stop()
    print(f"{time.monotonic() - start:.0f} s, {arguments.kills} kills, {len(accepted.jobs)} jobs accepted, of which "
          f"{unfinished} had not ended at the last kill")
    if unfinished == 0:
        wrong.append("there were too few jobs: all had ended before the last kill")
    if ended != 0:
        wrong.append(f"the last server ended with {ended}")
    print("\n".join(["FAILED:", *wrong]) if wrong else "passed")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
