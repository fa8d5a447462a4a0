# SPDX-License-Identifier: GPL-3.0-or-later
"""POST /sample with counts of features: dot maps, mostly of the counties in npm's us-atlas.

The counts are invented; densities of neighbouring counties differ by factors up to 10,000.
"""

import base64
import io
import json
import math
import unittest

import numpy
import scipy.optimize
import scipy.spatial
import shapely
import shapely.geometry
import shapely.vectorized
from PIL import Image

from harness import POLYGONS, ServerCase, ask, post_json, wait_until
from test_maps import features, repaired_area

PER = 2000
FLAT = "Falls Church"  # quantized to a line


def collection(given):
    return {"type": "FeatureCollection", "features": given}


def counties():
    """Returns counties with counts that are independent of area: log-normal, from about 100 to about a million."""
    given = features("us-atlas/counties-10m.json", "counties")
    random = numpy.random.default_rng(1)
    for feature, count in zip(given, numpy.exp(random.normal(10.3, 1.45, len(given))), strict=True):
        feature["properties"]["people"] = int(count)
    return given


def hexagonal_spacing(density):
    return numpy.sqrt(2 / math.sqrt(3) / density)


def nearest(points, feature, density, pairs):
    """Returns the sorted nearest distances of points along chosen edges, divided by the mean hexagonal distance of the
    two features."""
    triangles = scipy.spatial.Delaunay(points).simplices
    edges = numpy.unique(numpy.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0)
    a, b = edges.T
    wanted = pairs(feature[a], feature[b])
    a, b = a[wanted], b[wanted]
    spacing = hexagonal_spacing(density)
    ratio = numpy.hypot(*(points[a] - points[b]).T) / (spacing[feature[a]] + spacing[feature[b]]) * 2
    least = numpy.full(len(points), 2.0)
    numpy.minimum.at(least, a, ratio)
    numpy.minimum.at(least, b, ratio)
    return numpy.sort(least[least < 2])


def error_in_rectangles(middles, errors):
    """Returns the root mean square of the sums of errors in random rectangles that cut each axis at ranks of places."""
    ranks = middles.argsort(axis=0).argsort(axis=0) / len(middles)
    ends = numpy.sort(numpy.random.default_rng(4).uniform(size=(1000, 2, 2)), axis=2)
    inside = ((ranks[:, None] >= ends[None, :, :, 0]) & (ranks[:, None] < ends[None, :, :, 1])).all(axis=2)
    return math.sqrt(numpy.mean((errors @ inside) ** 2))


class Counties(ServerCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.features = counties()
        body = {"geometry": collection(cls.features), "sites": {"property": "people", "per": PER}}
        cls.answer = post_json(cls.server, "/sample", body).json()
        cls.points = numpy.array(cls.answer["points"])
        cls.feature = numpy.array(cls.answer["feature"])
        cls.areas = [repaired_area(each["geometry"]) for each in cls.features]

    def test_have_exactly_their_counts(self):
        quotas = numpy.array([each["properties"]["people"] / PER for each in self.features])
        counts = numpy.array([each["sites"] for each in self.answer["features"]])
        flat = next(i for i, each in enumerate(self.features) if each["properties"]["name"] == FLAT)
        self.assertGreater(quotas[flat], 0.5)
        warning = self.answer["warnings"][0]
        self.assertTrue(warning["pointer"].startswith(f"/geometry/features/{flat}/"), warning)
        self.assertIn(f"{round(quotas[flat])} point", warning["detail"])
        quotas[flat] = 0
        self.assertLess(numpy.abs(counts - quotas).max(), 1)
        self.assertEqual(counts.sum(), round(quotas.sum()))
        self.assertEqual(numpy.bincount(self.feature, minlength=len(counts)).tolist(), counts.tolist())
        self.assertEqual([each["id"] for each in self.answer["features"]], [each["id"] for each in self.features])
        self.assertEqual(len(numpy.unique(self.points, axis=0)), counts.sum())

    def test_have_their_sums_in_every_region(self):
        quotas = numpy.array([each["properties"]["people"] / PER for each in self.features])
        counts = numpy.bincount(self.feature, minlength=len(self.features))
        used = [each["properties"]["name"] != FLAT for each in self.features]
        middles = numpy.array([self.areas[i].centroid.coords[0] for i in numpy.flatnonzero(used)])
        self.assertLess(error_in_rectangles(middles, (counts - quotas)[used]), 2.5)

    def test_contain_their_points(self):
        ends = numpy.searchsorted(self.feature, numpy.arange(len(self.features) + 1))
        for i, area in enumerate(self.areas):
            own = self.points[ends[i]:ends[i + 1]]
            if len(own) > 0:
                self.assertTrue(shapely.vectorized.contains(area, *own.T).all(), self.features[i]["properties"]["name"])

    def test_keep_distance_within_and_across_borders(self):
        counts = numpy.bincount(self.feature, minlength=len(self.features))
        density = counts / numpy.maximum([area.area for area in self.areas], 1e-9)
        density = numpy.maximum(density, 1e-9)
        within = nearest(self.points, self.feature, density, lambda a, b: a == b)
        self.assertGreater(within[len(within) // 100], 0.75)

        def alike(a, b):
            return (a != b) & (numpy.abs(numpy.log(density[a] / density[b])) < math.log(4))

        across = nearest(self.points, self.feature, density, alike)
        self.assertGreater(len(across), 20_000)
        self.assertGreater(across[len(across) // 100], 0.6)


def cells(counts, width=20):
    """Returns square cells in rows from the south, with a count each."""
    return [{"type": "Feature", "properties": {"n": count, "column": i % width},
             "geometry": shapely.geometry.mapping(
                 shapely.geometry.box(i % width, i // width, i % width + 1, i // width + 1))}
            for i, count in enumerate(counts)]


class SmallCounts(ServerCase):
    """Maps on which most features have less than one point."""

    def counts(self, given, per, **options):
        answer = post_json(self.server, "/sample", {
            "geometry": collection(given), "sites": {"property": "n", "per": per}, "quality": "draft", **options})
        self.assertEqual(answer.status, 200, answer)
        return numpy.array([each["sites"] for each in answer.json()["features"]])

    def test_have_their_sums_in_quarters_and_sides(self):
        for options in ({}, {"coordinates": "lonlat"}):
            with self.subTest(**options):
                counts = self.counts(cells(400 * [2]), 5, **options).reshape(20, 20)
                self.assertEqual(counts.reshape(4, -1).sum(axis=1).tolist(), 4 * [40])
                counts = self.counts(cells(20 * (10 * [1] + 10 * [4])), 10, **options).reshape(20, 20)
                self.assertEqual([counts[:, :10].sum(), counts[:, 10:].sum()], [20, 80])

    def test_do_not_depend_on_the_order_of_features(self):
        given = cells(numpy.random.default_rng(6).integers(0, 9, 400).tolist())
        counts = self.counts(given, 10)
        order = numpy.random.default_rng(7).permutation(400)
        self.assertEqual(self.counts([given[i] for i in order], 10).tolist(), counts[order].tolist())

    def test_have_their_sums_across_the_antimeridian(self):
        given = cells(400 * [1])
        for each in given:
            east = 170 if each["properties"]["column"] < 10 else -190
            each["geometry"]["coordinates"] = [[[x + east, y] for x, y in each["geometry"]["coordinates"][0]]]
        counts = self.counts(given, 8, coordinates="lonlat").reshape(20, 20)
        self.assertEqual(counts.sum(), 50)
        self.assertLessEqual(abs(counts[:, 5:15].sum() - 25), 2)

    def test_are_spread_evenly(self):
        given = cells(3600 * [1], 60)
        row, column = numpy.nonzero(self.counts(given, 10).reshape(60, 60))
        near, _ = scipy.spatial.cKDTree(numpy.column_stack((row, column))).query(numpy.column_stack((row, column)), 2)
        self.assertGreater(near[:, 1].mean(), 0.7 * hexagonal_spacing(0.1))  # 0.47 for random cells

    def test_have_their_sums_in_irregular_areas(self):
        random = numpy.random.default_rng(8)
        places = random.uniform(0, 1, (3000, 2))
        mirrored = [places, *(places * sign + shift for sign, shift in (
            ((-1, 1), (0, 0)), ((-1, 1), (2, 0)), ((1, -1), (0, 0)), ((1, -1), (0, 2))))]
        diagram = scipy.spatial.Voronoi(numpy.concatenate(mirrored))
        rings = [diagram.vertices[diagram.regions[diagram.point_region[i]]] for i in range(3000)]
        people = numpy.exp(random.normal(5, 1.45, (3000, 2))).round()
        given = [{"type": "Feature", "properties": {"a": own[0], "b": own[1]},
                  "geometry": {"type": "Polygon", "coordinates": [[*ring.tolist(), ring[0].tolist()]]}}
                 for own, ring in zip(people, rings, strict=True)]
        answer = post_json(self.server, "/sample", {"geometry": collection(given), "classes": ["a", "b"], "per": 1000,
                                                    "quality": "draft"}).json()
        feature, number = numpy.array(answer["feature"]), numpy.array(answer["class"])
        middles = numpy.array([ring.mean(axis=0) for ring in rings])
        errors = [numpy.bincount(feature[number == i], minlength=3000) - people[:, i] / 1000 for i in range(2)]
        for own in errors:
            self.assertLess(numpy.abs(own).max(), 1)
            self.assertLessEqual(abs(own.sum()), 0.5)
            self.assertLess(error_in_rectangles(middles, own), 2.2)
        self.assertLess(error_in_rectangles(middles, sum(errors)), 2.6)


class Formats(ServerCase):
    MAP = collection([
        {"type": "Feature", "id": "west", "properties": {"a": 30, "b": 10},
         "geometry": {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]]}},
        {"type": "Feature", "properties": {"a": "20", "b": None},
         "geometry": {"type": "Polygon", "coordinates": [[[1, 0], [2, 0], [2, 1], [1, 1], [1, 0]]]}}])

    def draw(self, **options):
        answer = post_json(self.server, "/sample", {"geometry": self.MAP, "classes": ["a", "b"], **options})
        self.assertEqual(answer.status, 200, answer)
        return answer

    def test_have_the_same_content(self):
        answer = self.draw().json()
        rows = [[*point, feature, number]
                for point, feature, number in zip(answer["points"], answer["feature"], answer["class"], strict=True)]
        self.assertEqual([row[2:] for row in rows], 30 * [[0, 0]] + 20 * [[1, 0]] + 10 * [[0, 1]])
        self.assertEqual(numpy.load(io.BytesIO(self.draw(format="npy").body)).tolist(), rows)
        lines = self.draw(format="csv").body.decode().split("\r\n")
        self.assertEqual(lines[0], "x,y,feature,class")
        self.assertEqual([[float(x), float(y), int(feature), "ab".index(name)]
                          for x, y, feature, name in (line.split(",") for line in lines[1:-1])], rows)
        drawn = self.draw(format="geojson").json()
        self.assertEqual([(each.get("id"), each["properties"]["feature"], each["properties"]["class"])
                          for each in drawn["features"]], [("west", 0, "a"), (None, 1, "a"), ("west", 0, "b")])
        self.assertEqual([point for each in drawn["features"] for point in each["geometry"]["coordinates"]],
                         answer["points"])
        self.assertIn("X-Warnings".lower(), self.draw(format="svg").headers)

    def test_use_the_colours_of_classes(self):
        colours = {tuple(int(each["color"][i:i + 2], 16) for i in (1, 3, 5)) for each in self.draw().json()["classes"]}
        picture = self.draw(format="png").picture("RGB")
        found = {tuple(colour) for colour in numpy.asarray(picture).reshape(-1, 3).tolist()}
        self.assertLessEqual(colours | {(255, 255, 255)}, found)


class Exclusions(ServerCase):
    def test_keep_the_counts(self):
        given = [{"type": "Feature", "properties": {"n": 400 + 300 * i},
                  "geometry": shapely.geometry.mapping(shapely.geometry.box(i % 2, i // 2, i % 2 + 1, i // 2 + 1))}
                 for i in range(4)]
        lake = shapely.geometry.Point(1, 1).buffer(0.4)
        picture = numpy.full((64, 64), 255, numpy.uint8)
        picture[8:24, 8:24] = 0
        image = io.BytesIO()
        Image.fromarray(picture).save(image, "PNG")
        dark = shapely.geometry.box(0.25, 1.25, 0.75, 1.75)
        wells = numpy.random.default_rng(2).uniform(0, 2, (50, 2))
        for coordinates, buffer in (("plane", 0.1), ("lonlat", 10_000)):
            with self.subTest(coordinates=coordinates):
                answer = post_json(self.server, "/sample", {
                    "geometry": collection(given), "sites": "n", "coordinates": coordinates, "buffer": buffer,
                    "avoid": shapely.geometry.mapping(lake), "fixed": wells.tolist(),
                    "exclude": {"image": base64.b64encode(image.getvalue()).decode()}}).json()
                self.assertEqual([each["sites"] for each in answer["features"]], [400, 700, 1000, 1300])
                points = numpy.array(answer["points"])
                degrees = 0.1 if coordinates == "plane" else buffer / 111_500
                left = shapely.geometry.box(0, 0, 2, 2).difference(lake).difference(dark).buffer(-0.99 * degrees)
                self.assertTrue(shapely.vectorized.contains(left, *points.T).all())
                near, _ = scipy.spatial.cKDTree(points).query(wells)
                self.assertGreater(near.min(), 0.5 * hexagonal_spacing(1300 / left.area * 4))
                # The lake is subtracted from each feature separately, but no strip remains between the features.
                for across in points.T:
                    self.assertGreater((numpy.abs(across - 1) < 0.01).sum(), 10)


def cut(area, share, upright):
    """Returns the part of an area on one side of a line that contains a given share of it, and the rest."""
    west, south, east, north = area.bounds
    low, high = (west, east) if upright else (south, north)

    def below(line):
        return area.intersection(shapely.geometry.box(west, south, line, north) if upright
                                 else shapely.geometry.box(west, south, east, line))

    part = below(scipy.optimize.brentq(lambda line: below(line).area / area.area - share, low, high, xtol=1e-12))
    return part, area.difference(part)


def pieces_of(area, shares, upright):
    pieces = []
    for i in range(len(shares) - 1):
        part, area = cut(area, shares[i] / sum(shares[i:]), upright)
        pieces.append(part)
    return [*pieces, area]


class Undivided(ServerCase):
    SITES = 8192

    def test_pieces_have_no_more_long_waves_than_the_whole(self):
        """Cuts a country into pieces that want a whole number of points each."""
        country = json.loads((POLYGONS / "South-Africa-50m.geojson").read_text())
        country = country.get("geometry", country)
        whole = max(getattr(shapely.geometry.shape(country), "geoms", [shapely.geometry.shape(country)]),
                    key=lambda part: part.area)
        counts = [(800, 838), (819, 819), (700, 938), (900, 738), (820, 820)]
        columns = pieces_of(whole, [sum(each) for each in counts], True)
        given = [{"type": "Feature", "properties": {"points": count}, "geometry": shapely.geometry.mapping(piece)}
                 for column, each in zip(columns, counts, strict=True)
                 for count, piece in zip(each, pieces_of(column, each, False), strict=True)]
        self.assertEqual(sum(map(sum, counts)), self.SITES)
        pitch = math.sqrt(whole.area / self.SITES)
        for quality in ("standard", "best"):
            sets = [[self.points(**request, quality=quality, seed=seed) for seed in range(3)] for request in (
                {"geometry": collection(given), "sites": "points"},
                {"geometry": shapely.geometry.mapping(whole), "sites": self.SITES})]
            for pitches in (1, 2, 4):
                with self.subTest(quality=quality, pitches=pitches):
                    noise, least = (sum(self.noise(points, whole, pitches * pitch) for points in each)
                                    for each in sets)
                    self.assertLess(10 * math.log10(noise / least), {"standard": 3, "best": 9}[quality])

    def points(self, **body):
        return numpy.array(post_json(self.server, "/sample", body).json()["points"])

    def noise(self, points, whole, radius):
        """Returns the mean squared error of the number of points, weighted by Gaussians far from the border, relative
        to that of independent points."""
        inner = whole.buffer(-3.5 * radius)
        west, south, east, north = inner.bounds
        places = numpy.random.default_rng(5).uniform((west, south), (east, north), (3000, 2))
        places = places[shapely.vectorized.contains(inner, *places.T)]
        near = scipy.spatial.cKDTree(points).query_ball_point(places, 4.5 * radius)
        sums = [numpy.exp(-((points[each] - place) ** 2).sum(1) / 2 / radius ** 2).sum()
                for place, each in zip(places, near, strict=True)]
        due = len(points) / whole.area * math.pi * radius ** 2
        return numpy.mean((numpy.array(sums) - 2 * due) ** 2) / due


class Jobs(ServerCase):
    def test_report_progress_and_can_be_cancelled(self):
        body = json.dumps({"geometry": Formats.MAP, "sites": {"property": "a", "per": 0.0002}, "iterations": 1000,
                           "passes": 100})
        job = ask(self.server, "/sample", "--header", "Prefer: respond-async", data=body).headers["location"]
        wait_until(lambda: ask(self.server, job).json().get("progress", 0) > 0)
        self.assertIn(ask(self.server, job, "--request", "DELETE").status, (200, 202, 204))
        wait_until(lambda: ask(self.server, job).json()["status"] != "running")


if __name__ == "__main__":
    unittest.main()
