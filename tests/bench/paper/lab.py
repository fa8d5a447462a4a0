# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts that all figures share: requests to the server, numbers of sites and runs, and storage for the drawings."""

import base64
import io
import re
import statistics
from dataclasses import dataclass
from pathlib import Path

import numpy
from PIL import Image

from harness import PICTURES, Server, ask, post_json

TORUS = {"type": "torus", "width": 1, "height": 1}


@dataclass(frozen=True, eq=False)
class Method:
    name: str
    file: str
    colour: str
    options: dict


RANDOM = Method("random", "random", "#999999", {"method": "random"})
CVT = Method("CVT", "cvt", "#e69f00", {"method": "cvt"})
ODT = Method("ODT", "odt", "#56b4e9", {"method": "odt"})
CCVT = Method("CCVT", "ccvt", "#009e73", {"method": "ccvt"})
CCDT = Method("CCDT", "ccdt", "#d55e00", {"quality": "draft"})
POLISHED = Method("CCDT, polished", "ccdt-polished", "#0072b2", {"quality": "standard"})


@dataclass(frozen=True)
class Halftone:
    picture: str
    sites: int

    def file(self):
        return PICTURES / f"{self.picture}.png"


@dataclass(frozen=True)
class Effort:
    """Sizes and numbers of runs; by default those of the paper."""
    mesh_sites: int = 1024
    iterations: int = 20
    ramp_sites: int = 1000
    ramp_seeds: int = 20
    spectrum_sites: int = 1024
    sets: int = 10
    sizes: tuple = (1024, 4096, 16384, 65536)
    runs: int = 11       # maximum number of runs for a timing
    seconds: float = 20  # time after which no more runs begin
    halftones: tuple = (Halftone("camera", 4096), Halftone("chelsea", 4096), Halftone("astronaut", 16384))


QUICK = Effort(mesh_sites=200, iterations=6, ramp_sites=300, ramp_seeds=2, spectrum_sites=144, sets=2,
               sizes=(64, 128, 51200), runs=2, seconds=0.2,
               halftones=(Halftone("camera", 400), Halftone("chelsea", 200)))


class Refused(Exception):
    """The server refused a request because it is too large."""


@dataclass(frozen=True)
class Lab:
    server: Server
    effort: Effort
    folder: Path

    def sample(self, method, sites, seed, **more):
        answer = post_json(self.server, "/sample", {"sites": sites, "seed": seed, **method.options, **more})
        if answer.status == 413:
            raise Refused(answer.json()["detail"])
        return _checked(answer).json()

    def analyze(self, sets, **more):
        return _checked(post_json(self.server, "/analyze", {"sets": sets, **more}))

    def halftone(self, halftone, method, seed=1, **more):
        # In the paper, dots follow the density alone, regardless of overlaps.
        options = {"sites": halftone.sites, "seed": seed, "tone": "density", **method.options, **more}
        query = "&".join(f"{name}={value}" for name, value in options.items())
        return _checked(ask(self.server, f"/halftone?{query}", data=halftone.file().read_bytes()))

    def time_halftone(self, halftone, method, **more):
        return self.median(lambda seed: seconds_of_work(self.halftone(halftone, method, seed, **more)))

    def figure(self, name):
        return self.folder / "figures" / name

    def save_bits(self, name, paper):
        """Saves a bilevel picture. paper: [height, width], true where it is white"""
        Image.fromarray(paper).save(self.figure(name), optimize=True)

    def save_greys(self, name, picture):
        """Saves a picture in sixteen levels of grey."""
        levels = Image.fromarray(numpy.asarray(picture.convert("L")) // 16, "P")
        levels.putpalette([17 * level for level in range(16) for _ in "rgb"])
        levels.save(self.figure(name), optimize=True, bits=4)

    def median(self, measure):
        """Calls measure(seed), which returns seconds, repeatedly. Returns the median and the number of runs."""
        taken = []
        while not taken or (len(taken) < self.effort.runs and sum(taken) < self.effort.seconds):
            taken.append(measure(len(taken) + 1))
        return statistics.median(taken), len(taken)


def _checked(answer):
    if answer.status != 200:
        raise RuntimeError(f"the server refused: {answer}")
    return answer


def seconds_of_work(answer):
    """Returns the seconds from the last byte of the request to the first byte of the answer, except the wait for a
    worker."""
    stages = dict(re.findall(r"(\w+);dur=([\d.]+)", answer.headers["server-timing"]))
    return sum(float(stages[name]) for name in ("decode", "prepare", "optimise", "encode")) / 1000


def data_of(file):
    return base64.b64encode(file.read_bytes()).decode()


def picture_of(answer):
    return Image.open(io.BytesIO(answer.body))
