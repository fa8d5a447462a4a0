# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes six pictures in a folder: gallery.py FOLDER. Editors that know percent cells run it step by step."""

# %% Pictures and maps of the tests of this project
import pathlib
import sys

import ccdt
import numpy as np
from PIL import Image

DATA = pathlib.Path(__file__).resolve().parents[3] / "tests" / "data"
OUTPUT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")

# %% A photograph as dots: ink where it is light, bare paper where it is dark
halftone = ccdt.halftone(DATA / "images" / "camera.png", width=800, sites=12_000)
halftone.save(OUTPUT / "halftone.png")
print(f"{len(halftone)} dots, the largest with a radius of {halftone.radius:.2f} pixels of the photograph")

# %% The same in three colours, from an array
photograph = np.asarray(Image.open(DATA / "images" / "chelsea.png"))
ccdt.halftone(photograph, color="cmyk", width=800).save(OUTPUT / "colour.png")

# %% Pixels of electronic paper with six colours
panel = ccdt.halftone(photograph, device="spectra6", width=600, height=400, fit="cover")
panel.save(OUTPUT / "device.png")
print(f"{len(np.unique(panel.image().reshape(-1, 3), axis=0))} colours")

# %% Points on a map, evenly spread on the earth's surface
country = DATA / "polygons" / "Switzerland-10m.geojson"
ccdt.sample(country, 4000, coordinates="lonlat", width=800).save(OUTPUT / "map.png")

# %% The spectrum of points on a torus: no power at low frequencies
points = ccdt.sample(ccdt.Torus(), 4096)
spectrum = ccdt.analyze(points)
spectrum.save(OUTPUT / "spectrum.png")
print(f"mean power below half of the principal frequency: {spectrum.low_frequency_power:.1e}")

# %% Dithering with a threshold mask: one comparison for each pixel
grey = np.asarray(Image.open(DATA / "images" / "camera.png").convert("L"))
tile = ccdt.mask(64)
mask = np.tile(tile, (grey.shape[0] // 64 + 1, grey.shape[1] // 64 + 1))[:grey.shape[0], :grey.shape[1]]
light = np.where(grey <= 10.31475, grey / 3294.6, ((grey / 255 + 0.055) / 1.055) ** 2.4)  # sRGB to linear light
Image.fromarray(light * 255 > mask).save(OUTPUT / "mask.png")
