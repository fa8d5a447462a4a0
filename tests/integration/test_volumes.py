# SPDX-License-Identifier: GPL-3.0-or-later
"""POST /sample with domains in space."""

import io
import json
import re
import tempfile
import unittest

import numpy
from PIL import Image
from scipy.spatial import cKDTree

from harness import ServerCase, post_json, wait_until
from test_surfaces import SPHERE

TORUS = {"type": "torus", "width": 2, "height": 1, "depth": 1}
BOX = {"type": "box", "width": 1, "height": 1, "depth": 1}
# A density that grows with x, has two layers, and is empty in a corner.
VOXELS = (numpy.arange(1, 5) * numpy.array([[1], [1], [2]]) * numpy.array([[[1]], [[3]]])).astype("u2")
VOXELS[0, 0, 0] = 0


def npy_of(array):
    file = io.BytesIO()
    numpy.save(file, array)
    return file.getvalue()


def tiff_of(layers):
    first, *others = [Image.fromarray(layer) for layer in layers]
    file = io.BytesIO()
    first.save(file, "TIFF", save_all=True, append_images=others, compression="tiff_lzw")
    return file.getvalue()


def read_vtu(file):
    """Returns the points, cells and types of an unstructured grid with raw appended data."""
    header, data = file.split(b'<AppendedData encoding="raw">\n_', 1)
    kinds = {b"Float64": "<f8", b"UInt32": "<u4", b"Int64": "<i8", b"UInt8": "u1"}
    arrays = {}
    for kind, name, offset in re.findall(rb'<DataArray type="(\w+)" Name="(\w+)".*? offset="(\d+)"/>', header):
        size = int.from_bytes(data[int(offset):int(offset) + 8], "little")
        arrays[name.decode()] = numpy.frombuffer(data[int(offset) + 8:][:size], kinds[kind])
    offsets = arrays["offsets"]
    cells = numpy.split(arrays["connectivity"], offsets[:-1])
    assert offsets[-1] == len(arrays["connectivity"])
    return arrays["Points"].reshape(-1, 3), numpy.array(cells), arrays["types"]


class VolumeCase(ServerCase):
    def post(self, *arguments, **body):
        return post_json(self.server, "/sample", body, *arguments)

    def points(self, **body):
        return numpy.array(self.sample(**body)["points"])

    def table(self, query, body, *arguments):
        answer = self.ask("/sample?format=npy&" + query, *arguments, data=body)
        self.assertEqual(answer.status, 200, answer)
        return numpy.load(io.BytesIO(answer.body))

    def form(self, **parts):
        arguments = []
        with tempfile.TemporaryDirectory() as folder:
            for name, value in parts.items():
                if isinstance(value, bytes):
                    with open(f"{folder}/{name}", "wb") as file:
                        file.write(value)
                    value = f"@{folder}/{name}"
                arguments += ["-F", f"{name}={value}"]
            return self.ask("/sample", *arguments)


class Points(VolumeCase):
    def test_keep_their_distance(self):
        points = self.points(sites=1000, domain=TORUS)
        self.assertEqual(len(points), 1000)
        distances = cKDTree(points, boxsize=(2, 1, 1)).query(points, 2)[0][:, 1]
        densest = (2 ** 0.5 * 2 / 1000) ** (1 / 3)
        self.assertGreater(distances.min() / densest, 0.8)
        in_box = self.points(sites=1000, domain=BOX)
        layer = numpy.minimum(in_box, 1 - in_box).min(axis=1)
        self.assertGreater(layer.min(), 0.25 / 10)

    def test_follow_voxels(self):
        cells = lambda points: numpy.histogramdd(points[:, ::-1], bins=VOXELS.shape,
                                                 range=[(0, side) for side in VOXELS.shape])[0]
        table = self.table("sites=2000", npy_of(VOXELS))
        expected = 2000 * VOXELS / VOXELS.sum()
        self.assertEqual(cells(table)[0, 0, 0], 0)
        numpy.testing.assert_allclose(cells(table), expected, atol=0.15 * expected.max())
        for voxels in (npy_of(VOXELS.astype("f4")), tiff_of(VOXELS), tiff_of(VOXELS.astype("f4"))):
            numpy.testing.assert_array_equal(self.table("sites=2000", voxels), table)
        grid = {"width": 4, "height": 3, "depth": 2, "values": VOXELS.ravel().tolist()}
        domain = {"type": "box", "width": 4, "height": 3, "depth": 2}
        numpy.testing.assert_array_equal(self.points(sites=2000, domain=domain, density=grid), table)
        answer = self.form(density=tiff_of(VOXELS), sites=2000, domain="box", format="npy")
        numpy.testing.assert_array_equal(numpy.load(io.BytesIO(answer.body)), table)

    def test_are_the_same_again(self):
        request = {"sites": 300, "domain": BOX, "format": "ply"}
        first = self.post(**request)
        self.assertEqual(first.body, self.post("-H", "Cache-Control: no-cache", **request).body)
        self.assertNotEqual(first.body, self.post(**request, seed=1).body)
        self.assertEqual(self.post("-H", "If-None-Match: " + first.headers["etag"], **request).status, 304)

    def test_are_not_requested_by_a_foreign_member_of_geojson(self):
        triangle = {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [0, 1], [0, 0]]], "domain": "EU"}
        answer = self.ask("/sample?sites=9", data=json.dumps(triangle).encode())
        self.assertEqual((answer.status, answer.json()["sites"]), (200, 9), answer)

    def test_can_be_jobs(self):
        job = self.ask("/sample?sites=80&format=csv", "-H", "Prefer: respond-async", data=npy_of(VOXELS)).headers["location"]
        wait_until(lambda: self.ask(job).json()["status"] == "succeeded", "the end of the job")
        lines = self.ask(job + "/result").body.decode().split("\r\n")
        table = numpy.array([line.split(",") for line in lines[1:-1]], float)
        numpy.testing.assert_array_equal(table, self.table("sites=80", npy_of(VOXELS)))


class Solids(VolumeCase):
    def test_hold_the_points(self):
        points = self.table("sites=500&domain=solid", SPHERE)
        radii = numpy.linalg.norm(points, axis=1)
        self.assertEqual(len(points), 500)
        self.assertLess(radii.max(), 0.97)
        self.assertLess(abs(points.mean(axis=0)).max(), 0.02)

    def test_take_forms_with_voxels(self):
        voxels = npy_of(numpy.array([[[1, 0]]]))
        answer = self.form(mesh=SPHERE, density=voxels, domain="solid", sites=200, format="npy")
        points = numpy.load(io.BytesIO(answer.body))
        self.assertEqual(points.shape, (200, 3))
        self.assertLessEqual(points[:, 0].max(), 0)


class Meshes(VolumeCase):
    def test_fill_the_domain(self):
        for domain, volume in ((BOX, 1), (TORUS, 2)):
            request = {"sites": 400, "domain": domain, "mesh": True}
            mesh = self.sample(**request)["mesh"]
            vertices, cells, types = read_vtu(self.post(**request, format="vtu").body)
            self.assertEqual((len(cells), set(types)), (len(mesh["tetrahedra"]), {10}))
            numpy.testing.assert_array_equal(vertices[:len(mesh["vertices"])], mesh["vertices"])
            if domain is BOX:
                numpy.testing.assert_array_equal(cells, mesh["tetrahedra"])
            a, b, c, d = (vertices[cells[:, i]] for i in range(4))
            volumes = (numpy.cross(b - a, c - a) * (d - a)).sum(axis=1) / 6
            self.assertGreater(volumes.min(), 0)
            self.assertAlmostEqual(volumes.sum(), volume)

    def test_are_vertex_cells_without_the_option(self):
        vertices, cells, types = read_vtu(self.post(sites=50, domain=BOX, format="vtu").body)
        numpy.testing.assert_array_equal(vertices, self.points(sites=50, domain=BOX))
        numpy.testing.assert_array_equal(cells[:, 0], range(50))
        self.assertEqual(set(types), {1})


class Errors(VolumeCase):
    flags = ("--max-pixels=1000",)

    def test_name_the_field(self):
        broken = VOXELS.astype(float)
        broken[1, 0, 2] = numpy.nan
        colour = io.BytesIO()
        Image.new("RGB", (2, 2)).save(colour, "TIFF")
        uneven = tiff_of([VOXELS[0], VOXELS[0, 1:]])
        mixed = tiff_of([VOXELS[0].astype(numpy.uint8), VOXELS[1].astype(numpy.float32)])
        cases = ((npy_of(broken), "sites=5", 400, "density/14", "nan in voxel (2, 0, 1)"),
                 (npy_of(0 * VOXELS), "sites=5", 422, "density", "0 everywhere"),
                 (npy_of(VOXELS), "sites=5&domain=solid", 400, "domain", "mesh"),
                 (npy_of(VOXELS), "sites=5&fixed=%5B%5B9,0,0%5D%5D", 400, "fixed/0",
                  "the fixed point 0, (9, 0, 0), is not in the domain"),
                 (npy_of(VOXELS), "sites=9&width=1e-301", 400, "domain", "1e-300"),
                 (npy_of(numpy.ones((11, 10, 10))), "sites=5", 413, None, "max-pixels"),
                 (npy_of(numpy.ones((2, 2))), "sites=5", 400, None, "not (2, 2)"),
                 (npy_of(VOXELS.astype("<c8")), "sites=5", 400, None, "c8"),
                 (npy_of(VOXELS)[:-1], "sites=5", 400, None, "47 bytes"),
                 (colour.getvalue(), "sites=5", 422, "density", "page 1 is not grey"),
                 (mixed, "sites=5", 422, "density", "page 2 has samples of another type than page 1"),
                 (uneven, "sites=5", 422, "density", "page 2 has 4 x 2 pixels, but page 1 has 4 x 3"),
                 (tiff_of(VOXELS)[:40], "sites=5", 422, None, ""))
        for body, query, status, field, word in cases:
            with self.subTest(query=query, word=word):
                problem = self.assert_problem(self.ask("/sample?" + query, data=body), status, word)
                if field is not None:
                    self.assertEqual(problem["errors"][0]["pointer"], field)


if __name__ == "__main__":
    unittest.main(verbosity=2)
