# SPDX-License-Identifier: GPL-3.0-or-later
"""Entity tags, 304, and cached answers."""

import gzip
import pathlib
import re
import tempfile
import unittest

from harness import Server, ServerCase, ask, figures_at_rest, file_of, flat, post_json

PICTURE = file_of(flat(100))
SAMPLE = {"sites": 100, "domain": {"type": "torus", "width": 1, "height": 1}}
CROSSING = {"sites": 9, "polygon": [[0, 0], [1, 1], [1, 0], [0, 1]], "invalid": "reject"}
POINTS = {"points": [[0, 0], [0.5, 0.5], [0.2, 0.7]]}
QUESTIONS = (("/halftone?sites=50", PICTURE), ("/sample", SAMPLE), ("/analyze", POINTS))


def figure(server, name):
    found = re.search(rf"^{name} (\S+)$", figures_at_rest(server), re.MULTILINE)
    return float(found[1])


def pose(server, path, body, *arguments):
    if isinstance(body, bytes):
        return ask(server, path, *arguments, data=body)
    return post_json(server, path, body, *arguments)


def known(*tags):
    return ("--header", "If-None-Match: " + ", ".join(tags))


class CacheCase(ServerCase):
    def pose(self, path, body, *arguments, status=200):
        answer = pose(self.server, path, body, *arguments)
        self.assertEqual(answer.status, status, answer)
        return answer

    def counted(self, action):
        """Returns the increase of hits, misses and computed sites by an action."""
        names = ("ccdt_cache_hits_total", "ccdt_cache_misses_total", "ccdt_sites_total")
        before = [figure(self.server, name) for name in names]
        action()
        return tuple(figure(self.server, name) - old for name, old in zip(names, before))


class Tags(CacheCase):
    """Tags with the cache off: the server has only the tag from the request."""

    def test_avoid_the_computation(self):
        for path, body in QUESTIONS:
            with self.subTest(path=path):
                answer = self.pose(path, body)
                tag = answer.headers["etag"]

                def ask_again():
                    again = self.pose(path, body, *known('"other"', tag), status=304)
                    self.assertEqual((again.body, again.headers["etag"]), (b"", tag))
                    self.assertIn("accept", again.headers["vary"].lower())
                    self.assertNotIn("content-type", again.headers)
                    self.assertNotIn("content-length", again.headers)

                self.assertEqual(self.counted(ask_again), (0, 0, 0))
                self.pose(path, body, *known('"other"', "*"))

    def test_differ_between_requests(self):
        tags = [self.pose("/sample", {**SAMPLE, "seed": seed}).headers["etag"] for seed in range(3)]
        tags += [self.pose("/sample", SAMPLE, "--header", "Accept: " + kind).headers["etag"]
                 for kind in ("text/csv", "image/png")]
        tags += [self.pose("/halftone?sites=50&seed=" + seed, PICTURE).headers["etag"] for seed in "01"]
        self.assertEqual(len(set(tags)), len(tags))
        self.pose("/sample", SAMPLE, *known(*tags[1:]))

    def test_are_strong_if_bytes_are_reproducible(self):
        for kind in ("csv", "geojson", "npy", "svg", "png"):
            first, second = (self.pose("/sample", {**SAMPLE, "format": kind}) for _ in range(2))
            self.assertTrue(first.headers["etag"].startswith('"'), kind)
            self.assertEqual((first.headers["etag"], first.body), (second.headers["etag"], second.body))
        for path, body in QUESTIONS:
            timed = b"elapsed_ms" in (answer := self.pose(path, body)).body
            self.assertEqual(answer.headers["etag"].startswith("W/"), timed, path)

    def test_differ_between_codings(self):
        body = {**SAMPLE, "format": "csv"}
        plain = self.pose("/sample", body)
        packed = self.pose("/sample", body, "--header", "Accept-Encoding: gzip")
        self.assertEqual(gzip.decompress(packed.body), plain.body)
        self.assertEqual(packed.headers["etag"], plain.headers["etag"][:-1] + '-gzip"')
        for tag in (plain.headers["etag"], packed.headers["etag"]):
            again = self.pose("/sample", body, *known(tag), status=304)
            self.assertEqual(again.headers["etag"], tag)

    def test_are_only_on_success(self):
        self.assertNotIn("etag", self.pose("/sample", CROSSING, status=422).headers)
        self.pose("/sample", CROSSING, *known("*"), status=422)

    def test_depend_on_the_limits(self):
        with Server("--max-sites=1000") as other:
            self.assertNotEqual(pose(other, "/sample", SAMPLE).headers["etag"],
                                self.pose("/sample", SAMPLE).headers["etag"])

    def test_do_not_turn_the_cache_on(self):
        self.assertEqual(self.counted(lambda: [self.pose("/sample", SAMPLE) for _ in range(2)]), (0, 0, 200))


class Cache(CacheCase):
    flags = ("--cache=1MiB", "--cors-origin=https://a.example")

    def test_returns_cached_answers(self):
        own = (("/halftone?sites=50&seed=9", PICTURE), ("/sample", {**SAMPLE, "seed": 9}),
               ("/analyze", {"points": [[0.5, 0.5], [0.2, 0.7]]}))  # not what other tests ask the same server
        for i, (path, body) in enumerate(own):
            with self.subTest(path=path):
                answers = []
                hits, misses, _ = self.counted(
                    lambda: answers.extend(self.pose(path, body, "--header", f"X-Request-ID: {i}-{turn}")
                                           for turn in range(3)))
                self.assertEqual((hits, misses), (2, 1))
                self.assertEqual(len({answer.body for answer in answers}), 1)  # with the time that it took
                self.assertEqual(len({answer.headers["etag"] for answer in answers}), 1)
                self.assertEqual({answer.type for answer in answers}, {answers[0].type})
                self.assertNotIn("cache=", self.server.wait_for_log(f"{i}-0 "))
                self.assertIn(" cache=hit", self.server.wait_for_log(f"{i}-1 "))
        self.assertGreater(figure(self.server, "ccdt_cache_bytes"), len(PICTURE))

    def test_computes_each_answer_once(self):
        body = {**SAMPLE, "seed": 1}
        self.assertEqual(self.counted(lambda: [self.pose("/sample", body) for _ in range(4)]), (3, 1, 100))
        for other in ({"seed": 2}, {"mesh": True}, {"quality": "draft"}):
            self.assertEqual(self.counted(lambda: self.pose("/sample", {**body, **other}))[:2], (0, 1))

    def test_serves_each_coding(self):
        body = {**SAMPLE, "seed": 3, "format": "csv"}
        packed = [self.pose("/sample", body, "--header", "Accept-Encoding: gzip") for _ in range(2)]
        plain = [self.pose("/sample", body) for _ in range(2)]
        self.assertEqual(packed[0].body, packed[1].body)
        self.assertEqual({answer.body for answer in plain}, {gzip.decompress(packed[1].body)})
        self.assertEqual({answer.headers["content-encoding"] for answer in packed}, {"gzip"})

    def test_stores_no_errors(self):
        size = figure(self.server, "ccdt_cache_bytes")
        self.assertEqual(self.counted(lambda: [self.pose("/sample", CROSSING, status=422) for _ in range(2)])[0], 0)
        self.assertEqual(figure(self.server, "ccdt_cache_bytes"), size)

    def test_exposes_tags_to_pages(self):
        origin = ("--header", "Origin: https://a.example")
        answer = self.pose("/sample", SAMPLE, *origin)
        self.assertIn("ETag", answer.headers["access-control-expose-headers"])
        preflight = self.ask("/sample", "--request", "OPTIONS", *origin, "--header",
                             "Access-Control-Request-Method: POST")
        self.assertIn("If-None-Match", preflight.headers["access-control-allow-headers"])


class Others(unittest.TestCase):
    def test_partial_answers_are_not_cached(self):
        body = {**SAMPLE, "sites": 2000, "iterations": 1000, "passes": 100, "on_deadline": "partial"}
        with Server("--timeout=1", "--cache=64MiB") as server:
            for _ in range(2):
                answer = post_json(server, "/sample", body)
                self.assertEqual((answer.status, answer.headers.get("x-partial")), (200, "deadline"), answer)
                self.assertNotIn("etag", answer.headers)
            self.assertEqual(figure(server, "ccdt_cache_hits_total"), 0)
            self.assertEqual(figure(server, "ccdt_cache_bytes"), 0)

    def ask_with_two_keys(self, *flags):
        """Sends the same request for Alice and Bob in turn, twice. Returns for each answer whether it was cached, and
        the answers."""
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "keys"
            file.write_text("alice:alice-0123456789abcdef\nbob:bob-0123456789abcdef\n")
            lines, answers = [], []
            with Server(f"--api-key-file={file}", "--cache=1MiB", *flags) as server:
                for name in ("alice", "bob") * 2:
                    bearer = ("--header", f"Authorization: Bearer {name}-0123456789abcdef", "--header",
                              f"X-Request-ID: {len(lines)}-{name}")
                    answers.append(post_json(server, "/sample", SAMPLE, *bearer))
                    lines.append(server.wait_for_log(f"{len(lines)}-{name} "))
                self.assertEqual(post_json(server, "/sample", SAMPLE).status, 401)
        self.assertEqual({answer.status for answer in answers}, {200})
        self.assertEqual(len({answer.headers["etag"] for answer in answers}), 1)
        return ["cache=hit" in line for line in lines], [answer.body for answer in answers]

    def test_keys_have_separate_caches(self):
        hits, bodies = self.ask_with_two_keys()
        self.assertEqual(hits, [False, False, True, True])
        self.assertEqual(bodies[:2], bodies[2:])

    def test_keys_share_the_cache_if_configured(self):
        hits, bodies = self.ask_with_two_keys("--cache-shared=true")
        self.assertEqual(hits, [False, True, True, True])
        self.assertEqual(len(set(bodies)), 1)

    def test_old_answers_are_evicted(self):
        with Server("--cache=200KiB") as server:
            for seed in range(30):  # 45 KiB each
                body = {"sites": 1000, "seed": seed, "domain": SAMPLE["domain"], "quality": "draft"}
                self.assertEqual(post_json(server, "/sample", body).status, 200)
                self.assertLessEqual(figure(server, "ccdt_cache_bytes"), 200 << 10)
            self.assertGreater(figure(server, "ccdt_cache_bytes"), 100 << 10)
            post_json(server, "/sample", body)
            self.assertEqual(figure(server, "ccdt_cache_hits_total"), 1)


if __name__ == "__main__":
    unittest.main(verbosity=2)
