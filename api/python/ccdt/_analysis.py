# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures of how evenly points are spread."""

from __future__ import annotations

import json
from typing import Any, Dict, Optional, Union, overload

import numpy as np
import numpy.typing as npt

from . import _core
from ._drawing import Drawing, Plotted
from ._libraries import domain_of, positions_of
from ._request import array_json, region_texts, running, surface_request
from ._sample import Points
from .domains import Box, Mesh, Rectangle, Solid, Torus, is_in_space, is_mesh_file, region_members
from .errors import Error

Floats = npt.NDArray[np.float64]


class _Measures(Plotted):
    def __init__(self, answer: Dict[str, Any]) -> None:
        self.frequency: Floats = np.array(answer["frequency"], dtype=np.float64)
        self.power: Floats = np.array(answer["power"], dtype=np.float64)
        self.low_frequency_power: Optional[float] = answer["low_frequency_power"]
        self.min_distance: float = answer["min_distance"]
        self.mean_distance: float = answer["mean_distance"]

    def _plot(self, ax: Any, options: Dict[str, Any]) -> None:
        ax.plot(self.frequency, self.power, **options)
        ax.set(xlabel="frequency", ylabel="power")

    def __repr__(self) -> str:
        return (f"<ccdt.{type(self).__name__}: min_distance {self.min_distance:.3f}, "
                f"mean_distance {self.mean_distance:.3f}>")


class Analysis(_Measures, Drawing):
    """Spectrum and spacing of points. Frequencies are in units of sqrt(points / area) or cbrt(points / volume).

    Attributes:
        frequency: float64 [rings], frequency of each ring.
        power: float64 [rings], mean power of each ring; white noise has power 1.
        anisotropy_db: float64 [rings], anisotropy of each ring in decibels.
        low_frequency_power: mean power below the frequency 0.5 or, in space, 0.5456; None if there are no such
            frequencies.
        min_distance: least distance to the nearest neighbour, relative to that of the densest packing.
        mean_distance: mean distance to the nearest neighbour, relative to that of the densest packing.
        sets: number of sets of points.
        spectrum: float64 [height, width], power of each frequency, with the frequency 0 in the middle; None unless
            requested. In space, it is the slice at the frequency 0 along z.
    """

    def __init__(self, members: Dict[str, str], answer: Dict[str, Any]) -> None:
        super().__init__(answer)
        self._members = members
        self.anisotropy_db: Floats = np.array(answer["anisotropy_db"], dtype=np.float64)
        self.sets: int = answer["sets"]
        spectrum = answer.get("spectrum")
        self.spectrum: Optional[Floats] = None
        if spectrum:
            values = np.array(spectrum["values"], dtype=np.float64)
            self.spectrum = values.reshape(spectrum["height"], spectrum["width"])

    def _answer(self, format: str) -> _core.Answer:
        return _answer({**self._members, "format": json.dumps(format or "json")}, None, None)


def _answer(members: Dict[str, str], threads: Optional[int], progress: Any) -> _core.Answer:
    body = "{" + ",".join(f'"{name}":{text}' for name, text in members.items()) + "}"
    return _core.answer_analyze(body, running(threads, progress))


class SurfaceAnalysis(_Measures):
    """Spectrum and spacing of points on a surface. Frequencies are in units of sqrt(points / area).

    Attributes:
        eigenvalues: float64 [modes], eigenvalues of the Laplace-Beltrami operator, without that of the constant.
        frequency: float64 [modes], frequency of each mode.
        power: float64 [modes], power of the points in each mode; random points have power 1.
        low_frequency_power: mean power of the modes below the frequency 0.5; None if there are none.
        min_distance, mean_distance: as for :class:`Analysis`.
    """

    def __init__(self, answer: Dict[str, Any]) -> None:
        super().__init__(answer)
        self.eigenvalues: Floats = np.array(answer["eigenvalues"], dtype=np.float64)


@overload
def analyze(  # type: ignore[misc]  # Any includes the domains of Analysis
        points: Any, domain: Union[Torus, Rectangle, Box, None] = None, *, max_frequency: Optional[float] = None,
        spectrum: bool = False, threads: Optional[int] = None, progress: Any = None) -> Analysis: ...
@overload
def analyze(points: Any, domain: Any = None, *, modes: Optional[int] = None, threads: Optional[int] = None,
            progress: Any = None) -> SurfaceAnalysis: ...
def analyze(points: Any, domain: Any = None, *, max_frequency: Optional[float] = None, spectrum: bool = False,
            modes: Optional[int] = None, threads: Optional[int] = None,
            progress: Any = None) -> Union[Analysis, SurfaceAnalysis]:
    """Measures how evenly points are spread, as ``POST /analyze`` of ccdt-server does.

    Args:
        points: positions [n, 2] or, in space and on a surface, [n, 3]; in the plane and in space also several sets of
            equal size [sets, n, 2 or 3], whose spectra are averaged.
        domain: domain of the points: a torus, a rectangle, a box, a :class:`Mesh`, the file of a mesh, or polygons in
            the plane as for :func:`sample`. By default, that in which :func:`sample` placed the points, or else the
            unit torus. In polygons, effects of the border are removed.
        max_frequency: end of the curves, 1 to 16; by default 4, or 2 in space. Not for surfaces.
        spectrum: whether the result has the two-dimensional spectrum. Not for surfaces.
        modes: number of modes of a surface, 1 to 500; 100 by default.
        threads: number of threads; by default all processors.
        progress: function that receives the completed share of the work, 0 to 1.

    Raises:
        Error: the points or an option are not usable. The message names the option and its limit.
    """
    system = None
    if domain is None and isinstance(points, Points):
        domain, system = points._domain, points._system
    points, domain = positions_of(points), domain_of(domain)
    if isinstance(domain, Solid):
        raise Error("domain must be a box or a torus, because points in a solid cannot be analyzed", field="domain")
    is_surface = isinstance(domain, Mesh) or is_mesh_file(domain)
    area = {} if is_surface or domain is None else region_members(domain)
    if system is not None or "coordinates" in area:
        raise Error("points in degrees cannot be analyzed; project them and their domain to a plane", field="domain")
    if modes is not None and not is_surface:
        raise Error("modes is only for meshes", field="modes")
    if max_frequency is not None and is_surface:
        raise Error("max_frequency is not for meshes", field="max_frequency")
    if spectrum and is_surface:
        raise Error("spectrum is not for meshes", field="spectrum")
    text = array_json(points, "points")
    depth, axes = np.ndim(points), (0, *np.shape(points))[-1]
    wanted = (3,) if is_surface or is_in_space(domain) else (2, 3) if domain is None else (2,)
    if depth not in ((2,) if is_surface else (2, 3)) or axes not in wanted:
        one = f"[n, {' or '.join(map(str, wanted))}]"
        raise Error(f"points must have the shape {one}{'' if is_surface else f' or [sets, {one[1:]}'}, not "
                    f"{list(np.shape(points))}", field="points")
    if is_surface:
        mesh, options = surface_request(domain, {"points": text, "modes": modes})
        answer = _core.answer_surface_analyze(mesh, [*options.items()], running(threads, progress))
        return SurfaceAnalysis(json.loads(bytes(answer)))  # type: ignore[call-overload]
    members = {"points" if depth == 2 else "sets": text, "spectrum": json.dumps(bool(spectrum))}
    members.update(region_texts(area))
    if max_frequency is not None:
        members["max_frequency"] = repr(float(max_frequency))
    return Analysis(members, json.loads(bytes(_answer(members, threads, progress))))  # type: ignore[call-overload]
