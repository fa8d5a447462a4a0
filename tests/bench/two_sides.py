#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the benefit of dots on both sides of the tonal scale: prints the tables of core/README.md.

Usage: two_sides.py URL [--colour] PICTURE:DOTS ...    For example: two_sides.py http://localhost:8080 photo.jpg:20000

The tables are in Markdown and compare dots=ink with dots=both, with the same number of dots, antialiased, at 6 output
pixels per pixel:
  grain   of flat greys, 16,000 dots on 256 x 256 pixels: standard deviation of L* after a Gaussian blur of one pitch
  error   of pictures: mean and 95th percentile of |dL*| after Gaussian blurs of 0.5, 1 and 2 pitches
With --colour, the tables are for color=cmyk, at 4 output pixels per pixel, in CIEDE2000. For flat tints, they have the
mean error after blurs of one and two pitches. The pitch is sqrt(area / dots); blurs are computed in linear light.
Pictures are read as sRGB, so the figures are wrong for pictures with another profile.
"""
import io
import pathlib
import sys
import urllib.request

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
import seen

SCALE = 6
GREYS = (32, 63, 89, 124, 149, 170, 188, 203, 230, 248)
TO_LUMINANCE = (0.2126, 0.7152, 0.0722)


TINTS = ((20, 40, 80), (120, 40, 20), (60, 60, 60), (40, 70, 30), (180, 170, 150), (230, 200, 180))


def light(data):
    values = np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), np.float32) / 255
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def lab(picture, sigma):
    """Returns L*, a*, b* of every third pixel, after a blur."""
    return seen.lab(np.stack([gaussian_filter(picture[..., c], sigma)[::3, ::3] for c in range(3)], -1))


def colour_errors(url, data, dots, sites, blurs, margin=0, scale=4):
    """Returns the CIEDE2000 errors after each blur, without a margin given in pitches."""
    drawn = light(halftone(url, data, dots, sites, f"&color=cmyk&scale={scale}"))
    wanted = np.repeat(np.repeat(light(data), scale, 0), scale, 1)[:drawn.shape[0], :drawn.shape[1]]
    pitch = (drawn.shape[0] * drawn.shape[1] / sites) ** 0.5
    edge = int(margin * pitch / 3)
    inside = slice(edge, -edge or None)
    return [seen.ciede2000(lab(wanted, blur * pitch), lab(drawn, blur * pitch))[inside, inside] for blur in blurs]


def flat(colour, side=256):
    file = io.BytesIO()
    Image.new("RGB", (side, side), colour).save(file, "PNG")
    return file.getvalue()


def main_of_colour(url, *pictures):
    print("| tint |", " | ".join(map(str, TINTS)), "|\n|---|" + "---|" * len(TINTS))
    for dots in ("ink", "both"):
        errors = (colour_errors(url, flat(tint), dots, 16000, (1, 2), 4) for tint in TINTS)
        print(f"| `dots={dots}` |", " | ".join(" / ".join(f"{e.mean():.2f}" for e in each) for each in errors), "|",
              flush=True)
    print("\n| picture, dots | `dots` | half a pitch | one pitch | two pitches |\n|---|---|---|---|---|")
    for picture in pictures:
        path, sites = picture.rsplit(":", 1)
        with open(path, "rb") as file:
            data = file.read()
        for dots in ("ink", "both"):
            errors = colour_errors(url, data, dots, int(sites), (0.5, 1, 2))
            figures = " | ".join(f"{e.mean():.2f} / {np.percentile(e, 95):.2f}" for e in errors)
            print(f"| `{path.rsplit('/', 1)[-1]}`, {int(sites):,} | {dots} | {figures} |", flush=True)


def luminance(data):
    return light(data) @ TO_LUMINANCE


def halftone(url, data, dots, sites, options=f"&scale={SCALE}"):
    """Requests a halftone, and returns the bytes of its PNG."""
    query = f"dots={dots}&sites={sites}&antialias=true&format=png{options}"
    request = urllib.request.Request(f"{url}/halftone?{query}", data, {"Content-Type": "application/octet-stream"})
    with urllib.request.urlopen(request) as answer:
        return answer.read()


def grain(url, grey, dots, sites=16000, side=256):
    file = io.BytesIO()
    Image.new("L", (side, side), grey).save(file, "PNG")
    drawn = luminance(halftone(url, file.getvalue(), dots, sites))
    pitch = (drawn.size / sites) ** 0.5
    margin = int(4 * pitch)
    return seen.lightness(gaussian_filter(drawn, pitch)[margin:-margin, margin:-margin]).std()


def errors(url, data, dots, sites):
    drawn = luminance(halftone(url, data, dots, sites))
    wanted = np.repeat(np.repeat(luminance(data), SCALE, 0), SCALE, 1)[:drawn.shape[0], :drawn.shape[1]]
    pitch = (drawn.size / sites) ** 0.5
    for blur in (0.5, 1, 2):
        error = abs(seen.lightness(gaussian_filter(drawn, blur * pitch)) - seen.lightness(gaussian_filter(wanted, blur * pitch)))
        yield f"{error.mean():.2f} / {np.percentile(error, 95):.2f}"


def main(url, *pictures):
    print("| luminance |", " | ".join(f"{float(luminance_of(grey)):.3f}" for grey in GREYS), "|")
    print("|---|" + "---|" * len(GREYS))
    for dots in ("ink", "both"):
        print(f"| `dots={dots}` |", " | ".join(f"{grain(url, grey, dots):.3f}" for grey in GREYS), "|", flush=True)
    print("\n| picture, dots | `dots` | half a pitch | one pitch | two pitches |\n|---|---|---|---|---|")
    for picture in pictures:
        path, sites = picture.rsplit(":", 1)
        with open(path, "rb") as file:
            data = file.read()
        for dots in ("ink", "both"):
            name = path.rsplit("/", 1)[-1]
            print(f"| `{name}`, {int(sites):,} | {dots} |", " | ".join(errors(url, data, dots, int(sites))), "|",
                  flush=True)


def luminance_of(grey):
    value = grey / 255
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--colour"]
    (main if len(arguments) == len(sys.argv) - 1 else main_of_colour)(*arguments)
