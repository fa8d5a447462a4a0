# SPDX-License-Identifier: GPL-3.0-or-later
"""Choices among given points."""

from __future__ import annotations

import json
from typing import Any, List, Optional, Tuple

import numpy as np
import numpy.typing as npt

from . import _core
from ._libraries import positions_of, seed_of
from ._options import Progress, Seed
from ._request import check_numbers, masked_values, npy_array, running, warn_of_answer
from .errors import Error


def choose(points: Any, sites: Any = None, *, spacing: Optional[float] = None, density: Any = None, priority: Any = None,
           keep: Any = None, classes: Any = None, coordinates: Optional[str] = None, domain: Optional[str] = None, order: Optional[str] = None, seed: Seed = 0,
           threads: Optional[int] = None, progress: Progress = None) -> npt.NDArray[np.intp]:
    """Chooses exactly ``sites`` of given points, evenly spread, however dense the points are.

    Args:
        points: positions [n, 2] or [n, 3], a DataFrame with the columns x and y (and z), or a GeoSeries or a
            GeoDataFrame of points. Points that are NaN, masked or empty are left out, with a warning. Points may
            coincide.
        sites: number of points to choose; with ``classes`` also a dict with the number for each class.
        spacing: instead of ``sites``, the least distance of chosen points; in metres with ``coordinates="lonlat"``. As
            many points are chosen as fit.
        density: wanted density of the chosen points around each point, [n] numbers of at least 0, of which only ratios
            matter, or the name of a column. Points with the density 0 are not chosen. By default the same everywhere.
        priority: [n] numbers, or the name of a column. Of points that are close to each other, those with higher numbers
            are preferred.
        keep: points that are always chosen: [n] booleans, indices, or the name of a column of booleans.
        classes: [n] texts or numbers, or the name of a column. The chosen points of each class are spread evenly, and
            those of all classes together.
        coordinates: ``"lonlat"`` for longitudes and latitudes in degrees, so that the choice is even on the ground. By
            default from the reference system of a GeoSeries or GeoDataFrame; otherwise ``"plane"``.
        domain: for [n, 3] points, ``"surface"`` (the default, such as a scan) or ``"solid"``, if they fill a volume.
        order: ``"progressive"``: the first k indices are spread evenly, for every k. By default they ascend.
        seed: as for :func:`sample`.
        threads: number of threads; by default all processors. Results do not depend on it.
        progress: function that receives the completed share of the work, 0 to 1.

    Returns:
        Indices of the chosen points, [sites]. ``points[indices]`` or ``frame.iloc[indices]`` are the points.

    Raises:
        Error: the points or an option are not usable. The message names the option and its limit.

    Warns:
        Warning: points are left out.
    """
    positions = positions_of(points)
    hidden = masked_values(positions)
    array = np.array(positions, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise Error(f"points must have the shape [n, 2] or [n, 3], not {list(array.shape)}", field="points")
    if hidden is not None:
        array[hidden.any(axis=1)] = np.nan
    columns = [array]
    options: List[Tuple[str, str]] = [("candidates", "body")]
    if spacing is not None:
        options.append(("spacing", repr(float(spacing))))
    for name, values in (("density", density), ("priority", priority), ("keep", keep)):
        if values is not None:
            options.append((name, str(sum(each.shape[1] for each in columns))))
            columns.append(_column(points, values, name, len(array))[:, None])
    if classes is not None:
        names, numbers = np.unique(_values(points, classes, "classes", len(array)), return_inverse=True)
        options.append(("classes", str(sum(each.shape[1] for each in columns))))
        columns.append(numbers.astype(np.float64)[:, None])
        if isinstance(sites, dict):
            known = {name: str(number) for number, name in enumerate(names.tolist())}
            unknown = [name for name in sites if name not in known]
            if unknown:
                raise Error(f"sites: there is no class {unknown[0]!r}", field="sites")
            sites = {known[name]: _whole(count) for name, count in sites.items()}
    if sites is not None:
        options.append(("sites", json.dumps(sites) if isinstance(sites, dict) else str(_whole(sites))))
    if coordinates is None and getattr(getattr(points, "crs", None), "is_geographic", False):
        coordinates = "lonlat"
    for name, value in (("x", "0"), ("y", "1"), ("z", "2" if array.shape[1] == 3 else None),
                        ("coordinates", coordinates), ("domain", domain), ("order", order),
                        ("seed", str(seed_of(seed))), ("format", "npy")):
        if value is not None:
            options.append((name, value))
    answer = _core.answer_choice(np.concatenate(columns, axis=1), options, running(threads, progress))
    warn_of_answer(answer)
    return npy_array(answer).ravel().astype(np.intp)


def _whole(sites: Any) -> int:
    if isinstance(sites, bool) or not hasattr(sites, "__index__"):
        raise Error(f"sites must be an integer, not {sites!r}", field="sites")
    return int(sites)


def _values(points: Any, values: Any, name: str, size: int) -> Any:
    """Returns the values of an option for each point, as an array."""
    if isinstance(values, str):
        try:
            values = points[values]
        except (KeyError, IndexError, TypeError, ValueError):
            raise Error(f"{name}: the points have no column {values!r}", field=name) from None
    elif name == "keep":
        values = _mask_of(np.asarray(values), size)
    array = np.asanyarray(values)
    if array.shape != (size,):
        raise Error(f"{name} must have a value for each of the {size} points, not the shape {list(array.shape)}",
                    field=name)
    return array


def _column(points: Any, values: Any, name: str, size: int) -> npt.NDArray[np.float64]:
    """Returns the numbers of an option for each point."""
    values = _values(points, values, name, size)
    array = np.asarray(values, dtype=np.float64)
    check_numbers(array, masked_values(values), name)
    if name == "density" and (array < 0).any():
        raise Error(f"density[{np.argmax(array < 0)}] must be at least 0", field=name)
    return array


def _mask_of(kept: npt.NDArray[Any], size: int) -> npt.NDArray[Any]:
    """Returns booleans for indices of kept points."""
    if kept.dtype.kind == "b" or kept.size == 0:
        return kept if kept.size else np.zeros(size)
    if kept.ndim != 1 or kept.dtype.kind not in "iu" or kept.min() < 0 or kept.max() >= size:
        raise Error(f"keep must be [{size}] booleans, or indices below {size}", field="keep")
    mask = np.zeros(size)
    mask[kept] = 1
    return mask
