# SPDX-License-Identifier: GPL-3.0-or-later
"""The installed libraries: their files, symbols and headers; projects that build with them; results and errors.

The environment variable CCDT_BUILD contains the path of the build folder, from which the libraries are installed.
"""

import io
import json
import os
import pathlib
import re
import shutil
import sys
import tempfile
import time
import unittest

import numpy
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
from harness import PICTURES, POLYGONS, ROOT, Server, ask, execute, post_json  # pylint: disable=wrong-import-position

CMAKE = os.environ["CCDT_CMAKE"]
EXAMPLE = pathlib.Path(__file__).resolve().parent / "example"
WARNINGS = ("-std=c++20", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
HEADERS = {"abi.h", "analysis.h", "ccdt.h", "control.h", "domain.h", "exception.h", "halftone.h", "sample.h", "service.h",
           "volume.h"}
COMPILERS = [name for name in ("g++", "clang++") if shutil.which(name)]

# Codes of failures, in the order of ccdt::FailureCode.
MALFORMED, UNUSABLE, LIMIT, NOT_ACCEPTABLE, UNSUPPORTED, UNAVAILABLE, STOPPED, INTERNAL = range(8)

SQUARE = {"polygon": [[0, 0], [4, 0], [4, 4], [0, 4]], "holes": [[[1, 1], [2, 1], [2, 2], [1, 2]]]}
TORUS = {"domain": {"type": "torus", "width": 2, "height": 1}}


def output_of(*command, **options):
    """Runs a program and returns its output. Fails with the errors of the program."""
    done = execute([str(part) for part in command], capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        raise AssertionError(f"{command} failed with {done.returncode}:\n{done.stdout[-4000:]}{done.stderr[-4000:]}")
    return done.stdout


def install(component, prefix):
    output_of(CMAKE, "--install", os.environ["CCDT_BUILD"], "--prefix", prefix, "--component", component)
    return {path.relative_to(prefix).as_posix() for path in prefix.rglob("*") if not path.is_dir()}


class Installed:
    """The installed libraries, a server, and the example project with all its programs. Built once."""

    def __init__(self):
        self.folder = tempfile.TemporaryDirectory()
        root = pathlib.Path(self.folder.name)
        self.library_files = install("library", root / "first")
        self.all_files = install("development", root / "first")
        # Other projects must find the libraries wherever they are.
        self.prefix = (root / "first").rename(root / "moved")
        self.libraries = next(self.prefix.rglob("libccdt.so.2")).parent
        self.build = root / "build"
        self.picture = Image.open(PICTURES / "astronaut.png").convert("RGB").resize((128, 96))
        self.png = root / "picture.png"
        self.picture.save(self.png)
        self.picture.save(root / "picture.ppm")
        shutil.copytree(EXAMPLE, root / "example")
        start = time.monotonic()
        output_of(CMAKE, "-G", "Ninja", "-S", root / "example", "-B", self.build,
                  f"-DCMAKE_PREFIX_PATH={self.prefix}")
        found = time.monotonic()
        output_of(CMAKE, "--build", self.build)
        print(f"find_package: {found - start:.1f} s, build of the example: {time.monotonic() - found:.1f} s")
        self.memory = json.loads(self.run_memory("shared"))
        self.server = Server()

    def run_memory(self, kind):
        return output_of(self.build / f"memory_{kind}", self.png.with_suffix(".ppm"))

    def run_files(self, *arguments, kind="shared"):
        """Returns the exit code and the output."""
        done = execute([self.build / f"files_{kind}", *map(str, arguments)], capture_output=True, text=True,
                       check=False)
        return done.returncode, done.stdout.strip()

    def close(self):
        with self.folder, self.server:
            pass

    def options_of_package(self, package, *arguments):
        """Returns the options that pkg-config prints."""
        environment = {**os.environ, "PKG_CONFIG_PATH": str(self.libraries / "pkgconfig")}
        return output_of("pkg-config", "--cflags", "--libs", *arguments, package, env=environment).split()


class Case(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.installed = Installed()
        cls.memory = cls.installed.memory
        cls.addClassCleanup(cls.installed.close)

    def halftone(self, query, picture=None):
        file = io.BytesIO()
        (picture or self.installed.picture).save(file, "png")
        answer = ask(self.installed.server, f"/halftone?sites=900&format=json&{query}", data=file.getvalue())
        self.assertEqual(answer.status, 200, answer)
        return answer.json()

    def sample(self, body):
        answer = post_json(self.installed.server, "/sample", body)
        self.assertEqual(answer.status, 200, answer)
        return answer.json()

    def assert_outlines_are_equal(self, rings, rounded):
        """Compares outlines with those of the service, which are rounded to three decimals."""
        self.assertEqual([len(ring) for ring in rings], [len(ring) for ring in rounded])
        for ring, other in zip(rings, rounded):
            self.assertLess(numpy.abs(numpy.array(ring) - other).max(), 0.00051)

    # Files.

    def test_components_contain_their_files(self):
        lib = self.installed.libraries.relative_to(self.installed.prefix).as_posix()
        libraries = {f"{lib}/{name}.so.2{rest}" for name in ("libccdt", "libccdt-api") for rest in ("", ".0.0")}
        self.assertEqual(self.installed.library_files, libraries)
        development = {f"include/ccdt/{name}" for name in HEADERS}
        development |= {f"{lib}/{name}{suffix}" for name in ("libccdt", "libccdt-api") for suffix in (".a", ".so")}
        development |= {f"{lib}/pkgconfig/{name}.pc" for name in ("ccdt", "ccdt-api")}
        package = {name for name in self.installed.all_files if name.startswith(f"{lib}/cmake/ccdt/")}
        self.assertIn(f"{lib}/cmake/ccdt/ccdt-config.cmake", package)
        self.assertEqual(self.installed.all_files, libraries | development | package)

    def test_files_name_no_folder_of_the_build(self):
        for path in self.installed.prefix.rglob("*"):
            if path.suffix in (".h", ".pc", ".cmake"):
                with self.subTest(path=path):
                    self.assertNotIn(str(ROOT), path.read_text())
        for name in ("libccdt", "libccdt-api"):
            dynamic = output_of("readelf", "--dynamic", "--wide", self.installed.libraries / f"{name}.so.2")
            self.assertIn(f"soname: [{name}.so.2]", dynamic)
            self.assertNotRegex(dynamic, "RPATH|RUNPATH")

    def test_shared_libraries_export_the_interface_only(self):
        counts = []
        for name in ("libccdt", "libccdt-api"):
            path = self.installed.libraries / f"{name}.so.2"
            lines = output_of("nm", "--dynamic", "--defined-only", "--demangle", path).splitlines()
            symbols = [line.split(maxsplit=2)[2] for line in lines]
            pattern = r"CCDT_2$|((typeinfo|typeinfo name|vtable) for )?ccdt::v2::[^ ]+.*@@CCDT_2$"
            self.assertEqual([symbol for symbol in symbols if not re.match(pattern, symbol)], [])
            for word in ("Execution", "core_", "raise"):
                self.assertEqual([symbol for symbol in symbols if word in symbol], [])
            counts.append(len(symbols))
        self.assertGreater(min(counts), 3)

    def test_headers_include_only_the_standard_library_and_each_other(self):
        folder = self.installed.prefix / "include" / "ccdt"
        for name in sorted(HEADERS):
            for included in re.findall(r'^\s*#\s*include\s*(.*)', (folder / name).read_text(), re.MULTILINE):
                with self.subTest(name=name, included=included):
                    self.assertRegex(included, r'^<[a-z_]+>$|^"ccdt/[a-z]+\.h"$')
                    if included.startswith('"ccdt/'):
                        self.assertIn(included[6:-1], HEADERS)

    def test_headers_compile_alone(self):
        include = f"-I{self.installed.prefix / 'include'}"
        cases = [("g++", name) for name in sorted(HEADERS)]
        if shutil.which("clang++"):
            cases += [("clang++", "ccdt.h"), ("clang++", "service.h")]  # these include all others
        for compiler, name in cases:
            with self.subTest(compiler=compiler, header=name):
                output_of(compiler, *WARNINGS, "-fsyntax-only", include, "-include", f"ccdt/{name}", "-x", "c++",
                          os.devnull)

    # Projects.

    def test_static_programs_print_the_same(self):
        self.assertEqual(json.loads(self.installed.run_memory("static")), self.memory)
        loaded = output_of("ldd", self.installed.build / "memory_static")
        self.assertNotIn("libccdt", loaded)
        self.assertIn("libccdt.so.2", output_of("ldd", self.installed.build / "memory_shared"))

    def compile_and_run(self, code, compiler, *options):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "main.cpp").write_text(code)
            (pathlib.Path(folder) / "photo.jpg").symlink_to(PICTURES / "chelsea.png")  # recognised by its first bytes
            output_of(compiler, *WARNINGS, "main.cpp", "-o", "main", *options, cwd=folder)
            environment = {**os.environ, "LD_LIBRARY_PATH": str(self.installed.libraries)}
            output = output_of("./main", cwd=folder, env=environment)
            files = {path.name: path.read_bytes() for path in pathlib.Path(folder).iterdir()}
            return output, files

    def test_examples_of_readmes_run(self):
        examples = []
        for page in (ROOT / "README.md", *(ROOT / "core").rglob("README.md"), *(ROOT / "api").rglob("README.md")):
            examples += re.findall(r"^```cpp\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)
        examples = [code for code in examples if "#include <ccdt/" in code]
        self.assertGreaterEqual(len(examples), 3)
        for number, code in enumerate(examples):
            package = "ccdt-api" if "<ccdt/service.h>" in code else "ccdt"
            with self.subTest(code=code):
                compiler = COMPILERS[number % len(COMPILERS)]
                output, files = self.compile_and_run(code, compiler, *self.installed.options_of_package(package))
                if package == "ccdt-api":
                    self.assertEqual(Image.open(io.BytesIO(files["dots.png"])).format, "PNG")
                else:
                    self.assertTrue(output)

    def test_pkg_config_links_a_program_without_shared_libraries(self):
        code = '#include <ccdt/ccdt.h>\n#include <cstdio>\nint main() { std::puts(ccdt::version()); return ' \
               'ccdt::sample(ccdt::Torus{1, 1}, 100).points.size() == 100 ? 0 : 1; }\n'
        options = self.installed.options_of_package("ccdt", "--static")
        output, _ = self.compile_and_run(code, "g++", "-static", *options)
        version = re.search(r"^project\(ccdt VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE)[1]
        self.assertEqual(output, f"{version}\n")
        self.assertEqual(self.memory["version"], version)

    # Results in memory.

    def test_points_are_those_of_the_service(self):
        answer = self.sample({**SQUARE, "sites": 300, "seed": 7, "mesh": True, "fixed": [[3, 3], [0.5, 0.5]],
                              "density": {"width": 2, "height": 1, "values": [1, 3]}})
        self.assertEqual(self.memory["varied"], answer["points"])
        self.assertEqual(self.memory["trace"], [entry["variation"] for entry in answer["trace"]])
        mesh = self.memory["mesh"]
        for name in ("vertices", "triangles", "boundary"):
            self.assertEqual(mesh[name], answer[name])
        self.assertEqual(self.memory["repairs"], 1)

    def test_progressive_orders_are_those_of_the_service(self):
        uniform = self.sample({**TORUS, "sites": 500, "quality": "stealthy"})["points"]
        self.assertEqual(self.memory["uniform"], uniform)
        ordered = self.sample({**TORUS, "sites": 500, "quality": "stealthy", "order": "progressive"})["points"]
        self.assertEqual([uniform[i] for i in self.memory["order"]], ordered)

    def test_points_in_space_are_those_of_the_service(self):
        sides = {"width": 1, "height": 1, "depth": 1}
        box = {"sites": 200, "domain": {**sides, "type": "box", "width": 2}, "order": "progressive", "mesh": True,
               "density": {"width": 1, "height": 1, "depth": 2, "values": [1, 3]}, "fixed": [[1, 0.5, 0.5]]}
        answer = post_json(self.installed.server, "/sample", box).json()
        self.assertEqual(self.memory["box"], answer["points"])
        self.assertEqual(self.memory["tetrahedra"], answer["mesh"]["tetrahedra"])
        torus = {"sites": 100, "domain": {**sides, "type": "torus"}, "quality": "stealthy"}
        self.assertEqual(self.memory["torus"], post_json(self.installed.server, "/sample", torus).json()["points"])
        off = b"OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
        inside = ask(self.installed.server, "/sample?domain=solid&sites=50", data=off).json()["points"]
        self.assertEqual(self.memory["solid"], inside)
        self.assertEqual(self.memory["open solid"][0], UNUSABLE)

    def test_analyses_are_those_of_the_service(self):
        answer = post_json(self.installed.server, "/analyze", {**TORUS, "points": self.memory["uniform"]}).json()
        analysis = self.memory["analysis"]
        for name in ("min_distance", "mean_distance", "low_frequency_power", "power"):
            self.assertEqual(analysis[name], answer[name], name)
        self.assertEqual(analysis["spectrum"], analysis["width"] * analysis["height"])
        # The densest packing.
        self.assertAlmostEqual(self.memory["analysis in space"]["min_distance"], 1)

    def test_dots_on_both_sides_are_those_of_the_service(self):
        grey = self.installed.picture.getchannel("G")
        alpha = numpy.tile(numpy.arange(grey.width, dtype=numpy.uint8), (grey.height, 1))
        transparent = Image.merge("LA", (grey, Image.fromarray(alpha)))
        for name, query, picture in (("both", "", self.installed.picture), ("grey", "", grey),
                                     ("transparent", "", transparent), ("linear transparent", "&alpha=linear", transparent)):
            with self.subTest(name=name):
                answer = self.halftone("dots=both" + query, picture)
                found = self.memory[name]
                self.assertEqual(found["points"], answer["points"])
                self.assert_outlines_are_equal(found["rings"][0], answer["rings"])
        self.assertEqual(self.memory["floats"], self.memory["both"])

    def test_dots_on_one_side_are_those_of_the_service(self):
        for name, query in (("ink", "dots=ink&seed=3"), ("paper", "dots=paper&tone=perceptual")):
            with self.subTest(name=name):
                answer = self.halftone(query)
                found = self.memory[name]
                self.assertEqual(found["points"], answer["points"])
                self.assertEqual(found["radius"], answer["radius"])
                self.assertEqual(found["rings"], [])

    def test_dots_in_colour_are_those_of_the_service(self):
        answer = self.halftone("dots=both&color=cmyk")
        found = self.memory["colour"]
        self.assertEqual(found["points"], answer["points"])
        for rings, ink in zip(found["rings"], answer["inks"], strict=True):
            self.assert_outlines_are_equal(rings, ink["rings"])

    def test_errors_name_the_field(self):
        wanted = {
            "no points": (MALFORMED, "sites", "is 0, but must be from 1 to 268435456"),
            "no dots": (MALFORMED, "sites", "is 0, but must be from 1 to 268435456"),
            "crossing": (UNUSABLE, "/0/0/2", "crosses itself at (0.5, 0.5)"),
            "nan corner": (UNUSABLE, "/0/0/1", "not finite"),
            "nan side": (MALFORMED, "width", "nan"),
            "nan fixed": (MALFORMED, "fixed/1", "nan"),
            "nan density": (MALFORMED, "density/values/1", "finite"),
            "few densities": (MALFORMED, "density/values", "4 values, not 2"),
            "empty polygon": (UNUSABLE, "", "at least one polygon"),
            "large seed": (MALFORMED, "seed", "9007199254740991"),
            "point outside": (UNUSABLE, "points/0", "outside"),
            "white": (UNUSABLE, "values", "white"),
            "black": (UNUSABLE, "values", "black"),
            "wrong size": (MALFORMED, "values", "72 values, not 64"),
            "no width": (MALFORMED, "width", "is 0, but must be from 1 to 2147483647"),
            "five channels": (MALFORMED, "channels", "from 1 to 4"),
            "colour of ink": (MALFORMED, "colour", "Both"),
            "nan detail": (MALFORMED, "detail", "is nan, but must be from 0 to 1"),
            "high frequency": (MALFORMED, "max_frequency", "is 17, but must be from 1 to 16"),
            "analysis of polygon": (MALFORMED, "domain", "Rectangle or a Torus"),
            "analysis of a solid": (MALFORMED, "domain", "Box3 or a Torus3"),
            "analysis of nan in space": (UNUSABLE, "sets/0/1", "outside"),
            "analysis outside": (UNUSABLE, "sets/0/1", "outside"),
            "analysis of nan": (MALFORMED, "sets/0/1", "nan"),
        }
        for name, (code, field, text) in wanted.items():
            with self.subTest(name=name):
                self.assertEqual(self.memory[name][:2], [code, field])
                self.assertIn(text, self.memory[name][2])
        solid = self.memory["solid black"]
        self.assertEqual(solid["points"], [])
        self.assertEqual(len(solid["rings"][0]), 1)

    def test_computations_can_be_stopped_and_observed(self):
        self.assertEqual(self.memory["stopped"][:2], [STOPPED, ""])
        stopped, points, entries = self.memory["partial"]
        self.assertEqual((stopped, points), (1, 5000))
        self.assertLess(entries, 10)
        progress = self.memory["progress"]
        self.assertGreater(len(progress), 5)
        self.assertEqual(progress, sorted(progress))
        self.assertTrue(0 < progress[0] and progress[-1] < 1)
        self.assertEqual(self.memory["thrown"], "enough")

    # Files as the service answers them.

    def test_files_have_the_bytes_of_the_service(self):
        folder = pathlib.Path(self.installed.folder.name)
        torus = folder / "torus.json"
        torus.write_text(json.dumps({**TORUS, "sites": 200}))
        points = folder / "points.json"
        points.write_text(json.dumps({"points": self.memory["uniform"], **TORUS}))
        italy, countries = POLYGONS / "Italy-110m.geojson", POLYGONS / "two-countries.zip"
        cases = (
            ("halftone", self.installed.png, "dots.png", {"sites": "900"}, "image/png"),
            ("halftone", self.installed.png, "dots.svg", {"color": "cmyk", "sites": "300"}, "image/svg+xml"),
            ("halftone", self.installed.png, "dots.bmp", {"device": "bwr"}, "image/bmp"),
            ("sample", italy, "dots.csv", {"sites": "400", "coordinates": "lonlat"}, "text/csv"),
            ("sample", italy, "dots.geojson", {"sites": "50"}, "application/geo+json"),
            ("sample", countries, "map.csv", {"sites": "70"}, "text/csv"),
            ("sample", torus, "tile.npy", {}, "application/x-npy"),
            ("analyze", points, "spectrum.svg", {}, "image/svg+xml"),
            ("sample", POLYGONS.parent / "meshes" / "house.obj", "house.ply", {"sites": "60"}, "model/ply"),
        )
        for number, (operation, source, name, options, media_type) in enumerate(cases):
            with self.subTest(operation=operation, name=name):
                pairs = [text for option in options.items() for text in option]
                code, printed = self.installed.run_files(operation, source, folder / name, *pairs,
                                                         kind=("shared", "static")[number % 2])
                self.assertEqual(code, 0, printed)
                query = "&".join(f"{key}={value}" for key, value in options.items())
                answer = ask(self.installed.server, f"/{operation}?{query}" if query else f"/{operation}",
                             "--header", f"Accept: {media_type}", data=source.read_bytes())
                self.assertEqual(answer.status, 200, answer)
                self.assertEqual((folder / name).read_bytes(), answer.body)
                self.assertEqual(printed, answer.type)

    def test_failures_leave_no_file(self):
        folder = pathlib.Path(self.installed.folder.name) / "failures"
        folder.mkdir()
        kept = folder / "kept.png"
        kept.write_text("kept")
        picture = self.installed.png
        white = folder / "white.png"
        Image.new("L", (20, 20), 255).save(white)
        broken = folder / "broken.png"
        broken.write_bytes(picture.read_bytes()[:500])
        cases = (
            (("halftone", picture, kept, "sites", "0"), f"{MALFORMED} sites: sites must be an integer from 1 to"),
            (("halftone", white, kept), f"{UNUSABLE} : the image is white"),
            (("halftone", broken, kept), f"{UNUSABLE} : "),
            (("halftone", folder, kept), f"{UNAVAILABLE} input: {folder} cannot be read: Is a directory"),
            (("halftone", folder / "none", kept), f"{UNAVAILABLE} input: {folder}/none cannot be read: No such file"),
            (("halftone", picture, folder / "dots.doc"), f"{NOT_ACCEPTABLE} output: {folder}/dots.doc: the suffix names no format"),
            (("halftone", picture, folder / "none" / "dots.png"), f"{UNAVAILABLE} output: {folder}/none/dots.png cannot"),
            (("halftone", picture, "/dev/full", "format", "svg"),
             f"{UNAVAILABLE} output: /dev/full cannot be written: No space left"),
            (("sample", picture, folder / "dots.csv", "sites", "9"), f"{UNSUPPORTED} "),
            (("sample", POLYGONS / "two-countries.zip", kept, "sites", "9", "object", "none"), f"{UNUSABLE} object: "),
            (("analyze", picture, folder / "plot.svg", "sites", "9"), f"{MALFORMED} sites: the body is not a mesh"),
        )
        for arguments, text in cases:
            with self.subTest(text=text):
                code, printed = self.installed.run_files(*arguments)
                self.assertEqual((code, printed[:len(text)]), (1, text))
        self.assertEqual(kept.read_text(), "kept")
        self.assertEqual({path.name for path in folder.iterdir()}, {"kept.png", "white.png", "broken.png"})


if __name__ == "__main__":
    unittest.main(verbosity=2)
