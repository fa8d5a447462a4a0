# SPDX-License-Identifier: GPL-3.0-or-later
"""POST /sample with all polygons of three popular files of maps: npm's world-atlas and us-atlas.

Geometries are quantized TopoJSON: many of their rings touch themselves or a neighbour, some are flat.
"""

import json
import pathlib
import tempfile
import unittest

import numpy
import shapely.geometry
import shapely.ops
import shapely.validation
import shapely.vectorized

from harness import NODE, NODE_MODULES, ServerCase, execute, post_json

FILES = {"world-atlas/countries-10m.json": ("countries", 255), "world-atlas/countries-50m.json": ("countries", 241),
         "us-atlas/counties-10m.json": ("counties", 3231)}

# Quantized to lines: Vatican, and Falls Church in Virginia.
FLAT = {("world-atlas/countries-10m.json", "Vatican"), ("us-atlas/counties-10m.json", "Falls Church")}

SITES = 100

# Prints the features of a TopoJSON file as a JSON array.
FEATURES = """
const [, modules, file, object] = process.argv;
const topology = JSON.parse(require("fs").readFileSync(`${modules}/${file}`));
process.stdout.write(JSON.stringify(
  require(`${modules}/topojson-client`).feature(topology, topology.objects[object]).features));
"""


def features(file, name):
    done = execute([NODE, "--eval", FEATURES, NODE_MODULES, file, name], capture_output=True, check=True)
    return json.loads(done.stdout)


def area_of(ring):
    """Returns the area inside a ring, by the even-odd rule."""
    if len(set(map(tuple, ring))) < 3:
        return shapely.geometry.Polygon()
    made = shapely.validation.make_valid(shapely.geometry.Polygon(ring))
    kept = [part for part in getattr(made, "geoms", [made]) if part.geom_type in ("Polygon", "MultiPolygon")]
    return shapely.ops.unary_union(kept)


def parts_of(geometry):
    coordinates = geometry["coordinates"]
    return [coordinates] if geometry["type"] == "Polygon" else coordinates


def repaired_area(geometry):
    return shapely.ops.unary_union([
        area_of(outer).difference(shapely.ops.unary_union([area_of(hole) for hole in holes]))
        for outer, *holes in parts_of(geometry)])


def is_valid(geometry):
    return shapely.geometry.shape(geometry).is_valid


class Maps(ServerCase):
    def ask_all(self, bodies):
        """Returns the answers to many requests, from one curl."""
        with tempfile.TemporaryDirectory() as folder:
            calls = []
            for number, body in enumerate(bodies):
                path = pathlib.Path(folder, str(number))
                path.write_text(json.dumps(body))
                calls.append(f'silent\nshow-error\nurl = "{self.server.url("/sample")}"\ndata-binary = "@{path}"\n'
                             f'output = "{path}.json"\nwrite-out = "%{{http_code}}\\n"\n')
            done = execute(["curl", "--config", "-"], input="next\n".join(calls), capture_output=True, text=True,
                           check=True)
            answers = [json.loads(pathlib.Path(folder, f"{number}.json").read_text()) for number in range(len(bodies))]
            return list(zip(map(int, done.stdout.split()), answers, strict=True))

    def check(self, geometry, answer):
        points = numpy.array(answer["points"])
        self.assertEqual(points.shape, (SITES, 2))
        self.assertEqual(len(numpy.unique(points, axis=0)), SITES)
        area = repaired_area(geometry)
        outside = ~shapely.vectorized.contains(area, *points.T)
        self.assertFalse(outside.any(), points[outside])
        self.assertEqual("repaired" not in answer, is_valid(geometry))
        for repair in answer.get("repaired", []):
            self.assertRegex(repair["pointer"], "^/geometry/coordinates")

    def test_every_polygon(self):
        for file, (name, count) in FILES.items():
            given = features(file, name)
            self.assertEqual(len(given), count)
            answers = self.ask_all([{"sites": SITES, "geometry": each["geometry"]} for each in given])
            for each, (status, answer) in zip(given, answers, strict=True):
                named = each["properties"]["name"]
                with self.subTest(file=file, name=named):
                    if (file, named) in FLAT:
                        self.assertEqual((status, answer["errors"][0]["detail"]), (422, "the polygon has no area"))
                    else:
                        self.assertEqual(status, 200, answer)
                        self.check(each["geometry"], answer)

    def test_repairable_polygons_may_be_rejected(self):
        given = [each["geometry"] for each in features("world-atlas/countries-50m.json", "countries")]
        wrong = next(geometry for geometry in given if not is_valid(geometry))
        repair = post_json(self.server, "/sample", {"sites": 10, "geometry": wrong}).json()["repaired"][0]
        answer = post_json(self.server, "/sample", {"sites": 10, "geometry": wrong, "invalid": "reject"})
        self.assertEqual(answer.status, 422)
        self.assertEqual(answer.json()["errors"][0], repair)


if __name__ == "__main__":
    unittest.main()
