# SPDX-License-Identifier: GPL-3.0-or-later
"""Drawings for the screen: their size, their tone, and the metadata of their files."""

import io
import itertools
import pathlib
import tempfile
import unittest

import numpy
from PIL import Image

from harness import PICTURES, ServerCase, data_uri, execute, file_of, flat, linear, pixels, post_json
from seen import LIGHT, blurred, lightness

CHELSEA = (PICTURES / "chelsea.png").read_bytes()
CHANNELS = numpy.array([0.2126, 0.7152, 0.0722])


def luminance(file):
    return LIGHT[pixels(file, "RGB")] @ CHANNELS


def resized(plane, shape):
    return numpy.asarray(Image.fromarray(plane.astype(numpy.float32)).resize(shape[::-1], Image.Resampling.BOX))


def chunks(png):
    """Returns names and contents of the chunks of a PNG."""
    found, at = {}, 8
    while at < len(png):
        size = int.from_bytes(png[at:at + 4], "big")
        found[png[at + 4:at + 8].decode()] = png[at + 8:at + 8 + size]
        at += size + 12
    return found


class Size(ServerCase):
    def size(self, query, data=CHELSEA):
        return self.halftone(data, f"?quality=draft&sites=300&{query}").picture().shape[1::-1]

    def test_is_as_requested(self):
        for query, size in (("width=137", (137, 91)), ("height=137", (206, 137)), ("width=137&height=50", (75, 50)),
                            ("width=137&height=50&fit=contain", (75, 50)), ("width=137&height=50&fit=cover", (137, 50)),
                            ("width=1", (1, 1)), ("width=2000", (2000, 1330)), ("width=137&width_mm=20", (137, 91)),
                            ("width=300&height=300&fit=cover&color=cmyk", (300, 300)),
                            ("width=640&format=webp", (640, 426)), ("width=640&format=tiff", (640, 426))):
            with self.subTest(query=query):
                self.assertEqual(self.size(query), size)
        answer = post_json(self.server, "/halftone", {"image": data_uri(CHELSEA), "width": 137, "format": "png"})
        self.assertEqual(answer.picture().shape, (91, 137))

    def test_fits_a_screen_by_default(self):
        for (width, height), size in (((1200, 900), (1067, 800)), ((60, 40), (1200, 800)), ((3, 9), (333, 1000)),
                                      ((1, 1), (1000, 1000)), ((2500, 100), (1280, 51))):
            with self.subTest(width=width, height=height):
                self.assertEqual(self.size("", file_of(flat(90, width, height))), size)

    def test_that_is_invalid_is_refused(self):
        for query, field, words in (("width=0", "width", "1 to 65535"), ("height=1.5", "height", "1 to 65535"),
                                    ("width=9&scale=1", "width", "replaces scale"),
                                    ("height=9&scale=1", "height", "replaces scale"),
                                    ("fit=cover", "fit", "width and height"), ("width=9&fit=cover", "fit", "both"),
                                    ("width=9&height=9&fit=fill", "fit", "contain"),
                                    ("width=9&format=json", "width", "drawings")):
            with self.subTest(query=query):
                problem = self.assert_problem(self.ask("/halftone?" + query, data=CHELSEA), 400, words)
                self.assertEqual(problem["errors"][0]["pointer"], field)
        self.assert_problem(self.ask("/halftone?width=60000", data=CHELSEA), 413, "60000 x 39911", "max-pixels")

    def test_of_a_part_equals_that_of_the_cropped_picture(self):
        image = Image.open(io.BytesIO(CHELSEA))
        for gravity, left in (("", 75), ("&gravity=0.5,0.5", 75), ("&gravity=0,0.3", 0), ("&gravity=1,0", 151), ("&gravity=0.4,1", 30)):
            cropped = io.BytesIO()
            image.crop((left, 0, left + 300, 300)).save(cropped, "png")
            for kind in ("sites=200&antialias=false", "device=1bit"):
                query = f"?{kind}&width=300&height=300"
                with self.subTest(gravity=gravity, kind=kind):
                    self.assertEqual(self.halftone(CHELSEA, query + "&fit=cover" + gravity).body, self.halftone(cropped.getvalue(), query).body)

    def test_is_that_of_the_svg_document(self):
        drawing = self.halftone(CHELSEA, "?format=svg&sites=100&width=300&height=300&fit=cover").body.decode()
        self.assertIn('width="300" height="300" viewBox="0 0 300 300"', drawing)


class Tone(ServerCase):
    def test_equals_that_of_the_picture_at_each_size(self):
        for name, width in itertools.product(("astronaut.png", "camera.png", "chelsea.png"), (100, 200, 640, 1280, None)):
            with self.subTest(name=name, width=width):
                data = (PICTURES / name).read_bytes()
                seen = luminance(self.halftone(data, f"?width={width}" if width else "?antialias=true").body)
                wanted = resized(luminance(data), seen.shape)
                self.assertLess(abs(seen.mean() - wanted.mean()), 0.004)
                sigma = 0.6 * seen.size ** 0.25 + 3
                error = lightness(blurred(seen, sigma)) - lightness(blurred(wanted, sigma))
                self.assertLess(abs(error.mean()), 0.5)
                self.assertLess(abs(error).mean(), 1.5)

    def test_of_flat_greys_is_exact_at_each_size(self):
        for level, width in itertools.product((30, 100, 180, 240), (50, 200, 1000)):
            with self.subTest(level=level, width=width):
                seen = LIGHT[pixels(self.halftone(file_of(flat(level)), f"?width={width}").body, "L")]
                self.assertAlmostEqual(seen.mean(), linear(level), delta=0.005)


class File(ServerCase):
    def test_declares_srgb(self):
        for query in ("", "width=200", "scale=1", "color=cmyk", "background=transparent", "width_mm=80"):
            with self.subTest(query=query):
                body = self.halftone(CHELSEA, "?sites=300&quality=draft&" + query).body
                found = chunks(body)
                self.assertEqual(found["sRGB"], b"\1")
                self.assertEqual(int.from_bytes(found["gAMA"], "big"), 45455)
                self.assertEqual("pHYs" in found, "width_mm" in query)
                with tempfile.NamedTemporaryFile(suffix=".png") as file:
                    pathlib.Path(file.name).write_bytes(body)
                    execute(["pngcheck", "-q", file.name], check=True)

    def test_for_print_has_a_resolution(self):
        for query, width in (("width_mm=100", None), ("width_mm=100&width=1000", 1000), ("width_mm=100&scale=2", 902)):
            with self.subTest(query=query):
                answer = self.halftone(CHELSEA, "?sites=300&quality=draft&" + query)
                shape = answer.picture().shape
                self.assertEqual(answer.picture().dtype, bool)
                self.assertIn(width, (None, shape[1]))
                density = round(shape[1] / 0.1)
                self.assertEqual(chunks(answer.body)["pHYs"], 2 * density.to_bytes(4, "big") + b"\1")


if __name__ == "__main__":
    unittest.main(verbosity=2)
