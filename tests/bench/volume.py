#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the points that a server places in space, and prints the results as Markdown tables.

    volume.py http://localhost:8080 4096 --quality draft standard best stealthy --cycodebase PATH

The first table is for a torus of uniform density: distances relative to the face-centred cubic lattice, the mean power
below half its principal frequency, and noise. The rows of other methods are random points, scipy's Poisson disk (its
radius is chosen such that it finds about as many points), and Yuksel's sample elimination, which gets five random
samples per point. The second table has the noise for a ball whose density falls with the square of the radius, and for
random clumps. Near the middle of the ball, the density changes by a large factor within a spacing; a column leaves out
this core. Noise is that of the density of smoothed-particle hydrodynamics at the points, by a cubic spline with 58
neighbours: the standard deviation relative to the smoothed wanted density. All results are for one seed.
"""
import argparse
import io
import json
import time
import urllib.parse
import urllib.request

import numpy
from scipy.spatial import cKDTree
from scipy.stats import qmc

from elimination import Elimination

NEIGHBOURS = 58
NODES = 24  # nodes of the quadrature along the radius of the kernel; with 12, voxels add up to 0.3 % to the noise
CORE = 0.1  # radius of the core of the ball


def place(url, sites, quality, periodic, voxels=None):
    """Returns points in the unit cube, and the seconds of the server."""
    domain = {"type": "torus" if periodic else "box", "width": 1, "height": 1, "depth": 1}
    options = {"sites": sites, "quality": quality, "seed": 1, "format": "npy"}
    if voxels is None:
        request = urllib.request.Request(url + "/sample", json.dumps({**options, "domain": domain}).encode())
    else:
        body = io.BytesIO()
        numpy.save(body, voxels)
        query = urllib.parse.urlencode({**options, "domain": json.dumps(domain)})
        request = urllib.request.Request(url + "/sample?" + query, body.getvalue(),
                                         {"Content-Type": "application/x-npy"})
    begin = time.perf_counter()
    points = numpy.load(io.BytesIO(urllib.request.urlopen(request, timeout=600).read()))
    return points, time.perf_counter() - begin


def distances(points):
    """Returns the least and the mean distance to the nearest neighbour on the unit torus."""
    tree = cKDTree(points % 1, boxsize=1)
    nearest = tree.query(points % 1, k=2, workers=-1)[0][:, 1] / (2 ** (1 / 6) / len(points) ** (1 / 3))
    return nearest.min(), nearest.mean()


def low_power(points):
    """Returns the mean power below half the principal frequency of the lattice, in dB. Samples the waves if many."""
    end = len(points) ** (1 / 3) * 1.5 ** 0.5 / 2 ** (1 / 6) / 2
    span = numpy.arange(-int(end), int(end) + 1)
    waves = numpy.stack(numpy.meshgrid(span, span, span), -1).reshape(-1, 3)
    squared = (waves ** 2).sum(1)
    waves = waves[(squared > 0) & (squared < end ** 2)]
    waves = waves[:len(waves) // 2]  # one of each pair of opposite waves
    waves = waves[::max(1, len(waves) * len(points) // 40_000_000)]
    power = [abs(numpy.exp(2j * numpy.pi * (points @ wave)).sum()) ** 2 / len(points) for wave in waves]
    return 10 * numpy.log10(numpy.mean(power))


def kernel(q):
    """Returns the cubic spline of smoothed-particle hydrodynamics, up to a factor; q is in smoothing lengths."""
    return numpy.where(q < 1, 1 - 1.5 * q ** 2 + 0.75 * q ** 3, 0.25 * numpy.clip(2 - q, 0, None) ** 3)


def noise(points, periodic, density, core=0.0):
    """Returns the standard deviation of the ratio of the density at points to the smoothed wanted density, in percent.

    Args:
        density: function of positions [..., 3]: the number of points per volume, and 0 outside the domain.
        core: radius of a ball in the middle whose points are left out.
    """
    step = 2 * (numpy.arange(-NODES, NODES) + 0.5) / NODES
    nodes = numpy.stack(numpy.meshgrid(step, step, step), -1).reshape(-1, 3)
    weights = kernel(numpy.linalg.norm(nodes, axis=1))
    nodes, weights = nodes[weights > 0], weights[weights > 0]
    weights /= weights.sum()
    per_kernel = numpy.pi  # integral of kernel()
    tree = cKDTree(points % 1 if periodic else points, boxsize=1 if periodic else None)
    ratios = []
    for first in range(0, len(points), 64):
        some = points[first:first + 64]
        wanted = density(some)
        for _ in range(2):
            length = (NEIGHBOURS / (32 / 3 * numpy.pi * wanted)) ** (1 / 3)
            values = density(some[:, None] + length[:, None, None] * nodes)
            wanted = values @ weights
        inside = (values > 0).all(1)  # the border of the domain has no points on its other side
        inside &= numpy.linalg.norm(some - 0.5, axis=1) >= core
        near = tree.query_ball_point(some[inside] % 1 if periodic else some[inside], 2 * length[inside])
        for place_of, length_of, wanted_of, numbers in zip(some[inside], length[inside], wanted[inside], near):
            apart = points[numbers] - place_of
            if periodic:
                apart -= numpy.round(apart)
            found = kernel(numpy.linalg.norm(apart, axis=1) / length_of).sum() / (per_kernel * length_of ** 3)
            ratios.append(found / wanted_of)
    return 100 * numpy.std(ratios)


def voxel_density(voxels, sites):
    """Returns the function of a density that is constant in voxels."""
    scaled = voxels * (sites / voxels.mean())
    size = numpy.array(voxels.shape[::-1])

    def density(places):
        cells = numpy.floor(places * size).astype(int)
        inside = ((cells >= 0) & (cells < size)).all(-1)
        x, y, z = numpy.moveaxis(numpy.clip(cells, 0, size - 1), -1, 0)
        return numpy.where(inside, scaled[z, y, x], 0)
    return density


def ball(side=128):
    """Returns voxels of a ball whose density falls with the square of the radius."""
    z, y, x = (numpy.indices((side, side, side)) + 0.5) / side - 0.5
    squared = x ** 2 + y ** 2 + z ** 2
    return numpy.where(squared < 0.45 ** 2, 1 / numpy.maximum(squared, 0.03 ** 2), 0)


def clumps(side=64):
    """Returns voxels of random clumps on a background."""
    random = numpy.random.default_rng(7)
    z, y, x = (numpy.indices((side, side, side)) + 0.5) / side
    voxels = numpy.ones((side, side, side))
    for _ in range(24):
        centre, width = random.random(3), random.uniform(0.05, 0.12)
        squared = (x - centre[0]) ** 2 + (y - centre[1]) ** 2 + (z - centre[2]) ** 2
        voxels += random.uniform(3, 20) * numpy.exp(-squared / (2 * width ** 2))
    return voxels


def poisson_disk(sites):
    """Returns about as many points by scipy. They keep no distance across the faces of the cube."""
    radius = 0.83 / sites ** (1 / 3)
    begin = time.perf_counter()
    points = qmc.PoissonDisk(3, radius=radius, seed=1).fill_space()
    return points, time.perf_counter() - begin


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("url")
    parser.add_argument("sites", type=int)
    parser.add_argument("--quality", nargs="*", default=["standard"])
    parser.add_argument("--cycodebase")
    arguments = parser.parse_args()
    sites, qualities = arguments.sites, arguments.quality
    random = numpy.random.default_rng(1)
    patterns = {quality: place(arguments.url, sites, quality, True) for quality in qualities}
    patterns["random"] = random.random((sites, 3)), 0.0
    if arguments.cycodebase:
        with Elimination(arguments.cycodebase) as elimination:
            points, elapsed = elimination.choose(random.random((5 * sites, 3)), sites, 1.0, 3, True)
        patterns["sample elimination"] = points, elapsed / 1000
        points, seconds = poisson_disk(sites)
        patterns[f"Poisson disk, {len(points)} points"] = points, seconds
    columns = "least distance | mean distance | power, dB | noise of density, % | seconds"
    print(f"| torus, {sites} points | {columns} |")
    print("|---|---|---|---|---|---|")
    for name, (points, seconds) in patterns.items():
        least, mean = distances(points)
        even = noise(points, True, lambda at, count=len(points): numpy.full(at.shape[:-1], float(count)))
        print(f"| {name} | {least:.3f} | {mean:.3f} | {low_power(points):.1f} | {even:.2f} | {seconds:.2f} |", flush=True)
    print(f"\n| noise of density, {sites} points, % | ball | ball without its core | clumps |\n|---|---|---|---|")
    for name in [*(quality for quality in qualities if quality != "stealthy"), "random"]:
        row = []
        for voxels, core in ((ball(), 0.0), (ball(), CORE), (clumps(), 0.0)):
            if name == "random":
                cells = random.choice(voxels.size, sites, p=voxels.ravel() / voxels.sum())
                corners = numpy.stack(numpy.unravel_index(cells, voxels.shape)[::-1], -1)
                points = (corners + random.random((sites, 3))) / len(voxels)
            else:
                points, _ = place(arguments.url, sites, name, False, voxels)
            row.append(f"{noise(points, False, voxel_density(voxels, sites), core):.2f}")
        print(f"| {name} | " + " | ".join(row) + " |", flush=True)


if __name__ == "__main__":
    main()
