# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares the answers of the WebAssembly module and of the server to random requests: those of test_goldens.py with
other numbers, options, corners and pictures.

    CCDT_SERVER=build/test/ccdt-server python3 tests/integration/wasm_fuzz.py --minutes 60 --seed 1

Prints a line for each difference. The seed and the number of a request determine it: --only NUMBER repeats it.
"""

import argparse
import base64
import collections
import contextlib
import copy
import http.client
import io
import json
import random
import re
import subprocess
import sys
import time
import urllib.parse
from types import SimpleNamespace

from PIL import Image

import test_wasm
from harness import PATIENCE, Server

MAX_MUTATIONS = 5  # of a request
GRIDS = 0.05  # share of requests on meshes in which points are equally far from several faces
MAX_NUMBER = 4000  # of sites, iterations and the like, which would take too long

# Refusals of the module for which the server has an answer.
OWN_REFUSALS = re.compile(rb"WebAssembly (cannot write|decodes|has at most)")


def random_picture(rng):
    """Returns a BMP: noise, a gradient, or few colours."""
    width, height = rng.randint(1, 90), rng.randint(1, 90)
    few = [rng.randrange(256) for _ in range(rng.choice((1, 2, 5)))]
    slopes = [rng.uniform(-4, 4) for _ in range(6)]
    values = {
        "noise": lambda x, y, channel: rng.randrange(256),
        "gradient": lambda x, y, channel: int(128 + slopes[2 * channel] * (x - 40) + slopes[2 * channel + 1] * (y - 40)),
        "few": lambda x, y, channel: rng.choice(few),
    }[rng.choice(("noise", "gradient", "few"))]
    image = Image.new("RGB", (width, height))
    image.putdata([tuple(min(max(values(x, y, channel), 0), 255) for channel in range(3))
                   for y in range(height) for x in range(width)])
    bitmap = io.BytesIO()
    image.save(bitmap, "BMP")
    return bitmap.getvalue()


def request_on_grid(rng):
    """Returns a request for points on a square of many triangles, some of whose corners are fixed points."""
    side = rng.randint(3, 12)
    corners = [(i / side, j / side, 0) for j in range(side + 1) for i in range(side + 1)]
    lower = [j * (side + 1) + i for j in range(side) for i in range(side)]
    faces = [face for a in lower for face in ((a, a + 1, a + side + 2), (a, a + side + 2, a + side + 1))]
    rng.shuffle(faces)
    lines = ["OFF", f"{len(corners)} {len(faces)} 0", *(f"{x} {y} {z}" for x, y, z in corners),
             *(f"3 {a} {b} {c}" for a, b, c in faces)]
    options = [("sites", "60"), ("seed", str(rng.randrange(100))), ("format", "json"),
               ("fixed", json.dumps(rng.sample(corners, 9)))]
    return SimpleNamespace(operation="sample", options=options, type="model/off", body="\n".join(lines).encode())


def other_number(rng, number):
    if isinstance(number, int):
        changed = rng.choice((number + 1, number - 1, rng.randint(0, 2 * abs(number) + 3), 2 * number, 0, 1))
        return min(changed, MAX_NUMBER) if abs(number) <= MAX_NUMBER else number
    return rng.choice((number * rng.uniform(0.5, 1.5), number + rng.gauss(0, 0.1), -number, 0.0, number + 1e-9))


def other_text(rng, text):
    """Changes one of the numbers in an option of a query."""
    numbers = list(re.finditer(r"(?<![\w#.])-?\d+(\.\d+)?", text))
    if not numbers:
        return text
    found = rng.choice(numbers)
    number = float(found.group()) if found.group(1) else int(found.group())
    return f"{text[:found.start()]}{other_number(rng, number)}{text[found.end():]}"


def places(value):
    """Yields the containers and keys of all numbers and members of JSON."""
    for key, inner in list(value.items() if isinstance(value, dict) else enumerate(value)):
        yield value, key
        if isinstance(inner, (dict, list)):
            yield from places(inner)


def change_json(rng, body, others):
    if rng.random() < 0.3:  # a member of another request
        name, value = rng.choice(list(rng.choice(others).json.items()))
        body[name] = copy.deepcopy(value)
        return
    container, key = rng.choice(list(places(body)))
    value = container[key]
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        container[key] = other_number(rng, value)
    elif rng.random() < 0.2:
        del container[key]
    elif isinstance(value, list) and value:
        rng.shuffle(value)


def change_options(rng, options, others):
    others = [request for request in others if request.options]
    if others and rng.random() < 0.4:
        name, value = rng.choice(rng.choice(others).options)
        options[:] = [option for option in options if option[0] != name] + [(name, value)]
    elif options:
        at = rng.randrange(len(options))
        name, value = options[at]
        options[at] = (name, other_text(rng, value))


def mutated(rng, request, others):
    """Returns a changed copy of a request; `others` have the same operation and kind of body."""
    request = copy.deepcopy(request)
    is_json = hasattr(request, "json")
    for _ in range(rng.randint(1, MAX_MUTATIONS)):
        if is_json:
            change_json(rng, request.json, others)
        else:
            change_options(rng, request.options, others)
    if is_json:
        request.body = json.dumps(request.json).encode()
    elif request.body.startswith(b"BM"):
        request.body = random_picture(rng)
    return request


class Native:
    """Asks a server through one connection."""

    def __init__(self, server):
        self.connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE)

    def answer(self, request):
        query = urllib.parse.urlencode(request.options)
        self.connection.request("POST", f"/{request.operation}?{query}".rstrip("?"), request.body,
                                {"Content-Type": request.type or "application/octet-stream"})
        response = self.connection.getresponse()
        return SimpleNamespace(status=response.status, type=response.headers["Content-Type"], body=response.read())


class Module:
    """Asks a process of Node.js that runs the module."""

    def __init__(self):
        self.process = subprocess.Popen(["node", test_wasm.SCRIPT, test_wasm.MODULE], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, text=True)

    def answer(self, request):
        self.process.stdin.write(test_wasm.line_of(request) + "\n")
        self.process.stdin.flush()
        return test_wasm.answer_in(self.process.stdout.readline())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate()


def is_same(native, module):
    if native.status != module.status:
        return False
    if native.status == 200:
        return test_wasm.test_goldens.digest(native) == test_wasm.test_goldens.digest(module)
    return json.loads(native.body)["detail"] == json.loads(module.body)["detail"]


def differences(server, seed, numbers, counts):
    """Yields the numbers of requests with different answers, the requests and both answers."""
    known = [request for _, request in test_wasm.requests(server)]
    kinds = collections.defaultdict(list)
    for request in known:
        kinds[request.operation, hasattr(request, "json")].append(request)
    native = Native(server)
    with Module() as module, contextlib.closing(native.connection):
        for number in numbers:
            rng = random.Random(f"{seed} {number}")
            request = request_on_grid(rng) if rng.random() < GRIDS else rng.choice(known)
            request = mutated(rng, request, kinds[request.operation, hasattr(request, "json")])
            answer = module.answer(request)
            if answer.status >= 400 and OWN_REFUSALS.search(answer.body):
                counts["refused by the module only"] += 1
                continue
            expected = native.answer(request)
            counts[expected.status] += 1
            if not is_same(expected, answer):
                yield number, request, expected, answer


def numbers_until(end):
    number = 0
    while time.monotonic() < end:
        yield number
        number += 1


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--minutes", type=float, default=1)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int)
    given = parser.parse_args()
    numbers = [given.only] if given.only is not None else numbers_until(time.monotonic() + 60 * given.minutes)
    counts = collections.Counter()
    found = 0
    with Server() as server:
        for number, request, expected, answer in differences(server, given.seed, numbers, counts):
            found += 1
            print(f"{number}: {request.operation} {request.options} {request.body[:2000]}\n"
                  f"  server: {expected.status} {expected.body[:300]}\n  module: {answer.status} {answer.body[:300]}")
            sys.stdout.flush()
    print(f"{sum(counts.values())} requests, {found} differences; statuses of the server: {dict(counts)}")
    return found > 0


if __name__ == "__main__":
    sys.exit(main())
