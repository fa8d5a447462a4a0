# SPDX-License-Identifier: GPL-3.0-or-later
"""Same input, options and seed: same bytes, whatever else the server does."""

import re
import unittest

import numpy

from harness import PICTURES, Call, Server, ask, file_of, polygon, post_json

CAMERA = (PICTURES / "camera.png").read_bytes()
CHELSEA = (PICTURES / "chelsea.png").read_bytes()
Y, X = numpy.mgrid[:1100, :1500]
WAVES = file_of(127 + 127 * numpy.stack([numpy.sin(X * Y / 1e5), numpy.cos(X / 40), numpy.sin(Y / 9)], axis=-1), "PNG")
SAMPLE = {"sites": 2000, "seed": 11, "mesh": True, "geometry": polygon("South-Africa-50m.geojson")}


def without_time(body):
    """Removes the only member that depends on time."""
    return re.sub(rb'"elapsed_ms":[^,}]*', b"", body)


def everything(server):
    answers = [
        ask(server, "/halftone?sites=3000&seed=5", data=CAMERA),
        ask(server, "/halftone?sites=3000&seed=5&format=json", data=CAMERA),
        ask(server, "/halftone?sites=3000&seed=5&format=json&dots=both", data=CAMERA),
        ask(server, "/halftone?sites=3000&seed=5&dots=ink", data=CAMERA),
        ask(server, "/halftone?sites=3000&seed=5&palette=%23c00,%2306c&antialias=true", data=CHELSEA),
        post_json(server, "/sample", SAMPLE),
    ]
    for answer in answers:
        assert answer.status == 200, answer
    return [without_time(answer.body) for answer in answers]


def large(server):
    """Returns answers whose computations are long enough for several threads."""
    answers = [ask(server, "/halftone?" + options, data=WAVES) for options in (
        "sites=20000", "sites=20000&dots=ink", "sites=30000&dots=both&format=csv",
        "sites=60000&scale=0.5&antialias=true", "sites=20000&color=cmyk&antialias=true", "sites=300000&quality=draft&tone=perceptual",
        "quality=draft&scale=0.5&levels=0.1,0.9,1.5", "sites=3000&format=csv")]
    answers += [post_json(server, "/sample", {"sites": 60_000, "format": "csv", "domain": domain}) for domain in (
        {"type": "torus", "width": 1, "height": 1}, {"type": "rectangle", "width": 2, "height": 1},
        {"type": "pixels", "width": 700, "height": 500})]
    for answer in answers:
        assert answer.status == 200, answer
    return [answer.body for answer in answers]


class Determinism(unittest.TestCase):
    def test_same_bytes_for_any_number_of_workers(self):
        with Server("--workers=1") as one, Server("--workers=4") as four:
            self.assertEqual(everything(one), everything(four))

    def test_same_bytes_for_any_number_of_threads(self):
        flags = ("--workers=4", "--threads-per-request")
        with Server(*flags, "1") as one, Server(*flags, "3") as three, Server(*flags, "4") as four:
            expected = large(one)
            self.assertEqual(large(three), expected)
            # Beside other requests they have fewer threads, in varying numbers.
            calls = [Call(four.url("/halftone?sites=3000"), data=CAMERA) for _ in range(6)]
            self.assertEqual(large(four), expected)
            self.assertEqual({call.answer().status for call in calls}, {200})

    def test_same_bytes_when_repeated_and_under_load(self):
        with Server("--workers=4") as server:
            alone = everything(server)
            self.assertEqual(everything(server), alone)
            calls = [Call(server.url(f"/halftone?sites=3000&seed={5 + i % 2}"), data=CAMERA) for i in range(16)]
            loaded = everything(server)
            answers = [call.answer() for call in calls]
            self.assertEqual(loaded, alone)
            for i, answer in enumerate(answers):
                self.assertEqual(answer.status, 200)
                self.assertEqual(answer.body == alone[0], i % 2 == 0)

    def test_other_seeds_give_other_points(self):
        with Server() as server:
            bodies = {ask(server, f"/halftone?sites=300&seed={seed}", data=CAMERA).body
                      for seed in (0, 1, 2, 2 ** 53 - 1)}
            self.assertEqual(len(bodies), 4)
            absent, zero = (ask(server, "/halftone?sites=300" + seed, data=CAMERA).body for seed in ("", "&seed=0"))
            self.assertEqual(absent, zero)


if __name__ == "__main__":
    unittest.main(verbosity=2)
