#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the distances of new points from fixed points: prints the table of results/regions.md.

Usage: fixed.py URL SETS    For example: fixed.py http://localhost:8080 10

The table is in Markdown. The domain is a square, then a torus; the entries for the two are separated by a comma. The
fixed points of a set are random, and the sets have the seeds 1 to SETS. A distance is that of a new point from the
nearest fixed point, relative to the median distance of a new point of this set from its nearest new neighbour. The
smallest distance and the first percentile are those of the new points of all sets together. If the fixed points lie in
a small square, the first percentile is left out, because nearly all new points are far from the square.
"""
import json
import sys
import urllib.request

import numpy
from scipy.spatial import cKDTree

SIDES = ((0, 0), (1, 0), (1, 1), (0, 1))
TORUS = {"type": "torus", "width": 1, "height": 1}
QUALITIES = ("draft", "standard")

# The numbers of fixed and of new points, and the side of the square in which the fixed points lie.
CASES = ((100, 1000, 1), (450, 4096, 1), (1000, 1000, 1), (100, 1000, 1 / 20), (450, 4096, 1 / 20))


def post(url, body):
    request = urllib.request.Request(url, json.dumps(body).encode(), {"Content-Type": "application/json"})
    with urllib.request.urlopen(request) as answer:
        return json.load(answer)


def distances(url, fixed, sites, quality, seed, periodic):
    """Returns the relative distance of each new point from the nearest fixed point."""
    domain = {"domain": TORUS} if periodic else {"polygon": SIDES}
    body = {"sites": sites, "quality": quality, "seed": seed, "fixed": fixed.tolist(), **domain}
    points = numpy.array(post(f"{url}/sample", body)["points"])
    period = 1 if periodic else None
    if periodic:
        points, fixed = points % 1, fixed % 1
    neighbour = cKDTree(points, boxsize=period).query(points, 2)[0][:, 1]
    return cKDTree(fixed, boxsize=period).query(points)[0] / numpy.median(neighbour)


def entries(url, sets, quality, fixed, sites, side):
    """Returns the smallest distance and the first percentile, each on a square and on a torus."""
    found = []
    for periodic in (False, True):
        parts = []
        for seed in range(1, sets + 1):
            random = numpy.random.default_rng(seed)
            corner = random.random(2) * (1 - side)
            parts.append(distances(url, corner + side * random.random((fixed, 2)), sites, quality, seed, periodic))
        found.append(numpy.concatenate(parts))
    yield ", ".join(f"{each.min():.2f}" for each in found)
    yield ", ".join(f"{numpy.percentile(each, 1):.2f}" for each in found) if side == 1 else ""


def main(url, sets):
    heads = (f"{quality}: smallest | first percentile" for quality in QUALITIES)
    print("| fixed points, new points |", " | ".join(heads),
          "|\n|---|" + "---|---|" * len(QUALITIES))
    for fixed, sites, side in CASES:
        place = "" if side == 1 else f", fixed ones in 1/{round(side ** -2)} of the area"
        row = [each for quality in QUALITIES for each in entries(url, int(sets), quality, fixed, sites, side)]
        print(f"| {fixed:,}, {sites:,}{place} |", " | ".join(row), "|", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
