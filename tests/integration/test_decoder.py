"""Pictures that are decoded in confined processes of their own."""

import base64
import os
import pathlib
import random
import signal
import time
import unittest

from harness import PATIENCE, PICTURES, Call, Server, ServerCase, ask, file_of, flat, post_json

FIXTURES = pathlib.Path(__file__).resolve().parent.parent / "api" / "data"
CAMERA = (PICTURES / "camera.png").read_bytes()
PROC = pathlib.Path("/proc")


class Process:
    """What /proc tells of a process."""

    def __init__(self, number):
        self.id = number

    def stat(self):
        """Its state and its parent; none if it is gone."""
        try:
            state, parent = (PROC / str(self.id) / "stat").read_text().rsplit(")", 1)[1].split()[:2]
        except (FileNotFoundError, ProcessLookupError):
            return None
        return state, int(parent)

    def is_running(self):
        stat = self.stat()
        return stat is not None and stat[0] not in "ZX"

    def links(self):
        """What its descriptors are open on."""
        folder = PROC / str(self.id) / "fd"
        links = []
        for name in os.listdir(folder):
            try:
                links.append(os.readlink(folder / name))
            except FileNotFoundError:
                pass  # closed meanwhile
        return links

    def output(self):
        """What its output goes to; none if it is gone or does not tell."""
        try:
            return os.readlink(PROC / str(self.id) / "fd" / "1")
        except OSError:
            return None

    def children(self):
        """Zombies are among them."""
        numbers = [int(entry.name) for entry in PROC.iterdir() if entry.name.isdigit()]
        found = [(Process(number), Process(number).stat()) for number in numbers]
        return [process for process, stat in found if stat is not None and stat[1] == self.id]

    def kill(self, number=signal.SIGKILL):
        os.kill(self.id, number)


def wait_for(condition):
    """Waits until it holds; returns what it gave."""
    end = time.monotonic() + PATIENCE
    while not (found := condition()):
        if time.monotonic() > end:
            raise AssertionError("waited in vain")
    return found


class Family:
    """The server's process, the keeper, the helper and the children that decode."""

    def __init__(self, server):
        self.server = Process(server.process.pid)
        (self.keeper,) = self.server.children()

    def helper(self):
        return wait_for(self.keeper.children)[0]

    def spare(self):
        """The child that waits for a picture, once it is alone. One at work has a socket for its output."""
        def find():
            children = self.helper().children()
            return len(children) == 1 and children[0].output() == "/dev/null" and children[0]

        return wait_for(find)

    def everyone(self):
        return [self.keeper, self.helper(), self.spare()]


def damaged(file, generator):
    """A file with a few bytes changed behind its first ones."""
    bytes_ = bytearray(file)
    for _ in range(8):
        bytes_[generator.randrange(min(32, len(bytes_) - 1), len(bytes_))] = generator.randrange(256)
    return bytes(bytes_)


class SameAnswers(unittest.TestCase):
    def ask_both(self, path, *arguments, data):
        answers = [ask(server, path, *arguments, data=data) for server in self.servers]
        self.assertEqual(answers[0].status, answers[1].status)
        if answers[0].status == 200:
            self.assertEqual(answers[0].body, answers[1].body)
        else:
            details = [{**answer.json(), "instance": None} for answer in answers]
            self.assertEqual(details[0], details[1])
        return answers[0].status

    @classmethod
    def setUpClass(cls):
        flags = ("--max-pixels=1000000",)
        cls.servers = [Server("--decoder=box", *flags), Server(*flags, environment={"CCDT_DECODER": "inline"})]

    @classmethod
    def tearDownClass(cls):
        for server in cls.servers:
            with server:
                assert server.stop() == 0, server.log()

    def test_for_every_kind_of_file(self):
        pictures = [path for path in sorted(FIXTURES.iterdir()) if path.suffix not in (".md", ".py")]
        self.assertGreater(len(pictures), 30)
        statuses = set()
        for path in [*pictures, *sorted(PICTURES.iterdir())]:
            with self.subTest(name=path.name):
                query = "/halftone?sites=200&iterations=1&scale=2"
                statuses.add(self.ask_both(query, data=path.read_bytes()))
        self.assertEqual(statuses, {200, 413, 415, 422})

    def test_for_damaged_files(self):
        generator = random.Random(1)
        for name in ("camera.png", "progressive.jpg", "lossy.webp", "lzw.tif"):
            folder = PICTURES if name == "camera.png" else FIXTURES
            file = (folder / name).read_bytes()
            for size in (12, 40, len(file) // 2, len(file) - 1):
                with self.subTest(name=name, size=size):
                    self.assertIn(self.ask_both("/halftone?sites=50&iterations=1", data=file[:size]), (200, 422))
            for _ in range(5):
                self.ask_both("/halftone?sites=50&iterations=1", data=damaged(file, generator))

    def test_for_densities(self):
        for name in ("rgba.png", "grey.jpg"):
            image = base64.b64encode((FIXTURES / name).read_bytes()).decode()
            body = {"sites": 50, "domain": {"type": "rectangle", "width": 2, "height": 1}, "density": {"image": image}}
            answers = [post_json(server, "/sample", body).json() for server in self.servers]
            self.assertEqual(answers[0]["points"], answers[1]["points"])


class Failures(ServerCase):
    def test_leave_nothing_behind(self):
        family = Family(self.server)
        self.halftone(CAMERA, "?sites=50")
        family.spare()
        helper = family.helper()
        before = len(helper.links())
        for _ in range(15):
            self.assert_problem(self.ask("/halftone", data=CAMERA[:5000]), 422, "broken")
            self.assertEqual(self.ask("/halftone?sites=50", data=file_of(flat(9))).status, 200)
        self.assertEqual(family.helper().id, helper.id)
        family.spare()
        self.assertLessEqual(len(helper.links()), before + 2)  # those in passing
        self.assertEqual(len(family.server.children()), 1)
        self.assertFalse(any("memfd" in link for link in family.server.links()))

    def test_of_a_decoder_cost_its_own_picture(self):
        family = Family(self.server)
        spare = family.spare()
        # A moment's work even for a fast machine.
        call = Call(self.server.url("/halftone?sites=50"), data=file_of(flat(99, 7900, 7900)))
        wait_for(lambda: len(family.helper().children()) == 2)
        spare.kill()
        self.assert_problem(call.answer(), 422, "could not be decoded")
        self.halftone(CAMERA, "?sites=50")

    def test_of_the_helper_cost_nothing(self):
        family = Family(self.server)
        for _ in range(3):
            family.helper().kill()
            self.halftone(CAMERA, "?sites=50")


class Confinement(ServerCase):
    def test_keeps_nothing_of_the_server_open(self):
        family = Family(self.server)
        harmless = ("/dev/null", "pipe:", "socket:", "anon_inode:[signalfd]")

        def is_closed(process):
            links = process.links()
            return all(link.startswith(harmless) for link in links) and str(links).count("socket:") <= 2

        # One that was forked a moment ago has yet to close what it got.
        for process in family.everyone():
            wait_for(lambda process=process: is_closed(process))


class Ending(unittest.TestCase):
    def test_leaves_no_process(self):
        with Server() as server:
            everyone = Family(server).everyone()
            self.assertEqual(server.stop(), 0)
            wait_for(lambda: not any(process.is_running() for process in everyone))

    def test_leaves_no_process_however_it_comes(self):
        with Server() as server:
            everyone = Family(server).everyone()
            call = Call(server.url("/halftone"), data=file_of(flat(99, 7900, 7900)))
            wait_for(lambda: len(Family(server).helper().children()) == 2)
            everyone += Family(server).helper().children()
            server.signal(signal.SIGKILL)
            call.abandon()
            self.assertEqual(server.wait(), -signal.SIGKILL)
            wait_for(lambda: not any(process.is_running() for process in everyone))

    def test_is_the_servers_to_decide(self):
        with Server() as server:
            for process in Family(server).everyone()[:2]:
                for number in (signal.SIGINT, signal.SIGTERM):
                    process.kill(number)
            self.assertEqual(ask(server, "/halftone?sites=50", data=CAMERA).status, 200)
            self.assertEqual(server.stop(), 0)

    def test_a_deadline_ends_the_decoding(self):
        with Server("--timeout=0.05") as server:
            family = Family(server)
            self.assertIn(ask(server, "/halftone", data=file_of(flat(99, 7900, 7900))).status, (503, 504))
            family.spare()
            self.assertEqual(server.stop(), 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
