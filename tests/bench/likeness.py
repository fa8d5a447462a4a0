#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares halftones in cyan, magenta, yellow and black with their pictures: prints the table of results/halftones.md.

Usage: likeness.py URL SITES PICTURE ...    For example: likeness.py http://localhost:8080 30000 astronaut.png

The table is in Markdown, and compares dots=ink with dots=both. It has the mean and the 95th percentile of the CIEDE2000
difference, and the mean error of L* of pixels whose L* in the picture is below 20, or "none" if less than 1 % of the
picture is as dark. The drawing has 3 x 3 pixels for each pixel of the picture. Drawing and picture are blurred in
linear light by a Gaussian whose standard deviation is two pitches. The pitch is sqrt(area / sites).
"""
import io
import pathlib
import sys
import urllib.request

import numpy
from PIL import Image, ImageCms

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
from seen import LIGHT, ciede2000, lab, seen_light  # pylint: disable=wrong-import-position

SCALE = 3
DOTS = ("ink", "both")


def light(data):
    """Returns the linear light of each channel of a picture file, with the primaries of sRGB."""
    image = Image.open(io.BytesIO(data)).convert("RGB")
    profile = image.info.get("icc_profile")
    if profile:
        image = ImageCms.profileToProfile(image, io.BytesIO(profile), ImageCms.createProfile("sRGB"))
    return LIGHT[numpy.asarray(image)]


def drawing(url, data, sites, dots):
    """Returns the linear light of a halftone, averaged over each pixel of the picture."""
    query = f"color=cmyk&sites={sites}&scale={SCALE}&format=png&dots={dots}"
    request = urllib.request.Request(f"{url}/halftone?{query}", data, {"Content-Type": "application/octet-stream"})
    with urllib.request.urlopen(request) as answer:
        drawn = light(answer.read())
    height, width = drawn.shape[0] // SCALE, drawn.shape[1] // SCALE
    return drawn.reshape(height, SCALE, width, SCALE, 3).mean((1, 3))


def entries(url, data, sites, dots):
    """Returns the mean difference, its 95th percentile, and the error of L* in dark places."""
    wanted = light(data)
    sigma = 2 * (wanted.shape[0] * wanted.shape[1] / sites) ** 0.5
    wanted = lab(seen_light(wanted, sigma))
    seen = lab(seen_light(drawing(url, data, sites, dots), sigma))
    difference = ciede2000(wanted, seen)
    dark = wanted[..., 0] < 20
    error = f"{(seen - wanted)[dark][:, 0].mean():+.1f}" if dark.mean() > 0.01 else "none"
    return f"{difference.mean():.1f}", f"{numpy.percentile(difference, 95):.1f}", error.replace("-0.0", "+0.0")


def main(url, sites, *pictures):
    print("| `cmyk` |", " | ".join(f"`{dots}`: mean | 95th percentile | error of L* where L* < 20" for dots in DOTS),
          "|\n|---|" + 3 * len(DOTS) * "---|")
    for picture in pictures:
        data = pathlib.Path(picture).read_bytes()
        row = [each for dots in DOTS for each in entries(url, data, int(sites), dots)]
        print(f"| `{pathlib.Path(picture).name}` |", " | ".join(row), "|", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
