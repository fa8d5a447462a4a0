# SPDX-License-Identifier: GPL-3.0-or-later
"""The tone of halftones of photographs as seen from a distance, level by level."""

import itertools
import pathlib
import re
import tempfile
import unittest

import numpy

from harness import PICTURES, ServerCase, execute, pixels
from seen import CHANNELS, LIGHT, blurred, enlarged, lightness, luminance, tone_errors

PHOTOGRAPHS = ("astronaut.png", "camera.png", "chelsea.png")


class Levels(ServerCase):
    def check(self, wanted, answer, dots, worst=1.5, dark=1):
        seen = tone_errors(wanted, luminance(answer), dots)
        self.assertLess(abs(seen[0]), dark)
        self.assertLess(seen[1], worst)

    def dots_of(self, data, query):
        return self.halftone(data, f"?format=json&quality=draft&{query}").json()["sites"]

    def test_photographs(self):
        queries = ("", "dots=ink", "scale=0.5", "detail=1", "scale=0.5&antialias=true", "quality=draft", "quality=best",
                   "detail=0", "background=transparent", "dots=ink&antialias=true", "dots=ink&detail=1")
        for name in PHOTOGRAPHS:
            data = (PICTURES / name).read_bytes()
            for query in queries if name == "camera.png" else queries[:3]:
                with self.subTest(name=name, query=query):
                    small = "scale=0.5" in query  # where levels are of few pixels
                    self.check(luminance(data), self.halftone(data, "?sites=13000&" + query).body, 13_000,
                               worst=2.5 if small else 2, dark=2 if small else 1)

    def test_photographs_in_few_dots_and_in_many(self):
        data = (PICTURES / "camera.png").read_bytes()
        for sites, dots in itertools.product((4000, 100_000), ("both", "ink")):
            with self.subTest(sites=sites, dots=dots):
                query = f"?sites={sites}&scale=2&dots={dots}"
                self.check(luminance(data), self.halftone(data, query).body, sites)

    def test_light_on_black(self):
        data = (PICTURES / "astronaut.png").read_bytes()
        dots = self.dots_of(data, "invert=true")
        self.check(luminance(data), self.halftone(data, "?invert=true").body, dots)

    def test_lightness_as_luminance(self):
        data = (PICTURES / "camera.png").read_bytes()
        for query in ("tone=perceptual&dots=both", "tone=perceptual&dots=ink"):
            dots = self.dots_of(data, query)
            self.check(lightness(luminance(data)) / 100, self.halftone(data, "?" + query).body, dots)

    def test_levels_as_in_an_image_editor(self):
        data = (PICTURES / "camera.png").read_bytes()
        share = numpy.clip((pixels(data) / 255 - 0.1) / 0.8, 0, 1) ** (1 / 1.5)
        query = "levels=0.1,0.9,1.5&dots=both"
        self.check(LIGHT[numpy.round(share * 255).astype(int)], self.halftone(data, "?" + query).body,
                   self.dots_of(data, query))

    def test_levels_of_each_colour(self):
        data = (PICTURES / "astronaut.png").read_bytes()
        share = numpy.clip((pixels(data) / 255 - 0.1) / 0.8, 0, 1) ** (1 / 0.7)
        seen = pixels(self.halftone(data, "?levels=0.1,0.9,0.7&color=rgb&sites=20000").body, "RGB")
        for channel in range(3):
            wanted = LIGHT[numpy.round(share[..., channel] * 255).astype(int)].mean()
            self.assertAlmostEqual(LIGHT[seen[..., channel]].mean(), wanted, delta=0.01)

    def test_coloured_paper(self):
        data = (PICTURES / "camera.png").read_bytes()
        ink, paper = (numpy.array([LIGHT[int(part * 2, 16)] for part in colour]) @ CHANNELS
                      for colour in ("024", "fda"))
        wanted = ink + luminance(data) * (paper - ink)
        seen = self.halftone(data, "?foreground=%23024&background=%23fda").body
        self.check(wanted, seen, self.dots_of(data, "dots=both"))

    def drawn(self, data, query):
        """Returns the light of a drawing whose dots are so large that the antialiasing of the renderer does not matter."""
        with tempfile.TemporaryDirectory() as folder:
            source, target = pathlib.Path(folder, "dots.svg"), pathlib.Path(folder, "dots.png")
            source.write_bytes(self.halftone(data, "?format=svg&sites=6000&" + query).body)
            execute(["rsvg-convert", "--width", "4096", "--background-color", "white", "--output", str(target),
                     str(source)], check=True)
            return (pixels(target.read_bytes(), "L") > 127).reshape(2048, 2, 2048, 2).mean((1, 3))

    def test_drawings(self):
        data = (PICTURES / "camera.png").read_bytes()
        dark, worst = tone_errors(luminance(data), self.drawn(data, "dots=ink"), 6000)
        self.assertLess(worst, 1.5)
        self.assertLess(abs(dark), 1)

    def test_lines_through_all_sites(self):
        data = (PICTURES / "astronaut.png").read_bytes()
        for query in ("style=path", "style=path&quality=draft"):
            wanted, seen = (lightness(blurred(light, 2 * (2048 ** 2 / 6000) ** 0.5))
                            for light in (enlarged(luminance(data), (2048, 2048)), self.drawn(data, query)))
            self.assertLess(abs(seen - wanted).mean(), 2)

    def test_lines_of_a_given_pen(self):
        """The number of sites follows from the pen, or the tone from both."""
        data = (PICTURES / "camera.png").read_bytes()
        sites = [int(re.search(rb"<desc>([0-9]+) dots",
                               self.halftone(data, f"?format=svg&style=path&width_mm=200&pen={pen}").body)[1])
                 for pen in (1, 2)]
        self.assertAlmostEqual(sites[0] / sites[1], 4, delta=0.1)
        thin, exact = (self.halftone(data, f"?format=svg&style=path&width_mm=200&pen=1&sites={count}").headers
                       for count in (sites[0] // 2, sites[0]))
        self.assertLess(float(thin["x-tone"]), 0.8)
        self.assertIn(f"cover only {100 * float(thin['x-tone']):.0f} % of what they should", thin["x-warnings"])
        self.assertAlmostEqual(float(exact["x-tone"]), 1, delta=0.01)
        self.assertNotIn("x-warnings", exact)

    def test_few_fine_dots_show_local_contrast(self):
        """The density of dots, relative to its mean, rises faster with local darkness than by the tone, which is 1."""
        for name, drawing in itertools.product(PHOTOGRAPHS, ("style=stroke&dot=0.15mm&sites=3000",
                                                             "style=fill&dot=0.2mm&sites=12000")):
            with self.subTest(name=name, drawing=drawing):
                data = (PICTURES / name).read_bytes()
                answer = self.halftone(data, f"?format=json&width_mm=200&{drawing}")
                dots = answer.json()
                self.assertLess(float(answer.headers["x-tone"]), 0.5)
                self.assertIn("local contrast", dots["warnings"][0]["detail"])
                wanted = luminance(data)
                columns, rows = (numpy.array(dots["points"]).reshape(-1, 2).astype(int)).T
                ink = numpy.zeros(wanted.shape)
                numpy.add.at(ink, (rows, columns), 1)
                pitch = (wanted.size / dots["sites"]) ** 0.5
                drawn, dark = (near - blurred(near, 8 * pitch) for near in
                               (blurred(ink / ink.mean(), 2 * pitch),
                                1 - lightness(blurred(wanted, 2 * pitch)) / 100))
                self.assertGreater((drawn * dark).sum() / (dark ** 2).sum(), 2)
                self.assertGreater(numpy.corrcoef(drawn.ravel(), dark.ravel())[0, 1], 0.5)

    def test_tone_density_ignores_overlaps(self):
        data = (PICTURES / "camera.png").read_bytes()
        dots = self.dots_of(data, "")
        dark, worst = tone_errors(luminance(data), luminance(self.halftone(data, "?tone=density").body), dots)
        self.assertGreater(dark, 15)
        self.assertGreater(worst, 15)


if __name__ == "__main__":
    unittest.main(verbosity=2)
