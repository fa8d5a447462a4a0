# SPDX-License-Identifier: GPL-3.0-or-later
"""Several servers that share jobs through Redis. Each server answers requests about all jobs."""

import contextlib
import json
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import unittest

from engine import Redis, SlowWay
from harness import PATIENCE, Call, Server, ask, execute, figures_at_rest, wait_until
from test_jobs import ENDLESS, LATER, LONG, SMALL, events, status, submit, wait_for, wait_for_end, without_time

TORUS = {"type": "torus", "width": 1, "height": 1}


def figure(server, name):
    return float(re.search(rf"^{re.escape(name)} (\S+)$", ask(server, "/metrics").body.decode(), re.MULTILINE)[1])


def ends_logged(log):
    """Counts how often the log reports the end of each job."""
    counts = {}
    for job in re.findall(r"job ([0-9a-f]{32}) (?:succeeded|failed)", log):
        counts[job] = counts.get(job, 0) + 1
    return counts


class Replicas(unittest.TestCase):
    def setUp(self):
        stack = contextlib.ExitStack()
        self.addCleanup(stack.close)
        self.stack = stack
        self.redis = stack.enter_context(Redis())
        self.flags = ("--workers=2", "--job-lease=1", f"--redis={self.redis.url}")

    def start(self, *flags):
        server = self.stack.enter_context(Server(*self.flags, *flags))
        server.wait_for_log("jobs are stored in Redis")
        return server

    def test_any_replica_answers_for_a_job(self):
        first, second = self.start(), self.start()
        job = submit(first, SMALL)
        found = wait_for_end(second, job)
        self.assertEqual(found, status(first, job))
        results = [ask(server, job + "/result") for server in (first, second)]
        now = ask(first, "/sample", data=json.dumps(SMALL))
        for result in results:
            self.assertEqual((result.status, without_time(result)), (200, without_time(now)))
            self.assertEqual(result.body, results[0].body)
        self.assertEqual(ask(second, job, "--request", "DELETE").status, 204)
        self.assertEqual(ask(first, job).status, 404)

    def test_any_replica_streams_and_cancels_a_job(self):
        first, second, third = self.start(), self.start(), self.start()
        job = submit(first, ENDLESS)
        found = wait_until(lambda: (now := status(second, job))["iteration"] > 0 and now)
        self.assertEqual(found["status"], "running")
        self.assertGreater(found["progress"], 0)
        self.assertIsNotNone(found["variation"])
        streams = [Call(server.url(job + "/events"), "--no-buffer") for server in (first, second, third)]
        wait_until(lambda: sum(figure(server, "ccdt_event_streams_open") for server in (first, second, third)) == 3)
        iteration = status(third, job)["iteration"]
        wait_until(lambda: status(third, job)["iteration"] > iteration + 1)
        self.assertEqual(ask(third, job, "--request", "DELETE").status, 204)
        for stream in streams:
            received = events(stream.answer().body)
            self.assertEqual(received[-1][0], "cancelled")
            self.assertEqual(received[-1][1], status(first, job))
            self.assertGreater(len(received), 2, "the stream must have reported progress")
            fractions = [document["progress"] for _, document in received[:-1]]  # the last is the one in the store
            self.assertEqual(fractions, sorted(fractions))
        others = [submit(first, SMALL) for _ in range(6)]
        for other in others:
            self.assertEqual(wait_for_end(second, other)["status"], "succeeded", "the worker must be free again")

    def test_trace_context_travels_with_its_job(self):
        first = self.start()
        trace, parent = "0af7651916cd43dd8448eb211c80319c", "b7ad6b7169203331"
        ids = ("--header", f"traceparent: 00-{trace}-{parent}-01")
        jobs = [submit(first, {**LONG, "seed": seed}, *ids) for seed in range(2)]
        wait_for(first, jobs[0], "running")
        second = self.start()
        self.assertEqual(first.stop(), 0)
        for job in jobs:
            self.assertEqual(wait_for_end(second, job)["status"], "succeeded")
            line = second.wait_for_log(f"job {job.removeprefix('/jobs/')} succeeded")
            self.assertIn(f" trace={trace} parent={parent}\n", line + "\n")
            self.assertIn(f" trace={trace} parent={parent}\n", first.log())

    def test_jobs_are_spread_over_replicas(self):
        servers = [self.start() for _ in range(3)]
        jobs = [submit(servers[0], {**LONG, "seed": seed}) for seed in range(3)]
        for job in jobs:
            wait_for(servers[1], job, "running")
        for job in jobs:
            ask(servers[2], job, "--request", "DELETE")

    def test_jobs_of_a_killed_replica_are_taken_over(self):
        first, second, third = self.start(), self.start(), self.start()
        requests = [{**SMALL, "sites": 3000, "iterations": 20, "seed": seed} for seed in range(30)]
        jobs = [submit((first, second)[seed % 2], request) for seed, request in enumerate(requests)]
        wait_until(lambda: "succeeded" in first.log())
        first.signal(signal.SIGKILL)
        first.wait()
        for job in jobs:
            self.assertEqual(wait_for_end(third, job)["status"], "succeeded")
        for job, request in zip(jobs, requests):
            now = ask(second, "/sample", data=json.dumps(request))
            self.assertEqual(without_time(ask(third, job + "/result")), without_time(now))
        self.assertEqual(self.redis.cli("ZCARD", "ccdt:1:leases"), "0")
        self.assertEqual((second.stop(), third.stop()), (0, 0))
        ends = ends_logged(first.log() + second.log() + third.log())
        self.assertEqual(set(ends.values()), {1}, "each job must have ended once")

    def test_shutdown_returns_running_jobs_to_the_queue(self):
        first = self.start()
        job = submit(first, LONG)
        wait_for(first, job, "running")
        second = self.start()
        self.assertEqual(first.stop(), 0)
        found = wait_for_end(second, job)
        self.assertEqual(found["status"], "succeeded")
        self.assertEqual(figure(second, "ccdt_job_runs_repeated_total"), 0, "the returned start must not count")

    def test_replica_whose_lease_expired_changes_nothing(self):
        first = self.start()
        job = submit(first, LONG)
        wait_for(first, job, "running")
        second = self.start()
        first.signal(signal.SIGSTOP)
        wait_until(lambda: figure(second, "ccdt_job_runs_repeated_total") == 1)
        first.signal(signal.SIGCONT)
        wait_until(lambda: figure(first, "ccdt_job_leases_lost_total") == 1)
        self.assertEqual(wait_for_end(first, job)["status"], "succeeded")
        now = ask(second, "/sample", data=json.dumps(LONG))
        self.assertEqual(without_time(ask(first, job + "/result")), without_time(now))
        self.assertEqual((first.stop(), second.stop()), (0, 0))
        self.assertEqual(ends_logged(first.log() + second.log()), {job.removeprefix("/jobs/"): 1})

    def test_only_jobs_wait_while_redis_is_away(self):
        for stop, go_on in ((self.redis.kill, self.redis.start), (self.redis.pause, self.redis.resume)):
            with self.subTest(stop=stop.__name__), Server(*self.flags) as server:
                server.wait_for_log("jobs are stored in Redis")
                done = submit(server, SMALL)
                wait_for_end(server, done)
                running = submit(server, LONG)
                wait_for(server, running, "running")
                stop()
                now = ask(server, "/sample", data=json.dumps(SMALL))
                self.assertEqual(now.status, 200)
                for answer in (ask(server, "/sample", *LATER, data=json.dumps(SMALL)), ask(server, done),
                               ask(server, done + "/result"), ask(server, running, "--request", "DELETE")):
                    self.assertEqual(answer.status, 503, answer)
                    self.assertGreater(int(answer.headers["retry-after"]), 0)
                self.assertEqual(ask(server, "/health/ready").status, 200)
                self.assertEqual(ask(server, "/sample", data=json.dumps({**SMALL, "seed": 1})).status, 200)
                server.wait_for_log("jobs have to wait")
                go_on()
                wait_until(lambda: ask(server, done).status == 200)
                self.assertEqual(without_time(ask(server, done + "/result")), without_time(now))
                self.assertEqual(wait_for_end(server, running)["status"], "succeeded")
                self.assertEqual(wait_for_end(server, submit(server, SMALL))["status"], "succeeded")
                self.assertGreater(figure(server, 'ccdt_redis_failures_total{use="jobs"}'), 0)

    def test_run_that_ends_while_redis_is_away_is_not_lost(self):
        server = self.start("--job-lease=600")
        job = submit(server, {**SMALL, "sites": 5000, "iterations": 100})
        wait_for(server, job, "running")
        self.redis.kill()
        wait_until(lambda: figure(server, "ccdt_workers_busy") == 0)
        self.redis.start()
        self.assertEqual(wait_until(lambda: (now := ask(server, job)).status == 200 and now.json()["finished"] and now)
                         .json()["status"], "succeeded")
        self.assertEqual(figure(server, "ccdt_job_runs_repeated_total"), 0)

    def test_server_starts_before_redis(self):
        self.redis.kill()
        server = self.stack.enter_context(Server(*self.flags))
        server.wait_for_log("jobs have to wait")
        self.assertEqual(ask(server, "/sample", *LATER, data=json.dumps(SMALL)).status, 503)
        self.redis.start()
        job = wait_until(lambda: (now := ask(server, "/sample", *LATER, data=json.dumps(SMALL))).status == 202
                    and now.headers["location"])
        self.assertEqual(wait_for_end(server, job)["status"], "succeeded")

    def test_slow_redis_delays_jobs_only(self):
        with SlowWay(self.redis, 0.4) as way:
            server = self.stack.enter_context(Server(
                "--workers=2", f"--redis={way.url}", f"--cache-redis={way.url}", f"--rate-redis={way.url}",
                "--rate-limit=1000"))
            server.wait_for_log("jobs are stored in Redis")
            job = submit(server, SMALL)
            now = ask(server, "/sample", data=json.dumps(SMALL))
            self.assertEqual(now.status, 200)
            self.assertEqual(wait_for_end(server, job)["status"], "succeeded")
            self.assertEqual(without_time(ask(server, job + "/result")), without_time(now))
            for use, fails in (("jobs", False), ("answers", True), ("rates", True)):
                failures = figure(server, f'ccdt_redis_failures_total{{use="{use}"}}')
                self.assertEqual(failures > 0, fails, "optional calls must time out after 0.2 s")

    def test_jobs_lost_by_redis_are_not_found(self):
        server = self.start()
        job = submit(server, ENDLESS)
        wait_for(server, job, "running")
        stream = Call(server.url(job + "/events"))
        wait_until(lambda: figure(server, "ccdt_event_streams_open") == 1)
        self.redis.cli("FLUSHALL")
        self.redis.cli("SCRIPT", "FLUSH")
        self.assertNotIn(b"event: succeeded", stream.answer().body, "but it ends")
        for path in (job, job + "/result", job + "/events"):
            self.assertEqual(ask(server, path).status, 404)
        wait_until(lambda: figure(server, "ccdt_workers_busy") == 0)
        self.assertEqual(figure(server, "ccdt_job_leases_lost_total"), 1)
        self.assertEqual(wait_for_end(server, submit(server, SMALL))["status"], "succeeded")

    def test_read_only_redis_replica_is_treated_as_unavailable(self):
        with Redis("--replicaof", "127.0.0.1", str(self.redis.port)) as copy:
            with Server("--workers=2", f"--redis={copy.url}") as server:
                refused = wait_until(lambda: (now := ask(server, "/sample", *LATER, data=json.dumps(SMALL))).status == 503
                                and now)
                self.assertGreater(int(refused.headers["retry-after"]), 0)
                self.assertEqual(ask(server, "/sample", data=json.dumps(SMALL)).status, 200)
                copy.cli("REPLICAOF", "NO", "ONE")
                job = wait_until(lambda: (now := ask(server, "/sample", *LATER, data=json.dumps(SMALL))).status == 202
                            and now.headers["location"])
                self.assertEqual(wait_for_end(server, job)["status"], "succeeded")

    def test_results_may_exceed_the_bulk_limit_of_redis(self):
        server = self.start()
        self.redis.cli("CONFIG", "SET", "proto-max-bulk-len", "1mb")
        job = submit(server, {**SMALL, "sites": 100_000, "iterations": 0})
        self.assertEqual(wait_for_end(server, job)["status"], "succeeded")
        self.assertGreater(len(ask(server, job + "/result").body), 3 << 20)

    def test_redis_without_memory_is_reported(self):
        server = self.start()
        done = submit(server, SMALL)
        wait_for_end(server, done)
        self.redis.cli("CONFIG", "SET", "maxmemory", "1")
        refused = ask(server, "/sample", *LATER, data=json.dumps(SMALL))
        self.assertEqual(refused.status, 507, refused)
        self.assertEqual(ask(server, done + "/result").status, 200)
        self.assertEqual(ask(server, done, "--request", "DELETE").status, 204)
        self.redis.cli("CONFIG", "SET", "maxmemory", "0")
        self.assertEqual(wait_for_end(server, submit(server, SMALL))["status"], "succeeded")


class Damage(unittest.TestCase):
    """Keys that other programs have overwritten. None may cause a 500 without a reason, or a job that waits forever."""

    JUNK = (("SET", "junk"), ("ZADD", "1", "junk"), ("HSET", "turn", "junk"))

    def assert_reported(self, answer, key):
        self.assertTrue(answer.status < 500 or b"damaged" in answer.body, f"{key}: {answer}")

    def test_damaged_keys_are_reported(self):
        with Redis() as redis:
            with Server("--workers=2", f"--redis={redis.url}", f"--cache-redis={redis.url}", "--rate-limit=1000000",
                        f"--rate-redis={redis.url}") as server:
                server.wait_for_log("jobs are stored in Redis")
                for junk in self.JUNK:
                    for place in range(15):
                        with self.subTest(junk=junk, place=place):
                            redis.cli("FLUSHALL")
                            self.damage_one_key(redis, server, place, junk)
                figures = figures_at_rest(server)
            self.assertGreater(float(re.search(r"^ccdt_job_store_damages_total (\S+)$", figures, re.MULTILINE)[1]), 10)

    def damage_one_key(self, redis, server, place, junk):
        done = submit(server, SMALL)
        wait_for_end(server, done)
        running = submit(server, ENDLESS)
        wait_for(server, running, "running")
        waiting = submit(server, {**SMALL, "seed": 3})
        keys = sorted(redis.cli("KEYS", "ccdt:1:*").split())
        if place >= len(keys):
            return
        key = keys[place]
        redis.cli("DEL", key)
        redis.cli(junk[0], key, *junk[1:])
        for job in (done, running, waiting):
            self.assert_reported(ask(server, job), key)
            self.assert_reported(ask(server, job + "/result"), key)
        answer = Call(server.url("/sample"), "--header", "Prefer: respond-async", data=json.dumps(SMALL)).answer()
        self.assertEqual(answer.status, 202, key)
        self.assert_reported(ask(server, running, "--request", "DELETE"), key)
        ends = [wait_until(lambda: (now := ask(server, job)).status == 404 or now.json()["finished"] and now.json())
                for job in (waiting, answer.headers["location"])]
        if ends[0] is not True and ends[0]["status"] != "succeeded":
            self.assertIn(key.split(":")[2], ("job", "question"), ends)
        self.assertEqual(ends[1]["status"], "succeeded", f"{key}: the job that was submitted afterwards")
        self.assert_reported(ask(server, "/sample", data=json.dumps(SMALL)), key)
        for job in (done, waiting):
            self.assert_reported(ask(server, job, "--request", "DELETE"), key)


class Shared(unittest.TestCase):
    """Data that servers share besides jobs, each by a separate option."""

    def test_answers_are_computed_once_by_a_shared_cache(self):
        with Redis() as redis, Server(f"--cache-redis={redis.url}") as first, \
                Server(f"--cache-redis={redis.url}") as second:
            answers = [ask(server, "/sample", data=json.dumps(SMALL)) for server in (first, second)]
            self.assertEqual(answers[0].body, answers[1].body)
            self.assertEqual(answers[0].headers["etag"], answers[1].headers["etag"])
            metrics = figures_at_rest(second)
            self.assertIn("\nccdt_cache_hits_total 1\n", metrics)
            self.assertIn("\nccdt_sites_total 0\n", metrics)
            for stop in (redis.pause, redis.kill):
                stop()
                again = ask(second, "/sample", data=json.dumps(SMALL))
                self.assertEqual(without_time(again), without_time(answers[0]))
            self.assertIn(f"\nccdt_sites_total {2 * SMALL['sites']}\n", figures_at_rest(second))
            self.assertEqual(ask(second, "/health/ready").status, 200)
            redis.start()
            wait_until(lambda: ask(second, "/sample", data=json.dumps({**SMALL, "seed": 5})).status == 200
                  and redis.cli("KEYS", "ccdt:2:answer:*"))

    def test_rates_are_counted_over_all_servers(self):
        with Redis() as redis:
            flags = (f"--rate-redis={redis.url}", "--rate-limit=0.001", "--rate-burst=3")
            with Server(*flags) as first, Server(*flags) as second:
                statuses = [ask(server, "/metrics").status for server in (first, second, first, second, first)]
                self.assertEqual(statuses, [200, 200, 200, 429, 429])
                redis.kill()
                statuses = [ask(first, "/metrics").status for _ in range(4)]
                self.assertEqual(statuses, [200, 200, 200, 429], "each server must count by itself")


class Settings(unittest.TestCase):
    def test_settings_of_redis_that_lose_jobs_are_logged(self):
        with Redis("--appendonly", "no", "--maxmemory-policy", "allkeys-lru") as redis:
            with Server(f"--redis={redis.url}") as server:
                server.wait_for_log("appendonly yes")
                server.wait_for_log("maxmemory-policy noeviction")

    def test_passwords_are_not_logged(self):
        with Redis("--requirepass", "secret-word") as redis:
            place = f"127.0.0.1:{redis.port}"
            with Server(environment={"CCDT_REDIS": f"redis://:secret-word@{place}"}) as server:
                job = submit(server, SMALL)
                self.assertEqual(wait_for_end(server, job)["status"], "succeeded")
                self.assertEqual(server.stop(), 0)
                self.assertNotIn("secret-word", server.log())
            with Server(f"--redis=redis://:wrong-word@{place}") as server:
                self.assertIn("WRONGPASS", server.wait_for_log("jobs have to wait"))
                self.assertEqual(server.stop(), 0)
                self.assertNotIn("wrong-word", server.log())

    def test_tls_certificates_are_verified(self):
        with tempfile.TemporaryDirectory() as folder:
            certificate, key = pathlib.Path(folder, "certificate"), pathlib.Path(folder, "key")
            execute(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
                     "-nodes", "-keyout", key, "-out", certificate, "-days", "1", "-subj", "/CN=localhost",
                     "-addext", "subjectAltName=DNS:localhost"], check=True, capture_output=True)
            with Redis(certificate=(str(certificate), str(key))) as redis:
                flag = f"--redis=rediss://localhost:{redis.port}"
                with Server(flag, environment={"SSL_CERT_FILE": str(certificate)}) as server:
                    job = submit(server, {**SMALL, "sites": 50_000, "iterations": 0})
                    self.assertEqual(wait_for_end(server, job)["status"], "succeeded")
                    self.assertGreater(len(ask(server, job + "/result").body), 1 << 20)
                with Server(flag) as server:
                    self.assertIn("certificate", server.wait_for_log("jobs have to wait"))

    def test_unsupported_addresses_are_rejected(self):
        for flags, word in ((["--redis=redis+sentinel://a:26379"], "Sentinel is not supported"),
                            (["--redis=http://a"], "redis://"),
                            (["--redis=redis://a", "--data-dir=b"], "only one of them")):
            result = subprocess.run([os.environ["CCDT_SERVER"], "--port=0", *flags], capture_output=True, text=True,
                                  timeout=PATIENCE, check=False)
            self.assertEqual(result.returncode, 2)
            self.assertIn(word, result.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
