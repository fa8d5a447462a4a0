# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the cost of sharing: of jobs in Redis over jobs in memory, of answers from Redis, and of three servers over
one."""

import argparse
import concurrent.futures
import contextlib
import http.client
import json
import os
import pathlib
import statistics
import sys
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
from engine import Redis  # pylint: disable=wrong-import-position
from harness import Server, file_of, flat  # pylint: disable=wrong-import-position

TORUS = {"type": "torus", "width": 1, "height": 1}
LATER = {"Prefer": "respond-async"}


class Client:
    """A connection that is kept."""

    def __init__(self, server):
        self.connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)

    def ask(self, method, path, body=None, headers=None):
        self.connection.request(method, path, body and json.dumps(body), headers or {})
        answer = self.connection.getresponse()
        return answer.status, answer.read()

    def job(self, body):
        """Runs a job, and returns the milliseconds from its request to the event of its end."""
        start = time.perf_counter()
        status, document = self.ask("POST", "/sample", body, LATER)
        assert status == 202, document
        _, stream = self.ask("GET", f"/jobs/{json.loads(document)['id']}/events")
        assert b"event: succeeded" in stream, stream
        return 1000 * (time.perf_counter() - start)

    def wait_for_libraries(self):
        """Waits until a picture was decoded: the server accepts connections before its decoder has loaded."""
        self.connection.request("POST", "/halftone?sites=50", file_of(flat(100)), {"Content-Type": "image/png"})
        answer = self.connection.getresponse()
        answer.read()
        assert answer.status == 200

    def answer(self, body):
        start = time.perf_counter()
        status, answer = self.ask("POST", "/sample", body)
        assert status == 200, answer
        return 1000 * (time.perf_counter() - start), len(answer)


def report(name, times):
    cuts = statistics.quantiles(times, n=100)
    print(f"  {name}: p50 {cuts[49]:.2f} ms, p99 {cuts[98]:.2f} ms of {len(times)}")
    return cuts[49], cuts[98]


def jobs(redis, count):
    """Measures jobs in memory and in Redis alternately, so that both see the same load of the machine."""
    body = {"sites": 64, "iterations": 1, "domain": TORUS}
    with Server("--workers=1", "--job-bytes=1GiB", "--memory=4GiB") as alone, \
            Server("--workers=1", f"--redis={redis.url}") as shared:
        clients = [Client(alone), Client(shared)]
        times = [[], []]
        worked = cpu(redis)
        for number in range(count + 20):
            for client, list_ in zip(clients, times):
                list_.append(client.job({**body, "seed": number}))
        worked = cpu(redis) - worked
    before = report("a job in memory", times[0][20:])
    after = report("a job by Redis ", times[1][20:])
    print(f"  Redis worked {1000 * worked / (count + 20):.2f} ms a job: at most {(count + 20) / worked:.0f} jobs a second")
    print(f"  over memory: {after[0] - before[0]:.2f} ms at p50, {after[1] - before[1]:.2f} ms at p99")


def cpu(redis):
    """Returns the processor time of Redis, in seconds."""
    values = dict(line.split(":") for line in redis.cli("INFO", "cpu").split() if ":" in line)
    return float(values["used_cpu_user"]) + float(values["used_cpu_sys"])


def cpu_of_descendants():
    """Returns the processor time of servers, their child processes and Redis, in seconds."""
    children, seconds = {}, {}
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            # The second field, the name in parentheses, may contain anything.
            fields = (process / "stat").read_text().rpartition(")")[2].split()
            children.setdefault(int(fields[1]), []).append(int(process.name))
            seconds[int(process.name)] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    total, found = 0, children.get(os.getpid(), [])
    while found:
        total += sum(seconds[process] for process in found)
        found = [child for process in found for child in children.get(process, [])]
    return total


def answers(redis, count):
    """Measures cached answers of about 100 kB, from the local cache and from Redis."""
    body = {"sites": 2500, "iterations": 0, "domain": TORUS}
    with Server("--workers=1", "--cache=64MiB") as here, \
            Server("--workers=1", f"--cache-redis={redis.url}") as there:
        clients = [Client(here), Client(there)]
        size = [client.answer(body) for client in clients][0][1]
        times = [[], []]
        for _ in range(count + 20):
            for client, list_ in zip(clients, times):
                list_.append(client.answer(body)[0])
    print(f"  an answer of {size} bytes")
    before = report("kept here      ", times[0][20:])
    after = report("kept by Redis  ", times[1][20:])
    print(f"  over here: {after[0] - before[0]:.2f} ms at p50")


def throughput(redis, count):
    """Measures jobs per second, from the first request to the last end, and the processor time per job."""
    body = {"sites": 1024, "iterations": 5, "domain": TORUS}

    def run(servers):
        clients = [Client(server) for server in servers]
        for client in clients:
            client.wait_for_libraries()
        worked = cpu_of_descendants()
        start = time.perf_counter()
        ids = [json.loads(clients[seed % len(clients)].ask("POST", "/sample", {**body, "seed": seed}, LATER)[1])["id"]
               for seed in range(count)]

        def wait(job):
            client = Client(servers[0])
            assert b"event: succeeded" in client.ask("GET", f"/jobs/{job}/events")[1]

        with concurrent.futures.ThreadPoolExecutor(8) as pool:
            list(pool.map(wait, ids))
        rate = count / (time.perf_counter() - start)
        return rate, 1000 * (cpu_of_descendants() - worked) / count

    runs = [[], []]
    flags = ("--max-connections-per-address=0", "--job-queue=10000", f"--redis={redis.url}")
    for _ in range(5):
        with Server("--workers=4", *flags) as one:  # three of the workers are for jobs
            runs[0].append(run([one]))
        with contextlib.ExitStack() as stack:
            three = [stack.enter_context(Server("--workers=1", *flags)) for _ in range(3)]
            runs[1].append(run(three))
    for name, each in (("jobs a second", 0), ("ms of all CPUs a job", 1)):
        one, three = ([run[each] for run in kind] for kind in runs)
        over = statistics.median(three) / statistics.median(one) - 1
        print(f"  {name}: one server {shown(one)}, three {shown(three)} ({100 * over:+.0f} %)")


def shown(numbers):
    low, middle, high = min(numbers), statistics.median(numbers), max(numbers)
    return f"{middle:.3g} ({low:.3g} to {high:.3g})"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--appendfsync", choices=("always", "everysec"), default="everysec")
    arguments = parser.parse_args()
    with Redis("--appendfsync", arguments.appendfsync) as redis:
        jobs(redis, arguments.count)
        answers(redis, arguments.count)
        throughput(redis, arguments.count)


if __name__ == "__main__":
    main()
