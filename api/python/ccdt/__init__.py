# SPDX-License-Identifier: GPL-3.0-or-later
"""Blue-noise dots: pictures as halftones, and evenly spread points.

    import ccdt
    ccdt.halftone("photo.jpg").save("dots.png")
    points = ccdt.sample([[0, 0], [4, 0], [4, 3], [2, 1], [0, 3]], 1000)    # array [1000, 2]

The functions compute in this process. :class:`Client` uses a server instead; it needs no NumPy, and the extension module
only to save files. Both are loaded when a function is first used.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any, List

from .domains import Box, Mesh, Pixels, Rectangle, Solid, Torus
from .errors import Error, Warning

if TYPE_CHECKING:
    from ._analysis import Analysis, SurfaceAnalysis, analyze
    from ._choice import choose
    from ._core import __version__
    from ._halftone import DevicePicture, Halftone, halftone
    from ._sample import Points, SurfacePoints, VolumePoints, mask, sample
    from .client import Client

__all__ = ["Analysis", "Box", "Client", "DevicePicture", "Error", "Halftone", "Mesh", "Pixels", "Points", "Rectangle",
           "Solid", "SurfaceAnalysis", "SurfacePoints", "Torus", "VolumePoints", "Warning", "analyze", "choose",
           "halftone", "mask", "sample"]

# Modules that are loaded when one of their names is first used.
_MODULES = {"Analysis": "_analysis", "analyze": "_analysis", "choose": "_choice", "Client": "client",
            "DevicePicture": "_halftone", "Halftone": "_halftone", "halftone": "_halftone", "Points": "_sample",
            "mask": "_sample", "SurfaceAnalysis": "_analysis", "SurfacePoints": "_sample", "VolumePoints": "_sample",
            "sample": "_sample", "__version__": "_core"}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module("." + _MODULES[name], __name__), name)
    globals()[name] = value
    return value


def __dir__() -> List[str]:
    return __all__
