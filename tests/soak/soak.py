# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads the real server with honest, slow, vanishing and hostile clients at once, and says whether it stood it.

It passes if every answer to an honest client was right, or a refusal of a full queue that says when to come back; if
every hostile client got what it had to get; and if the server holds no more memory, descriptors, threads and processes
at rest than after the warm-up. With --latency-bound also only if small requests took at most twice as long beside
honest and hostile clients as beside the same honest ones alone, in the 99th percentile.
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

CROWD = 300          # connections at once, before the warm-up
MOST_TIMES = 2       # longer that small requests may take beside hostile clients than without them
HONEST_SHARE = 0.3   # of a round, in which there are no hostile clients, to compare with
SWIFT_SHARE = 0.25   # of a round, in which there are only swift requests, so that many go through


class Watched(Server):
    """Its log holds a line a request, which are let go."""

    def keeps(self, line):
        return " total=" not in line


def is_expected(line):
    """Children that were killed are replaced. Sanitizers need system calls that the decoder's filter would not let
    through, so there is none with them."""
    return "started again" in line or (SANITIZED and "not in force: " in line)


class Fatal(Exception):
    """There is no point in going on."""


def figures(server):
    """The server's own, summed over labels, but with those of ccdt_cancellations_total apart."""
    with urllib.request.urlopen(server.url("/metrics"), timeout=PATIENCE) as answer:
        text = answer.read().decode()
    found = collections.Counter()
    for name, labels, value in re.findall(r"^(\w+)(?:\{(.*)\})? (\S+)$", text, re.MULTILINE):
        cause = re.search(r'cause="(\w+)"', labels)
        found[cause[1] if cause else name] += float(value)
    return found


# The server, what makes processes that compute, the decoder's keeper and helper, and the child that waits for a picture.
# Besides these there is a process for each worker, and one for short requests, once they are needed.
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
        """Watches the server until the loads have ended; returns their tallies."""
        try:
            while time.monotonic() < until:
                self.check()
                now = watch.held(self.server.process.pid)
                self.most = watch.Held(*map(max, self.most, now))
                time.sleep(0.25)
            return [each.end(load.LONGEST) for each in loads]
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
        """These clients, and those that measure. Returns how long small requests took."""
        port, until = self.server.port, time.monotonic() + seconds
        tallies = self.run([*(Process(group, port, self.known, until) for group in (load.probe, *groups)),
                            Hammer(port, self.known, 1, seconds)], until)
        waits = tallies[0].take_waits()
        for tally in tallies:
            self.tally.add(tally)
        return waits

    def round(self, seconds):
        """The honest clients alone, then everyone at once, then only swift ones. Returns how long small requests took
        in the first part and in the second."""
        calm, swift = (max(2, round(share * seconds)) for share in (HONEST_SHARE, SWIFT_SHARE))
        waits = (self.load(calm, load.honest), self.load(max(2, int(seconds) - calm - swift), load.honest,
                                                         hostile.hostile))
        for tally in self.run([Hammer(self.server.port, self.known, 4, swift)], time.monotonic() + swift):
            self.tally.add(tally)
        return waits

    def kill_children(self):
        """As the system does when memory is short. A second later pictures are decoded again, or the server says that
        it is not ready."""
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
        """Waits until nothing is left to do, and notes what the server then holds."""
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
    """What the quiet server answers to everything that will be asked."""
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


def report_clients(counts, told):
    """Returns what failed."""
    failed = []
    print("\n| clients | |\n|---|---|")
    print(f"| honest, right answers | {counts['right']} |\n| put off by a full queue | {counts['put off']} |")
    for group in hostile.GROUPS:
        for act in group[1]:
            print(f"| {act.__name__.replace('_', ' ')} | {counts[act.__name__]} |")
    for what in sorted(what for what in counts if what.startswith("failed ")):
        print(f"| **{what}** | {counts[what]} |")
        failed.append(f"{counts[what]} {what}")
    for what, details in told.items():
        for detail in details:
            print(f"  {what}: {detail}")
    return failed


def report_held(levels, most):
    """Returns what grows."""
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
        print("Memory is not judged: sanitizers keep what is freed.")
    return failed


def report_latency(quiet, honest, loaded, missed, bound):
    """Returns what took too long, if that is asked for."""
    print("\n| small requests, ms | n | p50 | p90 | p99 |\n|---|---|---|---|---|")
    for name, waits in (("quiet, before", quiet[0]), ("quiet, after", quiet[1]),
                        ("beside honest clients", honest), ("beside hostile ones, too", loaded)):
        show_waits(name, waits)
    calm, beside, all_told = (percentile([wait.taken for wait in waits], 0.99)
                              for waits in (quiet[0] + quiet[1], honest, loaded))
    print(f"\nThe p99 beside hostile clients is {all_told / beside:.1f} times that beside honest ones alone, and "
          f"{all_told / calm:.1f} times the quiet one. {missed} came too late to be measured.")
    if bound and not all_told <= MOST_TIMES * beside:
        return [f"p99 of small requests is {all_told / beside:.1f} times that without hostile clients, over {MOST_TIMES}"]
    return []


def plan(seconds):
    """Seconds of a quiet measurement, of the warm-up and of a round, and how many rounds: together about so long, with
    what clients need to come to their end."""
    quiet, ending = seconds / 15, 8
    rounds = 7 if seconds >= 300 else 3
    each = (seconds - 2 * quiet - ending * (rounds + 1)) / (rounds + 1.3)
    return quiet, 1.3 * each, each, rounds


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=600, help="about so long, 60 at least")
    parser.add_argument("--latency-bound", action="store_true", help="small requests have to keep to their bound")
    parser.add_argument("--flag", action="append", default=[], help="one more for the server")
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
              "given up as their clients had left")
        counts = soak.tally.counts
        failed = (report_clients(counts, soak.tally.told) + report_held(soak.levels, soak.most) +
                  report_latency(quiet, honest, loaded, counts["missed"], arguments.latency_bound))
        if given_up == 0:
            failed.append("no computation was given up for a client that had left")
        if server.stop() != 0:
            failed.append("the server did not end well")
        if errors := [line for line in server.log().splitlines() if " error " in line and not is_expected(line)]:
            failed.append("errors in the log: " + "\n".join(errors[:5]))
    print("\nFAILED: " + "; ".join(failed) if failed else "\npassed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
