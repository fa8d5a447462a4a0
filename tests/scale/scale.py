# SPDX-License-Identifier: GPL-3.0-or-later
"""Kills, pauses and drains servers that share jobs by Redis, and reports whether any job was lost, repeated or changed.

Three servers run behind haproxy, and Redis is killed, too. Meanwhile, clients submit jobs and send synchronous
requests. A job counts once its 202 has arrived. In the end, each job must have the result that an idle server returned
for the same request. A synchronous request may fail if its server is killed, but not because of a drain, and no answer
may be wrong.
"""

import argparse
import collections
import contextlib
import http.client
import itertools
import json
import pathlib
import re
import signal
import sys
import tempfile
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path += [str(HERE.parent / "integration"), str(HERE.parent / "soak")]
import cases  # pylint: disable=wrong-import-position
from engine import Redis, free_port  # pylint: disable=wrong-import-position
from harness import Server, join  # pylint: disable=wrong-import-position
from test_deploy import HAPROXY, Balancer  # pylint: disable=wrong-import-position

LATER = {"Prefer": "respond-async"}
PATIENCE = 300  # time limit of waits, for example until all jobs have ended, in seconds
LEASE = 3       # in seconds


def ask(port, method, path, body=None, headers=None):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
    with contextlib.closing(connection):
        connection.request(method, path, body, headers or {})
        answer = connection.getresponse()
        return answer.status, answer.read()


def questions():
    """Returns cases that are short enough that hardly any job is interrupted three times, after which it would fail."""
    medium = [case for case in cases.medium() if case.name.endswith("-4096")]
    return [case for case in [*cases.small(), *cases.swift(), *medium] if case.status == 200]


def learn(*programs):
    """Returns the essences of the synchronous answers of idle servers, by the name of the case. Servers of another
    release may answer differently."""
    known = {case.name: [] for case in questions()}
    for program in programs:
        with Server("--workers=1", program=program) as server:
            for case in questions():
                answer = ask(server.port, "POST", case.path, case.body, case.headers)[1]
                known[case.name].append(cases.essence(answer))
    return known


class Replica:
    """A server on a fixed port, which can be restarted. The logs of all its runs are kept."""

    def __init__(self, redis, program=None):
        self.port = free_port()
        self.flags = (f"--port={self.port}", "--workers=1", f"--job-lease={LEASE}", "--job-queue=100000",
                      "--max-connections-per-address=0", f"--redis={redis.url}")
        self.logs = []
        self.server = Server(*self.flags, program=program)

    def end(self, number):
        """Ends the server by a signal; returns the exit code."""
        self.server.signal(number)
        code = self.server.wait()
        self.logs.append(self.server.log())
        return code

    def start(self):
        self.server = Server(*self.flags)

    def close(self):
        with self.server:
            self.server.stop()
            self.logs.append(self.server.log())


class Clients:
    """Threads that submit a given number of jobs, and threads that send synchronous requests until they are stopped."""

    def __init__(self, port, known, wanted):
        self.port = port
        self.known = known
        self.turn = iter(list(itertools.islice(itertools.cycle(questions()), wanted)))
        self.lock = threading.Lock()
        self.jobs = {}
        self.refused = collections.Counter()
        self.statuses = collections.Counter()
        self.wrong = []
        self.over = threading.Event()
        self.submitters = [threading.Thread(target=self._submit) for _ in range(2)]
        self.askers = [threading.Thread(target=self._ask) for _ in range(2)]
        for thread in self.submitters + self.askers:
            thread.start()

    def _submit(self):
        """Submits jobs. A request that was not accepted is repeated; a job whose 202 was lost does not count."""
        while True:
            with self.lock:
                case = next(self.turn, None)
            if case is None:
                return
            end = time.monotonic() + PATIENCE
            while (status := self._try(case, LATER)[0]) != 202:
                self.refused[status] += 1
                if time.monotonic() > end:
                    self.wrong.append(f"waited {PATIENCE} s for {case.name} to be accepted; last status: {status}")
                    return
                time.sleep(0.05)

    def _try(self, case, headers):
        try:
            status, body = ask(self.port, "POST", case.path, case.body, {**case.headers, **headers})
        except (OSError, http.client.HTTPException) as error:
            return type(error).__name__, b""
        if status == 202:
            with self.lock:
                self.jobs["/jobs/" + json.loads(body)["id"]] = case
        return status, body

    def _ask(self):
        for case in itertools.cycle(questions()):
            if self.over.is_set():
                return
            status, body = self._try(case, {})
            self.statuses[status] += 1
            if status == 200 and cases.essence(body) not in self.known[case.name]:
                self.wrong.append(f"{case.name} has a different synchronous answer: {body[:200]}")

    def failed(self):
        """Returns the number of synchronous requests that failed."""
        return sum(count for status, count in self.statuses.items() if status != 200)

    def is_submitting(self):
        return any(thread.is_alive() for thread in self.submitters)

    def join(self):
        for thread in self.submitters:
            join(thread, "the acceptance of all jobs", PATIENCE)
        self.over.set()
        for thread in self.askers:
            join(thread, "the last synchronous answer", PATIENCE)


def trouble(replicas, redis, clients, seconds):
    """Kills or pauses a server every second, and kills Redis three times. Returns the counts."""
    done = collections.Counter()
    end = time.monotonic() + seconds
    for number in itertools.count():
        if time.monotonic() > end:
            return done
        time.sleep(1)
        replica = replicas[number % len(replicas)]
        if number % 7 == 4:
            replica.server.signal(signal.SIGSTOP)
            time.sleep(2 * LEASE)
            replica.server.signal(signal.SIGCONT)
            done["servers paused"] += 1
        elif number % 3 == 1 and done["Redis killed"] < 3:
            redis.kill()
            time.sleep(0.5)
            redis.start()
            done["Redis killed"] += 1
        else:
            replica.end(signal.SIGKILL)
            replica.start()
            done["servers killed"] += 1


def drain(replica, clients):
    """Drains a server under load. Returns all faults, as texts."""
    time.sleep(3)  # haproxy knows that all are there
    before, answered = clients.failed(), sum(clients.statuses.values())
    code = replica.end(signal.SIGTERM)
    time.sleep(1)
    lost = clients.failed() - before
    print(f"  drained with {code}; of {sum(clients.statuses.values()) - answered} requests meanwhile {lost} were lost")
    replica.start()
    wrong = [f"a drain lost {lost} requests: {dict(clients.statuses)}"] if lost else []
    return wrong + ([f"a drained server ended with {code}"] if code else [])


def status_of(port, job):
    status, body = ask(port, "GET", job)
    return json.loads(body)["status"] if status == 200 else f"answered {status}"


def check(port, clients):
    """Waits for the end of all jobs, and returns all faults, as texts."""
    end = time.monotonic() + PATIENCE
    left = list(clients.jobs)
    while left and time.monotonic() < end:
        left = [job for job in left if status_of(port, job) in ("queued", "running")]
        time.sleep(0.1)
    wrong = [f"{job} has not ended" for job in left]
    for job, case in clients.jobs.items():
        status, body = ask(port, "GET", job + "/result")
        if status != 200 or cases.essence(body) not in clients.known[case.name]:
            wrong.append(f"{job} ({case.name}) is answered {status}: {body[:300]}")
    return wrong


def twice(replicas):
    """Returns the jobs whose end was logged more than once, as texts."""
    ends = collections.Counter(job for replica in replicas for log in replica.logs
                               for job in re.findall(r"job ([0-9a-f]{32}) (?:succeeded|failed)", log))
    return [f"/jobs/{job} ended {count} times" for job, count in ends.items() if count > 1]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=60, help="minimum time in which servers are killed and paused")
    parser.add_argument("--before", metavar="PROGRAM", help="a server of another release, with which all start; "
                                                            "they are upgraded in turn under load")
    arguments = parser.parse_args()
    if not HAPROXY.exists():
        print("skipped: docker/install --unpack tools has not run")
        return 0
    start = time.monotonic()
    known = learn(None, *([arguments.before] if arguments.before else []))
    with contextlib.ExitStack() as stack:
        # With the default, once per second, Redis replies before the data is on the disk.
        redis = stack.enter_context(Redis("--appendfsync", "always"))
        replicas = [Replica(redis, arguments.before) for _ in range(3)]
        for replica in replicas:
            stack.callback(replica.close)
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        balancer = stack.enter_context(Balancer(folder, [replica.server for replica in replicas]))
        clients = Clients(balancer.port, known, arguments.jobs)
        stack.callback(clients.over.set)
        wrong = [fault for replica in replicas if arguments.before for fault in drain(replica, clients)]
        done = trouble(replicas, redis, clients, arguments.seconds)
        wrong += drain(replicas[0], clients)
        clients.join()
        print(f"  {dict(done)}; {len(clients.jobs)} jobs accepted, others answered {dict(clients.refused)}; "
              f"at once {dict(clients.statuses)}")
        wrong += clients.wrong + check(balancer.port, clients)
    wrong += twice(replicas)
    if not done["servers killed"] or not done["Redis killed"] or not done["servers paused"]:
        wrong.append("the time was too short to kill a server, to kill Redis and to pause a server")
    print(f"{time.monotonic() - start:.0f} s")
    print("\n".join(["FAILED:", *wrong[:20]]) if wrong else "passed")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
