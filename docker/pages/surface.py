#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws answers of /sample for a mesh side by side: points as discs on the shaded mesh or, if an answer contains a
triangulation, on the triangulation with its edges: surface.py FILE.obj ANSWER.json... -o PICTURE
"""

import argparse
import json
import pathlib

import numpy
from PIL import Image

SIDE = 480  # pixels of the picture of an answer
FINER = 2  # the picture is first drawn this many times as large
TURN = 145  # degrees; rotation around the vertical axis
MARGIN = 0.04  # share of the picture on each side
DISC = 0.3  # radius of a disc, in mean distances of points; with edges, it is half as large
EDGE = 1.1  # pixels; half the width of an edge
LIGHT = numpy.array([0.35, 0.45, 0.82])
SURFACE, INK, LATER, LINE = (numpy.array(tuple(bytes.fromhex(colour))) / 255
                             for colour in ("c6d0dc", "191919", "f4f6f8", "1f5fa8"))


def read_obj(path):
    """Returns the vertices and the triangles of an OBJ file."""
    vertices, triangles = [], []
    for line in path.read_text().splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            vertices.append([float(word) for word in words[:3]])
        elif kind == "f":
            corners = [int(word.split("/")[0]) - 1 for word in words]
            triangles += [(corners[0], *corners[i:i + 2]) for i in range(1, len(corners) - 1)]
    return numpy.array(vertices), numpy.array(triangles)


def rotation(degrees):
    """Returns the matrix of a rotation around the vertical axis, and then slightly towards the viewer."""
    a, b = numpy.radians(degrees), numpy.radians(18)
    around = numpy.array([[numpy.cos(a), 0, numpy.sin(a)], [0, 1, 0], [-numpy.sin(a), 0, numpy.cos(a)]])
    down = numpy.array([[1, 0, 0], [0, numpy.cos(b), -numpy.sin(b)], [0, numpy.sin(b), numpy.cos(b)]])
    return down @ around


class Canvas:
    """A picture with the depth of each pixel; x points right, y down, z to the viewer. The unit is a pixel."""

    def __init__(self, side):
        self.colours = numpy.ones((side, side, 3))
        self.depths = numpy.full((side, side), -numpy.inf)

    def box(self, low, high):
        """Returns the part of the picture in a bounding box, and the positions of its pixels."""
        top, left = (int(max(numpy.floor(low[axis]), 0)) for axis in (1, 0))
        part = (slice(top, int(high[1]) + 2), slice(left, int(high[0]) + 2))
        rows, columns = self.depths[part].shape
        x, y = numpy.meshgrid(left + 0.5 + numpy.arange(columns), top + 0.5 + numpy.arange(rows))
        return part, x, y

    def paint(self, part, covered, depth, colour):
        """Paints the covered pixels of a part, except where something nearer is already painted."""
        nearer = covered & (depth > self.depths[part])
        self.depths[part][nearer] = depth[nearer]
        self.colours[part][nearer] = colour[nearer] if colour.ndim > 1 else colour

    def triangle(self, corners, normals, has_edges):
        (ax, ay, _), (bx, by, _), (cx, cy, _) = corners
        twice = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if twice == 0:
            return
        part, x, y = self.box(corners.min(axis=0), corners.max(axis=0))
        v = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / twice
        w = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / twice
        weights = numpy.stack([1 - v - w, v, w], axis=-1)
        normal = weights @ normals
        normal /= numpy.linalg.norm(normal, axis=-1, keepdims=True) + 1e-12
        shade = 0.5 + 0.5 * numpy.maximum(normal @ LIGHT, 0)
        colour = shade[..., None] * SURFACE
        if has_edges:
            lengths = numpy.hypot(*(numpy.roll(corners, -1, axis=0) - numpy.roll(corners, 1, axis=0))[:, :2].T)
            colour[(weights * abs(twice) / lengths).min(axis=-1) < EDGE] = LINE
        self.paint(part, weights.min(axis=-1) >= 0, weights @ corners[:, 2], colour)

    def disc(self, centre, normal, radius, colour):
        """Paints a disc perpendicular to a normal. It is moved slightly towards the viewer, so that the surface does not
        hide it.
        """
        if normal[2] < 0.05:
            return
        part, x, y = self.box(centre - radius, centre + radius)
        dx, dy = x - centre[0], y - centre[1]
        dz = -(dx * normal[0] + dy * normal[1]) / normal[2]
        self.paint(part, dx ** 2 + dy ** 2 + dz ** 2 < radius ** 2, centre[2] + dz + 0.5 * radius * normal[2], colour)


def draw(answer, mesh, first=None):
    """Returns a picture of an answer of `/sample`.

    `mesh` is (vertices, triangles). If `first` is given, the points whose rank is less are black, and the others are
    white. Otherwise, all points are black.
    """
    has_edges = "mesh" in answer
    if has_edges:
        mesh = (numpy.array(answer["mesh"][name]) for name in ("vertices", "triangles"))
    vertices, triangles = mesh
    turn = rotation(TURN)
    places = turn @ vertices.T
    low, high = places.min(axis=1), places.max(axis=1)
    side = FINER * SIDE
    scale = side * (1 - 2 * MARGIN) / max(high - low)
    mirror = numpy.array([1, -1, 1])  # rows are numbered from the top
    middle = numpy.array([side / 2, side / 2, 0])

    def on_screen(positions):
        return (numpy.array(positions) @ turn.T - (low + high) / 2) * scale * mirror + middle

    corners = on_screen(vertices)[triangles]
    crosses = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) * -mirror
    sums = numpy.zeros_like(vertices)
    for corner in range(3):
        numpy.add.at(sums, triangles[:, corner], crosses)
    sums /= numpy.linalg.norm(sums, axis=1, keepdims=True) + 1e-12
    canvas = Canvas(side)
    for triangle, places in zip(triangles, corners):
        canvas.triangle(places, sums[triangle], has_edges)
    pitch = numpy.sqrt(numpy.linalg.norm(crosses, axis=1).sum() / 2 / len(answer["points"]))
    radius = DISC * (0.5 if has_edges else 1) * pitch
    ranks = answer.get("rank") or range(len(answer["points"]))
    normals = numpy.array(answer["normals"]) @ turn.T * mirror
    for rank, place, normal in zip(ranks, on_screen(answer["points"]), normals):
        is_first = first is None or rank < first
        canvas.disc(place, normal, radius, INK if is_first else LATER)
    image = Image.fromarray((255 * canvas.colours).round().astype(numpy.uint8))
    return image.resize((SIDE, SIDE), Image.Resampling.BOX)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("mesh", type=pathlib.Path)
    parser.add_argument("answers", type=pathlib.Path, nargs="+")
    parser.add_argument("-o", dest="out", type=pathlib.Path, required=True)
    given = parser.parse_args()
    mesh = read_obj(given.mesh)
    parts = [numpy.asarray(draw(json.loads(path.read_text()), mesh)) for path in given.answers]
    Image.fromarray(numpy.concatenate(parts, axis=1)).save(given.out, quality=80)


if __name__ == "__main__":
    main()
