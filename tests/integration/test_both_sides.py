# SPDX-License-Identifier: GPL-3.0-or-later
"""Halftones drawn by one field: dots in the light, a net in the middle, holes in the dark."""

import csv
import io
import pathlib
import tempfile
import unittest
from xml.etree import ElementTree

import numpy
from PIL import Image, ImageDraw

from harness import PICTURES, ServerCase, colours, execute, file_of, flat, inside, linear, pixels
from seen import LIGHT, ciede2000, lab, seen_light

ASTRONAUT = (PICTURES / "astronaut.png").read_bytes()
CAMERA = (PICTURES / "camera.png").read_bytes()
SVG = "{http://www.w3.org/2000/svg}"


def light(file):
    """Returns the linear light of a drawing whose edges are antialiased in linear light."""
    return LIGHT[pixels(file, "L")]


def black_and_white():
    """Returns text and noise, in black and white."""
    picture = Image.new("L", (160, 120), 255)
    draw = ImageDraw.Draw(picture)
    draw.rectangle((80, 0, 160, 60), fill=0)
    for row in range(6, 60, 14):
        draw.text((6, row), "Quick brown", fill=0)
    levels = numpy.where(numpy.asarray(picture) < 128, 0, 255)
    levels[90:, :] = 255 * numpy.random.default_rng(3).integers(0, 2, (30, 160))
    return levels


def drawn_by_librsvg(svg, shape):
    """Draws an SVG as PNG with the rows and columns of `shape`."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = pathlib.Path(folder, "dots.svg"), pathlib.Path(folder, "dots.png")
        source.write_bytes(svg)
        execute(["rsvg-convert", "--width", str(shape[1]), "--height", str(shape[0]), "--output", str(target),
                 str(source)], check=True)
        return target.read_bytes()


def area(rings):
    """Returns the area that rings enclose by the even-odd rule, if inner rings turn the other way."""
    twice = sum((x * numpy.roll(y, -1) - numpy.roll(x, -1) * y).sum() for x, y in (numpy.array(ring).T for ring in rings))
    return abs(twice) / 2


class Tone(ServerCase):
    def test_flat_greys_preserve_luminance(self):
        for share in (0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.48, 0.52, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98):
            level = int(numpy.argmin(abs(LIGHT - share)))
            with self.subTest(share=share):
                drawn = self.halftone(file_of(flat(level, 128, 128)), "?sites=2000&scale=4&antialias=true")
                self.assertAlmostEqual(light(drawn.body).mean(), linear(level), delta=0.004)

    def test_outlines_enclose_the_ink(self):
        for level in (20, 60, 120, 180, 190, 200, 240):
            dots = self.halftone(file_of(flat(level, 128, 128)), "?sites=2000&format=json&dots=both").json()
            self.assertAlmostEqual(area(dots["rings"]) / 128 ** 2, 1 - linear(level), delta=0.004)

    def test_foreground_and_background_are_used(self):
        drawn = self.halftone(CAMERA, "?sites=2000&scale=4&foreground=%23024&background=%23fda").picture("RGB")
        self.assertEqual(colours(drawn), {(0, 0x22, 0x44), (255, 0xdd, 0xaa)})


class BlackAndWhite(ServerCase):
    def test_is_reproduced_without_dots(self):
        picture = black_and_white()
        for query in ("", "&sites=500", "&detail=0", "&format=webp"):
            with self.subTest(query=query):
                drawn = self.halftone(file_of(picture), "?scale=1" + query)
                numpy.testing.assert_array_equal(pixels(drawn.body, "L"), picture)
        dots = self.halftone(file_of(picture), "?dots=both&format=json").json()
        self.assertEqual((dots["sites"], dots["points"]), (0, []))
        self.assertAlmostEqual(area(dots["rings"]), (picture == 0).sum(), delta=0.02 * picture.size)

    def test_black_is_solid(self):
        black = file_of(flat(0, 30, 20))
        self.assertFalse(self.halftone(black, "?scale=3").picture().any())
        dots = self.halftone(black, "?dots=both&format=json").json()
        self.assertEqual(dots["sites"], 0)
        self.assertEqual(area(dots["rings"]), 30 * 20)


class Lists(ServerCase):
    def test_hold_the_requested_number_of_dots(self):
        for sites in (1, 7, 1000, 20_000):
            dots = self.halftone(CAMERA, f"?sites={sites}&dots=both&format=json").json()
            self.assertEqual(dots["sites"], sites)
            self.assertEqual(len(dots["points"]), sites)

    def test_hold_the_same_sites_in_all_formats(self):
        query = "?sites=900&dots=both&format="
        dots = self.halftone(ASTRONAUT, query + "json").json()
        array = numpy.load(io.BytesIO(self.halftone(ASTRONAUT, query + "npy").body), allow_pickle=False)
        numpy.testing.assert_array_equal(array, dots["points"])
        rows = list(csv.reader(io.StringIO(self.halftone(ASTRONAUT, query + "csv").body.decode(), newline="")))
        self.assertEqual(rows[0], ["x", "y"])
        numpy.testing.assert_array_equal(numpy.array(rows[1:], float), array)

    def test_agree_with_drawings(self):
        scale = 8
        dots = self.halftone(CAMERA, "?sites=2000&dots=both&format=json").json()
        drawn = self.halftone(CAMERA, f"?sites=2000&scale={scale}").picture()
        places = numpy.random.default_rng(1).integers(0, drawn.shape[0], (4000, 2))
        is_ink = inside((places + 0.5) / scale, [numpy.array(ring) for ring in dots["rings"]])
        # Contours are fitted to the areas of polygons, and pixels to theirs, so rims differ by a hundredth of a pitch.
        self.assertGreater((drawn[places[:, 1], places[:, 0]] == ~is_ink).mean(), 0.97)

    def test_have_ink_dots_by_default(self):
        for form in ("json", "csv", "npy"):
            usual, ink = (self.halftone(CAMERA, f"?sites=300&seed=4&format={form}{dots}").body
                          for dots in ("", "&dots=ink"))
            if form == "json":
                self.assertNotIn(b'"rings"', usual)
            else:
                self.assertEqual(usual, ink)


class Drawings(ServerCase):
    def test_svg_looks_like_png(self):
        for data, query in ((CAMERA, "?sites=3000&scale=4"), (ASTRONAUT, "?sites=6000&scale=4"),
                            (file_of(flat(0, 64, 64)), "?scale=4")):
            with self.subTest(query=query):
                ours = light(self.halftone(data, query + "&antialias=true").body)
                theirs = pixels(drawn_by_librsvg(self.halftone(data, query + "&format=svg").body, ours.shape), "L") / 255
                self.assertLess(abs(ours.mean() - theirs.mean()), 0.01)
                self.assertLess(numpy.abs(ours - theirs).mean(), 0.025)


class Colour(ServerCase):
    def test_cmyk_and_rgb_give_the_same_pixels(self):
        for query in ("&scale=2", "&scale=2&antialias=true"):  # edges for screens are rounded separately
            inks, lamps = (pixels(self.halftone(ASTRONAUT, f"?sites=2000&color={color}{query}").body, "RGB")
                           for color in ("cmyk", "rgb"))
            numpy.testing.assert_array_equal(inks, lamps)

    def test_flat_colours_preserve_each_channel(self):
        for colour in ((20, 40, 80), (120, 40, 20), (230, 200, 180)):
            drawn = self.halftone(file_of(numpy.full((128, 128, 3), colour)),
                                  "?sites=3000&scale=4&antialias=true&color=cmyk")
            seen = LIGHT[pixels(drawn.body, "RGB")].mean((0, 1))
            numpy.testing.assert_allclose(seen, [linear(value) for value in colour], atol=0.004)

    def test_greys_have_the_same_outlines_in_all_inks(self):
        answer = self.halftone(CAMERA, "?sites=1000&color=cmyk&dots=both&format=json").json()
        self.assertEqual(len(answer["points"]), 1000)
        first, *others = (ink["rings"] for ink in answer["inks"])
        self.assertTrue(all(rings == first for rings in others))

    def test_outlines_enclose_the_ink(self):
        for color, names in (("cmyk", ["cyan", "magenta", "yellow"]), ("rgb", ["red", "green", "blue"])):
            answer = self.halftone(ASTRONAUT, f"?sites=3000&color={color}&dots=both&format=json").json()
            self.assertEqual([ink["name"] for ink in answer["inks"]], names)
            light = LIGHT[pixels(ASTRONAUT, "RGB")].mean((0, 1))
            covered = [area(ink["rings"]) / (answer["width"] * answer["height"]) for ink in answer["inks"]]
            numpy.testing.assert_allclose(covered, light if color == "rgb" else 1 - light, atol=0.01)


class Palettes(ServerCase):
    """Custom palettes."""
    RISO = ["ff48b0", "0078bf", "ffe800", "000000", "00a95c", "ff6c2f"]

    def query(self, count):
        return "&palette=" + ",".join("%23" + ink for ink in self.RISO[:count])

    def difference(self, data, sites, scale, options):
        """Returns the mean CIEDE2000 difference after a blur of two pitches."""
        drawn, picture = (LIGHT[pixels(file, "RGB")] for file in
                          (self.halftone(data, f"?sites={sites}&scale={scale}&antialias=true{options}").body, data))
        sigma = 2 * (picture.shape[0] * picture.shape[1] / sites) ** 0.5
        height, width = picture.shape[:2]
        means = drawn.reshape(height, scale, width, scale, 3).mean((1, 3))
        return ciede2000(lab(seen_light(picture, sigma)), lab(seen_light(means, sigma))).mean()

    def test_tints_have_their_colour(self):
        for count, colour in ((3, (20, 40, 80)), (3, (180, 170, 150)), (4, (60, 60, 60)), (4, (180, 170, 150)),
                              (6, (120, 40, 20)), (6, (40, 70, 30))):
            with self.subTest(inks=count, colour=colour):
                picture = file_of(numpy.full((96, 96, 3), colour))
                self.assertLess(self.difference(picture, 2000, 6, "&dots=both" + self.query(count)), 0.6)

    def test_photographs_look_no_worse_than_in_ink(self):
        for count in (1, 3, 6):
            with self.subTest(inks=count):
                both, ink = (self.difference(ASTRONAUT, 8000, 2, self.query(count) + dots)
                             for dots in ("", "&dots=ink"))
                self.assertLess(both, 1.02 * ink)

    def test_solid_colours_are_those_of_the_inks(self):
        drawn = self.halftone(ASTRONAUT, "?sites=500&scale=2&background=%23ffe" + self.query(2)).picture("RGB")
        inks = [numpy.array([LIGHT[int(ink[i:i + 2], 16)] for i in (0, 2, 4)]) for ink in self.RISO[:2]]
        paper = LIGHT[[255, 255, 238]]
        expected = [paper, paper * inks[0], paper * inks[1], paper * inks[0] * inks[1]]
        found = colours(drawn)
        self.assertLessEqual(len(found), 4)
        for colour in found:
            self.assertLess(min(abs(LIGHT[list(colour)] - each).max() for each in expected), 0.01, colour)

    def test_lists_have_the_outlines_of_each_ink(self):
        answer = self.halftone(ASTRONAUT, "?sites=900&dots=both&format=json" + self.query(4)).json()
        self.assertEqual([ink["name"] for ink in answer["inks"]], ["#" + ink for ink in self.RISO[:4]])
        self.assertEqual(len(answer["points"]), 900)
        places = numpy.random.default_rng(1).random((500, 2)) * (answer["width"], answer["height"])
        for ink in answer["inks"]:
            covered = inside(places, [numpy.array(ring) for ring in ink["rings"]]).mean()
            self.assertTrue(0.01 < covered < 0.99, ink["name"])

    def test_svg_has_a_layer_for_each_ink(self):
        for inks, count in (("&color=cmyk", 3), ("&color=rgb", 3), (self.query(4), 4)):
            with self.subTest(inks=inks):
                query = "?sites=500&scale=2" + inks
                ours = LIGHT[pixels(self.halftone(ASTRONAUT, query + "&antialias=true").body, "RGB")]
                svg = self.halftone(ASTRONAUT, query + "&format=svg").body
                self.assertEqual(len(ElementTree.fromstring(svg).findall(SVG + "g")), count)
                theirs = LIGHT[pixels(drawn_by_librsvg(svg, ours.shape), "RGB")]
                self.assertLess(abs(ours.mean((0, 1)) - theirs.mean((0, 1))).max(), 0.02)
                self.assertLess(numpy.abs(ours - theirs).mean(), 0.05)

    def test_tiff_has_a_plate_for_each_ink(self):
        plates = self.halftone(ASTRONAUT, "?sites=900&scale=2&format=tiff&dots=both" + self.query(4))
        self.assertEqual(Image.open(io.BytesIO(plates.body)).tag_v2[334], 4)


class Options(ServerCase):
    def test_contradictory_ones_are_rejected(self):
        for query, field, words in (
                ("dots=both&palette=%23f00&style=stroke&format=svg", "dots", "style=fill"),
                ("dots=both&tone=density", "dots", "tone=density"),
                ("dots=both&style=stroke&format=svg", "dots", "style=fill"),
                ("dots=both&sites=500&dot=3", "dot", "together with sites"),
                ("dots=paper&color=rgb", "dots", "color=gray"), ("dots=none", "dots", "'both' or 'ink' or 'paper'"),
                ("dots=both&invert=true", "invert", "contradicts dots"),
                ("dots=ink&invert=true", "invert", "contradicts dots"),
                ("dots=paper&invert=false", "invert", "contradicts dots")):
            with self.subTest(query=query):
                problem = self.assert_problem(self.ask("/halftone?" + query, data=CAMERA), 400, words)
                self.assertEqual(problem["errors"][0]["pointer"], field)

    def test_drawings_have_dots_on_both_sides_by_default(self):
        for form in ("png", "webp", "tiff", "svg"):
            usual, both, ink = (self.halftone(CAMERA, f"?sites=300&format={form}{dots}").body
                                for dots in ("", "&dots=both", "&dots=ink"))
            self.assertEqual(usual, both)
            self.assertNotEqual(usual, ink)

    def test_of_any_number_of_inks_are_both_by_default(self):
        for count in (1, 3, 6):
            query = "?sites=300&palette=" + ",".join("%23" + ink for ink in Palettes.RISO[:count])
            usual, both = (self.halftone(ASTRONAUT, query + dots).body for dots in ("", "&dots=both"))
            self.assertEqual(usual, both)

    def test_of_pens_and_of_densities_are_ink_by_default(self):
        for query in ("format=svg&style=stroke", "tone=density", "palette=%23000&style=stroke&format=svg"):
            usual, ink = (self.halftone(CAMERA, f"?sites=300&{query}{dots}").body for dots in ("", "&dots=ink"))
            self.assertEqual(usual, ink, query)

    def test_invert_is_an_alias_of_dots(self):
        for invert, dots in (("true", "paper"), ("false", "ink")):
            inverted, sided = (self.halftone(CAMERA, "?sites=300&" + query).body
                               for query in (f"invert={invert}", f"dots={dots}"))
            self.assertEqual(inverted, sided)


if __name__ == "__main__":
    unittest.main(verbosity=2)
