# SPDX-License-Identifier: GPL-3.0-or-later
"""Domains that are not polygons, and values of requests. This module imports nothing but the standard library."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import Any, Dict, Union

from .errors import Error


@dataclass(frozen=True)
class Torus:
    """The area [0, width) x [0, height), whose opposite sides are joined. Points on it tile the plane."""

    width: float = 1
    height: float = 1


@dataclass(frozen=True)
class Rectangle:
    """The area [0, width] x [0, height], in any unit of length."""

    width: float = 1
    height: float = 1


@dataclass(frozen=True)
class Pixels:
    """A raster of width x height pixels, of which an exact number is chosen. The first row is at the top."""

    width: int
    height: int


def domain_member(domain: Union[Torus, Rectangle, Pixels]) -> Dict[str, Any]:
    """Returns the member `domain` of a request."""
    return {"type": type(domain).__name__.lower(), "width": domain.width, "height": domain.height}


def region_members(domain: Any) -> Dict[str, Any]:
    """Returns the member of a request that gives its area: `domain`, `geometry` or `polygon`."""
    if isinstance(domain, (Torus, Rectangle, Pixels)):
        return {"domain": domain_member(domain)}
    if isinstance(domain, (str, os.PathLike)):
        domain = _read_json(domain)
    if hasattr(domain, "__geo_interface__"):
        domain = domain.__geo_interface__
    if isinstance(domain, dict):
        return {"domain" if domain.get("type") in ("torus", "rectangle", "pixels") else "geometry": domain}
    if hasattr(domain, "__len__"):
        return {"polygon": domain}
    raise Error("domain must be the corners of a polygon, GeoJSON, the path of a file with GeoJSON, an object with "
                f"__geo_interface__, or a torus, a rectangle or pixels, not {type(domain).__name__}", field="domain")


def jsonable(value: Any) -> Any:
    """Returns a value that the module json can write instead of an array, or of an object with a geometry."""
    if hasattr(value, "__geo_interface__"):
        return value.__geo_interface__
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} cannot be written as JSON")


def _read_json(path: Union[str, os.PathLike[str]]) -> Any:
    with open(path, "rb") as file:
        try:
            return json.load(file)
        except ValueError as reason:
            raise Error(f"domain: {os.fspath(path)!r} is not a file with GeoJSON: {reason}", field="domain") from None
