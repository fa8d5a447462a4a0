#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the patterns that a server makes on a torus, and prints them as a Markdown table.

Usage: torus.py URL SITES SETS QUALITY ...    For example: torus.py http://localhost:8080 1024 10 draft standard best

The sets have the seeds 1 to SETS. The minimum and mean distance are relative to a hexagonal grid; the power is relative
to white noise, below a frequency in units of sqrt(sites). The last column is the mean time to place a set.
"""
import json
import sys
import urllib.request

import numpy

TORUS = {"type": "torus", "width": 1, "height": 1}


def post(url, body):
    request = urllib.request.Request(url, json.dumps(body).encode(), {"Content-Type": "application/json"})
    with urllib.request.urlopen(request) as answer:
        return json.load(answer)


def row(url, sites, sets, quality):
    made = [post(f"{url}/sample", {"sites": sites, "seed": seed, "quality": quality, "domain": TORUS})
            for seed in range(1, sets + 1)]
    found = post(f"{url}/analyze", {"sets": [each["points"] for each in made], "domain": TORUS, "max_frequency": 1,
                                    "spectrum": True})
    height, width = found["spectrum"]["height"], found["spectrum"]["width"]
    spectrum = numpy.array(found["spectrum"]["values"], dtype=float).reshape(height, width)
    y, x = numpy.ogrid[:height, :width]
    frequency = numpy.hypot(x - width // 2, y - height // 2) / sites ** 0.5

    def powers(limit):
        return spectrum[(frequency > 0) & (frequency < limit)]

    return (f"{quality}, {sites:,} sites", f"{found['min_distance']:.2f}", f"{found['mean_distance']:.3f}",
            f"{powers(0.5).mean():.1e}", f"{powers(0.25).mean():.1e}", f"{powers(0.5).max():.0e}",
            f"{sum(each['elapsed_ms'] for each in made) / sets:.3g} ms")


def main(url, sites, sets, *qualities):
    print(f"| torus, {sets} sets | minimum distance | mean distance | power below 0.5 | power below 0.25 | "
          "largest power below 0.5 | time |\n|---|---|---|---|---|---|---|")
    for quality in qualities:
        print("|", " | ".join(row(url, int(sites), int(sets), quality)), "|", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
