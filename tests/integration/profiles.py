# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds ICC profiles, and computes the colours that they define (ICC.1:2001-04)."""

import struct

import numpy

D50 = numpy.array([0.9642, 1.0, 0.8249])
D65 = (0.3127, 0.3290)
SRGB = ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06))
DISPLAY_P3 = ((0.680, 0.320), (0.265, 0.690), (0.150, 0.060))
ADOBE_RGB = ((0.64, 0.33), (0.21, 0.71), (0.15, 0.06))
WEIGHTS = numpy.array([0.2126, 0.7152, 0.0722])


def srgb_to_linear(share):
    share = numpy.asarray(share, float)
    return numpy.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(light):
    light = numpy.clip(light, 0, 1)
    return numpy.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)


def _to_xyz(xy):
    x, y = xy
    return numpy.array([x / y, 1, (1 - x - y) / y])


def primaries_to_xyz(primaries, white=D65):
    """Returns the matrix from linear light to XYZ, adapted to D50 (Bradford)."""
    columns = numpy.stack([_to_xyz(xy) for xy in primaries], axis=1)
    matrix = columns * numpy.linalg.solve(columns, _to_xyz(white))
    bradford = numpy.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
    scale = (bradford @ D50) / (bradford @ _to_xyz(white))
    return numpy.linalg.inv(bradford) @ numpy.diag(scale) @ bradford @ matrix


def to_srgb_light(light, primaries):
    """Converts linear light [..., 3] of other primaries to the primaries of sRGB. The result may be out of range."""
    matrix = numpy.linalg.solve(primaries_to_xyz(SRGB), primaries_to_xyz(primaries))
    return numpy.asarray(light) @ matrix.T


def fit(light):
    """Mixes colours outside sRGB with grey of the same luminance until they are inside."""
    grey = numpy.clip(light @ WEIGHTS, 0, 1)
    low, high = light.min(-1), light.max(-1)
    with numpy.errstate(divide="ignore", invalid="ignore"):
        kept = numpy.minimum(numpy.where(low < 0, grey / (grey - low), 1),
                             numpy.where(high > 1, (1 - grey) / (high - grey), 1))
    return numpy.clip(grey[..., None] + kept[..., None] * (light - grey[..., None]), 0, 1)


def _fixed(values):
    return b"".join(struct.pack(">i", round(float(value) * 65536)) for value in values)


def _xyz(values):
    return b"XYZ \0\0\0\0" + _fixed(values)


def _curve(curve):
    """Encodes a curve: an exponent, or a function sampled at 1,024 points as in common sRGB profiles."""
    if callable(curve):
        points = numpy.rint(curve(numpy.linspace(0, 1, 1024)) * 65535).astype(">u2")
        return b"curv\0\0\0\0" + struct.pack(">I", len(points)) + points.tobytes()
    return b"curv\0\0\0\0" + struct.pack(">IH", 1, round(curve * 256))


def _profile(kind, colours, space, tags):
    tags = {b"desc": b"desc\0\0\0\0" + struct.pack(">I", 5) + b"test\0" + bytes(78),
            b"cprt": b"text\0\0\0\0none\0", b"wtpt": _xyz(D50), **tags}
    directory, data = b"", b""
    for name, tag in tags.items():
        directory += name + struct.pack(">II", 128 + 4 + 12 * len(tags) + len(data), len(tag))
        data += tag + bytes(-len(tag) % 4)
    body = struct.pack(">I", len(tags)) + directory + data
    head = struct.pack(">I4sI4s4s4s6H4s4sIIIIII", 128 + len(body), b"test", 0x02400000, kind, colours, space,
                       2026, 1, 1, 0, 0, 0, b"acsp", b"\0" * 4, 0, 0, 0, 0, 0, 0)
    return (head + _fixed(D50)).ljust(128, b"\0") + body


def rgb_profile(primaries, curve):
    xyz = primaries_to_xyz(primaries)
    tags = {name: _xyz(xyz[:, i]) for i, name in enumerate((b"rXYZ", b"gXYZ", b"bXYZ"))}
    return _profile(b"mntr", b"RGB ", b"XYZ ", tags | {name: _curve(curve) for name in (b"rTRC", b"gTRC", b"bTRC")})


def grey_profile(curve):
    return _profile(b"mntr", b"GRAY", b"XYZ ", {b"kTRC": _curve(curve)})


def ink_light(inks):
    """Returns the linear sRGB [..., 3] of inks [..., 4] whose transmittances multiply. Solid black transmits 1 %."""
    inks = numpy.asarray(inks, float)
    cyan, magenta, yellow, black = (inks[..., i:i + 1] for i in range(4))
    light = numpy.ones(inks.shape[:-1] + (3,))
    for ink, colour in ((cyan, (0.05, 0.35, 0.75)), (magenta, (0.55, 0.05, 0.25)), (yellow, (0.9, 0.75, 0.06))):
        light = light * (1 - ink + ink * numpy.array(colour))
    return light * (1 - black + black * 0.01)


def _xyz_to_lab(xyz):
    ratio = xyz / D50
    root = numpy.where(ratio > 216 / 24389, numpy.cbrt(ratio), (24389 / 27 * ratio + 16) / 116)
    return numpy.stack([116 * root[..., 1] - 16, 500 * (root[..., 0] - root[..., 1]),
                        200 * (root[..., 1] - root[..., 2])], axis=-1)


def _table(light_of, channels, points):
    """Encodes a table of 16 bits (lut16Type) to CIELAB."""
    steps = numpy.linspace(0, 1, points)
    light = light_of(numpy.stack(numpy.meshgrid(*[steps] * channels, indexing="ij"), axis=-1))
    lab = _xyz_to_lab(light @ primaries_to_xyz(SRGB).T)
    coded = numpy.stack([lab[..., 0] * 652.8, (lab[..., 1] + 128) * 256, (lab[..., 2] + 128) * 256], axis=-1)
    line = struct.pack(">2H", 0, 65535)
    return (b"mft2\0\0\0\0" + struct.pack(">4B", channels, 3, points, 0) + _fixed([1, 0, 0, 0, 1, 0, 0, 0, 1])
            + struct.pack(">2H", 2, 2) + line * channels
            + numpy.clip(numpy.rint(coded), 0, 65535).astype(">u2").tobytes() + line * 3)


def ink_profile(points=9):
    return _profile(b"prtr", b"CMYK", b"Lab ", {b"A2B0": _table(ink_light, 4, points)})


def table_profile(light_of, points=17):
    """Returns an RGB profile with a table."""
    return _profile(b"scnr", b"RGB ", b"Lab ", {b"A2B0": _table(light_of, 3, points)})
