# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects of other libraries, in and out. Classes of libraries that the tests do not need have stand-ins."""

import datetime
import decimal
import io
import json
import math
import random
import sys
import types

import ccdt
import matplotlib.figure
import numpy as np
import pyproj
import pytest
import scipy.spatial
import shapely.geometry
from ccdt.domains import jsonable
from PIL import Image

EARTH_RADIUS = 6378137
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]


DEGREES, METRES = (pyproj.CRS.from_epsg(code) for code in (4326, 3035))


class Frame:
    """Stands in for geopandas.GeoDataFrame."""

    def __init__(self, boxes, crs=None, **columns):
        self.crs = crs
        features = [{"type": "Feature", "properties": {name: values[i] for name, values in columns.items()},
                     "geometry": shapely.geometry.mapping(shapely.geometry.box(*each))}
                    for i, each in enumerate(boxes)]
        self.__geo_interface__ = {"type": "FeatureCollection", "features": features}


TALL = [(0, 40, 1, 60), (1.5, 40, 2.5, 60)]


def test_frames_in_degrees_are_sampled_on_the_ground(recwarn):
    points = ccdt.sample(Frame(TALL, DEGREES), 500)
    assert np.array_equal(points, ccdt.sample(Frame(TALL), 500, coordinates="lonlat"))
    assert np.median(points[:, 1]) < 49.5 and not recwarn.list
    plane = ccdt.sample(Frame(TALL, METRES), 500)
    assert np.median(plane[:, 1]) > 49.5 and not recwarn.list
    with pytest.warns(ccdt.Warning, match="reference system WGS 84"):
        assert np.array_equal(ccdt.sample(Frame(TALL, DEGREES), 500, coordinates="plane"), plane)


def test_columns_may_have_any_type():
    columns = {"count": [np.int64(10), float("nan")], "day": [datetime.date(2020, 1, 2), None],
               "cost": [decimal.Decimal("1.5"), np.float32(2)]}
    with pytest.warns(ccdt.Warning, match="null: this counts as 0"):
        points = ccdt.sample(Frame(TALL, METRES, **columns), "count", properties="*")
    assert len(points) == 10
    ccdt.sample([[0, 30], [9, 30], [0, 70]], 5, avoid=Frame(TALL[:1], day=[datetime.date(2020, 1, 2)]))
    feature = json.loads(points.write("geojson"))["features"][0]
    assert {name: feature["properties"][name] for name in columns} == {"count": 10, "day": "2020-01-02", "cost": "1.5"}


def test_seeds_are_drawn_from_generators():
    def twice(make):
        """Returns the results of two seeds of one generator, and of the first seed of an equal one."""
        generator, equal = make(), make()
        return [ccdt.sample(SQUARE, 20, seed=each).tolist() for each in (generator, generator, equal)]

    for make in (lambda: np.random.default_rng(5), lambda: np.random.RandomState(5), lambda: random.Random(5)):
        first, second, again = twice(make)
        assert first == again and first != second
    seed = int(np.random.default_rng(5).integers(2**53))
    assert np.array_equal(ccdt.sample(SQUARE, 20, seed=seed), ccdt.sample(SQUARE, 20, seed=np.random.default_rng(5)))
    assert np.array_equal(ccdt.mask(8, seed=seed), ccdt.mask(8, seed=np.random.default_rng(5)))
    picture = np.zeros((8, 8), np.uint8)
    assert (ccdt.halftone(picture, 20, seed=seed).write()
            == ccdt.halftone(picture, 20, seed=np.random.default_rng(5)).write())


class Table:
    """Stands in for pandas.DataFrame, whose columns are attributes."""

    def __init__(self, **columns):
        self.columns = list(columns)
        self.__dict__.update(columns)

    def __array__(self, dtype=None):
        return np.column_stack([getattr(self, name) for name in self.columns]).astype(dtype)


def test_tables_are_positions():
    corners = np.array(SQUARE, float)
    points = ccdt.sample(Table(n=np.zeros(4), y=corners[:, 1], x=corners[:, 0]), 30, fixed=Table(a=[0.5], b=[0.25]))
    assert np.array_equal(points, ccdt.sample(SQUARE, 30, fixed={"type": "Point", "coordinates": [0.5, 0.25]}))
    assert np.array_equal(points, ccdt.sample(SQUARE, 30, fixed=[[0.5, 0.25]]))
    x, y = points.T
    assert ccdt.analyze(Table(x=x, y=y), ccdt.Rectangle()).power.tolist() \
        == ccdt.analyze(np.asarray(points), ccdt.Rectangle()).power.tolist()
    solid = ccdt.sample(ccdt.Box(), 30)
    x, y, z = solid.T
    assert ccdt.analyze(Table(x=x, y=y, z=z), ccdt.Box()).power.tolist() == ccdt.analyze(solid).power.tolist()


CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
SQUARE_IN_SPACE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def test_meshes_of_other_libraries_are_surfaces():
    expected = ccdt.sample(ccdt.Mesh(CORNERS, FACES), 40)
    counted = np.column_stack([np.full(4, 3), FACES]).ravel()
    for mesh in (types.SimpleNamespace(vertices=CORNERS, faces=FACES),
                 types.SimpleNamespace(vertices=CORNERS.tolist(), triangles=FACES.tolist(), vertex_colors=[]),
                 types.SimpleNamespace(points=CORNERS, faces=counted)):
        points = ccdt.sample(mesh, 40)
        assert np.array_equal(points, expected) and points.colors is None
        assert np.array_equal(ccdt.sample(ccdt.Solid(mesh), 10), ccdt.sample(ccdt.Solid(ccdt.Mesh(CORNERS, FACES)), 10))
        assert ccdt.analyze(np.asarray(points), mesh, modes=5).power.tolist() == ccdt.analyze(points, modes=5).power.tolist()
    colors = np.full((4, 4), 200, np.uint8)
    visual = types.SimpleNamespace(kind="vertex", vertex_colors=colors)
    assert (ccdt.sample(types.SimpleNamespace(vertices=CORNERS, faces=FACES, visual=visual), 9).colors == 200).all()
    painted = types.SimpleNamespace(vertices=CORNERS, triangles=FACES, vertex_colors=colors[:, :3] / 255)
    assert (ccdt.sample(painted, 9).colors == 200).all()
    with pytest.raises(ccdt.Error, match="triangulate"):
        ccdt.sample(types.SimpleNamespace(points=CORNERS, faces=np.array([4, 0, 1, 2, 3])), 5)


def test_triangulations_of_scipy_are_their_hulls(recwarn):
    places = np.random.default_rng(1).random((30, 3))
    for hull in (scipy.spatial.Delaunay, scipy.spatial.ConvexHull):
        flat = hull(places[:, :2])
        points = ccdt.sample(flat, 50)
        assert points.shape == (50, 2)
        border = shapely.geometry.MultiPoint(places[:, :2]).convex_hull
        assert all(border.contains(shapely.geometry.Point(point)) for point in points)
        inside = ccdt.sample(hull(places), 50)
        assert isinstance(inside, ccdt.VolumePoints)
        assert (scipy.spatial.Delaunay(places).find_simplex(inside) >= 0).all()
    assert not recwarn.list
    grid = np.column_stack([places[:, :2], np.zeros(30)])
    triangulation = scipy.spatial.Delaunay(places[:, :2])
    assert np.array_equal(ccdt.sample(ccdt.Mesh(grid, triangulation), 20),
                          ccdt.sample(ccdt.Mesh(grid, triangulation.simplices), 20))


@pytest.mark.parametrize(("domain", "density", "means"), [
    ([[1, 1], [3, 1], [3, 2], [1, 2]], lambda x, y: x - 1, (1 + 4 / 3, 1.5)),
    ([[1, 1], [3, 1], [3, 2], [1, 2]], lambda x, y: math.sqrt(x - 1), (2.2, 1.5)),
    (ccdt.Torus(2, 1), lambda x, y: x, (4 / 3, 0.5)),
    (shapely.geometry.MultiPolygon([shapely.geometry.box(0, 0, 1, 3)]), lambda x, y: 1 + 0 * y, (0.5, 1.5)),
    (ccdt.Box(2, 1, 3), lambda x, y, z: z, (1, 0.5, 2)),
    (ccdt.Solid(ccdt.Mesh(CORNERS, FACES)), lambda x, y, z: z, (0.2, 0.2, 0.4)),
    (ccdt.Mesh(SQUARE_IN_SPACE, [[0, 1, 2], [0, 2, 3]]), lambda x, y, z: x, (2 / 3, 0.5, 0)),
], ids=["polygon", "numbers", "torus", "shapely", "box", "solid", "mesh"])
def test_functions_are_densities(domain, density, means):
    points = ccdt.sample(domain, 2000, density=density)
    assert np.allclose(points.mean(axis=0), means, atol=0.01)


def test_functions_see_the_pixels():
    chosen = ccdt.sample(ccdt.Pixels(20, 10), 50, density=lambda x, y: (y > 3) & (x < 10.5))
    assert chosen[3:, :10].sum() == 50


@pytest.mark.parametrize(("domain", "density", "text"), [
    ({"type": "Topology"}, lambda x, y: x, "neither polygons nor a Mesh"),
    (Frame([(-170, 0, 170, 9)], DEGREES), lambda x, y: x, "wider than 180"),
    (SQUARE, lambda x, y: x - 2, "at least 0"),
], ids=["topology", "globe", "negative"])
def test_functions_that_cannot_be_densities_are_refused(domain, density, text):
    with pytest.raises(ccdt.Error, match=text):
        ccdt.sample(domain, 5, density=density)


class Raster:
    """Stands in for xarray.DataArray and for a dataset of rasterio."""

    values = np.array([[np.nan, 4], [0, 1]])  # the first row is at the top


class DataArray(Raster):
    dims = ("band", "y", "x")
    coords = {"y": np.array([1.75, 1.25]), "x": np.array([1.5, 2.5])}

    def __getitem__(self, name):
        return self.coords[name]

    def __array__(self, dtype=None):
        return self.values[None]


class Dataset(Raster):
    transform = (1, 0, 1, 0, -0.5, 2)

    def read(self, band, masked):
        assert band == 1 and masked
        return np.ma.masked_invalid(self.values)


@pytest.mark.parametrize("raster", [DataArray(), Dataset()], ids=["xarray", "rasterio"])
def test_rasters_are_densities_at_their_coordinates(raster):
    points = ccdt.sample([[1, 1], [3, 1], [3, 2], [1, 2]], 1000, density=raster)
    assert np.histogram2d(*points.T, bins=2, range=[[1, 3], [1, 2]])[0].tolist() == [[0, 0], [200, 800]]
    part = ccdt.sample([[2, 1.5], [5, 1.5], [5, 3], [2, 3]], 100, density=raster)
    assert (part[:, 0] <= 3).all() and (part[:, 1] <= 2).all()


def test_web_mercator_is_even_on_the_ground():
    ends = EARTH_RADIUS * np.arcsinh(np.tan(np.radians([40, 60])))
    frame = Frame([(0, ends[0], 100_000, ends[1])], pyproj.CRS.from_epsg(3857))
    points = ccdt.sample(frame, 1000)
    shares = (np.tanh(points[:, 1] / EARTH_RADIUS) - np.sin(np.radians(40))) / np.ptp(np.sin(np.radians([40, 60])))
    assert abs(shares.mean() - 0.5) < 0.005 and abs(shares.std() - 12**-0.5) < 0.005
    assert np.median(ccdt.sample(frame, 1000, coordinates="plane")[:, 1]) == pytest.approx(ends.mean(), rel=0.005)


def test_points_are_a_geometry():
    points = ccdt.sample(SQUARE, 20)
    assert np.array_equal([each.coords[0] for each in shapely.geometry.shape(points).geoms], points)
    assert not hasattr(points[:5], "__geo_interface__")
    assert jsonable(points) == points.tolist()


def test_points_become_a_frame(monkeypatch):
    """GeoPandas has a stand-in that returns its arguments."""
    pandas = types.SimpleNamespace(GeoDataFrame=lambda columns, **rest: {**columns, **rest},
                                   points_from_xy=lambda *axes: np.column_stack(axes))
    monkeypatch.setitem(sys.modules, "geopandas", pandas)
    points = ccdt.sample(Frame(TALL, METRES, count=[3, 4]), "count", order="progressive")
    frame = points.to_geodataframe()
    assert frame["crs"] == METRES and np.array_equal(frame["geometry"], points)
    assert frame["feature"].tolist() == points.features.tolist() and sorted(frame["rank"]) == list(range(7))
    degrees = ccdt.sample(Frame(TALL), 5, coordinates="lonlat").to_geodataframe()
    assert set(degrees) == {"geometry", "crs"} and degrees["crs"] == "EPSG:4326"
    space = ccdt.sample(ccdt.Mesh(CORNERS, FACES), 9).to_geodataframe()
    assert set(space) == {"faces", "geometry", "crs"} and space["geometry"].shape == (9, 3) and space["crs"] is None


def test_results_are_pictures_as_arrays(ramp):
    halftone = ccdt.halftone(ramp, 60, scale=2)
    assert np.array_equal(np.asarray(halftone), halftone.image())
    assert np.asarray(halftone, dtype=float).dtype == np.float64
    device = ccdt.halftone(ramp, device="gray4")
    assert np.array_equal(np.asarray(device), device.image())


def test_results_are_plotted(ramp):
    def axes(projection=None):
        return matplotlib.figure.Figure().add_subplot(projection=projection)

    halftone = ccdt.halftone(ramp, 60, scale=2)
    [image] = halftone.plot(axes()).images
    assert np.array_equal(image.get_array(), halftone.image()) and tuple(image.get_extent()) == (0, 64, 48, 0)
    points = ccdt.sample(SQUARE, 20)
    [dots] = points.plot(axes(), c="red").collections
    assert np.array_equal(dots.get_offsets(), points)
    analysis = ccdt.analyze(points, ccdt.Rectangle())
    [curve] = analysis.plot(axes(), label="dots").lines
    assert np.array_equal(curve.get_ydata(), analysis.power) and curve.get_label() == "dots"
    surface = ccdt.sample(ccdt.Mesh(CORNERS, FACES), 50)
    assert len(surface.plot(axes("3d")).collections) == len(ccdt.analyze(surface, modes=5).plot(axes()).lines) == 1


@pytest.mark.parametrize("domain", [ccdt.Box(2, 1, 1), ccdt.Mesh(SQUARE_IN_SPACE, [[0, 1, 2], [0, 2, 3]])], ids=str)
def test_notebooks_show_points_in_space(domain, monkeypatch):
    points = ccdt.sample(domain, 50)
    picture = np.asarray(Image.open(io.BytesIO(points._repr_png_())).convert("L"))
    assert (picture < 128).sum() > 50
    assert points.copy()._repr_png_() is None
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert points._repr_png_() is None
