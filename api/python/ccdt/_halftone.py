# SPDX-License-Identifier: GPL-3.0-or-later
"""Halftones: pictures as dots, and as the pixels of a device."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Tuple, overload

import numpy as np
import numpy.typing as npt

from . import _core
from ._drawing import Drawing, Kept
from ._libraries import seed_of
from ._options import DeviceOptions, HalftoneOptions, Progress, check_names, format_for, texts_of
from ._request import npy_array, picture_of, running, warn_of_answer

if TYPE_CHECKING:
    from typing_extensions import Unpack

Floats = npt.NDArray[np.float64]
Table = List[Tuple[str, str]]


class Halftone(Drawing):
    """A picture as dots. Positions are in pixels of the picture; y points down, the first pixel is [0, 1] x [0, 1].

    Files and pixels show exactly the dots of ``points`` or, with ``dots="both"``, the ink inside ``rings``.
    """

    def __init__(self, kept: Kept, table: Floats, radius: Optional[float]) -> None:
        self._kept = kept
        self._table = table
        self._radius = radius
        self._described: Optional[Tuple[Dict[str, Any], List[List[Floats]]]] = None

    def _answer(self, format: str) -> _core.Answer:
        return self._kept.write(format)

    @property
    def warnings(self) -> Tuple[str, ...]:
        """Texts of the warnings that :func:`ccdt.halftone` gave."""
        return self._kept.warnings

    @property
    def points(self) -> Floats:
        """Centres of the dots, float64 [n, 2], grouped by ink; with ``dots="both"``, the sites that all inks share."""
        return self._table[:, :2]

    @property
    def radius(self) -> Optional[float]:
        """Radius of the dots, in pixels of the picture; None if it is chosen when the dots are drawn.

        With ``dots="both"``, the radius of the largest dots, which cover half of an area of luminance 1/2.
        """
        return self._radius

    @property
    def ink(self) -> Optional[npt.NDArray[np.uint8]]:
        """Index of each dot's ink in ``inks``, uint8 [n]; None if there is a single ink, or with ``dots="both"``."""
        return self._table[:, 2].astype(np.uint8) if self._table.shape[1] == 3 else None

    @property
    def rings(self) -> List[List[Floats]]:
        """Outlines of each ink with ``dots="both"``, float64 [corners, 2] each, by the even-odd rule; otherwise empty.

        They are those of the single ink, or of the inks in ``inks``.
        """
        return self._describe()[1]

    @property
    def inks(self) -> List[str]:
        """Names of the inks; empty if there is a single ink."""
        return [each["name"] for each in self.info.get("inks", ())]

    @property
    def width(self) -> int:
        """Width of the picture, or of the part that is drawn, in pixels."""
        return int(self.info["width"])

    @property
    def height(self) -> int:
        """Height of the picture, or of the part that is drawn, in pixels."""
        return int(self.info["height"])

    @property
    def info(self) -> Dict[str, Any]:
        """Members of the service's JSON answer, without lists of dots and outlines."""
        return self._describe()[0]

    def _plot(self, ax: Any, options: Dict[str, Any]) -> None:
        super()._plot(ax, {"extent": (0, self.width, self.height, 0), **options})

    def __len__(self) -> int:
        return len(self._table)

    def __repr__(self) -> str:
        return f"<ccdt.Halftone of {len(self)} dots>"

    def _describe(self) -> Tuple[Dict[str, Any], List[List[Floats]]]:
        """Returns ``info`` and ``rings``, which are read only once."""
        if self._described is None:
            members = json.loads(self.write("json"))
            parts = [members, *members.get("inks", ())]
            for part in parts:
                part.pop("points", None)
            rings = [[np.array(ring, dtype=np.float64) for ring in part.pop("rings")] for part in parts
                     if "rings" in part]
            self._described = members, rings
        return self._described


class DevicePicture(Drawing):
    """A picture that has exactly the pixels and the colours of a device.

    Attributes:
        warnings: texts of the warnings that :func:`ccdt.halftone` gave.
    """

    def __init__(self, picture: Any, linear: bool, options: Mapping[str, str], answer: _core.Answer) -> None:
        self._picture = picture
        self._linear = linear
        self._options = dict(options)
        self._answers = {self._options.get("format", ""): answer}
        self.warnings = warn_of_answer(answer)

    def _answer(self, format: str) -> _core.Answer:
        format = format or self._options.get("format", "")
        if format not in self._answers:
            options = {**self._options, "format": format}
            self._answers[format] = _core.answer_device(self._picture, self._linear, list(options.items()), running())
        return self._answers[format]

    def __getstate__(self) -> Dict[str, Any]:
        return {**self.__dict__, "_answers": {}}

    @property
    def width(self) -> int:
        """Width in pixels."""
        return int(self.image().shape[1])

    @property
    def height(self) -> int:
        """Height in pixels."""
        return int(self.image().shape[0])

    def __repr__(self) -> str:
        return f"<ccdt.DevicePicture for {self._options['device']}>"


@overload
def halftone(picture: Any, sites: Optional[int] = None, *, device: None = None, format: Optional[str] = None,
             linear: bool = False, threads: Optional[int] = None, progress: Progress = None,
             **options: Unpack[HalftoneOptions]) -> Halftone: ...
@overload
def halftone(picture: Any, *, device: str, format: Optional[str] = None, linear: bool = False,
             threads: Optional[int] = None, progress: Progress = None,
             **options: Unpack[DeviceOptions]) -> DevicePicture: ...
def halftone(picture: Any, sites: Optional[int] = None, *, device: Optional[str] = None,
             format: Optional[str] = None, linear: bool = False, threads: Optional[int] = None,
             progress: Progress = None, **options: Any) -> Any:
    """Draws a picture with dots, or in the pixels and colours of a device.

    Options, ranges, defaults, dots and bytes are those of ``POST /halftone`` of ccdt-server.

    Args:
        picture: array [height, width] or [height, width, channels] of bool, uint8, uint16, other integers from 0 to
            255, or floats from 0 to 1; an image of Pillow; or a file as a path, bytes, or an open file. One channel is grey, three are red, green
            and blue; a second or a fourth channel is alpha.
        sites: exact number of dots. By default, it is chosen for the picture and the size of the drawing.
        device: name of a device, such as ``"spectra6"``. The result is then a :class:`DevicePicture`.
        format: format for which defaults are chosen, such as the size of the drawing. The default is ``"png"``, a
            drawing for a screen, or a format that has the given options, such as ``"svg"`` for ``paper``. Results can be written in other formats as well; the dots stay the same.
        linear: whether an array has linear light. By default, values are sRGB, as in most pictures.
        threads: number of threads; by default all processors. Results do not depend on it.
        progress: function that receives the completed share of the work, 0 to 1.
        **options: see api/halftone/README.md: ``seed``, ``color``, ``dots``, ``width``, ``quality``, ``palette`` and others.
            Options that are None are left out.

    Raises:
        Error: an option or the picture is not usable. The message names the option and its limit.
        TypeError: there is no such option.

    Warns:
        Warning: the answer has remarks, which the attribute ``warnings`` of the result keeps.
    """
    check_names("halftone", options, HalftoneOptions if device is None else DeviceOptions)
    if "seed" in options:
        options["seed"] = seed_of(options["seed"])
    if device is None and format is None:
        format = format_for(options, None)
    texts = texts_of({"sites": sites, "device": device, **options, "format": format})
    pixels = picture_of(picture)
    if device is not None:
        answer = _core.answer_device(pixels, linear, list(texts.items()), running(threads, progress))
        return DevicePicture(pixels, linear, texts, answer)
    kept = Kept(_core.Halftone, pixels, linear, list(texts.items()))
    answer = kept.start(threads, progress)
    return Halftone(kept, npy_array(answer), answer.radius)
