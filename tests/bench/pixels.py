#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares pictures for devices with those of other programs: prints the tables of results/pixels.md.

Usage: pixels.py [--peers FOLDER] URL PICTURE ...    For example: pixels.py http://localhost:8080 photo.jpg

The tables are in Markdown. They have the error of the picture that an eye sees, after Gaussian blurs in linear light.
In black and white, it is the peak signal-to-noise ratio in dB of luminance, at 1.5 pixels, and the mean |dL*|, at 3
pixels. In colours it is the mean CIEDE2000, at 2 pixels: from the picture in the range of the device, and from the
picture as it is. Pictures are shrunk to 800 pixels in black and white, and to 400 in colours. Their colour profiles are
ignored.

Error diffusion is that of Floyd and Steinberg in linear light, with alternating directions. peers.py lists the other
programs; FOLDER has those that are not installed on the system. Only the best result of all of them is printed, for
each picture and each measure. In colours, the other programs get both the picture in the range of the device and the
picture as it is.
"""
import argparse
import io
import itertools
import pathlib
import sys
import urllib.request

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter

import peers as other_programs

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
from seen import ciede2000, lab, lightness  # pylint: disable=wrong-import-position

TO_LUMINANCE = np.array((0.2126, 0.7152, 0.0722))
BLACK_AND_WHITE = np.array([[0.0] * 3, [1.0] * 3])

# Colours as they look, as in api/input/device.cpp.
PANELS = {
    "spectra6": ((26, 13, 35), (185, 202, 205), (202, 184, 0), (121, 9, 0), (0, 69, 139), (40, 82, 57)),
    "acep7": ((25, 30, 33), (241, 241, 241), (83, 164, 40), (49, 49, 143), (210, 14, 19), (243, 207, 17), (184, 94, 28))}


def light_of(values):
    values = np.asarray(values) / 255
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def diffused(wanted, palette):
    """Returns the numbers of the palette's colours that error diffusion chooses."""
    rows, columns = wanted.shape[:2]
    left = np.pad(wanted, ((0, 1), (1, 1), (0, 0)))  # with a margin that takes the errors at the borders
    result = np.zeros((rows, columns), int)
    for y in range(rows):
        step = 1 if y % 2 == 0 else -1
        for x in range(columns)[::step]:
            value = left[y, x + 1]
            result[y, x] = ((palette - value) ** 2).sum(-1).argmin()
            error = value - palette[result[y, x]]
            left[y, x + 1 + step] += error * 7 / 16
            left[y + 1, x + 1 - step] += error * 3 / 16
            left[y + 1, x + 1] += error * 5 / 16
            left[y + 1, x + 1 + step] += error / 16
    return result


def blurred(light, sigma):
    return gaussian_filter(light, (sigma, sigma, 0))


def errors_of_grey(chosen, wanted):
    seen, wanted = chosen.astype(float), wanted @ TO_LUMINANCE
    fine = gaussian_filter(seen - wanted, 1.5)
    tones = [lightness(gaussian_filter(values, 3)) for values in (seen, wanted)]
    return 10 * np.log10((fine ** 2).mean()), np.abs(tones[0] - tones[1]).mean()


def errors_of_colour(chosen, palette, *wanted):
    seen = lab(blurred(palette[chosen], 2))
    return [ciede2000(seen, lab(blurred(light, 2))).mean() for light in wanted]


def nearest_of(corners):
    """Returns the weights of the points nearest to the origin in simplices [n, corners, 3] of 1 to 3 corners."""
    sides = corners[:, 1:] - corners[:, :1]
    weights = np.zeros(corners.shape[:2])
    if sides.shape[1]:
        gram = np.einsum("nij,nkj->nik", sides, sides)
        weights[:, 1:] = -np.einsum("nij,nj->ni", np.linalg.pinv(gram), np.einsum("nij,nj->ni", sides, corners[:, 0]))
    weights[:, 0] = 1 - weights.sum(1)
    return weights


def within_range(light, palette):
    """Returns a picture in the range of a device: scaled, then moved to the mixtures of the palette that look most like
    it, in CIELAB that is linear around each colour."""
    order = np.argsort(palette @ TO_LUMINANCE)
    dark, white = palette[order[0]], palette[order[-1]]
    scaled = (dark + light * (white - dark)).reshape(-1, 3)
    at, step = np.maximum(scaled, 0.01), 1e-3
    slopes = np.stack([(lab(at + step * axis) - lab(at)) / step for axis in np.eye(3)], -1)
    corners = np.einsum("nij,nkj->nki", slopes, palette - scaled[:, None])
    best, least = scaled.copy(), np.full(len(scaled), np.inf)
    for tetrahedron in itertools.combinations(range(len(palette)), 4):
        edges = (palette[list(tetrahedron[1:])] - palette[tetrahedron[0]]).T
        shares = np.linalg.solve(edges, (scaled - palette[tetrahedron[0]]).T)
        least[(shares >= -1e-9).all(0) & (shares.sum(0) <= 1 + 1e-9)] = 0
    for count in (1, 2, 3):
        for simplex in map(list, itertools.combinations(range(len(palette)), count)):
            weights = nearest_of(corners[:, simplex])
            distance = (np.einsum("nk,nkj->nj", weights, corners[:, simplex]) ** 2).sum(-1)
            nearer = (weights >= 0).all(1) & (distance < least)
            best[nearer], least[nearer] = (weights @ palette[simplex])[nearer], distance[nearer]
    return best.reshape(light.shape)


def answer(url, device, image):
    """Returns the numbers of the device's colours in the server's picture."""
    file = io.BytesIO()
    image.save(file, "PNG")
    with urllib.request.urlopen(f"{url}/halftone?device={device}", file.getvalue()) as reply:
        picture = Image.open(io.BytesIO(reply.read()))
        return np.asarray(picture).astype(int)


def opened(path, side):
    image = Image.open(path).convert("RGB")
    image.info.clear()
    image.thumbnail((side, side))
    return image, light_of(image)


def best_of(results):
    """Returns the least error in each measure, each with the name of its program."""
    return [min((errors[i], name) for name, errors in results) for i in range(2)] if results else []


def in_grey(errors):
    return f"{-errors[0]:.1f} dB / {errors[1]:.2f}"


def in_colours(errors):
    return " / ".join(f"{error:.2f}" for error in errors)


def row(name, ours, diffusion, best, text):
    others = "-" if not best else text([error for error, _ in best]) + f" ({', '.join(dict.fromkeys(n for _, n in best))})"
    print(f"| `{name}` | {text(diffusion)} | {others} | {text(ours)} |", flush=True)


def compare_grey(url, paths, folder):
    print("| picture | error diffusion | best other program | `device=1bit` |\n|---|---|---|---|")
    for path in paths:
        image, light = opened(path, 800)
        grey = np.repeat((light @ TO_LUMINANCE)[..., None], 3, -1)
        results = [(name, errors_of_grey(chosen, light))
                   for name, chosen in other_programs.shown(grey, BLACK_AND_WHITE, folder)]
        diffusion = errors_of_grey(diffused(grey, BLACK_AND_WHITE), light)
        row(path.name, errors_of_grey(answer(url, "1bit", image), light), diffusion, best_of(results), in_grey)


def compare_colours(url, device, paths, folder):
    print(f"\n| picture | error diffusion | best other program | `device={device}` |\n|---|---|---|---|")
    palette = light_of(PANELS[device])
    for path in paths:
        image, light = opened(path, 400)
        wanted = within_range(light, palette)
        results = [(name, errors_of_colour(chosen, palette, wanted, light)) for source in (wanted, light)
                   for name, chosen in other_programs.shown(source, palette, folder)]
        diffusion = errors_of_colour(diffused(wanted, palette), palette, wanted, light)
        ours = errors_of_colour(answer(url, device, image), palette, wanted, light)
        row(path.name, ours, diffusion, best_of(results), in_colours)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", metavar="FOLDER", help="folder with the programs that peers.py lists")
    parser.add_argument("url")
    parser.add_argument("pictures", nargs="+", type=pathlib.Path)
    options = parser.parse_args()
    compare_grey(options.url, options.pictures, options.peers)
    for device in PANELS:
        compare_colours(options.url, device, options.pictures, options.peers)


if __name__ == "__main__":
    main()
