#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Looks for seams and islands in halftones by a running server, which blurs of a pitch do not show.

Usage: seams.py URL [QUERY]
For example: seams.py http://localhost:8080 'dots=both'

Draws a ramp of luminance from 0.3 to 0.7, a flat of 0.5 with noise of 3 % and, for comparison, one without noise, each
with 4,000 dots at 8 output pixels a pitch. In windows of four pitches, measures the mean distance of dots to their
nearest neighbours, the same of holes, and the contrast at half a cycle to one cycle a pitch. Prints, for each measure,
the largest and the root mean square deviation of a window from the mean of its four neighbours.
"""
import io
import sys
import urllib.request

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter, maximum_filter
from scipy.spatial import cKDTree

DOTS, PITCH, WINDOW = 4000, 8, 4


def pictures():
    side = 256
    ramp = np.tile(np.linspace(0.3, 0.7, side), (side, 1))
    noise = 0.5 + 0.03 * np.random.default_rng(1).standard_normal((side, side))
    return {"ramp": ramp, "noise": noise, "flat": np.full((side, side), 0.5)}


def encoded(light):
    srgb = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    file = io.BytesIO()
    Image.fromarray(np.uint8(np.round(255 * srgb))).save(file, "PNG")
    return file.getvalue()


def drawn(url, query, data):
    side = round(PITCH * DOTS ** 0.5)
    request = urllib.request.Request(f"{url}/halftone?sites={DOTS}&antialias=true&width={side}&{query}", data)
    with urllib.request.urlopen(request) as answer:
        values = np.asarray(Image.open(io.BytesIO(answer.read())).convert("L")) / 255
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def spacing(light):
    """Returns places of the peaks of a picture, and their distances to the nearest one."""
    smooth = gaussian_filter(light, PITCH / 5)
    peaks = np.argwhere((smooth == maximum_filter(smooth, size=PITCH // 2 + 1)) & (smooth > light.mean()))
    distances, _ = cKDTree(peaks).query(peaks, 2)
    return peaks, distances[:, 1]


def windows(places, values, count):
    """Returns the mean of the values in each window."""
    index = np.minimum(places // (WINDOW * PITCH), count - 1)
    sums, numbers = np.zeros((count, count)), np.zeros((count, count))
    np.add.at(sums, tuple(index.T), values)
    np.add.at(numbers, tuple(index.T), 1)
    return sums / np.maximum(numbers, 1)


def deviations(means):
    """Returns the relative deviation of inner windows from the mean of their four neighbours."""
    inner = means[1:-1, 1:-1]
    around = (means[:-2, 1:-1] + means[2:, 1:-1] + means[1:-1, :-2] + means[1:-1, 2:]) / 4
    return inner / around - 1


def main():
    url, query = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else "dots=both"
    print("| largest and rms deviation, % | dots | holes | contrast |\n|---|---|---|---|")
    for name, light in pictures().items():
        seen = drawn(url, query, encoded(light))
        count = len(seen) // (WINDOW * PITCH)
        band = gaussian_filter(seen, 0.16 * PITCH) - gaussian_filter(seen, 0.32 * PITCH)
        places = np.argwhere(np.ones_like(seen, bool))
        contrast = windows(places, (band ** 2).ravel(), count) ** 0.5
        means = [windows(*spacing(1 - seen), count), windows(*spacing(seen), count), contrast]
        print(f"| {name} |", " | ".join(f"{100 * abs(each).max():.0f}, {100 * (each ** 2).mean() ** 0.5:.1f}"
                                        for each in map(deviations, means)), "|")


if __name__ == "__main__":
    main()
