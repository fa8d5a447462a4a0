# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors of the package. This module imports nothing but the standard library."""

from __future__ import annotations

from typing import Any, Iterable, Optional, Tuple


class Error(ValueError):
    """A request that cannot be answered.

    str(error) is readable text, which names the option, its value and the limit.

    Attributes:
        code: kind of the error: ``malformed``, ``unusable``, ``limit_exceeded``, ``not_acceptable``, ``unsupported``,
            ``unavailable`` or ``internal``; from a server, ``http_400`` and so on.
        field: name of the option, or path to the faulty value such as ``polygon/2``; empty if there is none.
        errors: all errors of the request, as pairs of field and text.
        status: HTTP status of a server's answer; None if the computation ran in this process.
    """

    def __init__(self, message: str, *, code: str = "malformed", field: str = "",
                 errors: Iterable[Tuple[str, str]] = (), status: Optional[int] = None) -> None:
        super().__init__(message)
        self.code = code
        self.field = field
        self.errors = tuple(errors) or ((field, message),)
        self.status = status

    @classmethod
    def _of(cls, code: str, errors: Iterable[Tuple[str, str]]) -> Error:
        """Creates an error from the errors of the extension module, of which the first one decides the field."""
        found = [(field.lstrip("/"), message) for field, message in errors]
        return cls("; ".join(message for _, message in found), code=code, field=found[0][0], errors=found)

    def __reduce__(self) -> Tuple[Any, ...]:
        state = {"code": self.code, "field": self.field, "errors": self.errors, "status": self.status}
        return type(self), (str(self),), state
