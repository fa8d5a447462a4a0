# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of halftones of a single grey, at their own size and enlarged."""

import unittest

import numpy
from PIL import Image

from harness import ServerCase, file_of, flat, pixels
from seen import CHANNELS, LIGHT, lightness, luminance


def luminance_enlarged(file):
    """Returns the luminance of each pixel of a picture enlarged twofold in encoded values, as browsers do."""
    image = Image.fromarray(pixels(file, "RGB"))
    image = image.resize((2 * image.width, 2 * image.height), Image.Resampling.BILINEAR)
    return LIGHT[numpy.asarray(image)] @ CHANNELS


class Wedge(ServerCase):
    def test_flat_greys(self):
        for share in (0.005, 0.02, 0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.995):
            level = int(numpy.argmin(abs(1 - LIGHT - share)))
            for query in ("antialias=true", "scale=1", "scale=0.5", "scale=0.1", "scale=0.1&antialias=true",
                          "dots=ink&antialias=true", "dots=ink&scale=1", "dots=ink&scale=0.1&antialias=true"):
                with self.subTest(share=share, query=query):
                    seen = luminance(self.halftone(file_of(flat(level, 300, 300)), "?" + query).body)
                    self.assertAlmostEqual(seen.mean(), LIGHT[level], delta=0.005)

    def test_flat_greys_at_their_own_size_and_enlarged(self):
        for share in (0.005, 0.02, 0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.995):
            level = int(numpy.argmin(abs(1 - LIGHT - share)))
            for query, most in (("", 1), ("?dots=ink", 1.5)):
                with self.subTest(share=share, query=query):
                    drawing = self.halftone(file_of(flat(level, 300, 300)), query).body
                    own, twice = luminance(drawing).mean(), luminance_enlarged(drawing).mean()
                    self.assertAlmostEqual((own + twice) / 2, LIGHT[level], delta=0.005)
                    for light in (own, twice):
                        self.assertAlmostEqual(lightness(light), lightness(LIGHT[level]), delta=most)


if __name__ == "__main__":
    unittest.main(verbosity=2)
