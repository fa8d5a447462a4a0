# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects of other libraries, in and out. Classes of libraries that the tests do not need have stand-ins."""

import datetime
import decimal
import json

import ccdt
import numpy as np
import pyproj
import pytest
import shapely.geometry

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
    feature = json.loads(points.write("geojson"))["features"][0]
    assert {name: feature["properties"][name] for name in columns} == {"count": 10, "day": "2020-01-02", "cost": "1.5"}
