# SPDX-License-Identifier: GPL-3.0-or-later
"""Halftones with dots on both sides of the tonal scale: ink dots on white ground, paper dots on black ground."""

import csv
import io
import pathlib
import tempfile
import unittest
from xml.etree import ElementTree

import numpy
import shapely.geometry
from PIL import Image, ImageDraw

from harness import PICTURES, ServerCase, execute, file_of, flat, inside, linear, pixels
from seen import LIGHT, ciede2000, lab, seen_light

ASTRONAUT = (PICTURES / "astronaut.png").read_bytes()
CAMERA = (PICTURES / "camera.png").read_bytes()
SVG = "{http://www.w3.org/2000/svg}"
LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"


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


def rings(answer):
    return [numpy.array(ring) for ring in answer["ground"]]


def is_far_from_boundary(answer):
    """Returns for each dot whether it is farther from the boundary of the ground than the error of the outline."""
    boundary = shapely.geometry.MultiLineString([[*ring, ring[0]] for ring in answer["ground"]])
    return numpy.array([shapely.geometry.Point(point).distance(boundary) > 0.5 for point in answer["points"]])


class Tone(ServerCase):
    def test_flat_greys_preserve_luminance(self):
        for share in (0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.48, 0.52, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98):
            level = int(numpy.argmin(abs(LIGHT - share)))
            with self.subTest(share=share):
                drawn = self.halftone(file_of(flat(level, 128, 128)), "?sites=2000&scale=4&antialias=true")
                self.assertAlmostEqual(light(drawn.body).mean(), linear(level), delta=0.004)

    def test_dots_never_cover_more_than_half(self):
        for level in (60, 120, 180, 190, 200):
            dots = self.halftone(file_of(flat(level, 128, 128)), "?sites=2000&format=json&dots=both").json()
            covered = numpy.pi * (numpy.array(dots["radii"]) ** 2).sum() / 128 ** 2
            self.assertAlmostEqual(covered, min(linear(level), 1 - linear(level)), delta=0.01)

    def test_foreground_and_background_are_used(self):
        drawn = self.halftone(CAMERA, "?sites=2000&scale=4&foreground=%23024&background=%23fda").picture("RGB")
        colours = {tuple(colour) for colour in numpy.unique(drawn.reshape(-1, 3), axis=0).tolist()}
        self.assertEqual(colours, {(0, 0x22, 0x44), (255, 0xdd, 0xaa)})

    def test_tone_is_reported_for_given_number_and_radius(self):
        for dots, radius in ((1000, 1), (3000, 1)):
            answer = self.halftone(file_of(flat(210, 200, 200)), f"?sites={dots}&scale=4&dot={4 * radius}&antialias=true")
            tone = float(answer.headers["x-tone"])
            self.assertLess(tone, 1)
            seen = 1 - light(answer.body).mean()
            self.assertAlmostEqual(seen / (1 - linear(210)), tone, delta=0.02 * tone)


class BlackAndWhite(ServerCase):
    def test_is_reproduced_without_dots(self):
        picture = black_and_white()
        for query in ("", "&sites=500", "&detail=0", "&format=webp"):
            with self.subTest(query=query):
                drawn = self.halftone(file_of(picture), "?scale=1" + query)
                numpy.testing.assert_array_equal(pixels(drawn.body, "L"), picture)
        dots = self.halftone(file_of(picture), "?dots=both&format=json").json()
        self.assertEqual((dots["sites"], dots["points"], dots["radii"], dots["side"]), (0, [], [], []))

    def test_black_is_solid(self):
        black = file_of(flat(0, 30, 20))
        self.assertFalse(self.halftone(black, "?scale=3").picture().any())
        dots = self.halftone(black, "?dots=both&format=json").json()
        self.assertEqual(dots["sites"], 0)
        self.assertAlmostEqual(sum(shapely.geometry.Polygon(ring).area for ring in dots["ground"]), 30 * 20)


class Lists(ServerCase):
    def test_hold_the_requested_number_of_dots(self):
        for sites in (1, 7, 1000, 20_000):
            dots = self.halftone(CAMERA, f"?sites={sites}&dots=both&format=json").json()
            self.assertEqual(dots["sites"], sites)
            for member in ("points", "radii", "side"):
                self.assertEqual(len(dots[member]), sites, member)

    def test_sides_agree_with_the_ground(self):
        for data in (CAMERA, ASTRONAUT):
            dots = self.halftone(data, "?sites=8000&dots=both&format=json").json()
            on_black = inside(dots["points"], rings(dots))
            is_paper = numpy.array(dots["side"]) == "paper"
            self.assertTrue(0.05 < is_paper.mean() < 0.95)
            far = is_far_from_boundary(dots)
            self.assertGreater(far.mean(), 0.7)
            numpy.testing.assert_array_equal(is_paper[far], on_black[far])

    def test_hold_the_same_dots_in_all_formats(self):
        query = "?sites=900&dots=both&format="
        dots = self.halftone(ASTRONAUT, query + "json").json()
        expected = numpy.column_stack([dots["points"], dots["radii"], [side == "paper" for side in dots["side"]]])
        array = numpy.load(io.BytesIO(self.halftone(ASTRONAUT, query + "npy").body), allow_pickle=False)
        numpy.testing.assert_allclose(array, expected, rtol=1e-6)
        rows = list(csv.reader(io.StringIO(self.halftone(ASTRONAUT, query + "csv").body.decode(), newline="")))
        self.assertEqual(rows[0], ["x", "y", "radius", "side"])
        self.assertEqual([row[3] for row in rows[1:]], dots["side"])
        numpy.testing.assert_allclose(numpy.array([row[:3] for row in rows[1:]], float), expected[:, :3], rtol=1e-6)

    def test_agree_with_drawings(self):
        scale = 8
        dots = self.halftone(CAMERA, "?sites=2000&dots=both&format=json").json()
        drawn = self.halftone(CAMERA, f"?sites=2000&scale={scale}").picture()
        uncut = numpy.flatnonzero(is_far_from_boundary(dots))
        for i in uncut[::50]:
            x, y = (numpy.array(dots["points"][i]) * scale).astype(int)
            self.assertEqual(drawn[y, x], dots["side"][i] == "paper", dots["points"][i])

    def test_have_ink_dots_by_default(self):
        for form in ("json", "csv", "npy"):
            usual, ink = (self.halftone(CAMERA, f"?sites=300&seed=4&format={form}{dots}").body
                          for dots in ("", "&dots=ink"))
            if form == "json":
                self.assertNotIn(b'"ground"', usual)
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
                self.assertLess(numpy.abs(ours - theirs).mean(), 0.02)


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

    def test_greys_have_black_and_white_dots_only(self):
        answer = self.halftone(CAMERA, "?sites=1000&color=cmyk&dots=both&format=json").json()
        self.assertEqual([kind["flips"] for kind in answer["kinds"]], [["cyan", "magenta", "yellow"]])
        first, *others = (ground["rings"] for ground in answer["grounds"])
        self.assertTrue(all(rings == first for rings in others))

    def test_lists_hold_the_same_dots_in_all_formats(self):
        query = "?sites=900&color=cmyk&dots=both&format="
        answer = self.halftone(ASTRONAUT, query + "json").json()
        self.assertEqual(answer["sites"], 900)
        self.assertEqual(sum(kind["sites"] for kind in answer["kinds"]), 900)
        inks = [ground["ink"] for ground in answer["grounds"]]
        array = numpy.load(io.BytesIO(self.halftone(ASTRONAUT, query + "npy").body), allow_pickle=False)
        rows = [(*point, radius, sum(1 << inks.index(ink) for ink in kind["flips"])) for kind in answer["kinds"]
                for point, radius in zip(kind["points"], kind["radii"])]
        numpy.testing.assert_allclose(array[:, :4], numpy.array(rows), rtol=1e-6)
        table = list(csv.reader(io.StringIO(self.halftone(ASTRONAUT, query + "csv").body.decode(), newline="")))
        self.assertEqual(table[0], ["x", "y", "radius", "flips", "ground"])
        for row, numbers in zip(table[1:], array):
            for text, bits in zip(row[3:], numbers[3:].astype(int)):
                self.assertEqual(text, "+".join(ink for i, ink in enumerate(inks) if bits >> i & 1) or "paper")


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
        for count in (1, 2, 3):
            with self.subTest(inks=count):
                both, ink = (self.difference(ASTRONAUT, 8000, 2, self.query(count) + dots)
                             for dots in ("", "&dots=ink"))
                self.assertLess(both, 1.02 * ink)

    def test_solid_colours_are_those_of_the_inks(self):
        drawn = self.halftone(ASTRONAUT, "?sites=500&scale=2&background=%23ffe" + self.query(2)).picture("RGB")
        inks = [numpy.array([LIGHT[int(ink[i:i + 2], 16)] for i in (0, 2, 4)]) for ink in self.RISO[:2]]
        paper = LIGHT[[255, 255, 238]]
        expected = [paper, paper * inks[0], paper * inks[1], paper * inks[0] * inks[1]]
        found = numpy.unique(drawn.reshape(-1, 3), axis=0)
        self.assertLessEqual(len(found), 4)
        for colour in found:
            self.assertLess(min(abs(LIGHT[colour] - each).max() for each in expected), 0.01, colour)

    def test_lists_name_the_inks_that_dots_flip(self):
        answer = self.halftone(ASTRONAUT, "?sites=900&dots=both&format=json" + self.query(4)).json()
        names = ["#" + ink for ink in self.RISO[:4]]
        self.assertEqual([ground["ink"] for ground in answer["grounds"]], names)
        self.assertEqual(sum(kind["sites"] for kind in answer["kinds"]), 900)
        for kind in answer["kinds"]:
            self.assertEqual(kind["flips"], [name for name in names if name in kind["flips"]])

    def test_svg_looks_like_png(self):
        query = "?sites=3000&scale=4&antialias=true" + self.query(3)
        ours = LIGHT[pixels(self.halftone(ASTRONAUT, query).body, "RGB")]
        theirs = LIGHT[pixels(drawn_by_librsvg(self.halftone(ASTRONAUT, query + "&format=svg").body, ours.shape), "RGB")]
        self.assertLess(abs(ours.mean((0, 1)) - theirs.mean((0, 1))).max(), 0.02)
        self.assertLess(numpy.abs(ours - theirs).mean(), 0.05)

    def test_svg_has_a_layer_for_each_kind_if_requested(self):
        for colours in ("&color=cmyk", "&color=rgb", self.query(3)):
            with self.subTest(colours=colours):
                query = "?sites=500&scale=2" + colours
                ours = LIGHT[pixels(self.halftone(ASTRONAUT, query + "&antialias=true").body, "RGB")]
                svg = self.halftone(ASTRONAUT, query + "&format=svg&layers=kind").body
                kinds = self.halftone(ASTRONAUT, query + "&dots=both&format=json").json()["kinds"]
                layers = [layer.get(LABEL) for layer in ElementTree.fromstring(svg).findall(SVG + "g")]
                self.assertEqual(layers[0], "ground")
                self.assertEqual(len(layers), 1 + len(kinds))
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
                ("dots=both&background=transparent&format=svg", "dots", "background"),
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

    def test_of_up_to_three_inks_are_both_by_default(self):
        for count in (3, 4):
            query = "?sites=300&palette=" + ",".join("%23" + ink for ink in Palettes.RISO[:count])
            usual, ink = (self.halftone(ASTRONAUT, query + dots).body for dots in ("", "&dots=ink"))
            self.assertEqual(usual == ink, count == 4)

    def test_of_pens_and_of_densities_are_ink_by_default(self):
        for query in ("format=svg&style=stroke", "tone=density", "format=svg&background=transparent",
                      "palette=%23000&style=stroke&format=svg"):
            usual, ink = (self.halftone(CAMERA, f"?sites=300&{query}{dots}").body for dots in ("", "&dots=ink"))
            self.assertEqual(usual, ink, query)

    def test_invert_is_an_alias_of_dots(self):
        for invert, dots in (("true", "paper"), ("false", "ink")):
            inverted, sided = (self.halftone(CAMERA, "?sites=300&" + query).body
                               for query in (f"invert={invert}", f"dots={dots}"))
            self.assertEqual(inverted, sided)


if __name__ == "__main__":
    unittest.main(verbosity=2)
