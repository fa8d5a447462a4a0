# SPDX-License-Identifier: GPL-3.0-or-later
"""The tone of halftones as seen from a distance, level by level."""

import itertools
import pathlib
import tempfile
import unittest

import numpy
from PIL import Image, ImageDraw, ImageFilter

from harness import PICTURES, ServerCase, execute, file_of, flat, pixels
from seen import LIGHT, blurred, lightness

CHANNELS = numpy.array([0.2126, 0.7152, 0.0722])
PHOTOGRAPHS = ("astronaut.png", "camera.png", "chelsea.png")


def luminance(file):
    """Returns the luminance of each pixel; transparent ones show white."""
    rgba = pixels(file, "RGBA")
    alpha = rgba[..., 3] / 255
    return LIGHT[rgba[..., :3]] @ CHANNELS * alpha + 1 - alpha


def enlarged(plane, shape):
    """Enlarges or reduces a plane of light to another shape."""
    return numpy.asarray(Image.fromarray(plane.astype(numpy.float32)).resize(shape[::-1], Image.Resampling.BOX))


def luminance_enlarged(file):
    """Returns the luminance of each pixel of a picture enlarged twofold in encoded values, as browsers do."""
    image = Image.fromarray(pixels(file, "RGB"))
    image = image.resize((2 * image.width, 2 * image.height), Image.Resampling.BILINEAR)
    return LIGHT[numpy.asarray(image)] @ CHANNELS


def errors(wanted, seen, dots):
    """Returns the mean error of L* after a blur by two pitches, where the picture is dark, and the largest error of a
    level.
    """
    sigma = 2 * (seen.size / dots) ** 0.5
    wanted = enlarged(wanted, seen.shape)
    level = lightness(blurred(wanted, sigma))
    error = lightness(blurred(seen, sigma)) - level
    dark = level < 20
    parts = [(level >= low) & (level < low + 5) for low in range(0, 100, 5)]
    worst = max(abs(error[part].mean()) for part in parts if part.mean() >= 0.005)
    return error[dark].mean() if dark.mean() > 0.005 else 0, worst


class Levels(ServerCase):
    def check(self, wanted, answer, dots, worst=1.5, dark=1):
        seen = errors(wanted, luminance(answer), dots)
        self.assertLess(abs(seen[0]), dark)
        self.assertLess(seen[1], worst)

    def dots_of(self, data, query):
        return self.halftone(data, f"?format=json&quality=draft&{query}").json()["sites"]

    def test_photographs(self):
        queries = ("", "dots=ink", "detail=1", "scale=0.5", "antialias=true", "scale=1", "scale=0.5&antialias=true",
                   "quality=draft", "quality=best", "detail=0", "format=tiff", "format=webp&antialias=true",
                   "background=transparent", "dots=ink&antialias=true", "dots=ink&scale=0.5", "dots=ink&detail=1")
        for name in PHOTOGRAPHS:
            data = (PICTURES / name).read_bytes()
            for query in queries if name == "camera.png" else queries[:4]:
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

    def test_drawings(self):
        """The dots are so large that the antialiasing of the renderer does not matter."""
        data = (PICTURES / "camera.png").read_bytes()
        with tempfile.TemporaryDirectory() as folder:
            source, target = pathlib.Path(folder, "dots.svg"), pathlib.Path(folder, "dots.png")
            source.write_bytes(self.halftone(data, "?format=svg&sites=6000&dots=ink").body)
            execute(["rsvg-convert", "--width", "4096", "--output", str(target), str(source)], check=True)
            seen = (pixels(target.read_bytes(), "L") > 127).reshape(2048, 2, 2048, 2).mean((1, 3))
        dark, worst = errors(luminance(data), seen, 6000)
        self.assertLess(worst, 1.5)
        self.assertLess(abs(dark), 1)

    def test_tone_density_ignores_overlaps(self):
        data = (PICTURES / "camera.png").read_bytes()
        dots = self.dots_of(data, "")
        dark, worst = errors(luminance(data), luminance(self.halftone(data, "?tone=density").body), dots)
        self.assertGreater(dark, 15)
        self.assertGreater(worst, 15)


class Wedge(ServerCase):
    def test_flat_greys(self):
        for share in (0.005, 0.02, 0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.995):
            level = int(numpy.argmin(abs(1 - LIGHT - share)))
            for query in ("antialias=true", "scale=1", "scale=0.5", "scale=0.1", "scale=0.1&antialias=true",
                          "dots=ink&antialias=true", "dots=ink&scale=1", "dots=ink&scale=0.1&antialias=true"):
                with self.subTest(share=share, query=query):
                    seen = luminance(self.halftone(file_of(flat(level, 300, 300)), "?" + query).body)
                    self.assertAlmostEqual(seen.mean(), LIGHT[level], delta=0.005)

    def test_flat_greys_at_their_own_size_and_enlarged(self):
        for share in (0.005, 0.02, 0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.995):
            level = int(numpy.argmin(abs(1 - LIGHT - share)))
            for query, most in (("", 0.75), ("?dots=ink", 1.5)):
                with self.subTest(share=share, query=query):
                    drawing = self.halftone(file_of(flat(level, 300, 300)), query).body
                    own, twice = luminance(drawing).mean(), luminance_enlarged(drawing).mean()
                    self.assertAlmostEqual((own + twice) / 2, LIGHT[level], delta=0.005)
                    for light in (own, twice):
                        self.assertAlmostEqual(lightness(light), lightness(LIGHT[level]), delta=most)


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
        dots = self.halftone(data, f"?format=json&{query}").json()["sites"]
        seen = luminance(self.halftone(data, "?" + query).body)
        wanted = enlarged(luminance(data), seen.shape)
        pitch = (seen.size / dots) ** 0.5
        of_picture, of_dots = (blurred(plane, 0.5 * pitch) - blurred(plane, pitch) for plane in (wanted, seen))
        return (of_picture * of_dots).sum() / (of_picture ** 2).sum()

    def test_preserves_the_contrast_of_edges_with_dots_on_both_sides(self):
        for name, data in (("camera", (PICTURES / "camera.png").read_bytes()), ("text", file_of(soft_lettering()))):
            with self.subTest(name=name):
                without, usual, much = (self.contrast(data, f"sites=12000&detail={detail}") for detail in (0, 0.7, 1))
                self.assertGreater(usual, without)
                self.assertGreater(much, usual)
                self.assertLess(abs(usual - 1), abs(without - 1))
                self.assertLess(abs(usual - 1), 0.03)

    def test_preserves_the_contrast_of_edges(self):
        for name, data in (("camera", (PICTURES / "camera.png").read_bytes()),
                           ("chelsea", (PICTURES / "chelsea.png").read_bytes()), ("text", file_of(soft_lettering()))):
            with self.subTest(name=name):
                without, usual, much = (self.contrast(data, f"sites=12000&dots=ink&detail={detail}")
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
        dark, worst = errors(luminance(data), luminance(answer.body), dots["sites"])
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
        dark, worst = errors(1 - tone * wanted, 1 - seen, 9000)
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
