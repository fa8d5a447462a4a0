# SPDX-License-Identifier: GPL-3.0-or-later
"""Drawings for plotters, interpreted like the programs that drive plotters."""

import io
import re
import unittest
import zipfile
import zlib
from xml.etree import ElementTree

import numpy
from PIL import Image

from harness import PICTURES, ServerCase, post_json

CHELSEA = (PICTURES / "chelsea.png").read_bytes()
SVG = "{http://www.w3.org/2000/svg}"
LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"


def pens_of_vpype(svg):
    """Returns the number of strokes of each layer, numbered like vpype's `read`. Each top-level group is a layer. The
    digits of its label, or else of its id, form its number; without digits, the number is its position from 1. The
    number 0 becomes 1. Top-level paths without a group are in layer 1."""
    root = ElementTree.fromstring(svg)
    pens = {}
    for place, group in enumerate(root.findall(SVG + "g"), 1):
        digits = re.sub("[^0-9]", "", group.get(LABEL) or "") or re.sub("[^0-9]", "", group.get("id") or "")
        number = max(int(digits), 1) if digits else place
        strokes = " ".join(path.get("d") for path in group.iter(SVG + "path"))
        pens[number] = pens.get(number, 0) + strokes.count("M")
    for path in root.findall(SVG + "path"):
        pens[1] = pens.get(1, 0) + path.get("d").count("M")
    return pens


def run_hpgl(text):
    """Interprets HPGL. Returns the strokes of each pen, [[(x, y), ...], ...] in millimetres."""
    pens, pen, down, at = {}, 0, False, (0, 0)
    for command, numbers in re.findall(r"([A-Z]{2})([^;A-Z]*);", text.decode("ascii")):
        values = [int(value) / 40 for value in numbers.split(",")] if numbers else []
        if command == "SP":
            pen = int(numbers)
        elif command in ("PU", "PD"):
            if command == "PD" and not down:
                pens.setdefault(pen, []).append([at])
            down = command == "PD"
            for at in zip(values[::2], values[1::2]):
                if down:
                    pens[pen][-1].append(at)
        elif command not in ("IN", "PA"):
            raise AssertionError(f"unknown HPGL command: {command}")
    return pens


class Grbl:
    """Interprets G-code like GRBL: one command per line, words of a letter and a number."""

    def __init__(self, text, speed=100):
        """@param speed  speed of G0, in millimetres per second"""
        self.pens, self.pen, self.at, self.seconds = {1: []}, 1, (0.0, 0.0), 0
        self.speed, self.feed = speed, None
        self.down, self.ended, self.millimetres, self.absolute = False, False, False, False
        for line in text.decode("ascii").splitlines():
            assert not self.ended and len(line) <= 80, line
            self.run(line.split(";")[0])

    def run(self, line):
        words = re.findall(r"([A-Z])(-?[0-9]+(?:\.[0-9]+)?)", line)
        assert "".join(map("".join, words)) == line.replace(" ", ""), line
        values = {letter: float(number) for letter, number in words}
        for code in ("".join(word) for word in words if word[0] in "GM"):
            if code in ("G0", "G1"):
                self.move(code, values)
            elif code == "G4":
                self.seconds += values["P"]
            elif code in ("M3", "M5"):
                if code == "M3":
                    self.pens[self.pen].append([self.at])
                self.down = code == "M3"
            elif code == "M0":
                self.pen += 1
                self.pens[self.pen] = []
            elif code == "M2":
                self.ended = True
            elif code in ("G21", "G90"):
                self.millimetres |= code == "G21"
                self.absolute |= code == "G90"
            else:
                raise AssertionError(f"unknown G-code: {code}")

    def move(self, code, values):
        assert self.millimetres and self.absolute and self.down == (code == "G1")
        self.feed = values.get("F", self.feed)
        before, self.at = self.at, (values["X"], values["Y"])
        if self.down:
            self.pens[self.pen][-1].append(self.at)
        self.seconds += numpy.hypot(*numpy.subtract(self.at, before)) / (self.feed / 60 if self.down else self.speed)


def read_dxf(text):
    """Reads DXF R12. Returns the declared layers, and the entities of each layer, [(kind, [(x, y), ...], radius)]."""
    lines = text.decode("ascii").splitlines()
    groups = [(int(code), value) for code, value in zip(lines[::2], lines[1::2])]
    assert len(lines) % 2 == 0 and groups[-1] == (0, "EOF")
    records, layers, layer_entities, line = [], [], {}, None
    for code, value in groups:
        if code == 0:
            records.append((value, {}))
        elif records:
            records[-1][1][code] = value
    section = None
    for kind, values in records:
        if kind == "SECTION":
            section = values[2]
        elif kind == "LAYER":
            layers.append(values[2])
        elif section == "ENTITIES" and kind not in ("ENDSEC", "EOF"):
            assert values[8] in layers, values
            entities = layer_entities.setdefault(values[8], [])
            at = (float(values.get(10, 0)), float(values.get(20, 0)))
            if kind == "POLYLINE":
                line = []
            elif kind == "VERTEX":
                line.append(at)
            elif kind == "SEQEND":
                entities.append(("POLYLINE", line, None))
            else:
                entities.append((kind, [at], float(values[40]) if kind == "CIRCLE" else None))
    return layers, layer_entities


class Pdf:
    """Interprets a PDF page: its discs, [(x, y, radius)], other areas, and strokes, in millimetres from the lower left.
    """

    def __init__(self, file):
        self.file, self.discs, self.areas, self.strokes = file, [], 0, []
        assert file.startswith(b"%PDF-") and file.rstrip().endswith(b"%%EOF")
        assert b"/Subtype /Image" not in file and b"/Filter /DCTDecode" not in file
        box = re.search(rb"/MediaBox \[ ([-0-9. ]+) ?\]", file)
        self.size = [float(value) / 72 * 25.4 for value in box[1].split()[2:]]
        for content in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", file, re.DOTALL):
            try:
                content = zlib.decompress(content)
            except zlib.error:
                pass
            if b" m\n" in content or b" m " in content or b" re" in content:
                self.run(content.decode("latin-1"))

    def run(self, content):
        # Groups have no matrix, because the page on which they are drawn has already flipped y.
        height = self.size[1] * 72 / 25.4
        turned = numpy.array([[1, 0, 0], [0, -1, 0], [0, height, 1]])
        stack, saved, path, width = [], [], [], 1
        matrix = numpy.identity(3) if " cm\n" in content[:60] else turned
        for token in re.findall(r"\[[^\]]*\]|<<.*?>>|\([^)]*\)|/\S+|[^\s\[\]]+", content):
            if re.fullmatch(r"-?\d*\.?\d+", token):
                stack.append(float(token))
                continue
            if token == "q":
                saved.append((matrix, width))
            elif token == "Q":
                matrix, width = saved.pop()
            elif token == "cm":
                a, b, c, d, e, f = stack[-6:]
                matrix = numpy.array([[a, b, 0], [c, d, 0], [e, f, 1]]) @ matrix
            elif token == "w":
                width = stack[-1]
            elif token == "m":
                path.append([stack[-2:]])
            elif token == "l":
                path[-1].append(stack[-2:])
            elif token == "c":
                path[-1] += [stack[-6:-4], stack[-4:-2], stack[-2:]]
            elif token in ("f", "f*"):
                for part in path:
                    points = numpy.array(part) @ matrix[:2, :2] + matrix[2, :2]
                    self.fill(points / 72 * 25.4)
                path = []
            elif token == "S":
                scale = numpy.sqrt(abs(numpy.linalg.det(matrix[:2, :2])))
                for part in path:
                    points = numpy.array(part) @ matrix[:2, :2] + matrix[2, :2]
                    self.strokes.append((points / 72 * 25.4, width * scale / 72 * 25.4))
                path = []
            elif token == "n":
                path = []
            stack = []

    def fill(self, points):
        low, high = points.min(0), points.max(0)
        radius = (high - low) / 2
        # A disc has four cubic curves, and possibly a closing line.
        if len(points) in (13, 14) and abs(radius[0] - radius[1]) < 0.02 * radius.max() + 0.003:
            self.discs.append((*(low + high) / 2, radius.mean()))
        else:
            self.areas += 1


class PlotterCase(ServerCase):
    def assert_refused(self, *cases):
        """Checks that requests are refused. @param cases  (query, field, words of the message)"""
        for query, field, words in cases:
            with self.subTest(query=query):
                answer = self.ask("/halftone" + query, data=CHELSEA)
                self.assertIn(answer.status, (400, 413, 422), answer)
                problem = answer.json()
                self.assertEqual(problem["errors"][0]["pointer"], field)
                self.assertIn(words, problem["detail"])


class Formats(ServerCase):
    """Each format must have the same dots as JSON. Interpreters in this file read the formats."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.inks = {}
        for colours in ("color=gray", "color=cmyk"):
            cls.inks[colours] = cls.points(cls(), colours)

    def points(self, colours, options=""):
        """Returns the dots of each ink, in millimetres from the lower left."""
        answer = self.made(colours, "format=json&" + options).json()
        unit = 90 / answer["width"]
        return [numpy.array(ink["points"]).reshape(-1, 2) * (unit, -unit) + (0, answer["height"] * unit)
                for ink in answer.get("inks", [answer])]

    def made(self, colours, options):
        return self.halftone(CHELSEA, f"?sites=700&{colours}&width_mm=90&{options}")

    def assert_dots(self, found, expected, tolerance):
        """Checks that each expected dot is found exactly once, in any order."""
        self.assertEqual(len(found), len(expected))
        if len(found) == 0:
            return
        distances = numpy.linalg.norm(numpy.asarray(found)[:, None] - expected[None], axis=2)
        nearest = distances.argmin(axis=1)
        self.assertLess(distances.min(axis=1).max(), tolerance)
        self.assertEqual(len(set(nearest)), len(expected))

    def middles(self, strokes):
        """Returns the centres of the bounding boxes of strokes, each of which draws a dot."""
        return [(numpy.min(stroke, axis=0) + numpy.max(stroke, axis=0)) / 2 for stroke in strokes]

    def test_hpgl(self):
        for colours, inks in self.inks.items():
            answer = self.made(colours, "format=hpgl")
            self.assertEqual(answer.type, "application/vnd.hp-hpgl")
            pens = run_hpgl(answer.body)
            for number, expected in enumerate(inks, 1):
                self.assert_dots([stroke[0] for stroke in pens.get(number, [])], expected, 0.02)

    def test_gcode(self):
        for colours, inks in self.inks.items():
            answer = self.made(colours, "format=gcode")
            self.assertEqual(answer.type, "text/x-gcode")
            machine = Grbl(answer.body)
            self.assertTrue(machine.ended)
            for number, expected in enumerate(inks, 1):
                self.assert_dots([stroke[0] for stroke in machine.pens[number]], expected, 1e-3)

    def test_dxf(self):
        for colours, inks in self.inks.items():
            answer = self.made(colours, "format=dxf")
            self.assertEqual(answer.type, "image/vnd.dxf")
            layers, entities = read_dxf(answer.body)
            self.assertEqual(len(layers), len(inks))
            for layer, expected in zip(layers, inks):
                circles = entities.get(layer, [])
                self.assertLessEqual({kind for kind, *_ in circles}, {"CIRCLE"})
                self.assertLessEqual(len({radius for *_, radius in circles}), 1)
                self.assert_dots([points[0] for _, points, _ in circles], expected, 1e-3)

    def test_pdf(self):
        for colours, inks in self.inks.items():
            for style in ("fill", "stroke"):
                with self.subTest(colours=colours, style=style):
                    options = f"style={style}&dots=ink&format=pdf"
                    answer = self.made(colours, options)
                    self.assertEqual(answer.type, "application/pdf")
                    page = Pdf(answer.body)
                    numpy.testing.assert_allclose(page.size, (90, 90 * 300 / 451), atol=0.01)
                    dots = page.discs if style == "fill" else [(*points[0], 0) for points, _ in page.strokes]
                    self.assert_dots(numpy.array(dots)[:, :2], numpy.concatenate(inks), 0.01)
                    self.assertEqual(answer.body, self.made(colours, options).body)

    def test_eps(self):
        for colours, inks in self.inks.items():
            answer = self.made(colours, "dots=ink&format=eps")
            self.assertEqual(answer.type, "application/postscript")
            document = answer.body.decode()
            dots = re.findall(r"^([\d.]+) ([\d.]+) [\d.]+ d$", document, re.MULTILINE)
            height = 90 * 300 / 451
            self.assert_dots([(float(x), height - float(y)) for x, y in dots], numpy.concatenate(inks), 0.01)
            if colours == "color=cmyk":
                self.assertEqual(re.findall(r"/Separation\((\w+)", document), ["Cyan", "Magenta", "Yellow", "Black"])

    def test_pdf_of_both_sides(self):
        for colours in ("color=gray", "color=cmyk", "color=rgb", "palette=%23f00,%2300f"):
            with self.subTest(colours=colours):
                query = f"?sites=700&{colours}&dots=both&width_mm=90&format="
                dots = self.halftone(CHELSEA, query + "json").json()
                page = Pdf(self.halftone(CHELSEA, query + "pdf").body)
                rings = [ring for ink in dots.get("inks", [dots]) for ring in ink["rings"]]
                papers = len(dots.get("inks", [dots]))
                self.assertEqual(page.areas + len(page.discs), papers + len(rings))

    def test_styles(self):
        for style in ("circles", "spiral"):
            with self.subTest(style=style):
                query = f"style={style}&pen=0.2mm&dots=ink&format="
                for strokes in (run_hpgl(self.made("color=gray", query + "hpgl").body)[1],
                                Grbl(self.made("color=gray", query + "gcode").body).pens[1],
                                [points for _, points, _ in
                                 read_dxf(self.made("color=gray", query + "dxf").body)[1]["PEN1_DOTS"]]):
                    self.assertGreater(min(map(len, strokes)), 8)
                    self.assert_dots(self.middles(strokes), self.inks["color=gray"][0], 0.1)

    def test_path_is_one_line(self):
        query = "style=path&format="
        points = self.points("color=gray", "style=path")[0]
        for strokes in (run_hpgl(self.made("color=gray", query + "hpgl").body)[1],
                        Grbl(self.made("color=gray", query + "gcode").body).pens[1],
                        [points for _, points, _ in
                         read_dxf(self.made("color=gray", query + "dxf").body)[1]["PEN1_DOTS"]]):
            self.assertEqual(len(strokes), 1)
            self.assert_dots(strokes[0], points, 0.02)
        line = numpy.array(Grbl(self.made("color=gray", query + "gcode").body).pens[1][0])
        self.assertLess(numpy.linalg.norm(numpy.diff(line, axis=0), axis=1).sum(),
                        0.7 * numpy.linalg.norm(numpy.diff(points, axis=0), axis=1).sum())

    def test_closed_tours(self):
        """Closed tours end where they start, and are hardly longer than paths through the same points."""
        square = {"sites": 500, "domain": {"type": "rectangle", "width": 1, "height": 1}, "width_mm": 50, "style": "path"}
        for made in (lambda name, closed: self.made("color=gray", f"style=path&format={name}&closed={closed}"),
                     lambda name, closed: self.made("color=rgb", f"style=path&format={name}&closed={closed}"),
                     lambda name, closed: post_json(self.server, "/sample",
                                                    {**square, "closed": closed == "true", "format": name})):
            paths, tours = ([run_hpgl(made("hpgl", closed).body), Grbl(made("gcode", closed).body).pens,
                             {layer: [line for _, line, _ in entities]
                              for layer, entities in read_dxf(made("dxf", closed).body)[1].items()},
                             {i: [line] for i, (line, _) in enumerate(Pdf(made("pdf", closed).body).strokes)}]
                            for closed in ("false", "true"))
            lengths = [[self.check_tour(*path, *tours[i][pen]) for pen, path in pens.items()]
                       for i, pens in enumerate(paths)]
            drawing = made("svg", "true").body
            stated = [float(length) for length in re.findall(rb"along a path of ([0-9.]+)", drawing)]
            for each in lengths:
                numpy.testing.assert_allclose(each, stated, rtol=1e-3)
            ends = [path.get("d").strip()[-1] for path in ElementTree.fromstring(drawing).iter(SVG + "path")]
            self.assertEqual(ends, ["Z"] * len(stated))
            self.assertNotIn(b"Z", made("svg", "false").body)

    def check_tour(self, path, tour):
        """Returns the length of a tour."""
        numpy.testing.assert_array_equal(tour[0], tour[-1])
        self.assertEqual(sorted(map(tuple, tour[1:])), sorted(map(tuple, path)))
        length, other = (numpy.linalg.norm(numpy.diff(line, axis=0), axis=1).sum() for line in (tour, path))
        self.assertAlmostEqual(length / other, 1, delta=0.05)
        return length

    def test_samples(self):
        body = {"sites": 60, "domain": {"type": "rectangle", "width": 2, "height": 1}, "width_mm": 50}
        expected = numpy.array(post_json(self.server, "/sample", body).json()["points"]) * 25
        strokes = run_hpgl(post_json(self.server, "/sample", {**body, "format": "hpgl"}).body)[1]
        self.assert_dots([stroke[0] for stroke in strokes], expected, 0.02)
        page = Pdf(post_json(self.server, "/sample", {**body, "format": "pdf"}).body)
        self.assert_dots(numpy.array(page.discs)[:, :2], expected, 0.01)


class Time(PlotterCase):
    """The drawing time that is estimated, or requested by `minutes`."""

    def seconds(self, query):
        answer = self.halftone(CHELSEA, query + "&width_mm=90&format=gcode&speed=40&dwell=0.05")
        return float(answer.headers["x-plot-seconds"]), Grbl(answer.body, speed=40)

    def test_is_estimated_as_measured(self):
        for style in ("stroke", "path", "spiral"):
            estimate, machine = self.seconds(f"?sites=900&style={style}")
            # The estimate omits the paths to the first dot and back, and to the edge of each filled dot.
            self.assertAlmostEqual(estimate, machine.seconds, delta=0.05 * estimate + 6)
            self.assertEqual(len(machine.pens[1]), 1 if style == "path" else 900)

    def test_is_not_exceeded_if_requested(self):
        for style, minutes in (("stroke", 4), ("path", 4), ("spiral&pen=0.9", 9), ("circles&pen=0.9", 9)):
            for options in ("", "&dot=0.4mm", "&color=cmyk", "&tone=density", "&iterations=0"):
                with self.subTest(style=style, options=options):
                    estimate, _ = self.seconds(f"?minutes={minutes}&style={style}{options}")
                    self.assertLessEqual(estimate, 60 * minutes)
        for style in ("stroke", "path"):
            estimate, _ = self.seconds(f"?minutes=4&style={style}")
            self.assertGreater(estimate, 0.85 * 240, style)

    def test_requires_a_width_and_no_number_of_dots(self):
        self.assert_refused(("?minutes=4", "minutes", "width_mm"),
                            ("?minutes=4&width_mm=90&sites=5", "minutes", "sites"),
                            ("?minutes=0&width_mm=90", "minutes", "0.1 to 10000"),
                            ("?minutes=1e308&width_mm=90", "minutes", "0.1 to 10000"),
                            ("?minutes=0.1&dwell=60&width_mm=90", "minutes", "minutes is too small to draw this picture"),
                            ("?minutes=1&style=spiral&pen=0.1&width_mm=90", "minutes", "wider pen"),
                            ("?minutes=4&width_mm=90&dots=both", "dots", "minutes"))


class Refusals(PlotterCase):
    """Refused requests, whose errors name the option and its limit."""

    def test_of_drawings_without_a_width(self):
        self.assert_refused(("?format=pdf", "width_mm", "format=pdf"),
                            ("?format=hpgl", "width_mm", "format=hpgl"),
                            ("?format=svg&style=spiral", "width_mm", "style=spiral"))

    def test_of_closed_dots(self):
        for style in ("", "&style=stroke", "&style=spiral"):
            self.assert_refused(("?format=svg&width_mm=90&closed=true" + style, "closed", "style=path"))
        answer = post_json(self.server, "/sample", {"sites": 5, "domain": {"type": "rectangle", "width": 2, "height": 1}, "closed": True})
        self.assertEqual((answer.status, answer.json()["errors"][0]["pointer"]), (400, "/closed"))

    def test_of_paper_dots(self):
        self.assert_refused(("?format=gcode&width_mm=90&dots=both", "dots", "pen"))

    def test_of_pens(self):
        self.assert_refused(("?pen=0", "pen", "0.01"), ("?pen=1e308", "pen", "0.01"),
                            ("?format=dxf&width_mm=9000&sites=1&style=spiral&pen=0.01", "pen", "turns"))

    def test_of_options_without_effect(self):
        self.assert_refused(("?dpi=300", "dpi", "width_mm"), ("?format=svg&width_mm=90&dpi=300", "dpi", "png"),
                            ("?width_mm=90&dpi=300&width=9", "width", "dpi"), ("?width_mm=9000&dpi=9600", "dpi", "65535"),
                            ("?width_mm=90&dpi=300&scale=2", "scale", "dpi"), ("?format=svg&machine=laser", "machine", "width_mm"),
                            ("?format=gcode&width_mm=90&machine=laser&style=path&dwell=1", "dwell", "laser"))

    def test_of_pen_commands_that_inject_others(self):
        for option in ("pen_down", "pen_up"):
            for command in ("", "M3%3BM5", "M5%0AM3", "M5%0DM3", "M5%00", "(M5)", "%24H", "!", "%25", "M5%E2%80%A8M3", "M" * 65):
                self.assert_refused((f"?format=gcode&width_mm=90&{option}={command}", option, "64 letters"))


class Paper(PlotterCase):
    """Drawings on paper whose format is given."""

    def made(self, query, picture=CHELSEA):
        return self.halftone(picture, "?sites=300&paper=a4&" + query).body

    def assert_box(self, points, low, high, tolerance=0.2):
        points = numpy.asarray(points)
        numpy.testing.assert_allclose((points.min(0), points.max(0)), (low, high), atol=tolerance)

    def test_has_the_drawing_in_the_middle(self):
        height = 277 * 300 / 451  # of the drawing, without the margins of 10 mm
        low, high = (10, 105 - height / 2), (287, 105 + height / 2)
        root = ElementTree.fromstring(self.made("format=svg"))
        self.assertEqual([root.get(name) for name in ("width", "height", "viewBox")], ["297mm", "210mm", "0 0 297 210"])
        numpy.testing.assert_allclose([float(root.find(SVG + "rect").get(name)) for name in ("x", "y", "width", "height")],
                                      (*low, 277, height), atol=1e-3)
        numpy.testing.assert_allclose(Pdf(self.made("format=pdf")).size, (297, 210), atol=0.01)
        dots = self.halftone(CHELSEA, "?sites=300&format=json&dots=ink").json()
        expected = numpy.array(dots["points"]) * (277 / 451, -277 / 451) + (10, high[1])
        for found in (run_hpgl(self.made("format=hpgl"))[1], Grbl(self.made("format=gcode")).pens[1],
                      [points for _, points, _ in read_dxf(self.made("format=dxf"))[1]["PEN1_DOTS"]]):
            self.assert_box([stroke[0] for stroke in found], expected.min(0), expected.max(0))

    def test_suits_the_picture_as_it_is_shown(self):
        for picture in ("turned.jpg", "turned.tif"):
            upright = Image.open(io.BytesIO(CHELSEA)).convert("RGB")
            file = io.BytesIO()
            exif = Image.Exif()
            exif[0x0112] = 6
            upright.save(file, "JPEG" if picture.endswith("jpg") else "TIFF", exif=exif)
            root = ElementTree.fromstring(self.made("format=svg", file.getvalue()))
            self.assertEqual((root.get("viewBox"), root.find(SVG + "rect").get("height")), ("0 0 210 297", "277"), picture)

    def test_has_marks_of_each_pen_outside_of_the_drawing(self):
        query = "marks=true&color=cmyk&style=stroke&margin=2cm&format="
        pens = run_hpgl(self.made(query + "hpgl"))
        marks = [[line for line in strokes if len(line) == 2] for strokes in pens.values()]
        self.assertEqual([len(lines) for lines in marks], [8] * len(pens))
        self.assertTrue(all(lines == marks[0] for lines in marks))
        for x, y in numpy.array(marks[0]).reshape(-1, 2):
            self.assertTrue(0 < x < 297 and 0 < y < 210 and (x < 20 or x > 277 or y < 20 or y > 190), (x, y))
        for style in ("stroke", "fill"):
            layers = ElementTree.fromstring(self.made(f"marks=true&color=cmyk&style={style}&format=svg")).findall(SVG + "g")
            self.assertEqual([len([path for path in layer.findall(SVG + "path") if path.get("d").count("L") == 8])
                              for layer in layers], [1] * len(layers))

    def test_adds_marks_to_the_time(self):
        seconds = [float(self.ask("/halftone?sites=300&paper=a4&speed=10&format=hpgl&marks=" + marks, data=CHELSEA)
                         .headers["x-plot-seconds"]) for marks in ("false", "true")]
        self.assertTrue(60 < seconds[1] - seconds[0] < 160, seconds)

    def test_of_points(self):
        body = {"sites": 50, "domain": {"type": "rectangle", "width": 1, "height": 2}, "format": "hpgl", "paper": "200x100", "margin": 0}
        answer = post_json(self.server, "/sample", body).body
        points = [stroke[0] for stroke in run_hpgl(answer)[1]]
        self.assert_box(points, (0, 0), (100, 200), 20)
        self.assertEqual(post_json(self.server, "/sample", {**body, "paper": "20X10CM"}).body, answer)

    def test_refuses_what_does_not_fit(self):
        self.assert_refused(("?format=svg&paper=a9", "paper", "a0 to a6"), ("?format=svg&paper=5x900", "paper", "10 to 10000"),
                            ("?format=svg&paper=5x900in", "paper", "10 to 10000"), ("?format=svg&paper=9inx12in", "paper", "9x12in"),
                            ("?format=svg&paper=nanx90", "paper", "10 to 10000"), ("?format=png&paper=a4", "paper", "svg"),
                            ("?format=svg&margin=9", "margin", "paper"), ("?format=svg&marks=true", "marks", "paper"),
                            ("?format=svg&paper=a4&margin=105", "margin", "no room"),
                            ("?format=svg&paper=a4&marks=true&margin=3", "marks", "4 mm"),
                            ("?format=svg&paper=a4&width_mm=278", "width_mm", "277 x 190"))


class Split(PlotterCase):
    """Drawings in several files, in a ZIP archive."""

    def made(self, query):
        answer = self.halftone(CHELSEA, "?sites=900&" + query)
        self.assertEqual(answer.type, "application/zip")
        archive = zipfile.ZipFile(io.BytesIO(answer.body))
        self.assertIsNone(archive.testzip())
        return {info.filename: archive.read(info) for info in archive.infolist()}, answer

    def test_by_inks_has_the_layers_of_the_whole_drawing(self):
        for style in ("fill", "stroke"):
            query = f"color=cmyk&paper=a4&style={style}&format=svg"
            layers = ElementTree.fromstring(self.halftone(CHELSEA, "?sites=900&" + query).body).findall(SVG + "g")
            files, _ = self.made(query + "&split=ink")
            self.assertEqual(list(files), [layer.get(LABEL) + ".svg" for layer in layers])
            for layer, file in zip(layers, files.values()):
                root = ElementTree.fromstring(file)
                self.assertEqual(root.get("viewBox"), "0 0 297 210")
                if style == "stroke":  # numbers of areas are relative to the number of sites
                    alone = root.find(SVG + "g")
                    self.assertEqual([path.get("d") for path in alone.iter(SVG + "path")],
                                     [path.get("d") for path in layer.iter(SVG + "path")])

    def test_by_time_has_all_strokes_in_files_that_take_at_most_this_time(self):
        for style in ("stroke", "circles&pen=0.5", "path", "path&closed=true"):
            with self.subTest(style=style):
                query = f"palette=red,black&paper=a4&speed=20&dwell=0.2&style={style}&format="
                files, answer = self.made(query + "gcode&split=2")
                whole = Grbl(self.halftone(CHELSEA, "?sites=900&" + query + "gcode").body, speed=20)
                machines = {name: Grbl(file, speed=20) for name, file in files.items()}
                self.assertGreater(len(machines), 3)
                for pen, ink in ((1, "red"), (2, "black")):
                    parts = [machine.pens[1] for name, machine in machines.items() if name.startswith(ink + "-")]
                    if "path" not in style:
                        self.assertEqual([stroke for part in parts for stroke in part], whole.pens[pen])
                        continue
                    line = parts[0][0]
                    for (following,) in parts[1:]:
                        self.assertEqual(line[-1], following[0])
                        line = line + following[1:]
                    self.assertEqual([line], whole.pens[pen])
                for name, file in files.items():
                    minutes = float(re.search(rb", ([0-9.]+) min", file)[1])
                    self.assertLessEqual(minutes, 2)
                self.assertAlmostEqual(float(answer.headers["x-plot-seconds"]),
                                       sum(60 * float(re.search(rb", ([0-9.]+) min", file)[1]) for file in files.values()),
                                       delta=3 * len(files) + 1)

    def test_of_a_map_has_files_for_classes(self):
        land = {"type": "Feature", "properties": {"a/b": 40, "c d": 60}, "geometry":
                {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]]}}
        answer = post_json(self.server, "/sample", {"geometry": land, "classes": ["a/b", "c d"], "format": "svg", "split": "ink"})
        self.assertEqual(answer.type, "application/zip")
        self.assertEqual(zipfile.ZipFile(io.BytesIO(answer.body)).namelist(), ["a_b.svg", "c_d.svg"])

    def test_refuses_what_has_no_effect(self):
        self.assert_refused(("?format=png&split=ink", "split", "svg"), ("?format=json&split=ink", "split", "svg"),
                            ("?format=svg&split=2", "split", "width_mm"), ("?format=svg&width_mm=90&split=0.5", "split", "1 to 10000"),
                            ("?format=svg&width_mm=90&split=2&dots=both", "dots", "pen"),
                            ("?format=hpgl&width_mm=90&split=1&sites=1500&dwell=60", "split", "1000 files"))


class Layers(ServerCase):
    """Layers as vpype reads them: one for each pen."""

    def check(self, svg, sites):
        pens = pens_of_vpype(svg)
        self.assertEqual(list(pens.items()), list(enumerate(sites, 1)))
        self.assertTrue(ElementTree.fromstring(svg).get("viewBox").startswith("0 0 "))

    def test_of_inks(self):
        for inks in ("color=cmyk", "color=rgb", "palette=%23ff0000,%2300ff00,%230000ff,%23000000",
                     "palette=%23ff0000,%23fe0000,%2378f480", "color=gray"):
            with self.subTest(inks=inks):
                query = f"?sites=900&{inks}&format="
                answer = self.halftone(CHELSEA, query + "json").json()
                sites = [ink["sites"] for ink in answer["inks"]] if "inks" in answer else [answer["sites"]]
                self.check(self.halftone(CHELSEA, query + "svg&style=stroke&width_mm=100").body, sites)

    def test_have_unique_ids(self):
        for colours, layers in (("color=gray", []), ("color=cmyk", ["layer1", "layer2", "layer3"])):
            root = ElementTree.fromstring(self.halftone(CHELSEA, f"?sites=700&{colours}&dots=both&format=svg").body)
            ids = [part.get("id") for part in root.iter() if part.get("id")]
            self.assertEqual(len(set(ids)), len(ids))
            self.assertEqual([group.get("id") for group in root.findall(SVG + "g")], layers)

    def test_of_classes(self):
        land = {"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {"pop2010": 40, "pop2020": 60}, "geometry":
             {"type": "Polygon", "coordinates": [[[x, 0], [x + 1, 0], [x + 1, 1], [x, 1], [x, 0]]]}} for x in range(3)]}
        for counts, sites in (({"classes": ["pop2010", "pop2020"]}, [120, 180]), ({"sites": "pop2020"}, [180])):
            body = {"geometry": land, **counts, "format": "svg", "style": "stroke", "width_mm": 100}
            answer = post_json(self.server, "/sample", body)
            self.assertEqual(answer.status, 200, answer)
            self.check(answer.body, sites)


if __name__ == "__main__":
    unittest.main()
