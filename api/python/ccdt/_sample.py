# SPDX-License-Identifier: GPL-3.0-or-later
"""Evenly spread points, sets of pixels, and threshold masks."""

from __future__ import annotations

import io
import json
from typing import TYPE_CHECKING, Any, Dict, Optional, Tuple, Union, overload

import numpy as np
import numpy.typing as npt

from . import _core
from ._drawing import Drawing, Kept
from ._libraries import domain_of, seed_of
from ._options import (PixelOptions, Progress, SampleOptions, Seed, SurfaceOptions, VolumeOptions, check_names,
                       format_for)
from ._request import npy_array, running, sample_body, surface_request, volume_request
from .domains import Box, Mesh, Pixels, Solid, Torus, is_in_space, is_mesh_file, region_members
from .errors import Error, warn

if TYPE_CHECKING:
    from typing_extensions import Unpack

Floats = npt.NDArray[np.float64]

# Members of the service's JSON answer that list every point.
LISTS = ("points", "rank", "ranks", "feature", "class", "faces", "barycentric", "normals", "colors", "texture")


class Points(np.ndarray, Drawing):  # type: ignore[type-arg, misc]  # both have __array__
    """Points as an array, float64 [n, 2], with the other members of the answer.

    It behaves like any array. Parts of it, and results of arithmetic, are plain arrays without the further members.
    """

    _kept: Optional[Kept]
    _columns: Dict[str, npt.NDArray[Any]]
    _domain: Any
    _info: Optional[Dict[str, Any]]
    _system: Optional[str]

    @classmethod
    def _of(cls, kept: Kept, table: Floats, domain: Any, columns: Tuple[str, ...] = ()) -> Points:
        axes = table.shape[1] - len(columns)
        points = table[:, :axes].view(cls)
        points._kept = kept
        points._columns = {name: table[:, axes + i].astype(np.uint32) for i, name in enumerate(columns)}
        points._domain = domain
        return points

    def __array_finalize__(self, parent: Any) -> None:
        self._kept = None
        self._columns = {}
        self._domain = None
        self._info = None
        self._system = None

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        return array[()] if array.ndim == 0 else np.asarray(array)

    def __getitem__(self, key: Any) -> Any:
        return np.asarray(self)[key]

    def __reduce__(self) -> Any:
        rebuild, arguments, state = super().__reduce__()  # type: ignore[misc]
        return rebuild, arguments, (state, self.__dict__)

    def __setstate__(self, state: Any) -> None:
        super().__setstate__(state[0])
        self.__dict__.update(state[1])

    def _answer(self, format: str) -> _core.Answer:
        if self._kept is None:
            raise AttributeError("only the array that sample() returned can be written, not a part or a copy of it")
        return self._kept.write(format)

    def _repr_png_(self) -> Optional[bytes]:
        return None if self._kept is None else super()._repr_png_()

    @property
    def warnings(self) -> Tuple[str, ...]:
        """Texts of the warnings that :func:`ccdt.sample` gave. ``info["repaired"]`` lists all repairs."""
        return () if self._kept is None else self._kept.warnings

    @property
    def info(self) -> Dict[str, Any]:
        """Members of the service's JSON answer, without those that list every point."""
        if self._info is None:
            members = json.loads(self.write("json"))
            for name in LISTS:
                members.pop(name, None)
            self._info = members
        return self._info

    @property
    def ranks(self) -> Optional[npt.NDArray[np.uint32]]:
        """Rank of each point, uint32 [n], with ``order="progressive"``; else None."""
        return self._columns.get("rank")

    @property
    def features(self) -> Optional[npt.NDArray[np.uint32]]:
        """Index of each point's feature in the request, uint32 [n], in dot maps and with ``properties``; else None."""
        return self._columns.get("feature")

    @property
    def classes(self) -> Optional[npt.NDArray[np.uint32]]:
        """Index of each point's class, uint32 [n], in dot maps with ``classes``; else None."""
        return self._columns.get("class")

    @property
    def variation(self) -> float:
        """Standard deviation of the capacities of triangles, relative to their targets."""
        return float(self.info["variation"])

    @property
    def variations(self) -> Floats:
        """Variation after each iteration, float64 [iterations + 1]."""
        return np.array([each["variation"] for each in self.info["trace"]], dtype=np.float64)

    @property
    def vertices(self) -> Optional[Floats]:
        """Vertices of the triangulation, float64 [m, 2], the points first, with ``mesh=True``; else None."""
        return np.array(self.info["vertices"], dtype=np.float64) if "vertices" in self.info else None

    @property
    def triangles(self) -> Optional[npt.NDArray[np.uint32]]:
        """Indices of each triangle's vertices, uint32 [t, 3], counter-clockwise, with ``mesh=True``; else None."""
        return np.array(self.info["triangles"], dtype=np.uint32) if "triangles" in self.info else None


    @property
    def crs(self) -> Any:
        """Reference system of the domain, EPSG:4326 with ``coordinates="lonlat"``, or None."""
        return getattr(self._domain, "crs", None) or self._system

    @property
    def __geo_interface__(self) -> Dict[str, Any]:
        """The points as a MultiPoint, for Shapely and others."""
        return {"type": "MultiPoint", "coordinates": self.tolist()}

    def to_geodataframe(self) -> Any:
        """Returns a GeoDataFrame of GeoPandas with the points, and with their ranks, features and classes as columns."""
        import geopandas

        columns = {name: values for name, values in self._columns.items() if values.ndim == 1}
        return geopandas.GeoDataFrame(columns, geometry=geopandas.points_from_xy(*np.asarray(self).T), crs=self.crs)

    def _plot(self, ax: Any, options: Dict[str, Any]) -> None:
        ax.scatter(*np.asarray(self).T, **{"s": 2, **options})
        ax.set_aspect("equal")


class _Points3(Points):
    """Points with three coordinates."""

    _is_in_space = True

    @property
    def vertices(self) -> Optional[Floats]:
        """Vertices of the triangulation, float64 [m, 3], beginning with the points; None without ``mesh=True``."""
        return np.array(self.info["mesh"]["vertices"], dtype=np.float64) if "mesh" in self.info else None

    def _plot(self, ax: Any, options: Dict[str, Any]) -> None:
        ax.scatter(*np.asarray(self).T, **{"s": 2, **options})
        sides = np.ptp(np.asarray(self), axis=0)
        ax.set_box_aspect(np.maximum(sides, sides.max() / 100))

    def _repr_png_(self) -> Optional[bytes]:
        """Returns a picture that matplotlib draws, or None without matplotlib."""
        if self._kept is None:
            return None
        try:
            from matplotlib.figure import Figure
        except ImportError:
            return None
        figure = Figure()
        self.plot(figure.add_subplot(projection="3d"))
        file = io.BytesIO()
        figure.savefig(file, format="png")
        return file.getvalue()


class SurfacePoints(_Points3):
    """Points on a surface as an array, float64 [n, 3], with the other members of the answer."""

    @classmethod
    def _on(cls, kept: Kept, table: Floats, domain: Any, ranked: bool) -> SurfacePoints:
        colored, textured = kept.result.has_colors, kept.result.has_texture
        points = table[:, :3].view(cls)
        points._kept = kept
        points._domain = domain
        points._columns = {"faces": table[:, 3].astype(np.uint32), "barycentric": table[:, 4:7],
                           "normals": table[:, 7:10]}
        if colored:
            points._columns["colors"] = table[:, 10:13].astype(np.uint8)
        if textured:
            points._columns["texture"] = table[:, 13:15] if colored else table[:, 10:12]
        if ranked:
            points._columns["rank"] = table[:, -1].astype(np.uint32)
        return points

    @property
    def faces(self) -> npt.NDArray[np.uint32]:
        """Triangle of each point, uint32 [n], counted from 0 in the order of the mesh."""
        return self._columns["faces"]

    @property
    def barycentric(self) -> Floats:
        """Barycentric coordinates of each point in its triangle, float64 [n, 3]."""
        return self._columns["barycentric"]

    @property
    def normals(self) -> Floats:
        """Unit normal of the surface at each point, float64 [n, 3]."""
        return self._columns["normals"]

    @property
    def colors(self) -> Optional[npt.NDArray[np.uint8]]:
        """Colour at each point, uint8 [n, 3] in sRGB; None if the mesh has no colours."""
        return self._columns.get("colors")

    @property
    def texture(self) -> Optional[Floats]:
        """Texture coordinates at each point, float64 [n, 2]; None if the mesh has none."""
        return self._columns.get("texture")

    @property
    def triangles(self) -> Optional[npt.NDArray[np.uint32]]:
        """Indices of each triangle's vertices, uint32 [t, 3]; None without ``mesh=True``."""
        return np.array(self.info["mesh"]["triangles"], dtype=np.uint32) if "mesh" in self.info else None


class VolumePoints(_Points3):
    """Points in space as an array, float64 [n, 3], with the other members of the answer."""

    @property
    def ranks(self) -> Optional[npt.NDArray[np.uint32]]:
        """None, because points in a progressive order are in the order of their ranks."""
        return None

    @property
    def variation(self) -> float:
        """Standard deviation of the capacities of tetrahedra before the last iteration, relative to their mean."""
        return float(self.variations[-1])

    @property
    def tetrahedra(self) -> Optional[npt.NDArray[np.uint32]]:
        """Indices of each tetrahedron's vertices, uint32 [t, 4]; None without ``mesh=True``."""
        return np.array(self.info["mesh"]["tetrahedra"], dtype=np.uint32) if "mesh" in self.info else None


@overload
def sample(domain: Union[Box, Solid], sites: int, *, density: Any = None, seed: Seed = 0, threads: Optional[int] = None,
           progress: Progress = None, **options: Unpack[VolumeOptions]) -> VolumePoints: ...
@overload
def sample(domain: Mesh, sites: int, *, density: Any = None, seed: Seed = 0, threads: Optional[int] = None,
           progress: Progress = None, **options: Unpack[SurfaceOptions]) -> SurfacePoints: ...
@overload  # type: ignore[misc]  # Any includes Pixels
def sample(domain: Pixels, sites: int, *, density: Any = None, seed: Seed = 0, threads: Optional[int] = None,
           progress: Progress = None, **options: Unpack[PixelOptions]) -> npt.NDArray[np.bool_]: ...
@overload
def sample(domain: Any, sites: Union[int, str, Dict[str, Any], None] = None, *, density: Any = None, seed: Seed = 0,
           threads: Optional[int] = None, progress: Progress = None, **options: Unpack[SampleOptions]) -> Points: ...
def sample(domain: Any, sites: Any = None, *, density: Any = None, seed: Seed = 0, threads: Optional[int] = None,
           progress: Progress = None, **options: Any) -> Any:
    """Spreads points evenly over an area, a surface or a domain in space, or chooses an exact number of pixels.

    Options, ranges, defaults and positions are those of ``POST /sample`` of ccdt-server.

    Args:
        domain: positions [n, 2] of the corners of a polygon; GeoJSON or TopoJSON, as a dict or as the path of a file;
            an object with ``__geo_interface__``, such as a geometry of Shapely; :class:`Torus`; :class:`Rectangle`;
            :class:`Pixels`; a surface: :class:`Mesh`, or the file of a mesh (STL, OBJ, PLY, OFF, GLB, or glTF with
            embedded buffers) as a path, bytes or an open file; or a domain in space: :class:`Box`, a :class:`Torus`
            with a depth, or :class:`Solid`. Meshes of trimesh, Open3D and PyVista are surfaces. A Delaunay
            triangulation or a ConvexHull of SciPy means the convex hull, a polygon or a solid.
        sites: exact number of points; in a dot map, the name of the property that has the counts.
        density: array [rows, columns] of values of at least 0, stretched over the bounding box of the area, with the
            first row at the smallest y (for pixels, at the top); or the file of a picture, in which dark is dense, as
            a path, bytes, or an open file. For a surface, ``"color"``, ``"curvature"``, or an array [n] of values at
            the vertices; for STL and OBJ files, at the corners of all faces. In space, an array [depth, height, width]
            of voxels, stretched over the domain or the bounding box of the solid, or a file of them (NPY, or a TIFF
            with several pages). Also a function of the coordinates of points, which is called with arrays; in the plane,
            a DataArray of xarray with coordinates, or a dataset of rasterio, in the coordinates of the domain, where NaN
            means 0. Uniform by default.
        seed: integer from 0 to 2^53 - 1, or a generator of NumPy or of the module random, from which one is drawn. The
            same arguments give the same points.
        threads: number of threads; by default all processors. Results do not depend on it.
        progress: function that receives the completed share of the work, 0 to 1.
        **options: see api/sample/README.md: ``holes``, ``fixed``, ``avoid``, ``buffer``, ``coordinates``, ``quality``,
            ``order``, ``mesh``, ``method`` and others; for a mesh also ``crease``. Options that are None are left
            out.

    Returns:
        Points: float64 [n, 2], strictly inside the area. For pixels, an array [height, width] of bool, True for the
        chosen ones. For a surface, SurfacePoints: float64 [n, 3]. In space, VolumePoints: float64 [n, 3].

    Raises:
        Error: an option or the area is not usable. The message names the option and its limit.
        TypeError: there is no such option.

    Warns:
        Warning: the answer has remarks, which the attribute ``warnings`` of the result keeps.
    """
    domain = domain_of(domain)
    seed = seed_of(seed)
    if isinstance(domain, Mesh) or is_mesh_file(domain):
        check_names("sample", options, SurfaceOptions)
        mesh, texts = surface_request(domain, {"sites": sites, "density": density, "seed": seed, **options})
        surface = Kept(_core.SurfaceSample, mesh, [*texts.items(), ("format", "npy")])
        table = npy_array(surface.start(threads, progress))
        kept_domain = domain if isinstance(domain, Mesh) else mesh  # a file is open or may change
        return SurfacePoints._on(surface, table, kept_domain, texts.get("order") == "progressive")
    if is_in_space(domain):
        check_names("sample", options, VolumeOptions)
        body, texts = volume_request(domain, {"sites": sites, "density": density, "seed": seed, **options})
        if isinstance(domain, Solid) and not isinstance(domain.mesh, Mesh):
            domain = Solid(body)
        solid = Kept(_core.VolumeSample, body, [*texts.items()])
        return VolumePoints._of(solid, npy_array(solid.start(threads, progress)), domain)
    raster = isinstance(domain, Pixels)
    check_names("sample", options, PixelOptions if raster else SampleOptions)
    members = {"sites": sites, "density": density, "seed": seed, **options}
    area = region_members(domain)
    body, has_pictures = sample_body(domain, area, {**members, "format": format_for(options, "npy")})
    if raster:
        return npy_array(_core.answer_sample(body, has_pictures, running(threads, progress)))
    kept = Kept(_core.Sample, body, has_pictures)
    table = npy_array(kept.start(threads, progress))
    names = ((("rank",) if options.get("order") == "progressive" else ())
             + (("feature", "class") if table.shape[1] - 2 > (options.get("order") == "progressive") else ()))
    points = Points._of(kept, table, domain, names[:table.shape[1] - 2])
    points._system = "EPSG:4326" if options.get("coordinates") == "lonlat" else None
    if points.features is not None and isinstance(sites, (str, dict)):
        kept.warnings += _warn_of_rounding(area["geometry"], sites if isinstance(sites, str) else sites["property"],
                                           points.features)
    return points


def _warn_of_rounding(geojson: Dict[str, Any], count: str, found: npt.NDArray[np.uint32]) -> Tuple[str, ...]:
    """Warns of features of GeoJSON that have a count above 0, but no point. Returns the texts."""
    features = geojson.get("features", [geojson])
    counts = np.array([float((each.get("properties") or {}).get(count) or 0) for each in features])
    points = np.bincount(found, minlength=len(counts))[:len(counts)]
    empty = int(((counts > 0) & (points == 0)).sum())
    if empty == 0:
        return ()
    text = f"{empty} of {len(counts)} features have a count above 0, but no point: counts divided by per are rounded"
    warn(text)
    return (text,)


def mask(width: int, height: Optional[int] = None, depth: Optional[int] = None, *, seed: Seed = 0, bits: int = 8,
         threads: Optional[int] = None, progress: Progress = None) -> npt.NDArray[Any]:
    """Computes a threshold mask for dithering, which tiles without seams.

    A pixel of a picture that is lighter than the mask becomes white. All values are equally frequent.

    Args:
        width, height: size in pixels, 8 to 1024 each; by default, the mask is a square.
        depth: number of frames of an animated mask, which is also even in time, 1 to 256; None: a single picture.
        seed: integer from 0 to 2^53 - 1, or a generator as for :func:`sample`.
        bits: 8 or 16, bits of each value.
        threads: number of threads; by default all processors.
        progress: function that receives the completed share of the work, 0 to 1.

    Returns:
        uint8 or uint16 [height, width], or [depth, height, width].

    Raises:
        Error: a side, the seed or the number of bits is out of range.
    """
    torus = Torus(width, width if height is None else height, depth)
    if bits not in (8, 16):
        raise Error(f"bits must be 8 or 16, not {bits}", field="bits")
    body, _ = sample_body(torus, region_members(torus), {"seed": seed_of(seed), "format": "mask" if bits == 8 else "mask16"})
    pixels = _core.png_pixels(_core.answer_sample(body, False, running(threads, progress)))
    return pixels if depth is None else pixels.reshape(depth, -1, width)
