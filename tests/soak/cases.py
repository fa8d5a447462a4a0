# SPDX-License-Identifier: GPL-3.0-or-later
"""Requests of honest clients, and the reproducible part of their answers."""

import base64
import json
import pathlib
import re
import struct
import typing
import zlib

DATA = pathlib.Path(__file__).resolve().parent.parent / "data"
JSON = {"Content-Type": "application/json"}
TORUS = {"type": "torus", "width": 1, "height": 1}
RECTANGLE = {"type": "rectangle", "width": 2, "height": 1}
LETTER = [[0, 0], [4, 0], [4, 3], [2, 1], [0, 3]]


class Case(typing.NamedTuple):
    name: str
    path: str
    body: bytes
    headers: dict
    status: int = 200


def essence(body):
    """Returns an answer without the members that differ between runs."""
    return re.sub(rb'"(elapsed_ms":[-+.\de]+|instance":"[^"]*")', b'""', body)


def grey_png(width, height, pixels=None):
    """Returns an 8-bit grey PNG. `pixels` contains the rows in order; by default they are ramps."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    if pixels is None:
        pixels = bytes(255 * x // width for x in range(width)) * height
    rows = b"".join(b"\0" + pixels[y * width:(y + 1) * width] for y in range(height))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def sample(name, status=200, **body):
    return Case(name, "/sample", json.dumps(body).encode(), JSON, status)


def halftone(name, query, picture):
    return Case(name, "/halftone?" + query, picture, {"Content-Type": "application/octet-stream"})


def picture(name):
    return (DATA / "images" / name).read_bytes()


def small():
    """Returns requests that take a few milliseconds each, whose latency matters."""
    return [sample("torus-64", sites=64, domain=TORUS), sample("letter-256", sites=256, polygon=LETTER),
            sample("torus-1024", sites=1024, domain=TORUS)]


def swift():
    """Returns requests of every kind that take about a millisecond each. Many can be sent, so that small leaks add up."""
    points = [[i / 64, i * 27 % 64 / 64] for i in range(64)]
    return [sample("torus-64", sites=64, domain=TORUS), sample("letter-100", sites=100, polygon=LETTER),
            sample("draft-300", sites=300, domain=RECTANGLE, quality="draft"),
            halftone("ramp-50", "sites=50&scale=1&iterations=1", grey_png(32, 32)),
            Case("analyze-64", "/analyze", json.dumps({"points": points, "domain": TORUS, "max_frequency": 1}).encode(),
                 JSON),
            sample("start-64", sites=64, domain=TORUS, iterations=0, mesh=True),
            sample("bow-tie", sites=9, polygon=[[0, 0], [1, 1], [1, 0], [0, 1]]),
            sample("flat", 422, sites=9, polygon=[[0, 0], [1, 1], [2, 2]]),
            Case("no-json", "/sample", b'{"sites":', JSON, 400)]


def medium():
    africa = json.loads((DATA / "polygons" / "South-Africa-50m.geojson").read_text())
    waves = {"width": 2, "height": 2, "values": [1, 4, 4, 1]}
    return [sample("torus-4096", sites=4096, domain=TORUS), sample("africa-4096", sites=4096, geometry=africa),
            sample("torus-16384", sites=16_384, domain=TORUS), sample("africa-8192", sites=8192, geometry=africa),
            sample("waves-4096", sites=4096, domain=RECTANGLE, density=waves, mesh=True),
            sample("letter-16384", sites=16_384, polygon=LETTER)]


def pictures():
    inside_json = {"image": base64.b64encode(picture("chelsea.png")).decode(), "sites": 4000, "seed": 7}
    return [halftone("camera", "sites=8000", picture("camera.png")),
            halftone("astronaut-json", "sites=8000&format=json", picture("astronaut.png")),
            halftone("chelsea-soft", "sites=4000&antialias=true&scale=2", picture("chelsea.png")),
            Case("chelsea-in-json", "/halftone", json.dumps(inside_json).encode(), JSON)]


def analyses():
    torus = (DATA / "analysis" / "torus.json").read_bytes()
    rectangle = (DATA / "analysis" / "rectangle.json").read_bytes()
    return [Case("analyze-torus", "/analyze", torus, JSON), Case("analyze-rectangle", "/analyze", rectangle, JSON),
            Case("analyze-plot", "/analyze", torus, {**JSON, "Accept": "image/png"})]


def everything():
    return [*small(), *swift(), *medium(), *pictures(), *analyses(), LARGE, LARGER]


LARGE = sample("large", sites=60_000, iterations=0, domain=RECTANGLE)
LARGER = sample("larger", sites=250_000, iterations=0, domain=RECTANGLE)
ENDLESS = sample("endless", sites=30_000, iterations=1000, domain=RECTANGLE)
