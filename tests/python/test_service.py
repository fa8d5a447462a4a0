# SPDX-License-Identifier: GPL-3.0-or-later
"""The package computes what the service answers."""

import io
import json
import pickle
import typing
import urllib.parse

import ccdt
import numpy as np
import pytest
from ccdt import _core, _options
from ccdt.client import Client
from harness import DATA, POLYGONS, ask, post_json
from PIL import Image

SQUARE = [[0, 0], [4, 0], [4, 3], [2, 1], [0, 3]]


@pytest.mark.parametrize("options", [
    {},
    {"sites": 500, "format": "svg"},
    {"sites": 500, "format": "csv", "color": "cmyk"},
    {"sites": 500, "format": "tiff", "palette": ["#c30", "#036"], "levels": (0.1, 0.9)},
    {"sites": 300, "format": "gcode", "width_mm": 50, "dots": "ink", "seed": 3},
    {"device": "spectra6", "width": 90},
    {"device": "1bit", "width": 64, "format": "raw", "invert_bits": True},
], ids=str)
def test_halftones_are_those_of_the_service(server, cat, options):
    texts = {name: ",".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value).lower()
             if isinstance(value, bool) else str(value) for name, value in options.items()}
    answer = ask(server, "/halftone?" + urllib.parse.urlencode(texts), data=cat)
    assert answer.status == 200
    assert ccdt.halftone(cat, **options).write() == answer.body


@pytest.mark.parametrize(("domain", "options", "members"), [
    (SQUARE, {}, {"polygon": SQUARE}),
    (np.array(SQUARE), {"seed": 5, "quality": "draft"}, {"polygon": SQUARE}),
    (ccdt.Torus(2, 1), {"order": "progressive"}, {"domain": {"type": "torus", "width": 2, "height": 1}}),
    (ccdt.Rectangle(2, 1), {"fixed": np.array([[1, 0.5]])},
     {"domain": {"type": "rectangle", "width": 2, "height": 1}}),
    (json.loads((POLYGONS / "Switzerland-10m.geojson").read_text()), {"coordinates": "lonlat"},
     {"geometry": json.loads((POLYGONS / "Switzerland-10m.geojson").read_text())}),
], ids=["list", "array", "torus", "rectangle", "geojson"])
def test_points_are_those_of_the_service(server, domain, options, members):
    sent = {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in options.items()}
    answer = post_json(server, "/sample", {"sites": 400, "format": "npy", **sent, **members})
    assert answer.status == 200
    assert ccdt.sample(domain, 400, **options).write("npy") == answer.body


def test_densities_are_those_of_the_service(server):
    density = np.arange(12.0).reshape(3, 4)[:, ::-1] / 7
    members = {"width": 4, "height": 3, "values": density.ravel().tolist()}
    answer = post_json(server, "/sample", {"sites": 300, "polygon": SQUARE, "density": members, "format": "npy"})
    assert ccdt.sample(SQUARE, 300, density=density).write("npy") == answer.body


def test_sets_of_pixels_are_those_of_the_service(server):
    body = {"sites": 64, "domain": {"type": "pixels", "width": 32, "height": 16}, "calibration": {"height": 2},
            "density": {"width": 2, "height": 1, "values": [1, 3]}, "format": "npy"}
    expected = np.load(io.BytesIO(post_json(server, "/sample", body).body))
    found = ccdt.sample(ccdt.Pixels(32, 16), 64, density=[[1, 3]], calibration={"height": 2})
    assert found.dtype == bool and found.shape == (16, 32) and found.sum() == 64
    assert np.array_equal(found, expected)


HOUSE = DATA / "meshes" / "house.obj"


@pytest.mark.parametrize("options", [
    {}, {"order": "progressive", "seed": 4}, {"density": "color", "crease": 30},
    {"mesh": True, "fixed": np.array([[2, 0, 5.0]])}], ids=str)
def test_points_on_meshes_are_those_of_the_service(server, options):
    texts = {name: json.dumps(value.tolist()) if isinstance(value, np.ndarray) else str(value).lower()
             for name, value in options.items()}
    path = "/sample?" + urllib.parse.urlencode({"sites": 90, **texts})
    points = ccdt.sample(str(HOUSE), 90, **options)
    expected = ask(server, path, data=HOUSE.read_bytes()).json()
    assert isinstance(points, ccdt.SurfacePoints) and points.shape == (90, 3)
    assert points.tolist() == expected["points"]
    for name in ("faces", "barycentric", "normals", "colors"):
        assert getattr(points, name).tolist() == expected[name]
    assert (points.ranks is None) == ("rank" not in expected)
    assert points.variation == expected["variation"]
    for file in ("npy", "ply", "csv", "glb"):
        assert points.write(file) == ask(server, path + "&format=" + file, data=HOUSE.read_bytes()).body
    if "mesh" in options:
        assert points.vertices.tolist() == expected["mesh"]["vertices"]
        assert points.triangles.tolist() == expected["mesh"]["triangles"]
    client = Client(server.url(""))
    assert client.sample(HOUSE, 90, **options).json()["points"] == expected["points"]


def test_meshes_of_arrays_give_the_points_of_files():
    vertices = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]])
    file = "OFF 4 2 0\n0 0 0\n2 0 0\n2 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n"
    mesh = ccdt.Mesh(vertices, [[0, 1, 2], [0, 2, 3]])
    points = ccdt.sample(mesh, 40, density=[1, 1, 2, 2])
    assert points.write("csv") == ccdt.sample(file.encode(), 40, density=[1, 1, 2, 2]).write("csv")
    assert points.colors is None and points.texture is None
    painted = ccdt.sample(ccdt.Mesh(vertices, mesh.triangles, colors=np.full((4, 3), 128, np.uint8),
                                    texture=vertices[:, :2]), 40, density=[1, 1, 2, 2])
    assert painted.tolist() == points.tolist()
    assert (painted.colors == 128).all()
    assert np.allclose(painted.texture, points[:, :2], atol=1e-6)


@pytest.mark.parametrize(("mesh", "options", "field"), [
    (ccdt.Mesh([[0, 0]], [[0, 0, 0]]), {}, "vertices"),
    (ccdt.Mesh([[0, 0, 0]], [[0, 0, 1]]), {}, "triangles/0"),
    (ccdt.Mesh([[0, 0, 0]], [[0, 0, 0.5]]), {}, "triangles"),
    (ccdt.Mesh([[0, 0, 0]], [[0, 0, 0]], colors=[[2.0, 0, 0]]), {}, "colors/0"),
    (ccdt.Mesh([[0, 0, 0]], [[0, 0, 0]], texture=[[0, 0]] * 2), {}, "texture"),
    (b"nothing", {}, "domain"), (str(HOUSE), {"crease": 0}, "crease"), (str(HOUSE), {"density": [1]}, "density"),
], ids=str)
def test_errors_about_meshes_name_the_fault(mesh, options, field):
    with pytest.raises(ccdt.Error) as raised:
        ccdt.sample(mesh, 5, **options)
    assert raised.value.field == field


VOXELS = np.array([[[1, 2], [3, 4]], [[0, 1], [2, 0]]], dtype=np.float32)


@pytest.mark.parametrize(("domain", "options"), [
    (ccdt.Box(2, 1, 1), {"order": "progressive", "fixed": np.array([[0.5, 0.5, 0.25]])}),
    (ccdt.Torus(1, 2, 1), {"quality": "stealthy", "mesh": True}), (ccdt.Box(1, 1, 2), {"seed": 3}),
])
def test_points_in_space_are_those_of_the_service(server, domain, options):
    members = {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in options.items()}
    box = {"type": type(domain).__name__.lower(), "width": domain.width, "height": domain.height, "depth": domain.depth}
    expected = post_json(server, "/sample", {"sites": 200, "domain": box, **members}).json()
    points = ccdt.sample(domain, 200, **options)
    assert points.tolist() == expected["points"]
    if "mesh" in options:
        assert points.tetrahedra.tolist() == expected["mesh"]["tetrahedra"]
        assert points.vertices.tolist() == expected["mesh"]["vertices"]
        assert points.write("vtu").startswith(b"<?xml")
    assert Client(server.url("")).sample(domain, 200, **options).json()["points"] == expected["points"]
    assert pickle.loads(pickle.dumps(points)).write("csv") == points.write("csv")


def test_voxels_are_those_of_the_service(server):
    values = {"width": 2, "height": 2, "depth": 2, "values": VOXELS.ravel().tolist()}
    box = {"type": "box", "width": 1, "height": 1, "depth": 1}
    expected = post_json(server, "/sample", {"sites": 100, "domain": box, "density": values}).json()["points"]
    assert ccdt.sample(ccdt.Box(), 100, density=VOXELS).tolist() == expected
    for dtype in ("float16", ">f8", "longdouble", "uint8"):
        assert ccdt.sample(ccdt.Box(), 100, density=VOXELS.astype(dtype)).tolist() == expected
    for wrong in (-VOXELS, VOXELS[0], VOXELS.astype(complex), VOXELS.astype(object)):
        with pytest.raises(ccdt.Error, match="density"):
            ccdt.sample(ccdt.Box(), 100, density=wrong)


def test_points_in_solids_are_inside():
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    solid = ccdt.Solid(ccdt.Mesh(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
    points = ccdt.sample(solid, 60, density=VOXELS)
    assert points.shape == (60, 3) and (points > 0).all() and (points.sum(1) < 1).all()


@pytest.mark.parametrize("depth", [None, 3])
@pytest.mark.parametrize("bits", [8, 16])
def test_masks_are_those_of_the_service(server, bits, depth):
    name = {8: "mask", 16: "mask16"}[bits]
    torus = {"type": "torus", "width": 16, "height": 32, **({"depth": depth} if depth else {})}
    expected = np.asarray(post_json(server, "/sample", {"domain": torus, "seed": 4, "format": name}).picture())
    found = ccdt.mask(16, 32, depth, seed=4, bits=bits)
    assert found.shape == ((32, 16) if depth is None else (3, 32, 16))
    found = found.reshape(-1, 16)
    assert found.dtype == (np.uint8 if bits == 8 else np.uint16)
    assert np.array_equal(found, expected)


def test_analyses_are_those_of_the_service(server):
    points = ccdt.sample(ccdt.Torus(2, 1), 500)
    members = {"points": points.tolist(), "domain": {"type": "torus", "width": 2, "height": 1}, "spectrum": True}
    expected = post_json(server, "/analyze", members).json()
    found = ccdt.analyze(points, spectrum=True)
    for name in ("frequency", "power", "anisotropy_db"):
        assert getattr(found, name).tolist() == expected[name]
    for name in ("low_frequency_power", "min_distance", "mean_distance", "sets"):
        assert getattr(found, name) == expected[name]
    assert found.spectrum.shape == (expected["spectrum"]["height"], expected["spectrum"]["width"])
    assert found.spectrum.ravel().tolist() == expected["spectrum"]["values"]
    assert found.write("svg") == post_json(server, "/analyze", {**members, "format": "svg"}).body


def test_analyses_in_space_and_on_meshes_are_those_of_the_service(server, tmp_path):
    points = ccdt.sample(ccdt.Box(2, 1, 1), 100)
    domain = {"type": "box", "width": 2, "height": 1, "depth": 1}
    expected = post_json(server, "/analyze", {"points": points.tolist(), "domain": domain}).json()
    assert ccdt.analyze(points).power.tolist() == expected["power"]
    points = ccdt.sample(HOUSE, 100)
    (tmp_path / "points.json").write_text(json.dumps(points.tolist()))
    form = (f"mesh=@{HOUSE}", f"points=@{tmp_path / 'points.json'}", "modes=20")
    expected = ask(server, "/analyze", *(each for part in form for each in ("-F", part))).json()
    found = ccdt.analyze(points, modes=20)
    for name in ("eigenvalues", "frequency", "power"):
        assert getattr(found, name).tolist() == expected[name]
    assert (found.min_distance, found.low_frequency_power) == (expected["min_distance"], expected["low_frequency_power"])


@pytest.mark.parametrize("mode", ["L", "LA", "RGB", "RGBA", "1", "I;16"])
def test_arrays_equal_files_of_the_same_pixels(mode):
    random = np.random.default_rng(1)
    smooth = np.add.outer(np.arange(24), np.arange(36)) * 4
    shape = (24, 36, *{"LA": (2,), "RGB": (3,), "RGBA": (4,)}.get(mode, ()))
    pixels = (smooth if len(shape) == 2 else smooth[..., None]) + random.integers(0, 16, shape)
    pixels = pixels > 120 if mode == "1" else pixels.astype(np.uint16) * 257 if mode == "I;16" \
        else pixels.astype(np.uint8)
    file = io.BytesIO()
    Image.fromarray(pixels, mode=None if mode in ("1", "I;16") else mode).save(file, "PNG")
    for options in ({"color": "cmyk"}, {"format": "json"}):
        from_array = ccdt.halftone(pixels, 200, **options)
        from_file = ccdt.halftone(file.getvalue(), 200, **options)
        assert np.array_equal(from_array.points, from_file.points)
        assert from_array.write("png") == from_file.write("png")


def test_large_pictures_are_reduced_as_from_files():
    pixels = np.tile(np.linspace(0, 255, 2400).astype(np.uint8), (2000, 1))
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "PNG")
    from_array = ccdt.halftone(pixels, 100, width=200)
    assert from_array.write("png") == ccdt.halftone(file.getvalue(), 100, width=200).write("png")


def test_options_have_the_names_of_the_tables():
    hidden = {"format", "on_deadline"}  # the format is a parameter; there is no deadline
    halftone = set(_core.halftone_options()) - hidden
    assert set(_options.all_names(_options.HalftoneOptions)) | {"sites"} == halftone
    assert set(_options.all_names(_options.DeviceOptions)) | {"device"} == set(_core.device_options()) - hidden
    shapes = {"polygon", "geometry", "domain"}
    parameters = {"sites", "density", "seed"}
    assert set(_options.all_names(_options.SampleOptions)) | shapes | parameters == set(_core.sample_options()) - hidden
    assert (set(_options.all_names(_options.PixelOptions)) | {"domain"} | parameters
            == set(_core.pixel_options()) - hidden)
    assert (set(_options.all_names(_options.SurfaceOptions)) | {"domain"} | parameters
            == set(_core.surface_options()) - hidden)
    sides = {"domain", "width", "height", "depth"}
    assert set(_options.all_names(_options.VolumeOptions)) | sides | parameters == set(_core.volume_options()) - hidden
    analyze = set(typing.get_type_hints(ccdt.analyze)) - {"return", "threads", "progress", "modes"}  # modes: of meshes
    assert analyze | {"sets", "polygon", "holes", "geometry"} == set(_core.analyze_options()) - hidden
