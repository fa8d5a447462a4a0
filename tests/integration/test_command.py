# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line ccdt: answers, files, messages, exit statuses, manual pages and completion."""

import json
import os
import pathlib
import pty
import re
import select
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
import urllib.parse

import numpy
from PIL import Image

from harness import (PATIENCE, PICTURES, POLYGONS, ROOT, ServerCase, check_private_dev, data_uri, execute, pixels,
                     post_json, wait_until)

PROGRAM = pathlib.Path(os.environ["CCDT_COMMAND"])
PICTURE = PICTURES / "camera.png"
OTHER = PICTURES / "chelsea.png"
MESH = ROOT / "tests" / "data" / "meshes" / "house.obj"
TORUS = '{"type":"torus","width":1,"height":1}'

# Arguments that compute for several seconds, so that a test can interrupt the program.
LONG = ("sample", "--domain", TORUS, "--sites", "200000", "--quality", "best")


def run(*arguments, program=PROGRAM, **options):
    """Runs ccdt with separate pipes for its output and its messages."""
    return execute([program, *map(str, arguments)], capture_output=True, stdin=options.pop("stdin", subprocess.DEVNULL)
                   if "input" not in options else None, **options)


def start(*arguments, **options):
    return subprocess.Popen([PROGRAM, *map(str, arguments)], **options)


class Folder(unittest.TestCase):
    """A test case whose tests have an empty folder each."""

    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def names(self):
        return sorted(path.name for path in self.folder.iterdir())

    def assert_done(self, result):
        self.assertEqual((result.returncode, result.stderr), (0, b""))
        return result.stdout

    def assert_fails(self, result, status, *words):
        message = result.stderr.decode()
        self.assertEqual(result.returncode, status, message)
        for word in words:
            self.assertIn(word, message)
        return message


class Answers(ServerCase, Folder):
    """Answers are the bytes that the service sends."""

    def compare(self, served, *arguments):
        self.assertEqual(served.status, 200, served)
        result = run(*arguments, "--quiet")
        self.assertEqual(self.assert_done(result), served.body)

    def test_halftones_equal_those_of_the_service(self):
        for query in ("", "sites=2000&format=svg", "sites=2000&color=cmyk&format=csv", "format=npy&dots=both&sites=900",
                      "sites=500&width_mm=60&format=gcode", "device=spectra6&width=200&height=120&fit=cover",
                      "sites=800&palette=%23c03,%23036&antialias=false&scale=2"):
            with self.subTest(query):
                options = [f"--{part}".replace("%23", "#") for part in query.split("&") if part]
                served = self.ask(f"/halftone?{query}", data=OTHER.read_bytes())
                self.compare(served, "halftone", OTHER, "-o", "-", *options)

    def test_points_equal_those_of_the_service(self):
        for members in ({"format": "csv", "order": "progressive"}, {"format": "npy", "method": "cvt"},
                        {"format": "geojson", "multipoint": False}, {"format": "png", "dot": 0.01}):
            with self.subTest(members):
                served = post_json(self.server, "/sample", {"domain": json.loads(TORUS), "sites": 300, **members})
                options = [f"--{name}={str(value).lower()}" for name, value in members.items()]
                self.compare(served, "sample", "--domain", TORUS, "--sites=300", *options)

    def test_maps_and_shapefiles_equal_those_of_the_service(self):
        for name, query in (("Switzerland-10m.geojson", "sites=200&format=geojson&coordinates=lonlat"),
                            ("southern-Africa-110m.topojson", "sites=90&properties=*&format=csv&object=countries"),
                            ("two-countries.zip", "sites=120&format=svg&object=two-countries"),
                            ("two-countries.zip", "sites=people&per=1&properties=name&format=csv")):
            with self.subTest(name, query=query):
                file = POLYGONS / name
                served = self.ask(f"/sample?{query}", data=file.read_bytes())
                options = [f"--{part}" for part in query.split("&")]
                self.compare(served, "sample", file, *options)

    def test_values_come_from_files(self):
        polygon = self.folder / "polygon.json"
        polygon.write_text("[[0,0],[4,0],[4,3]]")
        served = post_json(self.server, "/sample", {
            "polygon": json.loads(polygon.read_text()), "density": {"image": data_uri(PICTURE.read_bytes())},
            "sites": 200, "format": "csv"})
        self.compare(served, "sample", "--polygon", f"@{polygon}", "--density", f"@{PICTURE}", "--sites", 200,
                     "--format", "csv")

    def test_points_in_space_equal_those_of_the_service(self):
        voxels = self.folder / "voxels.npy"
        numpy.save(voxels, numpy.arange(1, 9).reshape(2, 2, 2))
        domain = '{"type":"box","width":2,"height":1,"depth":1}'
        query = urllib.parse.urlencode({"domain": domain, "sites": 60, "format": "vtu", "mesh": "true"})
        served = self.ask("/sample?" + query, data=voxels.read_bytes())
        options = ("--domain", domain, "--sites=60", "--format=vtu", "--mesh")
        self.compare(served, "sample", voxels, *options)
        self.compare(served, "sample", "--density", f"@{voxels}", *options)
        layers = [Image.fromarray(layer) for layer in numpy.arange(1, 9, dtype="u1").reshape(2, 2, 2)]
        layers[0].save(self.folder / "voxels.tif", save_all=True, append_images=layers[1:])
        self.compare(served, "sample", "--density", f"@{self.folder / 'voxels.tif'}", *options)
        served = self.ask("/sample?domain=torus&depth=4&sites=60&format=csv", data=voxels.read_bytes())
        self.compare(served, "sample", voxels, "--domain=torus", "--depth=4", "--sites=60", "--format=csv")
        served = post_json(self.server, "/sample", {"domain": json.loads(domain), "sites": 60, "format": "csv"})
        self.compare(served, "sample", "--domain=box", "--width=2", "--height=1", "--depth=1", "--sites=60",
                     "--format=csv")

    def test_maps_take_options_that_the_service_takes_in_a_body(self):
        file = POLYGONS / "Italy-110m.geojson"
        served = post_json(self.server, "/sample", {"geometry": json.loads(file.read_text()), "fixed": [[12.5, 42]],
                                                    "sites": 50, "format": "csv"})
        self.compare(served, "sample", file, "--fixed", "[[12.5,42]]", "--sites", 50, "--format", "csv")

    def test_choices_equal_those_of_the_service(self):
        table, features = self.folder / "table.csv", self.folder / "features.json"
        table.write_text("x,y,name\r\n" + "".join(f"{i % 30},{i // 30},n{i}\r\n" for i in range(900)), newline="")
        served = self.ask("/sample?candidates=body&sites=40", "--header", "Content-Type: text/csv",
                          data=table.read_bytes())
        self.assertEqual(served.body.count(b"\r\n"), 41)
        self.compare(served, "choose", table, "--sites=40")
        lines = [json.dumps({"type": "Feature", "geometry": {"type": "Point", "coordinates": [x, 0]}}) for x in range(9)]
        features.write_text("\n".join(lines))
        # The suffix of the output is that of the input, so the format is, too.
        self.assert_done(run("choose", features, "--sites=2", "-o", self.folder / "chosen.json", "--quiet"))
        self.assertEqual(len(set((self.folder / "chosen.json").read_text().splitlines()) & set(lines)), 2)

    def test_analyses_equal_those_of_the_service(self):
        expected = {}
        for kind in ("csv", "npy", "json", "geojson"):
            points = self.folder / f"points.{kind}"
            self.assert_done(run("sample", "--domain", TORUS, "--sites", 200, "-o", points))
            for answer in ("json", "svg"):
                if answer not in expected:
                    table = [line.split(",") for line in points.read_text().split()[1:]]
                    body = {"points": [[float(x), float(y)] for x, y in table], "max_frequency": 3, "format": answer}
                    expected[answer] = post_json(self.server, "/analyze", body)
                with self.subTest(kind, answer=answer):
                    self.compare(expected[answer], "analyze", points, "--max-frequency=3", "--format", answer)
            self.assert_fails(run("analyze", points, "--domain=square"), 2, "--domain must be a JSON object")

    def test_analyses_on_meshes_equal_those_of_the_service(self):
        points = self.folder / "points.ply"
        self.assert_done(run("sample", MESH, "--sites", 100, "-o", points))
        served = self.ask("/analyze", "-F", f"mesh=@{MESH}", "-F", f"points=@{points}", "-F", "modes=20")
        self.compare(served, "analyze", points, "--mesh", MESH, "--modes=20")
        self.assert_fails(run("analyze", points, "--mesh", PICTURE), 3, "--mesh", PICTURE.name, "not an STL")
        self.assert_fails(run("analyze", PICTURE, "--mesh", MESH), 3, "points")

    def test_pixels_equal_those_of_the_service(self):
        domain = '{"type":"pixels","width":40,"height":30}'
        served = post_json(self.server, "/sample", {"domain": json.loads(domain), "sites": 100, "include": [[1, 2]],
                                                    "format": "npy"})
        self.compare(served, "sample", "--domain", domain, "--sites=100", "--include=[[1,2]]", "--format=npy")

    def test_do_not_depend_on_the_number_of_threads(self):
        arguments = ("sample", "--domain", TORUS, "--sites", 5000, "--format", "csv")
        self.assertEqual(self.assert_done(run(*arguments, "--threads", 1)),
                         self.assert_done(run(*arguments, "--threads", 3)))


class Files(Folder):
    def test_pattern_names_an_output_for_each_input(self):
        self.assert_done(run("halftone", PICTURE, OTHER, "-o", f"{self.folder}/{{name}}-dots.svg", "--sites=300"))
        self.assertEqual(self.names(), ["camera-dots.svg", "chelsea-dots.svg"])

    def test_a_name_may_have_the_maximum_length(self):
        name = "a" * 251 + ".svg"
        self.assert_done(run("halftone", PICTURE, "-o", self.folder / name, "--sites=300"))
        self.assertEqual(self.names(), [name])

    def test_a_failed_input_does_not_prevent_the_others(self):
        missing, text = self.folder / "missing.png", self.folder / "text.png"
        text.write_text("not a picture")
        result = run("halftone", missing, text, PICTURE, "-o", f"{self.folder}/{{name}}.svg", "--sites=300")
        self.assert_fails(result, 3, f"ccdt: {missing}: No such file or directory\n", f"ccdt: {text}: ")
        self.assertEqual(self.names(), ["camera.svg", "text.png"])

    def test_outputs_are_checked_before_any_work(self):
        own = self.folder / "own.png"
        shutil.copy(PICTURE, own)
        cases = ((2, (PICTURE, OTHER, "-o", self.folder / "a.svg"), f"{OTHER} have the same output"),
                 (2, (PICTURE, OTHER), "have the same output, standard output"),
                 (2, (own, "-o", f"{self.folder}/{{name}}.png"), f"would replace the input {own}"),
                 (2, (PICTURE, "-o", self.folder / "a.xyz"), ".png, .json, .svg"),
                 (4, (PICTURE, "-o", self.folder / "no" / "a.svg"), f"{self.folder}/no: No such file or directory"))
        for status, arguments, message in cases:
            with self.subTest(message):
                self.assert_fails(run("halftone", *arguments, "--format=svg" if status == 4 else "-q"), status, message)
        self.assertEqual(self.names(), ["own.png"])
        self.assertEqual(own.read_bytes(), PICTURE.read_bytes())

    def test_existing_files_are_replaced_and_keep_their_mode(self):
        output, link = self.folder / "a.csv", self.folder / "link.csv"
        output.write_text("before")
        output.chmod(0o640)
        link.symlink_to(output.name)
        self.assert_done(run("sample", "--domain", TORUS, "--sites", 3, "-o", link))
        self.assertTrue(link.is_symlink())
        self.assertTrue(output.read_bytes().startswith(b"x,y\r\n"))
        self.assertEqual(output.stat().st_mode & 0o777, 0o640)
        self.assertEqual(self.names(), ["a.csv", "link.csv"])

    def test_pipes_are_written_directly(self):
        pipe = self.folder / "pipe"
        os.mkfifo(pipe)
        with start("sample", "--domain", TORUS, "--sites", 3, "--format=csv", "-o", pipe) as process:
            self.assertTrue(pipe.read_text().startswith("x,y\n"))
            self.assertEqual(process.wait(PATIENCE), 0)
        self.assertEqual(self.names(), ["pipe"])

    def test_open_files_and_devices_are_written_directly(self):
        command = [PROGRAM, "sample", "--domain", TORUS, "--sites", 3, "--quiet", "--format=csv", "--output"]
        check_private_dev(command, self.folder, self.assert_done(run(*command[1:], "-")))

    def test_inputs_share_no_open_file(self):
        link = self.folder / "link.csv"
        link.symlink_to("/proc/self/fd/1")
        inputs = (POLYGONS / "Italy-110m.geojson", POLYGONS / "Switzerland-10m.geojson")
        self.assert_fails(run("sample", *inputs, "--sites=3", "-o", link), 2, "have the same output")

    def test_a_file_that_is_mounted_is_written_directly(self):
        output, mounted = self.folder / "a.csv", self.folder / "b.csv"
        output.touch()
        mounted.write_text("before " * 1000)
        command = ("sample", "--domain", TORUS, "--sites=3", "-o")
        script = 'mount --bind "$1" "$2"; shift 2; exec "$@"'
        mounting = ("unshare", "--mount", "sh", "-ec", script, "sh", mounted, output)
        if execute([*mounting, "true"], capture_output=True).returncode != 0:
            self.skipTest("no mount namespace can be made here")
        self.assert_done(execute([*mounting, PROGRAM, *command, output], capture_output=True))
        self.assertEqual((output.read_bytes(), self.names()), (b"", ["a.csv", "b.csv"]))
        self.assertEqual(mounted.read_bytes(), self.assert_done(run(*command, "-", "--format=csv")))

    def test_standard_streams(self):
        dots = self.assert_done(run("halftone", "-", "--sites=300", input=PICTURE.read_bytes()))
        self.assertEqual(pixels(dots).shape, (1000, 1000))
        self.assertEqual(dots, self.assert_done(run("halftone", PICTURE, "-o", "-", "--sites=300")))
        self.assert_fails(run("halftone", "-", "-", "-o", "{name}.png"), 2, "standard input (-) is given twice")

    def test_large_answers_are_complete(self):
        output = self.folder / "points.csv"
        self.assert_done(run("sample", "--domain", TORUS, "--sites", 200000, "--method=random", "-o", output))
        self.assertEqual(output.read_bytes().count(b"\n"), 200001)
        self.assertGreater(output.stat().st_size, 4 << 20)

    def test_a_full_disk_fails_without_a_file(self):
        with open("/dev/full", "wb") as full:
            result = execute([PROGRAM, "sample", "--domain", TORUS, "--sites=3"], stdout=full, stderr=subprocess.PIPE)
        self.assert_fails(result, 4, "cannot write standard output: No space left on device")
        output = self.folder / "points.csv"
        result = execute(["prlimit", "--fsize=1000000", PROGRAM, "sample", "--domain", TORUS, "--sites=200000",
                          "--method=random", "-o", output], capture_output=True)
        self.assert_fails(result, 4, f"cannot write {output}: File too large")
        self.assertEqual(self.names(), [])

    def test_a_closed_pipe_ends_the_program_silently(self):
        with start("sample", "--domain", TORUS, "--sites=200000", "--method=random", "--format=csv",
                   stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            process.stdout.read(10)
            process.stdout.close()
            self.assertEqual(process.stderr.read(), b"")
            self.assertEqual(process.wait(PATIENCE), -signal.SIGPIPE)


class Interruptions(Folder):
    def test_an_interrupted_run_leaves_existing_files_alone(self):
        output = self.folder / "points.csv"
        output.write_text("before")
        for number in (signal.SIGINT, signal.SIGTERM):
            with start(*LONG, "-o", output, "--json", stderr=subprocess.PIPE) as process:
                self.assertEqual(json.loads(process.stderr.readline())["type"], "progress")
                process.send_signal(number)
                self.assertEqual(process.wait(PATIENCE), -number)
        self.assertEqual((self.names(), output.read_text()), (["points.csv"], "before"))

    def test_an_incomplete_file_is_removed(self):
        output = self.folder / "points.geojson"
        arguments = ("sample", "--domain", TORUS, "--sites=300000", "--method=random", "--no-multipoint", "-o", output)
        for _ in range(10):
            with start(*arguments) as process:
                wait_until(self.names, "a temporary file")
                process.send_signal(signal.SIGINT)
                interrupted = process.wait(PATIENCE) == -signal.SIGINT
            if interrupted and not output.exists():
                self.assertEqual(self.names(), [])
                return
            output.unlink(missing_ok=True)  # it was complete before the signal arrived
        self.fail("every file was complete before the signal arrived")

    def test_waiting_for_input_ends_at_once(self):
        with start("halftone", "-", "-o", self.folder / "a.png", stdin=subprocess.PIPE) as process:
            threads = pathlib.Path(f"/proc/{process.pid}/task")
            wait_until(lambda: len(list(threads.iterdir())) >= 3, "the threads of a program that waits for its input")
            process.send_signal(signal.SIGTERM)
            self.assertEqual(process.wait(PATIENCE), -signal.SIGTERM)

    def test_a_shell_reports_143(self):
        script = '"$@" & echo $!; wait $!; echo $?'
        with subprocess.Popen(["bash", "-c", script, "bash", PROGRAM, *LONG, "-o", self.folder / "a.csv", "--json"],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE) as shell:
            number = int(shell.stdout.readline())
            self.assertIn(b"progress", shell.stderr.readline())
            os.kill(number, signal.SIGTERM)
            self.assertEqual(shell.stdout.readline(), b"143\n")


class Errors(Folder):
    def test_name_the_option_the_value_and_the_limit(self):
        domain = ("--domain", TORUS)
        for status, arguments, message in (
                (2, (), "Usage: ccdt COMMAND"),
                (2, ("draw",), "draw is not a command"),
                (2, ("help", "draw"), "draw is not a command"),
                (2, ("manual", "sample", "analyze"), "one command can be described at a time, not 2"),
                (2, (PICTURE,), f"ccdt halftone {PICTURE} turns a picture into dots"),
                (2, ("halftone",), "halftone needs an input"),
                (2, ("sample", "--sites=3"), "--domain, --polygon and --geometry"),
                (2, ("halftone", PICTURE, "--sites=many"), "--sites must be an integer from 1 to 100000000, not 'many'"),
                (2, ("halftone", PICTURE, "--detail=2"), "--detail must be a number from 0 to 1, not '2'"),
                (2, ("halftone", PICTURE, "--format=gif"), "--format 'gif' is not available here; the formats are png,"),
                (2, ("halftone", PICTURE, "--format=pdf"), "--width-mm (the width of the drawing in millimetres)"),
                (2, ("halftone", PICTURE, "--minutes=30"), "--minutes needs --width-mm or paper"),
                (2, ("halftone", PICTURE, "--dpi=300"), "--dpi needs --width-mm,"),
                (2, ("sample", *domain, "--sites=3", "--density=/etc/passwd"), "; @ before the name of a file reads it: @/etc/passwd"),
                (2, ("sample", *domain), "--sites"),
                (2, ("sample", MESH, "--sites=3", "-o", "x.png"), "--output x.png sets --format=png: format 'png' is not available here; the formats are json, csv, npy, ply, glb"),
                (2, ("sample", "--domain=solid", "--sites=3"), "--domain solid needs a mesh"),
                (2, ("sample", *domain, "--sites=3", "--max_frequency=3"), "--max_frequency is not an option"),
                (2, ("sample", "--domain={", "--sites=3"), "--domain is not valid JSON: error at byte"),
                (2, ("sample", "--domain", '{"type":"torus","width":0,"height":1}', "--sites=3"), "--domain/width"),
                (2, ("analyze", "-", "--max-frequency=17"), "--max-frequency must be a number from 1 to 16, not '17'"),
                (1, ("sample", *domain, "--sites=30", "--max-sites=20"), "--sites is 30; the limit (--max-sites) is 20"),
                (1, ("sample", *domain, "--sites=3000", "--memory=1KiB"), "the limit (--memory) is 0 MiB"),
                (1, ("analyze", ROOT / "LICENSE", "--memory=1KiB"), "more bytes than half of the limit (--memory), 512"),
                (1, ("halftone", PICTURE, "--max-pixels=1000"), "the limit (--max-pixels) is 1000"),
                (3, ("halftone", ROOT / "LICENSE"), "the supported formats are PNG"),
                (3, ("sample", ROOT / "LICENSE", "--sites=3"), "the input seems to be text; accepted are options"),
                (3, ("sample", PICTURE, "--sites=3"), "the input seems to be a picture (PNG); accepted are options"),
                (3, ("sample", PICTURE, "--sites=3", "--avoid=[]"), "the input seems to be a picture (PNG)"),
                (3, ("halftone", MESH), "this is a mesh ("),
                (3, ("analyze", ROOT / "LICENSE"), "line 1 must name the columns"),
                (3, ("analyze", PICTURE), "the file seems to be a picture; points are read from CSV"),
                (1, ("analyze", "-", "--domain", '{"type":"torus","width":0.2,"height":1}'), "/points/1: the point lies"),
                (3, ("sample", *domain, "--sites=3", "--density=@/no/file"), "--density: /no/file: No such file")):
            with self.subTest(arguments=arguments):
                result = run(*arguments, input=b"x,y\n0.1,0.2\n0.3,0.4\n")
                self.assert_fails(result, status, message)
                self.assertEqual(result.stdout, b"")

    def run_measured(self, *arguments, stdin=subprocess.DEVNULL):
        """Returns the messages of a program, and its peak memory in bytes."""
        with start(*arguments, stdin=stdin, stderr=subprocess.PIPE) as process:
            message = process.stderr.read().decode()
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        return message, usage.ru_maxrss << 10

    def test_endless_inputs_are_not_read(self):
        zeros = "/dev/zero"
        for arguments in (("halftone", zeros), ("sample", zeros, "--sites=3"), ("analyze", zeros),
                          ("sample", "--domain", TORUS, "--sites=3", f"--density=@{zeros}"),
                          ("analyze", zeros, f"--mesh={zeros}")):
            with self.subTest(arguments):
                message, peak = self.run_measured(*arguments)
                self.assertIn(f"{zeros}: ", message)
                self.assertLess(peak, 256 << 20)

    def test_inputs_stay_within_the_memory(self):
        picture = PICTURE.read_bytes()
        script = 'cat "$0"; head -c 400000000 /dev/zero'
        for begin in (picture, b" " * 100_000, b'{"points":[' + 10_000_000 * b"[],"):
            start = self.folder / "start"
            start.write_bytes(begin)
            for command in ("halftone",) if begin is picture else ("sample", "analyze"):
                with self.subTest(begin[:10], command=command):
                    with subprocess.Popen(["sh", "-c", script, start], stdout=subprocess.PIPE) as source:
                        message, peak = self.run_measured(command, "-", "--memory=300MiB", stdin=source.stdout)
                        source.stdout.close()
                    self.assertIn("(--memory)", message)
                    self.assertLess(peak, 300 << 20)

    def test_outputs_can_be_in_a_folder(self):
        self.assert_done(run("halftone", PICTURE, OTHER, "-o", self.folder, "--sites=100"))
        self.assert_done(run("halftone", PICTURE, "-o", f"{self.folder}/", "--sites=100", "--format=hpgl", "--width-mm=100"))
        self.assertEqual(self.names(), sorted([f"{PICTURE.stem}.png", f"{OTHER.stem}.png", f"{PICTURE.stem}.plt"]))
        self.assert_done(run("halftone", PICTURE, "-o", self.folder / "a.nc", "--sites=100", "--width-mm=100"))
        self.assertTrue((self.folder / "a.nc").read_bytes().startswith(b"; 100 dots"))

    def test_inks_can_have_files_of_their_own(self):
        halftone = ("halftone", PICTURE, "--color=cmyk", "--sites=300", "--width-mm=100")
        self.assert_done(run(*halftone, "-o", self.folder / "{ink}.svg"))
        self.assertEqual(self.names(), ["cyan.svg", "magenta.svg", "yellow.svg"])
        self.assert_done(run(*halftone, "-o", self.folder, "--format=hpgl", "--split=100"))
        self.assertIn(f"{PICTURE.stem}-black-1.plt", self.names())
        self.assert_fails(run(*halftone, "-o", self.folder / "x.svg", "--split=ink"), 2, "{ink}")
        told = json.loads(run(*halftone, "-o", self.folder / "a {ink}.svg", "--json").stderr.splitlines()[-1])
        self.assertEqual(told["files"], [f"{self.folder}/a {ink}.svg" for ink in ("cyan", "magenta", "yellow")])
        self.assertNotIn("plot_seconds", told)  # pens do not draw areas
        self.assertEqual(told["bytes"], sum(pathlib.Path(name).stat().st_size for name in told["files"]))

    def test_json_bodies_can_have_several_files(self):
        shape = {"sites": 50, "width_mm": 100, "polygon": [[0, 0], [4, 0], [0, 3]]}
        for name, options in (("a", {}), ("b", {"split": "ink"}), ("c", {"split": 1, "speed": 1})):
            body = self.folder / f"{name}.json"
            body.write_text(json.dumps({**shape, **options}))
            self.assert_done(run("sample", body, "-o", self.folder / "{name} {ink}.svg"))
            self.assertIn(f"{name} dots{'-1' if name == 'c' else ''}.svg", self.names())
        self.assert_fails(run("sample", body, "-o", self.folder / "c.svg"), 2, "{ink}")
        self.assertNotIn("c.svg", self.names())

    def test_suffixes_set_the_format_of_json_bodies(self):
        body = {"sites": 9, "domain": {"type": "torus", "width": 16, "height": 8}}
        def made(output, **more):
            given = {**body, **more}
            (self.folder / "request.json").write_text(json.dumps({name: each for name, each in given.items() if each}))
            return run("sample", self.folder / "request.json", "-o", self.folder / output)
        self.assert_done(made("a.csv"))
        self.assertTrue((self.folder / "a.csv").read_text().startswith("x,y"))
        self.assert_done(made("a.png", format="mask16", sites=None))
        self.assertEqual(Image.open(self.folder / "a.png").size, (16, 8))
        self.assert_fails(made("b.csv", format="svg"), 2, "b.csv sets --format=csv: the input has the format svg")
        self.assert_fails(made("b.csv", format="abc"), 2, "abc")
        self.assertNotIn("b.csv", self.names())

    def test_numbers_can_be_thousands(self):
        sample = ("sample", "--domain", TORUS, "--iterations=0", "--format=csv")
        self.assertEqual(self.assert_done(run(*sample, "--sites=1.2k")), self.assert_done(run(*sample, "--sites=1200")))
        self.assert_fails(run(*sample, "--seed=k", "--sites=9"), 2, "--seed", "'k'")
        for typed in ("-1k", "1e-308k"):
            self.assert_fails(run(*sample, f"--sites={typed}"), 2, "--sites must be", f"not '{typed}'")

    def test_domains_of_the_plane_can_be_words(self):
        for word in ("torus", "rectangle"):
            domain = json.dumps({"type": word, "width": 2, "height": 1})
            self.assertEqual(self.assert_done(run("sample", "--domain", word, "--width=2", "--height=1", "--sites=50", "--format=csv")),
                             self.assert_done(run("sample", "--domain", domain, "--sites=50", "--format=csv")))

    def test_report_all_wrong_options_once(self):
        result = run("halftone", PICTURE, OTHER, "-o", f"{self.folder}/{{name}}.png", "--sites=0", "--scale=99")
        message = self.assert_fails(result, 2, "--scale must be a number from 0.1 to 16, not '99'")
        self.assertEqual(len(message.splitlines()), 2)

    def test_messages_can_be_json(self):
        output = f"{self.folder}/{{name}}.svg"
        result = run("halftone", "/no/file", PICTURE, "-o", output, "--sites=300", "--json")
        self.assertEqual(result.returncode, 3)
        error, *_, finished = map(json.loads, result.stderr.splitlines())
        self.assertEqual(error, {"type": "error", "status": 3, "input": "/no/file",
                                 "message": "No such file or directory"})
        self.assertEqual((finished["type"], finished["sites"], finished["media_type"], finished["output"]),
                         ("result", 300, "image/svg+xml", f"{self.folder}/camera.svg"))
        self.assertEqual(finished["bytes"], (self.folder / "camera.svg").stat().st_size)
        self.assertEqual(finished["tone"], 1)
        plot = run("halftone", PICTURE, "-o", output, "--style=path", "--pen=0.5", "--width-mm=100", "--sites=7000", "--json")
        told = {each["type"]: each for each in map(json.loads, plot.stderr.splitlines())}
        self.assertIn("sites: so few small dots cover only", told["warning"]["message"])
        self.assertLess(told["result"]["tone"], 0.8)
        self.assertGreater(told["result"]["plot_seconds"], 60)
        self.assertEqual(told["result"]["pen_mm"], 0.5)
        self.assertIn(f"<!-- 7000 dots, pen 0.5 mm, path {told['result']['path_mm'] / 1000:.2f}".rstrip("0"),
                      (self.folder / "camera.svg").read_text())
        error = json.loads(run("halftone", PICTURE, "--json", "--scale=x").stderr)
        self.assertEqual((error["status"], error["option"]), (2, "--scale"))
        error = json.loads(run("halftone", PICTURE, "--json", "-o", "a.xyz").stderr)
        self.assertEqual((error["status"], error["option"], error["message"][:16]), (2, "--output", "--output a.xyz: "))

    def test_errors_of_a_format_name_the_output_that_sets_it(self):
        request, output = self.folder / "request.json", self.folder / "x.json"
        request.write_text('{"sites":17,"format":"csv"}')
        result = run("sample", request, "-o", output)
        self.assert_fails(result, 2, f"ccdt: --output {output} sets --format=json: the input has the format csv")
        self.assert_fails(run("sample", request, "--format=json"), 2, "ccdt: --format: options must be members")

    def test_warnings_are_printed_unless_quiet(self):
        arguments = ("sample", POLYGONS / "Italy-110m.geojson", "--sites=9", "--format=csv")
        self.assertIn(b"points are even in degrees", run(*arguments).stderr)
        self.assertEqual(run(*arguments, "-q").stderr, b"")


class Terminal(Folder):
    """A program with a pseudo terminal for its standard streams."""

    def read(self, master, until):
        """Reads until a text appears, or to the end if `until` is None."""
        text = b""
        end = time.monotonic() + PATIENCE
        while until is None or until not in text:
            self.assertTrue(select.select([master], [], [], max(0, end - time.monotonic()))[0],
                            f"waited {PATIENCE} s for {until}; read {text}")
            try:
                piece = os.read(master, 4096)
            except OSError:  # all other ends are closed
                piece = b""
            if not piece:
                self.assertIsNone(until, text)
                break
            text += piece
        return text

    def open(self, command, **environment):
        master, slave = pty.openpty()
        self.addCleanup(os.close, master)
        process = subprocess.Popen(command, stdin=slave, stdout=slave, stderr=slave, cwd=self.folder,
                                   start_new_session=True, env={**os.environ, **environment})
        os.close(slave)
        self.addCleanup(process.wait, PATIENCE)
        self.addCleanup(process.kill)
        return master, process

    def test_shows_progress_and_the_result(self):
        arguments = ("sample", "--domain", TORUS, "--sites=60000", "-o", "a.csv")
        master, process = self.open([PROGRAM, *arguments])
        text = self.read(master, None)
        self.assertEqual(process.wait(PATIENCE), 0)
        self.assertRegex(text, rb"\[#+-+\] +\d+ %")
        self.assertRegex(text, rb"\r\x1b\[Ka.csv: 60000 sites, \d+ bytes, [\d.]+ s\r\n$")
        master, process = self.open([PROGRAM, *arguments, "-q"])
        self.assertEqual(self.read(master, None), b"")
        self.assert_done(run(*arguments[:-1], self.folder / "a.csv"))  # prints nothing to a pipe

    def test_receives_text_but_no_pictures(self):
        master, process = self.open([PROGRAM, "halftone", str(PICTURE)])
        self.assertIn(b"standard output is a terminal, and PNG is not text; --output FILE", self.read(master, None))
        self.assertEqual(process.wait(PATIENCE), 2)
        master, process = self.open([PROGRAM, "sample", "--domain", TORUS, "--sites=2"])
        self.assertIn(b'{"points":[[', self.read(master, None))
        self.assertEqual(process.wait(PATIENCE), 0)

    def test_bash_completes(self):
        (self.folder / "weights.png").write_bytes(b"")
        (self.folder / "knot.obj").write_bytes(b"")
        master, _ = self.open(["bash", "--norc", "--noprofile", "-i"], TERM="dumb", PS1="> ",
                              PATH=f"{PROGRAM.parent}:{os.environ['PATH']}")
        os.write(master, b"source <(ccdt completion bash); echo loa''ded\n")
        self.read(master, b"loaded")
        for typed, completed in (("ccdt ha\t", b"ccdt halftone "), ("--co\t", b"--color "), ("cm\t", b"cmyk "),
                                 ("--device=sp\t", b"spectra6 "), ("--outp\t", b"--output "), ("we\t", b"weights.png "),
                                 ("\x15ccdt sample --density @w\t", b"@weights.png "),
                                 ("\x15ccdt analyze --mesh kn\t", b"knot.obj "),
                                 ("\x15ccdt help an\t", b"analyze "), ("\x15ccdt completion f\t", b"fish ")):
            with self.subTest(typed):
                os.write(master, typed.encode())
                self.read(master, completed)


class Documents(Folder):
    COMMANDS = ("halftone", "sample", "analyze")

    def manuals(self):
        yield "ccdt.1", run("manual").stdout
        for command in self.COMMANDS:
            yield f"ccdt-{command}.1", run("manual", command).stdout
        yield "ccdt-server.8", execute([os.environ["CCDT_SERVER"], "--manual"], capture_output=True).stdout

    def test_manual_pages_have_no_faults(self):
        for name, page in self.manuals():
            with self.subTest(name):
                file = self.folder / name
                file.write_bytes(page)
                groff = execute(["groff", "-man", "-ww", "-Tutf8", "-P-cbu", file], capture_output=True)
                self.assertEqual((groff.returncode, groff.stderr), (0, b""))
                self.assertIn(b"EXIT STATUS", groff.stdout)
                # Without a date, builds are reproducible.
                lint = execute(["mandoc", "-T", "lint", "-W", "warning", file], capture_output=True, text=True)
                faults = [line for line in lint.stdout.splitlines() if 'missing date, using ""' not in line]
                self.assertEqual(faults, [])

    def test_completions_parse(self):
        for shell in ("bash", "zsh", "fish"):
            script = self.folder / shell
            script.write_bytes(self.assert_done(run("completion", shell)))
            self.assert_done(execute([shell, "-n", script], capture_output=True))
        zsh = "autoload -U compinit; compinit -D -u; source zsh; print -r -- $_comps[ccdt]"
        result = execute(["zsh", "-fc", zsh], capture_output=True, cwd=self.folder)
        self.assertEqual(self.assert_done(result), b"_ccdt\n")
        fish = "source fish; complete -C 'ccdt halftone --color '"
        result = execute(["fish", "-Nc", fish], capture_output=True, cwd=self.folder,
                         env={**os.environ, "HOME": str(self.folder)})
        self.assertEqual([line.split()[0] for line in result.stdout.splitlines()[:3]], [b"cmyk", b"gray", b"rgb"])

    def test_help_names_all_options(self):
        for command in self.COMMANDS:
            text = self.assert_done(run(command, "--help"))
            self.assertEqual(text, self.assert_done(run("help", command)))
            self.assertNotRegex(text, rb"(?m)^ +\.", "an option without a description")
            self.assertLessEqual({b"--format", b"--output", b"--max-sites"}, set(re.findall(rb"--[a-z-]+", text)))
        version = execute([os.environ["CCDT_SERVER"], "--version"], capture_output=True).stdout.split()[1]
        self.assertEqual(self.assert_done(run("--version")), b"ccdt " + version + b"\n")
        text = self.assert_done(run("--help"))
        for arguments in (("help", "serve"), ("completion", "--help"), ("manual", "-h"), ("help", "--help")):
            self.assertEqual(self.assert_done(run(*arguments)), text, arguments)
        self.assertEqual(run("manual", "completion").stdout, run("manual").stdout)
        for arguments in (("completion", "csh"), ("help", "draw"), ("manual", "halftone", "sample")):
            self.assertEqual(run(*arguments).returncode, 2, arguments)


class Examples(Folder):
    def test_in_the_readmes_work(self):
        Image.open(PICTURE).convert("L").save(self.folder / "photo.jpg")
        Image.open(PICTURE).resize((32, 32)).save(self.folder / "weights.png")
        shutil.copy(POLYGONS / "Switzerland-10m.geojson", self.folder / "map.geojson")
        (self.folder / "shape.json").write_text("[[0,0],[4,0],[2,3]]")
        (self.folder / "bunny.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
        numpy.save(self.folder / "voxels.npy", numpy.ones((2, 3, 4)))
        (self.folder / "occurrences.csv").write_text(
            "species,decimalLongitude,decimalLatitude\n" + "".join(f"a,{i % 30},{i // 30}\n" for i in range(600)))
        (self.folder / "out").mkdir()
        lines = [line for page in ("README.md", "server/cli/README.md")
                 for block in re.findall(r"^```sh\n(.*?)^```", (ROOT / page).read_text(), re.MULTILINE | re.DOTALL)
                 for line in block.splitlines() if line.startswith("ccdt ") and not line.startswith("ccdt serve")]
        self.assertGreater(len(lines), 5)
        for line in lines:
            with self.subTest(line):
                result = execute(["bash", "-c", f"{line} --quiet"], cwd=self.folder, capture_output=True,
                                 env={**os.environ, "PATH": f"{PROGRAM.parent}:{os.environ['PATH']}"})
                self.assertEqual(self.assert_done(result), b"")
        self.assertLessEqual({"dots.csv", "dots.png", "dots.svg", "points.csv", "spectrum.svg"}, set(self.names()))


class Installation(Folder):
    def test_programs_find_each_other(self):
        for name in ("bin", "lib/ccdt"):
            (self.folder / "usr" / name).mkdir(parents=True)
        program = shutil.copy(PROGRAM, self.folder / "usr/bin")
        link = self.folder / "ccdt"
        link.symlink_to(program)
        arguments = ("halftone", PICTURE, "-o", self.folder / "a.png", "--sites=300")
        self.assert_fails(run(*arguments, program=link), 1, f"{self.folder}/usr/lib/ccdt/ccdt-decoder",
                          "in the package ccdt\n")
        result = run("serve", "--version", program=link, env={"PATH": "/nonexistent"})
        self.assert_fails(result, 1, "cannot start ccdt-server", "in the package ccdt-server\n")
        shutil.copy(PROGRAM.with_name("ccdt-decoder"), self.folder / "usr/lib/ccdt")
        self.assert_done(run(*arguments, program=link))
        self.assertTrue((self.folder / "a.png").exists())

    def test_serve_starts_the_server(self):
        self.assertRegex(self.assert_done(run("serve", "--version")), rb"^ccdt-server \d")
        self.assert_fails(run("serve", "--port=x"), 2, "--port")


if __name__ == "__main__":
    unittest.main()
