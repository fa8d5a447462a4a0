# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads a server with honest, slow, disconnecting and hostile clients at the same time, and reports whether it failed.

The test passes if these conditions hold. Every honest client got the right answer, or a refusal with a time to retry
because the queue was full. Every hostile client got the expected answer. The idle server holds no more memory, descriptors, threads and
processes than after the warm-up. With --latency-bound, the 99th percentile of the time of small requests beside honest
and hostile clients is at most twice that beside the same honest clients alone.
"""

import argparse
import collections
import contextlib
import os
import pathlib
import re
import signal
import sys
import time
import urllib.request

import cases
import hostile
import load
import watch
from load import Client, Hammer, Process, Tally

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
from harness import PATIENCE, Server  # pylint: disable=wrong-import-position
from raw import SANITIZED  # pylint: disable=wrong-import-position

CROWD = 300          # simultaneous connections before the warm-up
MAX_LATENCY_RATIO = 2  # limit of the latencies with hostile clients, relative to those without
HONEST_SHARE = 0.3   # share of a round without hostile clients, for comparison
SWIFT_SHARE = 0.25   # share of a round with short requests only, so that there are many of them


class Watched(Server):
    """A server that stores no log lines of requests, because there are too many."""

    def keeps(self, line):
        return " total=" not in line


def is_expected(line):
    """Returns whether an error in the log is expected: killed children are restarted, and sanitizers make system calls
    that the decoder's filter would deny, so they have no filter."""
    return "started again" in line or (SANITIZED and "not in force: " in line)


class Fatal(Exception):
    """An error after which the test cannot continue."""


def figures(server):
    """Returns the server's metrics, summed over labels. Those of ccdt_cancellations_total are separate, by cause."""
    with urllib.request.urlopen(server.url("/metrics"), timeout=PATIENCE) as answer:
        text = answer.read().decode()
    found = collections.Counter()
    for name, labels, value in re.findall(r"^(\w+)(?:\{(.*)\})? (\S+)$", text, re.MULTILINE):
        cause = re.search(r'cause="(\w+)"', labels)
        found[cause[1] if cause else name] += float(value)
    return found


# Processes of an idle server: the server, the fork server, the decoder's keeper and helper, and the child that waits
# for a picture. In addition, there is a process for each worker and one for short requests, once they are needed.
KEPT = 5


class Soak:
    def __init__(self, server, known):
        self.server = server
        self.known = known
        self.tally = Tally()
        self.most = watch.Held(0, 0, 0, 0)
        self.levels = []
        self.resting = KEPT + int(figures(server)["ccdt_workers"]) + 1

    def check(self):
        if self.server.process.poll() is not None:
            raise Fatal(f"the server ended with {self.server.process.returncode}:\n{self.server.log()[-3000:]}")

    def run(self, loads, until):
        """Watches the server until `until`, then waits for the loads to end; returns their tallies."""
        try:
            while time.monotonic() < until:
                self.check()
                now = watch.held(self.server.process.pid)
                self.most = watch.Held(*map(max, self.most, now))
                time.sleep(0.25)
            return [each.end(load.TIME_LIMIT) for each in loads]
        except BaseException:
            for each in loads:
                each.process.kill()
            raise

    def measure_quiet(self, seconds):
        until = time.monotonic() + seconds
        tally, = self.run([Process(load.probe, self.server.port, self.known, until)], until)
        waits = tally.take_waits()
        self.tally.add(tally)
        return waits

    def load(self, seconds, *groups):
        """Runs groups of clients, and clients that measure. Returns the measured waits of small requests."""
        port, until = self.server.port, time.monotonic() + seconds
        tallies = self.run([*(Process(group, port, self.known, until) for group in (load.probe, *groups)),
                            Hammer(port, self.known, 1, seconds)], until)
        waits = tallies[0].take_waits()
        for tally in tallies:
            self.tally.add(tally)
        return waits

    def round(self, seconds):
        """Runs the honest clients alone, then all clients, then short requests only. Returns the measured waits of
        small requests in the first and in the second part."""
        calm, swift = (max(2, round(share * seconds)) for share in (HONEST_SHARE, SWIFT_SHARE))
        waits = (self.load(calm, load.honest), self.load(max(2, int(seconds) - calm - swift), load.honest,
                                                         hostile.hostile))
        for tally in self.run([Hammer(self.server.port, self.known, 4, swift)], time.monotonic() + swift):
            self.tally.add(tally)
        return waits

    def kill_children(self):
        """Kills all child processes, as the kernel does when memory runs out. After a second, pictures must be decoded
        again, or be refused because the server is not ready."""
        for pid in watch.family(self.server.process.pid)[1:]:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        time.sleep(1)
        self.check()
        with contextlib.closing(Client(self.server.port, "127.0.2.1")) as client:
            for case in cases.pictures():
                load.judge(client.ask(case), case, self.known, self.tally)
        self.tally.count("children killed")

    def rest(self):
        """Waits until the server is idle, and records the resources that it then holds."""
        end = time.monotonic() + 30
        while True:
            self.check()
            now = figures(self.server)
            held = watch.held(self.server.process.pid)
            at_work = {name: now[name] for name in ("ccdt_workers_busy", "ccdt_queue_requests") if now[name]}
            if now["ccdt_connections_open"] > 1:
                at_work["connections"] = now["ccdt_connections_open"]
            if held.processes > self.resting:
                at_work["processes"] = held.processes
            if not at_work:
                break
            if time.monotonic() > end:
                self.tally.fail("rest", f"half a minute after the load: {dict(at_work)}")
                break
            time.sleep(0.05)
        self.levels.append(watch.Level(int(now["ccdt_http_requests_total"]), held))


def learn(server):
    """Returns the essence of the idle server's answer to each case, by name."""
    known = {}
    client = Client(server.port, "127.0.2.1")
    for case in cases.everything():
        if case.name not in known:
            answer = client.ask(case)
            if answer.status != case.status:
                raise Fatal(f"{case.name} is answered {answer.status} before there is any load: {answer.body[:300]}")
            known[case.name] = cases.essence(answer.body)
    client.close()
    return known


def percentile(values, share):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else float("nan")


def show_waits(name, waits):
    for what, values in ((name, [wait.taken for wait in waits]),
                         ("- not sent, as the one before was not answered", [wait.late for wait in waits]),
                         ("- waiting for a worker", [wait.queue for wait in waits]),
                         ("- computing", [wait.computing for wait in waits]),
                         ("- all else", [wait.rest for wait in waits])):
        shares = " | ".join(f"{percentile(values, share):.1f}" for share in (0.5, 0.9, 0.99))
        print(f"| {what} | {len(values)} | {shares} |")


def report_clients(counts, failures):
    """Prints the counts. Returns failures, as texts."""
    failed = []
    print("\n| clients | |\n|---|---|")
    print(f"| honest, right answers | {counts['right']} |\n| put off by a full queue | {counts['put off']} |")
    for group in hostile.GROUPS:
        for act in group[1]:
            print(f"| {act.__name__.replace('_', ' ')} | {counts[act.__name__]} |")
    for what in sorted(what for what in counts if what.startswith("failed ")):
        print(f"| **{what}** | {counts[what]} |")
        failed.append(f"{counts[what]} {what}")
    for what, details in failures.items():
        for detail in details:
            print(f"  {what}: {detail}")
    return failed


def report_held(levels, most):
    """Prints the resources held. Returns those that grow, as texts."""
    failed = []
    print("\n| held at rest, children included | after warm-up | at the end | under load, most | slope, a request | "
          "allowed | would be seen, a request |\n|---|---|---|---|---|---|---|")
    for name, found in watch.judge(levels).items():
        size, unit = (1 << 20, " MiB") if name == "memory" else (1, "")
        print(f"| {name} | {found.first / size:.1f}{unit} | {found.last / size:.1f}{unit} | "
              f"{getattr(most, name) / size:.1f}{unit} | {found.slope:.3g} | +{found.allowed / size:.1f}{unit} | "
              f"{found.least:.3g} |")
        if found.leaks and not (name == "memory" and SANITIZED):
            failed.append(f"{name} grows")
    print("\nMiB at rest after so many requests:",
          ", ".join(f"{level.held.memory / (1 << 20):.1f} after {level.requests}" for level in levels))
    if SANITIZED:
        print("Memory is not judged, because sanitizers keep freed memory.")
    return failed


def report_latency(quiet, honest, loaded, missed, bound):
    """Prints the latencies. Returns failures, as texts, if there is a bound."""
    print("\n| small requests, ms | n | p50 | p90 | p99 |\n|---|---|---|---|---|")
    for name, waits in (("quiet, before", quiet[0]), ("quiet, after", quiet[1]),
                        ("beside honest clients", honest), ("beside hostile ones, too", loaded)):
        show_waits(name, waits)
    calm, beside, beside_all = (percentile([wait.taken for wait in waits], 0.99)
                              for waits in (quiet[0] + quiet[1], honest, loaded))
    print(f"\nThe p99 beside hostile clients is {beside_all / beside:.1f} times that beside honest ones alone, and "
          f"{beside_all / calm:.1f} times the quiet one. {missed} came too late to be measured.")
    if bound and not beside_all <= MAX_LATENCY_RATIO * beside:
        return [f"p99 of small requests is {beside_all / beside:.1f} times that without hostile clients, over {MAX_LATENCY_RATIO}"]
    return []


def plan(seconds):
    """Returns the seconds of a quiet measurement, of the warm-up and of a round, and the number of rounds. With the
    time that clients need to end, they add up to about `seconds`."""
    quiet, ending = seconds / 15, 8
    rounds = 7 if seconds >= 300 else 3
    each = (seconds - 2 * quiet - ending * (rounds + 1)) / (rounds + 1.3)
    return quiet, 1.3 * each, each, rounds


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=600, help="approximate duration, at least 60")
    parser.add_argument("--latency-bound", action="store_true", help="fail if small requests take too long")
    parser.add_argument("--flag", action="append", default=[], help="additional flag for the server")
    arguments = parser.parse_args()
    quiet_seconds, warm_up, each, rounds = plan(max(arguments.seconds, 60))
    start = time.monotonic()
    with Watched(*hostile.FLAGS, *arguments.flag) as server:
        try:
            soak = Soak(server, learn(server))
            quiet = [soak.measure_quiet(quiet_seconds)]
            hostile.everyone_at_once(server.port, CROWD)
            soak.kill_children()
            soak.round(warm_up)
            soak.rest()
            honest, loaded = [], []
            for _ in range(rounds):
                soak.kill_children()
                for waits, found in zip((honest, loaded), soak.round(each)):
                    waits += found
                soak.rest()
            quiet.append(soak.measure_quiet(quiet_seconds))
            given_up = figures(server)["client_gone"]
        except Fatal as failure:
            print(f"FAILED: {failure}")
            return 1
        print(f"\n{time.monotonic() - start:.0f} s, {soak.levels[-1].requests} requests, {given_up:.0f} computations "
              "cancelled because their clients had disconnected")
        counts = soak.tally.counts
        failed = (report_clients(counts, soak.tally.details) + report_held(soak.levels, soak.most) +
                  report_latency(quiet, honest, loaded, counts["missed"], arguments.latency_bound))
        if given_up == 0:
            failed.append("no computation was cancelled because its client had disconnected")
        if server.stop() != 0:
            failed.append("the server did not exit with 0")
        if errors := [line for line in server.log().splitlines() if " error " in line and not is_expected(line)]:
            failed.append("errors in the log: " + "\n".join(errors[:5]))
    print("\nFAILED: " + "; ".join(failed) if failed else "\npassed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
