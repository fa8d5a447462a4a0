# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets with an exact number of pixels, such as masks of samples in k-space for magnetic resonance imaging."""

import io
import unittest

import numpy
from PIL import Image

from harness import Server, ServerCase, data_uri, file_of, post_json


def domain(width, height):
    return {"type": "pixels", "width": width, "height": height}


def falling(side):
    """Returns a density that falls with the distance from the centre."""
    y, x = numpy.mgrid[:side, :side] - (side - 1) / 2
    values = numpy.maximum(0, 1 - numpy.hypot(x, y) / (0.72 * side)) ** 2
    return {"width": side, "height": side, "values": values.ravel().tolist()}


def calibrated(mask, side):
    """Returns the block of a mask that a calibration of this side has, for an even side and an even mask."""
    rows, columns = (slice(length // 2 - side // 2, length // 2 + side // 2) for length in mask.shape)
    return mask[rows, columns]


class Pixels(ServerCase):
    def sample(self, body, status=200):
        answer = post_json(self.server, "/sample", body)
        self.assertEqual(answer.status, status, answer)
        return answer

    def mask(self, width, height, sites, **members):
        body = {"sites": sites, "domain": domain(width, height), "format": "npy", **members}
        mask = numpy.load(io.BytesIO(self.sample(body).body))
        self.assertEqual((mask.dtype, mask.shape), (bool, (height, width)))
        self.assertEqual(int(mask.sum()), sites)
        return mask

    def test_accelerations_are_exact(self):
        for width, height in ((128, 128), (230, 180)):
            for acceleration in (2, 3, 4, 6, 8, 10):
                for density in ({}, {"density": falling(32)}):
                    for calibration in ({}, {"calibration": {"width": 24, "height": 24}}):
                        with self.subTest(width=width, acceleration=acceleration, **calibration):
                            sites = round(width * height / acceleration)
                            mask = self.mask(width, height, sites, **density, **calibration)
                            if calibration:
                                self.assertTrue(calibrated(mask, 24).all())

    def test_all_formats_have_the_same_pixels(self):
        body = {"sites": 900, "seed": 4, "domain": domain(90, 70), "density": falling(16)}
        mask = self.mask(90, 70, 900, seed=4, density=falling(16))
        image = Image.open(io.BytesIO(self.sample({**body, "format": "png"}).body))
        self.assertEqual((image.mode, image.size), ("1", (90, 70)))
        numpy.testing.assert_array_equal(numpy.array(image), mask)
        pixels = numpy.argwhere(mask)[:, ::-1].tolist()
        self.assertEqual(self.sample(body).json(), {"points": pixels, "sites": 900, "seed": 4, "width": 90, "height": 70})
        table = numpy.loadtxt(io.BytesIO(self.sample({**body, "format": "csv"}).body), delimiter=",", skiprows=1)
        numpy.testing.assert_array_equal(table, pixels)

    def test_lists_that_are_streamed_are_complete(self):
        answer = self.sample({"sites": 900_000, "domain": domain(1200, 1000)})
        self.assertEqual(answer.headers.get("transfer-encoding"), "chunked")
        self.assertEqual(len({tuple(pixel) for pixel in answer.json()["points"]}), 900_000)
        self.mask(2500, 2000, 1_000_000)

    def test_sets_have_more_pixels_than_points_may_be(self):
        with Server("--max-sites=100", "--max-pixels=10000") as server:
            self.assertEqual(post_json(server, "/sample", {"sites": 5000, "domain": domain(100, 100)}).status, 200)
            refused = post_json(server, "/sample", {"sites": 5000, "domain": domain(100, 101)})
            self.assertEqual(refused.status, 413)
            self.assertIn("100 x 101 pixels; this server's limit (max-pixels) is 10000", refused.json()["detail"])

    def test_included_pixels_are_in_the_set(self):
        mask = self.mask(64, 48, 700, include=[[0, 0], [63, 47], {"y": 5, "height": 2}, {"x": 60}])
        self.assertTrue(mask[0, 0] and mask[47, 63] and mask[5:7].all() and mask[:, 60:].all())
        self.assertFalse(mask[4].all())
        rows = self.mask(64, 48, 700, calibration={"height": 8})
        self.assertTrue(rows[20:28].all())
        self.assertFalse(rows[19].all() or rows[28].all())

    def test_density_decides_where_pixels_are(self):
        mask = self.mask(100, 100, 2000, density={"width": 4, "height": 1, "values": [0, 1, 2, 5]})
        self.assertEqual(mask[:, :25].sum(), 0)
        for left, share in ((25, 1 / 8), (50, 2 / 8), (75, 5 / 8)):
            self.assertAlmostEqual(mask[:, left:left + 25].sum() / 2000, share, delta=0.01)
        picture = file_of(numpy.repeat([[255, 0]], 20, axis=0).T)  # dark below
        below = self.mask(100, 100, 5000, density={"image": data_uri(picture)})
        self.assertTrue(below[50:].all())

    def test_dense_parts_are_full_and_the_rest_takes_what_is_left(self):
        mask = self.mask(100, 100, 3000, density={"width": 2, "height": 2, "values": [100, 1, 1, 1]})
        self.assertTrue(mask[:50, :50].all())
        for part in (mask[:50, 50:], mask[50:, :50], mask[50:, 50:]):
            self.assertAlmostEqual(part.sum(), 500 / 3, delta=12)

    def test_pixels_are_spread_evenly(self):
        side = 256
        for acceleration, most in ((4, 0.12), (8, 0.08)):
            residual = self.mask(side, side, side * side // acceleration) - 1 / acceleration
            power = abs(numpy.fft.fft2(residual)) ** 2 / (residual ** 2).sum()
            frequency = numpy.hypot(*numpy.meshgrid(*(numpy.fft.fftfreq(side),) * 2))
            low = power[(frequency > 0) & (frequency < 0.5 / acceleration ** 0.5)].mean()
            self.assertLess(low, most)  # random pixels have 1

    def test_seeds_give_different_sets(self):
        masks = [self.mask(64, 64, 512, seed=seed) for seed in range(4)]
        for i, first in enumerate(masks):
            for second in masks[:i]:
                self.assertLess((first & second).sum(), 128)  # independent sets have 64 in common

    def test_impossible_requests_name_field_and_numbers(self):
        for members, pointer, words in (
                ({"sites": 257}, "/sites", "sites is 257, but the domain has only 16 x 16 pixels"),
                ({"sites": 15, "calibration": {"width": 4, "height": 4}}, "/calibration",
                 "16 pixels are included, but there are only 15 sites"),
                ({"sites": 20, "calibration": {"width": 4, "height": 4}, "include": [{"y": 0, "height": 1}]}, "/include",
                 "32 pixels are included, but there are only 20 sites"),
                ({"sites": 129, "density": {"width": 2, "height": 1, "values": [0, 1]}}, "/sites",
                 "only 128 pixels have a density above 0 or are included, but there are 129 sites"),
                ({"sites": 9, "density": {"width": 2, "height": 1, "values": [0, 0]}}, "/density/values", "zero"),
                ({"sites": 9, "calibration": {"width": 17}}, "/calibration", "within the domain of 16 x 16 pixels"),
                ({"sites": 9, "include": [[3, 3], [3, 16]]}, "/include/1", "within the domain of 16 x 16 pixels")):
            with self.subTest(members=members):
                problem = self.sample({"domain": domain(16, 16), **members}, 422).json()
                self.assertEqual([error["pointer"] for error in problem["errors"]], [pointer])
                self.assertIn(words, problem["detail"])

    def test_memory_is_estimated_before_the_work(self):
        with Server("--memory=1GiB", "--workers=1") as server:
            refused = post_json(server, "/sample", {"sites": 100, "domain": domain(8000, 8000)})
            self.assertEqual(refused.status, 413)
            self.assertIn("(memory)", refused.json()["detail"])
            self.assertEqual(post_json(server, "/sample", {"sites": 100, "domain": domain(800, 800)}).status, 200)

    def test_many_overlapping_blocks_are_answered(self):
        blocks = [{}] * 100_000
        mask = self.mask(600, 600, 360_000, include=blocks)
        self.assertTrue(mask.all())


if __name__ == "__main__":
    unittest.main(verbosity=2)
