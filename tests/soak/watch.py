# SPDX-License-Identifier: GPL-3.0-or-later
"""What a program and its children hold, through /proc, and whether that grows."""

import itertools
import os
import pathlib
import re
import statistics
import typing

MEMORY_NOISE = 8 << 20  # bytes by which the resident memory of a sound server may differ from rest to rest
MEMORY_LEAK = 512       # bytes a request
COUNT_NOISE = 3         # the same for descriptors and threads, in pieces
COUNT_LEAK = 0.0001


class Held(typing.NamedTuple):
    memory: int     # bytes, resident and not of files
    files: int
    threads: int
    processes: int


NOTHING = Held(0, 0, 0, 0)


class Level(typing.NamedTuple):
    """What was held at rest, after so many requests."""
    requests: int
    held: Held


def family(pid):
    """The process and those that descend from it."""
    pids = [pid]
    for parent in pids:
        try:
            for task in pathlib.Path(f"/proc/{parent}/task").iterdir():
                pids += map(int, (task / "children").read_text().split())
        except OSError:
            continue  # it has just ended
    return pids


def _files_of(folder):
    try:
        return len(os.listdir(folder / "fd"))
    except OSError:  # it has just ended, or is confined and may be looked into by nobody
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
    """By the process and its descendants together."""
    return Held(*map(sum, zip(*map(_of, family(pid)))))


def slope(points):
    """Of a line through them, the median of all pairs' (Theil and Sen): a few outliers do not matter."""
    rates = [(b[1] - a[1]) / (b[0] - a[0]) for a, b in itertools.combinations(points, 2) if b[0] != a[0]]
    return statistics.median(rates) if rates else 0.0


class Growth(typing.NamedTuple):
    first: float
    last: float
    slope: float    # a request
    allowed: float  # from first to last
    leaks: bool
    least: float    # a request: a leak of this much would have been seen


def growth(points, noise, leak):
    """Judges (requests, amount) at rest, from the end of the warm-up to the end of the load.

    It leaks if both the last level and the line through all of them rise by more than is allowed: noise moves the one
    or the other, a leak moves both.
    """
    requests = points[-1][0] - points[0][0]
    allowed = max(noise, leak * requests)
    first, last, rate = points[0][1], points[-1][1], slope(points)
    leaks = last - first > allowed and rate * requests > allowed
    return Growth(first, last, rate, allowed, leaks, allowed / max(requests, 1))


def judge(levels):
    """Growth by the name of what is held."""
    def over(name):
        return [(level.requests, getattr(level.held, name)) for level in levels]

    return {"memory": growth(over("memory"), MEMORY_NOISE, MEMORY_LEAK),
            "files": growth(over("files"), COUNT_NOISE, COUNT_LEAK),
            "threads": growth(over("threads"), COUNT_NOISE, COUNT_LEAK),
            "processes": growth(over("processes"), COUNT_NOISE, 0)}
