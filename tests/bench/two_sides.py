#!/usr/bin/python3
"""How much dots on both sides of the tonal scale are worth: the tables of core/README.md.

usage: two_sides.py URL PICTURE:DOTS ...        e.g. two_sides.py http://localhost:8080 photo.jpg:20000

Prints tables in Markdown, for dots=ink and dots=both with as many dots, antialiased, at 6 output pixels a pixel:
  grain   of flat greys, 16,000 dots on 256 x 256 pixels: standard deviation of L* after a Gaussian of one mean pitch
  error   of pictures: mean and 95th percentile of |dL*| after Gaussians of 0.5, 1 and 2 mean pitches
The pitch is sqrt(area / dots); blurs are in linear light. Pictures are read as sRGB: one with another profile would be
measured wrong.
"""
import io
import sys
import urllib.request

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter

SCALE = 6
GREYS = (32, 63, 89, 124, 149, 170, 188, 203, 230, 248)
TO_LUMINANCE = (0.2126, 0.7152, 0.0722)


def luminance(data):
    values = np.asarray(Image.open(io.BytesIO(data)).convert("RGB")) / 255
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4) @ TO_LUMINANCE


def lightness(light):
    return np.where(light > 216 / 24389, 116 * np.cbrt(light) - 16, light * 24389 / 27)


def halftone(url, data, dots, sites):
    query = f"dots={dots}&sites={sites}&scale={SCALE}&antialias=true&format=png"
    request = urllib.request.Request(f"{url}/halftone?{query}", data, {"Content-Type": "application/octet-stream"})
    with urllib.request.urlopen(request) as answer:
        return luminance(answer.read())


def grain(url, grey, dots, sites=16000, side=256):
    file = io.BytesIO()
    Image.new("L", (side, side), grey).save(file, "PNG")
    drawn = halftone(url, file.getvalue(), dots, sites)
    pitch = (drawn.size / sites) ** 0.5
    margin = int(4 * pitch)
    return lightness(gaussian_filter(drawn, pitch)[margin:-margin, margin:-margin]).std()


def errors(url, data, dots, sites):
    drawn = halftone(url, data, dots, sites)
    wanted = np.repeat(np.repeat(luminance(data), SCALE, 0), SCALE, 1)[:drawn.shape[0], :drawn.shape[1]]
    pitch = (drawn.size / sites) ** 0.5
    for blur in (0.5, 1, 2):
        error = abs(lightness(gaussian_filter(drawn, blur * pitch)) - lightness(gaussian_filter(wanted, blur * pitch)))
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
    main(*sys.argv[1:])
