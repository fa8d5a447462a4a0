# SPDX-License-Identifier: GPL-3.0-or-later
"""Edges in halftones, the number of dots that follows from the detail of a picture, and dots of given sizes."""

import unittest

import numpy
from PIL import Image, ImageDraw, ImageFilter

from harness import PICTURES, ServerCase, file_of
from seen import blurred, enlarged, luminance, tone_errors


def lettering(width=480, height=320):
    """Returns text with thin strokes, black on white."""
    picture = Image.new("L", (width, height), 255)
    draw = ImageDraw.Draw(picture)
    for row in range(6, height - 12, 14):
        draw.text((6 + row % 5, row), "The quick brown fox jumps over the lazy dog. " * 2, fill=0)
    return numpy.where(numpy.asarray(picture) < 128, 0, 255)


def soft_lettering():
    """Returns the same text as a camera sees it, on grey paper."""
    soft = Image.fromarray(lettering().astype(numpy.uint8)).filter(ImageFilter.GaussianBlur(0.7))
    return 50 + numpy.asarray(soft) // 2


class Detail(ServerCase):
    def contrast(self, data, query):
        """Returns the contrast of edges relative to the picture, for waves of about two to four pitches."""
        dots = 12_000
        seen = luminance(self.halftone(data, f"?sites={dots}&{query}").body)
        wanted = enlarged(luminance(data), seen.shape)
        pitch = (seen.size / dots) ** 0.5
        of_picture, of_dots = (blurred(plane, 0.5 * pitch) - blurred(plane, pitch) for plane in (wanted, seen))
        return (of_picture * of_dots).sum() / (of_picture ** 2).sum()

    def test_preserves_the_contrast_of_edges_with_dots_on_both_sides(self):
        for name, data in (("camera", (PICTURES / "camera.png").read_bytes()), ("text", file_of(soft_lettering()))):
            with self.subTest(name=name):
                without, usual, much = (self.contrast(data, f"detail={detail}") for detail in (0, 0.7, 1))
                self.assertGreater(usual, without)
                self.assertGreater(much, usual)
                self.assertLess(abs(usual - 1), 0.035)

    def test_preserves_the_contrast_of_edges(self):
        for name, data in (("camera", (PICTURES / "camera.png").read_bytes()),
                           ("chelsea", (PICTURES / "chelsea.png").read_bytes()), ("text", file_of(soft_lettering()))):
            with self.subTest(name=name):
                without, usual, much = (self.contrast(data, f"dots=ink&detail={detail}")
                                        for detail in (0, 0.7, 1))
                self.assertGreater(usual, without + 0.02)
                self.assertGreater(much, usual + 0.02)
                self.assertLess(abs(usual - 1), abs(without - 1))

    def test_puts_no_dots_on_white(self):
        picture = lettering()
        dots = self.halftone(file_of(picture), "?detail=1&format=json").json()["points"]
        x, y = numpy.array(dots).astype(int).T
        self.assertTrue((picture[y, x] == 0).all())

    def test_of_the_picture_determines_the_number_of_dots(self):
        sharp = lettering()
        soft = numpy.asarray(Image.fromarray(sharp.astype(numpy.uint8)).filter(ImageFilter.GaussianBlur(4)))
        of_sharp, of_soft = (self.halftone(file_of(picture), "?format=json").json()["sites"]
                             for picture in (sharp, soft))
        self.assertGreater(of_sharp, 3 * of_soft)
        seen = luminance(self.halftone(file_of(sharp), "?dots=ink").body)
        likeness = [numpy.corrcoef(blurred(enlarged(sharp / 255, view.shape), 1).ravel(), blurred(view, 1).ravel())[0, 1]
                    for view in (seen, luminance(self.halftone(file_of(sharp), f"?dots=ink&sites={of_soft}").body))]
        self.assertGreater(likeness[0], 0.9)
        self.assertLess(likeness[1], 0.8)

    def test_of_photographs_gives_a_dot_per_eight_pixels_of_ink(self):
        for name in ("astronaut.png", "camera.png"):
            data = (PICTURES / name).read_bytes()
            ink = (1 - luminance(data)).sum()
            self.assertEqual(self.dots_of(data), int(ink / 8))
            minority = numpy.minimum(luminance(data), 1 - luminance(data)).sum()
            self.assertEqual(self.dots_of(data, "&dots=both"), int(minority / 8))

    def dots_of(self, data, query=""):
        return self.halftone(data, "?format=json&quality=draft" + query).json()["sites"]

    def test_is_limited_to_a_number_of_dots(self):
        noise = numpy.random.default_rng(1).integers(0, 256, (500, 500))
        self.assertEqual(self.dots_of(file_of(noise)), 100_000)


class Pen(ServerCase):
    def test_number_of_dots_follows_from_the_pen(self):
        data = (PICTURES / "camera.png").read_bytes()
        answer = self.halftone(data, "?dot=5&scale=2&dots=ink")
        dots = self.dots(data, "dot=5&scale=2")
        self.assertEqual(float(answer.headers["x-radius"]), 2.5)
        self.assertAlmostEqual(float(answer.headers["x-tone"]), 1, delta=0.001)
        dark, worst = tone_errors(luminance(data), luminance(answer.body), dots["sites"])
        self.assertLess(worst, 1.5)
        self.assertLess(abs(dark), 1)

    def dots(self, data, query):
        return self.halftone(data, f"?format=json&{query}").json()

    def test_millimetres_are_those_of_the_picture(self):
        data = (PICTURES / "camera.png").read_bytes()
        dots = self.dots(data, "dot=0.5mm&width_mm=100&quality=draft")
        self.assertAlmostEqual(dots["radius"], 0.5 / 100 * 512, delta=1e-9)
        drawing = self.halftone(data, "?dot=0.5mm&width_mm=100&format=svg&style=stroke&quality=draft").body.decode()
        self.assertIn('stroke-width="1"', drawing)
        self.assertIn("; their radius is 0.5 mm</desc>", drawing)
        self.assertIn(f"<desc>{dots['sites']} dots along", drawing)
        self.assert_problem(self.ask("/halftone?dot=0.5mm", data=data), 400, "width_mm")

    def test_size_and_number_together_give_a_reported_factor_of_tone(self):
        data = (PICTURES / "chelsea.png").read_bytes()
        wanted = 1 - luminance(data)
        answer = self.halftone(data, "?dot=2&scale=2&sites=9000&dots=ink")
        seen = 1 - luminance(answer.body)
        tone = float(answer.headers["x-tone"])
        self.assertLess(tone, 0.5)
        self.assertAlmostEqual(seen.mean() / wanted.mean(), tone, delta=0.01 * tone)
        dark, worst = tone_errors(1 - tone * wanted, 1 - seen, 9000)
        self.assertLess(worst, 1.5)

    def test_reported_radius_is_that_of_the_drawn_dots(self):
        data = (PICTURES / "camera.png").read_bytes()
        dots = self.dots(data, "sites=3000&scale=4")
        drawn = self.halftone(data, "?sites=3000&scale=4&dots=ink")
        self.assertAlmostEqual(float(drawn.headers["x-radius"]), dots["radius"], delta=1e-9)
        y, x = numpy.mgrid[:512 * 4, :512 * 4] / 4 + 0.125
        for px, py in dots["points"][:20]:
            self.assertFalse(drawn.picture()[(x - px) ** 2 + (y - py) ** 2 < dots["radius"] ** 2].any())


if __name__ == "__main__":
    unittest.main(verbosity=2)
