# SPDX-License-Identifier: GPL-3.0-or-later
"""Reproduces the paper's figures. Each function sends requests, draws a figure, and returns its numbers."""

import numpy

import tone
from drawing import GREY, Axis, Box, Curve, Svg, decades, steps
from lab import CCDT, CCVT, CVT, ODT, POLISHED, RANDOM, TORUS, Refused, data_of, picture_of

POLYGONS = {"convex": [[0, 2], [3, 0], [8, 1], [10, 5], [7, 9], [2, 8]],
            "concave": [[0, 0], [10, 0], [9, 4], [6, 3], [5, 5], [7, 7], [10, 6], [10, 10], [1, 10], [2, 5]]}

# Times on the authors' machine, in seconds, by the number of sites.
PAPER_TIMES = {CCVT: {1024: 2.8, 4096: 24.8, 16384: 497}, CCDT: {1024: 0.3, 4096: 1.4, 16384: 4.3}}

# Scale of the drawings in figure 6: pixels per pixel of the picture.
SCALE = 2

# Colours of triangles, by the lower bound of their area relative to the median.
SHADES = ((0, "#2166ac"), (0.5, "#92c5de"), (0.8, "#dddddd"), (1.25, "#f4a582"), (2, "#b2182b"))


def polygons(lab):
    """Draws figure 1: meshes of polygons, and the fall of the variance."""
    return {name: _polygon(lab, name, {"polygon": corners}) for name, corners in POLYGONS.items()}


def _polygon(lab, name, domain):
    sites, iterations = lab.effort.mesh_sites, lab.effort.iterations
    start = lab.sample(CCDT, sites, 1, iterations=0, mesh=True, **domain)
    end = lab.sample(CCDT, sites, 1, iterations=iterations, mesh=True, **domain)
    others = {"polished": POLISHED, "random": RANDOM}
    variations = {of: lab.sample(method, sites, 1, **domain)["variation"] for of, method in others.items()}
    trace = [entry["variation"] for entry in end["trace"]]

    svg = Svg(1140, 420)
    for result, left, title in ((start, 10, "start"), (end, 380, f"after {iterations} iterations")):
        svg.text(left + 180, 30, f"{title}: variation {result['variation']:.3f}", "middle", 'font-weight="bold"')
        _triangles(svg, Box(left, 40, 360, 340), result)
    _shades(svg, 300, 405)
    variance = [value ** 2 for value in trace]
    passes = [5 * i for i in range(len(trace))]
    curve = Curve("", passes, variance, CCDT.colour, marks=True)
    svg.chart(Box(810, 50, 310, 310), "variance of area over target", Axis("passes", steps(0, passes[-1])),
              Axis("", decades(min(variance), max(variance)), log=True), [curve])
    svg.save(lab.figure(f"figure-1-{name}.svg"))
    return {"sites": sites, "trace": trace, **variations}


def _triangles(svg, box, result):
    corners = box.fit(result["vertices"])[numpy.array(result["triangles"])]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = numpy.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    bounds = [bound for bound, _ in SHADES]
    shade = numpy.digitize(areas / numpy.median(areas), bounds) - 1
    for i, (_, colour) in enumerate(SHADES):
        svg.triangles(corners[shade == i], colour)


def _shades(svg, x, y):
    svg.text(x - 10, y, "area over the median, from", "end")
    for i, (bound, colour) in enumerate(SHADES):
        at = x + 60 * i
        svg.rectangle(Box(at, y - 10, 12, 12), f'fill="{colour}"')
        svg.text(at + 16, y, f"{bound:g}")


def ramp(lab):
    """Reproduces figure 3: the density x^2, with x from 0 to 1 along a strip of four squares."""
    cells = 256
    edges = numpy.arange(cells + 1) ** 3
    request = {"domain": {"type": "rectangle", "width": 4, "height": 1},
               "density": {"width": cells, "height": 1, "values": numpy.diff(edges).tolist()}}
    methods = (RANDOM, CCVT, CCDT, POLISHED)
    sets = {method: [numpy.array(lab.sample(method, lab.effort.ramp_sites, seed, **request)["points"])
                     for seed in range(1, lab.effort.ramp_seeds + 1)] for method in methods}
    exact = (numpy.diff(edges[::cells // 4]) / edges[-1]).tolist()
    shares = {method.name: [_quarters(points) for points in sets[method]] for method in methods}
    _draw_ramp(lab, exact, {method: sets[method][0] for method in methods})
    return {"sites": lab.effort.ramp_sites, "seeds": lab.effort.ramp_seeds, "exact": exact, "shares": shares}


def _quarters(points):
    return (numpy.bincount(points[:, 0].astype(int), minlength=4) / len(points)).tolist()


def _draw_ramp(lab, exact, first):
    svg = Svg(720, 100 + 205 * len(first))
    columns = 120
    for i in range(columns):
        svg.rectangle(Box(110 + 5 * i, 10, 5, 40), f'fill-opacity="{((i + 0.5) / columns) ** 2:.4f}"')
    _label_quarters(svg, 65, "density", exact)
    for row, (method, points) in enumerate(first.items()):
        top = 85 + 205 * row
        box = Box(110, top, 600, 150)
        svg.dots(numpy.array([110, top + 150]) + points * (150, -150), 1.3)
        for quarter in (1, 2, 3):
            svg.line(110 + 150 * quarter, top, 110 + 150 * quarter, top + 150, GREY)
        svg.frame(box)
        _label_quarters(svg, top + 167, method.name, _quarters(points))
    svg.save(lab.figure("figure-3.svg"))


def _label_quarters(svg, y, name, shares):
    svg.text(100, y, name, "end")
    for quarter, share in enumerate(shares):
        svg.text(185 + 150 * quarter, y, f"{100 * share:.2f} %", "middle")


def spectra(lab):
    """Draws figure 4: spectra of the methods."""
    analyses = {method: _spectrum(lab, method) for method in (CVT, ODT, CCVT, CCDT, POLISHED)}
    svg = Svg(1140, 380)
    curves = [[Curve(method.name, found["frequency"], found[member], method.colour)
               for method, found in analyses.items()] for member in ("power", "anisotropy_db")]
    frequency = Axis("frequency, in units of the square root of points over area", range(5))
    svg.chart(Box(50, 40, 420, 280), "radially averaged power", frequency, _linear_axis(curves[0], 0), curves[0])
    svg.chart(Box(560, 40, 420, 280), "anisotropy, dB", frequency, _linear_axis(curves[1]), curves[1])
    svg.legend(1000, 60, curves[0])
    svg.save(lab.figure("figure-4-curves.svg"))
    return {"sites": lab.effort.spectrum_sites, "sets": lab.effort.sets,
            "methods": {method.name: _figures_of(found) for method, found in analyses.items()}}


def _spectrum(lab, method):
    runs = [lab.sample(method, lab.effort.spectrum_sites, seed, domain=TORUS)
            for seed in range(1, lab.effort.sets + 1)]
    sets = [run["points"] for run in runs]
    plot = picture_of(lab.analyze(sets, format="png"))
    lab.save_greys(f"figure-4-{method.file}.png", plot.resize((1100, 396)))
    found = lab.analyze(sets).json()
    found["variation"] = float(numpy.mean([run["variation"] for run in runs]))
    return found


def _linear_axis(curves, low=None):
    values = [value for curve in curves for value in curve.y]
    return Axis("", steps(min(values) if low is None else low, max(values)))


def _figures_of(found):
    """Summarizes an analysis in numbers. Rings below half the principal frequency have too few frequencies for the
    anisotropy."""
    frequency, power, anisotropy = (numpy.array(found[name]) for name in ("frequency", "power", "anisotropy_db"))
    judged = anisotropy[frequency >= 0.5]
    oscillation = numpy.sqrt(((power[frequency >= 1.5] - 1) ** 2).mean())
    return {"peak": power.max(), "oscillation": oscillation,
            "low_frequency_power": found["low_frequency_power"],
            "anisotropy_mean": judged.mean(), "anisotropy_worst": judged.max(),
            "min_distance": found["min_distance"], "mean_distance": found["mean_distance"],
            "variation": found["variation"]}


def timings(lab):
    """Reproduces the timings of section 4.1: seconds for one set on the torus."""
    methods = (CVT, ODT, CCVT, CCDT, POLISHED)
    times = {method: {size: _time(lab, method, size) for size in lab.effort.sizes} for method in methods}
    taken = {method: {size: run["seconds"] for size, run in times[method].items() if "seconds" in run}
             for method in methods}
    curves = [Curve(method.name, list(of), list(of.values()), method.colour, marks=True)
              for method, of in taken.items() if of]
    curves += [Curve(f"{method.name}, the paper's", list(of), list(of.values()), method.colour, dashed=True, marks=True)
               for method, of in PAPER_TIMES.items()]
    x, y = ([value for curve in curves for value in getattr(curve, axis)] for axis in "xy")
    svg = Svg(720, 420)
    svg.chart(Box(70, 40, 420, 320), "seconds", Axis("sites", decades(min(x), max(x)), log=True),
              Axis("", decades(min(y), max(y)), log=True), curves)
    svg.legend(510, 60, curves)
    svg.save(lab.figure("figure-timings.svg"))
    return {method.name: times[method] for method in methods}


def _time(lab, method, sites):
    try:
        seconds, runs = lab.median(
            lambda seed: lab.sample(method, sites, seed, domain=TORUS)["elapsed_ms"] / 1000)
    except Refused as refusal:
        return {"refused": str(refusal)}
    return {"seconds": seconds, "runs": runs}


def evolution(lab):
    """Draws figure 5: a halftone after each iteration."""
    halftone = lab.effort.halftones[0]
    target = tone.ink(halftone.file())
    stages = [{"iterations": n, **_halftone(lab, halftone, CCDT, target, f"figure-5-{n}.png", scale=1, iterations=n)}
              for n in range(6)]
    return {"picture": halftone.picture, "sites": halftone.sites, "stages": stages}


def _halftone(lab, halftone, method, target, name, **more):
    lab.save_bits(name, lab.halftone(halftone, method, **more).picture())
    seconds, runs = lab.time_halftone(halftone, method, **more)
    points = numpy.array(lab.halftone(halftone, method, format="json", **more).json()["points"])
    return {"seconds": seconds, "runs": runs, "tone_error": tone.error(points, target)}


def halftones(lab):
    """Draws figure 6: halftones by several methods."""
    return [_compare(lab, halftone) for halftone in lab.effort.halftones]


def _compare(lab, halftone):
    target = tone.ink(halftone.file())
    names = {method: f"figure-6-{halftone.picture}-{method.file}.png" for method in (CCVT, CCDT, POLISHED)}
    results = {method.name: _halftone(lab, halftone, method, target, names[method], scale=SCALE)
               for method in (CCDT, POLISHED)}
    results[CCVT.name] = _ccvt_halftone(lab, halftone, target, names[CCVT])
    height, width = target.shape
    return {"picture": halftone.picture, "sites": halftone.sites, "width": width, "height": height, "methods": results}


def _ccvt_halftone(lab, halftone, target, name):
    """Makes a halftone by CCVT, timed once, because it takes long. /halftone has only CCDT, so the points come from
    /sample and are drawn here."""
    height, width = target.shape
    made = lab.sample(CCVT, halftone.sites, 1, domain={"type": "rectangle", "width": width, "height": height},
                      density={"image": data_of(halftone.file())})
    points = numpy.array(made["points"]) * (1, -1) + (0, height)
    lab.save_bits(name, tone.dots(points, SCALE, target))
    return {"seconds": made["elapsed_ms"] / 1000, "runs": 1, "iterations": made["iterations"],
            "tone_error": tone.error(points, target)}
