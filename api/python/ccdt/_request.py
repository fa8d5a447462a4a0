# SPDX-License-Identifier: GPL-3.0-or-later
"""Conversion of Python values to requests of the extension module, and of its answers to arrays."""

from __future__ import annotations

import ast
import base64
import io
import json
import os
from typing import Any, Dict, Mapping, Optional, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._density import density_of, ground_of_web_mercator, is_web_mercator
from ._files import read_file
from ._libraries import is_array, positions_of
from ._options import Progress, mesh_texts
from .domains import Mesh, Solid, domain_member, jsonable, region_members
from .errors import Error, warn, warn_of

_ma: Any = np.ma  # its functions have no types

# A picture for the extension module: the bytes of a file, or an array [height, width, channels].
Picture = Union[bytes, npt.NDArray[Any]]


def running(threads: Optional[int] = None, progress: Progress = None) -> _core.Running:
    """Returns the settings of a computation. By default, it uses all processors of this process."""
    if threads is None:
        threads = len(os.sched_getaffinity(0))
    if threads < 1:
        raise Error(f"threads must be at least 1, not {threads}", field="threads")
    return _core.Running(threads, progress)


def warn_of_answer(answer: _core.Answer) -> Tuple[str, ...]:
    """Warns of the remarks in an answer that is not JSON. Returns the texts."""
    return warn_of({"warnings": json.loads(answer.warnings or "[]"), "repaired": json.loads(answer.repaired or "[]")})


def array_picture(array: npt.NDArray[Any], name: str = "picture") -> npt.NDArray[Any]:
    """Converts an array for the extension module. Copies it only if its type or its layout requires that.

    Masked pixels become transparent.
    """
    shape = array.shape
    if not (array.ndim == 2 or array.ndim == 3 and 1 <= shape[2] <= 4):
        raise Error(f"{name} must have the shape [height, width] or [height, width, 1 to 4], not {list(shape)}",
                    field=name)
    if array.size == 0:
        raise Error(f"{name} must have at least one pixel, not the shape {list(shape)}", field=name)
    hidden = masked_values(array)
    array = _ma.filled(array, 0)
    if array.dtype == np.bool_:
        array = array * np.uint8(255)
    elif array.dtype.kind == "f":
        low, high = float(array.min()), float(array.max())
        if not (low >= 0 and high <= 1):  # also true for NaN
            raise Error(f"{name} of floats must have values from 0 to 1, not from {low:g} to {high:g}", field=name)
        array = array.astype(np.float32, copy=False)
    elif array.dtype.kind not in "iu":
        raise Error(f"{name} must have the type bool, uint8, uint16 or float, not {array.dtype}", field=name)
    elif array.dtype.kind == "i" or array.dtype.itemsize > 2:
        if array.min() < 0 or array.max() > 255:
            raise Error(f"{name} of {array.dtype} must have values from 0 to 255, not from {array.min()} to "
                        f"{array.max()}; use uint16 for values to 65535", field=name)
        if array.max() == 1:
            warn(f"{name} of {array.dtype} has no values above 1, which are almost black: white is 255, or True of bool")
        array = array.astype(np.uint8)
    native = array.astype(array.dtype.newbyteorder("="), copy=False)
    pixels = np.ascontiguousarray(native).reshape(shape[0], shape[1], -1)
    if hidden is None:
        return pixels
    opaque = 1 if pixels.dtype.kind == "f" else np.iinfo(pixels.dtype).max
    alpha = pixels[..., -1] if pixels.shape[2] % 2 == 0 else np.full(shape[:2], opaque, pixels.dtype)
    alpha = np.where(hidden.reshape(pixels.shape).any(axis=2), pixels.dtype.type(0), alpha)
    return np.ascontiguousarray(np.dstack([pixels[..., :(pixels.shape[2] - 1) // 2 * 2 + 1], alpha]))


def masked_values(value: Any) -> Optional[npt.NDArray[np.bool_]]:
    """Returns which values of an array are masked, or None if none are."""
    mask = _ma.getmaskarray(value) if isinstance(value, _ma.MaskedArray) else None
    return mask if mask is not None and mask.any() else None


def pillow_picture(image: Any, name: str) -> Picture:
    """Returns the upright pixels of an image of Pillow, or a TIFF file if its colours must be converted."""
    from PIL import ImageOps

    profile = image.info.get("icc_profile")
    image = ImageOps.exif_transpose(image)
    if image.mode == "P":
        image = image.convert("RGBA" if "transparency" in image.info else "RGB")
    if image.mode in ("L", "LA", "RGB", "RGBA", "1", "I;16") and not profile:
        return array_picture(np.asarray(image), name)
    file = io.BytesIO()
    image.save(file, "TIFF", icc_profile=profile)
    return file.getvalue()


def picture_of(source: Any, name: str = "picture") -> Picture:
    """Converts a picture for the extension module."""
    if hasattr(source, "getexif"):  # an image of Pillow
        return pillow_picture(source, name)
    if is_array(source) or hasattr(source, "__array_interface__"):
        return array_picture(source if isinstance(source, _ma.MaskedArray) else np.asarray(source), name)
    return read_file(source, name, "an array, an image of Pillow, ")


def array_json(value: Any, name: str) -> str:
    """Writes an array of numbers as JSON."""
    value = positions_of(value)
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as reason:
        raise Error(f"{name} must be numbers in lists of equal length: {reason}", field=name) from None
    check_numbers(array, masked_values(value), name)
    return _core.json_of(array)


def check_numbers(array: npt.NDArray[Any], hidden: Optional[npt.NDArray[np.bool_]], name: str) -> None:
    """Raises an error that names the first value that is not finite, or that is masked."""
    usable = np.isfinite(array)
    if hidden is not None:
        usable &= ~hidden
    if not usable.all():
        index = tuple(int(i) for i in np.argwhere(~usable)[0])
        path = "".join(f"[{i}]" for i in index)
        value = array[index] if hidden is None or not hidden[index] else "masked"
        raise Error(f"{name}{path} must be finite, not {value}", field="/".join([name, *(str(i) for i in index)]))


def json_of(value: Any, name: str) -> str:
    """Writes a value as JSON: arrays, objects with a geometry, and what the module json can write."""
    if isinstance(value, np.ndarray) and value.ndim > 0:
        return array_json(value, name)
    try:
        return json.dumps(value, default=jsonable, allow_nan=False)
    except (TypeError, ValueError) as reason:
        path = "/".join(map(str, (name, *(_path_of_infinite(value) or ()))))
        text = f"{name} is not valid: {reason}" if path == name else f"{path} must be finite"
        raise Error(text, field=path) from None


def _path_of_infinite(value: Any) -> Optional[Tuple[Any, ...]]:
    """Returns the keys and indices that lead to the first number that is not finite, or None."""
    if isinstance(value, float) and not np.isfinite(value):
        return ()
    children = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, (list, tuple)) else ()
    for key, child in children:
        path = _path_of_infinite(child)
        if path is not None:
            return key, *path
    return None


def points_json(value: Any, name: str) -> str:
    """Writes a list of positions as JSON."""
    array = value if isinstance(value, np.ndarray) else None  # with its mask
    if array is None and isinstance(value, (list, tuple)):
        array = np.asarray(value, dtype=object)
    if array is None or array.ndim != 2 or array.shape[1] != 2:
        shape = None if array is None else list(array.shape)
        raise Error(f"{name} must be positions [n, 2], not {shape or type(value).__name__}", field=name)
    return array_json(value, name)


def density_values(density: Any) -> npt.NDArray[Any]:
    """Returns a density as an array, in which masked values are 0. Values that are NaN are 0 with a warning."""
    array = np.asarray(_ma.filled(density, 0))
    missing = np.isnan(array) if array.dtype.kind == "f" else np.zeros(0, bool)
    if not missing.any():
        return array
    warn(f"density has {missing.sum()} values that are NaN: they count as 0")
    return np.where(missing, array.dtype.type(0), array)


def density_json(density: Any) -> str:
    """Writes a density as JSON: a grid of values, or the file of a picture."""
    if is_array(density):
        grid = density_values(density)
        if grid.ndim != 2:
            raise Error(f"density must have the shape [rows, columns], not {list(grid.shape)}", field="density")
        return (f'{{"width":{grid.shape[1]},"height":{grid.shape[0]},'
                f'"values":{array_json(grid.ravel(), "density")}}}')
    return picture_json(density, "density")


def picture_json(source: Any, name: str) -> str:
    """Writes the file of a picture as JSON."""
    return json.dumps({"image": base64.b64encode(read_file(source, name)).decode()})


def region_texts(area: Mapping[str, Any]) -> Dict[str, str]:
    """Writes the members of a request that give its area, as from region_members()."""
    return {name: points_json(region, name) if name == "polygon" else json_of(region, name)
            for name, region in area.items()}


def sample_body(domain: Any, area: Mapping[str, Any], members: Mapping[str, Any]) -> Tuple[str, bool]:
    """Writes a request for points. Returns it, and whether it contains pictures.

    Args:
        area: members of the request that give its area, as from region_members().
    """
    members = {name: value for name, value in members.items() if value is not None}
    texts: Dict[str, str] = {}
    if "density" in members:
        members["density"] = density_of(members["density"], domain, {**area, **members})
    elif is_web_mercator(domain) and "coordinates" not in members:
        members["density"] = density_of(ground_of_web_mercator, domain, area)
    texts.update(region_texts(area))
    for name, value in members.items():
        if name == "density":
            texts[name] = density_json(value)
        elif name == "fixed":
            texts[name] = json_of(positions_of(value), name)
        elif name == "exclude" and not isinstance(value, dict):
            texts[name] = picture_json(value, name)
        else:
            texts[name] = json_of(value, name)
    has_pictures = any('"image"' in texts.get(name, "")[:16] for name in ("density", "exclude"))
    return "{" + ",".join(f"{json.dumps(name)}:{text}" for name, text in texts.items()) + "}", has_pictures


def surface_request(domain: Any, members: Mapping[str, Any]) -> Tuple[Any, Dict[str, str]]:
    """Returns the arguments of the extension module for points on a mesh: the mesh, and the options as text."""
    density = members.get("density")
    if density is not None and not isinstance(density, str):
        members = {**members, "density": density_values(density_of(density, domain, {}))}
    options = mesh_texts(members, array_json)
    if not isinstance(domain, Mesh):
        return read_file(domain, "domain"), options
    arrays = [_mesh_array(domain.vertices, "vertices", np.float64, 3),
              _mesh_array(domain.triangles, "triangles", np.int64, 3)]
    colors = None if domain.colors is None else np.asarray(domain.colors)
    if colors is not None and colors.dtype.kind != "f":
        colors = colors / 255
    for values, name, columns in ((colors, "colors", 3), (domain.texture, "texture", 2)):
        arrays.append(_mesh_array(np.zeros((0, columns)) if values is None else values, name, np.float64, columns))
        if values is not None and len(arrays[-1]) != len(arrays[0]):
            raise Error(f"{name} must have a row for each of the {len(arrays[0])} vertices, not {len(arrays[-1])}",
                        field=name)
    return tuple(arrays), options


def volume_request(domain: Any, members: Mapping[str, Any]) -> Tuple[Any, Dict[str, Any]]:
    """Returns the arguments of the extension module for points in space: the body, and the options as text."""
    density = members.get("density")
    rest = {name: value for name, value in members.items() if name != "density"}
    if density is not None:
        density = _voxel_file(density_of(density, domain, {}))
    if isinstance(domain, Solid):
        mesh, options = surface_request(domain.mesh, {**rest, "domain": "solid"})
        return mesh, options if density is None else {**options, "density": density}
    if density is None:
        return sample_body(domain, region_members(domain), rest)[0], {}
    return density, {**mesh_texts(rest, array_json), "domain": json_of(domain_member(domain), "domain")}


def _voxel_file(density: Any) -> bytes:
    """Returns voxels as the bytes of a file."""
    if not is_array(density):
        return read_file(density, "density")
    array = density_values(density)
    if array.ndim != 3 or array.dtype.kind not in "biuf":
        raise Error("density must be an array [depth, height, width] of numbers or booleans, not an array of the type "
                    f"{array.dtype} with the shape {array.shape}", field="density")
    if array.dtype.kind == "f" and array.dtype.itemsize not in (4, 8):
        array = array.astype(np.float64)
    file = io.BytesIO()
    np.save(file, np.ascontiguousarray(array, array.dtype.newbyteorder("<")))
    return file.getvalue()


def _mesh_array(value: Any, name: str, dtype: Any, columns: int) -> npt.NDArray[Any]:
    array = np.asarray(getattr(value, "simplices", value))
    hidden = masked_values(value)
    if hidden is not None:
        check_numbers(array, hidden, name)
    if array.ndim != 2 or array.shape[1] != columns or array.dtype.kind not in ("fiu" if dtype == np.float64 else "iu"):
        raise Error(f"{name} must be {'numbers' if dtype == np.float64 else 'integers'} of the shape [n, {columns}], not "
                    f"{array.dtype} {list(array.shape)}", field=name)
    return np.ascontiguousarray(array, dtype=dtype)


def npy_array(answer: _core.Answer) -> npt.NDArray[Any]:
    """Returns the array in an NPY file, without a copy."""
    head = memoryview(answer)  # type: ignore[arg-type]
    end = 10 + int.from_bytes(head[8:10], "little")
    header = ast.literal_eval(bytes(head[10:end]).decode("latin-1"))
    flat: npt.NDArray[Any] = np.frombuffer(head, dtype=header["descr"], offset=end)
    return flat.reshape(header["shape"])
