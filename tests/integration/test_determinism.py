"""Same input, options and seed: same bytes, whatever else the server does."""

import re
import unittest

from harness import PICTURES, Call, Server, ask, polygon, post_json

CAMERA = (PICTURES / "camera.png").read_bytes()
SAMPLE = {"sites": 2000, "seed": 11, "mesh": True, "geometry": polygon("South-Africa-50m.geojson")}


def without_time(body):
    """The one member that tells how long it took."""
    return re.sub(rb'"elapsed_ms":[^,}]*', b"", body)


def everything(server):
    answers = [
        ask(server, "/halftone?sites=3000&seed=5", data=CAMERA),
        ask(server, "/halftone?sites=3000&seed=5&format=json", data=CAMERA),
        ask(server, "/halftone?sites=3000&seed=5&color=rgb", data=CAMERA),
        post_json(server, "/sample", SAMPLE),
    ]
    for answer in answers:
        assert answer.status == 200, answer
    return [without_time(answer.body) for answer in answers]


class Determinism(unittest.TestCase):
    def test_same_bytes_for_any_number_of_workers(self):
        with Server("--workers=1") as one, Server("--workers=4") as four:
            self.assertEqual(everything(one), everything(four))

    def test_same_bytes_again_and_under_load(self):
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
