#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares how ccdt reads pictures with how Chromium shows them.

Usage: viewers.py URL FOLDER ...    For example: viewers.py http://localhost:8080 /var/tmp/sets/pillow

Needs chromium-headless-shell, Node.js and the npm packages of tests/page/install. Takes every file below the folders
that Chromium displays. Both pictures are composited on white and divided into a grid of at most 16 x 16 cells of at
least 8 x 8 pixels. L* of a cell is that of its mean luminance. Our luminance is that of device=gray16.
Prints the files whose cells differ by more than 2 L* on average, the files that ccdt refuses, and the counts.

Some differences are decisions:
- HDR pictures (PQ, HLG) are mapped by the extended curve of Reinhard, and not by the curve of Chromium. This includes
  AVIFs with a gain map whose base is HDR.
- The curves of video in a cICP are taken as that of sRGB. Chromium takes a power of 2.4, which makes greys darker.
- The primaries in cHRM apply without gAMA, too. If cHRM is invalid, gAMA still applies.
- A colour outside sRGB is mixed with grey of its luminance. Chromium clips each channel, which changes saturated colours.
- CMYK with a profile has black point compensation, as in editors. Chromium shows black as lighter.
- A PNG is turned upright by an eXIf after its pixels, too.
- An orientation in EXIF may be an integer of 4 bytes, as in Pillow. Chromium requires 2.
- A WebP with an orientation in EXIF is turned upright, which Chromium does not do.
- A crop (clap) of an AVIF is applied, because HEIF requires it. Chromium shows the whole picture.
- Colours of an AVIF whose alpha is premultiplied are divided by alpha before they are converted. Chromium shows them up
  to 8 L* darker.
- A layer that an AVIF selects (lsel) is shown, and so is an AVIF in 4:2:2. Chromium shows nothing.
- Of animations, ccdt reads the default image or the first frame, as Pillow and ImageMagick do. Chromium draws a frame of
  the animation, of which the default image need not be part.
- Icons, cursors, BMPs with RLE of 24 bits, AVIFs without a primary item, with the matrix 10 of H.273 (constant
  luminance), or with tiles whose alpha or order the library misreads are refused by name, and pictures above
  --max-pixels by their size. Truncated or damaged pictures are refused, of which Chromium shows the part that is
  there: also PNGs with wrong checksums or without IEND, JPEGs with wrong codes, GIFs with codes of more than 8 bits.
- A BMP whose alpha is zero everywhere is opaque, and not invisible.
- Pixels that the runs of a BMP leave out have the first colour of the palette, as in Pillow and ImageMagick. Chromium
  makes them black.
- Colours that the palette of a PNG lacks are black, as in ImageMagick. Chromium takes another colour.
- If a JPEG lacks its end (EOI), its last rows are shown, too.
- The alpha of a BMP has the bits that the file states. If this is one bit of 32, Chromium takes 8.
- The measure exceeds 2 L* where many hard edges cross a picture of 16 or 32 pixels, because the smooth edges of the
  enlargement are lighter. If the pixels are repeated before the comparison, the difference is below 0.1 L*.
"""
import io
import json
import pathlib
import subprocess
import sys
import urllib.error
import urllib.parse
import urllib.request

import numpy as np
from PIL import Image

MODULES = pathlib.Path(__file__).resolve().parents[2] / "build/tools/page/node_modules/"
LIMIT = 2
CELLS = 16
CELL_SIDE = 8

# Reads paths from the standard input, and writes the picture's size and the mean luminances of its cells for each path,
# or null if Chromium does not display the file.
BROWSER = """
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { createInterface } from "node:readline";
const { chromium } = createRequire(process.argv[1])("playwright-core");
const browser = await chromium.launch({ executablePath: "/usr/bin/chromium-headless-shell", args: ["--no-sandbox"] });
const page = await browser.newPage();
let file;
await page.route("**", (route) => route.request().url().endsWith("/page")
  ? route.fulfill({ contentType: "text/html", body: "" })
  : route.fulfill({ body: file, headers: { "Cache-Control": "no-store" } }));
await page.goto("http://localhost/page");
let number = 0;
for await (const name of createInterface({ input: process.stdin })) {
  file = await readFile(name);
  const seen = await page.evaluate(async ([url, most, side]) => {
    const image = new Image();
    image.src = url;
    try { await image.decode(); } catch { return null; }
    const { naturalWidth: width, naturalHeight: height } = image;
    if (!width || !height) return null;
    const context = new OffscreenCanvas(width, height).getContext("2d");
    context.fillStyle = "white";
    context.fillRect(0, 0, width, height);
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, width, height);
    const light = Array.from({ length: 256 }, (_, value) =>
      value <= 10 ? value / 3294.6 : ((value / 255 + 0.055) / 1.055) ** 2.4);
    const [columns, rows] = [width, height].map((length) => Math.max(1, Math.min(most, Math.floor(length / side))));
    const sums = new Float64Array(columns * rows), counts = new Float64Array(columns * rows);
    for (let y = 0, at = 0; y < height; ++y)
      for (let x = 0; x < width; ++x, at += 4) {
        const cell = Math.floor(y * rows / height) * columns + Math.floor(x * columns / width);
        sums[cell] += 0.2126 * light[data[at]] + 0.7152 * light[data[at + 1]] + 0.0722 * light[data[at + 2]];
        ++counts[cell];
      }
    return { width, height, columns, rows, cells: Array.from(sums, (sum, cell) => sum / counts[cell]) };
  }, [`/${++number}`, +process.argv[2], +process.argv[3]]).catch(() => null);
  console.log(JSON.stringify(seen));
}
await browser.close();
"""


def lightness(luminance):
    luminance = np.asarray(luminance)
    return np.where(luminance > 216 / 24389, 116 * np.cbrt(luminance) - 16, 24389 / 27 * luminance)


def cells(picture, seen):
    """Returns the mean luminances of the cells of a grey picture. The cells consist of whole pixels of the file."""
    values = np.asarray(picture) / 255
    light = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    for axis, (count, pixels) in enumerate(((seen["rows"], seen["height"]), (seen["columns"], seen["width"]))):
        length = light.shape[axis]
        edges = -(-np.arange(count + 1) * pixels // count) * length // pixels
        light = np.add.reduceat(light, edges[:-1], axis) / np.diff(edges).reshape((-1, 1) if axis == 0 else (1, -1))
    return light.ravel()


def ours(url, file, seen):
    """Returns the mean luminances of the cells of our picture, or the message of the refusal."""
    enlargement = max(1, -(-256 // max(seen["width"], seen["height"])))
    reduction = max(1, max(seen["width"], seen["height"]) // 512)
    width = max(1, seen["width"] * enlargement // reduction)
    query = urllib.parse.urlencode({"device": "gray16", "width": width})
    request = urllib.request.Request(f"{url}/halftone?{query}", file.read_bytes(),
                                     {"Content-Type": "application/octet-stream"})
    try:
        with urllib.request.urlopen(request, timeout=100) as answer:
            return cells(Image.open(io.BytesIO(answer.read())).convert("L"), seen)
    except urllib.error.HTTPError as error:
        return f"{error.code} {json.load(error)['detail']}"


def main():
    url, *folders = sys.argv[1:]
    files = [file for folder in folders for file in sorted(pathlib.Path(folder).rglob("*")) if file.is_file()]
    command = ["node", "--input-type=module", "--eval", BROWSER, f"{MODULES}/", str(CELLS), str(CELL_SIDE)]
    browser = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    shown = refused = different = 0
    print("| file | mean difference in L* | largest | or refusal |\n|---|---|---|---|")
    for file in files:
        print(file, file=browser.stdin, flush=True)
        seen = json.loads(browser.stdout.readline())
        if seen is None:
            continue
        shown += 1
        got = ours(url, file, seen)
        if isinstance(got, str):
            refused += 1
            print(f"| {file} | | | {got} |", flush=True)
            continue
        difference = lightness(got) - lightness(seen["cells"])
        if np.abs(difference).mean() > LIMIT:
            different += 1
            largest = difference[np.abs(difference).argmax()]
            mean = f"{np.abs(difference).mean():.1f} (signed {difference.mean():+.1f})"
            print(f"| {file} | {mean} | {largest:+.1f} | |", flush=True)
    browser.stdin.close()
    browser.wait()
    print(f"\nOf {len(files)} files, Chromium shows {shown}. Of these, ccdt refuses {refused}, and {different} differ by "
          f"more than {LIMIT} L*.")


if __name__ == "__main__":
    main()
