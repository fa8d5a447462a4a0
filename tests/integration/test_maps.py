# SPDX-License-Identifier: GPL-3.0-or-later
"""POST /sample with maps.

Class Maps uses all polygons of three popular files: npm's world-atlas and us-atlas. Their geometries are quantized
TopoJSON: many of their rings touch themselves or a neighbour, some are flat.
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



def square(x, properties=None, side=1):
    ring = [[x, 0], [x + side, 0], [x + side, side], [x, side], [x, 0]]
    return {"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": [ring]}}


def feature(geometry, properties=None):
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def collection(*features, **members):
    return {"type": "FeatureCollection", **members, "features": list(features)}


class Documents(ServerCase):
    def post(self, query, document, kind="application/geo+json"):
        data = document if isinstance(document, bytes) else json.dumps(document).encode()
        return self.ask(f"/sample?{query}", "-H", f"Content-Type: {kind}", data=data)

    def points(self, query, document, **options):
        answer = self.post(query, document, **options)
        self.assertEqual(answer.status, 200, answer)
        return answer.json()

    def warnings(self, query, document):
        return [(each["pointer"], each["detail"]) for each in self.points(query, document).get("warnings", [])]

    def test_sequences_of_features(self):
        features = [square(0, {"n": 3}), square(2, {"n": 5})]
        expected = self.points("sites=n&seed=1", collection(*features))["points"]
        lines = [json.dumps(each).encode() for each in features]
        for body in (b"\n".join(lines), b"\r\n".join(lines) + b"\r\n", b"\n\n" + b"\n\n".join(lines) + b"\n\n",
                     b"\xef\xbb\xbf" + b"\n".join(lines), b"".join(b"\x1e" + line + b"\n" for line in lines),
                     b"\xef\xbb\xbf" + b"".join(b"\x1e" + line for line in lines)):
            for kind in ("application/octet-stream", "application/x-ndjson", "application/geo+json-seq", ""):
                with self.subTest(body=body, kind=kind):
                    self.assertEqual(self.points("sites=n&seed=1", body, kind=kind)["points"], expected)
        for body in (lines[0], lines[0] + b"\r\n", b"\x1e" + lines[0] + b"\n"):
            self.assertEqual(len(self.points("sites=n", body)["points"]), 3)
        problem = self.assert_problem(self.post("sites=n", lines[0] + b"\n" + lines[1][:-1]), 400, "error at byte")
        self.assertNotIn("seems", problem["detail"])
        broken = feature({"type": "Polygon", "coordinates": [[[0, 0], "x"]]})
        problem = self.assert_problem(self.post("sites=3", lines[0] + b"\n" + json.dumps(broken).encode()), 400)
        self.assertEqual(problem["errors"][0]["pointer"], "/features/1/geometry/coordinates/0/1")

    def test_reads_the_sequences_that_it_writes(self):
        body = collection(square(0), square(2))
        for name in ("ndjson", "geojsonseq"):
            written = self.post(f"sites=20&format={name}", body)
            mixed = written.body + b"\x1e" * (name == "geojsonseq") + json.dumps(square(0)).encode() + b"\n"
            self.assertEqual(len(self.points("sites=5", mixed)["points"]), 5)

    def test_empty_geometries_are_left_out(self):
        for geometry in (None, {"type": "Polygon", "coordinates": []}, {"type": "MultiPolygon", "coordinates": []},
                         {"type": "MultiPolygon", "coordinates": [[]]}, {"type": "Polygon", "coordinates": [[]]}):
            with self.subTest(geometry):
                body = collection(feature(geometry, {"n": 4}), square(0, {"n": 20}))
                self.assertEqual(self.warnings("sites=n", body),
                                 [("/features/0", "the feature has no polygon: 4 points left out")])
                kind = "null" if geometry is None else "empty"
                self.assertEqual(self.warnings("sites=9", body),
                                 [("/features/0/geometry", f"1 {kind} geometry is left out")])
                self.assert_problem(self.post("sites=3", feature(geometry)), 422, "contains no polygon")
        body = collection(feature({"type": "GeometryCollection", "geometries": []}, {"n": 4}), square(0, {"n": 20}))
        self.assertEqual(len(self.warnings("sites=n", body)), 1)

    def test_empty_arcs_are_left_out(self):
        arcs = [[[0, 0], [1, 0], [1, 1], [0, 0]]]
        for empty in ({"type": "Polygon", "arcs": []}, {"type": "MultiPolygon", "arcs": []}, {"type": None},
                      {"type": "MultiPolygon", "arcs": [[]]}, {"type": "Point", "coordinates": [0, 0]}):
            with self.subTest(empty):
                body = {"type": "Topology", "arcs": arcs, "objects": {"a": {"type": "GeometryCollection", "geometries": [
                    {**empty, "properties": {"n": 4}},
                    {"type": "MultiPolygon", "arcs": [[], [[0]]], "properties": {"n": 5}}]}}}
                self.assertEqual(len(self.points("sites=n", body)["points"]), 5)
                self.assertIn(("/objects/a/geometries/0", "the feature has no polygon: 4 points left out"),
                              self.warnings("sites=n", body))
                self.assertEqual(len(self.warnings("sites=9", body)), 1)

    def test_points_and_lines_are_left_out(self):
        line = {"type": "LineString", "coordinates": [[0, 0], [1, 1]]}
        mixed = {"type": "GeometryCollection", "geometries": [line, square(3)["geometry"]]}
        body = collection(feature({"type": "Point", "coordinates": [9, 9]}), square(0), feature(line), feature(mixed))
        self.assertEqual(self.warnings("sites=9", body), [
            ("/features/0/geometry", "1 geometry is left out: type Point, but only polygons have an area"),
            ("/features/2/geometry", "2 geometries are left out: type LineString, but only polygons have an area")])
        problem = self.assert_problem(self.post("sites=9", collection(feature(line))), 400, "not a LineString")
        self.assertEqual(problem["errors"][0]["pointer"], "/features/0/geometry")

    def test_integers_keep_all_digits(self):
        for number in (2 ** 53 + 1, -(2 ** 63), 2 ** 64 - 1, 12345678901234567890123):
            body = collection({**square(0, {"code": number}), "id": number}, square(2, {"code": 1}))
            query = "sites=9&properties=code"
            self.assertEqual(self.points(query, body)["features"][0]["properties"]["code"], number)
            self.assertIn(f",{number}\r\n", self.post(query + "&format=csv", body).body.decode())
            answer = json.loads(self.post(query + "&format=geojson", body).body)
            self.assertIn(number, [each["properties"]["code"] for each in answer["features"]])

    def test_unknown_properties_are_named(self):
        body = collection(square(0, {"POP2020": 3, "name": "a"}), square(2, {"POP2020": 4}))
        for query, pointer in (("sites=POP2021", "sites"), ("classes=POP2020,pop_2020", "classes"),
                               ("sites=9&properties=POP", "properties")):
            with self.subTest(query):
                problem = self.assert_problem(self.post(query, body), 400, "POP2020, name")
                self.assertEqual(problem["errors"][0]["pointer"], pointer)
        self.assert_problem(self.post("sites=POP2021", body), 400, "did you mean 'POP2020'?")
        self.assert_problem(self.post("per=5000", body), 400, "POP2020, name")
        self.assert_problem(self.post("sites=POP2020&per=5000", body), 422, "divided by per, round to 0")

    def test_reference_systems(self):
        degrees = {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}
        metres = {"type": "name", "properties": {"name": "EPSG:25832"}}
        for crs, query, warned in ((degrees, "", "coordinates=lonlat"), (degrees, "&coordinates=lonlat", None),
                                   (metres, "", None), (metres, "&coordinates=lonlat", "should be plane")):
            with self.subTest(crs=crs, query=query):
                found = self.warnings("sites=9" + query, collection(square(0), crs=crs))
                self.assertEqual(len(found), warned is not None)
                self.assertIn(warned or "", found[0][1] if found else "")
        for crs in (None, 1, {}, {"properties": 1}, {"properties": {"name": 1}}, {"properties": {"name": "("}}):
            self.assertEqual(self.warnings("sites=9", collection(square(0), crs=crs)), [])

    def test_rings_along_parallels(self):
        around = {"type": "Polygon", "coordinates": [[[x, 60] for x in (-180, -90, 0, 90, 180)]]}
        problem = self.assert_problem(self.post("sites=9&coordinates=lonlat", around), 422, "[180, 90] and [-180, 90]")
        self.assertEqual(problem["errors"][0]["pointer"], "/coordinates/0")
        box = [[-179, 60], [179, 60], [179, 70], [-179, 70], [-179, 60]]
        found = self.warnings("sites=9&coordinates=lonlat", {"type": "Polygon", "coordinates": [box]})
        self.assertEqual([pointer for pointer, detail in found if "antimeridian" in detail], ["/coordinates/0/0"])
        whole = [[-180, 60], [180, 60], [180, 70], [-180, 70], [-180, 60]]
        self.assertEqual(self.warnings("sites=9&coordinates=lonlat", {"type": "Polygon", "coordinates": [whole]}), [])

    def test_other_members_are_ignored(self):
        plain = self.points("sites=9", collection(square(0), square(2)))["points"]
        raised = square(2)
        raised["geometry"]["coordinates"] = [[[x, y, 7] for x, y in raised["geometry"]["coordinates"][0]]]
        body = collection({**square(0), "bbox": [0, 0, 1, 1], "id": 7, "style": {"x": 1}}, raised, bbox=[0, 0, 3, 1],
                          name="layer", unknown=[1])
        self.assertEqual(self.points("sites=9", body)["points"], plain)
        self.assert_problem(self.post("sites=9", b'{"type":"Polygon","type":"Polygon","coordinates":[]}'), 400, "twice")


if __name__ == "__main__":
    unittest.main()
