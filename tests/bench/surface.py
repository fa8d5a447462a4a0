#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the points that a server places on surfaces, and prints the results as a Markdown table.

    surface.py http://localhost:8080 16384 sphere bunny.obj --quality standard best --cycodebase PATH --mesh PROGRAM

A mesh is an OBJ file, or one of the shapes sphere, torus, blob, cap (open) and cube (with creases of 90 degrees).
Distances are relative to a hexagonal grid. The power of the lowest Laplace-Beltrami modes is relative to that of random
points, in decibels. All are means over the seeds 1 to SETS. With --cycodebase, the table has rows of Yuksel's sample
elimination, which gets five random samples per point. With --mesh, a second table compares triangulations with those of
CGAL's isotropic remeshing; PROGRAM is ccdt_mesh_quality, a
target that only `cmake --build --preset test --target ccdt_mesh_quality` builds.
"""
import argparse
import io
import json
import math
import pathlib
import subprocess
import tempfile
import urllib.request
import uuid

import numpy
from elimination import Elimination


def grid(columns, rows, place):
    """Returns an OBJ with the vertices place(u, v) for u and v in [0, 1]."""
    vertices = [place(i / columns, j / rows) for j in range(rows + 1) for i in range(columns + 1)]
    corners = [[j * (columns + 1) + i + 1 for i, j in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))]
               for j in range(rows) for i in range(columns)]
    # Vertices with the same text are one vertex. The sum removes the sign of zero.
    lines = ["v " + " ".join(f"{round(x, 12) + 0.0:.12f}" for x in vertex) for vertex in vertices]
    return "\n".join(lines + ["f " + " ".join(map(str, corner)) for corner in corners]) + "\n"


def turned(u, radius, z):
    angle = 2 * math.pi * (u % 1)
    return radius * math.cos(angle), radius * math.sin(angle), z


def ball(u, v, bump=0.0, end=1.0):
    polar = math.pi * end * v
    radius = 1 + bump * math.sin(polar) ** 3 * math.cos(6 * math.pi * (u % 1)) * math.cos(3 * polar)
    return turned(u, radius * (0 if v in (0, 1 / end) else math.sin(polar)), radius * math.cos(polar))


def torus(u, v):
    angle = 2 * math.pi * (v % 1)
    return turned(u, 1 + 0.4 * math.cos(angle), 0.4 * math.sin(angle))


CUBE = ("".join(f"v {i & 1} {i >> 1 & 1} {i >> 2}\n" for i in range(8))
        + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n")
SHAPES = {"sphere": lambda: grid(96, 48, ball), "torus": lambda: grid(96, 48, torus),
          "blob": lambda: grid(144, 72, lambda u, v: ball(u, v, 0.25)),
          "cap": lambda: grid(96, 32, lambda u, v: ball(u, v, end=0.4)), "cube": lambda: CUBE}


def ask(url, body, kind):
    request = urllib.request.Request(url, body, {"Content-Type": kind})
    with urllib.request.urlopen(request, timeout=3600) as answer:
        return answer.read()


def form(**files):
    """Returns the body and the content type of a form."""
    border = uuid.uuid4().hex
    parts = [f'--{border}\r\nContent-Disposition: form-data; name="{name}"; filename="{name}"\r\n\r\n'.encode() + data
             + b"\r\n" for name, data in files.items()]
    return b"".join(parts) + f"--{border}--\r\n".encode(), "multipart/form-data; boundary=" + border


def analyse(url, mesh, points, modes):
    array = io.BytesIO()
    numpy.save(array, points)
    return json.loads(ask(url + "/analyze", *form(mesh=mesh, points=array.getvalue(), modes=str(modes).encode())))


def row(name, analyses, times):
    low = numpy.mean([numpy.mean(each["power"]) for each in analyses])
    least, mean = (numpy.mean([each[member] for each in analyses]) for member in ("min_distance", "mean_distance"))
    return f"| {name} | {least:.2f} | {mean:.3f} | {10 * math.log10(low):.1f} dB | {numpy.mean(times):.4g} ms |"


def triangles_of(mesh):
    lines = [line.split() for line in mesh.decode(errors="replace").splitlines()]
    vertices = numpy.array([line[1:4] for line in lines if line[:1] == ["v"]], dtype=float)
    faces = [[int(corner.split("/")[0]) - 1 for corner in line[1:]] for line in lines if line[:1] == ["f"]]
    return vertices[numpy.array([[f[0], f[k], f[k + 1]] for f in faces for k in range(1, len(f) - 1)])]


def random_points(triangles, count, generator):
    """Returns uniform random points on triangles, and the area of the triangles."""
    a, b, c = triangles.swapaxes(0, 1)
    areas = numpy.linalg.norm(numpy.cross(b - a, c - a), axis=1) / 2
    chosen = generator.choice(len(areas), count, p=areas / areas.sum())
    u, v = numpy.sqrt(generator.random(count))[:, None], generator.random(count)[:, None]
    return (1 - u) * a[chosen] + u * (1 - v) * b[chosen] + u * v * c[chosen], areas.sum()


def table_of_points(meshes, options):
    print(f"| {options.sites:,} points | minimum distance | mean distance | lowest {options.modes} modes | time |\n"
          "|---|---|---|---|---|")
    seeds = range(1, options.sets + 1)
    for name, mesh in meshes.items():
        for quality in options.quality:
            query = f"/sample?sites={options.sites}&quality={quality}&seed="
            made = [json.loads(ask(options.url + query + str(seed), mesh, "model/obj")) for seed in seeds]
            found = [analyse(options.url, mesh, each["points"], options.modes) for each in made]
            print(row(f"{name}, {quality}", found, [each["elapsed_ms"] for each in made]), flush=True)
        if not options.cycodebase:
            continue
        with Elimination(options.cycodebase) as elimination:
            made = []
            for seed in seeds:
                samples, area = random_points(triangles_of(mesh), 5 * options.sites, numpy.random.default_rng(seed))
                made.append(elimination.choose(samples, options.sites, float(area)))
            found = [analyse(options.url, mesh, points, options.modes) for points, _ in made]
            print(row(f"{name}, sample elimination", found, [elapsed for _, elapsed in made]), flush=True)


def table_of_meshes(meshes, options):
    print(f"\n| {options.sites:,} points | vertices | variation of areas | angles of 30 to 120 degrees | "
          "Hausdorff distance / diagonal |\n|---|---|---|---|---|")
    for name, mesh in meshes.items():
        with tempfile.TemporaryDirectory() as folder:
            files = pathlib.Path(folder, "surface.obj"), pathlib.Path(folder, "mesh.obj")
            query = f"/sample?sites={options.sites}&quality={options.quality[-1]}&mesh=true&format=obj"
            query += f"&crease={options.crease}" if options.crease else ""
            files[0].write_bytes(mesh)
            files[1].write_bytes(ask(options.url + query, mesh, "model/obj"))
            done = subprocess.run([options.mesh, *files, str(options.crease or 180)], stdout=subprocess.PIPE,
                                  check=False, timeout=3600)
        for found in map(json.loads, done.stdout.splitlines()):
            kind = options.quality[-1] if found["name"] == "given" else found["name"]
            print(f"| {name}, {kind} | {found['vertices']:,} | {100 * found['area_variation']:.1f} % | "
                  f"{100 * found['good_angles']:.2f} % | {found['hausdorff']:.1e} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("url")
    parser.add_argument("sites", type=int)
    parser.add_argument("meshes", nargs="+")
    parser.add_argument("--quality", nargs="+", default=["standard"])
    parser.add_argument("--sets", type=int, default=1)
    parser.add_argument("--modes", type=int, default=401)
    parser.add_argument("--crease", type=float)
    parser.add_argument("--cycodebase")
    parser.add_argument("--mesh")
    options = parser.parse_args()
    meshes = {pathlib.Path(name).stem: SHAPES[name]().encode() if name in SHAPES else pathlib.Path(name).read_bytes()
              for name in options.meshes}
    table_of_points(meshes, options)
    if options.mesh:
        table_of_meshes(meshes, options)


if __name__ == "__main__":
    main()
