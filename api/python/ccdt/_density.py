# SPDX-License-Identifier: GPL-3.0-or-later
"""Densities that are functions, or rasters with coordinates, as arrays over the bounding box of a domain."""

from __future__ import annotations

from typing import Any, Callable, Iterator, List, Mapping, Tuple

import numpy as np
import numpy.typing as npt

from .domains import Box, Mesh, Pixels, Rectangle, Solid, Torus, is_in_space
from .errors import Error

_ma: Any = np.ma  # its functions have no types

Floats = npt.NDArray[np.float64]
Bounds = List[Tuple[float, float]]  # least and greatest value of each coordinate

CELLS_OF_LONGER_SIDE = {2: 512, 3: 64}  # of the array for a function, by the number of coordinates
MAX_CELLS = 2048  # of a side of the array for a raster

EARTH_RADIUS = 6378137.0  # metres, of Web Mercator


class Raster:
    """A function that returns the values of a raster with coordinates: the value of the nearest cell, or 0 outside.

    Attributes:
        size: width and height of a cell.
    """

    def __init__(self, values: Any, x: Any, y: Any) -> None:
        values = _ma.masked_invalid(values)
        if values.ndim != 2 or min(values.shape) < 2:
            raise Error(f"density must be a raster with at least 2 rows and 2 columns, not {list(values.shape)}",
                        field="density")
        order = np.ix_(np.argsort(y), np.argsort(x))
        self._values = values.filled(0)[order]
        self._axes = np.sort(x), np.sort(y)
        self.size = tuple(float(np.median(np.diff(axis))) for axis in self._axes)

    def __call__(self, x: Floats, y: Floats) -> Floats:
        inside = np.ones(np.broadcast_shapes(x.shape, y.shape), bool)
        indices = []
        for axis, places, size in zip(self._axes, (x, y), self.size):
            indices.append(np.searchsorted((axis[1:] + axis[:-1]) / 2, places))
            inside &= (places >= axis[0] - size / 2) & (places <= axis[-1] + size / 2)
        return np.where(inside, self._values[indices[1], indices[0]], 0)


def _raster_of(density: Any) -> Any:
    """Returns a DataArray of xarray or a dataset of rasterio as a Raster; otherwise the density."""
    dims = getattr(density, "dims", ())
    if isinstance(dims, tuple) and len(dims) > 1 and all(name in density.coords for name in dims[-2:]):
        rows, columns = dims[-2:]
        values = np.asarray(density)
        return Raster(values.reshape(values.shape[-2:]) if values[..., 0, 0].size == 1 else values,
                      np.asarray(density[columns]), np.asarray(density[rows]))
    if hasattr(density, "transform") and hasattr(density, "read"):
        values = density.read(1, masked=True)
        step_x, turn_x, left, turn_y, step_y, top = tuple(density.transform)[:6]
        if turn_x != 0 or turn_y != 0:
            raise Error("density must be a raster whose rows are parallel to the x axis", field="density")
        return Raster(values, left + step_x * (np.arange(values.shape[1]) + 0.5),
                      top + step_y * (np.arange(values.shape[0]) + 0.5))
    return density


def density_of(density: Any, domain: Any, members: Mapping[str, Any]) -> Any:
    """Returns a density that is a function or a raster as an array; otherwise the density.

    Args:
        members: members of the request that give its area, as from region_members().
    """
    if not (is_in_space(domain) or isinstance(domain, (Mesh, Pixels))):
        density = _raster_of(density)
    if not callable(density):
        return density
    if isinstance(domain, Mesh):
        return _values(density, list(np.asarray(domain.vertices, np.float64).T))
    bounds = _bounds(domain, members)
    if members.get("coordinates") == "lonlat" and bounds[0][1] - bounds[0][0] > 180:
        raise Error("density must be an array for maps on the earth that are wider than 180 degrees", field="density")
    sides = [high - low for low, high in bounds]
    if isinstance(domain, Pixels):
        counts = [domain.width, domain.height]
    elif isinstance(density, Raster):
        counts = [max(1, min(MAX_CELLS, round(side / size))) for side, size in zip(sides, density.size)]
    else:
        longest = CELLS_OF_LONGER_SIDE[len(sides)]
        counts = [max(16, round(longest * side / max(sides))) for side in sides]
    centres = [low + side * (np.arange(count) + 0.5) / count
               for (low, _), side, count in zip(bounds, sides, counts)]
    return _values(density, [axis.T for axis in np.meshgrid(*centres, indexing="ij")])


def is_web_mercator(domain: Any) -> bool:
    """Returns whether the reference system of a frame is Web Mercator."""
    system: Any = getattr(domain, "crs", None)
    return hasattr(system, "to_epsg") and system.to_epsg() == 3857


def ground_of_web_mercator(_: Floats, y: Floats) -> Floats:
    """Returns the area on the ground of a part of a map in Web Mercator, divided by its area on the map."""
    return np.asarray(1 / np.cosh(y / EARTH_RADIUS) ** 2)


def _values(density: Callable[..., Any], axes: List[Floats]) -> Floats:
    """Calls a function with arrays or, if it does not accept these, with numbers."""
    try:
        return np.array(np.broadcast_to(density(*axes), axes[0].shape))
    except (TypeError, ValueError):
        return np.asarray(np.vectorize(density, otypes=[np.float64])(*axes))


def _bounds(domain: Any, members: Mapping[str, Any]) -> Bounds:
    if isinstance(domain, (Box, Torus, Rectangle, Pixels)):
        return [(0, side) for side in vars(domain).values() if side is not None]
    if isinstance(domain, Solid) and isinstance(domain.mesh, Mesh):
        corners = np.asarray(domain.mesh.vertices, np.float64)
    elif "polygon" in members:
        corners = np.asarray(members["polygon"], np.float64)
    else:
        rings = list(_outer_rings(members.get("geometry")))
        if not rings:
            raise Error("density must be an array, because the domain is neither polygons nor a Mesh", field="density")
        corners = np.vstack([np.asarray(ring, np.float64)[:, :2] for ring in rings])
    return list(zip(corners.min(axis=0), corners.max(axis=0)))


def _outer_rings(geometry: Any) -> Iterator[Any]:
    if not isinstance(geometry, dict):
        return
    if geometry.get("type") in ("Polygon", "MultiPolygon"):
        parts = geometry["coordinates"] if geometry["type"] == "MultiPolygon" else [geometry["coordinates"]]
        yield from (part[0] for part in parts if part)
    for each in (geometry.get("geometry"), *geometry.get("geometries", ()), *geometry.get("features", ())):
        yield from _outer_rings(each)
