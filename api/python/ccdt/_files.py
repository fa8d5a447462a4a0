# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are read and written. Imports nothing but the standard library."""

from __future__ import annotations

import os
from typing import Any, Union

from .errors import Error

Path = Union[str, "os.PathLike[str]"]


def read_file(source: Any, name: str, others: str = "") -> bytes:
    """Returns the bytes of a file: given as bytes, as a path, or as an open file. Errors name the `others`, too."""
    if isinstance(source, (bytes, bytearray, memoryview)):
        return bytes(source)
    if isinstance(source, (str, os.PathLike)):
        with open(source, "rb") as file:
            return file.read()
    if hasattr(source, "read"):
        return bytes(source.read())
    raise Error(f"{name} must be {others}a path, bytes or an open file, not {type(source).__name__}", field=name)


def write_file(path: Path, data: Any) -> None:
    """Writes a file. A failure leaves an existing file unchanged.

    The data is written to a new file in the same folder, which then replaces the file and takes over its mode. A link
    to a file stays. Everything that is not a regular file, such as a pipe or /dev/stdout, is written directly.
    """
    from . import _core  # loaded only now, because the client reads files without it

    _core.write_file(os.fsencode(path), data)
