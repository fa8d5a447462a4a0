#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Counts sites near the borders of shapes, for points of a running server: prints a Markdown table.

Usage: borders.py URL SITES SEEDS DEPTH ...    For example: borders.py http://localhost:8080 4096 5 1 1.5 2 4

The table has the number of sites within DEPTH mean spacings of the border, relative to the number that the area of this
strip should hold: 1.00 means that sites neither crowd at the border nor avoid it. If the density varies, it is relative
to the integral of the density over the strip. The mean spacing is sqrt(area / SITES). The seeds are 1 to SEEDS.
"""
import json
import math
import pathlib
import sys
import urllib.request

import numpy
from shapely.geometry import Point, Polygon, box, mapping, shape
from shapely.prepared import prep

POLYGONS = pathlib.Path(__file__).resolve().parent.parent / "data" / "polygons"
ARC = 64  # segments of a quarter circle, in the outline of a strip
SQUARE = box(0, 0, 1, 1)
GRID = 128


def corners(count, outer, inner):
    """Returns points around the origin, alternately at two radii."""
    return [(radius * math.cos(angle), radius * math.sin(angle))
            for angle, radius in ((2 * math.pi * i / count, (outer, inner)[i % 2]) for i in range(count))]


def holes(count):
    """Returns the unit square with count x count round holes, which cover a fifth of it."""
    radius = math.sqrt(0.2 / math.pi) / count
    centres = [Point((i + 0.5) / count, (j + 0.5) / count) for i in range(count) for j in range(count)]
    return Polygon(SQUARE.exterior, [centre.buffer(radius).exterior for centre in centres])


def waves():
    """Returns a grid of densities from 1 to 16, with three waves along each side."""
    wave = numpy.sin(6 * math.pi * (numpy.arange(GRID) + 0.5) / GRID)
    return 4 ** (1 + numpy.outer(wave, wave))


def country(name):
    return shape(json.loads((POLYGONS / name).read_text()))


def shapes():
    """Yields names, shapes and densities on grids."""
    yield "square", SQUARE, None
    yield "Switzerland, 740 corners", country("Switzerland-10m.geojson"), None
    yield "South Africa, with its hole", country("South-Africa-50m.geojson"), None
    yield "Italy, 3 parts", country("Italy-110m.geojson"), None
    yield "star with 12 needles", Polygon(corners(24, 1, 0.05)), None
    yield "square with 9 round holes", holes(3), None
    yield "square, density 1 to 16 in waves", SQUARE, waves()
    yield "circle of 20,000 edges", Polygon(corners(20000, 1, 1)), None


def sample(url, area, density, sites, seed):
    body = {"sites": sites, "seed": seed, "geometry": mapping(area)}
    if density is not None:
        body["density"] = {"width": GRID, "height": GRID, "values": density.ravel().tolist()}
    request = urllib.request.Request(f"{url}/sample", json.dumps(body).encode(), {"Content-Type": "application/json"})
    with urllib.request.urlopen(request) as answer:
        return [Point(point) for point in json.load(answer)["points"]]


def share(part, area, density):
    """Returns the share of the density over an area that lies in a part of it."""
    if density is None:
        return part.area / area.area
    left, bottom, right, top = area.bounds
    xs, ys = numpy.linspace(left, right, GRID + 1), numpy.linspace(bottom, top, GRID + 1)
    within = [[box(xs[i], ys[j], xs[i + 1], ys[j + 1]).intersection(part).area for i in range(GRID)]
              for j in range(GRID)]
    return (density * within).sum() / (density.mean() * area.area)


def main(url, sites, seeds, *depths):
    sites, seeds = int(sites), int(seeds)
    print(f"| {sites:,} sites | t = {' | '.join(depths)} |\n|---|{'---|' * len(depths)}")
    for name, area, density in shapes():
        points = [point for seed in range(1, seeds + 1) for point in sample(url, area, density, sites, seed)]
        spacing = math.sqrt(area.area / sites)
        figures = []
        for depth in map(float, depths):
            inner = area.buffer(-depth * spacing, ARC)
            near = len(points) - sum(map(prep(inner).contains, points))
            figures.append(near / (len(points) * (1 - share(inner, area, density))))
        print(f"| {name} |", " | ".join(f"{figure:.2f}" for figure in figures), "|", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
