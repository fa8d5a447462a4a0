# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs Yuksel's sample elimination on a surface or in space, with the header of a copy of his library.

    git clone https://github.com/cemyuksel/cyCodeBase
"""
import pathlib
import subprocess
import tempfile

import numpy

PROGRAM = """
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "cyVector.h"

#include "cySampleElim.h"

// Reads numbers of samples and points, the number of dimensions, the area or volume, whether the unit cube is a torus,
// and samples as text. Writes the milliseconds and the chosen points.
int main() {
    std::size_t samples, count;
    int dimensions, is_torus;
    double size;
    if (std::scanf("%zu %zu %d %lf %d", &samples, &count, &dimensions, &size, &is_torus) != 5) return 1;
    std::vector<cy::Vec3d> given(samples), chosen(count);
    for (auto& p : given) {
        if (std::scanf("%lf %lf %lf", &p.x, &p.y, &p.z) != 3) return 1;
    }
    const auto begin = std::chrono::steady_clock::now();
    cy::WeightedSampleElimination<cy::Vec3d, double, 3, std::size_t> elimination;
    const double reach = 2 * elimination.GetMaxPoissonDiskRadius(dimensions, count, size);
    elimination.SetTiling(is_torus != 0);
    elimination.Eliminate(given.data(), samples, chosen.data(), count, false, reach, dimensions);
    const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - begin;
    std::printf("%.3f\\n", elapsed.count());
    for (const auto& p : chosen) std::printf("%.17g %.17g %.17g\\n", p.x, p.y, p.z);
}
"""


class Elimination:
    """A compiled program. Use it in a `with` statement, which removes the program at the end."""

    def __init__(self, library):
        self.library = library
        self.folder = tempfile.TemporaryDirectory()
        self.program = pathlib.Path(self.folder.name, "elimination")

    def __enter__(self):
        source = self.program.with_suffix(".cpp")
        source.write_text(PROGRAM, encoding="ascii")
        subprocess.run(["c++", "-std=c++20", "-O3", "-march=native", "-w", "-I", self.library, source, "-o",
                        self.program, "-pthread"], check=True, timeout=300)
        return self

    def __exit__(self, *_):
        self.folder.cleanup()

    def choose(self, samples, count, size, dimensions=2, is_torus=False):
        """Chooses points among samples, and returns them with the milliseconds of the choice.

        Args:
            size: area of the surface, or volume.
            is_torus: whether the domain is the unit cube with joined faces.
        """
        rows = (" ".join(map(repr, p)) for p in samples.tolist())
        text = f"{len(samples)} {count} {dimensions} {size!r} {int(is_torus)}\n" + "\n".join(rows)
        done = subprocess.run([self.program], input=text, capture_output=True, text=True, check=True, timeout=3600)
        elapsed, *rows = done.stdout.splitlines()
        return numpy.array([row.split() for row in rows], dtype=float), float(elapsed)
