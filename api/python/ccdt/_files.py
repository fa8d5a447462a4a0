# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are read and written. Imports nothing but the standard library."""

from __future__ import annotations

import contextlib
import os
import secrets
import stat
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

    The data is written to a new file in the same folder, which then replaces the file and takes over its mode. A file
    that cannot be replaced, such as a pipe or /dev/stdout, is written directly.
    """
    target = os.path.realpath(path)
    if os.path.exists(path) and not os.path.isfile(target):
        with open(path, "wb") as file:
            file.write(data)
        return
    temporary = os.path.join(os.path.dirname(target), f".ccdt-{secrets.token_hex(8)}")
    try:
        with open(temporary, "xb") as file:
            with contextlib.suppress(FileNotFoundError):
                os.chmod(temporary, stat.S_IMODE(os.stat(target).st_mode))
            file.write(data)
        os.replace(temporary, target)
    except OSError as error:
        raise OSError(error.errno, error.strerror, os.fspath(path)) from None
    finally:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
