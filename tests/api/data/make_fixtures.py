#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the image files of this folder (Debian 12: python3-pil 9.4, python3-numpy, libavif-bin 0.11,
libheif-examples 1.15).

All files except those for alpha, colours and corruption show the test picture of 24 x 16 pixels: four quadrants of
sRGB grey, 0 and 85 above 170 and 255.
"""
import io
import pathlib
import struct
import subprocess
import sys
import zlib

import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "integration"))
import profiles  # pylint: disable=wrong-import-position

GREY = np.repeat(np.repeat(np.array([[0, 85], [170, 255]], np.uint8), 8, axis=0), 12, axis=1)
ORIENTATION = 0x0112
# Transformation from the upright picture to the stored one, by EXIF orientation.
STORE = {
    2: Image.Transpose.FLIP_LEFT_RIGHT,
    3: Image.Transpose.ROTATE_180,
    4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE,
    6: Image.Transpose.ROTATE_90,
    7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_270,
}


def oriented(name, orientation, **options):
    exif = Image.Exif()
    exif[ORIENTATION] = orientation
    picture = Image.fromarray(GREY).convert("RGB")
    if orientation in STORE:
        picture = picture.transpose(STORE[orientation])
    picture.save(name, exif=exif, **options)


def chunk(name, data):
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def header(width, height, depth, kind):
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, 0))


def tiff(name, blocks, order="<", **wanted):
    """Writes a TIFF of one directory. `blocks`: its strips or tiles; `wanted`: tags by number, as in t256=[24]."""
    tags = {int(key[1:]): values for key, values in wanted.items()}
    offsets = [8 + sum(map(len, blocks[:i])) for i in range(len(blocks))]
    tiled = 322 in tags
    tags[324 if tiled else 273] = offsets
    tags[325 if tiled else 279] = [len(block) for block in blocks]
    body = b"".join(blocks)
    body += b"\0" * (len(body) % 2)
    directory = 8 + len(body)
    spare = directory + 2 + 12 * len(tags) + 4
    entries, extra = b"", b""
    for tag, values in sorted(tags.items()):
        kind, letter = (4, "I") if tag in (273, 279, 324, 325) else (3, "H")
        data = struct.pack(order + letter * len(values), *values)
        if len(data) > 4:
            entry, extra = struct.pack(order + "I", spare + len(extra)), extra + data
        else:
            entry = data.ljust(4, b"\0")
        entries += struct.pack(order + "HHI", tag, kind, len(values)) + entry
    start = (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(order + "I", directory)
    with open(name, "wb") as file:
        file.write(start + body + struct.pack(order + "H", len(tags)) + entries + b"\0" * 4 + extra)


def tiff_with_profile(name, pixels, profile):
    """Writes a TIFF of one strip, with an invalid profile that Pillow would refuse to write."""
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "TIFF", icc_profile=b"#" * len(profile))
    with open(name, "wb") as kept:
        kept.write(file.getvalue().replace(b"#" * len(profile), profile))


def profiled():
    """Writes four colours of Display P3, 4 x 1 pixels, with a profile or another colour tag."""
    colours = Image.fromarray(np.array([[[255, 255, 255], [200, 100, 50], [40, 160, 90], [255, 0, 0]]], np.uint8))
    p3 = profiles.rgb_profile(profiles.DISPLAY_P3, profiles.srgb_to_linear)
    colours.save("p3.png", icc_profile=p3)
    colours.save("p3.webp", icc_profile=p3, lossless=True)
    colours.save("p3.tif", icc_profile=p3)
    blocks = colours.resize((64, 16), Image.Resampling.NEAREST)
    blocks.save("p3.jpg", icc_profile=p3 + bytes(70000), quality=100, subsampling=0)
    rows = zlib.compress(b"\0" + colours.tobytes())
    chromaticities = struct.pack(">8I", *(round(100000 * v) for xy in (profiles.D65, *profiles.DISPLAY_P3) for v in xy))
    for name, tag in (("p3-chromaticities.png", (b"cHRM", chromaticities)), ("p3-code-points.png", (b"cICP", b"\x0c\x0d\0\1"))):
        with open(name, "wb") as file:
            file.write(header(4, 1, 8, 2) + chunk(*tag) + chunk(b"IDAT", rows) + chunk(b"IEND", b""))
    colours.save("srgb.png", icc_profile=profiles.rgb_profile(profiles.SRGB, profiles.srgb_to_linear))

    ramp = np.arange(65536, dtype=np.uint16).reshape(256, 256)
    Image.fromarray(ramp).save("ramp.png")
    Image.fromarray(ramp).save("ramp.tif", compression="tiff_adobe_deflate", tiffinfo={317: 2})
    Image.fromarray(ramp).save("ramp-gamma.png", icc_profile=profiles.grey_profile(1.8))
    inks = Image.fromarray(np.array([[[0, 0, 0, 0], [255, 0, 0, 0], [0, 128, 64, 32], [0, 0, 0, 255]]], np.uint8), "CMYK")
    inks.save("inks.tif", icc_profile=profiles.ink_profile(5))
    inks.resize((64, 16), Image.Resampling.NEAREST).save("inks.jpg", icc_profile=profiles.ink_profile(5), quality=100)

    # A tag of the profile has an offset of 4 GiB, far beyond the end of the profile.
    broken = bytearray(p3)
    broken[132 + 4:132 + 12] = struct.pack(">II", 0xFFFFFFF0, 0x20)
    tiff_with_profile("profile-beyond.tif", np.asarray(colours), bytes(broken))
    colours.save("profile-beyond.png", icc_profile=bytes(broken))
    blocks.save("profile-beyond.jpg", icc_profile=bytes(broken), quality=100, subsampling=0)


def bmp(name, width, height, bits, pixels, extra=b"", compression=0, info=40, fields=b""):
    """Writes a BMP. `extra`: palette; `fields`: bytes after the first 40 of the header."""
    begin = 14 + max(info, 40 + len(fields)) + len(extra)
    head = struct.pack("<IiiHHIIiiII", info, width, height, 1, bits, compression, len(pixels), 0, 0, len(extra) // 4, 0)
    with open(name, "wb") as file:
        file.write(b"BM" + struct.pack("<IHHI", begin + len(pixels), 0, 0, begin))
        file.write((head + fields).ljust(begin - 14 - len(extra), b"\0") + extra + pixels)


def bitmaps():
    greys = b"".join(bytes([v, v, v, 0]) for v in (0, 85, 170, 255))
    indices = GREY[::-1] // 85
    Image.fromarray(GREY).convert("RGB").save("rgb.bmp")
    bmp("indices.bmp", 24, 16, 8, indices.tobytes(), greys)
    bmp("from-top.bmp", 24, -16, 8, indices[::-1].tobytes(), greys)
    bmp("four-bits.bmp", 24, 16, 4, (indices[:, ::2] << 4 | indices[:, 1::2]).tobytes(), greys)
    bmp("two-bits.bmp", 24, 16, 2, np.pad(sum(indices[:, i::4] << 6 - 2 * i for i in range(4)), ((0, 0), (0, 2))).tobytes(), greys)
    runs = b"".join(bytes([12, row[0], 12, row[-1], 0, 0]) for row in indices)
    bmp("runs-8.bmp", 24, 16, 8, runs + b"\0\1", greys, 1)
    # The left half of each row is stored uncompressed, the right half as a run.
    halves = b"".join(bytes([0, 12]) + bytes([row[0] * 17]) * 6 + bytes([12, row[-1] * 17, 0, 0]) for row in indices)
    bmp("runs-4.bmp", 24, 16, 4, halves + b"\0\1", greys, 2)
    five, ten = GREY[::-1].astype(np.uint32) * 31 // 255, GREY[::-1].astype(np.uint32) * 1023 // 255
    bmp("sixteen-bits.bmp", 24, 16, 16, (five << 10 | five << 5 | five).astype("<u2").tobytes())
    bmp("fields.bmp", 24, 16, 32, (ten << 20 | ten << 10 | ten).astype("<u4").tobytes(), b"", 3,
        fields=struct.pack("<III", 1023 << 20, 1023 << 10, 1023))
    colours = np.array([[[0, 0, 255, 51 * i] for i in range(6)]], np.uint8)
    masks = struct.pack("<IIII", 255 << 16, 255 << 8, 255, 255 << 24)
    bmp("alpha.bmp", 6, 1, 32, colours.tobytes(), b"", 3, 108, masks)
    colours[..., 3] = 0
    bmp("no-alpha.bmp", 6, 1, 32, colours.tobytes(), b"", 3, 108, masks)
    bmp("bomb.bmp", 30000, 30000, 8, b"\0\1", greys, 1)


def films():
    palette = Image.fromarray(GREY).convert("P")
    palette.save("grey.gif", interlace=False)
    Image.fromarray(GREY).save("interlaced.gif", interlace=True)
    noise = np.random.default_rng(1).integers(0, 256, (96, 96), np.uint8)
    Image.fromarray(noise).save("noise.gif")
    Image.fromarray(noise).save("noise.png")
    palette.save("film.gif", save_all=True, append_images=[Image.new("L", (24, 16))], duration=100)
    # A frame that covers a part of the picture. One of its two colours is transparent.
    with open("part.gif", "wb") as file:
        file.write(b"GIF89a\4\0\3\0\x80\0\0" + b"\xff\0\0\xff\xff\xff" + b"!\xf9\4\1\0\0\1\0")
        file.write(b",\1\0\1\0\2\0\1\0\0" + b"\2\2\x44\x0a\0;")
    with open("bomb.gif", "wb") as file:
        file.write(b"GIF89a" + struct.pack("<HH", 65535, 65535) + b"\x80\0\0" + bytes(6) + b",\0\0\0\0\1\0\1\0\0" + b"\2\2D\1\0;")


def encode_avif(name, *arguments):
    """Writes an AVIF. `arguments`: options of avifenc, and names of the pictures."""
    subprocess.run(["avifenc", "--jobs", "1", "--speed", "6", *arguments, name], check=True, stdout=subprocess.DEVNULL)


def avifs():
    lossless = ("--lossless",)
    grey = ("--min", "0", "--max", "0", "--yuv", "400")
    Image.fromarray(GREY).convert("RGB").save("upright.png")
    encode_avif("lossless.avif", *lossless, "upright.png")
    encode_avif("grey.avif", *grey, "upright.png")
    encode_avif("lossy.avif", "--min", "0", "--max", "5", "--yuv", "420", "upright.png")
    # By orientation: number of counter-clockwise quarter turns on display, then the axis of mirroring.
    turns = {1: [], 2: ["--imir", "1"], 3: ["--irot", "2"], 4: ["--imir", "0"], 5: ["--irot", "1", "--imir", "0"],
             6: ["--irot", "3"], 7: ["--irot", "1", "--imir", "1"], 8: ["--irot", "1"]}
    for orientation, turn in turns.items():
        stored = Image.fromarray(GREY).convert("RGB")
        if orientation in STORE:
            stored = stored.transpose(STORE[orientation])
        stored.save("stored.png")
        encode_avif(f"orientation-{orientation}.avif", *lossless, *turn, "stored.png")
    encode_avif("rgba.avif", *lossless, "rgba.png")
    encode_avif("premultiplied.avif", *lossless, "--premultiply", "rgba.png")
    encode_avif("grey-alpha.avif", *grey, "rgba.png")
    encode_avif("p3.avif", *lossless, "p3.png")
    encode_avif("p3-code-points.avif", *lossless, "--ignore-icc", "--cicp", "12/13/0", "p3.png")
    encode_avif("cropped.avif", *lossless, "--clap", "12,1,16,1,0,1,0,1", "upright.png")
    encode_avif("ramp.avif", *grey, "--depth", "12", "ramp.png")
    encode_avif("noise.avif", *lossless, "noise.png")
    Image.open("noise.png").crop((0, 0, 64, 64)).convert("RGB").save("left.png")
    Image.new("RGB", (64, 64), (255, 0, 0)).save("right.png")
    encode_avif("tiles.avif", *lossless, "--grid", "2x1", "left.png", "right.png")
    Image.new("RGB", (24, 16)).save("black.png")
    encode_avif("film.avif", *lossless, "upright.png", "black.png")
    # The combination of properties that needs most memory to decode.
    Image.new("RGBA", (1000, 1500), (255, 255, 255, 128)).save("large.png")
    encode_avif("large.avif", "--yuv", "444", "--depth", "12", "--grid", "2x2", *["large.png"] * 4)
    for name in ("upright.png", "stored.png", "black.png", "left.png", "right.png", "large.png"):
        pathlib.Path(name).unlink()
    with open("lossless.avif", "rb") as file:
        picture = file.read()
    with open("bomb.avif", "wb") as file:
        file.write(picture.replace(struct.pack(">II", 24, 16), struct.pack(">II", 30000, 30000)))


def box(name, *contents):
    data = b"".join(contents)
    return struct.pack(">I", 8 + len(data)) + name + data


def full_box(name, version, *contents):
    return box(name, struct.pack(">I", version << 24), *contents)


def boxes(data):
    """Returns the boxes of a file or a box, by name. Of boxes with the same name, the first one counts."""
    found, at = {}, 0
    while at < len(data):
        size, = struct.unpack_from(">I", data, at)
        found.setdefault(data[at + 4:at + 8], data[at + 8:at + size])
        at += size
    return found


def coded(name):
    """Returns the data of the only coded item of a HEIC or AVIF, and its size and configuration. The encoder of HEIC
    enlarges small pictures to 64 x 64 pixels, and writes a grid of this one tile, which crops them."""
    file = boxes(pathlib.Path(name).read_bytes())
    properties = boxes(boxes(boxes(file[b"meta"][4:])[b"iprp"])[b"ipco"])
    kinds = (b"ispe", b"hvcC", b"av1C")
    return file[b"mdat"], [box(kind, properties[kind]) for kind in kinds if kind in properties]


def size_box(width, height):
    return full_box(b"ispe", 0, struct.pack(">II", width, height))


def crop_box(width, height, whole=64):
    """Returns a crop to the upper left corner of a square of `whole` pixels."""
    return box(b"clap", struct.pack(">4I4i", width, 1, height, 1, width - whole, 2, height - whole, 2))


def heif(name, brand, items, references=()):
    """Writes a HEIF. `items`: type, data and properties of each; the first is the primary item. `references`: type,
    number of an item from 1 on, and the numbers of the items that it refers to."""
    def location(first):
        entries, at = b"", first
        for number, (_, data, _) in enumerate(items, 1):
            entries += struct.pack(">HHHII", number, 0, 1, at, len(data))
            at += len(data)
        return full_box(b"iloc", 0, struct.pack(">HH", 0x4400, len(items)), entries)

    properties = [each for _, _, own in items for each in own]
    associations = b""
    for number, (_, _, own) in enumerate(items, 1):
        associations += struct.pack(">HB", number, len(own))
        associations += bytes(0x80 * (each[4:8] != b"ispe") | properties.index(each) + 1 for each in own)
    infos = [full_box(b"infe", 2, struct.pack(">HH", number, 0), kind, b"\0") for number, (kind, _, _) in
             enumerate(items, 1)]
    links = [box(kind, struct.pack(">HH", item, len(others)), struct.pack(f">{len(others)}H", *others))
             for kind, item, others in references]
    start = box(b"ftyp", brand, bytes(4), brand, b"mif1")

    def meta(first):
        return full_box(
            b"meta", 0, full_box(b"hdlr", 0, bytes(4), b"pict", bytes(13)), full_box(b"pitm", 0, b"\0\1"),
            location(first), full_box(b"iinf", 0, struct.pack(">H", len(items)), *infos),
            box(b"iprp", box(b"ipco", *properties), full_box(b"ipma", 0, struct.pack(">I", len(items)), associations)),
            *([full_box(b"iref", 0, *links)] if links else []))

    data = box(b"mdat", *(each for _, each, _ in items))
    pathlib.Path(name).write_bytes(start + meta(len(start) + len(meta(0)) + 8) + data)


def encode_heic(name, picture, *arguments):
    """Writes a HEIC with one item, and a second one if the picture has alpha. Greys are exact. `arguments`: options of
    heif-enc."""
    picture.save("source.png")
    subprocess.run(["heif-enc", "-L", "-p", "chroma=444", "-p", "x265:info=0", "--matrix_coefficients=0", *arguments,
                    "-o", name, "source.png"], check=True, stdout=subprocess.DEVNULL)
    pathlib.Path("source.png").unlink()


def add_gain_map(source, name, brand, kind, crop):
    """Writes a picture with a gain map that claims to be much larger than the picture. `crop`: more properties of the
    picture."""
    data, properties = coded(source)
    kind_of_map = full_box(b"auxC", 0, b"urn:com:apple:photo:2020:aux:hdrgainmap\0")
    heif(name, brand, [(kind, data, properties + crop), (kind, data, [size_box(10000, 10000), *properties[1:], kind_of_map])],
         [(b"auxl", 2, [1])])


def heics():
    rgb = Image.fromarray(GREY).convert("RGB")
    encode_heic("lossless.heic", rgb)
    encode_heic("lossy.heic", rgb, "-q", "95", "-p", "lossless=false", "-p", "chroma=420", "--matrix_coefficients=6")
    # By orientation: the turns and mirrorings, in the order in which they are applied.
    steps = {1: [], 2: ["imir1"], 3: ["irot2"], 4: ["imir0"], 5: ["irot1", "imir0"], 6: ["irot3"],
             7: ["imir0", "irot1"], 8: ["irot1"]}
    for orientation, turns in steps.items():
        encode_heic("stored.heic", rgb.transpose(STORE[orientation]) if turns else rgb)
        data, properties = coded("stored.heic")
        crop = crop_box(16, 24) if orientation > 4 else crop_box(24, 16)
        turns = [box(turn[:4].encode(), bytes([int(turn[4])])) for turn in turns]
        heif(f"orientation-{orientation}.heic", b"heic", [(b"hvc1", data, [*properties, crop, *turns])])
    add_gain_map("lossless.heic", "gain-map.heic", b"heic", b"hvc1", [crop_box(24, 16)])
    add_gain_map("lossless.avif", "gain-map.avif", b"avif", b"av01", [])
    data, (_, configuration) = coded("lossless.heic")
    heif("bomb.heic", b"heic", [(b"hvc1", data, [size_box(30000, 30000), configuration])])

    rgba = Image.open("rgba.png")
    encode_heic("rgba.heic", rgba)
    multiplied = np.array(rgba)
    multiplied[..., :3] = np.rint(multiplied[..., :3] * (multiplied[..., 3:] / 255.0))
    encode_heic("premultiplied.heic", Image.fromarray(multiplied), "--premultiplied-alpha")
    encode_heic("p3.heic", Image.open("p3.png"))
    encode_heic("ramp.heic", Image.open("ramp.png"), "-b", "12")
    encode_heic("noise.heic", Image.open("noise.png"))
    tiles = []
    for tile in (Image.open("noise.png").crop((0, 0, 64, 64)).convert("RGB"), Image.new("RGB", (64, 64), (255, 0, 0))):
        encode_heic("tile.heic", tile)
        tiles.append((b"hvc1", *coded("tile.heic")))
    grid = (b"grid", struct.pack(">4BHH", 0, 0, 0, 1, 128, 64), [size_box(128, 64)])
    heif("tiles.heic", b"heic", [grid] + tiles, [(b"dimg", 1, [2, 3])])

    still = pathlib.Path("lossless.heic").read_bytes()
    track = full_box(b"stsz", 0, struct.pack(">III", 0, 2, 0))
    for name in (b"stbl", b"minf", b"mdia", b"trak", b"moov"):
        track = box(name, track)
    pathlib.Path("film.heic").write_bytes(still + track)
    pathlib.Path("track.heic").write_bytes(box(b"ftyp", b"hevc", bytes(4), b"msf1") + track)
    for name in ("stored.heic", "tile.heic"):
        pathlib.Path(name).unlink()


def main():
    grey = Image.fromarray(GREY)
    rgb = grey.convert("RGB")
    for orientation in range(1, 9):
        oriented(f"orientation-{orientation}.jpg", orientation, quality=95, subsampling=0)
    oriented("orientation-6.webp", 6, lossless=True)
    oriented("orientation-6.tif", 6)
    oriented("orientation-6.png", 6)

    grey.save("grey.jpg", quality=95)
    rgb.save("progressive.jpg", quality=95, progressive=True)
    Image.merge("CMYK", [Image.new("L", (24, 16), 0)] * 3 + [Image.fromarray(255 - GREY)]).save("cmyk.jpg", quality=95)
    rgb.save("lossy.webp", quality=90)
    rgb.save("lossless.webp", lossless=True)
    Image.fromarray(GREY.astype(np.uint16) * 257).save("grey-16.png")
    rgb.convert("P", palette=Image.Palette.ADAPTIVE).save("palette.png")
    rgb.save("lzw.tif", compression="tiff_lzw")
    Image.fromarray((GREY / 255).astype(np.float32)).save("float.tif")
    Image.fromarray(GREY > 100).save("bits-missing.tif")
    with open("linear.png", "wb") as file:
        rows = b"".join(b"\0" + row.tobytes() for row in GREY)
        file.write(header(24, 16, 8, 0) + chunk(b"gAMA", struct.pack(">I", 100000)))
        file.write(chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))

    shape = dict(t256=[24], t257=[16], t258=[8], t259=[1], t262=[1], t277=[1])
    tiff("big-endian.tif", [GREY.tobytes()], order=">", t278=[16], **shape)
    padded = np.pad(GREY, ((0, 0), (0, 8)))
    tiff("tiled.tif", [padded[:, :16].tobytes(), padded[:, 16:].tobytes()], t322=[16], t323=[16], **shape)
    tiff("huge-tile.tif", [GREY.tobytes()], t322=[65520], t323=[65520], **shape)

    # Rows of red, green, blue and 50 % grey; alpha rises from left to right: 0, 51, 102 ...
    colours = np.zeros((4, 6, 4), np.uint8)
    colours[0, :, 0] = colours[1, :, 1] = colours[2, :, 2] = 255
    colours[3, :, :3] = 128
    colours[:, :, 3] = np.arange(6) * 51
    Image.fromarray(colours).save("rgba.png")
    Image.fromarray(colours).save("rgba.webp", lossless=True, exact=True)
    Image.fromarray(np.dstack([colours[..., 0], colours[..., 3]])).save("grey-alpha.png")
    multiplied = np.rint(colours[..., :3] * (colours[..., 3:] / 255.0)).astype(np.uint8)
    tiff("premultiplied.tif", [np.dstack([multiplied, colours[..., 3:]]).tobytes()], t256=[6], t257=[4],
         t258=[8] * 4, t259=[1], t262=[2], t277=[4], t278=[4], t338=[1])
    seen = Image.fromarray(np.array([[0, 1, 2, 3]], np.uint8), "P")
    seen.putpalette([0, 0, 0, 255, 0, 0, 0, 255, 0, 255, 255, 255])
    seen.save("palette-transparent.png", transparency=1)

    profiled()
    bitmaps()
    films()
    avifs()
    heics()

    with open("bomb.png", "wb") as file:
        file.write(header(30000, 30000, 8, 2) + chunk(b"IDAT", zlib.compress(bytes(1000))) + chunk(b"IEND", b""))
    with open("bomb.webp", "wb") as file:
        picture = b"\x2f" + struct.pack("<I", 16383 | 16383 << 14) + bytes(11)
        file.write(b"RIFF" + struct.pack("<I", 12 + len(picture)) + b"WEBPVP8L" + struct.pack("<I", len(picture)))
        file.write(picture)


main()
