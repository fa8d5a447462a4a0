# SPDX-License-Identifier: GPL-3.0-or-later
"""Named options of the operator: preset=NAME."""

import json
import os
import pathlib
import signal
import tempfile
import unittest

from harness import Server, ask, execute, file_of, flat

GREY = file_of(flat(128))
PRESETS = {"small": {"sites": 50, "scale": 1, "format": "csv"}, "map": {"sites": 30, "format": "csv"}}
LAND = {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [0, 1], [0, 0]]]}


class PresetsCase(unittest.TestCase):
    flags = ()

    def setUp(self):
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.file = folder / "presets.json"
        self.file.write_text(json.dumps(PRESETS))
        (folder / "cat.png").write_bytes(GREY)
        self.server = self.enterContext(Server(f"--presets={self.file}", f"--pictures={folder}", *self.flags))

    def body(self, path, *arguments, data=None):
        answer = ask(self.server, path, *arguments, data=data)
        self.assertEqual(answer.status, 200, answer)
        return answer.body

    def refuse(self, words, path, *arguments, data=None):
        answer = ask(self.server, path, *arguments, data=data)
        self.assertEqual(answer.status, 400, answer)
        self.assertIn(words, answer.json()["detail"])


class Presets(PresetsCase):
    flags = ("--cache=16MiB",)

    def test_stand_for_their_options(self):
        expected = self.body("/halftone?sites=50&scale=1&format=csv", data=GREY)
        self.assertEqual(self.body("/halftone?preset=small", data=GREY), expected)
        self.assertEqual(self.body("/halftone/cat.png?preset=small"), expected)
        self.assertEqual(self.body("/halftone?preset=small&sites=60", data=GREY).count(b"\n"), 61)
        self.refuse("did you mean small?", "/halftone?preset=smal", data=GREY)
        self.assertIn("?preset=small ", self.server.wait_for_log("?preset="))

    def test_apply_to_documents_and_jobs(self):
        land = json.dumps(LAND)
        expected = self.body("/sample?sites=30&format=csv", data=land)
        self.assertEqual(self.body("/sample?preset=map", data=land), expected)
        form = ("--form-string", "map=" + land, "--form", "preset=map")
        self.assertEqual(self.body("/sample", *form), expected)
        self.assertEqual(self.body("/sample", *form, "--form", "sites=7").count(b"\n"), 8)
        job = ask(self.server, "/sample?preset=map", "--header", "Prefer: respond-async", data=land).json()["id"]
        self.assertIn(b"succeeded", self.body(f"/jobs/{job}/events"))
        self.assertEqual(self.body(f"/jobs/{job}/result"), expected)

    def test_are_listed_and_reloaded(self):
        listed = json.loads(self.body("/capabilities"))["presets"]
        self.assertEqual(listed, {"names": ["map", "small"], "required": False})
        form = ("--form", f"image=@{self.file.with_name('cat.png')}", "--form", "preset=small")
        self.assertEqual(self.body("/halftone", *form).count(b"\n"), 51)
        self.file.write_text('{"small": {"sites": 7, "format": "csv"}}')
        self.server.signal(signal.SIGHUP)
        self.server.wait_for_log("were reloaded")
        self.assertEqual(self.body("/halftone?preset=small", data=GREY).count(b"\n"), 8)
        self.assertEqual(self.body("/halftone", *form).count(b"\n"), 8, "not the cached answer")
        self.file.write_text('{"small": {"siets": 7}}')
        self.server.signal(signal.SIGHUP)
        self.assertIn("did you mean sites?", self.server.wait_for_log("stay as they were"))
        self.assertEqual(self.body("/halftone?preset=small", data=GREY).count(b"\n"), 8)

    def test_of_a_malformed_file_prevent_the_start(self):
        self.file.write_text("[]")
        command = [os.environ["CCDT_SERVER"], "--port=0", f"--presets={self.file}"]
        done = execute(command, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn(f"{self.file}: presets must be members of an object", done.stderr)


class PresetsOnly(PresetsCase):
    flags = ("--presets-only=true",)

    def test_are_required(self):
        self.assertTrue(json.loads(self.body("/capabilities"))["presets"]["required"])
        expected = self.body("/halftone?preset=small", data=GREY)
        self.assertEqual(self.body("/halftone/cat.png?preset=small"), expected)
        self.refuse("needs preset=NAME", "/halftone", data=GREY)
        self.refuse("needs preset=NAME", "/halftone/cat.png?sites=3")

    def test_cannot_be_changed_by_any_part_of_a_request(self):
        picture = str(self.file.with_name("cat.png"))
        expected = self.body("/halftone?preset=small", data=GREY)
        self.assertEqual(self.body("/halftone?preset=small", "--form", f"image=@{picture}"), expected)
        self.assertEqual(self.body("/halftone", "--form", f"image=@{picture}", "--form", "preset=small"), expected)
        self.refuse("besides a preset", "/halftone?preset=small&sites=9", data=GREY)
        self.refuse("besides a preset", "/halftone?preset=small", "--form", f"image=@{picture}", "--form", "sites=9")
        self.refuse("besides a preset", "/halftone/cat.png?preset=small&seed=9")
        encoded = json.dumps({"image": "", "seed": 9})
        self.refuse("besides a preset", "/halftone?preset=small", "--form-string", "image=" + encoded)
        for path in ("/halftone", "/sample", "/analyze"):
            body = {"domain": LAND, "sites": 9, "points": [[0, 0]], "image": ""}
            for data in (json.dumps(body), " \n" + json.dumps(body)):
                for kind in ("application/json", "text/plain", "image/png", "application/geo+json"):
                    answer = ask(self.server, path + "?preset=map", "--header", "Content-Type: " + kind, data=data)
                    self.assertIn(answer.status, (400, 415, 422), answer)
        land = json.dumps({**LAND, "sites": 5})
        self.assertEqual(self.body("/sample?preset=map", data=land).count(b"\n"), 31)


if __name__ == "__main__":
    unittest.main(verbosity=2)
