# SPDX-License-Identifier: GPL-3.0-or-later
"""POST /analyze: spectra, spacing and the plot."""

import json
import unittest
import xml.etree.ElementTree

import numpy

from harness import DATA, Call, Server, ServerCase, post_json

TORUS = {"type": "torus", "width": 1, "height": 1}
SVG = "{http://www.w3.org/2000/svg}"


def noise(points, seed=1):
    return numpy.random.default_rng(seed).random((points, 2))


def power(points, i, j):
    """Returns the periodogram on the unit torus at frequency (i, j), computed by its definition."""
    return abs(numpy.exp(-2j * numpy.pi * (points @ (i, j))).sum()) ** 2 / len(points)


def nearest(points):
    """Returns the distance from each point to the nearest other point on the unit torus."""
    apart = numpy.abs(points[:, None] - points[None, :])
    squared = (numpy.minimum(apart, 1 - apart) ** 2).sum(axis=2)
    numpy.fill_diagonal(squared, numpy.inf)
    return numpy.sqrt(squared.min(axis=1))


class AnalyzeCase(ServerCase):
    def post(self, *arguments, **body):
        return post_json(self.server, "/analyze", body, *arguments)

    def analyze(self, **body):
        answer = self.post(**body)
        self.assertEqual(answer.status, 200, answer)
        self.assertEqual(answer.type, "application/json")
        return answer.json()


class Figures(AnalyzeCase):
    def test_spectrum_equals_its_definition(self):
        points = noise(150)
        spectrum = self.analyze(points=points.tolist(), spectrum=True)["spectrum"]
        self.assertEqual(len(spectrum["values"]), spectrum["width"] * spectrum["height"])
        values = numpy.array(spectrum["values"]).reshape(spectrum["height"], spectrum["width"])
        middle = spectrum["height"] // 2, spectrum["width"] // 2
        self.assertEqual(values[middle], 0)
        for i, j in ((1, 0), (0, 1), (3, -7), (-20, 11), (middle[1], middle[0]), (-middle[1], middle[0])):
            self.assertAlmostEqual(values[middle[0] + j, middle[1] + i], power(points, i, j), delta=1e-7)

    def test_curves_are_means_over_rings(self):
        result = self.analyze(points=noise(150).tolist(), spectrum=True)
        spectrum = result["spectrum"]
        values = numpy.array(spectrum["values"]).reshape(spectrum["height"], spectrum["width"])
        y, x = numpy.indices(values.shape) - numpy.array(values.shape)[:, None, None] // 2
        radius = numpy.hypot(x, y)
        half = (y > 0) | ((y == 0) & (x > 0))
        for r in (1, 5, len(result["power"])):
            ring = values[half & (numpy.rint(radius) == r)]
            self.assertAlmostEqual(result["frequency"][r - 1], r / 150 ** 0.5)
            self.assertAlmostEqual(result["power"][r - 1], ring.mean())
            decibels = 10 * numpy.log10(ring.var(ddof=1) / ring.mean() ** 2)
            self.assertAlmostEqual(result["anisotropy_db"][r - 1], decibels)
        low = values[half & (radius < 0.5 * 150 ** 0.5)]
        self.assertAlmostEqual(result["low_frequency_power"], low.mean())

    def test_distances_are_relative_to_the_densest_packing(self):
        sets = [noise(100, seed) for seed in range(3)]
        result = self.analyze(sets=[points.tolist() for points in sets])
        densest = (2 / (3 ** 0.5 * 100)) ** 0.5
        self.assertEqual(result["sets"], 3)
        self.assertAlmostEqual(result["min_distance"], numpy.mean([nearest(p).min() for p in sets]) / densest)
        self.assertAlmostEqual(result["mean_distance"], numpy.mean([nearest(p).mean() for p in sets]) / densest)

    def test_has_the_documented_members(self):
        names = {"frequency", "power", "anisotropy_db", "min_distance", "mean_distance", "low_frequency_power", "sets"}
        points = noise(50).tolist()
        self.assertEqual(set(self.analyze(points=points)), names)
        self.assertEqual(set(self.analyze(points=points, spectrum=True)), names | {"spectrum"})

    def test_stored_sets_give_the_stored_figures(self):
        for kind in ("torus", "rectangle"):
            expected = json.loads((DATA / "analysis" / f"{kind}-expected.json").read_text())
            answer = post_json(self.server, "/analyze", (DATA / "analysis" / f"{kind}.json").read_bytes())
            self.assertEqual(answer.status, 200, answer)
            found = answer.json()
            self.assertEqual(set(found), set(expected))
            for name in expected:
                numpy.testing.assert_allclose(found[name], expected[name], rtol=1e-6, atol=1e-6, err_msg=name)

    def test_sampled_points_are_blue(self):
        sets = [self.sample(sites=1000, seed=seed, domain={"type": "rectangle", "width": 3, "height": 2})["points"]
                for seed in range(4)]
        result = self.analyze(sets=sets, domain={"type": "rectangle", "width": 3, "height": 2})
        self.assertLess(result["low_frequency_power"], 0.01)
        self.assertGreater(result["mean_distance"], 0.8)
        frequency, radial = numpy.array(result["frequency"]), numpy.array(result["power"])
        self.assertLess(abs(frequency[radial.argmax()] - 1), 0.15)
        self.assertAlmostEqual(radial[frequency > 3].mean(), 1, delta=0.05)

    def test_max_frequency_ends_the_curves(self):
        for most in (1, 2.5, 8):
            frequency = self.analyze(points=noise(400).tolist(), max_frequency=most)["frequency"]
            self.assertAlmostEqual(frequency[-1], most)


class Plots(AnalyzeCase):
    points = noise(300).tolist()

    def test_accept_and_format_select_the_format(self):
        for kind, name in (("image/png", "png"), ("image/svg+xml", "svg"), ("application/json", "json")):
            accepted = self.post("--header", f"Accept: {kind}", points=self.points)
            named = self.post("--header", "Accept: text/csv", points=self.points, format=name)
            self.assertEqual((accepted.status, accepted.type), (200, kind))
            self.assertEqual((named.status, named.type), (200, kind))
            self.assertEqual(accepted.body, named.body)

    def test_png_has_four_panels(self):
        pixels = self.post(points=self.points, format="png").picture("L")
        self.assertEqual(pixels.shape, (1080, 3000))
        for left, top, right, bottom in ((90, 110, 910, 930), (1030, 110, 1850, 930), (2030, 110, 2810, 470),
                                         (2030, 570, 2810, 930)):
            panel = pixels[top:bottom, left:right]
            self.assertLess(panel.min(), 130)
            self.assertGreater(panel.max(), 200)

    def test_svg_is_well_formed_and_complete(self):
        root = xml.etree.ElementTree.fromstring(self.post(sets=[self.points] * 2, format="svg").body)
        self.assertEqual(root.tag, SVG + "svg")
        words = {text.text for text in root.iter(SVG + "text")}
        for expected in ("300 points, first of 2 sets", "Power spectrum", "Radially averaged power", "Anisotropy, dB",
                         "white noise", "isotropic"):
            self.assertIn(expected, words)
        dots = next(root.iter(SVG + "path")).get("d")
        self.assertEqual(dots.count("M"), 300)
        curves = [line.get("points").split() for line in root.iter(SVG + "polyline")]
        rings = len(self.analyze(points=self.points)["power"])
        self.assertEqual([len(curve) for curve in curves], [rings, rings])

    def test_are_identical_from_any_worker(self):
        body = json.dumps({"points": self.points})
        for kind in ("image/png", "image/svg+xml", "application/json"):
            with Server("--workers=4") as other:
                calls = [Call(server.url("/analyze"), "--header", f"Accept: {kind}", data=body)
                         for server in (self.server, other) for _ in range(4)]
                bodies = {call.answer().body for call in calls}
            self.assertEqual(len(bodies), 1, kind)


class Refusals(AnalyzeCase):
    flags = ("--max-sites=20000", "--timeout=1")

    def refuse(self, status, *words, **body):
        self.assert_problem(self.post(**body), status, *words)

    def test_400_names_the_member(self):
        good = noise(10).tolist()
        self.refuse(400, "points")
        self.refuse(400, "points", points=good, sets=[good])
        self.refuse(400, "/points/10", points=good + [[1]])
        self.refuse(400, "/sets/1/0", sets=[good, [[0, "0"]]])
        self.refuse(400, "/domain/type", points=good, domain={**TORUS, "type": "disc"})
        self.refuse(400, "/max_frequency", points=good, max_frequency=0)
        self.refuse(400, "/spectrum", points=good, spectrum="yes")
        self.refuse(400, "/format", points=good, format="csv")
        self.refuse(400, "iterations", points=good, iterations=5)
        self.assert_problem(self.ask("/analyze", data="{"), 400)
        self.assert_problem(self.ask("/analyze?format=png", data=json.dumps({"points": good})), 400)

    def test_405_406_415(self):
        answer = self.ask("/analyze")
        self.assert_problem(answer, 405)
        self.assertEqual(answer.headers["allow"], "POST, OPTIONS")
        self.assert_problem(self.post("--header", "Accept: text/csv", points=noise(10).tolist()), 406)
        self.assert_problem(self.ask("/analyze", "--header", "Content-Type: image/png", data="{}"), 415)

    def test_413_names_the_limit(self):
        self.refuse(413, "max-sites", "20000", sets=[noise(10001).tolist()] * 2)
        long, points = {"type": "rectangle", "width": 1e8, "height": 1}, noise(20000) * [1e8, 1]
        self.refuse(413, "/max_frequency", "536870912", points=points.tolist(), domain=long, max_frequency=16)

    def test_422_locates_points_that_cannot_be_analyzed(self):
        good = noise(10).tolist()
        self.refuse(422, "/points", points=good[:1])
        self.refuse(422, "/points/10", points=good + [[0.5, 1.01]])
        self.refuse(422, "/sets/2", sets=[good, good, good[:9]])
        self.refuse(422, "/sets/1/3", sets=[good, good[:3] + [[-1, 0]] + good[4:]])
        self.refuse(422, "/domain", points=good, domain={**TORUS, "width": 1e9})

    def test_504_ends_the_computation(self):
        # Each set takes little time, but 5,000 sets take longer than the timeout.
        sets = [noise(4, seed).tolist() for seed in range(5000)]
        self.refuse(504, "timeout", sets=sets, max_frequency=16, domain={**TORUS, "width": 1000})
        self.assertEqual(self.post(points=noise(100).tolist()).status, 200)


if __name__ == "__main__":
    unittest.main(verbosity=2)
