# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the results of the benchmark Scaling: time per site over the number of sites, with one thread and with all.

Usage: ccdt_bench --benchmark_filter=Scaling --benchmark_out=scaling.json --benchmark_out_format=json
       scaling_plot.py scaling.json scaling.svg
"""

import json
import math
import sys

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 720, 390, 64, 170, 30, 48
COLOURS = {"draft": "#3b6ea5", "standard": "#b5482f"}
QUALITIES = {"0": "draft", "1": "standard"}


def read(path):
    """Returns the points (sites, microseconds per site) of each line, by quality and threads; and the thread count."""
    lines, threads = {}, 0
    for run in json.load(open(path, encoding="utf-8"))["benchmarks"]:
        _, sites, quality = run["name"].split("/")[:3]
        threads = int(run["threads"]) if run["threads"] > 1 else threads
        for threads_of, counter in ((1, "ms_alone"), (2, "ms_together")):
            line = lines.setdefault((QUALITIES[quality], threads_of), [])
            line.append((int(sites), 1000 * run[counter] / int(sites)))
    return lines, threads


def main(source, target):
    lines, threads = read(source)
    xs = [math.log10(x) for line in lines.values() for x, _ in line]
    highest = math.ceil(max(y for line in lines.values() for _, y in line))

    def place(sites, time):
        x = LEFT + (math.log10(sites) - min(xs)) / (max(xs) - min(xs)) * (WIDTH - LEFT - RIGHT)
        return x, HEIGHT - BOTTOM - time / highest * (HEIGHT - TOP - BOTTOM)

    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" '
           'font-size="13" fill="#333">', f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>']
    for time in range(highest + 1):
        x, y = place(10 ** min(xs), time)
        svg.append(f'<path d="M{x:.1f} {y:.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>'
                   f'<text x="{x - 8:.1f}" y="{y + 4:.1f}" text-anchor="end">{time}</text>')
    for power in range(math.ceil(min(xs)), math.floor(max(xs)) + 1):
        x, y = place(10 ** power, 0)
        svg.append(f'<text x="{x:.1f}" y="{y + 18:.1f}" text-anchor="middle">10<tspan dy="-5" font-size="10">{power}'
                   '</tspan></text>')
    ends = {}  # heights of the labels at the ends of the lines, apart from each other
    for key, line in sorted(lines.items(), key=lambda item: place(*max(item[1]))[1]):
        ends[key] = max(place(*max(line))[1], max(ends.values(), default=0) + 16)
    for (quality, by), line in sorted(lines.items()):
        points = " ".join("%.1f,%.1f" % place(*point) for point in sorted(line))
        dashes = ' stroke-dasharray="6 4"' if by > 1 else ""
        svg.append(f'<polyline points="{points}" fill="none" stroke="{COLOURS[quality]}" stroke-width="2"{dashes}/>')
        x, y = place(*max(line))[0], ends[quality, by]
        name = f"{quality}, {threads} threads" if by > 1 else f"{quality}, 1 thread"
        svg.append(f'<text x="{x + 8:.1f}" y="{y + 4:.1f}" fill="{COLOURS[quality]}">{name}</text>')
    svg.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 8}" text-anchor="middle">sites</text>'
               f'<text x="{LEFT - 50}" y="{TOP - 14}">microseconds per site</text></svg>')
    with open(target, "w", encoding="utf-8") as file:
        file.write("\n".join(svg) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
