# SPDX-License-Identifier: GPL-3.0-or-later
"""The Helm chart: rendered, and checked against the types of Kubernetes, the restricted profile and the server's
settings."""

import json
import os
import pathlib
import re
import tempfile
import unittest

import yaml

from harness import NODE, ROOT, TOOLS, execute

CHART = ROOT / "docker" / "chart"
DEPLOY = TOOLS / "deploy"
HELM = DEPLOY / "helm" / "helm"
MODULES = DEPLOY / "node_modules"

# Modules of kubernetes-types, by the apiVersion of a document. Other versions have no types.
TYPES = {"v1": "core/v1", "apps/v1": "apps/v1", "autoscaling/v2": "autoscaling/v2",
         "networking.k8s.io/v1": "networking/v1", "policy/v1": "policy/v1"}
UNTYPED = {"keda.sh/v1alpha1", "monitoring.coreos.com/v1"}

REDIS = {"kind": "redis", "redis": {"url": "redis://:secret@redis/0"}}

# A release for each branch of the templates.
RELEASES = {
    "plain": {},
    "whole": {
        "store": REDIS,
        "settings": {"CCDT_MAX_PIXELS": 16000000, "CCDT_CACHE_SHARED": True, "CCDT_TIMEOUT": 2.5,
                     "CCDT_MEMORY": "1GiB"},
        "keys": {"list": {"alice": "0123456789abcdef", "bob": "fedcba9876543210"}},
        "trustedProxies": ["10.0.0.0/8", "fd00::/8"],
        "service": {"annotations": {"a": "b"}},
        "ingress": {"enabled": True, "className": "nginx", "annotations": {"a": "b"},
                    "hosts": ["a.example", "b.example"],
                    "tls": [{"hosts": ["a.example"], "secretName": "certificate"}]},
        "autoscaling": {"kind": "hpa", "hpa": {"queue": 4}},
        "networkPolicy": {"enabled": True, "from": [{"namespaceSelector": {"matchLabels": {"name": "ingress"}}}],
                          "redis": [{"podSelector": {"matchLabels": {"app": "redis"}}}]},
        "monitoring": {"enabled": True, "labels": {"release": "prometheus"}, "keySecret": "metrics"},
        "imagePullSecrets": [{"name": "registry"}],
        "podLabels": {"team": "dots"}, "podAnnotations": {"a": "b"}, "nodeSelector": {"kubernetes.io/arch": "amd64"},
        "tolerations": [{"key": "dots", "operator": "Exists"}], "priorityClassName": "high",
        "affinity": {"nodeAffinity": {"requiredDuringSchedulingIgnoredDuringExecution": {"nodeSelectorTerms": [
            {"matchExpressions": [{"key": "disk", "operator": "Exists"}]}]}}},
    },
    "scaled by KEDA": {
        "store": {"kind": "redis", "redis": {"existingSecret": "engine"}},
        "keys": {"existingSecret": "keys"},
        "autoscaling": {"kind": "keda", "keda": {"address": "redis:6379", "authentication": "redis"}},
        "networkPolicy": {"enabled": True},
    },
    "on a disk": {"replicas": 1, "pause": 0, "store": {"kind": "disk", "disk": {"storageClass": "fast"}},
                  "networkPolicy": {"enabled": True}, "podDisruptionBudget": {"enabled": False}},
    "with a port of metrics": {"monitoring": {"enabled": True, "port": 9090}, "networkPolicy": {"enabled": True}},
    "with webhooks": {"settings": {"CCDT_WEBHOOK_HOST": "a", "CCDT_WEBHOOK_KEY_FILE": "/etc/ccdt/webhooks"},
                      "keys": {"existingSecret": "keys"},
                      "networkPolicy": {"enabled": True, "egress": [{"ports": [{"port": 443}]}]}},
}

REFUSED = (
    {"replicas": -1}, {"replica": 3}, {"store": {"kind": "etcd"}}, {"store": {"kind": "redis"}},
    {"store": {"kind": "redis", "redis": {"url": "http://redis"}}}, {"store": {"kind": "disk"}, "replicas": 2},
    {"store": {"kind": "disk"}, "replicas": 1, "autoscaling": {"kind": "hpa"}}, {"settings": {"MAX_PIXELS": 1}},
    {"keys": {"list": {"alice": "short"}}}, {"trustedProxies": ["balancer"]},
    {"autoscaling": {"kind": "keda", "keda": {"address": "redis:6379"}}},
    {"store": REDIS, "autoscaling": {"kind": "keda"}}, {"workers": 0}, {"workers": "2"},
)


def helm(command, values):
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(values, file)
        file.flush()
        return execute([HELM, *command, CHART, "--values", file.name], capture_output=True, text=True,
                       check=False)


def render(values):
    """Returns the documents of a release, by their kind."""
    done = helm(("template", "release", "--namespace=dots"), values)
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    documents = [document for document in yaml.safe_load_all(done.stdout) if document]
    return {document["kind"] + ("/keys" if document["metadata"]["name"].endswith("-keys") else ""): document
            for document in documents}


def typescript(documents):
    """Returns a program that type-checks if the documents match the types of Kubernetes."""
    lines = []
    for i, document in enumerate(documents):
        module, kind = TYPES[document["apiVersion"]], document["kind"]
        lines.append(f"import type {{{kind} as Type{i}}} from 'kubernetes-types/{module}'")
        lines.append(f"export const document{i}: Type{i} = {json.dumps(document)}")
    return "\n".join(lines)


def compile_types(documents):
    """Returns the errors of TypeScript's compiler; empty if there are none."""
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "node_modules").symlink_to(MODULES)
        (pathlib.Path(folder) / "documents.ts").write_text(typescript(documents))
        options = {"noEmit": True, "strict": True, "module": "node16", "moduleResolution": "node16", "types": []}
        (pathlib.Path(folder) / "tsconfig.json").write_text(json.dumps({"compilerOptions": options}))
        return execute([NODE, MODULES / "typescript" / "bin" / "tsc", "--project", folder],
                       capture_output=True, text=True, check=False).stdout


def pod_of(documents):
    return (documents.get("Deployment") or documents["StatefulSet"])["spec"]["template"]["spec"]


def variables_of(documents):
    return {entry["name"]: entry.get("value") for entry in pod_of(documents)["containers"][0]["env"]}


@unittest.skipUnless(HELM.exists() and NODE.exists(), "tests/page/install or tests/deploy/install has not run")
class Chart(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.releases = {name: render(values) for name, values in RELEASES.items()}

    def test_passes_helm_lint(self):
        for name, values in RELEASES.items():
            with self.subTest(name=name):
                linted = helm(("lint", "--strict"), values)
                self.assertEqual(linted.returncode, 0, linted.stdout + linted.stderr)

    def test_renders_documents_that_match_kubernetes_types(self):
        documents = [document for release in self.releases.values() for document in release.values()]
        typed = [document for document in documents if document["apiVersion"] not in UNTYPED]
        self.assertEqual(compile_types(typed), "")
        self.assertEqual({document["kind"] for document in documents},
                         {"Deployment", "StatefulSet", "Service", "Ingress", "HorizontalPodAutoscaler", "ScaledObject",
                          "PodDisruptionBudget", "NetworkPolicy", "Secret", "ServiceMonitor", "PrometheusRule"})
        deployment = {**self.releases["plain"]["Deployment"], "spec": {"replicaz": 3}}
        self.assertIn("replicaz", compile_types([deployment]))

    def test_rejects_invalid_values_by_its_schema(self):
        for values in REFUSED:
            with self.subTest(values=values):
                self.assertNotEqual(helm(("template", "release"), values).returncode, 0)

    def test_pods_are_restricted(self):
        for name, documents in self.releases.items():
            with self.subTest(name=name):
                pod = pod_of(documents)
                self.assertIs(pod["automountServiceAccountToken"], False)
                rights = pod["securityContext"]
                self.assertEqual((rights["runAsNonRoot"], rights["runAsUser"]), (True, 10001))
                self.assertEqual(rights["seccompProfile"], {"type": "RuntimeDefault"})
                self.assertEqual(pod["containers"][0]["securityContext"],
                                 {"allowPrivilegeEscalation": False, "readOnlyRootFilesystem": True,
                                  "capabilities": {"drop": ["ALL"]}})

    def test_grace_period_of_pods_exceeds_the_drain(self):
        for documents in self.releases.values():
            pod = pod_of(documents)
            pause = pod["containers"][0].get("lifecycle", {}).get("preStop", {}).get("sleep", {}).get("seconds", 0)
            self.assertGreater(pod["terminationGracePeriodSeconds"],
                               pause + int(variables_of(documents)["CCDT_DRAIN_TIMEOUT"]))

    def test_sets_only_variables_of_the_server(self):
        output = execute([os.environ["CCDT_SERVER"], "--help"], capture_output=True, text=True, check=True).stdout
        known = set(re.findall(r"^  --\S+ \S+ +(\S+)", output, re.MULTILINE))
        for documents in self.releases.values():
            self.assertEqual(set(variables_of(documents)) - known, set())
        set_ = {name: value for name, value in variables_of(self.releases["whole"]).items() if value is not None}
        self.assertEqual(set_["CCDT_MAX_PIXELS"], "16000000")
        self.assertEqual(set_["CCDT_TRUSTED_PROXY"], "10.0.0.0/8,fd00::/8")
        environment = {name: value for name, value in os.environ.items() if name not in known}
        checked = execute([os.environ["CCDT_SERVER"], "--check", "--port=0", "--api-key-file="],
                          env={**environment, **set_}, capture_output=True, text=True, check=False)
        self.assertIn("--api-key-file", checked.stderr, "of all only the flag that is wrong")

    def test_secrets_appear_only_in_secrets(self):
        documents = self.releases["whole"]
        self.assertEqual(documents["Secret"]["stringData"]["url"], REDIS["redis"]["url"])
        self.assertEqual(documents["Secret/keys"]["stringData"]["keys"],
                         "alice:0123456789abcdef\nbob:fedcba9876543210\n")
        others = {kind: document for kind, document in documents.items() if not kind.startswith("Secret")}
        for secret in ("secret@", "0123456789abcdef"):
            self.assertNotIn(secret, json.dumps(others))
        named = pod_of(self.releases["scaled by KEDA"])
        self.assertEqual(named["volumes"][0]["secret"]["secretName"], "keys")
        self.assertIn({"name": "CCDT_REDIS", "valueFrom": {"secretKeyRef": {"name": "engine", "key": "url"}}},
                      named["containers"][0]["env"])

    def test_policy_permits_only_what_is_configured(self):
        ports = {name: [[port["port"] for port in rule["ports"]] for rule in
                        self.releases[name]["NetworkPolicy"]["spec"]["egress"]]
                 for name in ("on a disk", "scaled by KEDA", "with webhooks")}
        self.assertEqual(ports, {"on a disk": [], "scaled by KEDA": [[6379], [53, 53]],
                                 "with webhooks": [[443], [53, 53]]})

    def test_selectors_match_labels(self):
        for documents in self.releases.values():
            workload = documents.get("Deployment") or documents["StatefulSet"]
            labels = workload["spec"]["template"]["metadata"]["labels"].items()
            selectors = [workload["spec"]["selector"]["matchLabels"], documents["Service"]["spec"]["selector"]]
            for kind, key in (("PodDisruptionBudget", "selector"), ("NetworkPolicy", "podSelector")):
                if kind in documents:
                    selectors.append(documents[kind]["spec"][key]["matchLabels"])
            for selector in selectors:
                self.assertLessEqual(selector.items(), labels)
            for kind in ("HorizontalPodAutoscaler", "ScaledObject"):
                if kind in documents:
                    self.assertEqual(documents[kind]["spec"]["scaleTargetRef"]["name"], workload["metadata"]["name"])
                    self.assertNotIn("replicas", workload["spec"])

    def test_includes_all_alerts(self):
        rule = self.releases["whole"]["PrometheusRule"]["spec"]
        self.assertEqual(rule, yaml.safe_load((ROOT / "docker" / "prometheus" / "alerts.yaml").read_text()))
        endpoint = self.releases["whole"]["ServiceMonitor"]["spec"]["endpoints"][0]
        self.assertEqual(endpoint["relabelings"], [{"targetLabel": "job", "replacement": "ccdt"}])

    def test_offers_metrics_on_a_port_of_their_own(self):
        documents = self.releases["with a port of metrics"]
        self.assertEqual(variables_of(documents)["CCDT_METRICS_PORT"], "9090")
        [policy] = documents["NetworkPolicy"]["spec"]["ingress"]
        self.assertEqual(policy["ports"], [{"port": "http"}, {"port": "metrics"}])
        endpoint = documents["ServiceMonitor"]["spec"]["endpoints"][0]
        self.assertEqual((endpoint["targetPort"], endpoint.get("port")), ("metrics", None))
        [pod] = documents["Deployment"]["spec"]["template"]["spec"]["containers"]
        self.assertIn({"name": "metrics", "containerPort": 9090}, pod["ports"])
        self.assertEqual([port["name"] for port in documents["Service"]["spec"]["ports"]], ["http"])

    def test_has_the_servers_version(self):
        result = execute([os.environ["CCDT_SERVER"], "--version"], capture_output=True, text=True, check=True)
        self.assertEqual(yaml.safe_load((CHART / "Chart.yaml").read_text())["appVersion"], result.stdout.split()[1])


if __name__ == "__main__":
    unittest.main(verbosity=2)
