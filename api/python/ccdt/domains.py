# SPDX-License-Identifier: GPL-3.0-or-later
"""Domains that are not polygons, and values of requests. This module imports nothing but the standard library."""

from __future__ import annotations

import json
import math
import os
from dataclasses import dataclass
from typing import Any, Dict, Optional, Union

from ._options import plain
from .errors import Error


@dataclass(frozen=True)
class Torus:
    """The area [0, width) x [0, height), whose opposite sides are joined. Points on it tile the plane.

    With a depth, it is a box whose opposite faces are joined.
    """

    width: float = 1
    height: float = 1
    depth: Optional[float] = None


@dataclass(frozen=True)
class Rectangle:
    """The area [0, width] x [0, height], in any unit of length."""

    width: float = 1
    height: float = 1


@dataclass(frozen=True)
class Box:
    """The domain [0, width] x [0, height] x [0, depth] in space."""

    width: float = 1
    height: float = 1
    depth: float = 1


@dataclass(frozen=True)
class Solid:
    """The inside of a closed surface.

    Attributes:
        mesh: a :class:`Mesh`, or the file of a mesh.
    """

    mesh: Any


@dataclass(frozen=True)
class Pixels:
    """A raster of width x height pixels, of which an exact number is chosen. The first row is at the top."""

    width: int
    height: int


@dataclass(frozen=True)
class Mesh:
    """A surface made of triangles, for points in space.

    Attributes:
        vertices: positions [n, 3].
        triangles: indices of the vertices of each triangle [m, 3], or a Delaunay triangulation of SciPy. Triangles need
            not have the same orientation.
        colors: sRGB colours of the vertices [n, 3], as integers from 0 to 255 or as floats from 0 to 1; None without
            colours.
        texture: texture coordinates of the vertices [n, 2]; None without texture coordinates.
    """

    vertices: Any
    triangles: Any
    colors: Any = None
    texture: Any = None


MESH_SUFFIXES = (".stl", ".obj", ".ply", ".off", ".gltf", ".glb")


def is_mesh_file(domain: Any) -> bool:
    """Returns whether a domain is the file of a mesh: a path with one of MESH_SUFFIXES, bytes, or an open file."""
    if isinstance(domain, (str, os.PathLike)):
        return os.path.splitext(os.fspath(domain))[1].lower() in MESH_SUFFIXES
    return isinstance(domain, (bytes, bytearray, memoryview)) or hasattr(domain, "read")


def is_in_space(domain: Any) -> bool:
    """Returns whether a domain has three dimensions."""
    return isinstance(domain, (Box, Solid)) or isinstance(domain, Torus) and domain.depth is not None


def domain_member(domain: Union[Torus, Rectangle, Box, Pixels]) -> Dict[str, Any]:
    """Returns the member `domain` of a request."""
    return {"type": type(domain).__name__.lower(),
            **{name: side for name, side in vars(domain).items() if side is not None}}


def region_members(domain: Any) -> Dict[str, Any]:
    """Returns the member of a request that gives its area: `domain`, `geometry` or `polygon`.

    The reference system of an object, such as a GeoDataFrame, becomes a member of its geometry. If it has longitudes
    and latitudes, these are the default of the member `coordinates`.
    """
    if isinstance(domain, (Torus, Rectangle, Box, Pixels)):
        return {"domain": domain_member(domain)}
    if isinstance(domain, (str, os.PathLike)):
        domain = _read_json(domain)
    if hasattr(domain, "__geo_interface__"):
        system = getattr(domain, "crs", None)
        geometry = _writable(domain.__geo_interface__)
        if system is None:
            return {"geometry": geometry}
        name = system.to_wkt() if hasattr(system, "to_wkt") else str(system)
        return {"geometry": {**geometry, "crs": {"type": "name", "properties": {"name": name}}},
                **({"coordinates": "lonlat"} if getattr(system, "is_geographic", False) else {})}
    if isinstance(domain, dict):
        if domain.get("type") in ("torus", "rectangle", "box", "pixels"):
            return {"domain": domain}
        return {"geometry": _writable(domain)}
    if hasattr(domain, "__len__"):
        return {"polygon": domain}
    raise Error("domain must be the corners of a polygon, GeoJSON, the path of a file with GeoJSON or a mesh, an object "
                "with __geo_interface__, a mesh, a torus, a rectangle, a box, a solid or pixels, not "
                + type(domain).__name__, field="domain")


def _writable(geojson: Any) -> Any:
    """Returns GeoJSON whose properties JSON can express. NaN becomes null, and values of other types become text."""
    if not isinstance(geojson, dict):
        return geojson
    result = dict(geojson)
    if isinstance(result.get("features"), (list, tuple)):
        result["features"] = [_writable(each) for each in result["features"]]
    if isinstance(result.get("properties"), dict):
        result["properties"] = {name: _property(value) for name, value in result["properties"].items()}
    return result


def _property(value: Any) -> Any:
    value = plain(value)
    if value is None or isinstance(value, (str, bool, int, dict, list, tuple)):
        return value
    if isinstance(value, float):
        return None if math.isnan(value) else value
    return value.isoformat() if hasattr(value, "isoformat") else str(value)


def jsonable(value: Any) -> Any:
    """Returns a value that the module json can write instead of an array, or of an object with a geometry."""
    if hasattr(value, "__geo_interface__") and not hasattr(value, "strides"):  # Points are an array, too
        return _writable(value.__geo_interface__)
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} cannot be written as JSON")


def _read_json(path: Union[str, os.PathLike[str]]) -> Any:
    with open(path, "rb") as file:
        try:
            return json.load(file)
        except ValueError as reason:
            raise Error(f"domain: {os.fspath(path)!r} is not a file with GeoJSON: {reason}", field="domain") from None
