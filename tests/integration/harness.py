# SPDX-License-Identifier: GPL-3.0-or-later
"""Starts the server under test, and sends requests to it by curl.

The environment variable CCDT_SERVER contains the path of the program.
"""

import base64
import contextlib
import inspect
import io
import json
import os
import pathlib
import re
import select
import signal
import subprocess
import tempfile
import threading
import time
import unittest

import numpy
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
DATA = ROOT / "tests" / "data"
PICTURES = DATA / "images"
POLYGONS = DATA / "polygons"

# Installed by tests/run. Tests use the Node.js of tests/page/package.json, never that of the machine.
TOOLS = pathlib.Path(os.environ.get("CCDT_TOOLS", ROOT / "build" / "tools"))
NODE_MODULES = TOOLS / "page" / "node_modules"
NODE = TOOLS / "page" / "node"

# Time limit of a wait, in seconds. Only a fault makes a test wait this long.
PATIENCE = 120


def wait_until(condition, what=None):
    """Waits until a condition holds, and returns its value.

    `what` describes the condition in the message of a failure; by default, the message contains the source of the
    condition. Pauses twice as long as the condition takes, within bounds, to leave the processor to the program that it
    waits for.
    """
    start = time.monotonic()
    end = start + PATIENCE
    while not (found := condition()):
        if (now := time.monotonic()) > end:
            what = what or inspect.getsource(condition).strip()
            raise AssertionError(f"waited {PATIENCE} s for: {what}\nlast value: {found!r}")
        time.sleep(min(max(0.005, 2 * (now - start)), 0.1))
        start = time.monotonic()
    return found


def execute(command, timeout=PATIENCE, **options):
    """Runs a program to its end, with the options of subprocess.run and a time limit."""
    return subprocess.run(command, timeout=timeout, **options)  # pylint: disable=subprocess-run-check


def join(thread, what, limit=PATIENCE):
    """Waits for the end of a thread. `what` describes it in the message of a failure."""
    thread.join(limit)
    if thread.is_alive():
        raise AssertionError(f"waited {limit} s for {what}")


# Runs a command with the name of an output as its last argument, for each kind of file in a /dev that only it sees.
# Fails if the files in /dev are not the same afterwards.
PRIVATE_DEV = r"""
mount -t tmpfs none /dev
mknod /dev/null c 1 3
mknod /dev/full c 1 7
mknod /dev/disk b 120 0  # a device without a driver
mkfifo /dev/pipe
ln -s /proc/self/fd /dev/fd
ln -s fd/1 /dev/stdout
ln -s created /dev/dangling
list() { find /dev -mindepth 1 -printf '%P %y %l\n' | sort; }
before=$(list)
for name in /dev/stdout /dev/fd/1 /proc/self/fd/1; do
    "$@" $name | cat > piped-${name//\//}
    { echo before; "$@" $name; echo after; } > redirected-${name//\//}
done
"$@" /dev/fd/3 3> third
exec 4<> deleted
rm deleted
"$@" /dev/fd/4
cat /proc/$$/fd/4 > once-deleted
exec 4>&-
cat /dev/pipe > through-pipe & "$@" /dev/pipe
wait $!
"$@" /dev/null
"$@" /dev/dangling
mv /dev/created .
for name in full disk fd fd/9; do
    if "$@" /dev/$name 2> error; then echo "$name was written"; fi
done
rm error
diff <(echo "$before") <(list)
"""


def check_private_dev(command, folder, expected):
    """Checks that a command, whose last argument is the name of its output, writes the expected bytes to all kinds of
    files in a /dev of its own. The folder must be empty."""
    unshare = ("unshare", "--mount")
    if execute([*unshare, "mount", "-t", "tmpfs", "none", "/dev"], capture_output=True).returncode != 0:
        raise unittest.SkipTest("no mount namespace can be made here")
    done = execute([*unshare, "bash", "-euo", "pipefail", "-c", PRIVATE_DEV, "bash", *map(str, command)],
                   cwd=folder, capture_output=True, text=True)
    if done.returncode != 0 or done.stdout or done.stderr:
        raise AssertionError(done.stdout + done.stderr)
    files = list(pathlib.Path(folder).iterdir())
    if len(files) != 10:
        raise AssertionError(files)
    for file in files:
        before, after = (b"before\n", b"after\n") if file.name.startswith("redirected") else (b"", b"")
        if file.read_bytes() != before + expected + after:
            raise AssertionError(f"{file.name}: {file.read_bytes()}")


def read_line(process, what):
    """Waits for the first line that a process prints, and returns it. `what` describes it in the message of a failure."""
    if not select.select([process.stdout], [], [], PATIENCE)[0]:
        raise AssertionError(f"waited {PATIENCE} s for {what}")
    return process.stdout.readline()


def descendants(process):
    """Returns the ids of all descendants of a process. Processes and threads may end meanwhile."""
    found = []
    with contextlib.suppress(OSError):
        for task in pathlib.Path(f"/proc/{process}/task").iterdir():
            with contextlib.suppress(OSError):
                for child in (task / "children").read_text().split():
                    found += [int(child), *descendants(child)]
    return found


class Server:
    """A running server on a free port, and its log.

    By default, it has no cache, and its timeout equals the time that clients wait, because workers have a low priority
    and are slow on a busy machine.
    """

    def __init__(self, *flags, environment=None, program=None, limit=None):
        limits = ["prlimit", limit] if limit else []  # prlimit executes the server in the same process
        command = [*limits, program or os.environ["CCDT_SERVER"], "--port=0", "--cache=0", f"--timeout={PATIENCE}",
                   *flags]
        # The server would warn of variables of the tests, such as CCDT_SERVER, which scripts use.
        inherited = {name: value for name, value in os.environ.items() if program or not name.startswith("CCDT_")}
        self.process = subprocess.Popen(
            command, stderr=subprocess.PIPE, text=True, env={**inherited, **(environment or {})})
        self.lines = []
        self.news = threading.Condition()
        self.reader = threading.Thread(target=self._read_log, daemon=True)
        self.reader.start()
        try:
            listening = self.wait_for_log("listening on ")
        except AssertionError:
            self.process.kill()
            self.wait()
            raise
        port = re.search(r"listening on http://[^\"]*:(\d+)", listening)
        self.port = int(port.group(1)) if port else None
        self.path = None if port else re.search(r"listening on unix:([^\"\n]+)", listening).group(1)

    def keeps(self, line):  # pylint: disable=unused-argument
        """Returns whether to store a line of the log. Subclasses override this method to save memory."""
        return True

    def _read_log(self):
        for line in filter(self.keeps, self.process.stderr):
            with self.news:
                self.lines.append(line)
                self.news.notify_all()
        with self.news:
            self.lines.append(None)
            self.news.notify_all()

    def wait_for_log(self, text):
        """Waits for a line that contains `text`, and returns it."""
        def find():
            return next(((line,) for line in self.lines if line is None or text in line), None)

        with self.news:
            (line,) = self.news.wait_for(find, PATIENCE) or (None,)
        if line is None:
            raise AssertionError(f"waited {PATIENCE} s, or until the end of the server, for '{text}' in the log:\n"
                                 f"{self.log()}")
        return line

    def log(self):
        with self.news:
            return "".join(line for line in self.lines if line is not None)

    def url(self, path):
        return f"http://127.0.0.1:{self.port}{path}"

    def signal(self, number=signal.SIGTERM):
        self.process.send_signal(number)

    def wait(self):
        """Waits for the end of the server, and returns its exit code."""
        code = self.process.wait(PATIENCE)
        join(self.reader, "the end of the log")
        self.process.stderr.close()
        return code

    def stop(self):
        if self.process.poll() is None:
            self.signal()
        return self.wait()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self.process.kill()
        finally:
            self.wait()


class Answer:
    def __init__(self, status, headers, body):
        self.status = status
        self.headers = headers
        self.body = body

    @property
    def type(self):
        return self.headers.get("content-type", "")

    def json(self):
        return json.loads(self.body)

    def picture(self, mode=None):
        """Returns the pixels, unchanged or converted to one of Pillow's modes. In bilevel pictures, white is 1."""
        return pixels(self.body, mode)

    def __repr__(self):
        return f"{self.status} {self.headers} {self.body[:300]}"


def _parse(head):
    """Parses the last of several heads. There are several after 100 Continue."""
    lines = head.decode("latin-1").strip().split("\r\n\r\n")[-1].split("\r\n")
    headers = {}
    for line in lines[1:]:
        name, value = line.split(":", 1)
        name, value = name.lower(), value.strip()
        headers[name] = f"{headers[name]}, {value}" if name in headers else value
    return int(lines[0].split()[1]), headers


class Call:
    """A curl process; `answer` waits for it."""

    def __init__(self, url, *arguments, data=None):
        self.folder = tempfile.TemporaryDirectory()
        folder = pathlib.Path(self.folder.name)
        self.head, self.body = folder / "head", folder / "body"
        command = ["curl", "--silent", "--show-error", "--max-time", str(PATIENCE), "--dump-header", str(self.head),
                   "--output", str(self.body), *arguments]
        if data is not None:
            sent = folder / "sent"
            sent.write_bytes(data if isinstance(data, bytes) else data.encode())
            command += ["--data-binary", f"@{sent}"]
        if "--head" in arguments:
            self.body = pathlib.Path(os.devnull)  # curl would write the head to the body's file
        self.process = subprocess.Popen([*command, url], stderr=subprocess.PIPE, text=True)

    def answer(self):
        with self.folder:
            error = self.process.communicate()[1]
            if self.process.returncode != 0:
                raise AssertionError(f"curl failed with {self.process.returncode}: {error}")
            status, headers = _parse(self.head.read_bytes())
            return Answer(status, headers, self.body.read_bytes() if self.body.is_file() else b"")

    def abandon(self):
        """Kills curl, so that the client disconnects."""
        with self.folder:
            self.process.kill()
            self.process.communicate()


def ask(server, path, *arguments, data=None):
    return Call(server.url(path), *arguments, data=data).answer()


def post_json(server, path, body, *arguments):
    data = body if isinstance(body, (str, bytes)) else json.dumps(body)
    return ask(server, path, "--header", "Content-Type: application/json", *arguments, data=data)


def figures_at_rest(server):
    """Waits until all answers are counted, which happens after they are sent, and returns /metrics."""
    def find():
        metrics = ask(server, "/metrics").body.decode()
        return metrics if "\nccdt_connections_open 1\n" in metrics else None

    return wait_until(find, "the end of all other connections")


class ServerCase(unittest.TestCase):
    """A test case whose tests share a server."""

    flags = ()
    program = None

    @classmethod
    def setUpClass(cls):
        # If the set-up of a subclass fails, unittest skips tearDownClass, but ends this context.
        cls.server = cls.enterClassContext(Server(*cls.flags, program=cls.program))

    @classmethod
    def tearDownClass(cls):
        if cls.server.stop() != 0:
            raise AssertionError("the server did not exit with 0:\n" + cls.server.log())

    def ask(self, path, *arguments, data=None):
        return ask(self.server, path, *arguments, data=data)

    def halftone(self, data, query=""):
        answer = self.ask("/halftone" + query, data=data)
        self.assertEqual(answer.status, 200, answer)
        return answer

    def sample(self, **body):
        answer = post_json(self.server, "/sample", body)
        self.assertEqual(answer.status, 200, answer)
        return answer.json()

    def assert_problem(self, answer, status, *words):
        self.assertEqual(answer.status, status, answer)
        self.assertEqual(answer.type, "application/problem+json")
        problem = answer.json()
        self.assertEqual(problem["status"], status)
        for member in ("type", "title", "detail", "instance"):
            self.assertIsInstance(problem[member], str)
        self.assertEqual(problem["instance"], "urn:request:" + answer.headers["x-request-id"])
        for word in words:
            self.assertIn(word, json.dumps(problem))
        return problem


def file_of(picture, kind="PNG"):
    """Encodes an array of 8-bit grey levels or colours as a file, and returns its bytes."""
    file = io.BytesIO()
    Image.fromarray(numpy.asarray(picture, dtype=numpy.uint8)).save(file, kind)
    return file.getvalue()


def pixels(file, mode=None):
    image = Image.open(io.BytesIO(file))
    return numpy.asarray(image.convert(mode) if mode else image)


def colours(picture):
    """Returns the different colours of a picture (rows, columns, channels of bytes), as tuples."""
    packed = sum(picture[..., channel].astype(numpy.uint32) << 8 * channel for channel in range(picture.shape[-1]))
    return {tuple(int(colour).to_bytes(picture.shape[-1], "little")) for colour in numpy.unique(packed)}


def flat(level, width=64, height=64):
    return numpy.full((height, width), level, dtype=numpy.uint8)


def data_uri(bytes_, kind="image/png"):
    return f"data:{kind};base64," + base64.b64encode(bytes_).decode()


def linear(level):
    """Returns the relative luminance of a grey level of sRGB, in [0, 1]."""
    value = level / 255
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def polygon(name):
    return json.loads((POLYGONS / name).read_text())


def rings_of(geometry):
    """Returns all rings of a GeoJSON geometry, as arrays of corners without the repeated last one."""
    many = geometry["coordinates"] if geometry["type"] == "MultiPolygon" else [geometry["coordinates"]]
    return [numpy.array(ring[:-1]) for part in many for ring in part]


def area(rings):
    """Returns the area inside an odd number of rings, which do not cross."""
    def signed(ring):
        x, y = ring[:, 0], ring[:, 1]
        return 0.5 * numpy.sum(x * numpy.roll(y, -1) - numpy.roll(x, -1) * y)

    total = 0
    for i, ring in enumerate(rings):
        others = [other for j, other in enumerate(rings) if j != i]
        outer = not others or not inside(ring[:1], others)[0]
        total += abs(signed(ring)) if outer else -abs(signed(ring))
    return total


def inside(points, rings):
    """Returns whether each point is inside an odd number of rings."""
    x, y = numpy.asarray(points)[:, 0], numpy.asarray(points)[:, 1]
    odd = numpy.zeros(len(x), dtype=bool)
    for ring in rings:
        for (ax, ay), (bx, by) in zip(ring, numpy.roll(ring, -1, axis=0)):
            if ay == by:
                continue
            crosses = (ay > y) != (by > y)
            odd ^= crosses & (x < ax + (y - ay) / (by - ay) * (bx - ax))
    return odd
