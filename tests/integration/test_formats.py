# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads answers in every format with the programs for which the formats are made."""

import csv
import io
import pathlib
import re
import tempfile
import unittest
from xml.etree import ElementTree

import numpy
import shapely.geometry
from PIL import Image

from harness import PICTURES, ServerCase, execute, file_of, flat, linear, pixels, polygon, post_json, rings_of

CAMERA = (PICTURES / "camera.png").read_bytes()
SVG = "{http://www.w3.org/2000/svg}"
ITALY = {"sites": 500, "seed": 4, "geometry": polygon("Italy-110m.geojson")}


def by_csv(file):
    rows = list(csv.reader(io.StringIO(file.decode("ascii"), newline="")))
    return rows[0], numpy.array(rows[1:], dtype=float)


def by_numpy(file):
    return numpy.load(io.BytesIO(file), allow_pickle=False)


class FormatCase(ServerCase):
    def made(self, format_, **body):
        answer = post_json(self.server, "/sample", {**body, "format": format_})
        self.assertEqual(answer.status, 200, answer)
        return answer

    def dots(self, query, *arguments):
        answer = self.ask("/halftone" + query, *arguments, data=CAMERA)
        self.assertEqual(answer.status, 200, answer)
        return answer


class Points(FormatCase):
    """All formats hold the same doubles."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.expected = numpy.array(post_json(cls.server, "/sample", ITALY).json()["points"])

    def test_csv_holds_the_points(self):
        answer = self.made("csv", **ITALY)
        self.assertEqual(answer.type, "text/csv; header=present")
        header, points = by_csv(answer.body)
        self.assertEqual(header, ["x", "y"])
        numpy.testing.assert_array_equal(points, self.expected)
        self.assertEqual(answer.body.count(b"\r\n"), 501)
        loaded = numpy.loadtxt(io.BytesIO(answer.body), delimiter=",", skiprows=1)
        numpy.testing.assert_array_equal(loaded, self.expected)

    def test_npy_holds_the_points(self):
        answer = self.made("npy", **ITALY)
        self.assertEqual(answer.type, "application/x-npy")
        points = by_numpy(answer.body)
        self.assertEqual((points.dtype, points.flags.c_contiguous), (numpy.dtype("<f8"), True))
        numpy.testing.assert_array_equal(points, self.expected)
        # Both files are equal but for the number of padding spaces.
        written = io.BytesIO()
        numpy.save(written, points)
        self.assertEqual(written.getvalue().replace(b" ", b"")[10:], answer.body.replace(b" ", b"")[10:])

    def test_geojson_holds_the_points(self):
        answer = self.made("geojson", **ITALY)
        self.assertEqual(answer.type, "application/geo+json")
        feature = answer.json()
        read = shapely.geometry.shape(feature["geometry"])
        self.assertEqual((feature["type"], read.geom_type), ("Feature", "MultiPoint"))
        numpy.testing.assert_array_equal([(p.x, p.y) for p in read.geoms], self.expected)
        self.assertTrue(shapely.geometry.shape(ITALY["geometry"]).contains(read))
        properties = feature["properties"]
        self.assertEqual((properties["sites"], properties["seed"], properties["method"]), (500, 4, "ccdt"))
        self.assertEqual(self.made("geojson", **ITALY).body, answer.body)

    def test_single_points_are_read_back(self):
        one = {"sites": 1, "domain": {"type": "rectangle", "width": 1, "height": 1}}
        self.assertEqual(by_csv(self.made("csv", **one).body)[1].shape, (1, 2))
        self.assertEqual(by_numpy(self.made("npy", **one).body).shape, (1, 2))
        self.assertEqual(len(self.made("geojson", **one).json()["geometry"]["coordinates"]), 1)

    def test_many_points_are_read_back(self):
        many = {"sites": 200_000, "method": "random", "domain": {"type": "torus", "width": 1, "height": 1}}
        expected = numpy.array(post_json(self.server, "/sample", many).json()["points"])
        numpy.testing.assert_array_equal(by_numpy(self.made("npy", **many).body), expected)
        numpy.testing.assert_array_equal(by_csv(self.made("csv", **many).body)[1], expected)

    def test_dots_of_halftones_are_read_back(self):
        expected = numpy.array(self.dots("?sites=700&format=json").json()["points"])
        table = self.dots("?sites=700&format=csv")
        self.assertEqual(table.type, "text/csv; header=present")
        numpy.testing.assert_array_equal(by_csv(table.body)[1], expected)
        array = self.dots("?sites=700&format=npy")
        self.assertEqual(array.type, "application/x-npy")
        numpy.testing.assert_array_equal(by_numpy(array.body), expected)


def rendered(svg, shape):
    """Returns the share of each pixel that librsvg covers with ink."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = pathlib.Path(folder) / "dots.svg", pathlib.Path(folder) / "dots.png"
        source.write_bytes(svg)
        height, width = shape
        execute(["rsvg-convert", "--width", str(width), "--height", str(height), "--background-color", "white",
                 "--output", str(target), str(source)], check=True)
        return 1 - pixels(target.read_bytes(), "L") / 255


def drawn(png):
    """Returns the share of ink of each pixel in a drawing of the server, whose edges are antialiased in linear
    light."""
    return 1 - numpy.vectorize(linear)(numpy.arange(256))[pixels(png, "L")]


def check_png(file):
    with tempfile.NamedTemporaryFile(suffix=".png") as stored:
        stored.write(file)
        stored.flush()
        execute(["pngcheck", "-q", stored.name], check=True)


def centres(svg):
    """Returns the centres of the dots, in the sequence in which they are drawn."""
    root = ElementTree.fromstring(svg)
    circles = [(float(c.get("cx")), float(c.get("cy"))) for c in root.iter(SVG + "circle")]
    paths = " ".join(path.get("d") for path in root.iter(SVG + "path"))
    strokes = re.findall(r"M(\S+) (\S+)h\S+", paths)
    return numpy.array(circles or strokes, dtype=float)


def length(points):
    return numpy.linalg.norm(numpy.diff(points, axis=0), axis=1).sum()


class Drawings(FormatCase):
    """Compares drawings of points, in pixels and in millimetres."""

    def same_picture(self, svg, png):
        ours = drawn(png)
        theirs = rendered(svg, ours.shape)
        self.assertEqual(ours.shape, theirs.shape)
        # Antialiasing by the server adds an area of pi / 12 square pixels to each dot.
        self.assertLess(abs(ours.mean() - theirs.mean()), 0.04 * ours.mean())
        self.assertLess(numpy.abs(ours - theirs).mean(), 0.1 * ours.mean())

    def test_svg_holds_the_points(self):
        points = numpy.array(post_json(self.server, "/sample", ITALY).json()["points"])
        corners = numpy.concatenate(rings_of(ITALY["geometry"]))
        left, top = corners[:, 0].min(), corners[:, 1].max()
        expected = (points - (left, top)) * (1, -1)
        for style in ("fill", "stroke"):
            svg = self.made("svg", style=style, **ITALY)
            self.assertEqual(svg.type, "image/svg+xml")
            found = centres(svg.body)
            numpy.testing.assert_allclose(found, expected[self.nearest(found, expected)], atol=2e-5)
            self.assertEqual(len(set(self.nearest(found, expected))), 500)

    @staticmethod
    def nearest(found, expected):
        return numpy.linalg.norm(found[:, None] - expected[None], axis=2).argmin(axis=1)

    def test_paths_of_pens_are_short(self):
        domain = {"type": "rectangle", "width": 2, "height": 1}
        points = numpy.array(self.sample(sites=4000, domain=domain)["points"])
        svg = self.made("svg", sites=4000, domain=domain, width_mm=200).body
        path = length(centres(svg))
        self.assertLess(path, 0.65 * 100 * length(points))
        described = re.search(rb"<desc>4000 dots along a path of (\S+) mm; in their original order it is (\S+) mm; ", svg)
        self.assertAlmostEqual(float(described[1]), path, delta=0.1)
        self.assertAlmostEqual(float(described[2]), 100 * length(points), delta=0.1)

    def test_svg_has_its_size_in_millimetres(self):
        svg = self.made("svg", sites=50, width_mm=150, style="stroke", dot=0.01,
                        domain={"type": "rectangle", "width": 2, "height": 1})
        root = ElementTree.fromstring(svg.body)
        self.assertEqual((root.get("width"), root.get("height"), root.get("viewBox")), ("150mm", "75mm", "0 0 150 75"))
        self.assertEqual(root.find(SVG + "g").get("stroke-width"), "1.5")
        self.assertIsNone(root.find(SVG + "rect"))

    def test_svg_looks_like_png(self):
        for body in ({**ITALY, "width": 700}, {**ITALY, "style": "stroke", "dot": 0.1},
                     {"sites": 300, "domain": {"type": "rectangle", "width": 1e6, "height": 2e6}, "width_mm": 90}):
            with self.subTest(body=list(body)):
                png = self.made("png", **body)
                self.assertEqual(png.type, "image/png")
                check_png(png.body)
                self.same_picture(self.made("svg", **body).body, png.body)

    def test_halftone_svg_looks_like_png(self):
        for query in ("?sites=3000", "?scale=2&dot=4", "?sites=3000&dots=ink",
                      "?sites=2000&scale=2&dot=4&dots=ink", "?sites=1000&style=stroke&width_mm=120"):
            with self.subTest(query=query):
                svg = self.dots(query + "&format=svg")
                self.assertEqual(svg.type, "image/svg+xml")
                self.same_picture(svg.body, self.dots(query + "&antialias=true").body)

    def test_halftone_svg_has_the_given_colours(self):
        query = "?sites=10&format=svg&foreground=%23f80&background=%23012&dots="
        ink, both = (ElementTree.fromstring(self.dots(query + dots).body) for dots in ("ink", "both"))
        for root in (ink, both):
            self.assertEqual(root.find(SVG + "rect").get("fill"), "#001122")
        self.assertEqual(ink.find(SVG + "g").get("fill"), "#ff8800")
        self.assertEqual([path.get("fill") for path in both.findall(SVG + "path")], ["#ff8800"])

    def test_png_has_the_requested_size(self):
        body = {"sites": 100, "domain": {"type": "rectangle", "width": 3, "height": 1}, "width": 600}
        image = Image.open(io.BytesIO(self.made("png", width_mm=150, **body).body))
        self.assertEqual((image.size, image.mode), ((600, 200), "L"))
        self.assertAlmostEqual(image.info["dpi"][0], 600 / 150 * 25.4, delta=0.02)
        self.assertNotIn("dpi", Image.open(io.BytesIO(self.made("png", **body).body)).info)
        halftone = Image.open(io.BytesIO(self.dots("?sites=50&scale=1&width_mm=100").body))
        self.assertAlmostEqual(halftone.info["dpi"][0], 512 / 100 * 25.4, delta=0.02)
        for form in ("png", "tiff"):
            printed = Image.open(io.BytesIO(self.halftone(CAMERA, f"?sites=300&width_mm=50.8&dpi=150&format={form}").body))
            self.assertEqual(printed.size, (300, 300))
            self.assertAlmostEqual(float(printed.info["dpi"][0]), 150, delta=0.02)
        self.assertEqual(Image.open(io.BytesIO(self.made("png", sites=9, domain=body["domain"], width_mm=50.8, dpi=150).body)).width, 300)

    def test_drawings_of_a_torus_wrap_around(self):
        body = {"sites": 64, "width": 640, "domain": {"type": "torus", "width": 1, "height": 1}, "dot": 0.02}
        inked = drawn(self.made("png", **body).body)
        self.assertAlmostEqual(inked.mean(), 64 * numpy.pi * 0.02 ** 2, delta=1e-3)

    def test_invalid_options_are_named_in_errors(self):
        square = {"sites": 5, "domain": {"type": "rectangle", "width": 1, "height": 100}}
        for options, status, word in (({"format": "png", "width": 60_000}, 413, "max-pixels"),
                                      ({"width": 0}, 400, "/width"), ({"width_mm": 0}, 400, "/width_mm"),
                                      ({"style": "dots"}, 400, "stroke"), ({"dot": 0}, 400, "/dot")):
            self.assert_problem(post_json(self.server, "/sample", {**square, **options}), status, word)


def tiffinfo(file):
    """Returns what tiffinfo prints, and its warnings while it reads the file to the end."""
    with tempfile.NamedTemporaryFile(suffix=".tiff") as stored:
        stored.write(file)
        stored.flush()
        result = execute(["tiffinfo", "-d", stored.name], capture_output=True, text=True, check=True)
        return result.stdout.split("Strip 0")[0], result.stderr


class Pictures(FormatCase):
    """All raster formats hold the same pixels of a halftone."""

    def test_webp_and_tiff_have_the_pixels_of_png(self):
        for query in ("?sites=800&scale=2", "?sites=800&scale=2&antialias=true", "?sites=300&invert=true&scale=1",
                      "?sites=800&scale=2&dots=ink", "?sites=800&scale=2&dots=ink&antialias=true",
                      "?sites=300&scale=1&foreground=%23306&background=%23fed",
                      "?sites=300&scale=1.5&foreground=%23306&background=transparent&antialias=true"):
            expected = self.dots(query).picture("RGBA")
            for name in ("webp", "tiff"):
                with self.subTest(query=query, format=name):
                    answer = self.dots(f"{query}&format={name}")
                    self.assertEqual(answer.type, "image/" + name)
                    numpy.testing.assert_array_equal(answer.picture("RGBA"), expected)

    def test_jpeg_looks_like_png_on_white_paper(self):
        for query in ("?sites=800&scale=2", "?sites=500&scale=1&color=cmyk&antialias=true",
                      "?sites=300&scale=1.5&foreground=%23306&background=transparent&antialias=true"):
            with self.subTest(query=query):
                expected = self.dots(query.replace("transparent", "white")).picture("RGB").astype(float)
                answer = self.dots(query + "&format=jpeg&jpeg_quality=98&width_mm=50")
                self.assertEqual(answer.type, "image/jpeg")
                self.assertLess(numpy.abs(answer.picture("RGB") - expected).mean(), 2)
                image = Image.open(io.BytesIO(answer.body))
                self.assertAlmostEqual(image.info["dpi"][0], image.width / 50 * 25.4, delta=0.51)
        sizes = [len(self.dots("?sites=800&format=jpeg" + more).body) for more in ("&jpeg_quality=30", "", "&jpeg_quality=100")]
        self.assertEqual(sorted(set(sizes)), sizes)
        self.assert_problem(self.ask("/halftone?sites=9&format=png&jpeg_quality=9", data=CAMERA), 400, "jpeg_quality", "jpeg only")
        drawn = Image.open(io.BytesIO(post_json(self.server, "/sample", {"sites": 9, "domain": {"type": "torus", "width": 1, "height": 1}, "format": "jpeg"}).body))
        self.assertEqual((drawn.format, drawn.mode), ("JPEG", "L"))

    def test_y_axis_points_up_in_drawings_of_points(self):
        body = {"sites": 300, "polygon": [[0, 0], [4, 0], [2, 4]], "format": "png"}
        dark = (post_json(self.server, "/sample", body).picture("L") < 128).sum(1)
        top, bottom = dark[:len(dark) // 2].sum(), dark[len(dark) // 2:].sum()
        self.assertLess(2 * top, bottom)  # a quarter of the triangle is in its upper half

    def test_webp_is_lossless_and_small(self):
        webp = self.dots("?sites=5000&scale=3&format=webp").body
        self.assertEqual(webp[12:16], b"VP8L")
        self.assertLess(len(webp), len(self.dots("?sites=5000&scale=3").body))

    def test_tiff_of_black_and_white_has_one_bit_per_pixel(self):
        output, complaints = tiffinfo(self.dots("?sites=5000&scale=2&format=tiff&width_mm=65.024").body)
        self.assertEqual(complaints, "")
        for line in ("Image Width: 1024 Image Length: 1024", "Resolution: 400, 400 pixels/inch", "Bits/Sample: 1",
                     "Compression Scheme: CCITT Group 4", "Photometric Interpretation: min-is-white"):
            self.assertIn(line, output)

    def test_tiff_of_greys_and_colours_declares_its_samples(self):
        for query, lines in (("&antialias=true", ("min-is-black", "Bits/Sample: 8")),
                             ("&foreground=%23306", ("RGB color", "Samples/Pixel: 3")),
                             ("&background=transparent", ("RGB color", "Samples/Pixel: 4", "unassoc-alpha"))):
            with self.subTest(query=query):
                output, complaints = tiffinfo(self.dots("?sites=50&scale=1&format=tiff" + query).body)
                self.assertEqual(complaints, "")
                for line in (*lines, "Compression Scheme: AdobeDeflate"):
                    self.assertIn(line, output)
                self.assertNotIn("pixels/inch", output)

    def test_webp_limits_sides_of_drawings(self):
        strip = file_of(flat(40, 2048, 8))
        answer = self.ask("/halftone?sites=10&scale=9&format=webp", data=strip)
        self.assert_problem(answer, 413, "16383", "scale")
        self.assertEqual(self.ask("/halftone?sites=10&scale=7&format=webp", data=strip).status, 200)


class Masks(FormatCase):
    SIDE = 128

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        torus = {"type": "torus", "width": cls.SIDE, "height": cls.SIDE}
        masks = {form: post_json(cls.server, "/sample", {"format": form, "domain": torus}) for form in ("mask", "mask16")}
        cls.greys = {form: numpy.array(Image.open(io.BytesIO(mask.body))).astype(int) for form, mask in masks.items()}

    def test_have_a_flat_histogram(self):
        counts = numpy.bincount(self.greys["mask"].ravel(), minlength=256)
        self.assertTrue((counts == self.SIDE ** 2 // 256).all())
        self.assertEqual(len(numpy.unique(self.greys["mask16"])), self.SIDE ** 2)
        self.assertTrue((self.greys["mask16"] // 256 == self.greys["mask"]).all())

    def test_have_almost_no_low_frequencies(self):
        frequency = numpy.hypot(*numpy.meshgrid(*2 * [numpy.fft.fftfreq(self.SIDE)]))
        for share in (1 / 16, 1 / 4, 1 / 2, 3 / 4, 15 / 16):
            below = self.greys["mask"] < 256 * share
            power = numpy.abs(numpy.fft.fft2(below - share)) ** 2 / (self.SIDE ** 2 * share * (1 - share))
            low = (frequency > 0) & (frequency < 0.25 * min(share, 1 - share) ** 0.5)
            self.assertLess(power[low].mean(), 0.1, share)  # 1 if pixels are chosen at random

    def test_with_frames_are_stacked_pictures_or_an_array(self):
        torus = {"type": "torus", "width": 24, "height": 16, "depth": 3}
        made = {form: post_json(self.server, "/sample", {"format": form, "domain": torus}).body
                for form in ("mask16", "masknpy")}
        frames = numpy.load(io.BytesIO(made["masknpy"]))
        self.assertEqual((frames.shape, frames.dtype), ((3, 16, 24), numpy.uint16))
        for frame in frames:
            self.assertTrue((numpy.sort(frame.ravel()) == numpy.arange(16 * 24) * 65536 // (16 * 24)).all())
        self.assertTrue((numpy.array(Image.open(io.BytesIO(made["mask16"]))) == frames.reshape(48, 24)).all())


class Accepted(FormatCase):
    """The header Accept chooses the format if the option `format` is absent."""

    def test_chooses_format_of_points(self):
        body = {"sites": 5, "domain": {"type": "rectangle", "width": 1, "height": 1}}
        for accept, type_ in (("text/csv", "text/csv; header=present"),
                              ("application/json;q=0.5, application/geo+json", "application/geo+json"),
                              ("application/x-npy, */*;q=0.1", "application/x-npy"),
                              ("application/json;q=0, application/*", "application/geo+json"),
                              ("*/*", "application/json"), ("", "application/json")):
            with self.subTest(accept=accept):
                answer = post_json(self.server, "/sample", body, "--header", "Accept: " + accept)
                self.assertEqual((answer.status, answer.type), (200, type_))
                self.assertIn("Accept", answer.headers["vary"].split(", "))

    def test_chooses_format_of_halftones(self):
        for accept, type_ in (("image/*", "image/png"), ("image/webp, */*;q=0.1", "image/webp"),
                              ("image/png;q=0.5, image/tiff", "image/tiff"), ("text/csv;q=0.2, application/x-npy;q=0.3", "application/x-npy"),
                              ("*/*", "image/png")):
            with self.subTest(accept=accept):
                answer = self.dots("?sites=5", "--header", "Accept: " + accept)
                self.assertEqual(answer.type, type_)
                self.assertIn("Accept", answer.headers["vary"].split(", "))

    def test_option_format_takes_precedence(self):
        body = {"sites": 5, "domain": {"type": "rectangle", "width": 1, "height": 1}, "format": "csv"}
        answer = post_json(self.server, "/sample", body, "--header", "Accept: text/html")
        self.assertEqual(answer.type, "text/csv; header=present")


if __name__ == "__main__":
    unittest.main(verbosity=2)
