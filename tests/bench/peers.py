# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs other programs that show pictures in a few colours: those that are installed.

Pillow and ImageMagick are found where the system has them. The others are in a folder:

    npm install image-q ditherjs esbuild                        # in the folder
    git clone https://github.com/Utzel-Butzel/epdoptimize
    git clone https://github.com/OpenDisplay/epaper-dithering   # version 0.6.4, which is in Python
    npx esbuild epdoptimize/src/index.ts --bundle --format=cjs --outfile=epdoptimize.cjs
"""
import importlib
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

NODE_PROGRAM = """
const fs = require("fs"), path = require("path");
const [folder, peers] = process.argv.slice(1);
const { width, height, palette } = JSON.parse(fs.readFileSync(path.join(folder, "job.json")));
const picture = fs.readFileSync(path.join(folder, "picture"));
const find = name => { try { return require(path.join(peers, name)); } catch { return null; } };
const write = (name, data) => fs.writeFileSync(path.join(folder, name + ".rgba"), data);
const copy = () => new Uint8ClampedArray(picture);

const imageq = find("node_modules/image-q");
if (imageq) {
  const colours = new imageq.utils.Palette();
  for (const [r, g, b] of palette) colours.add(imageq.utils.Point.createByRGBA(r, g, b, 255));
  for (const way of ["floyd-steinberg", "false-floyd-steinberg", "stucki", "atkinson", "jarvis", "burkes", "sierra",
                     "two-sierra", "sierra-lite", "riemersma"]) {
    const points = imageq.utils.PointContainer.fromUint8Array(copy(), width, height);
    const options = { colorDistanceFormula: "euclidean-bt709-noalpha", imageQuantization: way };
    write("image-q " + way, imageq.applyPaletteSync(points, colours, options).toUint8Array());
  }
}
const DitherJS = find("node_modules/ditherjs/lib/ditherjs.js");
for (const algorithm of DitherJS ? ["diffusion", "atkinson", "ordered"] : []) {
  const image = { width, height, data: copy() };
  new DitherJS().ditherImageData(image, { algorithm, palette, step: 1 });
  write("ditherjs " + algorithm, image.data);
}
const epdoptimize = find("epdoptimize.cjs");
const canvas = data => ({ width, height, getContext: () => ({
  getImageData: () => ({ width, height, data }), putImageData: image => { data.set(image.data); } }) });
const hex = colour => "#" + colour.map(value => value.toString(16).padStart(2, "0")).join("");
(async () => {
  for (const errorDiffusionMatrix of epdoptimize ? ["floydSteinberg", "jarvis", "stucki", "burkes", "sierra3"] : []) {
    const result = copy();
    await epdoptimize.ditherImage(canvas(copy()), canvas(result), { palette: palette.map(hex), errorDiffusionMatrix });
    write("epdoptimize " + errorDiffusionMatrix, result);
  }
})();
"""


def picture_of(values):
    return Image.fromarray(values.astype(np.uint8), "RGB")


def palette_image(palette):
    image = Image.new("P", (1, 1))
    image.putpalette(sum(map(list, palette), []) + list(palette[-1]) * (256 - len(palette)))
    return image


def pillow(values, palette):
    yield "Pillow", picture_of(values).quantize(palette=palette_image(palette), dither=Image.Dither.FLOYDSTEINBERG)


def image_magick(values, palette):
    program = shutil.which("magick") or shutil.which("convert-im6.q16") or shutil.which("convert")
    if not program:
        return
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder)
        picture_of(values).save(path / "in.png")
        picture_of(np.array([palette])).save(path / "palette.png")
        ways = {"Floyd-Steinberg": ["-dither", "FloydSteinberg", "-remap", "palette.png"],
                "Riemersma": ["-dither", "Riemersma", "-remap", "palette.png"]}
        if len(palette) == 2:
            ways |= {order: ["-colorspace", "Gray", "-ordered-dither", order] for order in ("o8x8", "h4x4a")}
        for way, options in ways.items():
            done = subprocess.run([program, "in.png", *options, "ppm:out.ppm"], cwd=folder, check=False)
            if done.returncode == 0:
                yield "ImageMagick " + way, Image.open(path / "out.ppm")


def programs_of_node(values, palette, peers):
    node = shutil.which("node")
    if not node:
        return
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder)
        height, width = values.shape[:2]
        (path / "job.json").write_text(json.dumps({"width": width, "height": height, "palette": palette}))
        opaque = np.full((height, width, 1), 255, np.uint8)
        (path / "picture").write_bytes(np.concatenate([values.astype(np.uint8), opaque], -1).tobytes())
        subprocess.run([node, "-e", NODE_PROGRAM, folder, peers], check=True, timeout=600)
        for result in sorted(path.glob("*.rgba")):
            yield result.stem, Image.frombytes("RGBA", (width, height), result.read_bytes()).convert("RGB")


def epaper_dithering(values, palette, peers):
    sys.path.append(str(pathlib.Path(peers, "epaper-dithering/packages/python/src")))
    try:
        library = importlib.import_module("epaper_dithering")  # optional, in no package of Debian
    except ImportError:
        return
    colours = {str(number): tuple(colour) for number, colour in enumerate(palette)}
    for mode in (library.DitherMode.FLOYD_STEINBERG, library.DitherMode.BURKES, library.DitherMode.STUCKI):
        picture = library.dither_image(picture_of(values), library.ColorPalette(colours, "0"), mode, tone_compression=0)
        yield "epaper-dithering " + mode.name.lower(), picture


def encoded(light):
    """Returns 8-bit sRGB values of linear light."""
    light = np.clip(light, 0, 1)
    return np.round(255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055))


def shown(light, palette, peers):
    """Yields names of programs, and for each the numbers of the palette's colours in its picture.

    Most programs take values for amounts of light, which 8-bit sRGB values are not. So each one gets both these values
    and values that are linear in light, and its better result may be chosen.

    `light` is red, green and blue in [0, 1]. `palette` has light, too.
    """
    linear = np.round(255 * np.clip(light, 0, 1)), np.round(255 * palette)
    srgb = encoded(light), encoded(palette)
    for kind, (values, colours) in (("linear", linear), ("sRGB", srgb)):
        palette_values = colours.astype(int).tolist()
        results = [*pillow(values, palette_values), *image_magick(values, palette_values)]
        if peers:
            results += programs_of_node(values, palette_values, peers)
            if kind == "sRGB":
                results += epaper_dithering(values, palette_values, peers)
        for name, picture in results:
            seen = np.asarray(picture.convert("RGB")).astype(int)
            distance = ((seen[:, :, None] - colours) ** 2).sum(-1)
            yield name, distance.argmin(-1)
