# SPDX-License-Identifier: GPL-3.0-or-later
"""POST /halftone: every form of the request, every option, and the answers."""

import base64
import io
import json
import shutil
import tempfile
import unittest

import numpy
from PIL import Image

from harness import PICTURES, ServerCase, ask, colours, data_uri, execute, file_of, flat, linear, pixels, post_json

CAMERA = (PICTURES / "camera.png").read_bytes()
CHELSEA = (PICTURES / "chelsea.png").read_bytes()


class RequestForms(ServerCase):
    """All forms of a request must get the same bytes."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.expected = ask(cls.server, "/halftone?sites=500&seed=3", data=CAMERA).body

    def same(self, answer):
        self.assertEqual(answer.status, 200, answer)
        self.assertEqual(answer.type, "image/png")
        self.assertEqual(answer.body, self.expected)

    def test_raw_body_with_its_type(self):
        self.same(self.ask("/halftone?sites=500&seed=3", "--header", "Content-Type: image/png", data=CAMERA))

    def test_raw_body_with_a_wrong_type(self):
        self.same(self.ask("/halftone?sites=500&seed=3", "--header", "Content-Type: image/jpeg", data=CAMERA))

    def test_raw_body_without_a_type(self):
        self.assertGreater(len(CAMERA), 8192)
        self.same(self.ask("/halftone?sites=500&seed=3", "--header", "Content-Type:", data=CAMERA))

    def test_raw_body_in_chunks(self):
        self.same(self.ask("/halftone?sites=500&seed=3", "--header", "Transfer-Encoding: chunked", data=CAMERA))

    def test_uploaded_file(self):
        self.same(self.ask("/halftone?sites=500&seed=3", "--request", "POST", "--upload-file",
                           str(PICTURES / "camera.png")))

    def test_client_that_waits_for_100_continue(self):
        self.same(self.ask("/halftone?sites=500&seed=3", "--header", "Expect: 100-continue", data=CAMERA))

    def test_form(self):
        for part in ("image", "file"):
            with self.subTest(part=part):
                self.same(self.ask("/halftone", "--form", f"{part}=@{PICTURES / 'camera.png'}", "--form", "sites=500",
                                   "--form", "seed=3"))

    def test_form_with_options_before_the_picture(self):
        self.same(self.ask("/halftone", "--form", "sites=500", "--form", f"image=@{PICTURES / 'camera.png'}",
                           "--form", "seed=3"))

    def test_form_with_options_in_the_query(self):
        self.same(self.ask("/halftone?seed=3", "--form", f"image=@{PICTURES / 'camera.png'}", "--form", "sites=500"))

    def test_json_with_base64(self):
        body = {"image": base64.b64encode(CAMERA).decode(), "sites": 500, "seed": 3}
        self.same(post_json(self.server, "/halftone", body))

    def test_json_with_a_data_uri(self):
        self.same(post_json(self.server, "/halftone", {"image": data_uri(CAMERA), "sites": 500, "seed": 3}))

    def test_json_without_its_content_type(self):
        body = json.dumps({"image": data_uri(CAMERA), "sites": 500, "seed": 3})
        for type_ in ("", " application/octet-stream", " application/x-www-form-urlencoded", " text/plain"):
            with self.subTest(type=type_):
                self.same(self.ask("/halftone", "--header", "Content-Type:" + type_, data="\r\n " + body))
        self.assert_problem(self.ask("/halftone", "--header", "Content-Type: image/png", data=body), 415)

    def test_json_with_options_in_the_query(self):
        self.same(post_json(self.server, "/halftone?seed=3", {"image": data_uri(CAMERA), "sites": 500}))


class Formats(ServerCase):
    def test_reads_the_usual_file_formats(self):
        grey = numpy.tile(numpy.arange(64) * 3 + 20, (48, 1))
        colours = numpy.stack([grey, grey.max() - grey, grey // 2], axis=2)
        for picture in (grey, colours):
            for kind in ("PNG", "JPEG", "TIFF", "WEBP"):
                if kind == "WEBP" and picture is grey:
                    continue
                with self.subTest(kind=kind, colours=picture is colours):
                    answer = self.halftone(file_of(picture, kind), "?sites=50&scale=2")
                    self.assertEqual(answer.picture().shape, (96, 128))

    def test_png_is_well_formed_with_one_bit_per_pixel(self):
        answer = self.halftone(CAMERA, "?sites=2000&scale=2")
        with tempfile.NamedTemporaryFile(suffix=".png") as file:
            file.write(answer.body)
            file.flush()
            output = execute(["file", file.name], capture_output=True, text=True, check=True).stdout
            self.assertIn("1024 x 1024, 1-bit", output)
            checker = shutil.which("pngcheck")
            self.assertIsNotNone(checker)
            execute([checker, "-q", file.name], check=True)

    def test_json_holds_the_points(self):
        for choice in (("?sites=700&format=json",), ("?sites=700", "--header", "Accept: application/json")):
            with self.subTest(choice=choice):
                answer = self.ask("/halftone" + choice[0], *choice[1:], data=CHELSEA)
                self.assertEqual(answer.type, "application/json", answer)
                result = answer.json()
                self.assertEqual((result["width"], result["height"]), (451, 300))
                self.assertEqual((result["sites"], result["seed"], result["method"]), (700, 0, "ccdt"))
                points = numpy.array(result["points"])
                self.assertEqual(points.shape, (700, 2))
                self.assertTrue((points > 0).all() and (points < (451, 300)).all())
                self.assertEqual(len(result["trace"]), result["iterations"] + 1)
                # The variation of the polished points. The trace ends before the polish.
                self.assertNotEqual(result["trace"][-1]["variation"], result["variation"])
                draft = self.halftone(CHELSEA, "?sites=700&format=json&quality=draft").json()
                self.assertEqual(draft["trace"][-1]["variation"], draft["variation"])

    def test_format_takes_precedence_over_accept(self):
        answer = self.ask("/halftone?sites=10&format=png", "--header", "Accept: application/json", data=CAMERA)
        self.assertEqual(answer.type, "image/png")

    def test_points_are_denser_where_the_picture_is_dark(self):
        picture = flat(250, 100, 100)
        picture[:50] = 40
        points = numpy.array(self.halftone(file_of(picture), "?sites=1000&format=json").json()["points"])
        self.assertGreater((points[:, 1] < 50).mean(), 0.9)


class Options(ServerCase):
    def picture(self, query, data=CAMERA):
        return self.halftone(data, query).picture()

    def test_scale_sets_the_size(self):
        for scale, side in ((0.5, 256), (1, 512), (2.5, 1280)):
            with self.subTest(scale=scale):
                self.assertEqual(self.picture(f"?sites=200&scale={scale}").shape, (side, side))

    def test_dot_sets_the_radius(self):
        small, large = (self.picture(f"?sites=300&scale=2&dots=ink&dot={dot}") for dot in (2, 4))
        self.assertGreater(large.size - large.sum(), 3 * (small.size - small.sum()))

    def test_dot_auto_is_the_default(self):
        self.assertEqual(self.halftone(CAMERA, "?sites=300&dot=auto").body, self.halftone(CAMERA, "?sites=300").body)

    def test_antialias_makes_grey_levels(self):
        levels = numpy.unique(self.picture("?sites=300&scale=2&antialias=true"))
        self.assertGreater(len(levels), 10)
        self.assertEqual(len(numpy.unique(self.picture("?sites=300&scale=2&antialias=false"))), 2)

    def test_invert_draws_light_dots_on_black(self):
        picture = self.picture("?sites=300&scale=2&invert=true", file_of(flat(30)))
        self.assertAlmostEqual(picture.mean(), linear(30), delta=0.01)
        self.assertEqual(picture[0, 0], 0)

    def test_perceptual_tone_is_lighter_than_linear(self):
        data = file_of(flat(128))
        linear_tone, perceptual = (self.picture(f"?sites=300&scale=4&tone={tone}", data).mean()
                                   for tone in ("linear", "perceptual"))
        self.assertAlmostEqual(linear_tone, linear(128), delta=0.01)
        self.assertGreater(perceptual, linear_tone + 0.2)

    def test_colours(self):
        answer = self.halftone(CAMERA, "?sites=300&scale=4&foreground=%23f00&background=%230000ff")
        self.assertEqual(colours(answer.picture("RGB")), {(255, 0, 0), (0, 0, 255)})

    def test_partly_transparent_pixels_look_as_in_viewers(self):
        shadow = io.BytesIO()
        Image.fromarray(numpy.full((60, 60, 4), (0, 0, 0, 127), numpy.uint8)).save(shadow, "PNG")
        white = io.BytesIO()
        Image.fromarray(numpy.full((60, 60, 4), (255, 255, 255, 127), numpy.uint8)).save(white, "PNG")
        viewed = 1 - linear(128)  # share of ink for half-transparent black on white
        for file, query, ink in ((shadow, "dots=ink", viewed), (shadow, "alpha=linear&dots=ink", 127 / 255),
                                 (shadow, "dots=both", viewed), (shadow, "color=cmyk&dots=ink", viewed),
                                 (white, "dots=paper", 1 - linear(127)), (white, "color=rgb&dots=ink", 1 - linear(127)),
                                 (white, "alpha=linear&dots=paper", 128 / 255)):
            with self.subTest(query):
                answer = self.halftone(file.getvalue(), f"?sites=500&scale=8&{query}")
                light = numpy.vectorize(linear)(numpy.arange(256))[answer.picture("RGB")].mean()
                self.assertAlmostEqual(1 - light, ink, delta=0.02)

    def test_transparent_background(self):
        answer = self.halftone(CAMERA, "?sites=300&scale=4&background=transparent")
        alpha = answer.picture("RGBA")[:, :, 3]
        self.assertEqual(set(numpy.unique(alpha)), {0, 255})

    def test_iterations_and_passes(self):
        bodies = {self.halftone(CAMERA, f"?sites=300&{query}").body
                  for query in ("iterations=0", "iterations=1", "iterations=1&passes=1", "iterations=9")}
        self.assertEqual(len(bodies), 4)

    def test_quality(self):
        for dots, different in (("ink", 3), ("both", 2)):
            bodies = [self.halftone(CAMERA, f"?sites=300&dots={dots}{query}").body
                      for query in ("", "&quality=standard", "&quality=draft", "&quality=best")]
            self.assertEqual(bodies[0], bodies[1])
            self.assertEqual(bodies[1] == bodies[2], dots == "both")
            self.assertEqual(len(set(bodies)), different)

    def test_no_iterations_return_the_start(self):
        result = self.halftone(CAMERA, "?sites=300&iterations=0&format=json").json()
        self.assertEqual(result["iterations"], 0)
        self.assertEqual(len(result["trace"]), 1)

    def test_number_of_sites_follows_from_the_ink(self):
        dark, light = (len(self.halftone(file_of(flat(level, 200, 200)), "?format=json").json()["points"])
                       for level in (40, 220))
        self.assertGreater(dark, light)

    def test_number_of_sites_follows_from_the_minority_of_ink_and_paper(self):
        shares = {level: min(linear(level), 1 - linear(level)) * 400 * 400 for level in (40, 140, 220)}
        for level, minority in shares.items():
            dots = self.halftone(file_of(flat(level, 400, 400)), "?format=json&dots=both&quality=draft").json()
            self.assertEqual(dots["sites"], int(min(max(minority / 8, 4096), minority)))

    def test_smallest_pictures_and_numbers(self):
        self.assertEqual(len(self.halftone(file_of(flat(0, 1, 1)), "?sites=1&format=json").json()["points"]), 1)
        self.assertEqual(self.halftone(file_of(flat(0, 300, 1)), "?sites=40&scale=3").picture().shape, (3, 900))
        self.assertEqual(len(self.halftone(CAMERA, "?sites=1&format=json").json()["points"]), 1)


class Tone(ServerCase):
    def test_flat_greys_keep_their_luminance(self):
        for black in range(5, 95, 5):
            wanted = 1 - black / 100
            level = min(range(256), key=lambda grey: abs(linear(grey) - wanted))
            for query in ("?sites=2000&scale=4", "?sites=2000&scale=4&antialias=true"):
                with self.subTest(black=black, query=query):
                    picture = self.halftone(file_of(flat(level, 128, 128)), query).picture()
                    # Coverage is in linear light, also where an antialiased edge is stored as a grey level.
                    shades = picture if picture.dtype == bool else numpy.vectorize(linear)(numpy.arange(256))[picture]
                    self.assertAlmostEqual(shades.mean(), linear(level), delta=0.005)

    def test_photographs_keep_their_mean_luminance(self):
        wanted = numpy.vectorize(linear)(numpy.arange(256))[pixels(CAMERA, "L")].mean()
        for query in ("?antialias=true", "?scale=2"):
            seen = numpy.vectorize(linear)(numpy.arange(256))[pixels(self.halftone(CAMERA, query).body, "L")]
            self.assertLess(abs(seen.mean() / wanted - 1), 0.01, query)


if __name__ == "__main__":
    unittest.main(verbosity=2)
