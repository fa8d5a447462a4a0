# SPDX-License-Identifier: GPL-3.0-or-later
"""Times of the Python package: PYTHONPATH=build/test/python /usr/bin/python3 tests/bench/python.py [SERVER_URL]

Prints the table of results/python.md: the least processor time of several runs, of all threads, in milliseconds.
Processor time varies less on a busy machine. With the URL of a server without a cache, the table also has the times of
the client, without those of the server.
"""

import json
import pathlib
import subprocess
import sys
import time

import ccdt
import numpy as np
from PIL import Image

PICTURE = pathlib.Path(__file__).resolve().parents[1] / "data" / "images" / "camera.png"


def least(function, runs=15):
    """Returns the least processor time of several calls, in milliseconds."""
    times = []
    for _ in range(runs):
        start = time.process_time()
        function()
        times.append(1000 * (time.process_time() - start))
    return min(times)


def loading(statement, runs=15):
    """Returns the least processor time of a statement in a new interpreter that has imported NumPy, in milliseconds."""
    script = ("import numpy, time; start = time.process_time()\n" + statement
              + "\nprint(1000 * (time.process_time() - start))")
    return min(float(subprocess.run([sys.executable, "-c", script], capture_output=True, check=True).stdout)
               for _ in range(runs))


def main():
    pixels = np.asarray(Image.open(PICTURE))
    grid = np.random.default_rng(0).random((1000, 1000))
    points = ccdt.sample(ccdt.Torus(), 100_000, quality="draft")
    rows = [
        ("`import ccdt`", loading("import ccdt")),
        ("`import ccdt; ccdt.sample`, which loads the extension", loading("import ccdt; ccdt.sample")),
        ("`import ccdt._codec`, which loads the decoders of files", loading("import ccdt._codec")),
        ("`sample(Torus(), 1000)`", least(lambda: ccdt.sample(ccdt.Torus(), 1000))),
        ("`sample(Torus(), 100_000)`", least(lambda: ccdt.sample(ccdt.Torus(), 100_000), 3)),
        ("`write(\"npy\")` of these, without a copy for the array", least(lambda: points._answer("npy"))),
        ("`write(\"json\")` of these and its reading, for `info`",
         least(lambda: json.loads(points.write("json")))),
        ("`halftone(array)`, 512 x 512", least(lambda: ccdt.halftone(pixels), 5)),
        ("`halftone(array, device=\"1bit\")`, 512 x 512", least(lambda: ccdt.halftone(pixels, device="1bit"), 5)),
        ("writing of a density of 1,000 x 1,000 values as JSON",
         least(lambda: ccdt._request.array_json(grid, "density"), 5)),
        ("the same by the module `json`", least(lambda: json.dumps(grid.tolist()), 5)),
    ]
    if len(sys.argv) > 1:
        client = ccdt.Client(sys.argv[1])
        rows.append(("`Client.sample(Torus(), 1000, format=\"npy\")`",
                     least(lambda: client.sample(ccdt.Torus(), 1000, format="npy"))))
        rows.append(("`Client.halftone(file)`, 512 x 512", least(lambda: client.halftone(PICTURE), 5)))
    print("| | ms |\n|---|---|")
    for name, milliseconds in rows:
        print(f"| {name} | {milliseconds:,.1f} |")


if __name__ == "__main__":
    main()
