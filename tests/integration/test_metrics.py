# SPDX-License-Identifier: GPL-3.0-or-later
"""Monitoring: metrics of the running server, and its readiness."""

import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from prometheus_client.parser import text_string_to_metric_families

from harness import PATIENCE, Call, Server, ServerCase, ask, figures_at_rest, file_of, flat, post_json, wait_until

ENDLESS = json.dumps({"sites": 100_000, "iterations": 1000, "domain": {"type": "rectangle", "width": 2, "height": 1}})


def samples(text):
    """Returns the samples by name and labels."""
    return {(sample.name, *sorted(sample.labels.items())): sample.value
            for family in text_string_to_metric_families(text) for sample in family.samples}


def figures(server):
    answer = ask(server, "/metrics")
    assert answer.status == 200, answer
    return samples(answer.body.decode())


def wait_for(server, name, value):
    wait_until(lambda: figures(server)[(name,)] == value, f"{name} = {value}")


class Metrics(ServerCase):
    def test_count_requests_and_work(self):
        before = samples(figures_at_rest(self.server))
        self.halftone(file_of(flat(100, 40, 30)), "?sites=50")
        self.sample(sites=70, domain={"type": "torus", "width": 1, "height": 1})
        self.assertEqual(post_json(self.server, "/sample", {"sites": 0}).status, 400)
        self.assertEqual(self.ask("/no/such/path").status, 404)
        after = samples(figures_at_rest(self.server))

        def grown(name, **labels):
            key = (name, *sorted(labels.items()))
            return after[key] - before.get(key, 0)

        self.assertEqual(grown("ccdt_http_requests_total", route="/halftone", status="200"), 1)
        self.assertEqual(grown("ccdt_http_requests_total", route="/sample", status="200"), 1)
        self.assertEqual(grown("ccdt_http_requests_total", route="/sample", status="400"), 1)
        self.assertEqual(grown("ccdt_http_requests_total", route="other", status="404"), 1)
        self.assertEqual(grown("ccdt_stage_duration_seconds_count", stage="optimise"), 2)
        self.assertGreater(grown("ccdt_stage_duration_seconds_sum", stage="optimise"), 0)
        self.assertEqual(grown("ccdt_sites_total"), 120)
        self.assertEqual(grown("ccdt_pixels_total"), 1200)
        wait_for(self.server, "ccdt_workers_busy", 0)

    def test_follow_the_conventions_of_prometheus(self):
        answer = self.ask("/metrics")
        self.assertTrue(answer.type.startswith("text/plain; version=0.0.4"))
        for family in text_string_to_metric_families(answer.body.decode()):
            self.assertRegex(family.name, r"^(ccdt|process)(_[a-z]+)+$")
            self.assertTrue(family.documentation.endswith("."), family.name)
            self.assertTrue(family.samples or family.type in ("counter", "histogram"), family.name)
            if family.type == "counter":
                self.assertTrue(all(sample.name.endswith("_total") for sample in family.samples), family.name)

    def test_pass_promtool(self):
        self.halftone(file_of(flat(100)), "?sites=50")
        checked = subprocess.run([os.environ["CCDT_PROMTOOL"], "check", "metrics"], input=self.ask("/metrics").body,
                                 capture_output=True, timeout=PATIENCE, check=False)
        self.assertEqual((checked.returncode, checked.stdout, checked.stderr), (0, b"", b""))


class Pressure(unittest.TestCase):
    def test_waiting_and_running_requests_are_counted(self):
        with Server("--workers=1", "--queue=4", "--timeout=300") as server:
            calls = [Call(server.url("/sample"), data=ENDLESS) for _ in range(3)]
            wait_for(server, "ccdt_queue_requests", 2)
            found = figures(server)
            self.assertEqual((found[("ccdt_workers",)], found[("ccdt_workers_busy",)]), (1, 1))
            self.assertGreater(found[("ccdt_queue_oldest_seconds",)], 0)
            for call in calls:
                call.abandon()
            wait_for(server, "ccdt_workers_busy", 0)
            gone = ("ccdt_cancellations_total", ("cause", "client_gone"))
            wait_until(lambda: figures(server)[gone] == 3)

    def test_not_ready_if_the_backlog_exceeds_the_timeout(self):
        with Server("--workers=1", "--queue=4", "--timeout=1") as server:
            self.assertEqual(ask(server, "/health/ready").status, 200)
            calls = [Call(server.url("/sample"), data=ENDLESS) for _ in range(5)]
            answer = wait_until(lambda: (now := ask(server, "/health/ready")).status != 200 and now)
            self.assertEqual((answer.status, answer.type), (503, "application/problem+json"))
            self.assertEqual(ask(server, "/health/live").status, 200)
            for call in calls:
                call.answer()
            wait_until(lambda: ask(server, "/health/ready").status == 200)


class OwnPort(unittest.TestCase):
    def test_has_metrics_and_health_checks_only(self):
        with tempfile.TemporaryDirectory() as folder:
            keys = pathlib.Path(folder) / "keys"
            keys.write_text("alice:alice-0123456789abcdef\n")
            with Server("--metrics-port=0", f"--api-key-file={keys}") as server:
                url = re.search(r"http://127.0.0.1:\d+", server.wait_for_log("metrics are at "))[0]

                def status(path, *arguments):
                    return Call(url + path, *arguments).answer().status

                self.assertIn(b"ccdt_build_info", Call(url + "/metrics").answer().body)
                self.assertEqual([status(path) for path in ("/health", "/health/ready", "/", "/jobs/x", "/sample")],
                                 [200, 200, 404, 404, 404])
                self.assertEqual(status("/sample", "--data", "{}"), 404)
                self.assertEqual(status("/metrics", "--header", "Host: evil.example"), 421)
                header = ("--header", "Authorization: Bearer alice-0123456789abcdef")
                self.assertEqual([ask(server, path, *header).status for path in ("/metrics", "/jobs/x")], [404, 404])
                self.assertEqual(ask(server, "/").status, 200)
                self.assertEqual(server.stop(), 0)

    def test_needs_no_allowed_host_on_other_addresses(self):
        with Server("--metrics-port=0", "--bind=0.0.0.0", "--allowed-host=dots.example") as server:
            port = re.search(r":(\d+)/metrics", server.wait_for_log("metrics are at "))[1]
            answer = Call(f"http://127.0.0.1:{port}/metrics", "--header", "Host: scraped.example").answer()
            self.assertEqual(answer.status, 200)


if __name__ == "__main__":
    unittest.main(verbosity=2)
