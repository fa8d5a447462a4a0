# SPDX-License-Identifier: GPL-3.0-or-later
"""POST /sample: the methods other than the default."""

import unittest

import numpy

from harness import ServerCase, inside, polygon, post_json, rings_of

TORUS = {"type": "torus", "width": 1, "height": 1}
SQUARE = {"type": "rectangle", "width": 1, "height": 1}


def nearest_around(points):
    """Returns the distance of each point to the nearest other point on the unit torus."""
    ways = points[:, None] - points[None]
    ways -= numpy.round(ways)
    squared = (ways ** 2).sum(axis=2)
    numpy.fill_diagonal(squared, 9)
    return numpy.sqrt(squared.min(axis=1))


class Methods(ServerCase):
    iterative = ("cvt", "odt", "ccvt")
    every = ("ccdt", *iterative, "random")

    def points(self, method, **body):
        result = self.sample(method=method, **body)
        self.assertEqual(result["method"], method)
        self.assertEqual(result["sites"], len(result["points"]))
        self.assertEqual(len(result["trace"]), result["iterations"] + 1)
        return numpy.array(result["points"])

    def test_country_with_a_hole(self):
        geometry = polygon("South-Africa-50m.geojson")
        for method in self.every:
            with self.subTest(method=method):
                points = self.points(method, sites=300, geometry=geometry)
                self.assertEqual(len(numpy.unique(points, axis=0)), 300)
                self.assertTrue(inside(points, rings_of(geometry)).all())

    def test_density(self):
        density = {"width": 2, "height": 1, "values": [1, 4]}
        for method in self.every:
            with self.subTest(method=method):
                points = self.points(method, sites=500, domain=SQUARE, density=density)
                self.assertAlmostEqual((points[:, 0] > 0.5).mean(), 0.8, delta=0.05)

    def test_nearest_distances_around_a_torus(self):
        """Mean and minimum of 500 sites, relative to the densest packing, must agree with the literature."""
        expected = {"cvt": (0.92, 0.78), "odt": (0.87, 0.60), "ccvt": (0.84, 0.70), "random": (0.465, 0.03)}
        for method, (mean, least) in expected.items():
            with self.subTest(method=method):
                points = self.points(method, sites=500, domain=TORUS, seed=1)
                self.assertTrue((points >= 0).all() and (points < 1).all())
                distances = nearest_around(points) / numpy.sqrt(2 / numpy.sqrt(3) / 500)
                self.assertAlmostEqual(distances.mean(), mean, delta=0.04)
                self.assertAlmostEqual(distances.min(), least, delta=0.08)

    def test_same_points_for_a_seed_and_others_for_another(self):
        for method in self.every:
            with self.subTest(method=method):
                first, again, other = (self.points(method, sites=100, domain=TORUS, seed=seed) for seed in (3, 3, 4))
                self.assertTrue((first == again).all())
                self.assertFalse((first == other).all())

    def test_iterations_and_tolerance(self):
        for method in self.iterative:
            with self.subTest(method=method):
                self.assertEqual(self.sample(method=method, sites=100, domain=SQUARE, iterations=3)["iterations"], 3)
                result = self.sample(method=method, sites=100, domain=SQUARE, tolerance=0.5)
                self.assertLess(result["variation"], 0.5)
                self.assertLess(result["iterations"], 20)

    def test_mesh(self):
        for method in self.every:
            with self.subTest(method=method):
                result = self.sample(method=method, sites=100, domain=TORUS, mesh=True)
                self.assertEqual(len(result["triangles"]), 200)
                self.assertEqual(result["vertices"], result["points"])

    def test_limits(self):
        for method, most in (("cvt", 50_000), ("odt", 500_000), ("ccvt", 20_000)):
            with self.subTest(method=method):
                body = {"sites": most + 1, "method": method, "domain": SQUARE}
                problem = self.assert_problem(post_json(self.server, "/sample", body), 413, method, str(most))
                self.assertEqual(problem["errors"][0]["pointer"], "/sites")

    def test_options_of_other_methods_are_refused(self):
        for method, option, value in (("cvt", "passes", 5), ("ccvt", "quality", "best"), ("random", "iterations", 1)):
            with self.subTest(method=method):
                body = {"sites": 10, "method": method, "domain": SQUARE, option: value}
                problem = self.assert_problem(post_json(self.server, "/sample", body), 400, method, option)
                self.assertEqual(problem["errors"][0]["pointer"], "/" + option)

    def test_unknown_method_is_refused(self):
        body = {"sites": 10, "method": "lloyd", "domain": SQUARE}
        self.assert_problem(post_json(self.server, "/sample", body), 400, "lloyd", "/method", *self.every)


class Impatient(ServerCase):
    flags = ("--timeout=1",)

    def test_deadline_ends_the_computation(self):
        for method in ("cvt", "ccvt"):
            with self.subTest(method=method):
                body = {"sites": 20_000, "method": method, "iterations": 1000, "domain": SQUARE}
                self.assert_problem(post_json(self.server, "/sample", body), 504)


if __name__ == "__main__":
    unittest.main(verbosity=2)
