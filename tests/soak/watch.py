# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the resources that a process and its descendants hold, by /proc, and judges whether they grow."""

import itertools
import os
import pathlib
import re
import statistics
import typing

MEMORY_NOISE = 8 << 20  # difference of resident memory between two measurements without a leak, in bytes
MEMORY_LEAK = 512       # tolerated growth, in bytes per request
COUNT_NOISE = 3         # the same for the numbers of descriptors and threads
COUNT_LEAK = 0.0001
# What one more computation process holds, the descriptors and threads that the server has for it included. The server
# keeps as many of these processes as have ever computed at the same time.
FILES_OF_PROCESS = 9
THREADS_OF_PROCESS = 3


class Held(typing.NamedTuple):
    memory: int     # resident memory that is not mapped from files, in bytes
    files: int
    threads: int
    processes: int


NOTHING = Held(0, 0, 0, 0)


class Level(typing.NamedTuple):
    """The resources that an idle server held after a number of requests."""
    requests: int
    held: Held


def family(pid):
    """Returns the ids of a process and its descendants."""
    pids = [pid]
    for parent in pids:
        try:
            for task in pathlib.Path(f"/proc/{parent}/task").iterdir():
                pids += map(int, (task / "children").read_text().split())
        except OSError:
            continue  # the process has just ended
    return pids


def _files_of(folder):
    try:
        return len(os.listdir(folder / "fd"))
    except OSError:  # the process has just ended, or is confined, so that its files cannot be listed
        return 0


def _of(pid):
    folder = pathlib.Path(f"/proc/{pid}")
    try:
        status = dict(re.findall(r"(\w+):\s+(\d+)", (folder / "status").read_text()))
    except OSError:
        return NOTHING
    if "RssAnon" not in status:
        return NOTHING
    memory = (int(status["RssAnon"]) + int(status["RssShmem"])) << 10
    return Held(memory, _files_of(folder), int(status["Threads"]), 1)


def held(pid):
    """Returns the resources held by a process and its descendants together."""
    return Held(*map(sum, zip(*map(_of, family(pid)))))


def slope(points):
    """Returns the slope of a line through points: the median over all pairs (Theil and Sen), which ignores outliers."""
    rates = [(b[1] - a[1]) / (b[0] - a[0]) for a, b in itertools.combinations(points, 2) if b[0] != a[0]]
    return statistics.median(rates) if rates else 0.0


class Growth(typing.NamedTuple):
    first: float
    last: float
    slope: float    # per request
    allowed: float  # from first to last
    leaks: bool
    least: float    # smallest leak per request that would have been detected


def growth(points, noise, leak):
    """Judges pairs (requests, amount) of an idle server, from the end of the warm-up to the end of the load.

    There is a leak if both the last amount and the line through all of them rise by more than is allowed. Noise raises
    one of them, a leak raises both.
    """
    requests = points[-1][0] - points[0][0]
    allowed = max(noise, leak * requests)
    first, last, rate = points[0][1], points[-1][1], slope(points)
    leaks = last - first > allowed and rate * requests > allowed
    return Growth(first, last, rate, allowed, leaks, allowed / max(requests, 1))


def judge(levels):
    """Returns the growth of each resource, by name."""
    def over(name):
        return [(level.requests, getattr(level.held, name)) for level in levels]

    more = max(levels[-1].held.processes - levels[0].held.processes, 0)
    return {"memory": growth(over("memory"), MEMORY_NOISE, MEMORY_LEAK),
            "files": growth(over("files"), COUNT_NOISE + FILES_OF_PROCESS * more, COUNT_LEAK),
            "threads": growth(over("threads"), COUNT_NOISE + THREADS_OF_PROCESS * more, COUNT_LEAK),
            "processes": growth(over("processes"), COUNT_NOISE, 0)}
