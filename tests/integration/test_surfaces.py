# SPDX-License-Identifier: GPL-3.0-or-later
"""POST /sample with meshes."""

import io
import json
import math
import os
import pathlib
import struct
import tempfile
import unittest

import numpy

from harness import DATA, PATIENCE, ServerCase, execute, wait_until

HOUSE = DATA / "meshes" / "house.obj"
COLUMNS = ["x", "y", "z", "face", "u", "v", "w", "nx", "ny", "nz"]
COMMAND = os.environ.get("CCDT_COMMAND", "ccdt")


def sphere(levels=3):
    """Returns the vertices [n, 3] and triangles [m, 3] of a unit sphere: a subdivided octahedron."""
    corners = [(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    triangles = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (1, 0, 5), (2, 1, 5), (3, 2, 5), (0, 3, 5)]
    for _ in range(levels):
        middles = {}

        def middle(a, b, middles=middles):
            key = min(a, b), max(a, b)
            if key not in middles:
                point = numpy.add(corners[a], corners[b])
                corners.append(tuple(point / numpy.linalg.norm(point)))
                middles[key] = len(corners) - 1
            return middles[key]

        triangles = [part for a, b, c in triangles for ab, bc, ca in [(middle(a, b), middle(b, c), middle(c, a))]
                     for part in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    return numpy.array(corners), numpy.array(triangles)


def off_of(vertices, triangles):
    lines = ["OFF", f"{len(vertices)} {len(triangles)} 0", *(" ".join(map(repr, map(float, row))) for row in vertices),
             *(f"3 {a} {b} {c}" for a, b, c in triangles)]
    return "\n".join(lines).encode() + b"\n"


VERTICES, TRIANGLES = sphere()
SPHERE = off_of(VERTICES, TRIANGLES)
COLOURED = b"""ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
element face 2
property list uchar int vertex_indices
end_header
0 0 0 0 0 0
2 0 0 255 255 255
2 1 0 255 255 255
0 1 0 0 0 0
3 0 1 2
3 0 2 3
"""

TYPES = {"double": "<f8", "float": "<f4", "uchar": "u1", "uint": "<u4", "int": "<i4"}


def read_ply(file):
    """Returns the elements of a binary PLY file as structured arrays."""
    header, _, body = file.partition(b"end_header\n")
    elements, counts = {}, {}
    for line in header.decode().split("\n")[2:]:
        words = line.split()
        if words[:1] == ["element"]:
            elements[words[1]], counts[words[1]] = [], int(words[2])
        elif words[:2] == ["property", "list"]:
            list(elements.values())[-1].extend([("size", TYPES[words[2]]), (words[4], TYPES[words[3]], 3)])
        elif words[:1] == ["property"]:
            list(elements.values())[-1].append((words[2], TYPES[words[1]]))
    tables, at = {}, 0
    for name, fields in elements.items():
        tables[name] = numpy.frombuffer(body, numpy.dtype(fields), counts[name], at)
        at += tables[name].nbytes
    assert at == len(body)
    return tables


def read_glb(file):
    """Returns the arrays of the only primitive of a GLB file."""
    magic, version, size, length, kind = struct.unpack_from("<4sIII4s", file)
    assert (magic, version, size, kind) == (b"glTF", 2, len(file), b"JSON")
    document = json.loads(file[20:20 + length])
    content = file[28 + length:]
    [primitive] = document["meshes"][0]["primitives"]
    arrays = {}
    for name, number in {**primitive["attributes"], **({"indices": primitive["indices"]} if "indices" in primitive else {})}.items():
        accessor = document["accessors"][number]
        view = document["bufferViews"][accessor["bufferView"]]
        assert view["byteOffset"] % 4 == 0
        values = numpy.frombuffer(content, {5126: "<f4", 5125: "<u4"}[accessor["componentType"]],
                                  view["byteLength"] // 4, view["byteOffset"])
        arrays[name] = values.reshape(accessor["count"], -1)
    return arrays


def nearest_distances(points):
    between = numpy.linalg.norm(points[:, None] - points[None], axis=2)
    numpy.fill_diagonal(between, numpy.inf)
    return between.min(axis=1)


class SurfaceCase(ServerCase):
    def post(self, query, body=SPHERE, *arguments):
        answer = self.ask("/sample?" + query, *arguments, data=body)
        self.assertEqual(answer.status, 200, answer)
        return answer

    def table(self, query, body=SPHERE):
        return numpy.load(io.BytesIO(self.post(query + "&format=npy", body).body))


class Points(SurfaceCase):
    def test_lie_on_the_triangles_that_are_named(self):
        answer = self.post("sites=500").json()
        points, weights = numpy.array(answer["points"]), numpy.array(answer["barycentric"])
        faces, normals = numpy.array(answer["faces"]), numpy.array(answer["normals"])
        self.assertEqual((len(points), len(faces), answer["sites"]), (500, 500, 500))
        numpy.testing.assert_allclose(weights.sum(axis=1), 1, atol=1e-9)
        self.assertGreaterEqual(weights.min(), 0)
        numpy.testing.assert_allclose((weights[:, :, None] * VERTICES[TRIANGLES[faces]]).sum(axis=1), points, atol=1e-6)
        numpy.testing.assert_allclose(numpy.linalg.norm(normals, axis=1), 1, atol=1e-9)
        self.assertGreater((normals * points).sum(axis=1).min(), 0.9)  # outwards

    def test_are_distributed_in_proportion_to_area(self):
        points = self.table("sites=2000")[:, :3]
        for axis in range(3):
            self.assertAlmostEqual((points[:, axis] > 0).mean(), 0.5, delta=0.05)

    def test_are_the_same_in_all_formats(self):
        query = "sites=100&order=progressive"
        for mesh in (SPHERE, COLOURED):
            table = self.table(query, mesh)
            lines = self.post(query + "&format=csv", mesh).body.decode().split("\r\n")
            names = lines[0].split(",")
            self.assertEqual(names, [*COLUMNS, *(["r", "g", "b"] if mesh is COLOURED else []), "rank"])
            numpy.testing.assert_array_equal([[float(each) for each in line.split(",")] for line in lines[1:-1]], table)
            answer = self.post(query, mesh).json()
            numpy.testing.assert_array_equal(answer["points"], table[:, :3])
            numpy.testing.assert_array_equal(answer["faces"], table[:, 3])
            numpy.testing.assert_array_equal(answer["barycentric"], table[:, 4:7])
            numpy.testing.assert_array_equal(answer["normals"], table[:, 7:10])
            numpy.testing.assert_array_equal(answer["rank"], range(100))
            ply = read_ply(self.post(query + "&format=ply", mesh).body)["vertex"]
            glb = read_glb(self.post(query + "&format=glb", mesh).body)
            numpy.testing.assert_array_equal(ply["x"], table[:, 0])
            numpy.testing.assert_array_equal(ply["face"], table[:, 3])
            numpy.testing.assert_array_equal(ply["rank"], table[:, -1])
            numpy.testing.assert_array_equal(glb["POSITION"], table[:, :3].astype("f4"))
            numpy.testing.assert_array_equal(glb["NORMAL"], table[:, 7:10].astype("f4"))
            numpy.testing.assert_array_equal(glb["_FACE"][:, 0], table[:, 3])
            numpy.testing.assert_array_equal(glb["_BARYCENTRIC"], table[:, 4:7].astype("f4"))
            if mesh is COLOURED:
                numpy.testing.assert_array_equal(answer["colors"], table[:, 10:13])
                numpy.testing.assert_array_equal(ply["green"], table[:, 11])
                light = glb["COLOR_0"][:, 0]  # linear, like x / 2
                numpy.testing.assert_allclose(light, table[:, 0] / 2, atol=1e-6)

    def test_avoid_fixed_points_and_follow_densities(self):
        for query in ("fixed=[[0,0,1]]", "density=curvature", "crease=30",
                      "density=[" + ",".join("1" if z > 0 else "0.1" for z in VERTICES[:, 2]) + "]"):
            self.assertEqual(self.table("sites=200&" + query.replace("[", "%5B").replace("]", "%5D")).shape, (200, 10))
        self.assertEqual(self.table("sites=200&density=color", COLOURED).shape, (200, 13))

    def test_every_prefix_of_a_progressive_order_is_even(self):
        points = self.table("sites=2000&order=progressive")[:, :3]
        for count in (1000, 500, 250, 125):
            hexagonal = math.sqrt(2 * 4 * math.pi / (math.sqrt(3) * count))
            self.assertGreater(nearest_distances(points[:count]).min() / hexagonal, 0.5, count)


class Meshes(SurfaceCase):
    def test_are_triangulations_of_the_points(self):
        mesh = self.post("sites=400&mesh=true").json()["mesh"]
        points = self.table("sites=400")[:, :3]
        numpy.testing.assert_allclose(mesh["vertices"][:400], points, atol=1e-9)
        triangles = numpy.array(mesh["triangles"])
        self.assertLess(triangles.max(), len(mesh["vertices"]))
        vertices = numpy.array(mesh["vertices"])
        lines = self.post("sites=400&mesh=true&format=obj").body.decode().splitlines()
        written = [line.split()[1:] for line in lines if line.startswith("v ")]
        numpy.testing.assert_array_equal(numpy.array(written, float), vertices)
        written = [line.split()[1:] for line in lines if line.startswith("f ")]
        numpy.testing.assert_array_equal(numpy.array(written, int) - 1, triangles)
        ply = read_ply(self.post("sites=400&mesh=true&format=ply").body)
        numpy.testing.assert_array_equal(ply["vertex"]["z"], vertices[:, 2])
        numpy.testing.assert_array_equal(ply["face"]["vertex_indices"], triangles)
        glb = read_glb(self.post("sites=400&mesh=true&format=glb").body)
        numpy.testing.assert_array_equal(glb["POSITION"], vertices.astype("f4"))
        numpy.testing.assert_array_equal(glb["indices"].reshape(-1, 3), triangles)
        stl = self.post("sites=400&mesh=true&format=stl").body
        corners = numpy.frombuffer(stl, numpy.dtype([("floats", "<f4", 12), ("rest", "<u2")]), offset=84)["floats"]
        numpy.testing.assert_array_equal(corners[:, 3:].reshape(-1, 3, 3), vertices[triangles].astype("f4"))

    def test_can_be_read_again(self):
        for name in ("obj", "ply", "glb", "stl"):
            with self.subTest(name):
                answer = self.post(f"sites=300&mesh=true&format={name}")
                points = self.table("sites=50", answer.body)[:, :3]
                self.assertEqual(len(points), 50)


class Requests(SurfaceCase):
    def test_may_be_bodies_or_forms(self):
        body = HOUSE.read_bytes()
        expected = self.post("sites=60&seed=3&format=csv", body).body
        for kind in ("model/obj", "application/octet-stream", "application/x-tgif", "text/plain"):
            answer = self.post("sites=60&seed=3&format=csv", body, "-H", f"Content-Type: {kind}")
            self.assertEqual((kind, answer.body), (kind, expected))
        for part in ("file", "mesh", "map"):
            answer = self.ask("/sample", "-F", f"{part}=@{HOUSE}", "-F", "sites=60", "-F", "seed=3", "-F", "format=csv")
            self.assertEqual((part, answer.body), (part, expected))
        answer = self.ask("/sample?format=obj", "-F", f"mesh=@{HOUSE}", "-F", "mesh=true", "-F", "sites=60")
        self.assertEqual(answer.body, self.post("sites=60&mesh=true&format=obj", body).body)
        self.assertEqual(answer.type, "model/obj")

    def test_negotiate_the_format(self):
        for kind in ("model/ply", "model/gltf-binary", "application/x-npy"):
            self.assertEqual(self.post("sites=9", SPHERE, "-H", f"Accept: {kind}").type, kind)

    def test_have_entity_tags(self):
        first = self.post("sites=70&format=ply")
        again = self.ask("/sample?sites=70&format=ply", "-H", "If-None-Match: " + first.headers["etag"], data=SPHERE)
        self.assertEqual((again.status, again.body), (304, b""))
        self.assertNotEqual(self.post("sites=70&format=ply", HOUSE.read_bytes()).headers["etag"], first.headers["etag"])

    def test_can_be_jobs(self):
        job = self.ask("/sample?sites=80&format=glb", "-H", "Prefer: respond-async", data=SPHERE).headers["location"]
        wait_until(lambda: self.ask(job).json()["status"] == "succeeded", "the end of the job")
        self.assertEqual(self.ask(job + "/result").body, self.post("sites=80&format=glb").body)

    def test_report_repairs_and_warnings(self):
        turned = off_of(VERTICES, [*TRIANGLES[:5, ::-1], *TRIANGLES[5:]])
        answer = self.post("sites=20", turned).json()
        self.assertGreater(len(answer["repaired"]), 0)
        for note in answer["repaired"]:
            self.assertEqual(note["pointer"], "")
            self.assertIn(note.get("face", 0), range(len(TRIANGLES)))
        headers = self.post("sites=20&format=csv", turned).headers
        self.assertEqual(json.loads(headers["x-repaired"]), answer["repaired"])

    def test_have_errors_that_name_the_option(self):
        cases = (("sites=5&width=3", 400, "width", "unknown option"), ("sites=5&order=path", 400, "order", "plane"),
                 ("sites=5&format=obj", 400, "mesh", "mesh=true"), ("crease=1", 400, "sites", "missing"),
                 ("sites=5&crease=0", 400, "crease", "180"), ("sites=5&density=%5B1%5D", 400, "density", "1"),
                 ("sites=5&density=color", 422, "density", "colour"), ("sites=0", 400, "sites", "from 1"),
                 ("sites=5000000", 413, "sites", "max-sites"))
        for query, status, field, word in cases:
            with self.subTest(query):
                problem = self.assert_problem(self.ask("/sample?" + query, data=SPHERE), status, word)
                self.assertEqual(problem["errors"][0]["pointer"].split("/")[0], field)
        flat = off_of([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)])
        self.assert_problem(self.ask("/sample?sites=5", data=flat), 422, "area")
        self.assert_problem(self.ask("/sample?sites=5", "-H", "Content-Type: model/ply", data=b"nothing"), 422)
        self.assert_problem(self.ask("/sample?sites=5", "-H", "Content-Type: model/vrml", data=b"x"), 415, "model/obj")
        self.assert_problem(self.ask("/sample?sites=5", "-H", "Accept: image/png", data=SPHERE), 406, "model/ply")


class Limits(SurfaceCase):
    flags = ("--max-faces=100",)

    def test_bound_the_number_of_faces(self):
        self.assert_problem(self.ask("/sample?sites=5", data=SPHERE), 413, "max-faces", "100")
        self.assertEqual(self.ask("/sample?sites=5", data=HOUSE.read_bytes()).status, 200)
        self.assertEqual(self.ask("/capabilities").json()["limits"]["max_faces"], 100)


class Command(SurfaceCase):
    def test_writes_the_bytes_of_the_service(self):
        with tempfile.TemporaryDirectory() as folder:
            for options in (("--format=csv",), ("--format=ply", "--order=progressive"), ("--format=glb", "--mesh"),
                            ("--format=npy", "--crease=40", "--fixed=[[0,0,0]]", "--density=color")):
                for threads in (1, 3):
                    output = pathlib.Path(folder) / "points"
                    execute([COMMAND, "sample", HOUSE, "--sites=90", *options, f"--threads={threads}", "-o", output],
                            check=True, timeout=PATIENCE)
                    query = "&".join(option[2:] if "=" in option else option[2:] + "=true" for option in options)
                    query = query.replace("[", "%5B").replace("]", "%5D")
                    self.assertEqual(output.read_bytes(), self.post("sites=90&" + query, HOUSE.read_bytes()).body)

    def test_chooses_the_format_by_the_suffix(self):
        with tempfile.TemporaryDirectory() as folder:
            output = pathlib.Path(folder) / "points.ply"
            execute([COMMAND, "sample", HOUSE, "--sites=90", "-o", output], check=True)
            self.assertEqual(len(read_ply(output.read_bytes())["vertex"]), 90)


if __name__ == "__main__":
    unittest.main(verbosity=2)
