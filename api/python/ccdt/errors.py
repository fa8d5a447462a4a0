# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors and warnings of the package. This module imports nothing but the standard library."""

from __future__ import annotations

import re
import sys
import warnings
from typing import Any, Iterable, Mapping, Optional, Tuple


def _without_service(message: str) -> str:
    """Replaces the words of a message that only make sense to clients of a server."""
    return re.sub(r"this server's limit \([^)]*\)", "the limit", re.sub("^the body", "the input", message))


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
        found = [(field.lstrip("/"), _without_service(message)) for field, message in errors]
        return cls("; ".join(message for _, message in found), code=code, field=found[0][0], errors=found)

    def __reduce__(self) -> Tuple[Any, ...]:
        state = {"code": self.code, "field": self.field, "errors": self.errors, "status": self.status}
        return type(self), (str(self),), state


class Warning(UserWarning):
    """A fact about a request that the caller may not expect. The request is answered nevertheless."""


def warn(text: str) -> None:
    """Passes a text to warnings.warn, with the place from which the package was called."""
    frame, level = sys._getframe(), 1
    while frame.f_back is not None and frame.f_globals.get("__package__") == __package__:
        frame, level = frame.f_back, level + 1
    warnings.warn(text, Warning, stacklevel=level)


def warn_of(members: Mapping[str, Any]) -> Tuple[str, ...]:
    """Warns of the remarks in the members ``warnings`` and ``repaired`` of an answer. Returns the texts."""
    texts = [each["detail"] for each in members.get("warnings", ())]
    repairs = members.get("repaired", ())
    if repairs:
        others = ", among others" if len(repairs) > 1 else ""
        texts.append(f"the domain was repaired: {repairs[0]['detail']}{others}")
    for text in texts:
        warn(text)
    return tuple(texts)
