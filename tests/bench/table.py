#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints results of ccdt_bench as a Markdown table, with a row for each run and a column for each counter.

Usage: ccdt_bench --benchmark_filter=Square --benchmark_out=results.json --benchmark_out_format=json
       table.py results.json [--qualities] COUNTER ...        For example: table.py results.json --qualities over_delaunay

With --qualities, the runs of a benchmark that differ only in the quality are one row, with columns for draft, standard
and best, whose cells have all counters. The quality is the last argument of a benchmark or, if its name ends with
Pattern or Tone, the first.
"""
import argparse
import json

QUALITIES = ("draft", "standard", "best")


def name_of(run):
    """Returns the name of a benchmark and its arguments, without settings such as `min_time:2`."""
    name, *arguments = (part for part in run["name"].split("/") if ":" not in part and part != "manual_time")
    return name, arguments


def without_quality(run):
    name, arguments = name_of(run)
    quality = QUALITIES[int(arguments.pop(0 if name.endswith(("Pattern", "Tone")) else -1))]
    return " ".join([name, *(f"{int(argument):,}" for argument in arguments)]), quality


def cells(run, counters):
    return [f"{run[counter]:.3g}" for counter in counters]


def table(runs, counters):
    yield "benchmark", *counters
    for run in runs:
        name, arguments = name_of(run)
        yield " ".join([name, *arguments]), *cells(run, counters)


def table_of_qualities(runs, counters):
    rows = {}
    for run in runs:
        row, quality = without_quality(run)
        rows.setdefault(row, {})[quality] = " / ".join(cells(run, counters))
    yield " / ".join(counters), *QUALITIES
    for row, found in rows.items():
        yield row, *(found.get(quality, "") for quality in QUALITIES)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", type=argparse.FileType(encoding="utf-8"))
    parser.add_argument("--qualities", action="store_true")
    parser.add_argument("counters", nargs="+", metavar="COUNTER")
    arguments = parser.parse_args()
    runs = [run for run in json.load(arguments.results)["benchmarks"] if set(arguments.counters) <= set(run)]
    lines = [*(table_of_qualities if arguments.qualities else table)(runs, arguments.counters)]
    for line in [lines[0], ["---"] * len(lines[0]), *lines[1:]]:
        print("|", " | ".join(line), "|")


if __name__ == "__main__":
    main()
