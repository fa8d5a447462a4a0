#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares device=1bit with error diffusion: prints a table of core/README.md.

Usage: pixels.py URL PICTURE ...    For example: pixels.py http://localhost:8080 photo.jpg

The table is in Markdown. It has the error of the picture that an eye sees, after Gaussian blurs in linear light: the
peak signal-to-noise ratio in dB of luminance, at 1.5 pixels, and the mean |dL*|, at 3 pixels. Error diffusion is that
of Floyd and Steinberg in linear light, with alternating directions. Colour profiles of the pictures are ignored.
"""
import io
import pathlib
import sys
import urllib.request

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter

TO_LUMINANCE = (0.2126, 0.7152, 0.0722)


def luminance(image):
    values = np.asarray(image.convert("RGB")) / 255
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4) @ TO_LUMINANCE


def lightness(values):
    return np.where(values > 0.008856, 116 * np.cbrt(values) - 16, 903.3 * values)


def diffused(wanted):
    rows, columns = wanted.shape
    left = np.pad(wanted, ((0, 1), (1, 1)))  # with a margin that takes the errors at the borders
    result = np.zeros_like(wanted)
    for y in range(rows):
        step = 1 if y % 2 == 0 else -1
        for x in range(columns)[::step]:
            value = left[y, x + 1]
            result[y, x] = value > 0.5
            error = value - result[y, x]
            left[y, x + 1 + step] += error * 7 / 16
            left[y + 1, x + 1 - step] += error * 3 / 16
            left[y + 1, x + 1] += error * 5 / 16
            left[y + 1, x + 1 + step] += error / 16
    return result


def errors(seen, wanted):
    fine = gaussian_filter(seen - wanted, 1.5)
    tones = [lightness(gaussian_filter(values, 3)) for values in (seen, wanted)]
    return f"{-10 * np.log10((fine ** 2).mean()):.1f} dB / {np.abs(tones[0] - tones[1]).mean():.2f}"


def main(url, *pictures):
    print("| picture | error diffusion | `device=1bit` |\n|---|---|---|")
    for path in pictures:
        image = Image.open(path).convert("RGB")
        image.info.clear()
        file = io.BytesIO()
        image.save(file, "PNG")
        request = urllib.request.Request(url + "/halftone?device=1bit", file.getvalue())
        with urllib.request.urlopen(request) as answer:
            ours = luminance(Image.open(io.BytesIO(answer.read())))
        wanted = luminance(image)
        print(f"| `{pathlib.Path(path).name}` | {errors(diffused(wanted), wanted)} | {errors(ours, wanted)} |", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
