"""POST /sample with areas where no point may lie: shapely tells what these are, and how far points are from them."""

import json
import unittest

import numpy
import shapely
import shapely.geometry
import shapely.ops
import shapely.vectorized

from harness import ServerCase, polygon, post_json

ITALY = polygon("Italy-110m.geojson")
SQUARE = [[0, 0], [4, 0], [4, 4], [0, 4]]
LAKES = {"type": "MultiPolygon", "coordinates": [
    [[[11, 43], [12.5, 43.2], [12.3, 44], [11.2, 44.1]]],
    [[[14, 39], [20, 39], [20, 41], [14, 41]], [[15, 39.5], [17, 39.5], [17, 40], [15, 40]]]]}
BOWTIE = [[1, 1], [3, 3], [3, 1], [1, 3]]


class Avoided(ServerCase):
    def points(self, sites=2000, **body):
        points = numpy.array(self.sample(sites=sites, **body)["points"])
        self.assertEqual(points.shape, (sites, 2))
        self.assertEqual(len(numpy.unique(points, axis=0)), sites)
        return points

    def assert_within(self, area, points):
        outside = ~shapely.vectorized.contains(area, *points.T)
        self.assertFalse(outside.any(), points[outside])

    def test_no_point_lies_in_what_is_avoided(self):
        area = shapely.geometry.shape(ITALY).difference(shapely.geometry.shape(LAKES))
        feature = {"type": "Feature", "geometry": LAKES, "properties": None}
        for avoid in (LAKES, feature, {"type": "FeatureCollection", "features": [feature]}):
            for coordinates in ("plane", "lonlat"):
                self.assert_within(area, self.points(geometry=ITALY, avoid=avoid, coordinates=coordinates))

    def test_all_methods_keep_out(self):
        area = shapely.geometry.Polygon(SQUARE).difference(shapely.geometry.box(1, 1, 2, 5))
        for method in ("ccdt", "cvt", "odt", "ccvt", "random"):
            self.assert_within(area, self.points(200, polygon=SQUARE, method=method,
                                                 avoid=[[[1, 1], [2, 1], [2, 5], [1, 5]]]))

    def test_rectangles_have_areas_to_avoid(self):
        points = self.points(domain={"type": "rectangle", "width": 4, "height": 4},
                             avoid=[[[1, 1], [2, 1], [2, 2], [1, 2]], [[3, 3], [9, 3], [9, 9], [3, 9]]])
        area = shapely.geometry.Polygon(SQUARE).difference(
            shapely.ops.unary_union([shapely.geometry.box(1, 1, 2, 2), shapely.geometry.box(3, 3, 9, 9)]))
        self.assert_within(area, points)

    def test_a_density_is_over_the_whole_box(self):
        density = {"width": 2, "height": 1, "values": [1, 3]}
        points = self.points(polygon=SQUARE, density=density, avoid=[[[-1, -1], [1, -1], [1, 5], [-1, 5]]])
        self.assertGreater(points[:, 0].min(), 1)
        self.assertAlmostEqual((points[:, 0] > 2).mean(), 6 / 7, delta=0.01)

    def test_what_is_avoided_is_repaired_and_told(self):
        body = {"sites": 100, "polygon": SQUARE, "avoid": [BOWTIE]}
        answer = self.sample(**body)
        self.assertEqual([repair["pointer"] for repair in answer["repaired"]], ["/avoid/0/2"])
        halves = [shapely.geometry.Polygon([(1, 1), (2, 2), (1, 3)]), shapely.geometry.Polygon([(3, 1), (2, 2), (3, 3)])]
        self.assert_within(shapely.geometry.Polygon(SQUARE).difference(shapely.ops.unary_union(halves)),
                           numpy.array(answer["points"]))
        rejected = post_json(self.server, "/sample", {**body, "invalid": "reject"})
        self.assert_problem(rejected, 422, "cross")
        self.assertEqual(rejected.json()["errors"][0]["pointer"], "/avoid/0/2")

    def test_areas_come_to_the_turn_of_the_globe_that_the_polygon_is_in(self):
        fiji = [[170, -20], [-170, -20], [-170, 20], [170, 20]]
        for ring in ([[175, -5], [-175, -5], [-175, 5], [175, 5]], [[-185, -5], [-175, -5], [-175, 5], [-185, 5]]):
            points = self.points(polygon=fiji, avoid=[ring], coordinates="lonlat")
            away = numpy.abs(numpy.remainder(points[:, 0], 360) - 180)
            self.assertFalse(((away < 5) & (numpy.abs(points[:, 1]) < 5)).any())
            self.assertTrue((away < 10).all() and ((away < 5).sum() > 600))

    def test_the_pole_is_avoided(self):
        north = {"type": "Polygon", "coordinates": [[[-180, 60], [180, 60], [180, 90], [-180, 90]]]}
        around = [[[-180, 80], [-60, 80], [60, 80]]]
        self.assertLess(self.points(geometry=north, avoid=around, coordinates="lonlat")[:, 1].max(), 80)

    def test_wrong_ones_are_told(self):
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

    def test_nothing_may_be_avoided(self):
        plain = self.sample(sites=50, polygon=SQUARE)["points"]
        for avoid in ([], {"type": "FeatureCollection", "features": []}, [[[7, 7], [8, 7], [8, 8]]]):
            self.assertEqual(self.sample(sites=50, polygon=SQUARE, avoid=avoid)["points"], plain, json.dumps(avoid))
        flat = self.sample(sites=50, polygon=SQUARE, avoid=[[[1, 1], [2, 2]]])
        self.assertEqual((flat["points"], flat["repaired"][0]["pointer"]), (plain, "/avoid/0"))


if __name__ == "__main__":
    unittest.main()
