# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures in the pixels and colours of a device: electronic paper, label printers."""

import io
import unittest

import numpy
from PIL import Image, ImageDraw
from scipy.ndimage import gaussian_filter

from harness import PICTURES, ServerCase, data_uri, execute, file_of, flat, linear, pixels, post_json
from seen import LIGHT, blurred, lightness

ASTRONAUT = (PICTURES / "astronaut.png").read_bytes()
CAMERA = (PICTURES / "camera.png").read_bytes()

COLOURS = {
    "1bit": 2, "gray4": 4, "gray16": 16, "bwr": 3, "bwy": 3, "spectra6": 6, "acep7": 7}
SPECTRA6 = [(0, 0, 0), (255, 255, 255), (255, 255, 0), (255, 0, 0), (0, 0, 255), (0, 255, 0)]


def opened(answer):
    image = Image.open(io.BytesIO(answer.body))
    image.load()
    return image


def colours_of(image):
    return {tuple(colour) for colour in numpy.asarray(image.convert("RGB")).reshape(-1, 3)}


def unpacked(body, width, height, bits):
    """Returns the pixel values of packed rows."""
    rows = numpy.frombuffer(body, numpy.uint8).reshape(height, -1)
    shifts = numpy.arange(8 - bits, -1, -bits)
    values = rows[:, :, None] >> shifts & (1 << bits) - 1
    return values.reshape(height, -1)[:, :width]


def printed(dark, diameter):
    """Returns the share of each pixel's square that spots of the dark pixels cover, by samples in the squares."""
    height, width = dark.shape
    framed = numpy.pad(dark, 1)
    places = (numpy.arange(24) + 0.5) / 24 - 0.5
    shares = numpy.zeros(dark.shape)
    for down in places:
        for right in places:
            covered = numpy.zeros(dark.shape, bool)
            for y, x in numpy.ndindex(3, 3):
                if numpy.hypot(down - (y - 1), right - (x - 1)) <= diameter / 2:
                    covered |= framed[y:y + height, x:x + width]
            shares += covered
    return shares / len(places) ** 2


class Devices(ServerCase):
    def test_each_device_gets_its_size_and_colours_only(self):
        for device, count in COLOURS.items():
            with self.subTest(device):
                image = opened(self.halftone(ASTRONAUT, f"?device={device}&width=120&height=90&fit=cover"))
                self.assertEqual(image.size, (120, 90))
                self.assertLessEqual(len(colours_of(image)), count)
        image = opened(self.halftone(ASTRONAUT, "?device=spectra6&width=120&height=90"))
        self.assertLessEqual(colours_of(image), set(SPECTRA6))

    def test_png_has_as_few_bits_as_the_device(self):
        for device, bits in (("1bit", 1), ("gray4", 2), ("gray16", 4), ("bwr", 2), ("spectra6", 4)):
            answer = self.halftone(CAMERA, f"?device={device}&width=64&height=48&fit=cover")
            self.assertEqual(answer.body[24], bits, device)

    def test_imagemagick_reads_the_same_pixels_as_pillow(self):
        for device in COLOURS:
            for form in ("png", "bmp"):
                with self.subTest(device=device, format=form):
                    answer = self.halftone(ASTRONAUT, f"?device={device}&width=61&height=47&fit=cover&format={form}")
                    read = execute(["convert", f"{form}:-", "-depth", "8", "rgb:-"], input=answer.body,
                                   capture_output=True, check=True)
                    seen = numpy.frombuffer(read.stdout, numpy.uint8).reshape(47, 61, 3)
                    numpy.testing.assert_array_equal(seen, numpy.asarray(opened(answer).convert("RGB")))

    def test_palette_of_a_custom_device_keeps_its_order(self):
        answer = self.halftone(ASTRONAUT, "?device=custom&palette=%23ffffff,%23000000,%23e02020&width=50&format=raw")
        values = unpacked(answer.body, 50, 50, 2)
        self.assertLessEqual(values.max(), 2)
        image = opened(self.halftone(ASTRONAUT, "?device=custom&palette=%23ffffff,%23000000,%23e02020&width=50"))
        self.assertEqual(image.getpalette()[:9], [255, 255, 255, 0, 0, 0, 224, 32, 32])
        numpy.testing.assert_array_equal(numpy.asarray(image), values)

    def test_flat_greys_keep_their_luminance(self):
        for level in (30, 90, 128, 188, 240):
            seen = pixels(self.halftone(file_of(flat(level, 96, 96)), "?device=1bit").body, "L") / 255
            self.assertAlmostEqual(seen.mean(), linear(level), delta=0.004, msg=level)

    def test_photograph_looks_like_the_original(self):
        picture = pixels(CAMERA, "L") / 255
        picture = numpy.where(picture <= 0.04045, picture / 12.92, ((picture + 0.055) / 1.055) ** 2.4)
        drawn = pixels(self.halftone(CAMERA, "?device=1bit").body, "L") / 255.0
        error = gaussian_filter(drawn - picture, 1.5)
        self.assertGreater(-10 * numpy.log10((error ** 2).mean()), 39.5)  # Floyd and Steinberg: 36.7 dB

    def test_printed_spots_have_the_tones_of_the_picture(self):
        for name, picture in (("camera", CAMERA), ("astronaut", ASTRONAUT)):
            wanted = LIGHT[pixels(picture, "RGB")] @ (0.2126, 0.7152, 0.0722)
            for spot in (1.5, 2):
                dark = pixels(self.halftone(picture, f"?device=1bit&spot={spot}").body, "L") == 0
                seen = 1 - printed(dark, spot)
                error = numpy.abs(lightness(blurred(seen, 3)) - lightness(blurred(wanted, 3))).mean()
                self.assertLess(error, 0.5, f"{name} {spot}")
            dark = pixels(self.halftone(picture, "?device=1bit").body, "L") == 0
            uncorrected = 1 - printed(dark, 1.5)
            error = numpy.abs(lightness(blurred(uncorrected, 3)) - lightness(blurred(wanted, 3))).mean()
            self.assertGreater(error, 5, name)

    def test_large_spots_make_no_chessboard_of_a_middle_grey(self):
        def share_of_chessboard(query):
            black = pixels(self.halftone(file_of(flat(188, 96, 96)), "?device=1bit" + query).body, "L") == 0
            across, down = black[:, 1:] != black[:, :-1], black[1:] != black[:-1]
            return (across[1:-1, 1:] & across[1:-1, :-1] & down[1:, 1:-1] & down[:-1, 1:-1]).mean()

        self.assertGreater(share_of_chessboard(""), 0.6)
        for spot in (1.4, 1.5, 2):
            self.assertLess(share_of_chessboard(f"&spot={spot}"), 0.3, spot)

    def test_spots_of_custom_colours_are_those_of_the_darker_colour(self):
        query = "?device=custom&width=90&spot=1.5&palette="
        one = pixels(self.halftone(CAMERA, query + "%23fff,%23024").body, "RGB")
        other = pixels(self.halftone(CAMERA, query + "%23024,%23fff").body, "RGB")
        numpy.testing.assert_array_equal(one, other)

    def test_exact_colours_stay_untouched(self):
        picture = Image.new("RGB", (160, 60), "white")
        draw = ImageDraw.Draw(picture)
        draw.rectangle((60, 0, 110, 60), fill=(255, 0, 0))
        draw.text((4, 4), "Text", fill="black")
        draw.line((0, 30, 160, 40), fill=(0, 0, 255))
        for x in range(110, 160):
            draw.line((x, 0, x, 25), fill=(x, 200, 100))
        original = numpy.asarray(picture)
        answer = opened(self.halftone(file_of(original), "?device=spectra6"))
        exact = numpy.isin(original, (0, 255)).all(-1) & ~((original == (0, 255, 255)).all(-1))
        numpy.testing.assert_array_equal(numpy.asarray(answer.convert("RGB"))[exact], original[exact])

    def test_picture_is_fitted_turned_and_framed(self):
        picture = numpy.zeros((20, 40), numpy.uint8)
        picture[:, 20:] = 255  # black on the left, white on the right
        turned = pixels(self.halftone(file_of(picture), "?device=1bit&rotate=90").body, "L")
        self.assertEqual(turned.shape, (40, 20))
        self.assertTrue((turned[:20] == 0).all() and (turned[20:] == 255).all())
        framed = pixels(self.halftone(file_of(picture), "?device=1bit&width=40&height=40&background=%23000").body, "L")
        self.assertTrue((framed[:10] == 0).all() and (framed[30:] == 0).all())
        self.assertTrue((framed[10:30, 20:] == 255).all())
        covered = pixels(self.halftone(file_of(picture), "?device=1bit&width=10&height=10&fit=cover").body, "L")
        self.assertTrue((covered[:, :5] == 0).all() and (covered[:, 5:] == 255).all())

    def test_transparency_looks_as_in_viewers(self):
        colour = numpy.full((60, 60, 4), (0, 0, 0, 127), numpy.uint8)
        grey = numpy.full((60, 60, 2), (0, 127), numpy.uint8)
        for name, picture in (("colour", colour), ("grey", grey)):
            file = io.BytesIO()
            Image.fromarray(picture).save(file, "PNG")
            # The ground is white, light red, and black.
            for query, seen in (("", (128, 128, 128)), ("&background=%23f88", (128, 68, 68)), ("&background=%23000", (0, 0, 0)),
                                ("&alpha=linear", (188, 188, 188)), ("&alpha=linear&background=%23f88", (188, 100, 100))):
                with self.subTest(name=name, query=query):
                    palette = "%23000,%23f00,%230f0,%2300f,%23ff0,%23f0f,%230ff,%23fff"
                    answer = self.halftone(file.getvalue(), f"?device=custom&palette={palette}{query}")
                    light = LIGHT[numpy.asarray(opened(answer).convert("RGB"))].mean((0, 1))
                    for found, value in zip(light, seen, strict=True):
                        self.assertAlmostEqual(found, LIGHT[value], delta=0.01)

    def test_formats_hold_the_same_pixels(self):
        for device, bits in (("1bit", 1), ("gray4", 2), ("spectra6", 4)):
            query = f"?device={device}&width=61&height=47&fit=cover"
            png = pixels(self.halftone(ASTRONAUT, query).body, "RGB")
            bmp = pixels(self.halftone(ASTRONAUT, query + "&format=bmp").body, "RGB")
            numpy.testing.assert_array_equal(bmp, png)
            raw = self.halftone(ASTRONAUT, query + "&format=raw").body
            values = unpacked(raw, 61, 47, bits)
            colours = {tuple(colour): value for colour, value in zip(png.reshape(-1, 3), values.ravel())}
            self.assertEqual([[colours[tuple(colour)] for colour in row] for row in png], values.tolist())
            flipped = self.halftone(ASTRONAUT, query + "&format=raw&invert_bits=true").body
            self.assertEqual(bytes(255 - byte for byte in raw), flipped)
            reverse = self.halftone(ASTRONAUT, query + "&format=raw&bit_order=lsb").body
            mask = (1 << bits) - 1
            swapped = [sum((byte >> shift & mask) << 8 - bits - shift for shift in range(0, 8, bits)) for byte in raw]
            self.assertEqual(bytes(swapped), reverse)

    def test_receipt_printers_get_bands_of_dark_pixels(self):
        picture = file_of(numpy.where(numpy.arange(300)[:, None] % 7 + numpy.arange(44) % 5 > 5, 255, 0))
        body = self.halftone(picture, "?device=1bit&format=escpos").body
        self.assertTrue(body.startswith(b"\x1b@"))
        place, rows = 2, []
        while place < len(body):
            self.assertEqual(body[place:place + 4], b"\x1dv0\0")
            width, height = (int.from_bytes(body[place + 4 + i:place + 6 + i], "little") for i in (0, 2))
            self.assertLess(height, 256, "some printers read only the low byte")
            rows.append(unpacked(body[place + 8:place + 8 + width * height], 44, height, 1))
            place += 8 + width * height
        numpy.testing.assert_array_equal(numpy.concatenate(rows) == 0, pixels(picture) == 255)

    def test_json_requests_have_the_same_answers(self):
        answer = post_json(self.server, "/halftone", {"image": data_uri(CAMERA), "device": "gray4", "width": 40})
        self.assertEqual(answer.body, self.halftone(CAMERA, "?device=gray4&width=40").body)

    def test_smallest_pictures(self):
        for query in ("?device=1bit", "?device=acep7&width=1&height=1", "?device=spectra6&width=3000&height=1",
                      "?device=gray16&width=1&height=500&fit=cover&rotate=270"):
            self.halftone(file_of(flat(90, 1, 1)), query)

    def test_bad_requests_name_the_option_and_the_limit(self):
        for query, words in (
                ("device=epaper", ("device", "spectra6")),
                ("device=1bit&sites=100", ("sites", "device")),
                ("device=1bit&palette=%23000,%23fff", ("palette", "custom")),
                ("device=custom", ("palette",)),
                ("device=custom&palette=%23000", ("palette", "2 to 16")),
                ("device=custom&palette=%23000,%23000000", ("palette", "repeats")),
                ("device=1bit&width=0", ("width", "65535")),
                ("device=1bit&rotate=45", ("rotate", "90")),
                ("device=1bit&fit=cover&width=10", ("fit", "height")),
                ("device=1bit&format=svg", ("format", "escpos")),
                ("device=1bit&bit_order=lsb", ("bit_order", "raw")),
                ("device=bwr&spot=1.5", ("spot", "two colours")),
                ("device=1bit&spot=2.5", ("spot", "2")),
                ("device=bwr&format=escpos", ("format", "two colours"))):
            with self.subTest(query):
                self.assert_problem(self.ask("/halftone?" + query, data=CAMERA), 400, *words)
        answer = self.ask("/halftone?device=1bit&width=65535&height=65535", data=CAMERA)
        self.assert_problem(answer, 413, "width", "max-pixels")


if __name__ == "__main__":
    unittest.main()
