# SPDX-License-Identifier: GPL-3.0-or-later
"""POST /halftone: real pictures, with colour profiles and in every supported format."""

import io
import json
import struct
import unittest
import zlib

import numpy
from PIL import Image, ImageCms

import profiles
from harness import ROOT, ServerCase, data_uri, file_of, linear, post_json

FIXTURES = ROOT / "tests" / "api" / "data"
P3 = profiles.rgb_profile(profiles.DISPLAY_P3, profiles.srgb_to_linear)
ADOBE_RGB = profiles.rgb_profile(profiles.ADOBE_RGB, 563 / 256)
SRGB = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
QUERY = "?sites=2000&iterations=2&scale=4&antialias=true"


def patch(mode, colour, size=64):
    return Image.new(mode, (size, size), colour)


def saved(picture, kind, profile=None, **options):
    file = io.BytesIO()
    picture.save(file, kind, icc_profile=profile, **options)
    return file.getvalue()


def luminance_by_oracle(picture, profile):
    """Returns the luminance after Pillow's conversion to sRGB by the profile, relative to white."""
    source = ImageCms.ImageCmsProfile(io.BytesIO(profile))
    to = ImageCms.createProfile("sRGB")
    seen = ImageCms.profileToProfile(picture, source, to, renderingIntent=1, outputMode="RGB")
    light = profiles.srgb_to_linear(numpy.asarray(seen) / 255.0)
    return float((light @ profiles.WEIGHTS).mean())


class Profiles(ServerCase):
    def paper(self, file):
        """Returns the share of paper between the dots, which is the mean luminance of the picture."""
        return float(profiles.srgb_to_linear(self.halftone(file, QUERY).picture("L") / 255.0).mean())

    def check(self, picture, profile, kinds):
        expected = luminance_by_oracle(picture, profile)
        for kind, options in kinds:
            with self.subTest(kind=kind, mode=picture.mode):
                self.assertAlmostEqual(self.paper(saved(picture, kind, profile, **options)), expected, delta=0.02)

    def test_display_p3(self):
        picture = patch("RGB", (90, 190, 70))
        self.check(picture, P3, (("PNG", {}), ("JPEG", {"quality": 95}), ("WEBP", {"lossless": True}), ("TIFF", {})))

    def test_adobe_rgb(self):
        self.check(patch("RGB", (60, 160, 110)), ADOBE_RGB, (("PNG", {}), ("JPEG", {"quality": 95}), ("TIFF", {})))

    def test_grey(self):
        for gamma in (1.0, 1.8):
            self.check(patch("L", 140), profiles.grey_profile(gamma), (("PNG", {}), ("JPEG", {}), ("TIFF", {})))

    def test_cmyk(self):
        profile = profiles.ink_profile(9)
        for colour in ((120, 40, 10, 20), (0, 0, 0, 128), (20, 140, 180, 0)):
            self.check(patch("CMYK", colour), profile, (("JPEG", {"quality": 95}), ("TIFF", {})))

    def test_rgb_tables(self):
        profile = profiles.table_profile(lambda shares: shares ** 1.5)
        self.check(patch("RGB", (120, 90, 60)), profile, (("PNG", {}), ("TIFF", {})))

    def test_colours_outside_srgb_keep_their_luminance(self):
        for colour in ((0, 255, 0), (255, 60, 0)):
            with self.subTest(colour=colour):
                light = profiles.to_srgb_light(profiles.srgb_to_linear(numpy.array(colour) / 255), profiles.DISPLAY_P3)
                self.assertLess(light.min(), 0)
                self.assertAlmostEqual(self.paper(saved(patch("RGB", colour), "PNG", P3)),
                                       float(light @ profiles.WEIGHTS), delta=0.02)

    def test_srgb_changes_nothing(self):
        picture = Image.open(ROOT / "tests" / "data" / "images" / "chelsea.png").convert("RGB")
        for kind in ("PNG", "JPEG", "TIFF", "WEBP"):
            for color in ("", "&color=cmyk"):
                with self.subTest(kind=kind, color=color):
                    query = "?sites=500&iterations=1" + color
                    self.assertEqual(self.halftone(saved(picture, kind, SRGB), query).body,
                                     self.halftone(saved(picture, kind), query).body)

    def test_broken_profiles_are_ignored(self):
        picture = patch("RGB", (90, 190, 70))
        for kind in ("PNG", "JPEG", "TIFF", "WEBP"):
            expected = self.halftone(saved(picture, kind), QUERY).body
            for broken in (b"no profile", P3[:200], P3[:-1], P3.replace(b"rTRC", b"none"), bytes(3000)):
                with self.subTest(kind=kind, size=len(broken)):
                    self.assertEqual(self.halftone(saved(picture, kind, broken), QUERY).body, expected)

    def test_invalid_offsets_do_not_crash_the_decoder(self):
        for path in sorted(FIXTURES.glob("profile-beyond.*")):
            with self.subTest(name=path.name):
                self.assertEqual(self.ask("/halftone" + QUERY, data=path.read_bytes()).status, 200)
        self.assertNotIn("crash", self.server.log())

    def test_large_profiles_fit_into_the_memory_of_the_decoder(self):
        profile = profiles.ink_profile(28)
        self.assertGreater(len(profile), 3 << 20)
        self.check(patch("CMYK", (120, 40, 10, 20)), profile, (("JPEG", {"quality": 95}), ("TIFF", {})))


class Formats(ServerCase):
    def test_all_lossless_ones_give_the_same_bytes(self):
        picture = Image.open(ROOT / "tests" / "data" / "images" / "camera.png").convert("L").resize((200, 200))
        colours = picture.convert("RGB")
        expected = self.halftone(saved(colours, "PNG"), QUERY).body
        for kind, same in (("GIF", picture), ("BMP", picture), ("BMP", colours), ("TIFF", colours)):
            with self.subTest(kind=kind, mode=same.mode):
                self.assertEqual(self.halftone(saved(same, kind), QUERY).body, expected)

    def test_lossless_avifs_give_the_same_bytes(self):
        originals = {name: (FIXTURES / f"{name}.png").read_bytes() for name in ("rgba", "p3")}
        originals["noise"] = saved(Image.open(FIXTURES / "noise.png").convert("RGB"), "PNG")
        originals["film"] = (FIXTURES / "lossless.webp").read_bytes()
        for name, original in originals.items():
            for color in ("gray", "rgb"):
                with self.subTest(name=name, color=color):
                    query = f"{QUERY}&color={color}"
                    self.assertEqual(self.halftone((FIXTURES / f"{name}.avif").read_bytes(), query).body,
                                     self.halftone(original, query).body)

    def test_avifs_and_heics_of_every_kind_are_decoded_in_confinement(self):
        query = "?sites=100&iterations=0&scale=1"
        refused = {"bomb.avif": 413, "bomb.heic": 413, "track.heic": 422}
        for path in sorted((*FIXTURES.glob("*.avif"), *FIXTURES.glob("*.heic"))):
            with self.subTest(name=path.name):
                self.assertEqual(self.ask("/halftone" + query, data=path.read_bytes()).status,
                                 refused.get(path.name, 200))
        self.assertNotIn("crash", self.server.log())

    def test_tiffs_of_every_kind_are_decoded_in_confinement(self):
        refused = {"signed.tif": "8-bit signed grey", "thumbnail.tif": "thumbnail"}
        for path in sorted((ROOT / "tests" / "fuzz" / "seeds" / "image").glob("*.tif")):
            with self.subTest(name=path.name):
                answer = self.ask("/halftone?sites=100&iterations=0&scale=1", data=path.read_bytes())
                if path.name in refused:
                    self.assert_problem(answer, 422, refused[path.name])
                else:
                    self.assertEqual(answer.status, 200)
        self.assertNotIn("crash", self.server.log())

    def test_broken_avifs_and_heics_are_refused(self):
        for name in ("tiles.avif", "tiles.heic"):
            file = (FIXTURES / name).read_bytes()
            for size in (40, 300, len(file) // 2, len(file) - 1):
                with self.subTest(name=name, size=size):
                    self.assert_problem(self.ask("/halftone", data=file[:size]), 422, "broken or truncated")

    def test_main_picture_of_a_heic_is_read(self):
        original = self.halftone((FIXTURES / "lossless.webp").read_bytes(), QUERY).body
        for name in ("lossless.heic", "orientation-6.heic", "gain-map.heic", "film.heic"):
            with self.subTest(name=name):
                answer = self.halftone((FIXTURES / name).read_bytes(), QUERY)
                self.assertEqual(answer.body, original)
                self.assertEqual("x-warnings" in answer.headers, name == "film.heic")
        self.assert_problem(self.ask("/halftone", data=(FIXTURES / "track.heic").read_bytes()), 422, "image sequence")

    def test_high_dynamic_range_is_compressed(self):
        """White of 203 cd/m2 and the peak of 1,000 cd/m2, in PQ and HLG, are L* 77 and 100."""
        def described(value, transfer):
            file = saved(Image.new("RGB", (24, 24), (value,) * 3), "PNG")
            chunk = b"cICP" + bytes((9, transfer, 0, 1))
            start = file.index(b"IDAT") - 4
            return file[:start] + struct.pack(">I", 4) + chunk + struct.pack(">I", zlib.crc32(chunk)) + file[start:]
        for value, transfer, seen in ((148, 16, 192), (191, 18, 192), (191, 16, 254), (0, 16, 0), (255, 18, 255)):
            with self.subTest(value=value, transfer=transfer):
                answer = self.halftone(described(value, transfer), "?device=1bit")
                self.assertAlmostEqual(answer.picture("L").mean() / 255, linear(seen), delta=0.02)

    def test_files_without_line_ends_get_a_hint(self):
        for name in ("grey.jpg", "palette.png", "lossy.webp", "lzw.tif", "noise.gif", "rgb.bmp", "rgba.avif", "lossless.heic"):
            with self.subTest(name=name):
                file = (FIXTURES / name).read_bytes().translate(None, b"\0\r\n")  # as curl -d reads it
                answer = self.ask("/halftone", "-H", "Content-Type: application/x-www-form-urlencoded", data=file)
                self.assert_problem(answer, 415, "--data-binary")

    def test_first_frame_of_an_animation_is_read(self):
        first, second = patch("L", 200), patch("L", 20)
        expected = self.halftone(saved(first, "GIF"), QUERY).body
        self.assertEqual(self.halftone(saved(first, "GIF", save_all=True, append_images=[second]), QUERY).body, expected)

    def test_frame_that_is_read_is_reported(self):
        frames = [patch("RGB", (level, level, 90)) for level in (200, 20, 90)]
        of_an_animation = "the file has 3 frames: the first is used"
        for kind, warning in (("GIF", of_an_animation), ("WEBP", of_an_animation),
                           ("PNG", "the file has 3 frames: the main picture is used"),
                           ("TIFF", "the file has 3 pages: the first is used")):
            with self.subTest(kind=kind):
                file = saved(frames[0], kind, save_all=True, append_images=frames[1:])
                self.assertEqual(json.loads(self.halftone(file, QUERY).headers["x-warnings"]),
                                 [{"pointer": "", "detail": warning}])
                for color in ("gray", "cmyk"):
                    answer = post_json(self.server, "/halftone",
                                       {"image": data_uri(file), "sites": 9, "color": color, "format": "json"})
                    self.assertNotIn("x-warnings", answer.headers)
                    self.assertEqual(answer.json()["warnings"], [{"pointer": "/image", "detail": warning}])
        for kind in ("GIF", "WEBP", "PNG", "TIFF", "JPEG", "BMP"):
            self.assertNotIn("x-warnings", self.halftone(saved(frames[0], kind), QUERY).headers)

    def test_sixteen_bits_are_kept(self):
        """Values that differ by half an eight-bit step must be distinguished."""
        ramp = numpy.linspace(128.0, 128.5, 64 * 64).reshape(64, 64)
        fine = Image.fromarray(numpy.rint(ramp * 257).astype(numpy.uint16))
        coarse = file_of(numpy.floor(ramp))
        for kind in ("PNG", "TIFF"):
            with self.subTest(kind=kind):
                self.assertNotEqual(self.halftone(saved(fine, kind), "?sites=500&format=json").json()["points"],
                                    self.halftone(coarse, "?sites=500&format=json").json()["points"])

    def test_unsupported_ones_are_refused_by_name(self):
        for file, name in ((b"\xff\x0a\x12\x34", "JPEG XL"), (b"%PDF-1.7\n", "PDF")):
            with self.subTest(name=name):
                self.assert_problem(self.ask("/halftone", data=file), 415, f"this is {name}",
                                    "the supported formats are PNG, JPEG, WebP, TIFF, GIF, BMP, AVIF and HEIC")

    def test_oversized_pictures_are_refused_by_their_header(self):
        for name in ("bomb.gif", "bomb.bmp", "bomb.avif", "bomb.heic"):
            with self.subTest(name=name):
                self.assert_problem(self.ask("/halftone", data=(FIXTURES / name).read_bytes()), 413, "max-pixels")


if __name__ == "__main__":
    unittest.main()
