# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws spectra side by side, in decibels, because dark areas in a plot of /analyze differ by orders of magnitude.

Usage: spectra.py standard.json best.json stealthy.json spectra.webp
The JSON files are answers of POST /analyze with spectra up to frequency 1.5, of equally many points on a torus.
"""

import json
import pathlib
import sys

import numpy
from PIL import Image, ImageDraw, ImageFont

LOWEST, HIGHEST = -200, 10  # dB, black and white
SIDE, GAP, LABEL = 385, 15, 24


def panel(answer):
    """Returns the power as grey values, with the lowest frequency in the middle."""
    spectrum = answer["spectrum"]
    power = numpy.array(spectrum["values"], dtype=float).reshape(spectrum["height"], spectrum["width"])
    decibels = 10 * numpy.log10(numpy.maximum(power, 10 ** (LOWEST / 10)))
    grey = (decibels - LOWEST) / (HIGHEST - LOWEST)
    return Image.fromarray(numpy.uint8(255 * numpy.clip(grey, 0, 1))).resize((SIDE, SIDE), Image.NEAREST)


def main(sources, target):
    image = Image.new("L", (len(sources) * (SIDE + GAP) - GAP, SIDE + LABEL), 255)
    draw, font = ImageDraw.Draw(image), ImageFont.load_default()
    for number, source in enumerate(sources):
        left = number * (SIDE + GAP)
        path = pathlib.Path(source)
        image.paste(panel(json.loads(path.read_text(encoding="utf-8"))), (left, LABEL))
        draw.text((left, 6), f"{path.stem}, {LOWEST} to {HIGHEST} dB", font=font, fill=0)
    image.save(target, quality=50)


main(sys.argv[1:-1], sys.argv[-1])
