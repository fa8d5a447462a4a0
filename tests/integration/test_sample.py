# SPDX-License-Identifier: GPL-3.0-or-later
"""POST /sample: domains, densities and the mesh."""

import json
import unittest

import numpy

from harness import ServerCase, area, data_uri, file_of, flat, inside, polygon, post_json, rings_of

SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
RECTANGLE = {"type": "rectangle", "width": 2, "height": 1}


def circle(corners):
    angle = 2 * numpy.pi * numpy.arange(corners) / corners
    return numpy.stack([numpy.cos(angle), numpy.sin(angle)], axis=1)


class Domains(ServerCase):
    def check(self, rings, sites, **body):
        result = self.sample(sites=sites, **body)
        self.assertEqual(result["sites"], sites)
        points = numpy.array(result["points"])
        self.assertEqual(points.shape, (sites, 2))
        self.assertTrue(inside(points, [numpy.array(ring) for ring in rings]).all())
        self.assertEqual(len(numpy.unique(points, axis=0)), sites)
        self.assertEqual(len(result["trace"]), result["iterations"] + 1)
        return result

    def test_polygon_open_or_closed_in_any_orientation(self):
        closed = SQUARE + SQUARE[:1]
        results = [self.check([SQUARE], 100, polygon=ring) for ring in (SQUARE, closed, SQUARE[::-1])]
        self.assertEqual(results[0]["points"], results[1]["points"])

    def test_polygon_with_holes(self):
        outer = [[0, 0], [10, 0], [10, 5], [0, 5]]
        holes = [[[1, 1], [4, 1], [4, 4], [1, 4]], [[6, 1], [9, 1], [7.5, 4]]]
        self.check([outer, *holes], 500, polygon=outer, holes=holes)

    def test_rectangle(self):
        self.check([[[0, 0], [2, 0], [2, 1], [0, 1]]], 300, domain=RECTANGLE)

    def test_countries(self):
        for name in ("Switzerland-10m", "South-Africa-50m", "Italy-110m"):
            geometry = polygon(name + ".geojson")
            for form in (geometry, {"type": "Feature", "properties": {}, "geometry": geometry}):
                with self.subTest(name=name, form=form["type"]):
                    self.check(rings_of(geometry), 2000, geometry=form)

    def test_invalid_polygons_are_repaired_with_a_report(self):
        bow_tie = [[0, 0], [2, 2], [2, 0], [0, 2]]
        repairs = [{"pointer": "/polygon/2", "detail": "the outer ring of part 0 crosses itself at (1, 1)"}]
        self.assertEqual(self.check([bow_tie], 100, polygon=bow_tie)["repaired"], repairs)
        body = {"sites": 100, "polygon": bow_tie}
        for form in ("csv", "geojson", "npy", "svg", "png"):
            with self.subTest(format=form):
                answer = post_json(self.server, "/sample", {**body, "format": form})
                self.assertEqual((answer.status, json.loads(answer.headers["x-repaired"])), (200, repairs))
        self.assertNotIn("x-repaired", post_json(self.server, "/sample", body).headers)
        parts = [[[[x, 0], [x + 1, 0], [x + 1, 1], [x, 1]]] for x in (0, 1)]
        result = self.check([[[0, 0], [2, 0], [2, 1], [0, 1]]], 100,
                            geometry={"type": "MultiPolygon", "coordinates": parts})
        self.assertEqual([each["pointer"] for each in result["repaired"]], ["/geometry/coordinates/1/0/3"])

    def test_a_document_may_be_the_body(self):
        rings = [[[x, 0], [x + 1, 0], [x + 1, 1], [x, 1]] for x in (0, 2, 4)]
        polygons = [{"type": "Polygon", "coordinates": [ring]} for ring in rings]
        features = [{"type": "Feature", "properties": {"people": 3}, "geometry": geometry}
                    for geometry in ({"type": "GeometryCollection", "geometries": polygons[:2]}, None, polygons[2])]
        document = {"type": "FeatureCollection", "features": features}
        expected = self.check(rings, 100, geometry={"type": "MultiPolygon", "coordinates": [[ring] for ring in rings]},
                              seed=3)["points"]
        self.assertEqual(self.check(rings, 100, geometry=document, seed=3)["points"], expected)
        for kind in ("application/geo+json", "application/json", ""):
            answer = self.ask("/sample?sites=100&seed=3", "--header", "Content-Type: " + kind, data=json.dumps(document))
            self.assertEqual((answer.status, answer.json()["points"]), (200, expected))
        answer = self.ask("/sample?sites=100&seed=3", "--header", "Accept: application/geo+json",
                          data=json.dumps(document))
        self.assertEqual(answer.json()["geometry"]["coordinates"], expected)

    def test_coordinates_that_may_be_degrees_get_a_warning(self):
        norway = {"type": "Polygon", "coordinates": [[[5, 58], [31, 58], [31, 71], [5, 71]]]}
        warnings = self.sample(sites=9, geometry=norway)["warnings"]
        self.assertEqual(warnings[0]["pointer"], "/geometry/coordinates")
        self.assertIn("1.63 times as many to a square kilometre at latitude 71 as at 58", warnings[0]["detail"])
        answer = post_json(self.server, "/sample?sites=9&format=csv", norway)
        self.assertEqual(json.loads(answer.headers["x-warnings"]), [{**warnings[0], "pointer": "/coordinates"}])

    def test_rings_may_touch(self):
        square = [[0, 0], [4, 0], [4, 4], [0, 4]]
        holes = [[[0, 0], [2, 1], [1, 2]], [[2, 4], [3, 3], [1, 3]], [[3, 3], [3.5, 2], [3, 1]]]
        result = self.check([square, *holes], 500, polygon=square, holes=holes, mesh=True)
        self.assertNotIn("repaired", result)

    def test_one_site(self):
        self.check([SQUARE], 1, polygon=SQUARE)
        self.check(rings_of(polygon("Switzerland-10m.geojson")), 1, geometry=polygon("Switzerland-10m.geojson"))

    def test_many_corners_and_few_sites(self):
        ring = circle(10_000)
        self.check([ring], 10, polygon=ring.tolist())

    def test_sliver(self):
        ring = [[0, 0], [1000, 0], [1000, 0.001]]
        self.check([ring], 50, polygon=ring)

    def test_coordinates_far_from_the_origin(self):
        ring = (numpy.array(SQUARE) * 3 + 1e6).tolist()
        self.check([ring], 100, polygon=ring)

    def test_body_needs_no_content_type(self):
        body = json.dumps({"sites": 10, "domain": RECTANGLE})
        for header in ("Content-Type:", "Content-Type: text/plain", "Content-Type: application/x-www-form-urlencoded"):
            with self.subTest(header=header):
                answer = self.ask("/sample", "--header", header, data=body)
                self.assertEqual(answer.status, 200, answer)
                self.assertEqual(answer.type, "application/json")

    def test_tolerance_ends_the_run(self):
        result = self.check([SQUARE], 200, polygon=SQUARE, tolerance=100, iterations=50)
        self.assertLess(result["iterations"], 50)

    def test_torus(self):
        domain = {"type": "torus", "width": 3, "height": 2}
        for density in ({}, {"density": {"width": 2, "height": 1, "values": [1, 3]}}):
            with self.subTest(density=density):
                result = self.sample(sites=600, domain=domain, mesh=True, **density)
                points, triangles = numpy.array(result["points"]), numpy.array(result["triangles"])
                self.assertEqual(len(numpy.unique(points, axis=0)), 600)
                self.assertTrue((points >= 0).all() and (points < (3, 2)).all())
                self.assertEqual(result["vertices"], result["points"])
                self.assertEqual(result["boundary"], [])
                self.assertEqual(triangles.shape, (1200, 3))
                # Every edge must occur once in each direction, and the nearest copies of the triangles must fill the
                # torus.
                edges = {(t[i], t[i - 2]) for t in result["triangles"] for i in range(3)}
                self.assertEqual(edges, {(q, p) for p, q in edges})
                a, b, c = (points[triangles[:, i]] for i in range(3))
                b, c = (a + (p - a + (1.5, 1)) % (3, 2) - (1.5, 1) for p in (b, c))
                areas = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
                self.assertTrue((areas > 0).all())
                self.assertAlmostEqual(areas.sum(), 6, delta=1e-9)

    def test_quality(self):
        drafts, standards, bests = ([self.check([SQUARE], 500, polygon=SQUARE, **quality) for _ in range(2)]
                                    for quality in ({"quality": "draft"}, {}, {"quality": "best"}))
        for one, other in (drafts, standards, bests):
            self.assertEqual(one["points"], other["points"])
        self.assertNotEqual(drafts[0]["points"], standards[0]["points"])
        self.assertNotEqual(bests[0]["points"], standards[0]["points"])
        self.assertEqual(drafts[0]["variation"], drafts[0]["trace"][-1]["variation"])

    def test_variation_falls(self):
        result = self.check([SQUARE], 1000, polygon=SQUARE)
        self.assertLess(result["variation"], 0.5 * result["trace"][0]["variation"])


class Densities(ServerCase):
    def points(self, density, sites=1000, **body):
        return numpy.array(self.sample(sites=sites, density=density, **(body or {"domain": RECTANGLE}))["points"])

    def test_grid_has_its_first_row_at_the_smallest_y(self):
        points = self.points({"width": 1, "height": 2, "values": [9, 1]})
        self.assertAlmostEqual((points[:, 1] < 0.5).mean(), 0.9, delta=0.03)

    def test_grid_runs_along_x(self):
        points = self.points({"width": 2, "height": 1, "values": [1, 3]})
        self.assertAlmostEqual((points[:, 0] > 1).mean(), 0.75, delta=0.03)

    def test_image_has_its_first_row_at_the_largest_y_and_is_dense_where_dark(self):
        picture = flat(255, 40, 40)
        picture[:20] = 0
        for image in (data_uri(file_of(picture)), data_uri(file_of(picture)).split(",")[1]):
            points = self.points({"image": image})
            self.assertGreater((points[:, 1] > 0.5).mean(), 0.98)

    def test_density_that_is_zero_almost_everywhere(self):
        values = numpy.zeros((100, 100))
        values[70, 20] = 1
        result = self.points({"width": 100, "height": 100, "values": values.ravel().tolist()}, 50, polygon=SQUARE)
        self.assertEqual(result.shape, (50, 2))
        cell = (numpy.abs(result - (0.205, 0.705)) < 0.03).all(axis=1)
        self.assertGreater(cell.mean(), 0.9)


class Mesh(ServerCase):
    def check(self, rings, **body):
        result = self.sample(mesh=True, **body)
        vertices, triangles = numpy.array(result["vertices"]), numpy.array(result["triangles"])
        self.assertEqual(result["vertices"][:len(result["points"])], result["points"])
        self.assertTrue((triangles >= 0).all() and (triangles < len(vertices)).all())
        a, b, c = (vertices[triangles[:, i]] for i in range(3))
        areas = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
        self.assertTrue((areas > 0).all())
        self.assertAlmostEqual(areas.sum() / area([numpy.array(ring) for ring in rings]), 1, delta=0.05)
        edges = {(t[i], t[i - 2]) for t in result["triangles"] for i in range(3)}
        self.assertEqual(len(edges), 3 * len(triangles), "an edge is used twice in one direction")
        border = {(p, q) for p, q in edges if (q, p) not in edges}
        loops = {(loop[i - 1], loop[i]) for loop in result["boundary"] for i in range(len(loop))}
        self.assertEqual(loops, border)

    def test_rectangle(self):
        self.check([[[0, 0], [2, 0], [2, 1], [0, 1]]], sites=500, domain=RECTANGLE)

    def test_country_with_a_hole_and_an_island(self):
        geometry = polygon("South-Africa-50m.geojson")
        self.check(rings_of(geometry), sites=1000, geometry=geometry)

    def test_is_omitted_unless_requested(self):
        result = self.sample(sites=10, domain=RECTANGLE)
        for member in ("vertices", "triangles", "boundary"):
            self.assertNotIn(member, result)


if __name__ == "__main__":
    unittest.main(verbosity=2)
