# SPDX-License-Identifier: GPL-3.0-or-later
"""Client of a ccdt-server. Imports nothing but the standard library.

    from ccdt.client import Client
    client = Client("http://localhost:8080")
    client.halftone("photo.jpg", sites=20000).save("dots.png")
"""

from __future__ import annotations

import contextlib
import http.client
import json
import os
import random
import secrets
import time
import urllib.error
import urllib.parse
import urllib.request
from typing import Any, Dict, Iterator, List, Mapping, Optional, Tuple

from ._files import Path, read_file, write_file
from ._options import Progress, mesh_texts, texts_of
from .domains import Mesh, Solid, is_mesh_file, jsonable, region_members
from .errors import Error, warn_of

Request = Tuple[str, bytes, str]  # path with query, body, media type

# Statuses after which the same request may succeed: too many requests, and no time or no process at present.
TEMPORARY = (429, 503)

POLL_INTERVAL = 1.0  # seconds between two requests for the state of a job


class Answer:
    """Answer of a server.

    Attributes:
        body: the bytes.
        media_type: media type of the body.
        headers: header fields, with names in lower case.
        warnings: texts of the warnings that the server gave.
    """

    def __init__(self, body: bytes, headers: Mapping[str, str]) -> None:
        self.body = body
        self.headers = {name.lower(): value for name, value in headers.items()}
        self.media_type = self.headers.get("content-type", "").partition(";")[0]
        self.warnings = warn_of(self._remarks())

    def _remarks(self) -> Any:
        """Returns the members ``warnings`` and ``repaired``, which other formats than JSON have as headers."""
        if self.media_type == "application/json" and (b'"warnings":[{' in self.body or b'"repaired":[{' in self.body):
            return self.json()
        return {name: json.loads(self.headers.get("x-" + name, "[]")) for name in ("warnings", "repaired")}

    def __bytes__(self) -> bytes:
        return self.body

    def json(self) -> Any:
        """Returns the value in a JSON answer."""
        return json.loads(self.body)

    def save(self, path: Path) -> None:
        """Writes the body to a file. A failure does not change it."""
        write_file(path, self.body)

    def _repr_png_(self) -> Optional[bytes]:
        return self.body if self.media_type == "image/png" else None

    def __repr__(self) -> str:
        return f"<ccdt.client.Answer: {len(self.body)} bytes of {self.media_type}>"


class Job:
    """A request that the server computes in the background.

    Attributes:
        path: path of the job on the server.
    """

    def __init__(self, client: Client, path: str) -> None:
        self._client = client
        self.path = path

    def status(self) -> Dict[str, Any]:
        """Returns the state of the job: ``status``, ``progress`` from 0 to 1, and others."""
        state: Dict[str, Any] = self._client._request("GET", self.path).json()
        return state

    def events(self) -> Iterator[Dict[str, Any]]:
        """Yields the state of the job at once, after each step, and at its end, which ends the iteration.

        The states come from the event stream of the job or, after a loss of the stream, from polling.
        """
        # A proxy may cut a stream within an event, whose rest then is no JSON.
        with contextlib.suppress(OSError, http.client.HTTPException, ValueError):
            for state in self._stream():
                yield state
                if state["finished"] is not None:
                    return
        yield from self._polls()

    def _stream(self) -> Iterator[Dict[str, Any]]:
        """Yields the state of the job from its server-sent events until the stream ends."""
        with self._client._open("GET", self.path + "/events") as stream:
            for line in stream:
                key, _, value = line.decode().partition(": ")
                if key == "data":
                    yield json.loads(value)

    def _polls(self) -> Iterator[Dict[str, Any]]:
        """Yields the state of the job by polling. Tolerates that the server cannot be reached for a while."""
        reached = time.monotonic()
        while True:
            try:
                state = self.status()
            except (OSError, http.client.HTTPException):
                if time.monotonic() - reached > self._client._patience:
                    raise
            else:
                yield state
                if state["finished"] is not None:
                    return
                reached = time.monotonic()
            time.sleep(POLL_INTERVAL)

    def result(self, progress: Progress = None) -> Answer:
        """Waits for the end of the job, and returns its answer.

        Args:
            progress: function that receives the completed share of the work, 0 to 1.

        Raises:
            Error: the computation failed, or was cancelled.
        """
        for state in self.events():
            if progress is not None:
                progress(state["progress"])
        return self._client._request("GET", self.path + "/result")

    def cancel(self) -> None:
        """Cancels the job, or deletes it if it has ended."""
        self._client._request("DELETE", self.path)


class Client:
    """Sends requests to a ccdt-server. Several threads may use one client.

    Args:
        url: address of the server, such as ``http://localhost:8080``.
        key: API key, if the server requires one.
        timeout: seconds without any byte from the server, after which a request fails.
        patience: seconds for which a request is repeated while the server is busy (429 or 503). The server says how
            long to wait between two attempts. While a job runs, the server may also be unreachable for this time.
    """

    def __init__(self, url: str, key: Optional[str] = None, *, timeout: float = 120, patience: float = 60) -> None:
        if urllib.parse.urlsplit(url).scheme not in ("http", "https"):
            raise Error(f"url must begin with http:// or https://, not {url!r}", field="url")
        self._url = url.rstrip("/")
        self._key = key
        self._timeout = timeout
        self._patience = patience

    def halftone(self, picture: Any, sites: Optional[int] = None, *, preset: Optional[str] = None,
                 progress: Progress = None, **options: Any) -> Answer:
        """Draws a picture with dots.

        Args:
            picture: file of a picture, as a path, bytes, or an open file.
            sites: exact number of dots; by default chosen by the server.
            preset: name of options that the operator of the server has defined. Other options override them.
            progress: function that receives the completed share of the work, 0 to 1. The request is then a job, which
                is cancelled if the function raises an exception.
            **options: options of ``POST /halftone``, such as ``format="svg"``. Options that are None are left out.

        Raises:
            Error: the server refused the request. The message names the option and its limit.
            OSError: the server cannot be reached.
        """
        return self._compute(_halftone(picture, {"preset": preset, "sites": sites, **options}), progress)

    def sample(self, domain: Any, sites: Any = None, *, preset: Optional[str] = None, progress: Progress = None,
               **options: Any) -> Answer:
        """Spreads points evenly over an area or a surface.

        Args:
            domain: as for :func:`ccdt.sample`: corners of a polygon, GeoJSON, an object with ``__geo_interface__``,
                a torus, a rectangle, a box, a solid or a raster of pixels, or the file of a mesh. A :class:`ccdt.Mesh` is
                not accepted. In space, a density is a dict, like the member of ``POST /sample``.
            sites: exact number of points.
            preset: as for :meth:`halftone`; for the file of a mesh only.
            progress: as for :meth:`halftone`.
            **options: members of the body of ``POST /sample``, such as ``format="csv"``; for a mesh, its options.
        """
        return self._compute(_sample(domain, {"preset": preset, "sites": sites, **options}), progress)

    def analyze(self, points: Any, domain: Any = None, *, preset: Optional[str] = None, progress: Progress = None,
                **options: Any) -> Answer:
        """Measures how evenly points are spread.

        Args:
            points: positions [n, 2] or, in space and on a surface, [n, 3].
            domain: a torus, a rectangle, a box, the file of a mesh, or polygons in the plane as for :meth:`sample`; the
                unit torus by default.
            preset: as for :meth:`sample`.
            progress: as for :meth:`halftone`.
            **options: members of the body of ``POST /analyze``, such as ``format="png"``; for a mesh, its options.
        """
        return self._compute(_analyze(points, {"preset": preset, "domain": domain, **options}), progress)

    def choose(self, points: Any, sites: int, *, preset: Optional[str] = None, progress: Progress = None,
               **options: Any) -> Answer:
        """Chooses exactly ``sites`` of given points, evenly spread.

        Args:
            points: positions [n, 2] or [n, 3]; or a file with a record for each point (CSV, GeoJSON, NPY or PLY), as a
                path, bytes or an open file. The answer then has the format of the file, unless ``format`` is given.
            sites: number of points to choose.
            preset: as for :meth:`sample`; for a file only.
            progress: as for :meth:`halftone`.
            **options: members of the body of ``POST /sample``, such as ``priority=[...]``; for a file, its options, such
                as ``priority="quality"``.
        """
        return self._compute(_choose(points, {"preset": preset, "sites": sites, **options}), progress)

    def start_halftone(self, picture: Any, sites: Optional[int] = None, *, preset: Optional[str] = None,
                       **options: Any) -> Job:
        """Starts a job. The parameters are those of :meth:`halftone`."""
        return self._start(_halftone(picture, {"preset": preset, "sites": sites, **options}))

    def start_sample(self, domain: Any, sites: Any = None, *, preset: Optional[str] = None, **options: Any) -> Job:
        """Starts a job. The parameters are those of :meth:`sample`."""
        return self._start(_sample(domain, {"preset": preset, "sites": sites, **options}))

    def start_analyze(self, points: Any, domain: Any = None, *, preset: Optional[str] = None, **options: Any) -> Job:
        """Starts a job. The parameters are those of :meth:`analyze`."""
        return self._start(_analyze(points, {"preset": preset, "domain": domain, **options}))

    def capabilities(self) -> Dict[str, Any]:
        """Returns the formats, the options and the limits of the server."""
        offered: Dict[str, Any] = self._request("GET", "/capabilities").json()
        return offered

    def _compute(self, request: Request, progress: Progress) -> Answer:
        if progress is None:
            return self._request("POST", *request)
        job = self._start(request)
        try:
            return job.result(progress)
        finally:
            with contextlib.suppress(Error, OSError):
                job.cancel()

    def _start(self, request: Request) -> Job:
        answer = self._request("POST", *request, prefer="respond-async")
        return Job(self, answer.headers["location"])

    def _request(self, method: str, path: str, body: Optional[bytes] = None, media_type: str = "",
                 prefer: str = "") -> Answer:
        with self._open(method, path, body, media_type, prefer) as response:
            return Answer(response.read(), response.headers)

    def _open(self, method: str, path: str, body: Optional[bytes] = None, media_type: str = "",
              prefer: str = "") -> Any:
        """Sends a request, again while the server is busy. Returns the response, whose body is not read."""
        fields = {"Content-Type": media_type, "Prefer": prefer,
                  "Authorization": f"Bearer {self._key}" if self._key else ""}
        request = urllib.request.Request(self._url + path, data=body, method=method,
                                         headers={name: value for name, value in fields.items() if value})
        end = time.monotonic() + self._patience
        while True:
            try:
                return urllib.request.urlopen(request, timeout=self._timeout)
            except urllib.error.HTTPError as refusal:
                with refusal:
                    wait = _seconds_to_wait(refusal.headers.get("Retry-After"))
                    if refusal.code not in TEMPORARY or time.monotonic() + wait > end:
                        raise _error_of(refusal) from None
                time.sleep(wait)


def _halftone(picture: Any, options: Mapping[str, Any]) -> Request:
    query = urllib.parse.urlencode(texts_of(options))
    return "/halftone" + ("?" + query if query else ""), read_file(picture, "picture"), "application/octet-stream"


def _sample(domain: Any, members: Mapping[str, Any]) -> Request:
    if isinstance(domain, Solid):
        members = {**members, "domain": "solid"}
        domain = domain.mesh
    if is_mesh_file(domain):
        return _mesh_request("/sample", domain, members)
    return "/sample", _body({**region_members(domain), **members}), "application/json"


def _choose(points: Any, members: Mapping[str, Any]) -> Request:
    if isinstance(points, (str, bytes, os.PathLike)) or hasattr(points, "read"):
        query = urllib.parse.urlencode(texts_of({"candidates": "body", **members}))
        return "/sample?" + query, read_file(points, "points"), "application/octet-stream"
    return "/sample", _body({"candidates": points, **members}), "application/json"


def _analyze(points: Any, members: Mapping[str, Any]) -> Request:
    domain = members["domain"]
    if is_mesh_file(domain):
        return _mesh_request("/analyze", domain, {**members, "points": points, "domain": None})
    if isinstance(domain, (Mesh, Solid)):
        raise Error("domain must be polygons, a torus, a rectangle, a box or the file of a mesh", field="domain")
    area = {} if domain is None else region_members(domain)
    return "/analyze", _body({**members, "domain": None, "points": points, **area}), "application/json"


def _mesh_request(path: str, mesh: Any, options: Mapping[str, Any]) -> Request:
    """Returns a request with a form: the file of a mesh, and the options as text."""
    boundary = secrets.token_hex(16)
    texts = mesh_texts(options, lambda value, name: json.dumps(value, default=jsonable, allow_nan=False))
    parts = [("file", read_file(mesh, "domain")), *((name, text.encode()) for name, text in texts.items())]
    body = b"".join(f'--{boundary}\r\nContent-Disposition: form-data; name="{name}"\r\n\r\n'.encode()
                    + content + b"\r\n" for name, content in parts)
    return path, body + f"--{boundary}--\r\n".encode(), f"multipart/form-data; boundary={boundary}"


def _body(members: Mapping[str, Any]) -> bytes:
    given = {name: value for name, value in members.items() if value is not None}
    return json.dumps(given, default=jsonable, allow_nan=False).encode()


def _seconds_to_wait(retry_after: Optional[str]) -> float:
    """Returns the delay that the server asks for, by default one second, plus a random part of up to a tenth.

    The random part keeps clients that were refused together from returning together.
    """
    seconds = float(retry_after) if retry_after is not None and retry_after.isdigit() else 1.0
    return seconds * random.uniform(1, 1.1)


def _error_of(refusal: urllib.error.HTTPError) -> Error:
    """Returns the error that a server reports as application/problem+json."""
    body = refusal.read()
    try:
        problem = json.loads(body)
        message = problem["detail"]
        errors: List[Tuple[str, str]] = [(each["pointer"].lstrip("/"), each["detail"])
                                         for each in problem.get("errors", ())]
    except (ValueError, KeyError, TypeError):
        message, errors = f"{refusal.code} {refusal.reason}", []
    return Error(message, code=f"http_{refusal.code}", field=errors[0][0] if errors else "", errors=errors,
                 status=refusal.code)
