# SPDX-License-Identifier: GPL-3.0-or-later
"""POST /analyze: spectra, spacing and the plot."""

import io
import json
import pathlib
import tempfile
import unittest
import urllib.parse
import xml.etree.ElementTree

import numpy

from harness import DATA, Call, Server, ServerCase, post_json

TORUS = {"type": "torus", "width": 1, "height": 1}
SVG = "{http://www.w3.org/2000/svg}"


def noise(points, seed=1):
    return numpy.random.default_rng(seed).random((points, 2))


def power(points, *frequency):
    """Returns the periodogram on the unit torus at a frequency, computed by its definition."""
    return abs(numpy.exp(-2j * numpy.pi * (points @ frequency)).sum()) ** 2 / len(points)


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

    def test_spectrum_in_space_equals_its_definition(self):
        points = numpy.random.default_rng(2).random((60, 3))
        result = self.analyze(points=points.tolist(), spectrum=True)
        values = numpy.array(result["spectrum"]["values"]).reshape(result["spectrum"]["height"], -1)
        middle = numpy.array(values.shape) // 2
        for i, j in ((1, 0), (0, 1), (3, -7), (-4, 6)):
            self.assertAlmostEqual(values[middle[0] + j, middle[1] + i], power(points, i, j, 0), delta=1e-7)
        apart = numpy.abs(points[:, None] - points[None, :])
        squared = (numpy.minimum(apart, 1 - apart) ** 2).sum(axis=2) + 9 * numpy.eye(60)
        self.assertAlmostEqual(result["min_distance"], (squared.min() * 60 ** (2 / 3)) ** 0.5 / 2 ** (1 / 6), delta=1e-9)
        plot = self.post("--header", "Accept: image/png", points=points.tolist())
        self.assertEqual((plot.status, plot.type), (200, "image/png"))
        torus = {"type": "torus", "width": 1, "height": 1}
        problem = self.post(points=points.tolist(), domain=torus)
        self.assertEqual((problem.status, problem.json()["errors"][0]["pointer"]), (400, "/domain"))

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


class Surfaces(AnalyzeCase):
    SQUARE = "".join(f"v {x} {y} 7\n" for y in (0, 2) for x in (0, 2)) + "f 1 2 4 3\n"
    PLACES = numpy.column_stack([2 * noise(200), numpy.full(200, 7)])

    def form(self, points, *arguments, mesh=SQUARE):
        with tempfile.TemporaryDirectory() as folder:
            file, list_of_points = pathlib.Path(folder, "square.obj"), pathlib.Path(folder, "points")
            file.write_text(mesh, encoding="ascii")
            list_of_points.write_bytes(points)
            return self.ask("/analyze", "-F", f"mesh=@{file}", "-F", f"points=@{list_of_points}", *arguments)

    def measure(self, *arguments):
        answer = self.form(*arguments)
        self.assertEqual((answer.status, answer.type), (200, "application/json"), answer)
        return answer.json()

    def test_power_on_a_square_is_that_of_cosines(self):
        found = self.measure(json.dumps(self.PLACES.tolist()).encode(), "-F", "modes=3")
        x, y = numpy.pi * self.PLACES[:, 0] / 2, numpy.pi * self.PLACES[:, 1] / 2
        self.assertEqual(len(found["eigenvalues"]), 3)
        numpy.testing.assert_allclose(found["eigenvalues"], numpy.pi ** 2 / 4 * numpy.array([1, 1, 2]), rtol=0.1)
        numpy.testing.assert_allclose(found["frequency"], numpy.array([1, 1, 2]) ** 0.5 / 2 / 200 ** 0.5, rtol=0.05)
        # The first two modes have the same eigenvalue, so they may be any basis of their space.
        equal = 2 / 200 * (numpy.cos(x).sum() ** 2 + numpy.cos(y).sum() ** 2)
        self.assertAlmostEqual(sum(found["power"][:2]), equal, delta=0.1 * equal)
        last = 4 / 200 * (numpy.cos(x) * numpy.cos(y)).sum() ** 2
        self.assertAlmostEqual(found["power"][2], last, delta=0.1 + 0.1 * last)
        self.assertAlmostEqual(found["low_frequency_power"], numpy.mean(found["power"]))

    def test_distances_are_relative_to_the_densest_packing(self):
        found = self.measure(json.dumps(self.PLACES.tolist()).encode(), "-F", "modes=1")
        apart = numpy.linalg.norm(self.PLACES[:, None] - self.PLACES[None], axis=2)
        numpy.fill_diagonal(apart, numpy.inf)
        densest = (2 * 4 / (3 ** 0.5 * 200)) ** 0.5
        self.assertAlmostEqual(found["min_distance"], apart.min() / densest, places=6)
        self.assertAlmostEqual(found["mean_distance"], apart.min(axis=1).mean() / densest, places=6)

    def test_all_formats_of_points_give_the_same_answer(self):
        numbers, array = self.PLACES.tolist(), io.BytesIO()
        numpy.save(array, self.PLACES)
        table = "z,x,y\n" + "".join(f"{z!r},{x!r},{y!r}\n" for x, y, z in numbers)
        answers = {self.form(points, "-F", "modes=5").body
                   for points in (json.dumps(numbers).encode(), json.dumps({"points": numbers}).encode(),
                                  array.getvalue(), table.encode())}
        self.assertEqual(len(answers), 1)

    def test_a_mesh_as_the_body_has_its_options_in_the_query(self):
        points = urllib.parse.quote(json.dumps([[0, 0, 7], [2, 2, 7]]))
        answer = self.ask(f"/analyze?modes=4&points={points}", "-H", "Content-Type: model/obj", data=self.SQUARE)
        self.assertEqual(answer.status, 200, answer)
        self.assertEqual(len(answer.json()["power"]), 4)

    def test_sampled_points_are_more_even_than_random_ones(self):
        points = self.ask("/sample?sites=400", "-H", "Content-Type: model/obj", data=self.SQUARE).body
        self.assertGreater(self.measure(points)["min_distance"], 0.6)
        self.assertLess(self.measure(points)["low_frequency_power"], 0.1)

    def test_errors_name_the_field(self):
        good = json.dumps(self.PLACES.tolist()).encode()
        for arguments, status, word in (((b"[[1,2]]",), 400, "points"), ((b"x,y\n1,2\n",), 400, "points"),
                                        ((b"[[1,2,3]]",), 422, "points"), ((good, "-F", "modes=0"), 400, "modes"),
                                        ((good, "-F", "modes=501"), 400, "modes"),
                                        ((good, "-F", "domain={}"), 400, "domain")):
            with self.subTest(arguments=arguments):
                self.assert_problem(self.form(*arguments), status, word)
        self.assert_problem(self.form(good, mesh="v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"), 422)
        self.assert_problem(self.ask("/analyze", "-F", "points=[[1,2,3]]"), 400, "mesh")


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
