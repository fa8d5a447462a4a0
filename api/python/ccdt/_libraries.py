# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of other libraries, which are recognised by their attributes, as values of this package."""

from __future__ import annotations

from typing import Any

import numpy as np

from .domains import Mesh, Solid
from .errors import Error


def is_array(value: Any) -> bool:
    """Returns whether a value is an array or can become one, other than an image of Pillow."""
    return isinstance(value, (list, tuple)) or hasattr(value, "__array__") and not hasattr(value, "getexif")


def seed_of(seed: Any) -> Any:
    """Returns a seed, drawn from a generator of NumPy or of the module random if that is given."""
    for draw in ("integers", "randrange"):
        if hasattr(seed, draw):
            return int(getattr(seed, draw)(2**53))
    return int(seed.randint(2**53, dtype=np.int64)) if hasattr(seed, "randint") else seed


def positions_of(value: Any) -> Any:
    """Returns the columns x, y and z of a DataFrame, and the positions of a GeoSeries or a GeoDataFrame, as an array."""
    if isinstance(value, (np.ndarray, dict)):
        return value
    is_geometry = hasattr(value, "__geo_interface__")
    if is_geometry and hasattr(value, "geometry"):
        value = value.geometry
    if not (hasattr(value, "x") and hasattr(value, "y")):
        return np.asarray(value) if hasattr(value, "columns") else value
    axes = "xyz" if hasattr(value, "z") and not is_geometry else "xy"
    return np.column_stack([np.asarray(getattr(value, axis)) for axis in axes])


def domain_of(domain: Any) -> Any:
    """Returns a domain of this package for a mesh or a triangulation of another library; otherwise the domain.

    Meshes are those of trimesh and Open3D, with `vertices` and `faces` or `triangles`, and of PyVista, with `points` and
    `faces`. The convex hull of a Delaunay triangulation or a ConvexHull of SciPy is a polygon or a solid.
    """
    if isinstance(domain, (Mesh, np.ndarray, dict, str, bytes)) or hasattr(domain, "__geo_interface__"):
        return domain
    if isinstance(domain, Solid):
        return Solid(domain_of(domain.mesh))
    if hasattr(domain, "simplices"):
        return _hull_of(domain)
    for vertices, faces in (("vertices", "faces"), ("vertices", "triangles"), ("points", "faces")):
        if hasattr(domain, vertices) and hasattr(domain, faces):
            return _mesh_of(domain, np.asarray(getattr(domain, vertices)), np.asarray(getattr(domain, faces)))
    return positions_of(domain)


def _hull_of(triangulation: Any) -> Any:
    facets = np.asarray(getattr(triangulation, "convex_hull", triangulation.simplices))
    points = np.asarray(triangulation.points)
    if points.shape[1] == 3:
        first, second, third = (points[facets[:, i]] for i in range(3))
        is_inward = ((first - points.mean(axis=0)) * np.cross(second - first, third - first)).sum(axis=1) < 0
        return Solid(Mesh(points, np.where(is_inward[:, None], facets[:, ::-1], facets)))
    corners = points[np.unique(facets)]
    x, y = (corners - corners.mean(axis=0)).T
    return corners[np.argsort(np.arctan2(y, x))]


def _mesh_of(mesh: Any, vertices: Any, faces: Any) -> Mesh:
    if faces.ndim == 1:  # each face begins with its number of corners
        if faces.size % 4 != 0 or (faces[::4] != 3).any():
            raise Error("domain must have only triangles: see the method triangulate() of the mesh", field="domain")
        faces = faces.reshape(-1, 4)[:, 1:]
    visual = getattr(mesh, "visual", None)
    colors = np.asarray(getattr(mesh if visual is None else visual, "vertex_colors", ()))
    is_colored = colors.shape[:1] == vertices.shape[:1] and getattr(visual, "kind", "vertex") == "vertex"
    return Mesh(vertices, faces, colors=colors[:, :3] if is_colored else None)
