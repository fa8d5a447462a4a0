# SPDX-License-Identifier: GPL-3.0-or-later
"""Models the appearance of pictures from a distance: blurred light, CIE colours and their differences."""

import numpy
from PIL import Image

from harness import linear, pixels

LIGHT = numpy.vectorize(linear)(numpy.arange(256))
CHANNELS = numpy.array([0.2126, 0.7152, 0.0722])
TO_XYZ = numpy.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def lightness(light):
    """Returns CIE L*, 0 to 100."""
    light = numpy.clip(light, 0, 1)
    return numpy.where(light > 216 / 24389, 116 * numpy.cbrt(light) - 16, light * 24389 / 27)


def blurred(plane, sigma):
    """Blurs by a Gaussian, mirrored at the sides."""
    for axis in (0, 1):
        plane = numpy.moveaxis(plane, axis, -1)
        side = plane.shape[-1]
        wave = numpy.fft.rfftfreq(2 * side)
        both = numpy.concatenate([plane, plane[..., ::-1]], -1)
        spectrum = numpy.fft.rfft(both, axis=-1) * numpy.exp(-2 * (numpy.pi * sigma * wave) ** 2)
        plane = numpy.moveaxis(numpy.fft.irfft(spectrum, 2 * side, axis=-1)[..., :side], -1, axis)
    return plane


def seen_light(picture, sigma):
    """Returns the blurred red, green and blue light of a picture."""
    return numpy.stack([blurred(picture[..., channel], sigma) for channel in range(3)], -1)


def lab(light):
    """Returns CIE L*, a*, b* of linear light with the primaries of sRGB."""
    x, y, z = numpy.moveaxis(lightness(light @ (TO_XYZ / TO_XYZ.sum(1, keepdims=True)).T), -1, 0)
    return numpy.stack([y, 500 / 116 * (x - y), 200 / 116 * (y - z)], -1)


def ciede2000(one, other):
    """Returns the CIEDE2000 difference of colours in L*, a*, b*. Source: Sharma, Wu, Dalal 2005."""
    chroma = (numpy.hypot(one[..., 1], one[..., 2]) + numpy.hypot(other[..., 1], other[..., 2])) / 2
    stretch = 1.5 - 0.5 * numpy.sqrt(chroma ** 7 / (chroma ** 7 + 25.0 ** 7))
    c1, c2 = (numpy.hypot(stretch * colour[..., 1], colour[..., 2]) for colour in (one, other))
    h1, h2 = (numpy.arctan2(colour[..., 2], stretch * colour[..., 1]) for colour in (one, other))
    turn = (h2 - h1 + numpy.pi) % (2 * numpy.pi) - numpy.pi
    hue = h1 + turn / 2
    level, chroma = (one[..., 0] + other[..., 0]) / 2, (c1 + c2) / 2
    t = (1 - 0.17 * numpy.cos(hue - numpy.radians(30)) + 0.24 * numpy.cos(2 * hue)
         + 0.32 * numpy.cos(3 * hue + numpy.radians(6)) - 0.2 * numpy.cos(4 * hue - numpy.radians(63)))
    lightness_part = (other[..., 0] - one[..., 0]) / (1 + 0.015 * (level - 50) ** 2 / numpy.sqrt(20 + (level - 50) ** 2))
    chroma_part = (c2 - c1) / (1 + 0.045 * chroma)
    hue_part = 2 * numpy.sqrt(c1 * c2) * numpy.sin(turn / 2) / (1 + 0.015 * chroma * t)
    off_blue = ((numpy.degrees(hue) % 360 - 275) / 25) ** 2
    twist = numpy.sin(numpy.radians(60 * numpy.exp(-off_blue))) * 2 * numpy.sqrt(chroma ** 7 / (chroma ** 7 + 25.0 ** 7))
    return numpy.sqrt(lightness_part ** 2 + chroma_part ** 2 + hue_part ** 2 - twist * chroma_part * hue_part)


def luminance(file):
    """Returns the luminance of each pixel; transparent ones show white."""
    rgba = pixels(file, "RGBA")
    alpha = rgba[..., 3] / 255
    return LIGHT[rgba[..., :3]] @ CHANNELS * alpha + 1 - alpha


def enlarged(plane, shape):
    """Enlarges or reduces a plane of light to another shape."""
    return numpy.asarray(Image.fromarray(plane.astype(numpy.float32)).resize(shape[::-1], Image.Resampling.BOX))


def tone_errors(wanted, seen, dots):
    """Returns the mean error of L* after a blur by two pitches, where the picture is dark, and the largest error of a
    level.
    """
    sigma = 2 * (seen.size / dots) ** 0.5
    wanted = enlarged(wanted, seen.shape)
    level = lightness(blurred(wanted, sigma))
    error = lightness(blurred(seen, sigma)) - level
    dark = level < 20
    parts = [(level >= low) & (level < low + 5) for low in range(0, 100, 5)]
    worst = max(abs(error[part].mean()) for part in parts if part.mean() >= 0.005)
    return error[dark].mean() if dark.mean() > 0.005 else 0, worst
