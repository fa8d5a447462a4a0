# SPDX-License-Identifier: GPL-3.0-or-later
"""Results that can be written as files."""

from __future__ import annotations

import os
from typing import Any, Dict, Optional, Tuple

import numpy.typing as npt

from . import _core
from ._files import Path, write_file
from ._request import running, warn_of_answer
from .errors import Error


def _formats() -> Dict[str, str]:
    """Returns the format of each extension of file names."""
    formats = {"tif": "tiff", "nc": "gcode", "ngc": "gcode", "gc": "gcode"}
    for name, extension in _core.file_extensions():
        formats.setdefault(extension, name)
        formats.setdefault(name, name)
    return formats


def format_of(path: Path) -> str:
    """Returns the format that the extension of a file's name means."""
    extension = os.path.splitext(os.fspath(path))[1].lower().lstrip(".")
    formats = _formats()
    if extension not in formats:
        raise Error(f"format: the extension of {os.fspath(path)!r} must be one of {', '.join(sorted(formats))}",
                    field="format")
    return formats[extension]


class Plotted:
    """A result that matplotlib can draw."""

    _is_in_space = False

    def plot(self, ax: Any = None, **options: Any) -> Any:
        """Draws the result with matplotlib.

        Args:
            ax: axes of matplotlib; by default, the current ones or, for points in space, new ones.
            **options: options of matplotlib: of imshow for pictures, of scatter for points, of plot for curves.

        Returns:
            the axes.
        """
        if ax is None:
            import matplotlib.pyplot

            ax = matplotlib.pyplot.subplot(projection="3d") if self._is_in_space else matplotlib.pyplot.gca()
        self._plot(ax, options)
        return ax

    def _plot(self, ax: Any, options: Dict[str, Any]) -> None:
        raise NotImplementedError


class Drawing(Plotted):
    """A result that can be written in several formats."""

    def _answer(self, format: str) -> _core.Answer:
        """Writes the result. The empty format is that of the request."""
        raise NotImplementedError

    def write(self, format: str = "") -> bytes:
        """Returns the bytes of a file.

        Args:
            format: name of a format, such as ``png``, ``svg``, ``csv`` or ``json``. By default, the format of the
                request.
        """
        return bytes(self._answer(format))  # type: ignore[call-overload, no-any-return]

    def save(self, path: Path, format: Optional[str] = None) -> None:
        """Writes a file.

        Args:
            path: name of the file. It is replaced when all bytes are written, so a failure does not change it.
            format: name of a format. By default, the extension of the path decides. A drawing with the option
                ``split`` is saved as ``.zip``, by default in the format of the request.
        """
        is_archive = os.fspath(path).lower().endswith(".zip")
        answer = self._answer(format or ("" if is_archive else format_of(path)))
        if is_archive != (bytes(memoryview(answer)[:4]) == b"PK\3\4"):  # type: ignore[arg-type]
            raise Error("split makes several files, in an archive: the name of the file must end with .zip"
                        if not is_archive else ".zip is the extension of drawings with the option split", field="split")
        write_file(path, answer)

    def image(self) -> npt.NDArray[Any]:
        """Returns the drawing as pixels: uint8 [height, width] for greys, or [height, width, 3 or 4] for colours.

        Values are sRGB. A fourth channel is alpha. 0 is black, 255 is white.
        """
        return _core.png_pixels(self._answer("png"))

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> npt.NDArray[Any]:
        """Returns :meth:`image`, so that functions such as matplotlib's imshow accept the result."""
        return self.image().astype(dtype, copy=False) if dtype is not None else self.image()

    def _plot(self, ax: Any, options: Dict[str, Any]) -> None:
        image = self.image()
        greys = {"cmap": "gray", "vmin": 0, "vmax": 255} if image.ndim == 2 else {}
        ax.imshow(image, **{**greys, **options})

    def _repr_png_(self) -> Optional[bytes]:
        return self.write("png")


class Kept:
    """A computation of the extension module, which is repeated after unpickling when it is needed.

    The same request gives the same result, so the request is all that has to be stored.
    """

    def __init__(self, compute: Any, *request: Any) -> None:
        self._compute = compute
        self._request = request
        self.result: Any = None
        self.warnings: Tuple[str, ...] = ()

    def run(self, threads: Optional[int], progress: Any) -> Any:
        self.result = self._compute(*self._request, running(threads, progress))
        return self.result

    def start(self, threads: Optional[int], progress: Any) -> _core.Answer:
        """Computes, and returns the NPY file of the result. Warns of the remarks in it."""
        answer: _core.Answer = self.run(threads, progress).write("npy", running(threads))
        self.warnings = warn_of_answer(answer)
        return answer

    def write(self, format: str) -> _core.Answer:
        result = self.run(None, None) if self.result is None else self.result
        answer: _core.Answer = result.write(format, running())
        return answer

    def __getstate__(self) -> Dict[str, Any]:
        return {**self.__dict__, "result": None}
