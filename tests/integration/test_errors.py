# SPDX-License-Identifier: GPL-3.0-or-later
"""Every refusal: its status and body. The server must continue."""

import io
import json
import unittest
import zipfile
from random import Random

from harness import PICTURES, Server, ServerCase, ask, data_uri, file_of, flat, post_json

GREY = file_of(flat(128))
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
RECTANGLE = {"type": "rectangle", "width": 2, "height": 1}


class Paths(ServerCase):
    def test_404_for_unknown_paths(self):
        for path in ("/nothing", "/halftone/", "/Halftone", "/health/x", "/%00", "/" + "x" * 8000):
            with self.subTest(path=path[:20]):
                self.assert_problem(self.ask(path), 404)
                self.assert_problem(self.ask(path, data=b"x"), 404)

    def test_405_lists_the_allowed_methods(self):
        for method in ("GET", "HEAD", "PUT", "DELETE", "PATCH", "TRACE", "BREW"):
            for path in ("/halftone", "/sample"):
                with self.subTest(method=method, path=path):
                    option = ["--head"] if method == "HEAD" else ["--request", method]
                    answer = self.ask(path, *option)
                    self.assertEqual(answer.status, 405, answer)
                    self.assertEqual(answer.headers["allow"], "POST, OPTIONS")
        answer = self.ask("/health", data=b"x")
        self.assert_problem(answer, 405)
        self.assertEqual(answer.headers["allow"], "GET, HEAD, OPTIONS")

    def test_options(self):
        answer = self.ask("/halftone", "--request", "OPTIONS")
        self.assertEqual((answer.status, answer.body), (204, b""))
        self.assertEqual(answer.headers["allow"], "POST, OPTIONS")
        self.assertNotIn("content-length", answer.headers)

    def test_options_of_the_server_as_a_whole(self):
        answer = self.ask("/", "--request", "OPTIONS", "--request-target", "*")
        self.assertEqual((answer.status, answer.body), (204, b""))
        self.assertEqual(answer.headers["allow"], "GET, HEAD, POST, DELETE, OPTIONS")
        self.assert_problem(self.ask("/", "--request-target", "*"), 400, "neither a path nor a URL")
        self.assert_problem(self.ask("/%2A", "--request", "OPTIONS"), 404)

    def test_health(self):
        for path in ("/health", "/health/live", "/health/ready"):
            answer = self.ask(path)
            self.assertEqual((answer.status, answer.type), (200, "application/json"))
            head = self.ask(path, "--head")
            self.assertEqual((head.status, head.body), (200, b""))
            self.assertEqual(head.headers["content-length"], str(len(answer.body)))


class EveryAnswer(ServerCase):
    flags = ("--cors-origin=*",)

    def test_has_an_id_timings_and_cors_headers(self):
        answers = [
            self.ask("/health"), self.ask("/nothing"), self.ask("/halftone"), self.ask("/halftone", data=GREY),
            self.ask("/halftone", data=b"no image"), self.ask("/halftone", "--request", "OPTIONS"),
        ]
        for answer in answers:
            self.assertRegex(answer.headers["x-request-id"], r"^[A-Za-z0-9._-]{1,64}$")
            self.assertRegex(answer.headers["server-timing"],
                             r"^queue;dur=[\d.]+, decode;dur=[\d.]+, prepare;dur=[\d.]+, optimise;dur=[\d.]+, encode;dur=[\d.]+"
                             r'(, cpu;dur=[\d.]+, threads;desc="\d+")?$')
            self.assertEqual(answer.headers["access-control-allow-origin"], "*")
        self.assertEqual(len({answer.headers["x-request-id"] for answer in answers}), len(answers))

    def test_keeps_a_well_formed_request_id(self):
        self.assertEqual(self.ask("/health", "--header", "X-Request-ID: my.id-7_x").headers["x-request-id"], "my.id-7_x")
        for bad in ("a b", "a%0d%0aEvil: 1", "x" * 65, "<script>"):
            answer = self.ask("/health", "--header", "X-Request-ID: " + bad)
            self.assertNotEqual(answer.headers["x-request-id"], bad)
            self.assertNotIn("evil", answer.headers)

    def test_preflight(self):
        answer = self.ask("/halftone", "--request", "OPTIONS", "--header", "Origin: https://example.org", "--header",
                          "Access-Control-Request-Method: POST")
        self.assertEqual(answer.status, 204)
        self.assertIn("POST", answer.headers["access-control-allow-methods"])
        self.assertIn("Content-Type", answer.headers["access-control-allow-headers"])

    def test_ignores_ranges_and_unavailable_encodings(self):
        plain = self.ask("/halftone?sites=10", data=GREY)
        for header in ("Range: bytes=0-9", "Range: bytes=0-1,3-4", "Range: nonsense", "Accept-Encoding: br, gzip"):
            answer = self.ask("/halftone?sites=10", "--header", header, data=GREY)
            self.assertEqual((answer.status, answer.body), (200, plain.body))
            self.assertNotIn("content-encoding", answer.headers)


class HalftoneOptions(ServerCase):
    def refuse(self, query, status=400, data=GREY, words=()):
        return self.assert_problem(self.ask("/halftone?" + query, data=data), status, *words)

    def test_unknown_option_is_named(self):
        problem = self.refuse("sytes=10", words=("sytes",))
        self.assertEqual(problem["errors"][0]["pointer"], "sytes")

    def test_values_out_of_range(self):
        for query in ("sites=0", "sites=-1", "sites=1.5", "sites=x", "sites=", "sites", "sites=10%00", "seed=-1",
                      f"seed={2 ** 53}", "iterations=1001", "passes=0", "passes=101", "scale=0", "scale=17",
                      "scale=nan", "scale=1e400", "dot=-1", "dot=inf", "antialias=maybe", "dots=all", "invert=2",
                      "tone=loud",
                      "foreground=reds", "foreground=transparent", "background=%2312"):
            with self.subTest(query=query):
                problem = self.refuse(query)
                self.assertEqual(problem["errors"][0]["pointer"], query.split("=")[0])

    def test_all_errors_are_reported_at_once(self):
        def pointers(problem):
            return [error["pointer"] for error in problem["errors"]]

        problem = self.refuse("sites=0&scale=99")
        self.assertEqual(pointers(problem), ["sites", "scale"])
        self.assertEqual(problem["detail"], "; ".join(error["detail"] for error in problem["errors"]))
        self.refuse("sites=0", data=b"no image", words=("sites", "PNG, JPEG"))
        self.assertEqual(pointers(self.refuse("dot=1mm&palette=reds&color=cmyk&sites=x")), ["palette", "sites"])
        self.assertEqual(pointers(self.refuse("dot=1mm&palette=%23f00&color=cmyk")), ["palette", "dot"])
        for path, body, expected in (
                ("/halftone", {"sites": 0, "scale": 99}, ["/sites", "/scale", "/image"]),
                ("/sample", {"sites": 0, "polygon": SQUARE, "density": {"width": 0, "height": 1, "what": 1}},
                 ["/sites", "/density/width", "/density/what"]),
                ("/sample", {"quality": "draft", "method": "random"}, ["/sites", "/quality"]),
                ("/analyze", {"points": 1, "spectrum": 2, "domain": {"type": "sphere", "width": 0}},
                 ["/points", "/spectrum", "/domain/type", "/domain/width"])):
            with self.subTest(path=path, body=body):
                self.assertEqual(pointers(self.assert_problem(post_json(self.server, path, body), 400)), expected)

    def test_repeated_option(self):
        self.refuse("sites=10&sites=10", words=("sites",))
        self.assert_problem(self.ask("/halftone?sites=1", "--form", f"image=@{PICTURES / 'camera.png'}", "--form",
                                     "sites=1"), 400, "sites")
        self.assert_problem(post_json(self.server, "/halftone?sites=1", {"image": data_uri(GREY), "sites": 1}), 400)

    def test_unknown_formats_are_refused_by_name(self):
        for name in ("bmp", "geojson", "PNG"):
            self.refuse("format=" + name, words=(name,))

    def test_406(self):
        for accept in ("image/gif", "text/html;q=1", "image/*;q=0, application/*;q=0, text/*;q=0, */*;q=0"):
            answer = self.ask("/halftone", "--header", "Accept: " + accept, data=GREY)
            self.assert_problem(answer, 406, "image/png", "application/json", "text/csv", "application/x-npy")
            self.assertIn("Accept", answer.headers["vary"].split(", "))

    def test_form_without_a_picture_or_with_two(self):
        picture = f"@{PICTURES / 'camera.png'}"
        self.assert_problem(self.ask("/halftone", "--form", "sites=1"), 400, "`image` or `file`")
        self.assert_problem(self.ask("/halftone", "--form", "image=" + picture, "--form", "file=" + picture), 400)

    def test_malformed_form(self):
        header = "Content-Type: multipart/form-data"
        self.assert_problem(self.ask("/halftone", "--header", header, data=b"x"), 400, "boundary")
        self.assert_problem(self.ask("/halftone", "--header", header + "; boundary=x", data=b"--x\r\n"), 400)

    def test_malformed_json(self):
        for body in ("", "{", "[]", "null", '{"image":1}', '{"image":"*"}', "{}", '{"image":"' + "A" * 7 + '"}',
                     '{"image":"data:image/png,x"}', "[" * 100_000, b'{"image":"\xff"}'):
            with self.subTest(body=body[:20]):
                answer = post_json(self.server, "/halftone", body)
                self.assertIn(answer.status, (400, 415), answer)
                self.assert_problem(answer, answer.status)

    def test_json_options_of_the_wrong_type(self):
        for option in ({"sites": "10"}, {"sites": 1.5}, {"sites": -1}, {"sites": 1e30}, {"invert": 1},
                       {"tone": None}, {"unknown": 1}):
            with self.subTest(option=option):
                problem = self.assert_problem(
                    post_json(self.server, "/halftone", {"image": data_uri(GREY), **option}), 400)
                self.assertEqual(problem["errors"][0]["pointer"], "/" + next(iter(option)))


class Pictures(ServerCase):
    def test_415_for_unsupported_formats(self):
        for body in (b"8BPS" + b"\0" * 50, b"BM" + b"\0" * 50, b"plain text", b"[]", b"\0"):
            with self.subTest(body=body[:8]):
                self.assert_problem(self.ask("/halftone", data=body), 415)

    def test_400_for_an_empty_body(self):
        self.assert_problem(self.ask("/halftone", data=b""), 400)

    def test_415_for_an_encoded_body(self):
        self.assert_problem(self.ask("/halftone", "--header", "Content-Encoding: gzip", data=GREY), 415)
        self.assert_problem(self.ask("/halftone", "--header", "Content-Encoding: identity", "--header",
                                     "Content-Encoding: gzip", data=GREY), 415)
        answer = self.ask("/halftone", "--header", "Content-Encoding: identity", data=GREY)
        self.assertEqual(answer.status, 200)

    def test_422_for_a_broken_picture(self):
        camera = (PICTURES / "camera.png").read_bytes()
        jpeg = file_of(flat(128, 500, 500), "JPEG")
        for body in (camera[:5000], camera[:20], jpeg[:len(jpeg) // 2], file_of(flat(9), "TIFF")[:200]):
            with self.subTest(body=body[:4]):
                self.assert_problem(self.ask("/halftone", data=body), 422)

    def test_422_for_a_picture_without_ink(self):
        white, black = file_of(flat(255)), file_of(flat(0))
        for query in ("", "?dots=ink", "?dots=both", "?dots=both&format=json"):
            self.assert_problem(self.ask("/halftone" + query, data=white), 422)
        self.assert_problem(self.ask("/halftone?invert=true", data=black), 422)
        self.assertEqual(self.ask("/halftone?invert=true", data=white).status, 200)
        self.assertEqual(self.ask("/halftone", data=black).status, 200)


class SampleRequests(ServerCase):
    def refuse(self, body, status, *words):
        return self.assert_problem(post_json(self.server, "/sample", body), status, *words)

    def test_missing_or_invalid_members(self):
        good = {"sites": 10, "polygon": SQUARE}
        for change in ({"sites": None}, {"sites": 0}, {"sites": "10"}, {"sites": 2.5}, {"seed": -1},
                       {"iterations": 1001}, {"passes": 0}, {"tolerance": 0}, {"mesh": "yes"}, {"unknown": 1},
                       {"polygon": [[0, 0], [1]]}, {"polygon": [[0, 0], [1, "a"], [1, 1]]}, {"polygon": {}},
                       {"domain": RECTANGLE}, {"density": {}}, {"density": {"width": 2, "height": 1, "values": [1]}},
                       {"density": {"width": 1, "height": 1, "values": [-1]}}):
            with self.subTest(change=change):
                self.refuse({**good, **change}, 400)
        self.refuse({**good, "quality": "good"}, 400, "quality", "good")
        self.refuse({"sites": 10}, 400, "polygon")
        self.refuse({"polygon": SQUARE}, 400, "sites")

    def test_unavailable_formats_and_domains_are_refused_by_name(self):
        good = {"sites": 10, "polygon": SQUARE}
        for name in ("bmp", "webp", "CSV"):
            self.refuse({**good, "format": name}, 400, name)
        self.refuse({"sites": 10, "domain": {"type": "sphere", "width": 1, "height": 1}}, 400, "sphere")
        answer = post_json(self.server, "/sample", good, "--header", "Accept: text/html")
        self.assert_problem(answer, 406, "application/json", "text/csv", "application/geo+json", "application/x-npy")

    def test_422_for_invalid_polygons(self):
        bow_tie = [[0, 0], [1, 1], [1, 0], [0, 1]]
        outside = [[2, 2], [3, 2], [3, 3]]
        self.refuse({"sites": 10, "polygon": bow_tie, "invalid": "reject"}, 422, "crosses itself at (0.5, 0.5)")
        self.refuse({"sites": 10, "polygon": [[0, 0], [1, 1], [2, 2]]}, 422)
        self.refuse({"sites": 10, "polygon": [[0, 0], [1, 1]]}, 422)
        self.refuse({"sites": 10, "polygon": SQUARE, "holes": [outside], "invalid": "reject"}, 422, "outside")
        self.refuse({"sites": 10, "polygon": SQUARE, "density": {"width": 1, "height": 1, "values": [0]}}, 422)

    def test_malformed_json(self):
        for body in ("", "{", "[" * 1_000_000, '{"sites":1,"sites":2}', "nul"):
            with self.subTest(body=body[:20]):
                self.refuse(body, 400)

    def test_415_for_other_types(self):
        body = json.dumps({"sites": 10, "polygon": SQUARE})
        for kind in ("image/png", "text/csv", "application/xml"):
            for path in ("/sample", "/analyze"):
                self.assert_problem(self.ask(path, "--header", "Content-Type: " + kind, data=body), 415, kind[:9])
        accepted = "application/zip, application/x-npy, image/tiff, multipart/form-data"
        self.assert_problem(self.ask("/sample", "--header", "Content-Type: text/csv", data=body), 415, accepted)
        kind = "multipart/form-data; boundary=x"
        for path in ("/sample", "/analyze"):
            self.assert_problem(self.ask(path, "--header", "Content-Type: " + kind, data=body), 400, "form")

    def test_options_in_the_query_are_refused(self):
        self.assert_problem(post_json(self.server, "/sample?sites=10", {"polygon": SQUARE}), 400)
        self.assert_problem(post_json(self.server, "/analyze?max_frequency=2", {"points": SQUARE}), 400)

    def test_errors_of_documents_have_options_or_pointers(self):
        square = {"type": "Polygon", "coordinates": [SQUARE]}
        point = {"type": "Feature", "properties": {}, "geometry": {"type": "Point", "coordinates": [0, 0]}}
        for query, document, status, pointer in (
                ("", square, 400, "sites"),
                ("sites=0", square, 400, "sites"),
                ("sites=10&x=1", square, 400, "x"),
                ("sites=10&width=60000&format=png", square, 413, "width"),
                ("sites=10", {"type": "FeatureCollection", "features": [point]}, 400, "/features/0/geometry"),
                ("sites=10", {"type": "Polygon", "coordinates": [[[0, 0], [1, 1], [2, 2]]]}, 422, "/coordinates/0")):
            with self.subTest(query=query, document=document):
                problem = self.assert_problem(post_json(self.server, "/sample?" + query, document), status)
                self.assertEqual(problem["errors"][0]["pointer"], pointer)


class Bodies(ServerCase):
    """Bodies of a kind that an endpoint does not accept."""

    ARCHIVE = io.BytesIO()
    with zipfile.ZipFile(ARCHIVE, "w") as made:
        made.writestr("doc.kml", "<kml/>")
    KINDS = {
        b"": (400, "is empty"),
        b" \r\n": (400, "is empty"),
        b"Dear Sir,": (400, "seems to be text"),
        b"x,y\n1,2\n": (415, "seems to be CSV"),
        b"<?xml version='1.0'?><kml xmlns='http://www.opengis.net/kml/2.2'/>": (415, "seems to be KML"),
        b"<!DOCTYPE html><html></html>": (415, "seems to be HTML"),
        b"<svg xmlns='http://www.w3.org/2000/svg'/>": (415, "seems to be SVG"),
        b"POLYGON ((0 0, 1 0, 1 1, 0 0))": (415, "well-known text (WKT)"),
        b"\x01\x03\x00\x00\x00\x01\x00\x00\x00": (415, "well-known binary (WKB)"),
        b"\x00\x00\x27\x0a" + bytes(96): (415, ".shp"),
        b"\x03\x7b\x05\x1f\x02\x00\x00\x00\x41\x00\x10" + bytes(90): (415, ".dbf"),
        b"\x1f\x8b\x08" + bytes(20): (415, "seems to be gzip"),
        b"SQLite format 3\x00" + bytes(52) + b"GPKG": (415, "a GeoPackage"),
        b"PAR1" + bytes(20): (415, "GeoParquet"),
        b"fgb\x03fgb\x00": (415, "FlatGeobuf"),
        b"%PDF-1.7": (415, "seems to be PDF"),
        b"\x00\x00\x00\x18ftypcrx ": (415, "a camera's raw file"),
        '{"sites":1}'.encode("utf-16"): (415, "UTF-16"),
        '{"sites":1}'.encode("utf-16-le"): (415, "UTF-16"),
        b"\x02\xf0\x0f\xff": (415, "binary data"),
    }

    def test_are_named_by_sample(self):
        for body, (status, words) in {**self.KINDS, GREY: (415, "a picture (PNG)"),
                                      b'{"asset":{"version":"2.0"},"scenes":[]}': (415, "a glTF without meshes")}.items():
            with self.subTest(words=words):
                problem = self.assert_problem(self.ask("/sample?sites=9", data=body), status, words, "accepted are", "a map")
                self.assertNotIn("error at byte", problem["detail"])
        self.assert_problem(self.ask("/sample?sites=9", data=self.ARCHIVE.getvalue()), 422, "no shapefile", "doc.kml")
        self.assert_problem(self.ask("/sample?sites=9", data=b"SOLID a"), 422, "it has no triangles")
        self.assert_problem(self.ask("/sample?sites=9", data='{"sites":'), 400, "not valid JSON: error at byte")

    def test_are_named_by_analyze(self):
        for body, (status, words) in {**self.KINDS, GREY: (415, "a picture (PNG)"),
                                      b'{"type":"Polygon","coordinates":[]}': (415, "seems to be GeoJSON")}.items():
            with self.subTest(words=words):
                self.assert_problem(self.ask("/analyze", data=body), status, words, "accepted are JSON")

    def test_are_named_by_halftone(self):
        for body, (_, words) in self.KINDS.items():
            if body:
                with self.subTest(words=words):
                    self.assert_problem(self.ask("/halftone", data=body), 415, words.removeprefix("seems to be "), "PNG")
        self.assert_problem(self.ask("/halftone", data=b"v 0 0 0\nf 1 1 1\n"), 415, "a mesh (OBJ)")
        self.assert_problem(self.ask("/halftone", data=b"\x93NUMPY\x01\x00"), 415, "a NumPy array")
        self.assert_problem(self.ask("/halftone", data=b'{"type":"Polygon"}'), 415, "seems to be GeoJSON", "pictures")
        self.assert_problem(self.ask("/halftone", data=b'{"type":"Topology"}'), 415, "seems to be TopoJSON")


class Limits(ServerCase):
    flags = ("--max-body=100KiB", "--max-pixels=10000", "--max-sites=100")

    def test_body(self):
        body = b"x" * (100 * 1024 + 1)
        for extra in ((), ("--header", "Transfer-Encoding: chunked"), ("--header", "Expect: 100-continue")):
            answer = self.ask("/halftone", *extra, data=body)
            self.assert_problem(answer, 413, "102400", "max-body")
            self.assertEqual(answer.headers["connection"], "close")
        self.assertEqual(self.ask("/halftone", data=body[1:]).status, 415, "a body at the limit is read")

    def test_a_body_far_over_the_limit_is_not_read(self):
        self.assert_problem(self.ask("/halftone", data=b"x" * 30_000_000), 413)
        self.assert_problem(self.ask("/halftone", "--form", f"image=@{PICTURES / 'astronaut.png'}"), 413)

    def test_pixels(self):
        self.assert_problem(self.ask("/halftone", data=file_of(flat(9, 101, 100))), 413, "10000", "max-pixels")
        self.assertEqual(self.ask("/halftone?scale=1", data=file_of(flat(9, 100, 100))).status, 200)
        self.assert_problem(self.ask("/halftone?scale=2", data=file_of(flat(9, 100, 100))), 413, "10000")
        self.assert_problem(post_json(self.server, "/sample", {
            "sites": 10, "domain": RECTANGLE, "density": {"image": data_uri(file_of(flat(9, 101, 100)))}}), 413)

    def test_sites(self):
        self.assert_problem(self.ask("/halftone?sites=101", data=GREY), 413, "100", "max-sites")
        self.assertEqual(self.ask("/halftone?sites=100", data=GREY).status, 200)
        self.assert_problem(post_json(self.server, "/sample", {"sites": 101, "domain": RECTANGLE}), 413, "max-sites")

    def test_411_without_a_length(self):
        self.assert_problem(self.ask("/halftone", "--request", "POST"), 411)


class Log(unittest.TestCase):
    def test_has_one_json_object_per_line(self):
        with Server("--log-format=json") as server:
            ask(server, "/halftone?sites=10", "--header", "X-Request-ID: mine", data=GREY)
            ask(server, '/no"thing?\\x%0a=%22')
            self.assertEqual(server.stop(), 0)
            lines = [json.loads(line) for line in server.log().splitlines()]
        requests = [line for line in lines if line["message"] == "request"]
        self.assertEqual([line["status"] for line in requests], [200, 404])
        self.assertEqual(requests[0]["id"], "mine")
        self.assertEqual((requests[0]["method"], requests[0]["target"]), ("POST", "/halftone?sites=10"))
        self.assertGreater(requests[0]["bytes_in"], len(GREY))
        self.assertTrue(all("time" in line and "level" in line for line in lines))

    def test_warns_of_points_that_are_not_spread_evenly(self):
        side, random = 128, Random(1)
        # Specks that are smaller than the spacing of the points.
        values = [1 if random.random() < 0.02 else 0.001 for _ in range(side * side)]
        even = {"sites": 1000, "domain": {"type": "rectangle", "width": 1, "height": 1}}
        specks = {**even, "density": {"width": side, "height": side, "values": values}}
        with Server("--log-format=json") as server:
            self.assertGreater(post_json(server, "/sample", specks).json()["variation"], 0.5)
            post_json(server, "/sample", {**specks, "iterations": 4})
            post_json(server, "/sample", even)
            post_json(server, "/sample", {**specks, "seed": 1}, "--header", "Prefer: respond-async")
            server.wait_for_log('"message":"job"')
            self.assertEqual(server.stop(), 0)
            lines = [json.loads(line) for line in server.log().splitlines()]
        levels = [line["level"] for line in lines if line["message"] == "request"]
        self.assertEqual(levels, ["warning", "info", "info", "info"])
        for line in lines:
            self.assertEqual(line["level"] == "warning", "1000 sites" in line.get("cause", ""), line)
        self.assertEqual([line["level"] for line in lines if line["message"] == "job"], ["warning"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
