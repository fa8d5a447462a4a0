# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures of how evenly points are spread."""

from __future__ import annotations

import json
from typing import Any, Dict, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._drawing import Drawing
from ._request import array_json, running
from ._sample import Points
from .domains import Rectangle, Torus, domain_member
from .errors import Error

Floats = npt.NDArray[np.float64]


class Analysis(Drawing):
    """Spectrum and spacing of points. Frequencies are in units of sqrt(points / area).

    Attributes:
        frequency: float64 [rings], frequency of each ring.
        power: float64 [rings], mean power of each ring; white noise has power 1.
        anisotropy_db: float64 [rings], anisotropy of each ring in decibels.
        low_frequency_power: mean power below the frequency 0.5; None if there are no such frequencies.
        min_distance: least distance to the nearest neighbour, relative to that of the densest packing.
        mean_distance: mean distance to the nearest neighbour, relative to that of the densest packing.
        sets: number of sets of points.
        spectrum: float64 [height, width], power of each frequency, with the frequency 0 in the middle; None unless
            requested.
    """

    def __init__(self, members: Dict[str, str], answer: Dict[str, Any]) -> None:
        self._members = members
        self.frequency: Floats = np.array(answer["frequency"], dtype=np.float64)
        self.power: Floats = np.array(answer["power"], dtype=np.float64)
        self.anisotropy_db: Floats = np.array(answer["anisotropy_db"], dtype=np.float64)
        self.low_frequency_power: Optional[float] = answer["low_frequency_power"]
        self.min_distance: float = answer["min_distance"]
        self.mean_distance: float = answer["mean_distance"]
        self.sets: int = answer["sets"]
        spectrum = answer.get("spectrum")
        self.spectrum: Optional[Floats] = None
        if spectrum:
            values = np.array(spectrum["values"], dtype=np.float64)
            self.spectrum = values.reshape(spectrum["height"], spectrum["width"])

    def _answer(self, format: str) -> _core.Answer:
        return _answer({**self._members, "format": json.dumps(format or "json")}, None, None)

    def __repr__(self) -> str:
        return f"<ccdt.Analysis: min_distance {self.min_distance:.3f}, mean_distance {self.mean_distance:.3f}>"


def _answer(members: Dict[str, str], threads: Optional[int], progress: Any) -> _core.Answer:
    body = "{" + ",".join(f'"{name}":{text}' for name, text in members.items()) + "}"
    return _core.answer_analyze(body, running(threads, progress))


def analyze(points: Any, domain: Union[Torus, Rectangle, None] = None, *, max_frequency: Optional[float] = None,
            spectrum: bool = False, threads: Optional[int] = None, progress: Any = None) -> Analysis:
    """Measures how evenly points are spread, as ``POST /analyze`` of ccdt-server does.

    Args:
        points: positions [n, 2], or several sets of equal size [sets, n, 2], whose spectra are averaged.
        domain: area of the points. By default, the torus or rectangle on which :func:`sample` placed them, or else
            the unit torus.
        max_frequency: end of the curves, 1 to 16; 4 by default.
        spectrum: whether the result has the two-dimensional spectrum.
        threads: number of threads; by default all processors.
        progress: function that receives the completed share of the work, 0 to 1.

    Raises:
        Error: the points or an option are not usable. The message names the option and its limit.
    """
    if domain is None and isinstance(points, Points) and isinstance(points._domain, (Torus, Rectangle)):
        domain = points._domain
    text = array_json(points, "points")
    depth = np.ndim(points)
    if depth not in (2, 3) or np.shape(points)[-1] != 2:
        raise Error(f"points must have the shape [n, 2] or [sets, n, 2], not {list(np.shape(points))}",
                    field="points")
    members = {"points" if depth == 2 else "sets": text, "spectrum": json.dumps(bool(spectrum))}
    if domain is not None:
        members["domain"] = json.dumps(domain_member(domain))
    if max_frequency is not None:
        members["max_frequency"] = repr(float(max_frequency))
    return Analysis(members, json.loads(bytes(_answer(members, threads, progress))))  # type: ignore[call-overload]
