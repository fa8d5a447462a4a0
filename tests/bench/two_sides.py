#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares drawings by one field with discs of ink: prints the tables of results/halftones.md.

Usage: two_sides.py URL [--colour] [--palette=COLOURS] PICTURE:DOTS[:X,Y,SIDE] ...
For example: two_sides.py http://localhost:8080 photo.jpg:20000
             two_sides.py http://localhost:8080 --palette=ff48b0,0078bf astronaut.png:4000:130,0,256

X,Y,SIDE selects a square of the picture by its upper left corner.
The tables are in Markdown and compare dots=ink with dots=both, with the same number of dots, antialiased, at 6 output
pixels per pixel:
  grain   of flat greys, 16,000 dots on 256 x 256 pixels: standard deviation of L* after a Gaussian blur of one pitch
  error   of pictures: mean and 95th percentile of |dL*| after Gaussian blurs of 0.5, 1 and 2 pitches
With --colour, the tables are for color=cmyk, at 4 output pixels per pixel, in CIEDE2000. For flat tints, they have the
mean error after blurs of one and two pitches. With --palette, the same table of pictures is for these inks, separated
by commas. The pitch is sqrt(area / dots); blurs are computed in linear light.
Pictures are read as sRGB, so the figures are wrong for pictures with another profile.
"""
import argparse
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


def colour_errors(url, data, dots, sites, blurs, inks="color=cmyk", margin=0, scale=4):
    """Returns the CIEDE2000 errors after each blur, except in a margin given in pitches."""
    drawn = light(halftone(url, data, dots, sites, f"&{inks}&scale={scale}"))
    wanted = np.repeat(np.repeat(light(data), scale, 0), scale, 1)[:drawn.shape[0], :drawn.shape[1]]
    pitch = (drawn.shape[0] * drawn.shape[1] / sites) ** 0.5
    edge = int(margin * pitch / 3)
    inside = slice(edge, -edge or None)
    return [seen.ciede2000(lab(wanted, blur * pitch), lab(drawn, blur * pitch))[inside, inside] for blur in blurs]


def flat(colour, side=256):
    file = io.BytesIO()
    Image.new("RGB", (side, side), colour).save(file, "PNG")
    return file.getvalue()


def read(picture):
    """Returns the name of a picture, its file and the number of dots, from an argument."""
    path, sites, *part = picture.split(":")
    name = path.rsplit("/", 1)[-1]
    if not part:
        return name, pathlib.Path(path).read_bytes(), int(sites)
    x, y, side = map(int, part[0].split(","))
    file = io.BytesIO()
    Image.open(path).crop((x, y, x + side, y + side)).save(file, "PNG")
    return name, file.getvalue(), int(sites)


def print_tints(url):
    print("| tint |", " | ".join(map(str, TINTS)), "|\n|---|" + "---|" * len(TINTS))
    for dots in ("ink", "both"):
        errors = (colour_errors(url, flat(tint), dots, 16000, (1, 2), margin=4) for tint in TINTS)
        print(f"| `dots={dots}` |", " | ".join(" / ".join(f"{e.mean():.2f}" for e in each) for each in errors), "|",
              flush=True)
    print()


def print_pictures(pictures, errors_of):
    """Prints the mean and the 95th percentile of errors_of(data, dots, sites), which yields the errors of each blur."""
    print("| picture, dots | `dots` | half a pitch | one pitch | two pitches |\n|---|---|---|---|---|")
    for name, data, sites in map(read, pictures):
        for dots in ("ink", "both"):
            figures = " | ".join(f"{e.mean():.2f} / {np.percentile(e, 95):.2f}" for e in errors_of(data, dots, sites))
            print(f"| `{name}`, {sites:,} | {dots} | {figures} |", flush=True)


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
        yield abs(seen.lightness(gaussian_filter(drawn, blur * pitch)) -
                  seen.lightness(gaussian_filter(wanted, blur * pitch)))


def print_greys(url):
    print("| luminance |", " | ".join(f"{float(luminance_of(grey)):.3f}" for grey in GREYS), "|")
    print("|---|" + "---|" * len(GREYS))
    for dots in ("ink", "both"):
        print(f"| `dots={dots}` |", " | ".join(f"{grain(url, grey, dots):.3f}" for grey in GREYS), "|", flush=True)
    print()


def luminance_of(grey):
    value = grey / 255
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("url")
    parser.add_argument("--colour", action="store_true")
    parser.add_argument("--palette", metavar="COLOURS")
    parser.add_argument("pictures", nargs="*", metavar="PICTURE:DOTS")
    arguments = parser.parse_intermixed_args()
    url, inks = arguments.url, "color=cmyk"
    if arguments.palette:
        inks = "palette=" + ",".join(f"%23{colour}" for colour in arguments.palette.split(","))
    elif arguments.colour:
        print_tints(url)
    else:
        print_greys(url)
        print_pictures(arguments.pictures, lambda *picture: errors(url, *picture))
        return
    print_pictures(arguments.pictures, lambda *picture: colour_errors(url, *picture, (0.5, 1, 2), inks))


if __name__ == "__main__":
    main()
