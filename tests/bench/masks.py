#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the threshold masks of a server and masks of the literature, and prints the results as Markdown tables.

    masks.py http://localhost:8080 --side 128 --depth 1
    masks.py http://localhost:8080 --side 64 --depth 32

The rows of a table are the mean power of the pixels below a threshold, relative to random pixels. In each frame, it is
that below a quarter and below half of the principal frequency of the rarer pixels, black or white. In time, it is that
of single pixels below a quarter of the frequency at which the rarer ones follow each other, and at most below 1/8. The
last lines are the errors of means of successive frames. Masks of the literature are void-and-cluster (Ulichney 1993,
sigma 1.5) and, for several frames, spatiotemporal blue noise (Wolfe et al. 2022, sigma 1.9).
"""
import argparse
import io
import json
import time
import urllib.request

import numpy

SHARES = (1 / 64, 1 / 16, 1 / 8, 1 / 4, 3 / 8, 1 / 2, 3 / 4, 15 / 16, 63 / 64)


def from_server(url, side, depth, seed):
    torus = {"type": "torus", "width": side, "height": side, "depth": depth}
    body = json.dumps({"format": "masknpy", "seed": seed, "domain": torus}).encode()
    return numpy.load(io.BytesIO(urllib.request.urlopen(url + "/sample", body).read())) / 65536


def void_and_cluster(side, depth, seed):
    """Returns a mask by void-and-cluster: of a single frame, or of spatiotemporal blue noise."""
    sigma = 1.5 if depth == 1 else 1.9
    shape = (depth, side, side)
    t, y, x = (numpy.minimum(axis, size - axis) for axis, size in zip(numpy.indices(shape), shape))
    kernel = numpy.exp(-(x ** 2 + y ** 2 + t ** 2) / (2 * sigma ** 2)) * ((t == 0) | ((x == 0) & (y == 0)))
    chosen = numpy.zeros(shape, bool)
    chosen.ravel()[numpy.random.default_rng(seed).permutation(chosen.size)[:chosen.size // 10]] = True
    crowding = numpy.fft.ifftn(numpy.fft.fftn(kernel) * numpy.fft.fftn(chosen)).real

    def change(place, sign):
        frame, row, column = numpy.unravel_index(place, shape)
        crowding[frame] += sign * numpy.roll(kernel[0], (row, column), (0, 1))
        if depth > 1:
            crowding[:, row, column] += sign * numpy.roll(kernel[:, 0, 0], frame)
            crowding[frame, row, column] -= sign
        chosen.ravel()[place] = sign > 0

    def cluster():
        return numpy.where(chosen, crowding, -1).argmax()

    def void():
        return numpy.where(chosen, 1e9, crowding).argmin()

    while True:
        first = cluster()
        change(first, -1)
        second = void()
        change(second, 1)
        if first == second:
            break
    start = chosen.copy(), crowding.copy()
    ranks = numpy.zeros(chosen.size)
    few = int(chosen.sum())
    for rank in reversed(range(few)):
        place = cluster()
        change(place, -1)
        ranks[place] = rank
    chosen[:], crowding[:] = start
    for rank in range(few, chosen.size):
        place = void()
        change(place, 1)
        ranks[place] = rank
    return (ranks.reshape(shape) + 0.5) / chosen.size


def measure(values):
    """Returns the rows of a mask in the table by name: a power for each threshold."""
    depth, side = values.shape[:2]
    frequency = numpy.hypot(*numpy.meshgrid(*2 * [numpy.fft.fftfreq(side)]))
    rows = {"frames, below 0.25": [], "frames, below 0.5": []}
    if depth > 1:
        rows["time"] = []
    for share in SHARES:
        below = values < share
        rarer = min(share, 1 - share)
        white = side ** 2 * share * (1 - share)
        power = (numpy.abs(numpy.fft.fft2(below - share)) ** 2).mean(0) / white
        for limit in (0.25, 0.5):
            low = (frequency > 0) & (frequency < limit * rarer ** 0.5)
            rows[f"frames, below {limit}"].append(power[low].mean())
        if depth == 1:
            continue
        in_time = (numpy.abs(numpy.fft.rfft(below - share, axis=0)) ** 2).mean((1, 2)) / (depth * share * (1 - share))
        slow = int(depth * min(rarer / 4, 1 / 8))
        rows["time"].append(in_time[1:slow + 1].mean() if slow > 0 else numpy.nan)
    return rows


def table(masks):
    print("| threshold | " + " | ".join(f"{share:.3g}" for share in SHARES) + " |")
    print("|---" * (len(SHARES) + 1) + "|")
    measured = {name: measure(mask) for name, mask in masks.items()}
    for quantity in next(iter(measured.values())):
        for name, rows in measured.items():
            cells = ("" if numpy.isnan(value) else f"{value:.3f}" for value in rows[quantity])
            print(f"| {name}, {quantity} | " + " | ".join(cells) + " |")


def averages(name, values):
    """Prints the error of the mean of successive frames, relative to independent frames."""
    errors = []
    for frames in (2, 4, 8, 16):
        mean = sum(numpy.roll(values, i, 0) for i in range(frames)) / frames
        errors.append(f"{frames}: {mean.std() * (12 * frames) ** 0.5:.2f}")
    print(f"{name}, error of the mean of frames: " + ", ".join(errors))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("url")
    parser.add_argument("--side", type=int, default=128)
    parser.add_argument("--depth", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    size = arguments.side, arguments.depth, arguments.seed
    begin = time.perf_counter()
    masks = {"this project": from_server(arguments.url, *size)}
    print(f"time of the server: {time.perf_counter() - begin:.2f} s\n")
    masks["void-and-cluster" if arguments.depth == 1 else "Wolfe et al."] = void_and_cluster(*size)
    table(masks)
    print()
    for name, values in masks.items():
        if arguments.depth > 16:
            averages(name, values)


if __name__ == "__main__":
    main()
