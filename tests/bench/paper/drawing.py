# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws charts, dots and triangles as SVG, with no more digits than are visible."""

import math
from dataclasses import dataclass
from typing import Sequence
from xml.sax.saxutils import escape

import numpy

BLACK = "#000000"
GREY = "#999999"

# Coordinates of dots and triangles are rounded to a fifth of a pixel.
GRAIN = 5


@dataclass(frozen=True)
class Box:
    left: float
    top: float
    width: float
    height: float

    def fit(self, points):
        """Maps points with y up to the box with y down, centred and as large as possible."""
        points = numpy.asarray(points)
        low, high = points.min(axis=0), points.max(axis=0)
        scale = min(self.width / (high - low)[0], self.height / (high - low)[1])
        middle = numpy.array([self.left + 0.5 * self.width, self.top + 0.5 * self.height])
        return middle + (points - 0.5 * (low + high)) * (scale, -scale)


@dataclass(frozen=True)
class Axis:
    """An axis from the first tick to the last."""
    label: str
    ticks: Sequence[float]
    log: bool = False

    def share(self, value):
        """Returns the position of a value: 0 at the first tick, 1 at the last."""
        first, last, at = (math.log(v) if self.log else v for v in (self.ticks[0], self.ticks[-1], value))
        return (at - first) / (last - first)


@dataclass(frozen=True)
class Curve:
    name: str
    x: Sequence[float]
    y: Sequence[float]
    colour: str = BLACK
    dashed: bool = False
    marks: bool = False


def steps(low, high):
    """Returns about five ticks at round numbers that enclose a range."""
    rough = (high - low) / 5
    power = 10 ** math.floor(math.log10(rough))
    step = next(power * factor for factor in (1, 2, 5, 10) if power * factor >= rough)
    return [step * i for i in range(math.floor(low / step), math.ceil(high / step) + 1)]


def decades(low, high):
    """Returns ticks at powers of ten that enclose a range."""
    return [10.0 ** i for i in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)]


class Svg:
    """Builds a drawing. Lengths are in pixels, and y points down."""

    def __init__(self, width, height):
        self.parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
                      f'height="{height}" font-family="sans-serif" font-size="12">',
                      f'<rect width="{width}" height="{height}" fill="#ffffff"/>']

    def save(self, path):
        path.write_text("\n".join([*self.parts, "</svg>", ""]))

    def text(self, x, y, words, anchor="start", style=""):
        self.parts.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" {style}>{escape(words)}</text>')

    def line(self, x1, y1, x2, y2, colour=BLACK, style=""):
        self.parts.append(f'<path d="M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}" stroke="{colour}" {style}/>')

    def frame(self, box):
        self.rectangle(box, f'fill="none" stroke="{BLACK}"')

    def rectangle(self, box, style):
        self.parts.append(f'<rect x="{box.left:.1f}" y="{box.top:.1f}" width="{box.width:.1f}" '
                          f'height="{box.height:.1f}" {style}/>')

    def dots(self, points, radius):
        grid = _on_grid(points)
        self._fine("".join(f"M{x} {y}h0" for x, y in grid),
                   f'stroke="{BLACK}" stroke-linecap="round" stroke-width="{2 * radius * GRAIN:.1f}"')

    def triangles(self, corners, colour):
        """Draws filled triangles. corners: [triangles, 3, 2]"""
        paths = []
        for (ax, ay), (bx, by), (cx, cy) in _on_grid(corners):
            paths.append(f"M{ax} {ay}l{bx - ax} {by - ay} {cx - bx} {cy - by}z")
        self._fine("".join(paths), f'fill="{colour}" stroke="#ffffff" stroke-width="{0.5 * GRAIN}"')

    def _fine(self, path, style):
        self.parts.append(f'<path transform="scale({1 / GRAIN:g})" d="{path}" {style}/>')

    def chart(self, box, title, x_axis, y_axis, curves):
        self.text(box.left + 0.5 * box.width, box.top - 10, title, "middle", 'font-weight="bold"')
        for tick in x_axis.ticks:
            x = box.left + x_axis.share(tick) * box.width
            self.line(x, box.top + box.height, x, box.top + box.height + 4)
            self.text(x, box.top + box.height + 17, f"{tick:,g}", "middle")
        for tick in y_axis.ticks:
            y = box.top + (1 - y_axis.share(tick)) * box.height
            self.line(box.left, y, box.left + box.width, y, GREY, 'stroke-width="0.3"')
            self.text(box.left - 5, y + 4, f"{tick:,g}", "end")
        self.text(box.left + 0.5 * box.width, box.top + box.height + 34, x_axis.label, "middle")
        self.text(box.left, box.top - 10, y_axis.label, "end")
        for curve in curves:
            self._curve(box, x_axis, y_axis, curve)
        self.frame(box)

    def _curve(self, box, x_axis, y_axis, curve):
        points = [(box.left + x_axis.share(x) * box.width, box.top + (1 - y_axis.share(y)) * box.height)
                  for x, y in zip(curve.x, curve.y)]
        path = "L".join(f"{x:.1f} {y:.1f}" for x, y in points)
        dashes = 'stroke-dasharray="4 3"' if curve.dashed else ""
        self.parts.append(f'<path d="M{path}" fill="none" stroke="{curve.colour}" stroke-width="1.5" {dashes}/>')
        if curve.marks:
            self.parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{curve.colour}"/>' for x, y in points]

    def legend(self, x, y, curves):
        for row, curve in enumerate(curves):
            at = y + 18 * row
            self.line(x, at, x + 24, at, curve.colour,
                      'stroke-width="2" ' + ('stroke-dasharray="4 3"' if curve.dashed else ""))
            self.text(x + 30, at + 4, curve.name)


def _on_grid(points):
    return numpy.rint(numpy.asarray(points) * GRAIN).astype(int).tolist()
