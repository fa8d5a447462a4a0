# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests tests/bench/paper/run: the paper's figures and their page, with small numbers."""

import json
import os
import pathlib
import re
import sys
import tempfile
import unittest
import xml.etree.ElementTree

import numpy
from PIL import Image

from harness import PATIENCE, PICTURES, execute, file_of, linear

PAPER = pathlib.Path(__file__).resolve().parent.parent / "bench" / "paper"
sys.path.insert(0, str(PAPER))

import drawing
import tone

# Maximum size of a figure in the repository, in bytes.
MAX_BYTES = 150_000


def run(*arguments, **environment):
    return execute([PAPER / "run", *arguments], 2 * PATIENCE, capture_output=True, text=True, check=False,
                   env={**os.environ, **environment})


class Quick(unittest.TestCase):
    """A run of the script with small numbers, into a folder that is not empty, and its output."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.output = pathlib.Path(cls.folder.name)
        (cls.output / "figures").mkdir()
        for name in ("figures/figure-of-old.svg", "figures/own.txt"):
            (cls.output / name).write_text("")
        done = run("--quick", "--output", str(cls.output))
        if done.returncode != 0 or done.stdout or done.stderr:
            raise AssertionError(f"tests/bench/paper/run exited with {done.returncode}:\n{done.stdout}\n{done.stderr}")
        cls.page = (cls.output / "README.md").read_text()
        cls.results = json.loads((cls.output / "results.json").read_text())

    def figures(self, kind):
        found = sorted((self.output / "figures").glob("*." + kind))
        self.assertGreater(len(found), 3)
        return found

    def test_page_shows_every_figure(self):
        shown = {(self.output / link).resolve() for link in re.findall(r"!\[[^]]*\]\(([^)]*)\)", self.page)}
        self.assertEqual([path for path in shown if not path.is_file()], [])
        drawn = {path.resolve() for path in self.figures("svg") + self.figures("png")}
        self.assertEqual({path for path in shown if path.parent != PICTURES}, drawn)

    def test_page_is_complete(self):
        for number in (1, 3, 4, 5, 6):
            self.assertIn(f"## Figure {number}", self.page)
        self.assertTrue(self.page.isascii())
        self.assertIsNone(re.search(r"\$\{|\b(nan|inf|None)\b|unknown", self.page))
        for table in re.findall(r"(?:^\|.*\n)+", self.page, re.MULTILINE):
            self.assertEqual(len({line.count("|") for line in table.splitlines()}), 1, table)

    def test_old_figures_are_removed_and_other_files_kept(self):
        self.assertFalse((self.output / "figures" / "figure-of-old.svg").exists())
        self.assertTrue((self.output / "figures" / "own.txt").exists())

    def test_drawings_are_valid_and_small(self):
        for path in self.figures("svg"):
            root = xml.etree.ElementTree.parse(path).getroot()
            self.assertGreater(len(root), 10, path)
            self.assertLess(path.stat().st_size, MAX_BYTES, path)
        for path in self.figures("png"):
            with Image.open(path) as picture:
                levels = numpy.unique(picture.convert("L"))
            self.assertEqual((levels[0], levels[-1]), (0, 255), path)
            self.assertLess(path.stat().st_size, MAX_BYTES, path)

    def test_variance_falls_in_both_polygons(self):
        self.assertEqual(set(self.results["figure_1"]), {"convex", "concave"})
        for polygon in self.results["figure_1"].values():
            trace = polygon["trace"]
            self.assertEqual(len(trace), 7)
            self.assertLess(trace[-1], 0.3 * trace[0])
            self.assertLess(trace[0], polygon["random"])
            self.assertLess(polygon["polished"], 0.3)

    def test_sites_follow_the_ramp(self):
        found = self.results["figure_3"]
        numpy.testing.assert_allclose(found["exact"], numpy.array([1, 7, 19, 37]) / 64, atol=1e-12)
        error = {name: numpy.abs(numpy.array(shares) - found["exact"]).max()
                 for name, shares in found["shares"].items()}
        for shares in found["shares"].values():
            numpy.testing.assert_allclose(numpy.sum(shares, axis=1), 1)
        for name in ("CCVT", "CCDT", "CCDT, polished"):
            self.assertLess(error[name], 0.02)
            self.assertLess(error[name], error["random"])

    def test_spectra_are_blue(self):
        methods = self.results["figure_4"]["methods"]
        self.assertEqual(set(methods), {"CVT", "ODT", "CCVT", "CCDT", "CCDT, polished"})
        for name, of in methods.items():
            self.assertLess(of["low_frequency_power"], 0.1, name)
            self.assertGreater(of["peak"], 1.5, name)
            self.assertLess(of["min_distance"], of["mean_distance"], name)
            self.assertLess(of["mean_distance"], 1, name)
            self.assertLess(abs(of["anisotropy_mean"] + 10 * numpy.log10(2)), 3, name)
        self.assertEqual(max(methods, key=lambda name: methods[name]["oscillation"]), "CVT")
        self.assertEqual(min(methods, key=lambda name: methods[name]["low_frequency_power"]), "CCDT, polished")

    def test_times_or_reasons_for_refusal_are_given(self):
        for name, runs in self.results["timings"].items():
            self.assertEqual(list(runs), ["64", "128", "51200"])
            for size, taken in runs.items():
                refused = name in ("CVT", "CCVT") and size == "51200"
                self.assertEqual("refused" in taken, refused, f"{name} {size}: {taken}")
                if refused:
                    self.assertIn(taken["refused"], self.page)
                else:
                    self.assertGreater(taken["seconds"], 0)

    def test_halftones_approach_their_pictures(self):
        stages = self.results["figure_5"]["stages"]
        self.assertEqual([stage["iterations"] for stage in stages], list(range(6)))
        self.assertLess(stages[5]["tone_error"], 0.5 * stages[0]["tone_error"])
        for halftone in self.results["figure_6"]:
            errors = {name: of["tone_error"] for name, of in halftone["methods"].items()}
            self.assertLess(max(errors.values()), 0.02)
            self.assertLess(errors["CCDT, polished"], errors["CCDT"])
            self.assertGreater(halftone["methods"]["CCVT"]["iterations"], 10)


class Failure(unittest.TestCase):
    def test_is_reported_and_leaves_no_output(self):
        with tempfile.TemporaryDirectory() as name:
            output = pathlib.Path(name) / "paper"
            for arguments, environment in ((("--quick",), {"CCDT_SERVER": "/nonexistent"}), (("--fast",), {})):
                failed = run(*arguments, "--output", str(output), **environment)
                self.assertNotEqual(failed.returncode, 0)
                self.assertTrue(failed.stderr)
                self.assertFalse(output.exists())


class Tone(unittest.TestCase):
    def test_ink_is_one_minus_luminance(self):
        levels = numpy.array([[0, 55, 188, 255]])
        with tempfile.NamedTemporaryFile(suffix=".png") as file:
            file.write(file_of(levels))
            file.flush()
            numpy.testing.assert_allclose(tone.ink(file.name), [[1 - linear(level) for level in levels[0]]], atol=1e-12)

    def test_blur_attenuates_waves_like_a_gaussian(self):
        rows, columns = 24, 40
        wave = numpy.outer(numpy.cos(numpy.pi * 3 * (numpy.arange(rows) + 0.5) / rows),
                           numpy.cos(numpy.pi * 2 * (numpy.arange(columns) + 0.5) / columns))
        squared_frequency = (3 / (2 * rows)) ** 2 + (2 / (2 * columns)) ** 2
        left = numpy.exp(-2 * numpy.pi ** 2 * 2.5 ** 2 * squared_frequency)
        numpy.testing.assert_allclose(tone.blur(1 + wave, 2.5), 1 + left * wave, atol=1e-12)

    def test_error_is_zero_for_a_grid_and_large_for_a_cluster(self):
        flat = numpy.full((32, 48), 0.25)
        y, x = numpy.mgrid[1:32:2, 1:48:2]
        grid = numpy.stack([x.ravel(), y.ravel()], axis=1)
        self.assertLess(tone.error(grid, flat), 1e-6)
        self.assertGreater(tone.error(grid * (0.5, 1), flat), 0.2)

    def test_error_equals_the_density_wave_of_displaced_sites(self):
        # Moving all sites by a sin(kx) changes their relative density by a k cos(kx); sites are 1 apart.
        flat = numpy.full((64, 256), 1.0)
        y, x = (part.ravel() for part in numpy.mgrid[0.5:64, 0.5:256])
        k, off = 2 * numpy.pi / 16, 0.1
        moved = numpy.stack([x + off * numpy.sin(k * x), y], axis=1)
        expected = off * k / numpy.sqrt(2) * numpy.exp(-0.5 * (2 * k) ** 2)
        self.assertAlmostEqual(tone.error(moved, flat) / expected, 1, delta=0.03)

    def test_dots_are_as_dark_as_their_target(self):
        target = numpy.full((60, 90), 0.3)
        points = numpy.random.default_rng(1).random((200, 2)) * (90, 60)
        paper = tone.dots(points, 2, target)
        self.assertEqual(paper.shape, (120, 180))
        self.assertAlmostEqual(1 - paper.mean(), 0.3, delta=0.01)
        rows, columns = (numpy.floor(2 * points[:, axis]).astype(int) for axis in (1, 0))
        self.assertFalse(paper[rows, columns].any())


class Drawing(unittest.TestCase):
    def test_ticks_reach_around_the_range(self):
        self.assertEqual(drawing.decades(0.003, 500), [0.001, 0.01, 0.1, 1, 10, 100, 1000])
        numpy.testing.assert_allclose(drawing.steps(-2.2, 7), [-4, -2, 0, 2, 4, 6, 8])

    def test_axes_are_linear_or_logarithmic(self):
        self.assertEqual(drawing.Axis("", [0, 2, 4]).share(1), 0.25)
        self.assertAlmostEqual(drawing.Axis("", [1, 10, 100], log=True).share(10), 0.5)

    def test_points_fit_their_box_and_keep_their_aspect_ratio(self):
        fitted = drawing.Box(10, 20, 100, 50).fit([[0, 0], [4, 0], [4, 4], [0, 4]])
        numpy.testing.assert_allclose(fitted, [[35, 70], [85, 70], [85, 20], [35, 20]])


if __name__ == "__main__":
    unittest.main(verbosity=2)
