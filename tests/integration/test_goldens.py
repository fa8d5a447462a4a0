# SPDX-License-Identifier: GPL-3.0-or-later
"""Detects changed answers. goldens.txt has a digest of each answer, for all routes, formats, inks, methods and
qualities.

A change that moves dots on purpose must renew the table, and its commit must give the reason:

    CCDT_SERVER=build/test/ccdt-server python3 tests/integration/test_goldens.py --renew

The digests are valid for x86-64 and the libraries of Debian 12: another standard library may sort differently, and
another zlib may compress differently.
"""

import hashlib
import itertools
import json
import pathlib
import platform
import re
import sys
import unittest
from functools import partial

import numpy

from harness import PICTURES, Server, ask, data_uri, file_of, flat, polygon, post_json

TABLE = pathlib.Path(__file__).with_name("goldens.txt")

PHOTOS = {
    "camera": (PICTURES / "camera.png").read_bytes(),
    "astronaut": (PICTURES / "astronaut.png").read_bytes(),
    "wedge": file_of(numpy.repeat(numpy.arange(256, dtype=numpy.uint8)[None, ::2], 24, axis=0)),
    "pixel": file_of(flat(90, 1, 1)),
    "black": file_of(flat(0, 40, 3)),
}
TORUS = {"type": "torus", "width": 1, "height": 1}
RECTANGLE = {"type": "rectangle", "width": 3, "height": 2}
SPACE = {"type": "box", "width": 3, "height": 2, "depth": 1}
GRID = {"width": 3, "height": 2, "values": [1, 2, 0.5, 0, 3, 1]}
TRIANGLE = [[0, 0], [4, 0], [1, 3]]

LAKE = [[[11, 43], [12.5, 43.2], [12.3, 44], [11.2, 44.1]]]
FIXED = [[0.5, 0.5], [0.5, 0.5], [0.51, 0.5], [0.9, 0.3], [8, 47]]



def land(ring, **properties):
    return {"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": [ring]}}


LANDS = {"type": "FeatureCollection", "features": [
    land([[0, 40], [2, 40], [2, 42], [0, 42], [0, 40]], people=120, cattle=60),
    land([[2, 40], [5, 40], [5, 42], [2, 42], [2, 40]], people=80, cattle=140),
    land([[0, 42], [5, 42], [3, 45], [0, 42]], people=40, cattle=0)]}

QUALITIES = ("draft", "standard", "best")
INKS = ("color=gray", "dots=ink", "color=cmyk", "color=rgb", "color=cmyk&dots=ink", "color=cmyk&dots=both",
        "palette=%23e02020,%232040c0", "palette=%23804000")


def names(rows):
    return [row["name"] for row in rows if not row.get("needs")]


def halftones(formats):
    """Returns queries, each with the name of a picture."""
    for inks, form in itertools.product(INKS, formats):
        yield f"sites=700&{inks}&format={form}", "astronaut"
    for inks, quality in itertools.product(INKS, QUALITIES):
        yield f"sites=900&seed=3&{inks}&quality={quality}", "astronaut"
    for inks, form in itertools.product(INKS[:3], ("png", "webp", "jpeg", "tiff")):
        yield f"sites=500&{inks}&antialias=true&scale=1.5&format={form}", "astronaut"
    for options in ("", "tone=perceptual", "dot=2.5", "scale=0.5", "scale=3&dot=1", "levels=0.1,0.9,1.2", "detail=0",
                    "foreground=%23204060&background=%23ffeecc", "background=transparent",
                    "background=transparent&antialias=true&format=webp", "iterations=0", "iterations=2&passes=3",
                    "format=svg&width_mm=100"):
        yield f"sites=1500&{options}", "camera"
        yield f"sites=1500&dots=ink&{options}", "camera"
    for options in ("invert=true", "invert=true&antialias=true", "tone=density", "format=svg&width_mm=200&style=stroke",
                    "format=svg&paper=a4&marks=true", "format=svg&paper=a4&split=ink&color=cmyk", "format=gcode&width_mm=90&machine=laser&style=spiral",
                    "format=json&width_mm=100"):
        yield f"sites=1500&{options}", "camera"
    for form in ("pdf", "eps", "hpgl", "gcode", "dxf"):
        yield f"sites=700&color=cmyk&dots=ink&width_mm=100&format={form}", "astronaut"
    for form in ("json", "csv", "npy", "svg"):
        yield f"sites=700&seed=2&dots=both&format={form}", "astronaut"
    for options in ("background=transparent", "background=%23ffeecc", "tone=perceptual", "dot=2", "scale=0.7",
                    "levels=0.2,0.8",
                    "format=svg&style=stroke&width_mm=150", "iterations=0", "antialias=true&background=transparent"):
        yield f"sites=1500&color=cmyk&{options}", "astronaut"
    for inks, picture in itertools.product((*INKS, "dots=both"), ("wedge", "pixel", "black")):
        yield f"sites=60&{inks}&format=json", picture
    for device, form in itertools.product(("1bit", "gray4", "bwr", "spectra6"), ("png", "bmp", "raw")):
        yield f"device={device}&width=120&height=80&format={form}", "astronaut"
    for options in ("format=escpos", "fit=cover", "rotate=90&background=%23f00", "levels=0.1,0.9,1.2", "spot=1.5"):
        yield f"device=1bit&width=120&height=80&{options}", "camera"
    yield "", "camera"
    yield "dots=ink", "camera"
    yield "color=cmyk", "camera"
    yield "sites=20000&quality=best", "camera"
    yield "sites=20000&dots=ink&quality=best", "camera"


def samples(formats, methods):
    domains = {"torus": {"domain": TORUS}, "rectangle": {"domain": RECTANGLE}, "triangle": {"polygon": TRIANGLE},
               "Switzerland": {"geometry": polygon("Switzerland-10m.geojson")},
               "South-Africa": {"geometry": polygon("South-Africa-50m.geojson")}}
    densities = {"uniform": {}, "grid": {"density": GRID}, "image": {"density": {"image": data_uri(PHOTOS["wedge"])}}}
    for (place, domain), (kind, density), method in itertools.product(domains.items(), densities.items(), methods):
        if method != "ccvt" or place in ("torus", "triangle"):
            yield f"{place} {kind} {method}", {"sites": 400, "method": method, **domain, **density}
    for (place, domain), quality in itertools.product(domains.items(), QUALITIES):
        yield f"{place} {quality} mesh", {"sites": 600, "seed": 7, "quality": quality, "mesh": True, **domain}
    for (place, domain), form in itertools.product(domains.items(), formats):
        yield f"{place} {form}", {"sites": 300, "format": form, **domain}
    for sites in (1, 2, 3, 10_000):
        yield f"torus {sites}", {"sites": sites, "domain": TORUS}
        yield f"triangle {sites}", {"sites": sites, "polygon": TRIANGLE}
    for form, method in itertools.product(("json", "png"), methods):
        yield f"iterations {form} {method}", {"sites": 90, "format": form, "method": method, "iterations": 2,
                                         "domain": RECTANGLE}
    for place, order in itertools.product(domains, ("none", "path", "progressive")):
        yield f"{place} {order}", {"sites": 300, "order": order, "format": "csv", **domains[place]}
    tile = {"type": "torus", "width": 48, "height": 32}
    for form in ("mask", "mask16", "masknpy"):
        yield "tile " + form, {"format": form, "seed": 3, "domain": tile}
        yield f"tile {form} frames", {"format": form, "seed": 3, "domain": {**tile, "depth": 4}}
    for form in ("json", "csv", "png", "npy"):
        yield f"pixels {form}", {"sites": 400, "format": form, "domain": {"type": "pixels", "width": 60, "height": 40}}
    yield "pixels by density", {"sites": 900, "seed": 3, "density": GRID, "calibration": {"width": 8, "height": 8},
                                "include": [{"y": 2, "height": 1}], "format": "png",
                                "domain": {"type": "pixels", "width": 101, "height": 77}}
    yield "order density", {"sites": 500, "order": "progressive", "density": GRID, "domain": RECTANGLE}
    # In parts of hundreds of points.
    yield "order large", {"sites": 9000, "order": "progressive", "format": "csv", "domain": TORUS}
    yield "order lonlat", {"sites": 500, "order": "progressive", "coordinates": "lonlat",
                           "geometry": polygon("Italy-110m.geojson")}
    yield "torus stealthy", {"sites": 500, "quality": "stealthy", "domain": {**TORUS, "width": 3}}
    yield "drawing", {"sites": 200, "format": "png", "width": 333, "dot": 0.02, "domain": RECTANGLE}
    yield "plot", {"sites": 200, "format": "svg", "width_mm": 90, "style": "stroke", "domain": RECTANGLE}
    yield "tolerance", {"sites": 500, "tolerance": 0.2, "domain": RECTANGLE}
    italy = {"sites": 300, "geometry": polygon("Italy-110m.geojson")}
    yield "avoid", {"avoid": LAKE, **italy}
    yield "exclude", {"exclude": {"image": data_uri(PHOTOS["wedge"])}, **italy}
    yield "buffer", {"avoid": LAKE, "buffer": 0.1, **italy}
    yield "tiles", {"sites": 700, "coordinates": "lonlat", "format": "pmtiles", "dots_per_tile": 200, **italy}
    yield "buffer lonlat", {"avoid": LAKE, "buffer": 9000, "coordinates": "lonlat", **italy}
    people = {"geometry": LANDS, "sites": {"property": "people", "per": 0.5}}
    for form in formats:
        yield f"map {form}", {"format": form, **people}
    for quality in QUALITIES:
        yield f"map {quality}", {"quality": quality, **people}
    yield "map classes", {"geometry": LANDS, "classes": ["people", "cattle"], "per": 2, "order": "progressive"}
    herds = {"geometry": LANDS, "classes": ["people", "cattle"], "coordinates": "lonlat"}
    yield "drawing of map svg", {"format": "svg", "order": "progressive", **herds}
    yield "drawing of map plane", {"format": "svg", "outlines": True, "legend": True, **herds, "coordinates": "plane"}
    # The letters of a legend depend on the font of the machine.
    yield "drawing of map png", {"format": "png", "width": 300, "legend": False, **herds}
    yield "drawing of map eps", {"format": "eps", "width_mm": 90, "legend": False, **herds}
    yield "drawing lonlat", {"format": "svg", **italy, "coordinates": "lonlat"}
    yield "map lonlat", {"coordinates": "lonlat", "fixed": FIXED[:2], "buffer": 2000, **people}
    for place, domain in domains.items():
        yield f"{place} fixed", {"sites": 300, "fixed": FIXED, **domain}
    for kind, quality in itertools.product(("box", "torus"), QUALITIES):
        yield f"space {kind} {quality}", {"sites": 300, "quality": quality, "domain": {**SPACE, "type": kind}}
    for form in ("json", "csv", "npy", "ply", "vtu", "msh"):
        yield f"space {form}", {"sites": 200, "format": form, "mesh": True, "order": "progressive", "domain": SPACE,
                                "density": {**GRID, "depth": 1}, "fixed": [[1, 1, 0.5]]}
    yield "space stealthy", {"sites": 300, "quality": "stealthy", "domain": {**SPACE, "type": "torus"}}
    yield "fixed lonlat", {"fixed": LAKE[0], "coordinates": "lonlat", **italy}


def analyses(formats):
    points = [[(37 * i % 101) / 101, (53 * i % 97) / 97] for i in range(150)]
    for form in formats:
        yield f"{form}", {"points": points, "format": form}
        yield f"{form} rectangle", {"sets": [points, points[::-1]], "domain": {"type": "rectangle", "width": 1,
                                                                               "height": 1}, "format": form}
    yield "spectrum", {"points": points, "spectrum": True, "max_frequency": 2}
    yield "columns", {"points": [(i % 9 / 9, (53 * i % 997) / 997) for i in range(400)]}


def choices():
    """Returns bodies in JSON, and queries for a file."""
    plane = [[(37 * i % 1009) / 1009, (53 * i % 997) / 997] for i in range(900)]
    space = [[x, y, (71 * i % 991) / 991] for i, (x, y) in enumerate(plane)]
    ranks = [i % 7 for i in range(900)]
    for form in ("json", "csv", "npy"):
        yield {"candidates": plane, "sites": 90, "format": form, "keep": [5, 6], "order": "progressive"}
    yield {"candidates": plane, "sites": 90, "seed": 4, "density": ranks, "priority": ranks[::-1]}
    yield {"candidates": plane, "sites": {"0": 30, "3": 20}, "classes": ranks}
    yield {"candidates": [[360 * x, 180 * y - 90] for x, y in plane], "sites": 90, "coordinates": "lonlat"}
    for domain in ("surface", "solid"):
        yield {"candidates": space, "sites": 90, "domain": domain, "order": "progressive"}
        yield {"candidates": space, "spacing": 0.2, "domain": domain, "priority": ranks}
    yield "sites=90&classes=rank"
    yield "spacing=900000&keep=odd&format=json"


def everything(server):
    """Yields names and functions that ask for the answers, for all formats and methods of the server."""
    offered = ask(server, "/capabilities").json()
    halftone, sample, analyze = offered["halftone"], offered["sample"], offered["analyze"]
    for query, picture in halftones(names(halftone["formats"])):
        yield f"halftone {picture} {query}", partial(ask, server, "/halftone?" + query, data=PHOTOS[picture])
    for name, body in samples(names(sample["formats"]), names(sample["methods"])):
        yield "sample " + name, partial(post_json, server, "/sample", body)
    for name, body in analyses(names(analyze["formats"])):
        yield "analyze " + name, partial(post_json, server, "/analyze", body)
    table = "lon,lat,rank,odd\n" + "".join(f"{37 * i % 360},{53 * i % 997 / 6 - 80:.3f},{i % 5},{i % 97 == 3:d}\n"
                                            for i in range(900))
    for number, request in enumerate(choices()):
        if isinstance(request, dict):
            yield f"choice {number}", partial(post_json, server, "/sample", request)
        else:
            yield f"choice {number}", partial(ask, server, f"/sample?candidates=body&{request}", data=table.encode())
    for name, options in ("json body", {}), ("json body of ink", {"dots": "ink"}):
        yield name, partial(post_json, server, "/halftone",
                            {"image": data_uri(PHOTOS["camera"]), "sites": 300, **options})


def digest(answer):
    """Returns the digest of an answer without the members that differ between runs: elapsed time and request id."""
    body = re.sub(rb'"(elapsed_ms|instance)":[^,}]*', b"", answer.body)
    return hashlib.sha256(json.dumps([answer.status, answer.type]).encode() + body).hexdigest()[:24]


def table(step=1, **environment):
    """Returns the digests of all answers or, with a larger step, of a part."""
    with Server(environment=environment) as server:
        return {name: digest(answer()) for name, answer in itertools.islice(everything(server), 0, None, step)}


def known():
    return dict(reversed(line.split(" ", 1)) for line in TABLE.read_text().splitlines())


@unittest.skipUnless(platform.machine() == "x86_64", "the digests are for x86-64")
class Goldens(unittest.TestCase):
    maxDiff = None

    def test_answers_are_unchanged(self):
        self.assertEqual(table(), known())

    def test_answers_do_not_depend_on_the_variants_of_the_c_library(self):
        some = table(step=4, GLIBC_TUNABLES="glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4")
        self.assertEqual(some, {name: known()[name] for name in some})


if __name__ == "__main__":
    if "--renew" in sys.argv:
        TABLE.write_text("".join(f"{value} {name}\n" for name, value in table().items()))
    else:
        unittest.main(verbosity=2)
