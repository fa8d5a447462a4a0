# SPDX-License-Identifier: GPL-3.0-or-later
"""Halftones in colour: their appearance, their formats, and errors of their options."""

import csv
import io
import pathlib
import tempfile
import unittest
from xml.etree import ElementTree

import numpy
import tifffile
from PIL import Image

from harness import PICTURES, Server, ServerCase, ask, colours, data_uri, execute, file_of, flat, pixels, post_json
from seen import LIGHT, ciede2000, lab, seen_light

ASTRONAUT = (PICTURES / "astronaut.png").read_bytes()
CHELSEA = (PICTURES / "chelsea.png").read_bytes()
GREY = (PICTURES / "camera.png").read_bytes()
SVG = "{http://www.w3.org/2000/svg}"
INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"
LATER = ("--header", "Prefer: respond-async")
PHOTOMETRIC, INK_SET, INK_NAMES = 262, 332, 333
INKS = {"cyan": "#00ffff", "magenta": "#ff00ff", "yellow": "#ffff00", "black": "#000000"}


def light(file):
    """Returns the linear light of each channel."""
    return LIGHT[pixels(file, "RGB")]


def blocks(picture, side):
    """Returns means over square blocks."""
    height, width = (length // side * side for length in picture.shape[:2])
    return picture[:height, :width].reshape(height // side, side, width // side, side, 3).mean(axis=(1, 3))


def rendered(svg, width):
    """Draws an SVG by librsvg, as PNG."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = pathlib.Path(folder) / "dots.svg", pathlib.Path(folder) / "dots.png"
        source.write_bytes(svg)
        execute(["rsvg-convert", "--width", str(width), "--output", str(target), str(source)], check=True)
        return target.read_bytes()


class Colours(ServerCase):
    def test_local_means_match_the_picture(self):
        for query in ("color=cmyk", "color=rgb&antialias=true", "palette=%230ff,%23f0f,%23ff0,%23000,%23f00,%2300f"):
            with self.subTest(query=query):
                answer = self.halftone(ASTRONAUT, f"?sites=20000&scale=3&{query}")
                errors = blocks(light(answer.body), 3 * 32) - blocks(light(ASTRONAUT), 32)
                self.assertLess(numpy.abs(errors.mean(axis=(0, 1))).max(), 0.02)
                self.assertLess(numpy.sqrt((errors ** 2).mean(axis=(0, 1))).max(), 0.04)

    def test_grey_pictures_have_black_dots_only(self):
        inks = self.halftone(GREY, "?sites=600&color=cmyk&format=json").json()["inks"]
        self.assertEqual([ink["sites"] for ink in inks], [0, 0, 0, 600])
        grey = self.halftone(GREY, "?sites=600&format=json").json()
        self.assertAlmostEqual(inks[3]["variation"], grey["variation"], delta=0.02)

    def test_number_of_sites_is_as_requested(self):
        for sites in (1, 3, 1000, 30_001):
            answer = self.halftone(CHELSEA, f"?sites={sites}&color=cmyk&iterations=1&format=json").json()
            self.assertEqual(sum(len(ink["points"]) for ink in answer["inks"]), sites)
            self.assertEqual(answer["sites"], sites)

    def test_dots_lie_where_the_picture_has_their_colour(self):
        picture = numpy.zeros((60, 90, 3))
        picture[:, :30], picture[:, 30:60], picture[:, 60:] = (255, 0, 0), (0, 255, 0), (0, 0, 255)
        inks = self.halftone(file_of(picture), "?sites=900&color=rgb&format=json").json()["inks"]
        for index, ink in enumerate(inks):
            x = numpy.array(ink["points"])[:, 0]
            self.assertTrue((30 * index < x).all() and (x < 30 * (index + 1)).all(), ink["name"])
            self.assertAlmostEqual(ink["sites"], 300, delta=15)  # the last dots of solid blue are hardly visible

    def test_transparent_parts_have_no_dots(self):
        picture = numpy.full((40, 60, 4), (200, 30, 90, 255), dtype=numpy.uint8)
        picture[:, 30:, 3] = 0
        inks = self.halftone(file_of(picture), "?sites=400&color=cmyk&format=json").json()["inks"]
        self.assertLess(max(x for ink in inks for x, _ in ink["points"]), 30)

    def test_paper_is_visible_between_dots(self):
        answer = self.halftone(CHELSEA, "?sites=500&scale=4&palette=%23800,%23008&background=%23ffe")
        self.assertIn((255, 255, 238), colours(pixels(answer.body, "RGB")))
        clear = self.halftone(CHELSEA, "?sites=500&scale=4&color=cmyk&background=transparent")
        self.assertEqual(set(numpy.unique(pixels(clear.body, "RGBA")[..., 3])), {0, 255})


class Likeness(ServerCase):
    """Compares the appearance from a distance: CIEDE2000 after a blur by two spacings of dots."""

    def differences(self, data, sites, query):
        wanted = light(data)
        scale = 3
        dots = light(self.halftone(data, f"?sites={sites}&scale={scale}&{query}").body)
        sigma = 2 * (wanted.shape[0] * wanted.shape[1] / sites) ** 0.5
        wanted, seen = lab(seen_light(wanted, sigma)), lab(seen_light(blocks(dots, scale), sigma))
        return wanted, seen, ciede2000(wanted, seen)

    def test_photographs_match(self):
        six = "palette=%230ff,%23f0f,%23ff0,%23000,%23f00,%2300f"
        for data, query, mean, most in ((ASTRONAUT, "color=cmyk&dots=ink", 1.8, 4.2),
                                        (CHELSEA, "color=cmyk&dots=ink", 2.1, 4.7),
                                        (ASTRONAUT, "color=rgb&dots=ink", 2.2, 7), (ASTRONAUT, six, 1.6, 3.5),
                                        (ASTRONAUT, "color=cmyk", 1, 2.5), (CHELSEA, "color=rgb", 0.7, 2)):
            with self.subTest(query=query):
                wanted, seen, difference = self.differences(data, 20_000, query)
                self.assertLess(difference.mean(), mean)
                self.assertLess(numpy.percentile(difference, 95), most)
                dark = wanted[..., 0] < 20
                if dark.mean() > 0.01:
                    self.assertLess(abs((seen - wanted)[dark][:, 0].mean()), 2)

    def test_greys_have_no_colour_cast(self):
        for share in (0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95):
            level = int(numpy.argmin(abs(1 - LIGHT - share)))
            wanted, seen, _ = self.differences(file_of(flat(level, 120, 120)), 1500, "color=cmyk")
            error = (seen - wanted).mean((0, 1))
            self.assertLess(numpy.abs(error[1:]).max(), 0.1, share)
            self.assertLess(abs(error[0]), 1.5, share)

    def test_dark_colours_are_reproduced(self):
        for colour in ((80, 40, 20), (20, 30, 60), (60, 20, 30)):
            wanted, seen, _ = self.differences(file_of(numpy.full((160, 160, 3), colour)), 4000, "color=cmyk")
            difference = ciede2000(wanted.mean((0, 1)), seen[20:-20, 20:-20].mean((0, 1)))
            self.assertLess(difference, 2.5, colour)

    def test_black_uses_black_ink_only(self):
        inks = self.halftone(file_of(flat(0, 60, 60)), "?sites=900&color=cmyk&format=json").json()["inks"]
        self.assertEqual([ink["sites"] for ink in inks], [0, 0, 0, 900])


class Formats(ServerCase):
    QUERY = "?sites=3000&color=cmyk&seed=2&scale=2"

    def made(self, format_, query=""):
        return self.halftone(CHELSEA, f"{self.QUERY}&format={format_}{query}")

    def test_png_has_a_palette(self):
        binary = self.made("png")
        image = Image.open(io.BytesIO(binary.body))
        self.assertEqual((image.mode, len(image.getpalette()) // 3 >= 8), ("P", True))
        self.assertLessEqual(len(colours(pixels(binary.body, "RGB"))), 8)
        self.assertEqual(Image.open(io.BytesIO(self.made("png", "&antialias=true").body)).mode, "RGB")
        with tempfile.NamedTemporaryFile(suffix=".png") as file:
            file.write(binary.body)
            file.flush()
            execute(["pngcheck", "-q", file.name], check=True)

    def test_webp_looks_like_png(self):
        for query in ("", "&background=transparent&antialias=true"):
            with self.subTest(query=query):
                expected = pixels(self.made("png", query).body, "RGBA")
                answer = self.made("webp", query)
                self.assertEqual(answer.type, "image/webp")
                found = pixels(answer.body, "RGBA")
                numpy.testing.assert_array_equal(found[..., 3], expected[..., 3])
                seen = expected[..., 3] > 0
                numpy.testing.assert_array_equal(found[seen], expected[seen])

    def test_tiff_of_cmyk_has_a_plate_for_each_ink(self):
        """The plates, composed as TIFF readers do, must look like the PNG."""
        answer = self.made("tiff", "&width_mm=100")
        self.assertEqual(answer.type, "image/tiff")
        image = Image.open(io.BytesIO(answer.body))
        self.assertEqual((image.mode, image.tag_v2[PHOTOMETRIC], image.tag_v2[INK_SET]), ("CMYK", 5, 1))
        self.assertEqual(image.tag_v2[INK_NAMES].rstrip("\0").split("\0"), list(INKS))
        self.assertAlmostEqual(image.info["dpi"][0], image.width / 100 * 25.4, 2)
        plates = numpy.asarray(image)
        self.assertEqual(set(numpy.unique(plates)), {0, 255})
        light = 1 - plates[..., :3] / 255
        printed = light * (1 - plates[..., 3:] / 255)
        numpy.testing.assert_array_equal(255 * printed, pixels(self.made("png").body, "RGB"))

    def test_tiff_of_a_palette_has_a_plate_for_each_ink(self):
        for palette in (["#c03000", "#003366"], ["#804000"], ["#ffff00", "#ff00ff", "#00ffff", "#000000"],
                        ["#c03000", "#003366", "#000000", "#ffff00", "#00ff00"]):
            with self.subTest(palette=palette):
                query = f"?sites=500&seed=2&scale=3&dots=ink&palette={','.join(palette).replace('#', '%23')}"
                with tifffile.TiffFile(io.BytesIO(self.halftone(CHELSEA, query + "&format=tiff").body)) as file:
                    (page,) = file.pages
                    self.assertEqual((page.photometric, page.tags["InkSet"].value), (tifffile.PHOTOMETRIC.SEPARATED, 2))
                    self.assertEqual(page.tags["NumberOfInks"].value, len(palette))
                    self.assertEqual(page.tags["InkNames"].value.rstrip("\0").split("\0"), palette)
                    plates = page.asarray().reshape(page.imagelength, page.imagewidth, len(palette))
                shown = pixels(self.halftone(CHELSEA, query).body, "RGB")
                for ink, colour in enumerate(palette):
                    alone = (plates[..., ink] == 255) & (plates.astype(int).sum(-1) == 255)
                    self.assertGreater(alone.sum(), 100)
                    self.assertEqual(colours(shown[alone]), {tuple(bytes.fromhex(colour[1:]))})
                self.assertTrue((shown[plates.max(-1) == 0] == 255).all())

    def test_plates_preserve_tone_if_antialiased(self):
        hard, soft = (numpy.asarray(Image.open(io.BytesIO(self.made("tiff", query).body)), dtype=float)
                      for query in ("", "&antialias=true"))
        self.assertGreater(len(numpy.unique(soft)), 100)
        numpy.testing.assert_allclose(soft.mean((0, 1)), hard.mean((0, 1)), rtol=0.03, atol=0.5)

    def test_rgb_tiff_looks_like_png(self):
        for query in ("", "&antialias=true"):
            files = [self.halftone(CHELSEA, f"?sites=3000&color=rgb&scale=2&format={form}{query}").body
                     for form in ("png", "tiff")]
            numpy.testing.assert_array_equal(*(pixels(file, "RGB") for file in files))

    def test_svg_has_a_layer_for_each_ink(self):
        inks = self.made("json").json()["inks"]
        for style, tag in (("fill", "circle"), ("stroke", "path")):
            root = ElementTree.fromstring(self.made("svg", "&dots=ink&style=" + style).body)
            layers = [group for group in root.findall(SVG + "g") if group.get(INKSCAPE + "groupmode") == "layer"]
            self.assertEqual([layer.get(INKSCAPE + "label") for layer in layers], list(INKS))
            for layer, ink in zip(layers, inks):
                group = layer.find(SVG + "g")
                self.assertEqual(group.get("fill" if style == "fill" else "stroke"), ink["color"])
                self.assertTrue(layer.find(SVG + "desc").text.startswith(f"{ink['sites']} dots along a path of"))
                drawn = group.findall(SVG + tag)
                count = len(drawn) if style == "fill" else sum(path.get("d").count("M") for path in drawn)
                self.assertEqual(count, ink["sites"])

    def test_svg_looks_like_png(self):
        for color in ("cmyk", "rgb"):
            query = f"?sites=3000&scale=4&color={color}&antialias=true"
            png = light(self.halftone(CHELSEA, query).body)
            svg = light(rendered(self.halftone(CHELSEA, query + "&format=svg").body, png.shape[1]))
            self.assertEqual(svg.shape, png.shape)
            # librsvg rounds antialiased edges differently, and blends them in sRGB.
            self.assertLess(numpy.abs(svg - png).mean(), 0.05)
            self.assertLess(numpy.abs(blocks(svg, 100) - blocks(png, 100)).max(), 0.06)

    def test_csv_and_npy_give_the_ink_of_each_dot(self):
        inks = self.made("json").json()["inks"]
        rows = list(csv.reader(io.StringIO(self.made("csv").body.decode("ascii"), newline="")))
        self.assertEqual(rows[0], ["x", "y", "ink"])
        expected = [(*point, ink["name"]) for ink in inks for point in ink["points"]]
        self.assertEqual([(float(x), float(y), ink) for x, y, ink in rows[1:]], expected)
        array = numpy.load(io.BytesIO(self.made("npy").body), allow_pickle=False)
        numbered = [(*point, number) for number, ink in enumerate(inks) for point in ink["points"]]
        numpy.testing.assert_array_equal(array, numpy.array(numbered))

    def test_json_lists_each_ink(self):
        answer = self.made("json").json()
        self.assertNotIn("points", answer)
        self.assertEqual({ink["name"]: ink["color"] for ink in answer["inks"]}, INKS)
        self.assertEqual((answer["sites"], answer["seed"], answer["method"]), (3000, 2, "ccdt"))
        for ink in answer["inks"]:
            self.assertEqual(len(ink["trace"]), ink["iterations"] + 1)
            self.assertEqual(len(ink["points"]), ink["sites"])

    def test_inks_of_palettes_are_named_by_colour(self):
        for palette in ("#0AF, #112233", ["#0af", "#112233"]):
            answer = post_json(self.server, "/halftone",
                               {"image": data_uri(CHELSEA), "sites": 200, "palette": palette, "format": "json"})
            self.assertEqual(answer.status, 200, answer)
            self.assertEqual([ink["name"] for ink in answer.json()["inks"]], ["#00aaff", "#112233"])


class Options(ServerCase):
    def test_invalid_ones_are_named_in_errors(self):
        for query, field, words in (
                ("color=pink", "color", "'gray' or 'cmyk' or 'rgb'"),
                ("palette=", "palette", "1 to 6 colours"),
                ("palette=%23000,%23111,%23222,%23333,%23444,%23555,%23666", "palette", "1 to 6 colours"),
                ("palette=%23000,reds", "palette", "colour 2 must be a colour: #rgb, #rrggbb"),
                ("palette=%23fff,%23ffffff", "palette", "colour 2 repeats an earlier colour"),
                ("palette=%23000&color=cmyk", "palette", "give only one of them"),
                ("color=cmyk&foreground=%23f00", "foreground", "color=gray"),
                ("color=cmyk&invert=true", "invert", "color=gray"),
                ("color=cmyk&dots=paper", "dots", "color=gray"),
                ("palette=%23f00&dots=paper", "dots", "color=gray"),
                ("color=rgb&background=%23fff", "background", "is black")):
            with self.subTest(query=query):
                problem = self.assert_problem(self.ask("/halftone?" + query, data=GREY), 400, words)
                self.assertEqual(problem["errors"][0]["pointer"], field)

    def test_pictures_like_their_paper_are_rejected(self):
        white = file_of(numpy.full((9, 9, 3), 255))
        black = file_of(numpy.zeros((9, 9, 3)))
        self.assert_problem(self.ask("/halftone?color=cmyk", data=white), 422, "like its paper")
        self.assert_problem(self.ask("/halftone?color=rgb", data=black), 422, "like its paper")
        self.assertEqual(self.ask("/halftone?color=rgb&sites=9", data=white).status, 200)

    def test_change_the_etag(self):
        tags = {self.halftone(GREY, "?sites=50" + query).headers["etag"]
                for query in ("", "&color=gray", "&color=cmyk", "&palette=%23000", "&palette=%23000,%23f00")}
        self.assertEqual(len(tags), 5)


class Jobs(unittest.TestCase):
    def test_report_monotonic_progress(self):
        with Server("--workers=2") as server:
            accepted = ask(server, "/halftone?sites=9000&color=cmyk", *LATER, data=ASTRONAUT)
            self.assertEqual(accepted.status, 202, accepted)
            job = accepted.headers["location"]
            stream = ask(server, job + "/events", "--no-buffer").body.decode()
            lines = [line for line in stream.splitlines() if line.startswith("data:")]
            progress = [float(line.split('"progress":')[1].split(",")[0].rstrip("}")) for line in lines]
            self.assertEqual(progress, sorted(progress))
            self.assertEqual(progress[-1], 1)
            now = ask(server, "/halftone?sites=9000&color=cmyk", data=ASTRONAUT)
            self.assertEqual(ask(server, job + "/result").body, now.body)


if __name__ == "__main__":
    unittest.main(verbosity=2)
