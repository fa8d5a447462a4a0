#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the distances between classes of a dot map: prints the table of results/regions.md.

Usage: classes.py URL SEEDS    For example: classes.py http://localhost:8080 2

The table is in Markdown. The map has 4,800 dots on four squares of equal density. A distance is that of a dot from the
nearest dot of another class, relative to the hexagonal distance of all dots. Each entry has the mean and the first
percentile of this distance, as means of the seeds 1 to SEEDS. In the last column, each class is a dot map of its own,
in standard quality and with another seed for each class.
"""
import json
import sys
import urllib.request

import numpy
from scipy.spatial import cKDTree

DOTS = 4800
SQUARES = ((0, 0), (1, 0), (0, 1), (1, 1))  # lower left corners
HEXAGONAL = (2 / 3 ** 0.5 * len(SQUARES) / DOTS) ** 0.5
CASES = {"two classes of equal size": (1, 1), "four classes of equal size": (1, 1, 1, 1),
         "two classes, sizes 1 : 4": (1, 4), "two classes, sizes 1 : 20": (1, 20)}


def post(url, body):
    request = urllib.request.Request(url, json.dumps(body).encode(), {"Content-Type": "application/json"})
    with urllib.request.urlopen(request) as answer:
        return json.load(answer)


def dot_map(sizes):
    """Returns a collection of squares, each with its number of dots of each class, and the names of the classes."""
    ends = numpy.rint(numpy.cumsum((0, *sizes)) / sum(sizes) * DOTS / len(SQUARES)).astype(int)
    counts = {f"class{number}": int(count) for number, count in enumerate(numpy.diff(ends))}
    features = [{"type": "Feature", "properties": counts, "geometry": {"type": "Polygon", "coordinates": [
        [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]]]}} for x, y in SQUARES]
    return {"type": "FeatureCollection", "features": features}, list(counts)


def together(url, sizes, quality, seed):
    """Returns the dots of each class of one dot map."""
    geometry, names = dot_map(sizes)
    made = post(f"{url}/sample", {"geometry": geometry, "classes": names, "quality": quality, "seed": seed})
    points, classes = numpy.array(made["points"]), numpy.array(made["class"])
    return [points[classes == number] for number in range(len(names))]


def separately(url, sizes, seed):
    """Returns the dots of each class, where each is a dot map of its own."""
    geometry, names = dot_map(sizes)
    bodies = ({"geometry": geometry, "sites": name, "seed": 100 * seed + number} for number, name in enumerate(names))
    return [numpy.array(post(f"{url}/sample", body)["points"]) for body in bodies]


def figures(classes):
    """Returns the mean and the first percentile of the distances from other classes."""
    assert sum(map(len, classes)) == DOTS
    distances = numpy.concatenate([
        cKDTree(numpy.concatenate(classes[:number] + classes[number + 1:])).query(dots)[0]
        for number, dots in enumerate(classes)]) / HEXAGONAL
    return distances.mean(), numpy.percentile(distances, 1)


def main(url, seeds):
    ways = {"standard": lambda sizes, seed: together(url, sizes, "standard", seed),
            "best": lambda sizes, seed: together(url, sizes, "best", seed),
            "each class placed separately": lambda sizes, seed: separately(url, sizes, seed)}
    print("| classes |", " | ".join(ways), "|\n|---|" + "---|" * len(ways))
    for name, sizes in CASES.items():
        row = (numpy.mean([figures(way(sizes, seed)) for seed in range(1, int(seeds) + 1)], 0) for way in ways.values())
        print(f"| {name} |", " | ".join(f"{mean:.2f}, {least:.2f}" for mean, least in row), "|", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
