# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares answers of the WebAssembly module, run by Node.js, with the digests of goldens.txt.

Needs the module, which `cmake --preset wasm` and `cmake --build --preset wasm` build. CCDT_WASM is its path.
"""

import base64
import io
import json
import os
import pathlib
import subprocess
import unittest
import urllib.parse
from types import SimpleNamespace
from unittest import mock

from PIL import Image

import test_goldens
from harness import Server, ask, data_uri

MODULE = pathlib.Path(os.environ.get("CCDT_WASM", "build/wasm/ccdt.wasm"))
LOADER = pathlib.Path(__file__).resolve().parents[2] / "api/wasm/loader.mjs"
SCRIPT = pathlib.Path(__file__).with_name("wasm_answers.mjs")
KIBIBYTE = 1024
MAX_SIZE = 1000 * KIBIBYTE  # of the module, compressed by Brotli

STEP = 1  # a part of the answers, for the time of the test

# Formats that need compiled libraries or contain a PNG, and the methods of CCDT_BASELINES.
ABSENT_FORMATS = ("png", "jpeg", "webp", "tiff", "pdf", "pmtiles", "mask", "mask16")
ABSENT_METHODS = ("cvt", "odt", "ccvt", "random")


def bitmap_of(file):
    """Decodes a picture, as a browser does for the module, and returns it as BMP."""
    bitmap = io.BytesIO()
    Image.open(io.BytesIO(file)).save(bitmap, "BMP")
    return bitmap.getvalue()


def requests(server):
    """Yields the names and requests of goldens.txt that the module can answer."""
    pictures = {photo: bitmap_of(photo) for photo in test_goldens.PHOTOS.values()}
    addresses = {data_uri(photo): data_uri(bitmap, "image/bmp") for photo, bitmap in pictures.items()}
    offered = ask(server, "/capabilities")

    def described(server, path, data=None):
        if path == "/capabilities":
            return offered
        url = urllib.parse.urlsplit(path)
        return SimpleNamespace(operation=url.path[1:], options=urllib.parse.parse_qsl(url.query, True), type="",
                               body=pictures.get(data, data))

    def described_json(server, path, body):
        text = json.dumps(body)
        for photo, bitmap in addresses.items():
            text = text.replace(photo, bitmap)
        return SimpleNamespace(operation=path[1:], options=[], type="application/json", body=text.encode(), json=body)

    with mock.patch.object(test_goldens, "ask", described), mock.patch.object(test_goldens, "post_json", described_json):
        for name, request in test_goldens.everything(None):
            request = request()
            options = {**dict(request.options), **getattr(request, "json", {})}
            usual = "png" if request.operation == "halftone" else "json"
            if (options.get("format", usual) not in ABSENT_FORMATS and not name.startswith("analyze svg")
                    and options.get("method") not in ABSENT_METHODS):
                yield name, request


def is_grey(name):
    return any(word in name.split() for word in ("camera", "wedge", "pixel", "black", "image"))


def line_of(request):
    """Returns a request as wasm_answers.mjs reads it."""
    return json.dumps({"operation": request.operation, "options": request.options, "type": request.type,
                       "body": base64.b64encode(request.body).decode()})


def answer_in(line):
    answer = json.loads(line)
    return SimpleNamespace(status=answer["status"], type=answer["type"], body=base64.b64decode(answer["body"]))


def answers_to(asked):
    run = subprocess.run(["node", SCRIPT, MODULE], input="\n".join(map(line_of, asked)), capture_output=True, text=True,
                         check=True, timeout=600)
    return map(answer_in, run.stdout.splitlines())


PREPARED = """
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { bitmapOf, Engine, Refusal } from "LOADER";

const engine = new Engine(await WebAssembly.compile(await readFile("MODULE")));
const sample = (request, options) =>
  engine.answer("sample", new TextEncoder().encode(JSON.stringify({ format: "csv", ...request })), options);
const torus = { sites: 200, domain: { type: "torus", width: 1, height: 1 } };
const expected = sample(torus);
"""

BROKEN = PREPARED + """
const broken = new Error("ends the instance");
assert.throws(() => sample(torus, { progress() { throw broken; } }), broken);
assert.deepEqual(sample(torus), expected);

assert.throws(() => sample({ ...torus, sites: 0 }), (error) =>
  error instanceof Refusal && error.status === 400 && error.problem.errors[0].pointer === "/sites");
assert.deepEqual(sample(torus), expected);

assert.throws(() => sample(torus, { progress: () => true }), { name: "Refusal", status: 503 });
assert.deepEqual(sample(torus), expected);

let share = 0;
sample(torus, { progress(next) { assert(next >= share && next < 1); share = next; } });
assert(share > 0.5);
assert.equal(sample({ ...torus, sites: 1_000_000 }, { seconds: 0.1 }), null);
assert.throws(() => engine.answer("halftone", new Uint8Array([1, 2, 3])), { name: "Refusal", status: 415 });
"""

# An answer that would not fit into the memory is refused. Bodies that do not fit end the instance.
EXHAUSTED = PREPARED + """
const large = { sites: 2_000_000, domain: { ...torus.domain, depth: 1 }, mesh: true, format: "vtu" };
assert.throws(() => sample(large, { seconds: 0 }), (error) =>
  error.status === 413 && /^the answer needs about \\d+ MiB, but WebAssembly has at most 1800 MiB$/.test(error.message));
assert.deepEqual(sample(torus), expected);
for (const length of [2_147_000_000, 4_000_000_000]) {
  assert.throws(() => engine.answer("sample", { length }), WebAssembly.RuntimeError);
  assert.deepEqual(sample(torus), expected);
}
"""

# Any progress would show that the computation has begun.
REFUSED = PREPARED + """
const refused = { progress: () => assert.fail("it computes") };
const refuses = (format, ask) => assert.throws(ask, (error) =>
  error.status === 406 && error.message.startsWith(`WebAssembly cannot write ${format};`));
const area = { sites: 20_000, width_mm: 100, domain: { ...torus.domain, type: "rectangle" } };
const degrees = { sites: 20_000, polygon: [[0, 0], [9, 0], [9, 8]], coordinates: "lonlat" };
const mask = { domain: { ...torus.domain, width: 64, height: 64 } };
const requests = { png: area, jpeg: area, pdf: area, pmtiles: degrees, mask, mask16: mask };
for (const [format, request] of Object.entries(requests)) refuses(format, () => sample({ ...request, format }, refused));
const picture = bitmapOf({ width: 64, height: 64, data: new Uint8Array(4 * 64 * 64).fill(128) });
const options = (format) => [["sites", "20000"], ["format", format]];
for (const format of FORMATS.filter((one) => !(one in requests)))
  refuses(format, () => engine.answer("halftone", picture, { options: options(format), ...refused }));
const points = new TextEncoder().encode(JSON.stringify({ points: [[0, 0], [0.5, 0.5]], format: "svg" }));
refuses("svg", () => engine.answer("analyze", points, refused));
"""

SIZE = """
import { readFile } from "node:fs/promises";
import { brotliCompressSync } from "node:zlib";

console.log(brotliCompressSync(await readFile("MODULE")).length);
"""


def run_script(script):
    script = script.replace("LOADER", LOADER.as_uri()).replace("MODULE", str(MODULE)).replace("FORMATS", json.dumps(ABSENT_FORMATS))
    return subprocess.run(["node", "--input-type=module", "--eval", script], capture_output=True, text=True, timeout=120)


@unittest.skipUnless(MODULE.exists(), "the module is not built")
class Wasm(unittest.TestCase):
    maxDiff = None

    def test_answers_are_those_of_the_service(self):
        with Server() as server:
            asked = dict(list(requests(server))[::STEP])
            answers = dict(zip(asked, answers_to(asked.values()), strict=True))
            for name, answer in answers.items():
                with self.subTest(name):
                    self.check(server, name, asked[name], answer)

    def check(self, server, name, request, answer):
        """Compares an answer with its digest. Grey pictures in PNG have one channel, but in BMP they have three, whose
        sums are rounded differently: so the service is asked for the same BMP. The same goes for refusals, whose
        titles differ."""
        if answer.status == 200 and not is_grey(name):
            self.assertEqual(test_goldens.digest(answer), test_goldens.known()[name])
            return
        query = urllib.parse.urlencode(request.options)
        expected = ask(server, f"/{request.operation}?{query}".rstrip("?"), "--header",
                       f"Content-Type: {request.type or 'application/octet-stream'}", data=request.body)
        self.assertEqual(answer.status, expected.status, answer.body[:300])
        if answer.status == 200:
            self.assertEqual(test_goldens.digest(answer), test_goldens.digest(expected))
        else:
            self.assertEqual(json.loads(answer.body)["detail"], expected.json()["detail"])

    def test_replaces_broken_instances_and_keeps_others(self):
        run = run_script(BROKEN)
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_refuses_what_does_not_fit_and_survives_exhausted_memory(self):
        run = run_script(EXHAUSTED)
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_refuses_formats_before_it_computes(self):
        run = run_script(REFUSED)
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_is_small(self):
        self.assertLess(int(run_script(SIZE).stdout), MAX_SIZE)


if __name__ == "__main__":
    unittest.main(verbosity=2)
