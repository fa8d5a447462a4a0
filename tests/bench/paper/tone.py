# SPDX-License-Identifier: GPL-3.0-or-later
"""The ink of pictures and of dots, and the difference between them after a blur."""

import math

import numpy
from PIL import Image

LUMINANCE = (0.2126, 0.7152, 0.0722)


def ink(file):
    """Returns the ink of a picture, [height, width]: 1 - luminance, in linear light."""
    value = numpy.asarray(Image.open(file).convert("RGB")) / 255
    light = numpy.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    return 1 - light @ LUMINANCE


def dots(points, scale, target):
    """Draws discs, of the radius for which their mean darkness equals that of the target.

    points: in pixels of the target [height, width], y down. Returns [scale * height, scale * width], true for paper.
    """
    height, width = (scale * side for side in target.shape)
    low, high = 0, max(target.shape) * scale
    while high - low > 0.01:
        radius = 0.5 * (low + high)
        paper = _discs(points * scale, radius, height, width)
        low, high = (radius, high) if 1 - paper.mean() < target.mean() else (low, radius)
    return paper


def _discs(centres, radius, height, width):
    paper = numpy.ones((height, width), dtype=bool)
    for x, y in centres:
        left, top = max(0, int(x - radius)), max(0, int(y - radius))
        rows = numpy.arange(top, min(height, int(y + radius) + 2)) + 0.5 - y
        columns = numpy.arange(left, min(width, int(x + radius) + 2)) + 0.5 - x
        part = paper[top:top + len(rows), left:left + len(columns)]
        part &= rows[:, None] ** 2 + columns ** 2 > radius ** 2
    return paper


def error(points, target):
    """Returns the root mean square difference between points and target. Each point has an equal share of the ink.

    Both are blurred by two mean spacings of the points. points: in pixels of the target [height, width], y down.
    """
    spacing = (target.size / len(points)) ** 0.5
    fine = math.ceil(4 / spacing)  # cells per pixel, so that a cell is at most a quarter of a spacing
    wanted = numpy.kron(target, numpy.ones((fine, fine)))
    given = _spread(points * fine, wanted.shape) * (wanted.sum() / len(points))
    return float(numpy.sqrt((blur(given - wanted, 2 * spacing * fine) ** 2).mean()))


def _spread(points, shape):
    """Distributes each point bilinearly among the four nearest cells."""
    cells = numpy.zeros(shape)
    first = numpy.floor(points - 0.5).astype(int)
    part = points - 0.5 - first
    for right in (0, 1):
        for down in (0, 1):
            column = numpy.clip(first[:, 0] + right, 0, shape[1] - 1)
            row = numpy.clip(first[:, 1] + down, 0, shape[0] - 1)
            numpy.add.at(cells, (row, column), abs(1 - right - part[:, 0]) * abs(1 - down - part[:, 1]))
    return cells


def blur(picture, sigma):
    """Blurs a picture by a Gaussian, mirrored at the sides."""
    for axis in (0, 1):
        mirrored = numpy.concatenate([picture, numpy.flip(picture, axis)], axis)
        frequency = numpy.fft.rfftfreq(mirrored.shape[axis])
        factor = numpy.exp(-2 * (numpy.pi * sigma * frequency) ** 2)
        waves = numpy.fft.rfft(mirrored, axis=axis) * (factor[:, None] if axis == 0 else factor)
        picture = numpy.take(numpy.fft.irfft(waves, mirrored.shape[axis], axis), range(picture.shape[axis]), axis)
    return picture
