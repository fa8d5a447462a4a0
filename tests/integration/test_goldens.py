"""Answers are those that they were: a digest of each is kept beside this file, over all routes, formats, inks, methods
and qualities. A change that means to move dots renews the table, and says why it does:

    CCDT_SERVER=build/test/ccdt-server python3 tests/integration/test_goldens.py --renew

Digests hold for x86-64 and Debian 12's libraries: another compiler may round differently, another zlib pack otherwise.
"""

import hashlib
import itertools
import json
import pathlib
import platform
import re
import sys
import unittest

import numpy

from harness import PICTURES, Server, ask, data_uri, file_of, flat, polygon, post_json

TABLE = pathlib.Path(__file__).with_name("goldens.txt")

CAMERA = (PICTURES / "camera.png").read_bytes()
ASTRONAUT = (PICTURES / "astronaut.png").read_bytes()
WEDGE = file_of(numpy.repeat(numpy.arange(256, dtype=numpy.uint8)[None, ::2], 24, axis=0))
TORUS = {"type": "torus", "width": 1, "height": 1}
RECTANGLE = {"type": "rectangle", "width": 3, "height": 2}
GRID = {"width": 3, "height": 2, "values": [1, 2, 0.5, 0, 3, 1]}
TRIANGLE = [[0, 0], [4, 0], [1, 3]]

HALFTONE_FORMATS = ("png", "json", "svg", "csv", "npy", "webp", "tiff")
SAMPLE_FORMATS = ("json", "csv", "geojson", "npy", "svg", "png")
ANALYZE_FORMATS = ("json", "png", "svg")
QUALITIES = ("draft", "standard", "best")
METHODS = ("ccdt", "cvt", "odt", "ccvt", "random")
INKS = ("color=gray", "color=cmyk", "color=rgb", "palette=%23e02020,%232040c0", "palette=%23804000")


def halftones():
    """Queries, each with a picture."""
    for inks, form in itertools.product(INKS, HALFTONE_FORMATS):
        yield f"sites=700&{inks}&format={form}", ASTRONAUT
    for inks, quality in itertools.product(INKS, QUALITIES):
        yield f"sites=900&seed=3&{inks}&quality={quality}", ASTRONAUT
    for inks, form in itertools.product(INKS[:2], ("png", "webp", "tiff")):
        yield f"sites=500&{inks}&antialias=true&scale=1.5&format={form}", ASTRONAUT
    for options in ("", "tone=perceptual", "invert=true", "invert=true&antialias=true", "dot=2.5", "scale=0.5",
                    "scale=3&dot=1", "foreground=%23204060&background=%23ffeecc", "background=transparent",
                    "background=transparent&antialias=true&format=webp", "iterations=0", "iterations=2&passes=3",
                    "format=svg&width_mm=200&style=stroke", "format=svg&width_mm=100", "format=json&width_mm=100"):
        yield f"sites=1500&{options}", CAMERA
    for options in ("background=transparent", "background=%23ffeecc", "tone=perceptual", "dot=2", "scale=0.7",
                    "format=svg&style=stroke&width_mm=150", "iterations=0", "antialias=true&background=transparent"):
        yield f"sites=1500&color=cmyk&{options}", ASTRONAUT
    for inks, picture in itertools.product(INKS, (WEDGE, file_of(flat(90, 1, 1)), file_of(flat(0, 40, 3)))):
        yield f"sites=60&{inks}&format=json", picture
    yield "", CAMERA
    yield "color=cmyk", CAMERA
    yield "sites=20000&quality=best", CAMERA


def samples():
    domains = {"torus": {"domain": TORUS}, "rectangle": {"domain": RECTANGLE}, "triangle": {"polygon": TRIANGLE},
               "Switzerland": {"geometry": polygon("Switzerland-10m.geojson")},
               "South-Africa": {"geometry": polygon("South-Africa-50m.geojson")}}
    densities = {"uniform": {}, "grid": {"density": GRID}, "image": {"density": {"image": data_uri(WEDGE)}}}
    for (place, domain), (kind, density), method in itertools.product(domains.items(), densities.items(), METHODS):
        if method != "ccvt" or place in ("torus", "triangle"):
            yield f"{place} {kind} {method}", {"sites": 400, "method": method, **domain, **density}
    for (place, domain), quality in itertools.product(domains.items(), QUALITIES):
        yield f"{place} {quality} mesh", {"sites": 600, "seed": 7, "quality": quality, "mesh": True, **domain}
    for (place, domain), form in itertools.product(domains.items(), SAMPLE_FORMATS):
        yield f"{place} {form}", {"sites": 300, "format": form, **domain}
    for sites in (1, 2, 3, 10_000):
        yield f"torus {sites}", {"sites": sites, "domain": TORUS}
        yield f"triangle {sites}", {"sites": sites, "polygon": TRIANGLE}
    for form, method in itertools.product(("json", "png"), METHODS):
        yield f"iterations {form} {method}", {"sites": 90, "format": form, "method": method, "iterations": 2,
                                         "domain": RECTANGLE}
    yield "drawing", {"sites": 200, "format": "png", "width": 333, "dot": 0.02, "domain": RECTANGLE}
    yield "plot", {"sites": 200, "format": "svg", "width_mm": 90, "style": "stroke", "domain": RECTANGLE}
    yield "tolerance", {"sites": 500, "tolerance": 0.2, "domain": RECTANGLE}


def analyses():
    points = [[(37 * i % 101) / 101, (53 * i % 97) / 97] for i in range(150)]
    for form in ANALYZE_FORMATS:
        yield f"{form}", {"points": points, "format": form}
        yield f"{form} rectangle", {"sets": [points, points[::-1]], "domain": {"type": "rectangle", "width": 1,
                                                                               "height": 1}, "format": form}
    yield "spectrum", {"points": points, "spectrum": True, "max_frequency": 2}


def everything(server):
    """Names and answers."""
    for i, (query, picture) in enumerate(halftones()):
        yield f"halftone {i} {query}", ask(server, "/halftone?" + query, data=picture)
    for name, body in samples():
        yield "sample " + name, post_json(server, "/sample", body)
    for name, body in analyses():
        yield "analyze " + name, post_json(server, "/analyze", body)
    yield "json body", post_json(server, "/halftone", {"image": data_uri(CAMERA), "sites": 300})


def digest(answer):
    """Of all but the members that tell how long it took, and which request it was."""
    body = re.sub(rb'"(elapsed_ms|instance)":[^,}]*', b"", answer.body)
    return hashlib.sha256(json.dumps([answer.status, answer.type]).encode() + body).hexdigest()[:24]


def table():
    with Server() as server:
        return {name: digest(answer) for name, answer in everything(server)}


@unittest.skipUnless(platform.machine() == "x86_64", "digests are those of x86-64")
class Goldens(unittest.TestCase):
    maxDiff = None

    def test_answers_are_those_they_were(self):
        known = dict(reversed(line.split(" ", 1)) for line in TABLE.read_text().splitlines())
        self.assertEqual(table(), known)


if __name__ == "__main__":
    if "--renew" in sys.argv:
        TABLE.write_text("".join(f"{value} {name}\n" for name, value in table().items()))
    else:
        unittest.main(verbosity=2)
