#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the structural similarity (SSIM) of halftones and pictures for several strengths of sharpening.

Usage: similarity.py URL DETAIL,... PICTURE ...    For example: similarity.py http://localhost:8080 0,0.5,0.7 photo.jpg

Prints two Markdown tables: the means of all pictures for each value of `detail`, and the values of each picture.
Pictures become grey first, and are read as sRGB. Halftones have dots=both, the default number of dots for print, and 6
antialiased output pixels per pixel. Values are means of the seeds 1 and 2. Gaussian blurs are computed in linear light
and measured in pitches; the pitch is sqrt(area / dots). Then the halftone is reduced to the pixels of the picture, and
the SSIM of the sRGB values is computed with a Gaussian window of 1.5 pixels (Wang, Bovik, Sheikh, Simoncelli 2004).
"""
import io
import json
import pathlib
import sys
import urllib.request

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter

from two_sides import SCALE, halftone, luminance

SEEDS = (1, 2)
BLURS = {"both blurred by one pitch": (1, 1), "both blurred by half a pitch": (0.5, 0.5),
         "only the halftone blurred, by half a pitch": (0.5, 0)}


def similarity(one, other):
    """Returns the mean SSIM of planes with values from 0 to 1."""
    def mean(plane):
        return gaussian_filter(plane, 1.5, truncate=3.5)

    mean_one, mean_other = mean(one), mean(other)
    covariance = mean(one * other) - mean_one * mean_other
    variances = mean(one ** 2) - mean_one ** 2 + mean(other ** 2) - mean_other ** 2
    return ((2 * mean_one * mean_other + 0.01 ** 2) * (2 * covariance + 0.03 ** 2) /
            ((mean_one ** 2 + mean_other ** 2 + 0.01 ** 2) * (variances + 0.03 ** 2))).mean()


def srgb(light):
    light = np.clip(light, 0, 1)
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)


def default_sites(url, data):
    """Returns the number of dots that the server chooses for print."""
    request = urllib.request.Request(f"{url}/halftone?dots=both&format=json", data,
                                     {"Content-Type": "application/octet-stream"})
    with urllib.request.urlopen(request) as answer:
        return json.load(answer)["sites"]


def reduced(light):
    """Returns the means of the output pixels in each pixel of the picture."""
    rows, columns = (side // SCALE for side in light.shape)
    return light.reshape(rows, SCALE, columns, SCALE).mean((1, 3))


def values(url, path, detail):
    """Returns the SSIM after each blur, as the mean of the seeds."""
    file = io.BytesIO()
    Image.fromarray(np.uint8(np.round(255 * srgb(luminance(path.read_bytes()))))).save(file, "PNG")
    data = file.getvalue()
    sites = default_sites(url, data)
    wanted = luminance(data)
    pitch = (wanted.size / sites) ** 0.5
    results = []
    for seed in SEEDS:
        drawn = luminance(halftone(url, data, "both", sites, f"&scale={SCALE}&seed={seed}&detail={detail}"))
        results.append([similarity(srgb(reduced(gaussian_filter(drawn, of_drawn * pitch * SCALE))),
                                   srgb(gaussian_filter(wanted, of_wanted * pitch)))
                        for of_drawn, of_wanted in BLURS.values()])
    return np.mean(results, 0)


def main(url, details, *paths):
    details, paths = details.split(","), [pathlib.Path(path) for path in paths]
    found = {detail: [values(url, path, detail) for path in paths] for detail in details}
    print(f"| SSIM, mean of {len(paths)} pictures |", " | ".join(BLURS), "|\n|---|" + "---|" * len(BLURS))
    for detail in details:
        print(f"| `detail={detail}` |", " | ".join(f"{value:.4f}" for value in np.mean(found[detail], 0)), "|")
    print(f"\n| SSIM, {' / '.join(f'`detail={detail}`' for detail in details)} |", " | ".join(BLURS), "|")
    print("|---|" + "---|" * len(BLURS))
    for i, path in enumerate(paths):
        cells = zip(*(found[detail][i] for detail in details))
        print(f"| `{path.name}` |", " | ".join(" / ".join(f"{value:.4f}" for value in cell) for cell in cells), "|")


if __name__ == "__main__":
    main(*sys.argv[1:])
