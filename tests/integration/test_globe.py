# SPDX-License-Identifier: GPL-3.0-or-later
"""POST /sample with coordinates=lonlat: equally many points per square kilometre everywhere, in round neighbourhoods.

PROJ computes areas and distances on the ground, by pyproj.
"""

import math
import unittest

import numpy
import pyproj
import shapely.geometry
import shapely.ops
import shapely.validation
import shapely.vectorized
from numpy.polynomial import legendre

from harness import ServerCase
from test_maps import features

GEOD = pyproj.Geod(ellps="WGS84")
SITES = 20_000

# From the equator to 83 degrees.
COUNTRIES = ("Gabon", "Colombia", "Thailand", "Egypt", "South Africa", "Argentina", "Sweden", "Norway", "Greenland",
             "Canada")


def box(west, south, east, north):
    return {"type": "Polygon", "coordinates": [[[west, south], [east, south], [east, north], [west, north],
                                                [west, south]]]}


def height(latitude):
    """Returns the square metres between the equator and a latitude, over one radian of longitude."""
    e = math.sqrt(GEOD.es)
    s = numpy.sin(numpy.radians(latitude))
    return GEOD.a ** 2 * (1 - e * e) / 2 * (s / (1 - (e * s) ** 2) + numpy.arctanh(e * s) / e)


def area_south_of(shape, latitude):
    """Returns the area south of a latitude, in square metres, of a valid shape in degrees with edges that are straight
    in degrees."""
    area = 0
    nodes, weights = legendre.leggauss(12)
    cut = shape.intersection(shapely.geometry.box(-181, -91, 181, latitude))
    for part in getattr(cut, "geoms", [cut]):
        if part.geom_type != "Polygon":
            continue
        part = shapely.geometry.polygon.orient(part)
        for ring in (part.exterior, *part.interiors):
            corners = numpy.array(ring.coords)
            a, b = corners[:-1], corners[1:]
            means = sum(w * height(a[:, 1] + (1 + t) / 2 * (b - a)[:, 1]) for t, w in zip(nodes, weights)) / 2
            area -= (means * numpy.radians((b - a)[:, 0])).sum()
    return area


def edges_of_bands(shape, bands):
    """Returns the latitudes between bands of equal area."""
    whole, edges = area_south_of(shape, 90), []
    for band in range(1, bands):
        low, high = shape.bounds[1], shape.bounds[3]
        for _ in range(30):
            middle = (low + high) / 2
            low, high = (middle, high) if area_south_of(shape, middle) < whole * band / bands else (low, middle)
        edges.append(low)
    return edges


def on_the_ground(a, b):
    return GEOD.inv(*a.T, *b.T)[2]


def in_the_plane(a, b):
    return numpy.hypot(*(a - b).T)


def nearest(answer, distance):
    """Returns the distance of each point to the nearest other point, which is always a neighbour in the
    triangulation."""
    points, triangles = numpy.array(answer["points"]), numpy.array(answer["triangles"])
    ends = numpy.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    a, b = ends[(ends < len(points)).all(axis=1)].T
    distances = distance(points[a], points[b])
    least = numpy.full(len(points), numpy.inf)
    numpy.minimum.at(least, a, distances)
    numpy.minimum.at(least, b, distances)
    return least[numpy.isfinite(least)]  # a point alone on its island has no other


def spacing(distances, pitch):
    """Returns the mean and the first percentile of distances, relative to the hexagonal distance."""
    over = distances / (pitch * math.sqrt(2 / math.sqrt(3)))
    return over.mean(), numpy.percentile(over, 1)


def plane(shape):
    """Returns the shape in an equal-area plane, in metres."""
    west, south, east, north = shape.bounds
    to_plane = pyproj.Proj(proj="laea", lat_0=(south + north) / 2, lon_0=(west + east) / 2, ellps="WGS84")
    moved = shapely.ops.transform(lambda x, y: to_plane(numpy.asarray(x), numpy.asarray(y)), shape)
    return moved.buffer(0)


class Globe(ServerCase):
    def ask_for(self, geometry, sites=SITES, **options):
        answer = self.sample(sites=sites, geometry=geometry, coordinates="lonlat", mesh=True, **options)
        points = numpy.array(answer["points"])
        self.assertEqual(points.shape, (sites, 2))
        self.assertEqual(len(numpy.unique(points, axis=0)), sites)
        self.assertTrue((numpy.abs(points) <= (180, 90)).all())
        return answer, points

    def spacing(self, answer):
        return spacing(nearest(answer, on_the_ground), answer["pitch_m"])

    def test_countries_are_even_on_the_ground(self):
        given = {each["properties"]["name"]: each["geometry"]
                 for each in features("world-atlas/countries-50m.json", "countries")}
        for name in COUNTRIES:
            with self.subTest(name=name):
                shape = shapely.validation.make_valid(shapely.geometry.shape(given[name]))
                answer, points = self.ask_for(given[name])
                self.assertTrue(shapely.vectorized.contains(shape, *points.T).all())
                self.assertAlmostEqual(answer["pitch_m"] ** 2 * SITES / area_south_of(shape, 90), 1, delta=1e-3)
                counts = numpy.histogram(points[:, 1], [-91, *edges_of_bands(shape, 10), 91])[0]
                self.assertLess(numpy.abs(counts / SITES * 10 - 1).max(), 0.02)
                flat = plane(shape)
                planar = self.sample(sites=SITES, geometry=shapely.geometry.mapping(flat), mesh=True)
                expected = spacing(nearest(planar, in_the_plane), math.sqrt(flat.area / SITES))
                for found, wanted in zip(self.spacing(answer), expected, strict=True):
                    self.assertAlmostEqual(found / wanted, 1, delta=0.02)

    def test_parts_cut_at_the_antimeridian_are_joined(self):
        cut = {"type": "MultiPolygon", "coordinates": [box(170, -20, 180, 20)["coordinates"],
                                                       box(-180, -20, -170, 20)["coordinates"]]}
        uncut = {"type": "Polygon", "coordinates": [[[170, -20], [-170, -20], [-170, 20], [170, 20]]]}
        for geometry in (cut, uncut, box(170, -20, 190, 20), box(-190, -20, -170, 20)):
            answer, points = self.ask_for(geometry, 4000)
            mean, least = self.spacing(answer)
            self.assertGreater(mean, 0.88)
            self.assertGreater(least, 0.8)
            self.assertAlmostEqual((points[:, 0] > 0).mean(), 0.5, delta=0.01)
            at_seam = points[numpy.abs(points[:, 0]) > 179]
            self.assertAlmostEqual(len(at_seam) / 4000, 0.1, delta=0.01)

    def test_poles_and_the_whole_globe(self):
        for geometry, expected in ((box(-180, -90, 180, -65), 0), (box(-180, 66, 180, 90), 1),
                                   (box(-180, -90, 180, 90), 0.5)):
            answer, points = self.ask_for(geometry, 4000)
            mean, least = self.spacing(answer)
            self.assertGreater(mean, 0.88)
            self.assertGreater(least, 0.8)
            self.assertAlmostEqual((points[:, 1] > 0).mean(), expected, delta=0.005)
            south, north = (corner[1] for corner in geometry["coordinates"][0][1:3])
            share = (height(points[:, 1]) - height(south)) / (height(north) - height(south))
            counts = numpy.histogram(share, 10, (0, 1))[0]
            # Sites form rows along a border, so a band at the border contains whole rows.
            self.assertLess(numpy.abs(counts / 400 - 1).max(), 0.07)

    def test_countries_joined_across_the_antimeridian_or_a_pole(self):
        given = {each["properties"]["name"]: each["geometry"]
                 for each in features("world-atlas/countries-50m.json", "countries")}
        # Millions of square kilometres.
        for name, area in (("Russia", 16.94), ("Fiji", 0.0183), ("Antarctica", 12.36)):
            answer, points = self.ask_for(given[name], 4000)
            self.assertAlmostEqual(answer["pitch_m"] ** 2 * 4000 / 1e12 / area, 1, delta=0.01)
            self.assertGreater(self.spacing(answer)[0], 0.87)
            if name == "Russia":
                east = points[points[:, 0] < 0]
                # The distance from the cape at -169.7 degrees is at most that of neighbouring sites, here 1.5 degrees.
                self.assertAlmostEqual(east[:, 0].max(), -169.7, delta=1.5)
                self.assertGreater(len(east), 20)

    def test_neighbourhoods_are_round(self):
        """A pattern has equal power in all directions where a degree of longitude is a third of a degree of
        latitude."""
        _, points = self.ask_for(box(0, 60, 60, 80), 40_000)
        to_plane = pyproj.Proj(proj="stere", lat_0=70.5, lon_0=30, ellps="WGS84")
        side = 600_000
        flat = numpy.stack(to_plane(*points.T), axis=1)
        inside = flat[(numpy.abs(flat) < side / 2).all(axis=1)]
        taper = numpy.cos(numpy.pi * inside / side).prod(axis=1) ** 2
        angles = numpy.arange(90) * math.pi / 90
        power = numpy.zeros(90)
        for frequency in numpy.linspace(0.8, 1.3, 26) * math.sqrt(len(inside)) / side:
            waves = 2 * math.pi * frequency * (inside @ numpy.stack([numpy.cos(angles), numpy.sin(angles)]))
            power += numpy.abs((taper[:, None] * numpy.exp(1j * waves)).sum(axis=0)) ** 2
        east, north = power[numpy.cos(2 * angles) > 0.5].mean(), power[numpy.cos(2 * angles) < -0.5].mean()
        self.assertAlmostEqual(east / north, 1, delta=0.2)

    def test_density_is_stretched_over_degrees(self):
        _, points = self.ask_for(box(0, 0, 40, 60), 4000, density={"width": 2, "height": 1, "values": [1, 3]})
        self.assertAlmostEqual((points[:, 0] > 20).mean(), 0.75, delta=0.01)
        share = height(points[:, 1]) / height(60)
        self.assertAlmostEqual((share > 0.5).mean(), 0.5, delta=0.01)


if __name__ == "__main__":
    unittest.main(verbosity=2)
