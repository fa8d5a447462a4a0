# SPDX-License-Identifier: GPL-3.0-or-later
"""The client of a server."""

import contextlib
import pathlib
import re
import socket
import socketserver
import subprocess
import sys
import threading

import ccdt
import numpy as np
import pytest
from ccdt.client import Client
from harness import PATIENCE, PICTURES, Server

LONG = {"sites": 400_000, "iterations": 1000, "passes": 100}


class CutStream(socketserver.StreamRequestHandler):
    """Forwards one request and its answer. Cuts event streams after the first appearance of `server.last`."""

    def handle(self):
        head = b"".join(iter(self.rfile.readline, b"\r\n")) + b"\r\n"
        self.server.requests.append(head.partition(b" HTTP/")[0].decode())
        length = re.search(rb"(?i)content-length: (\d+)", head)
        answer = b""
        with socket.create_connection(("127.0.0.1", self.server.target), PATIENCE) as target:
            target.sendall(head + self.rfile.read(int(length[1]) if length else 0))
            while piece := target.recv(65536):
                answer += piece
                if self.server.requests[-1].endswith("/events") and self.server.last in answer:
                    answer = answer[:answer.index(self.server.last) + len(self.server.last)]
                    break
        self.wfile.write(answer)


@contextlib.contextmanager
def cutting_proxy(server, last):
    """Starts a TCP proxy in front of a server. Its `requests` are the methods and paths of all requests."""
    with socketserver.TCPServer(("127.0.0.1", 0), CutStream) as proxy:
        proxy.target, proxy.last, proxy.requests = server.port, last, []
        thread = threading.Thread(target=proxy.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield proxy
        finally:
            proxy.shutdown()
            thread.join()


@pytest.fixture(scope="module")
def client(server):
    return Client(server.url(""))


def test_answers_are_those_of_the_package(client, cat, tmp_path):
    answer = client.halftone(PICTURES / "chelsea.png", 500, color="cmyk", antialias=False)
    assert answer.media_type == "image/png"
    answer.save(tmp_path / "dots.png")
    expected = ccdt.halftone(cat, 500, color="cmyk", antialias=False).write()
    assert bytes(answer) == expected == (tmp_path / "dots.png").read_bytes()
    points = ccdt.sample(ccdt.Rectangle(2, 1), 200, seed=1)
    assert client.sample(ccdt.Rectangle(2, 1), 200, seed=1).json()["points"] == points.tolist()
    polygon = np.array([[0, 0], [1, 0], [0, 1]])
    assert bytes(client.sample(polygon, 20, format="npy")) == ccdt.sample(polygon, 20).write("npy")
    figures = client.analyze(points, ccdt.Rectangle(2, 1)).json()
    assert figures["power"] == ccdt.analyze(points).power.tolist()
    assert client.capabilities()["halftone"]


def test_meshes_are_sampled_and_analyzed(client):
    mesh = PICTURES.parent / "meshes" / "house.obj"
    points = ccdt.sample(mesh, 60, fixed=[[2, 0, 5]])
    assert client.sample(mesh, 60, fixed=[[2, 0, 5]]).json()["points"] == points.tolist()
    figures = client.analyze(np.array(points), mesh, modes=5).json()
    assert figures["power"] == ccdt.analyze(points, mesh, modes=5).power.tolist()


def test_errors_name_the_field(client):
    with pytest.raises(ccdt.Error, match="1 to 2000000") as refused:
        client.sample(ccdt.Torus(), 0)
    assert (refused.value.status, refused.value.code, refused.value.field) == (400, "http_400", "sites")
    with pytest.raises(ccdt.Error, match="PNG") as refused:
        client.halftone(b"no picture")
    assert refused.value.status == 415
    with pytest.raises(ccdt.Error, match="the file of a mesh"):
        client.analyze([[0, 0, 0], [1, 0, 0]], ccdt.Solid("cube.obj"))
    with pytest.raises(ccdt.Error, match="http://"):
        Client("localhost")


@pytest.mark.parametrize("options", [{}, {"format": "csv"}, {"progress": print}], ids=str)
def test_warnings_point_at_the_caller(client, options):
    bow = [[0, 0], [1, 0], [0, 1], [1, 1]]
    with pytest.warns(ccdt.Warning, match="repaired: .*crosses itself") as given:
        answer = client.sample(bow, 20, **options)
    assert [warning.filename for warning in given] == [__file__]
    assert answer.warnings == tuple(str(warning.message) for warning in given)


def test_jobs_report_progress(client):
    shares = []
    answer = client.sample(ccdt.Torus(), 500, progress=shares.append, format="npy")
    assert bytes(answer) == ccdt.sample(ccdt.Torus(), 500).write("npy")
    assert shares == sorted(shares) and shares[-1] == 1


def test_an_exception_in_progress_cancels_the_job(client, monkeypatch):
    jobs = []
    start = Client._start
    monkeypatch.setattr(Client, "_start", lambda self, request: jobs.append(start(self, request)) or jobs[-1])

    def refuse(share):
        raise LookupError(share)

    with pytest.raises(LookupError):
        client.sample(ccdt.Torus(), **LONG, progress=refuse)
    assert jobs[0].status()["status"] == "cancelled"


def test_jobs_end_with_the_error_of_the_request(client):
    with pytest.raises(ccdt.Error) as refused:
        client.start_sample([[0, 0], [1, 1], [2, 2]], 5).result()
    assert (refused.value.status, refused.value.field) == (422, "polygon")


def test_jobs_can_be_cancelled(client):
    job = client.start_sample(ccdt.Torus(), **LONG)
    states = job.events()
    next(states)
    job.cancel()
    assert list(states)[-1]["status"] == "cancelled"
    with pytest.raises(ccdt.Error) as refused:
        job.result()
    assert refused.value.status == 410


@pytest.mark.parametrize("last", [b"", b'data: {"', b"\n\n"], ids=["no answer", "within an event", "after an event"])
def test_jobs_survive_the_loss_of_their_stream(last, monkeypatch):
    """The job waits for another one, which is cancelled as soon as the client polls."""
    monkeypatch.setattr("ccdt.client.POLL_INTERVAL", 0.1)
    with Server("--workers=1") as server, cutting_proxy(server, last) as proxy:
        running = [Client(server.url("")).start_sample(ccdt.Torus(), **LONG)]
        job = Client(f"http://127.0.0.1:{proxy.server_address[1]}").start_sample(ccdt.Torus(), 500, format="npy")
        shares = []

        def note(share):
            shares.append(share)
            if f"GET {job.path}" in proxy.requests and running:
                running.pop().cancel()

        assert bytes(job.result(note)) == ccdt.sample(ccdt.Torus(), 500).write("npy")
    assert shares[0] == 0 and shares[-1] == 1
    assert proxy.requests[1] == f"GET {job.path}/events" and proxy.requests[-1] == f"GET {job.path}/result"


def test_keys_are_sent(tmp_path):
    keys = tmp_path / "keys"
    keys.write_text("alice:alice-0123456789abcdef\n")
    with Server(f"--api-key-file={keys}") as server:
        with pytest.raises(ccdt.Error) as refused:
            Client(server.url("")).sample(ccdt.Torus(), 5)
        assert refused.value.status == 401
        assert len(Client(server.url(""), "alice-0123456789abcdef").sample(ccdt.Torus(), 5).json()["points"]) == 5


def test_presets_are_requested_by_name(tmp_path):
    presets = tmp_path / "presets.json"
    presets.write_text('{"small": {"sites": 7, "format": "csv"}}')
    with Server(f"--presets={presets}") as server:
        client = Client(server.url(""))
        assert bytes(client.halftone(PICTURES / "chelsea.png", preset="small")).count(b"\n") == 8
        assert bytes(client.start_halftone(PICTURES / "chelsea.png", 5, preset="small").result()).count(b"\n") == 6
        assert bytes(client.sample(PICTURES.parent / "meshes" / "house.obj", preset="small")).count(b"\n") == 8


def test_requests_wait_while_the_server_is_busy():
    with Server("--rate-limit=1", "--rate-burst=1") as server:
        client = Client(server.url(""), patience=30)
        assert [len(client.sample(ccdt.Torus(), 5).json()["points"]) for _ in range(2)] == [5, 5]
        impatient = Client(server.url(""), patience=0)
        with pytest.raises(ccdt.Error) as refused:
            for _ in range(3):
                impatient.sample(ccdt.Torus(), 5)
        assert refused.value.status == 429


def test_the_client_needs_the_standard_library_alone(server):
    """Runs without site packages, so that neither NumPy nor the other modules of Debian can be imported."""
    package = str(pathlib.Path(ccdt.__file__).parent.parent)
    script = f"""
import sys
sys.path.insert(0, {package!r})
from ccdt.client import Client
import ccdt
print(len(Client({server.url("")!r}).sample(ccdt.Torus(), 5).json()["points"]))
print(any(name.startswith("numpy") or name == "ccdt._core" for name in sys.modules))
"""
    output = subprocess.run([sys.executable, "-S", "-E", "-c", script], capture_output=True, text=True, check=True)
    assert output.stdout.split() == ["5", "False"]
