# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the overhead of the service over the bare computation, and its throughput on one core.

The server, with one worker, and the bare computation run on the same core; clients use the others. Bare and served runs
alternate, so that other load of the machine affects both alike, and the tables have medians over the turns. The spread
of the bare runs shows how much other load there was.
"""

import http.client
import json
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent.parent
sys.path.insert(0, str(ROOT / "tests" / "integration"))
from harness import PATIENCE, Server  # pylint: disable=wrong-import-position

CORES = sorted(os.sched_getaffinity(0))
SITES = (1024, 4096, 16_384, 131_072)
TURNS = 3
SERVED_SECONDS = 4   # minimum per turn
MIN_REQUESTS = 4     # minimum per turn
WRK_SECONDS = 5
SQUARE = {"type": "rectangle", "width": 1, "height": 1}

WRK = """
wrk.method = "POST"
function init(arguments)
  local file = assert(io.open(arguments[1], "rb"))
  wrk.body = file:read("*a")
  file:close()
  wrk.headers["Content-Type"] = arguments[2]
end
function done(summary, latency)
  local errors = summary.errors
  local lost = errors.connect + errors.read + errors.write + errors.timeout + errors.status
  print(string.format("rate %f p50 %f p90 %f p99 %f lost %d", 1e6 * summary.requests / summary.duration,
                      latency:percentile(50) / 1e3, latency:percentile(90) / 1e3, latency:percentile(99) / 1e3, lost))
end
"""


def busy_seconds():
    """Returns the busy time of all processors since the machine was started, in seconds."""
    user, nice, system, _, _, irq, soft, steal = map(
        int, pathlib.Path("/proc/stat").read_text().splitlines()[0].split()[1:9])
    return (user + nice + system + irq + soft + steal) / os.sysconf("SC_CLK_TCK")


class OtherLoad:
    """Measures the load by other programs, while the benchmark is idle."""

    def __init__(self):
        self.shares = []

    def measure(self, seconds=0.5):
        before, start = busy_seconds(), time.monotonic()
        time.sleep(seconds)
        self.shares.append((busy_seconds() - before) / (time.monotonic() - start) / os.cpu_count())


def move_to(cores):
    """Moves all threads of this process to given cores. Does not move child processes."""
    for task in pathlib.Path("/proc/self/task").iterdir():
        os.sched_setaffinity(int(task.name), cores)


def on_core(core):
    return lambda: os.sched_setaffinity(0, {core})


def bare(sites):
    """Returns the median time of the bare computation by ccdt_bench, in milliseconds."""
    done = subprocess.run(
        [os.environ["CCDT_BENCH"], f"--benchmark_filter=^Square/{sites}/1/", "--benchmark_format=json"],
        preexec_fn=on_core(CORES[0]), capture_output=True, text=True, check=True)
    run, = json.loads(done.stdout)["benchmarks"]
    return run["us_per_site"] * sites / 1000


class Served:
    """Repeats a request over a persistent connection."""

    def __init__(self, port, sites):
        self.connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
        self.body = json.dumps({"sites": sites, "domain": SQUARE})
        self.taken, self.inside = [], []

    def ask(self):
        start = time.perf_counter()
        self.connection.request("POST", "/sample", self.body, {"Content-Type": "application/json"})
        response = self.connection.getresponse()
        response.read()
        taken = 1000 * (time.perf_counter() - start)
        if response.status != 200:
            raise SystemExit(f"the server answered {response.status}")
        return taken, float(re.search(r"optimise;dur=([\d.]+)", response.headers["Server-Timing"])[1])

    def run(self):
        self.ask()
        end = time.monotonic() + SERVED_SECONDS
        count = 0
        while time.monotonic() < end or count < MIN_REQUESTS:
            taken, inside = self.ask()
            self.taken.append(taken)
            self.inside.append(inside)
            count += 1


def percentile(values, share):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def spread(values):
    return (max(values) - min(values)) / statistics.median(values)


def overheads(port, other_load):
    bares = {sites: [] for sites in SITES}
    served = {sites: Served(port, sites) for sites in SITES}
    for _ in range(TURNS):
        for sites in SITES:
            other_load.measure()
            bares[sites].append(bare(sites))
            served[sites].run()
    print("| uniform, square, standard | bare, ms | computing in the service | answer p50 | p90 | p99 | n | "
          "over bare | over its own computing | spread of bare |\n|---|---|---|---|---|---|---|---|---|---|")
    for sites in SITES:
        alone, run = statistics.median(bares[sites]), served[sites]
        middle, inside = statistics.median(run.taken), statistics.median(run.inside)
        own = statistics.median(taken / max(spent, 0.1) for taken, spent in zip(run.taken, run.inside))
        print(f"| {sites:,} sites | {alone:.2f} | {inside:.1f} | {middle:.2f} | {percentile(run.taken, 0.9):.2f} | "
              f"{percentile(run.taken, 0.99):.2f} | {len(run.taken)} | {100 * (middle / alone - 1):+.1f} % | "
              f"{100 * (own - 1):+.1f} % | {100 * spread(bares[sites]):.0f} % |")


def wrk(port, path, body, kind, connections):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "script.lua").write_text(WRK)
        (folder / "body").write_bytes(body)
        output = subprocess.run(
            ["wrk", "--threads", "1", "--connections", str(connections), "--duration", f"{WRK_SECONDS}s", "--timeout",
             f"{PATIENCE}s", "--script", str(folder / "script.lua"), f"http://127.0.0.1:{port}{path}", "--",
             str(folder / "body"), kind], capture_output=True, text=True, check=True).stdout
    values = dict(re.findall(r"(rate|p50|p90|p99|lost) ([\d.]+)", output))
    if float(values["lost"]) != 0:
        raise SystemExit("wrk had failures:\n" + output)
    return [float(values[name]) for name in ("rate", "p50", "p90", "p99")]


def throughput(port, other_load):
    camera = (ROOT / "tests" / "data" / "images" / "camera.png").read_bytes()
    rows = [(f"/sample, {sites} sites", "/sample", json.dumps({"sites": sites, "domain": SQUARE}).encode(),
             "application/json") for sites in (64, 256, 1024)]
    rows += [(f"/halftone, 512 x 512, {sites:,} dots", f"/halftone?sites={sites}", camera, "image/png")
             for sites in (4096, 16_384)]
    print("\n| one core, kept connections | requests a second | 1 client: p50 ms | p90 | p99 | 4 clients: requests a "
          "second |\n|---|---|---|---|---|---|")
    for name, path, body, kind in rows:
        other_load.measure()
        alone = wrk(port, path, body, kind, 1)
        crowded = wrk(port, path, body, kind, 4)
        print(f"| {name} | {alone[0]:.1f} | " + " | ".join(f"{value:.2f}" for value in alone[1:]) +
              f" | {crowded[0]:.1f} |")


def main():
    start = time.monotonic()
    other_load = OtherLoad()
    os.sched_setaffinity(0, {CORES[0]})
    with Server("--workers=1") as server:
        move_to(CORES[1:] or CORES)
        overheads(server.port, other_load)
        throughput(server.port, other_load)
        server.stop()
    print(f"\nOther programs took {100 * statistics.median(other_load.shares):.0f} % of the machine, "
          f"{100 * max(other_load.shares):.0f} % at most; load average {os.getloadavg()[0]:.1f}; {len(CORES)} cores; "
          f"{time.monotonic() - start:.0f} s.")


if __name__ == "__main__":
    main()
