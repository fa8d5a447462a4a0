# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws answers of /sample for unit boxes in space: points as balls that fade with distance."""

import itertools

import numpy
from PIL import Image

import surface

WIDTH = 1.42  # of the turned cube
BALL = 0.26  # radius of a ball, in mean distances of points
INK = numpy.array(tuple(bytes.fromhex("1f5fa8"))) / 255
EDGE, EDGE_RADIUS = numpy.array((0.55, 0.58, 0.62)), 2.2  # colour and half the width of an edge, in pixels


def ball(canvas, centre, radius, colour):
    part, x, y = canvas.box(centre - radius, centre + radius)
    dx, dy = x - centre[0], y - centre[1]
    dz = numpy.sqrt(numpy.maximum(radius ** 2 - dx ** 2 - dy ** 2, 0))
    shade = 0.5 + 0.5 * numpy.maximum(numpy.stack([dx, -dy, dz], axis=-1) @ surface.LIGHT / radius, 0)
    canvas.paint(part, dz > 0, centre[2] + dz, shade[..., None] * colour)


def draw(answer):
    """Returns a picture of points in the unit cube, with the edges of the cube."""
    turn = surface.rotation(35)
    side = surface.FINER * surface.SIDE
    scale = side * (1 - 2 * surface.MARGIN) / WIDTH

    def on_screen(positions):
        upright = (numpy.array(positions, dtype=float) - 0.5)[:, (0, 2, 1)] * (1, 1, -1)  # the z axis points up
        return upright @ turn.T * scale * (1, -1, 1) + (side / 2, side / 2, 0)

    canvas = surface.Canvas(side)
    for axis, ends in itertools.product(range(3), itertools.product((0, 1), repeat=2)):
        for place in on_screen([numpy.insert(numpy.array(ends, dtype=float), axis, at) for at in numpy.linspace(0, 1, side)]):
            ball(canvas, place, EDGE_RADIUS, EDGE)
    radius = BALL * scale / len(answer["points"]) ** (1 / 3)
    for place in on_screen(answer["points"]):
        fading = 0.75 * (0.5 - place[2] / scale / numpy.sqrt(3))
        ball(canvas, place, radius, INK + fading * (1 - INK))
    image = Image.fromarray((255 * canvas.colours).round().astype(numpy.uint8))
    return image.resize((surface.SIDE, surface.SIDE), Image.Resampling.BOX)
