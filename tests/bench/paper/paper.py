# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes all figures by a server, and writes their page. It is started by `run`."""

import argparse
import json
import os
import shutil
import sys
import tempfile
from pathlib import Path

import figures
import page
from harness import Server
from lab import QUICK, Effort, Lab

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent.parent

# Load average above which other programs are running, so that times are not reliable.
BUSY = 0.5


def arguments():
    parser = argparse.ArgumentParser(prog="tests/bench/paper/run", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="use small numbers, only to check that everything works")
    parser.add_argument("--output", type=Path, help="folder to write to")
    chosen = parser.parse_args()
    chosen.output = chosen.output or (ROOT / "build" / "paper" if chosen.quick else HERE)
    return chosen


def measure(lab):
    return {"figure_1": figures.polygons(lab), "figure_3": figures.ramp(lab), "figure_4": figures.spectra(lab),
            "timings": figures.timings(lab), "figure_5": figures.evolution(lab), "figure_6": figures.halftones(lab)}


def replace(output, made):
    """Copies the new files, after removing all old figures, so that no obsolete one remains."""
    for old in (output / "figures").glob("figure-*"):
        old.unlink()
    shutil.copytree(made, output, dirs_exist_ok=True)


def main():
    chosen = arguments()
    load = os.getloadavg()[0]
    if load > BUSY and not chosen.quick:
        print(f"the machine is busy (load {load:.1f}), so the times are not reliable", file=sys.stderr)
    with tempfile.TemporaryDirectory() as name, Server("--workers=1", "--timeout=110") as server:
        made = Path(name) / "paper"
        (made / "figures").mkdir(parents=True)
        effort = QUICK if chosen.quick else Effort()
        results = {"machine": page.machine(load), **measure(Lab(server, effort, made))}
        (made / "results.json").write_text(json.dumps(results, indent=1) + "\n")
        (made / "README.md").write_text(page.write(results, effort, chosen.output))
        replace(chosen.output, made)


if __name__ == "__main__":
    main()
