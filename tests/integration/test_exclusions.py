# SPDX-License-Identifier: GPL-3.0-or-later
"""POST /sample with excluded areas. shapely computes these areas and the distances of points from them."""

import base64
import io
import json
import math
import unittest

import numpy
import PIL.Image
import PIL.ImageFilter
import pyproj
import shapely.geometry
import shapely.ops
import shapely.vectorized

from harness import ROOT, ServerCase, polygon, post_json

GEOD = pyproj.Geod(ellps="WGS84")
TO_SPACE = pyproj.Transformer.from_crs(4979, 4978, always_xy=True)
ITALY = polygon("Italy-110m.geojson")
SQUARE = [[0, 0], [4, 0], [4, 4], [0, 4]]
LAKES = {"type": "MultiPolygon", "coordinates": [
    [[[11, 43], [12.5, 43.2], [12.3, 44], [11.2, 44.1]]],
    [[[14, 39], [20, 39], [20, 41], [14, 41]], [[15, 39.5], [17, 39.5], [17, 40], [15, 40]]]]}
BOWTIE = [[1, 1], [3, 3], [3, 1], [1, 3]]


def embedded(grey):
    file = io.BytesIO()
    PIL.Image.fromarray(grey).save(file, "PNG")
    return {"image": base64.b64encode(file.getvalue()).decode()}


def distances_to(border, points):
    return numpy.array([border.distance(shapely.geometry.Point(point)) for point in points])


def edges_of(ring):
    corners = numpy.array(ring.coords)
    return numpy.stack([corners[:-1], corners[1:]], axis=1)


def cut(edges, longest):
    """Cuts edges [n, 2, 2] into pieces of a maximum length in degrees."""
    pieces = []
    for a, b in edges:
        shares = numpy.linspace(0, 1, 1 + max(1, math.ceil(numpy.hypot(*(b - a)) / longest)))
        ends = a + shares[:, None] * (b - a)
        pieces.append(numpy.stack([ends[:-1], ends[1:]], axis=1))
    return numpy.concatenate(pieces)


def in_space(degrees):
    return numpy.stack(TO_SPACE.transform(*degrees.T, numpy.zeros(len(degrees))), axis=1)


class Avoided(ServerCase):
    def points(self, sites=2000, **body):
        points = numpy.array(self.sample(sites=sites, **body)["points"])
        self.assertEqual(points.shape, (sites, 2))
        self.assertEqual(len(numpy.unique(points, axis=0)), sites)
        return points

    def assert_within(self, area, points):
        outside = ~shapely.vectorized.contains(area, *points.T)
        self.assertFalse(outside.any(), points[outside])

    def test_areas_contain_no_points(self):
        area = shapely.geometry.shape(ITALY).difference(shapely.geometry.shape(LAKES))
        feature = {"type": "Feature", "geometry": LAKES, "properties": None}
        for avoid in (LAKES, feature, {"type": "FeatureCollection", "features": [feature]}):
            for coordinates in ("plane", "lonlat"):
                self.assert_within(area, self.points(geometry=ITALY, avoid=avoid, coordinates=coordinates))

    def test_areas_apply_to_all_methods(self):
        area = shapely.geometry.Polygon(SQUARE).difference(shapely.geometry.box(1, 1, 2, 5))
        for method in ("ccdt", "cvt", "odt", "ccvt", "random"):
            self.assert_within(area, self.points(200, polygon=SQUARE, method=method,
                                                 avoid=[[[1, 1], [2, 1], [2, 5], [1, 5]]]))

    def test_areas_apply_to_rectangles(self):
        points = self.points(domain={"type": "rectangle", "width": 4, "height": 4},
                             avoid=[[[1, 1], [2, 1], [2, 2], [1, 2]], [[3, 3], [9, 3], [9, 9], [3, 9]]])
        area = shapely.geometry.Polygon(SQUARE).difference(
            shapely.ops.unary_union([shapely.geometry.box(1, 1, 2, 2), shapely.geometry.box(3, 3, 9, 9)]))
        self.assert_within(area, points)

    def test_density_covers_the_whole_bounding_box(self):
        density = {"width": 2, "height": 1, "values": [1, 3]}
        points = self.points(polygon=SQUARE, density=density, avoid=[[[-1, -1], [1, -1], [1, 5], [-1, 5]]])
        self.assertGreater(points[:, 0].min(), 1)
        self.assertAlmostEqual((points[:, 0] > 2).mean(), 6 / 7, delta=0.01)

    def test_areas_are_repaired_with_a_report(self):
        body = {"sites": 100, "polygon": SQUARE, "avoid": [BOWTIE]}
        answer = self.sample(**body)
        self.assertEqual([repair["pointer"] for repair in answer["repaired"]], ["/avoid/0/2"])
        halves = [shapely.geometry.Polygon([(1, 1), (2, 2), (1, 3)]), shapely.geometry.Polygon([(3, 1), (2, 2), (3, 3)])]
        self.assert_within(shapely.geometry.Polygon(SQUARE).difference(shapely.ops.unary_union(halves)),
                           numpy.array(answer["points"]))
        rejected = post_json(self.server, "/sample", {**body, "invalid": "reject"})
        self.assert_problem(rejected, 422, "cross")
        self.assertEqual(rejected.json()["errors"][0]["pointer"], "/avoid/0/2")

    def test_areas_apply_in_every_turn_of_the_globe(self):
        fiji = [[170, -20], [-170, -20], [-170, 20], [170, 20]]
        for ring in ([[175, -5], [-175, -5], [-175, 5], [175, 5]], [[-185, -5], [-175, -5], [-175, 5], [-185, 5]]):
            points = self.points(polygon=fiji, avoid=[ring], coordinates="lonlat")
            away = numpy.abs(numpy.remainder(points[:, 0], 360) - 180)
            self.assertFalse(((away < 5) & (numpy.abs(points[:, 1]) < 5)).any())
            self.assertTrue((away < 10).all() and ((away < 5).sum() > 600))

    def test_areas_may_contain_a_pole(self):
        north = {"type": "Polygon", "coordinates": [[[-180, 60], [180, 60], [180, 90], [-180, 90]]]}
        around = [[[-180, 80], [-60, 80], [60, 80]]]
        self.assertLess(self.points(geometry=north, avoid=around, coordinates="lonlat")[:, 1].max(), 80)

    def test_buffer_applies_to_border_and_areas(self):
        area = shapely.geometry.shape(ITALY).difference(shapely.geometry.shape(LAKES))
        for buffer in (1e-6, 0.05, 0.2):
            points = self.points(geometry=ITALY, avoid=LAKES, buffer=buffer)
            self.assert_within(area, points)
            distances = distances_to(area.boundary, points)
            self.assertGreaterEqual(distances.min(), buffer)
            self.assertLess(distances.min(), 1.02 * buffer + 0.5 * math.sqrt(area.area / len(points)))

    def test_buffer_applies_to_holes_and_rectangles(self):
        hole = [[2, 2], [2.5, 2], [2.5, 2.5], [2, 2.5]]
        area = shapely.geometry.Polygon(SQUARE, [hole])
        for body in ({"polygon": SQUARE, "holes": [hole]},
                     {"domain": {"type": "rectangle", "width": 4, "height": 4}, "avoid": [hole]}):
            points = self.points(buffer=0.3, **body)
            distances = distances_to(area.boundary, points)
            self.assertGreaterEqual(distances.min(), 0.3)
            # The points must be as even as in other areas of the same size.
            inner = area.buffer(-0.3)
            pitch = numpy.sqrt(inner.area / len(points))
            self.assertAlmostEqual(shapely.vectorized.contains(inner.buffer(-2 * pitch), *points.T).mean(),
                                   inner.buffer(-2 * pitch).area / inner.area, delta=0.01)

    def test_buffer_is_in_metres_on_the_ground(self):
        wide = {"type": "Polygon", "coordinates": [[[-20, 50], [40, 50], [40, 72], [-20, 72]]]}
        for geometry, metres in ((ITALY, 500), (ITALY, 20_000), (wide, 100), (wide, 200_000)):
            answer = self.sample(sites=2000, geometry=geometry, buffer=metres, coordinates="lonlat")
            least = self.min_metres(numpy.array(answer["points"]), shapely.geometry.shape(geometry), metres)
            self.assertGreaterEqual(least, 0.999 * metres)
            # The first row of sites is half a row, sqrt(3) / 4 pitches, from the border.
            self.assertLess(least, 1.04 * metres + 0.44 * answer["pitch_m"])

    def test_buffer_on_the_globe_applies_to_the_island_only(self):
        globe = [[-180, -90], [180, -90], [180, 90], [-180, 90]]
        island = [[110, -35], [150, -35], [150, -15], [110, -15]]
        answer = self.sample(sites=2000, polygon=globe, avoid=[island], buffer=300_000, coordinates="lonlat", mesh=True)
        points = numpy.array(answer["points"])
        least = self.min_metres(points, shapely.geometry.Polygon(island), 300_000)
        self.assertGreaterEqual(least, 0.999 * 300_000)
        # There must be no strip without points where the globe is cut.
        spaces = in_space(points)
        nearest = [numpy.sort(numpy.linalg.norm(spaces - place, axis=1))[6] for place in spaces]
        self.assertLess(numpy.median(nearest), 1.4 * answer["pitch_m"])
        self.assertLess(max(nearest), 2.2 * answer["pitch_m"])

    def min_metres(self, points, shape, metres):
        """Returns the minimum geodesic distance of points to the border, computed only for the 50 nearest points and
        the four pieces of the border that are nearest to each in space."""
        pieces = cut(numpy.concatenate([edges_of(ring) for part in getattr(shape, "geoms", [shape])
                                        for ring in (part.exterior, *part.interiors)]), 0.05)
        middles = in_space((pieces[:, 0] + pieces[:, 1]) / 2)
        places = in_space(points)
        away = numpy.array([numpy.linalg.norm(middles - place, axis=1) for place in places])
        found = []
        for number in away.min(axis=1).argsort()[:50]:
            near = pieces[away[number].argsort()[:4]]
            border = cut(near, 0.02 * metres / 111_000)[:, 0]
            found.append(GEOD.inv(*border.T, *numpy.broadcast_to(points[number], border.shape).T)[2].min())
        return min(found)

    def test_invalid_areas_are_refused(self):
        def refused(status, pointer, *words, **body):
            answer = post_json(self.server, "/sample", {"sites": 10, **body})
            self.assert_problem(answer, status, *words)
            self.assertEqual(answer.json()["errors"][0]["pointer"], pointer, answer)

        far = 1e308
        refused(422, "/avoid", "nothing", polygon=SQUARE, avoid=[[[-1, -1], [5, -1], [5, 5], [-1, 5]]])
        refused(400, "/avoid", "torus", domain={"type": "torus", "width": 1, "height": 1}, avoid=[SQUARE])
        refused(400, "/avoid/0/1", "position", polygon=SQUARE, avoid=[[[0, 0], [1]]])
        refused(400, "/avoid", "a Polygon", polygon=SQUARE, avoid={"type": "Point", "coordinates": [1, 1]})
        refused(422, "/avoid/0", "extent", polygon=SQUARE, avoid=[[[-far, -far], [far, -far], [0, far]]])
        refused(422, "/avoid/0/2", "latitude", polygon=SQUARE, coordinates="lonlat", avoid=[[[1, 1], [2, 1], [2, 91]]])

    def test_buffers_that_leave_nothing_are_refused(self):
        def refused(status, *words, **body):
            answer = post_json(self.server, "/sample", {"sites": 10, **body})
            self.assert_problem(answer, status, *words)
            self.assertEqual(answer.json()["errors"][0]["pointer"], "/buffer", answer)

        refused(422, "about 1.99", polygon=SQUARE, buffer=2)
        refused(422, "about 1.99", polygon=SQUARE, buffer=1e308)
        refused(422, "nothing", polygon=SQUARE, buffer=1e7, coordinates="lonlat")
        refused(422, "nothing", polygon=SQUARE, buffer=1e308, coordinates="lonlat")
        refused(400, "torus", domain={"type": "torus", "width": 1, "height": 1}, buffer=0.1)
        refused(400, "at least 0", polygon=SQUARE, buffer=-1)
        plain = self.sample(sites=50, polygon=SQUARE)["points"]
        self.assertEqual(self.sample(sites=50, polygon=SQUARE, buffer=0)["points"], plain)
        self.points(50, polygon=SQUARE, buffer=1e-308)

    def test_buffer_applies_to_documents(self):
        document = json.dumps(ITALY)
        answer = self.ask("/sample?sites=10&buffer=99", data=document)
        self.assert_problem(answer, 422, "no place")
        self.assertEqual(answer.json()["errors"][0]["pointer"], "buffer")
        self.assertEqual(self.ask("/sample?sites=10&buffer=0.2", data=document).status, 200)

    def test_dark_pixels_of_an_excluded_picture_have_no_points(self):
        photograph = PIL.Image.open(ROOT / "tests/data/images/camera.png").resize((60, 40))
        grey = numpy.asarray(photograph.filter(PIL.ImageFilter.GaussianBlur(1)))
        dark = numpy.where(grey <= 10, grey / 3294.6, ((grey / 255 + 0.055) / 1.055) ** 2.4) < 0.5
        self.assertTrue(0.3 < dark.mean() < 0.9)
        for shape, coordinates in (({"geometry": ITALY}, "plane"), ({"geometry": ITALY}, "lonlat"),
                                   ({"domain": {"type": "rectangle", "width": 3, "height": 2}}, "plane")):
            points = self.points(**shape, coordinates=coordinates, exclude=embedded(grey))
            area = shapely.geometry.shape(ITALY) if "geometry" in shape else shapely.geometry.box(0, 0, 3, 2)
            self.assert_within(area, points)
            west, south, east, north = area.bounds
            columns = numpy.floor((points[:, 0] - west) / (east - west) * 60).astype(int)
            rows = numpy.floor((north - points[:, 1]) / (north - south) * 40).astype(int)
            self.assertFalse(dark[rows, columns].any())

    def test_buffer_applies_to_excluded_pictures(self):
        grey = numpy.full((4, 4), 255, numpy.uint8)
        grey[1, 2] = 0  # the square from (2, 2) to (3, 3)
        points = self.points(polygon=SQUARE, exclude=embedded(grey), buffer=0.25, density={"width": 1, "height": 1, "values": [1]})
        area = shapely.geometry.Polygon(SQUARE).difference(shapely.geometry.box(2, 2, 3, 3))
        self.assert_within(area, points)
        self.assertGreaterEqual(distances_to(area.boundary, points).min(), 0.25)
        grey[:] = 255
        plain = self.sample(sites=50, polygon=SQUARE)["points"]
        self.assertEqual(self.sample(sites=50, polygon=SQUARE, exclude=embedded(grey))["points"], plain)

    def test_invalid_excluded_pictures_are_refused(self):
        noise = numpy.random.default_rng(1).integers(0, 256, (400, 400), numpy.uint8)
        black, grey = numpy.zeros((2, 2), numpy.uint8), numpy.full((2, 2), 255, numpy.uint8)
        for status, field, words, body in (
                (422, "/exclude/image", "nothing", {"polygon": SQUARE, "exclude": embedded(black)}),
                (413, "/exclude/image", "100000 corners", {"polygon": SQUARE, "exclude": embedded(noise)}),
                (400, "/exclude", "torus", {"domain": {"type": "torus", "width": 1, "height": 1}, "exclude": embedded(grey)}),
                (400, "/exclude", "image", {"polygon": SQUARE, "exclude": {}}),
                (400, "/exclude/picture", "", {"polygon": SQUARE, "exclude": {"picture": ""}}),
                (400, "/exclude/image", "base64", {"polygon": SQUARE, "exclude": {"image": "?"}})):
            answer = post_json(self.server, "/sample", {"sites": 10, **body})
            self.assertEqual(answer.status, status, answer)
            self.assertEqual(answer.json()["errors"][0]["pointer"], field)
            self.assertIn(words, answer.json()["detail"])

    def test_empty_areas_change_nothing(self):
        plain = self.sample(sites=50, polygon=SQUARE)["points"]
        for avoid in ([], {"type": "FeatureCollection", "features": []}, [[[7, 7], [8, 7], [8, 8]]]):
            self.assertEqual(self.sample(sites=50, polygon=SQUARE, avoid=avoid)["points"], plain, json.dumps(avoid))
        flat = self.sample(sites=50, polygon=SQUARE, avoid=[[[1, 1], [2, 2]]])
        self.assertEqual((flat["points"], flat["repaired"][0]["pointer"]), (plain, "/avoid/0"))


if __name__ == "__main__":
    unittest.main()
