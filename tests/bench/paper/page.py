# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the page: inserts numbers into the text of page.md."""

import datetime
import os
import re
import string
from pathlib import Path

import numpy

from figures import PAPER_TIMES
from harness import PICTURES
from lab import CCDT, CCVT, POLISHED

HERE = Path(__file__).resolve().parent


def machine(load):
    processor = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    compiler = re.search(rb"GCC: \([^)]*\) ([\d.]+)", Path(os.environ["CCDT_SERVER"]).read_bytes())
    return {"date": datetime.date.today().isoformat(), "cores": os.cpu_count(),
            "processor": processor.group(1) if processor else "unknown processor",
            "compiler": "g++ " + compiler.group(1).decode() if compiler else "unknown compiler", "load": round(load, 2)}


def write(results, effort, output):
    texts = {**_setting(results["machine"], effort), **_figure_1(results["figure_1"]), **_figure_3(results["figure_3"]),
             **_figure_4(results["figure_4"]), **_timings(results["timings"], effort), **_figure_5(results["figure_5"]),
             **_figure_6(results["figure_6"], output)}
    return string.Template((HERE / "page.md").read_text()).substitute(texts)


def _setting(found, effort):
    return {"command": "tests/bench/paper/run" + ("" if effort == type(effort)() else " --quick"),
            "machine": f"Made on {found['date']}: {found['cores']} cores ({found['processor']}), {found['compiler']}, "
                       f"load {found['load']} before the start",
            "runs": effort.runs, "seconds": f"{effort.seconds:g}"}


def _figure_1(found):
    columns = {name: polygon["trace"] for name, polygon in found.items()}
    steps = [step for step in (0, 1, 2, 3, 5, 10, 20) if all(step < len(trace) for trace in columns.values())]
    rows = [[name, *(f"{trace[step]:.3f}" for step in steps), f"{found[name]['polished']:.3f}"]
            for name, trace in columns.items()]
    first = next(iter(found.values()))
    return {"mesh_sites": f"{first['sites']:,}", "trace_iterations": len(first["trace"]) - 1,
            "random_variations": _list([f"{polygon['random']:.2f}" for polygon in found.values()]),
            "after_five": _list([f"{100 * _done(trace, 5):.1f} %" for trace in columns.values()]),
            "traces": _table(["iterations", *map(str, steps), "5, polished"], rows)}


def _done(trace, iterations):
    """Returns the share of the total fall of the variance."""
    variance = numpy.square(trace)
    return (variance[0] - variance[iterations]) / (variance[0] - variance[-1])


def _figure_3(found):
    rows = [["density", *(f"{100 * share:.2f}" for share in found["exact"]), ""]]
    errors = {}
    for name, shares in found["shares"].items():
        mean, deviation = numpy.mean(shares, axis=0), numpy.std(shares, axis=0, ddof=1)
        errors[name] = 100 * numpy.abs(mean - found["exact"]).max()
        rows.append([name, *(f"{100 * m:.2f} +- {100 * d:.2f}" for m, d in zip(mean, deviation)),
                     f"{errors[name]:.2f}"])
    return {"ramp_sites": f"{found['sites']:,}", "ramp_seeds": found["seeds"],
            "ramp": _table(["", "1st", "2nd", "3rd", "4th", "largest error of the mean"], rows),
            "ramp_errors": _list([f"{errors[method.name]:.2f} ({method.name})" for method in (CCVT, CCDT, POLISHED)])}


def _figure_4(found):
    columns = {"peak": ("peak", ".2f"), "oscillation": ("oscillation", ".2f"),
               "power below 0.5": ("low_frequency_power", ".5f"), "anisotropy, dB: mean": ("anisotropy_mean", ".1f"),
               "largest": ("anisotropy_worst", ".1f"), "least distance": ("min_distance", ".3f"),
               "mean distance": ("mean_distance", ".3f"), "variation": ("variation", ".3f")}
    rows = [[name, *(format(of[member], digits) for member, digits in columns.values())]
            for name, of in found["methods"].items()]
    return {"spectrum_sites": f"{found['sites']:,}", "sets": found["sets"], "spectra": _table(["", *columns], rows),
            "isotropic": f"{-10 * numpy.log10(found['sets']):.1f}",
            **_comparison({name: found["methods"][name] for name in ("ODT", "CCVT", "CCDT")})}


def _comparison(of):
    """Quantifies the paper's statements about its curves."""
    def ratio(member, over, under):
        return f"{of[over][member] / of[under][member]:.2g}"

    return {"odt_oscillation": ratio("oscillation", "ODT", "CCDT"),
            "odt_low": ratio("low_frequency_power", "ODT", "CCDT"),
            "ccdt_low": ratio("low_frequency_power", "CCDT", "CCVT"), "ccdt_peak": ratio("peak", "CCDT", "CCVT"),
            "ccdt_anisotropy": f"{of['CCDT']['anisotropy_worst'] - of['CCVT']['anisotropy_worst']:+.1f}"}


def _timings(found, effort):
    rows = [[name, *(_timing(runs[size]) for size in effort.sizes)] for name, runs in found.items()]
    for method, times in PAPER_TIMES.items():
        rows.append([f"{method.name}, the paper's",
                     *(_duration(times[size]) if size in times else "" for size in effort.sizes)])
    refused = sorted({run["refused"] for runs in found.values() for run in runs.values() if "refused" in run})
    here = {method: {size: run["seconds"] for size, run in found[method.name].items() if "seconds" in run}
            for method in (CCVT, CCDT)}
    return {"times": _table(["sites", *(f"{size:,}" for size in effort.sizes)], rows),
            "refusals": "Refused: " + _list([f'"{reason}"' for reason in refused]) + "." if refused else "",
            "ratio_sizes": _list([f"{size:,}" for size in here[CCVT]]),
            "ratios_here": _ratios(here), "ratios_paper": _ratios(PAPER_TIMES),
            "growths_here": _growths(here), "growths_paper": _growths(PAPER_TIMES)}


def _timing(run):
    return f"{_duration(run['seconds'])} ({run['runs']})" if "seconds" in run else "refused"


def _ratios(times):
    return _list([_ratio(seconds / times[CCDT][size]) for size, seconds in times[CCVT].items()])


def _growths(times):
    """Returns the exponents by which times grow with the number of sites, from the smallest size to the largest that
    both methods have."""
    sizes = list(times[CCVT])
    growth = {method: numpy.log(of[sizes[-1]] / of[sizes[0]]) / numpy.log(sizes[-1] / sizes[0])
              for method, of in times.items()}
    return f"{growth[CCVT]:.2f} and {growth[CCDT]:.2f}"


def _figure_5(found):
    stages = found["stages"]
    pictures = [f"![{stage['iterations']}](figures/figure-5-{stage['iterations']}.png)" for stage in stages]
    rows = [[_duration(stage["seconds"]), f"{stage['tone_error']:.5f}"] for stage in stages]
    return {"evolution_picture": found["picture"], "evolution_sites": f"{found['sites']:,}",
            "evolution": "\n\n".join(_table(["start", "1 iteration", "2 iterations"] if first == 0 else
                                            ["3 iterations", "4 iterations", "5 iterations"],
                                            [pictures[first:first + 3]]) for first in (0, 3)),
            "evolution_table": _table(["iterations", *(str(stage["iterations"]) for stage in stages)],
                                      [[name, *values] for name, values in zip(("time", "tone error"), zip(*rows))])}


def _figure_6(found, output):
    heads = ["picture", "dots", "CCVT: time, iterations", "CCDT: time", "polished: time", "CCVT over CCDT",
             "tone error: CCVT", "CCDT", "polished"]
    return {"halftones": _table(["picture", "CCVT", "CCDT", "CCDT, polished"],
                                [_pictures(halftone["picture"], output) for halftone in found]),
            "halftone_table": _table(heads, [_halftone(halftone, halftone["methods"]) for halftone in found]),
            "halftone_times": _over(found, "seconds", CCVT, CCDT),
            "tone_ccdt": _over(found, "tone_error", CCDT, CCVT),
            "tone_polished": _over(found, "tone_error", POLISHED, CCVT)}


def _pictures(name, output):
    original = f"{os.path.relpath(PICTURES, output)}/{name}.png"
    made = [f"figures/figure-6-{name}-{method.file}.png" for method in (CCVT, CCDT, POLISHED)]
    return [f"![{name}]({path})" for path in (original, *made)]


def _halftone(halftone, methods):
    times = {method: methods[method.name]["seconds"] for method in (CCVT, CCDT, POLISHED)}
    return [f"{halftone['picture']}, {halftone['width']} x {halftone['height']}", f"{halftone['sites']:,}",
            f"{_duration(times[CCVT])}, {methods[CCVT.name]['iterations']}", _duration(times[CCDT]),
            _duration(times[POLISHED]), _ratio(times[CCVT] / times[CCDT]),
            *(f"{methods[method.name]['tone_error']:.5f}" for method in times)]


def _over(found, member, over, under):
    return _list([_ratio(of["methods"][over.name][member] / of["methods"][under.name][member]) for of in found])


def _table(heads, rows):
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _list(words):
    return ", ".join(words[:-1]) + " and " + words[-1] if len(words) > 1 else words[0]


def _ratio(value):
    return f"{value:.1f}" if value < 10 else f"{value:,.0f}"


def _duration(seconds):
    if seconds < 1:
        return f"{1000 * seconds:.2g} ms" if seconds < 0.1 else f"{1000 * seconds:.0f} ms"
    return f"{seconds:.1f} s" if seconds < 100 else f"{seconds:.0f} s"
