# SPDX-License-Identifier: GPL-3.0-or-later
"""Alerts and dashboard must be valid, and use only metrics of the server."""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from prometheus_client.parser import text_string_to_metric_families

from harness import PATIENCE, ServerCase, execute, file_of, flat

HERE = pathlib.Path(__file__).resolve().parent
DOCKER = HERE.parent.parent / "docker"
ALERTS = DOCKER / "prometheus" / "alerts.yaml"
CASES = HERE / "alerts.yaml"
DASHBOARD = json.loads(execute([sys.executable, DOCKER / "grafana" / "dashboard.py"], capture_output=True,
                               text=True, check=True).stdout)


# Labels that Prometheus adds.
ADDED = {"instance", "job"}


def promtool(*arguments):
    done = subprocess.run([os.environ["CCDT_PROMTOOL"], *arguments], capture_output=True, text=True, timeout=PATIENCE,
                          check=False)
    return done.returncode, done.stdout + done.stderr


def panels():
    return [panel for panel in DASHBOARD["panels"] if panel["type"] != "row"]


def expressions():
    return [target["expr"] for panel in panels() for target in panel["targets"]]


class Rules(unittest.TestCase):
    def test_pass_promtool(self):
        settings = [("check", "config", DOCKER / "prometheus" / name) for name in ("prometheus.yaml", "scale.yaml")]
        for arguments in (("check", "rules", ALERTS), *settings):
            code, output = promtool(*arguments)
            self.assertEqual(code, 0, output)

    def test_fire_when_they_should(self):
        code, output = promtool("test", "rules", CASES)
        self.assertEqual(code, 0, output)

    def test_are_all_tested_firing_and_silent(self):
        alerts = re.findall(r"- alert: (\w+)", ALERTS.read_text())
        tried = re.findall(r"alertname: (\w+)\n +exp_alerts:( \[\])?\n", CASES.read_text())
        self.assertGreater(len(alerts), 10)
        self.assertEqual({name for name, silent in tried if silent}, set(alerts))
        self.assertEqual({name for name, silent in tried if not silent}, set(alerts))


class Dashboard(unittest.TestCase):
    def test_has_titles_descriptions_and_units(self):
        for panel in DASHBOARD["panels"]:
            self.assertTrue(panel["title"], panel)
        for panel in panels():
            with self.subTest(panel=panel["title"]):
                self.assertTrue(panel["description"].endswith("."))
                self.assertTrue(panel["fieldConfig"]["defaults"]["unit"])
                self.assertTrue(panel["targets"])

    def test_panels_do_not_overlap(self):
        self.assertEqual(len({panel["id"] for panel in DASHBOARD["panels"]}), len(DASHBOARD["panels"]))
        taken = set()
        for panel in DASHBOARD["panels"]:
            place = panel["gridPos"]
            cells = {(x, y) for x in range(place["x"], place["x"] + place["w"])
                     for y in range(place["y"], place["y"] + place["h"])}
            self.assertEqual(cells & taken, set(), panel["title"])
            self.assertLessEqual(place["x"] + place["w"], 24)
            taken |= cells

    def test_expressions_are_valid_promql(self):
        rules = [{"record": f"panel:{i}", "expr": expression.replace("$__rate_interval", "1m")}
                 for i, expression in enumerate(expressions())]
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
            json.dump({"groups": [{"name": "dashboard", "rules": rules}]}, file)
            file.flush()
            code, output = promtool("check", "rules", file.name)
        self.assertEqual(code, 0, output)


class Names(ServerCase):
    def labels_of_metrics(self):
        """Returns the labels by the name of the sample."""
        self.halftone(file_of(flat(100)), "?sites=50")
        labels = {"up": set()}
        for family in text_string_to_metric_families(self.ask("/metrics").body.decode()):
            for sample in family.samples:
                labels.setdefault(sample.name, set()).update(sample.labels)
        return labels

    def test_exist_in_the_metrics_of_the_server(self):
        labels_of_metrics = self.labels_of_metrics()
        used = ALERTS.read_text() + "\n".join(expressions())
        names = set(re.findall(r"\b(?:ccdt|process)_\w+", used))
        self.assertGreater(len(names), 20)
        self.assertEqual(names - set(labels_of_metrics), set())
        for name, labels in re.findall(r"\b(up|(?:ccdt|process)_\w+)\{(.*?)\}", used):
            used_labels = set(re.findall(r"(\w+)(?:=|!)", re.sub(r'"[^"]*"', "", labels)))
            self.assertEqual(used_labels - ADDED - labels_of_metrics.get(name, set()), set(), name)


if __name__ == "__main__":
    unittest.main(verbosity=2)
