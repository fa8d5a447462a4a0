# SPDX-License-Identifier: GPL-3.0-or-later
"""Names and types of the options, for type checkers, editors and the check of names."""

from __future__ import annotations

from typing import Any, Callable, Dict, Iterable, Mapping, Optional, Sequence, Tuple, Type, TypedDict, Union

from .errors import Error

# Function that receives the completed share of the work, 0 to 1. If it raises an exception, the computation ends.
Progress = Optional[Callable[[float], object]]


# An integer, or a generator of NumPy or of the module random, from which one is drawn.
Seed = Any


class PlotOptions(TypedDict, total=False):
    """Options of drawings on paper. Lengths are in millimetres. With ``split``, a drawing of shapes is saved as a ZIP
    archive of several files, whatever the suffix of its name."""

    width_mm: float
    paper: str
    margin: Union[float, str]
    marks: bool
    split: Union[str, float]
    dpi: float
    jpeg_quality: int
    style: str
    closed: bool
    pen: Union[float, str]
    speed: float
    dwell: float
    machine: str
    dwell_unit: str
    pen_down: str
    pen_up: str


class HalftoneOptions(PlotOptions, total=False):
    """Options of :func:`ccdt.halftone`."""

    minutes: float
    seed: Seed
    iterations: int
    passes: int
    quality: str
    scale: float
    width: int
    height: int
    fit: str
    gravity: Union[str, Sequence[float]]
    dot: Union[float, str]
    detail: float
    alpha: str
    levels: Union[str, Sequence[float]]
    antialias: bool
    dots: str
    invert: bool
    tone: str
    color: str
    palette: Union[str, Sequence[str]]
    foreground: str
    background: str


class DeviceOptions(TypedDict, total=False):
    """Options of :func:`ccdt.halftone` with a device."""

    palette: Union[str, Sequence[str]]
    width: int
    height: int
    fit: str
    gravity: Union[str, Sequence[float]]
    rotate: int
    background: str
    alpha: str
    levels: Union[str, Sequence[float]]
    spot: float
    width_mm: float
    bit_order: str
    invert_bits: bool


class SampleOptions(PlotOptions, total=False):
    """Options of :func:`ccdt.sample`."""

    holes: Any
    fixed: Any
    exclude: Any
    avoid: Any
    per: float
    classes: Union[str, Sequence[str]]
    object: str
    properties: Union[str, Sequence[str]]
    multipoint: bool
    invalid: str
    coordinates: str
    buffer: Union[float, str]
    iterations: int
    passes: int
    quality: str
    tolerance: float
    method: str
    mesh: bool
    order: str
    width: int
    dot: float
    outlines: bool
    legend: bool
    minzoom: int
    maxzoom: int
    dots_per_tile: int


class SurfaceOptions(TypedDict, total=False):
    """Options of :func:`ccdt.sample` for a mesh."""

    fixed: Any
    crease: float
    iterations: int
    passes: int
    quality: str
    mesh: bool
    order: str


class VolumeOptions(TypedDict, total=False):
    """Options of :func:`ccdt.sample` for a domain in space. Only solids have creases."""

    fixed: Any
    crease: float
    quality: str
    mesh: bool
    order: str


class PixelOptions(TypedDict, total=False):
    """Options of :func:`ccdt.sample` for a raster of pixels."""

    calibration: Any
    include: Any


def check_names(function: str, options: Mapping[str, object], kind: Type[Any]) -> None:
    """Raises TypeError for an option that the function does not have, as Python does for parameters."""
    names = all_names(kind)
    for name in options:
        if name not in names:
            raise TypeError(f"{function}() got an unexpected keyword argument {name!r}; options are "
                            + ", ".join(sorted(names)))


#: Formats of the options that only some formats have.
_FORMATS = {"paper": "svg", "margin": "svg", "marks": "svg", "split": "svg", "dpi": "png", "jpeg_quality": "jpeg"}


def format_for(options: Mapping[str, object], otherwise: Optional[str]) -> Optional[str]:
    """Returns a format that has the given options, or ``otherwise`` if all formats have them."""
    return next((format for name, format in _FORMATS.items() if options.get(name) is not None), otherwise)


def all_names(kind: Type[Any]) -> Tuple[str, ...]:
    """Returns the names of the options of a kind."""
    return tuple(kind.__required_keys__ | kind.__optional_keys__)


def plain(value: object) -> object:
    """Returns the Python value of a NumPy scalar, and any other value unchanged."""
    item = getattr(value, "item", None)
    return item() if item is not None and getattr(value, "shape", None) == () else value


def text_of(name: str, value: object) -> str:
    """Writes the value of an option as in the query of a URL."""
    value = plain(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return value
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, Iterable):
        return ",".join(text_of(name, each) for each in value)
    raise Error(f"{name} must be text, a number, a boolean or a list of these, not {type(value).__name__}",
                field=name)


def texts_of(options: Mapping[str, object]) -> Dict[str, str]:
    """Writes options as in the query of a URL. Options that are None are left out."""
    return {name: text_of(name, value) for name, value in options.items() if value is not None}


def mesh_texts(options: Mapping[str, object], write_list: Callable[[Any, str], str]) -> Dict[str, str]:
    """Writes the options of a request with a mesh as in the query of a URL.

    Args:
        write_list: function that takes the value and the name of an option, and writes the value as a list in JSON.
    """
    lists = {name: write_list(options[name], name) for name in ("density", "fixed", "points")
             if options.get(name) is not None and not isinstance(options[name], str)}
    return {**texts_of({name: value for name, value in options.items() if name not in lists}), **lists}
