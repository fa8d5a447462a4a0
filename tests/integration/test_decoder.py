# SPDX-License-Identifier: GPL-3.0-or-later
"""Decoding of pictures in confined processes."""

import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import unittest

from harness import PATIENCE, PICTURES, Call, Server, ServerCase, ask, execute, file_of, flat, join, wait_until

CAMERA = (PICTURES / "camera.png").read_bytes()
PROC = pathlib.Path("/proc")


class Process:
    """A process, as /proc describes it."""

    def __init__(self, number):
        self.id = number

    def stat(self):
        """Returns state and parent; none if the process has ended."""
        try:
            state, parent = (PROC / str(self.id) / "stat").read_text().rsplit(")", 1)[1].split()[:2]
        except (FileNotFoundError, ProcessLookupError):
            return None
        return state, int(parent)

    def name(self):
        """Returns the name; none if the process has ended."""
        try:
            return (PROC / str(self.id) / "comm").read_text().strip()
        except OSError:
            return None

    def is_running(self):
        stat = self.stat()
        return stat is not None and stat[0] not in "ZX"

    def links(self):
        """Returns the targets of the open descriptors."""
        folder = PROC / str(self.id) / "fd"
        links = []
        for name in os.listdir(folder):
            try:
                links.append(os.readlink(folder / name))
            except FileNotFoundError:
                pass  # the descriptor was closed in the meantime
        return links

    def output(self):
        """Returns the target of the standard output; none if it cannot be read."""
        try:
            return os.readlink(PROC / str(self.id) / "fd" / "1")
        except OSError:
            return None

    def children(self):
        """Returns the children, including zombies."""
        numbers = [int(entry.name) for entry in PROC.iterdir() if entry.name.isdigit()]
        found = [(Process(number), Process(number).stat()) for number in numbers]
        return [process for process, stat in found if stat is not None and stat[1] == self.id]

    def kill(self, number=signal.SIGKILL):
        os.kill(self.id, number)


class Family:
    """The processes of a server: the server, the keeper, the helper and the decoding children. Waits until they are
    ready."""

    def __init__(self, server):
        server.wait_for_log("pictures are decoded by user")
        self.server = Process(server.process.pid)

    def keepers(self):
        """Returns the keepers, including zombies."""
        return [process for process in self.server.children() if process.name() == "decoder-keeper"]

    def keeper(self):
        return wait_until(self.keepers)[0]

    def helper(self):
        """Waits until the helper has a child that waits for a picture, and returns the helper."""
        def find():
            helpers = [process for process in self.keeper().children() if process.name() == "decoder-helper"]
            return helpers and helpers[0].children() and helpers[0]

        return wait_until(find)

    def spare(self):
        """Waits until the helper has only one child, which waits for a picture, and returns the child. Children at work
        have a socket as standard output."""
        def find():
            children = self.helper().children()
            return len(children) == 1 and children[0].output() == "/dev/null" and children[0]

        return wait_until(find)

    def decoding(self):
        """Returns a child that decodes; none if there is none."""
        for keeper in self.keepers():
            for helper in keeper.children():
                for child in helper.children():
                    if (child.output() or "").startswith("socket:"):
                        return child
        return None

    def everyone(self):
        return [self.keeper(), self.helper(), self.spare()]


def restarts(server):
    metrics = ask(server, "/metrics").body.decode()
    return int(float(re.search(r"^ccdt_decoder_restarts_total (\S+)$", metrics, re.MULTILINE)[1]))


def is_ready(server):
    return ask(server, "/health/ready").status == 200


class Failures(ServerCase):
    def test_leak_neither_processes_nor_descriptors(self):
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
        self.assertLessEqual(len(helper.links()), before + 2)  # those of children that start or end
        self.assertEqual(len(family.keepers()), 1)
        files = {link for link in family.server.links() if "memfd" in link}
        self.assertEqual(files, {"/memfd:number (deleted)"}, "neither pictures nor replies")

    def end_decoder(self, number):
        """Requests a picture, and sends a signal to the process that decodes it. Returns the answer."""
        family = Family(self.server)
        spare = family.spare()
        # Takes a moment even on a fast machine.
        call = Call(self.server.url("/halftone?sites=50"), data=file_of(flat(99, 7900, 7900)))
        wait_until(lambda: len(family.helper().children()) == 2)
        spare.kill(number)
        return call.answer()

    def test_of_a_decoder_fail_only_its_own_picture(self):
        self.assert_problem(self.end_decoder(signal.SIGSEGV), 422, "could not be decoded")
        self.halftone(CAMERA, "?sites=50")

    def test_from_outside_are_repaired(self):
        self.assertEqual(self.end_decoder(signal.SIGKILL).status, 200)


class Jobs(unittest.TestCase):
    """Jobs whose decoders are killed from outside."""

    def test_survive_kills(self):
        large = file_of(flat(99, 4000, 4000))
        with Server("--workers=2") as server:
            family = Family(server)
            expected = ask(server, "/halftone?sites=50", data=large).body
            jobs = [ask(server, "/halftone?sites=50", "--header", "Prefer: respond-async", data=large)
                    .headers["location"] for _ in range(3)]
            # Two kills of a decoder, and one of the helper, use up two starts of a job at most.
            for find_victim in (family.decoding, family.decoding, family.helper):
                wait_until(family.decoding)
                victim = wait_until(find_victim)
                victim.kill()
                wait_until(lambda victim=victim: not victim.is_running())
            for job in jobs:
                wait_until(lambda job=job: ask(server, job).json()["status"] not in ("queued", "running"))
                answer = ask(server, job + "/result")
                self.assertEqual((answer.status, answer.body), (200, expected), ask(server, job).json()["error"])
            self.assertEqual(server.stop(), 0)


class Start(unittest.TestCase):
    def test_serves_before_the_decoder_is_ready(self):
        with Server() as server:
            self.assertEqual(ask(server, "/halftone?sites=5&scale=1", data=CAMERA).status, 200)
            server.wait_for_log("pictures are decoded by user")
            self.assertEqual(restarts(server), 0)
            self.assertEqual(server.stop(), 0)

    def test_fails_if_one_of_its_programs_cannot_start(self):
        ours = pathlib.Path(os.environ["CCDT_SERVER"]).parent
        for broken, message in (("ccdt-decoder", "cannot start the decoder: it exited with 3"),
                             ("ccdt-worker", "cannot start the worker: it exited with 3")):
            with self.subTest(broken=broken), tempfile.TemporaryDirectory() as folder:
                for name in ("ccdt-decoder", "ccdt-server", "ccdt-worker"):
                    (pathlib.Path(folder) / name).symlink_to(ours / name)
                program = pathlib.Path(folder) / broken
                program.unlink()
                program.write_text("#!/bin/sh\nexit 3\n")
                program.chmod(0o755)
                (pathlib.Path(folder) / "ccdt-server").unlink()
                shutil.copy(ours / "ccdt-server", folder)  # looks for the other programs in its own folder
                done = subprocess.run([f"{folder}/ccdt-server", "--port=0"], capture_output=True, text=True,
                                      timeout=PATIENCE, check=False)
                self.assertEqual(done.returncode, 1)
                self.assertIn(message, done.stderr)


class Restarts(unittest.TestCase):
    def ask_until(self, done, server, expected, statuses):
        while not done.is_set():
            answer = ask(server, "/halftone?sites=50", data=CAMERA)
            statuses.append(answer.status if answer.status != 200 or answer.body == expected else "another picture")

    def test_lose_no_picture(self):
        with Server("--workers=2", "--queue=20") as server:
            family = Family(server)
            expected = ask(server, "/halftone?sites=50", data=CAMERA).body
            done, statuses = threading.Event(), []
            clients = [threading.Thread(target=self.ask_until, args=(done, server, expected, statuses))
                       for _ in range(4)]
            for client in clients:
                client.start()
            try:
                for round_ in range(10):
                    # When the helper or the keeper is killed, the other one and all children end.
                    victim = family.helper() if round_ % 2 == 0 else family.keeper()
                    gone = [family.helper(), *family.helper().children()]
                    victim.kill()
                    wait_until(lambda count=round_ + 1: restarts(server) == count and is_ready(server))
                    wait_until(lambda gone=gone: not any(process.is_running() for process in gone))
            finally:
                done.set()
                for client in clients:
                    join(client, "the last answer of a client")
            self.assertGreater(len(statuses), 10)
            self.assertEqual(set(statuses), {200})
            self.assertEqual(len(family.keepers()), 1, "no zombies")
            self.assertEqual(server.stop(), 0)
            self.assertEqual(server.log().count("was killed by signal 9 (Killed), and is started again"), 10)

    def test_are_waited_for_and_logged(self):
        with Server() as server:
            helper, keeper = Family(server).helper(), Family(server).keeper()
            helper.kill(signal.SIGSTOP)
            call = Call(server.url("/halftone?sites=50"), data=CAMERA)
            keeper.kill()
            wait_until(lambda: restarts(server) == 1)
            answer = call.answer()
            self.assertEqual(answer.status, 200, (answer.body, server.log()))
            wait_until(lambda: is_ready(server))
            wait_until(lambda: not keeper.is_running() and not helper.is_running())
            self.assertEqual(server.stop(), 0)

    def test_follow_the_end_of_the_keeper(self):
        with Server() as server:
            family = Family(server)
            others, keeper = [family.helper(), family.spare()], family.keeper()
            family.server.kill(signal.SIGSTOP)  # so that its end of the socket for orders stays open
            try:
                keeper.kill()
                wait_until(lambda: not any(process.is_running() for process in others))
            finally:
                family.server.kill(signal.SIGCONT)
            wait_until(lambda: restarts(server) == 1)
            self.assertEqual(server.stop(), 0)


class AddressSpace(unittest.TestCase):
    def test_that_is_limited_is_logged(self):
        with tempfile.TemporaryDirectory() as folder:
            limited = pathlib.Path(folder, "limited")
            limited.write_text(f'#!/bin/sh\nulimit -v 100000000\nexec "{os.environ["CCDT_SERVER"]}" "$@"\n')
            limited.chmod(0o755)
            with Server(program=str(limited)) as server:
                server.wait_for_log("the address space of a process is limited to 97656 MiB (ulimit -v)")


class Confinement(ServerCase):
    def test_closes_all_files_of_the_server(self):
        family = Family(self.server)
        harmless = ("/dev/null", "pipe:", "socket:", "anon_inode:[signalfd]", "/proc")

        def is_closed(process):
            links = process.links()
            return all(link.startswith(harmless) for link in links) and str(links).count("socket:") <= 2

        # A new child closes inherited files a moment after the fork.
        for process in family.everyone():
            wait_until(lambda process=process: is_closed(process))

    def test_is_as_logged(self):
        line = self.server.wait_for_log("pictures are decoded by user ")
        user = re.search(r"by user (\d+)", line)[1]
        there = re.search(r"in force: (.*?)(?:; not in force|$)", line)[1]
        family = Family(self.server)
        for process in (family.helper(), family.spare()):
            status = dict(line.split(":\t", 1) for line in (PROC / str(process.id) / "status").read_text().splitlines())
            self.assertEqual(status["Uid"].split(), [user] * 4)
            self.assertEqual(status["NoNewPrivs"], "1")
            if "no root" in there:
                self.assertNotEqual(user, "0")
            if "no capabilities" in there:
                self.assertEqual({int(status[name], 16) for name in ("CapInh", "CapPrm", "CapEff", "CapAmb")}, {0})
            if os.geteuid() != 0:
                continue  # to read namespaces
            for kind, layer in (("net", "network"), ("mnt", "mount"), ("pid", "pid"), ("ipc", "ipc"), ("uts", "uts")):
                namespaces = {os.readlink(PROC / str(one.id) / "ns" / kind) for one in (process, family.server)}
                self.assertEqual(len(namespaces) == 2, f"{layer} namespace" in there, kind)
            self.assertEqual(not os.listdir(PROC / str(process.id) / "root"), "empty root directory" in there)

    def test_keeps_libraries_of_decoders_out_of_the_server(self):
        family = Family(self.server)
        self.assertNotIn("libOpenImageIO", (PROC / str(family.server.id) / "maps").read_text())
        self.assertIn("libOpenImageIO", (PROC / str(family.keeper().id) / "maps").read_text())


class Chroot(unittest.TestCase):
    # Runs a program in a chroot that is not a mount point and shows the contents of the machine's root directory.
    ENTER = """#!/bin/sh -e
exec unshare --mount sh -ec '
    mount -t tmpfs none "$0"
    mkdir "$0/root"
    cd "$0/root"
    for entry in /*; do
        if [ -d "$entry" ] && [ ! -L "$entry" ]; then
            mkdir ".$entry"
            mount --rbind "$entry" ".$entry"
        elif [ -L "$entry" ]; then
            cp -P "$entry" .
        fi
    done
    exec chroot . "$@"' "$(dirname "$0")" "$CCDT_SERVER" "$@"
"""

    def test_lacks_an_empty_root_directory_and_logs_that(self):
        if execute(["unshare", "--mount", "true"], capture_output=True, check=False).returncode != 0:
            self.skipTest("no mount namespace can be made here")
        with tempfile.TemporaryDirectory() as folder:
            enter = pathlib.Path(folder) / "enter"
            enter.write_text(self.ENTER)
            enter.chmod(0o755)
            with Server(program=enter) as server:
                line = server.wait_for_log("pictures are decoded by user ")
                self.assertRegex(line, "in force: .*mount namespace.*; not in force: .*empty root directory")
                self.assertEqual(ask(server, "/halftone?sites=50", data=CAMERA).status, 200)
                self.assertEqual(server.stop(), 0)


class Ending(unittest.TestCase):
    def test_leaves_no_process(self):
        with Server() as server:
            everyone = Family(server).everyone()
            self.assertEqual(server.stop(), 0)
            wait_until(lambda: not any(process.is_running() for process in everyone))

    def test_leaves_no_process_even_if_killed(self):
        with Server() as server:
            family = Family(server)
            everyone = family.everyone()
            worker = everyone[-1]
            worker.kill(signal.SIGSTOP)  # so that it is still at work when the next one waits
            call = Call(server.url("/halftone"), data=file_of(flat(99, 7900, 7900)))
            wait_until(lambda: len(family.helper().children()) == 2)
            everyone += family.helper().children()
            worker.kill(signal.SIGCONT)
            server.signal(signal.SIGKILL)
            call.abandon()
            self.assertEqual(server.wait(), -signal.SIGKILL)
            wait_until(lambda: not any(process.is_running() for process in everyone))

    def test_ignores_signals_to_child_processes(self):
        with Server() as server:
            for process in Family(server).everyone()[:2]:
                for number in (signal.SIGINT, signal.SIGTERM):
                    process.kill(number)
            self.assertEqual(ask(server, "/halftone?sites=50", data=CAMERA).status, 200)
            self.assertEqual(server.stop(), 0)

    def test_of_decoding_follows_a_deadline(self):
        with Server("--timeout=0.05") as server:
            family = Family(server)
            self.assertIn(ask(server, "/halftone", data=file_of(flat(99, 7900, 7900))).status, (503, 504))
            family.spare()
            self.assertEqual(server.stop(), 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
