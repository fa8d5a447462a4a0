# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares /openapi.json with the server that serves it, in both directions."""

import json
import pathlib
import re
import subprocess
import tempfile
import unittest

from jsonschema import Draft202012Validator, RefResolver

from harness import DATA, PATIENCE, ROOT, Server, ServerCase, ask, data_uri, execute, file_of, pixels, post_json, read_line

FILE = (ROOT / "api" / "openapi.json").read_bytes()
DOCUMENT = json.loads(FILE)
SERVER = ROOT / "server"
COMPUTING = ("/halftone", "/sample", "/analyze")

PICTURE = file_of([[0, 80, 160, 240]] * 4)
SHADOW = file_of([[[0, 0, 0, alpha] for alpha in (20, 90, 160, 230)]] * 4)
SAMPLE = {"sites": 20, "domain": {"type": "torus", "width": 1, "height": 1}}
POINTS = {"points": [[0, 0], [0.5, 0.5], [0.2, 0.7]]}
BODIES = {"/halftone": {"image": data_uri(PICTURE), "sites": 20, "format": "json"}, "/sample": SAMPLE,
          "/analyze": POINTS}
SCHEMAS = {"/halftone": "HalftoneRequest", "/sample": "SampleRequest", "/analyze": "AnalyzeRequest"}
ENDLESS = {"sites": 100_000, "iterations": 1000, "passes": 100, "domain": SAMPLE["domain"]}
MESH = (DATA / "meshes" / "house.obj").read_bytes()
CROSSING = {"sites": 9, "polygon": [[0, 0], [1, 1], [1, 0], [0, 1]], "invalid": "reject"}
JOB = "/jobs/" + 32 * "0"

LATER = ("--header", "Prefer: respond-async")


def concrete(path):
    """Returns a path of the document in which names that do not exist replace the parameters."""
    path = path.replace("{z}/{x}/{y}", "0/0/0").replace("/tiles/{id}", JOB.replace("jobs", "tiles"))
    return path.replace("/jobs/{id}", JOB).replace("{name}", "no-picture").replace("{path}", "no-document")


def resolve(node):
    """Returns a node merged with the node that its `$ref` names. Members of the node itself take precedence."""
    while "$ref" in node:
        place = DOCUMENT
        for name in node["$ref"].removeprefix("#/").split("/"):
            place = place[name]
        node = {**place, **{name: value for name, value in node.items() if name != "$ref"}}
    return node


def schema(name):
    return {"$ref": "#/components/schemas/" + name}


POINT_FEATURE = schema("PointFeature")


def faults(value, of):
    return [error.message for error in
            Draft202012Validator(of, resolver=RefResolver.from_schema(DOCUMENT)).iter_errors(value)]


def operations():
    for path, item in DOCUMENT["paths"].items():
        for method, operation in item.items():
            if method != "parameters":
                yield path, method, operation


def properties(name):
    found = {}
    node = resolve(schema(name))
    for part in (*map(resolve, node.get("allOf", ())), node):
        found.update(part.get("properties", {}))
    return {option: resolve(value) for option, value in found.items()}


def options():
    for path, name in SCHEMAS.items():
        for option, described in properties(name).items():
            if option != "image":
                yield path, option, described


def response_of(operation, status):
    responses = operation["responses"]
    return resolve(responses.get(str(status)) or responses[f"{status // 100}XX"])


def comparable(body):
    """Removes the elapsed time, the only member that differs between runs."""
    return re.sub(rb'"elapsed_ms":[^,}]*', b"", body)


class ContractCase(ServerCase):
    def check(self, operation, answer):
        """Asserts that status, media type, schema and headers of an answer are as documented."""
        described = response_of(operation, answer.status)
        content = described.get("content", {})
        kind = answer.type.split(";")[0]
        if content and "*/*" not in content:
            self.assertIn(kind, content)
        if not content:
            self.assertEqual(answer.body, b"")
        if kind.endswith(("/json", "+json")) and kind in content:
            self.assertEqual(faults(answer.json(), content[kind]["schema"]), [])
        if kind.endswith(("ndjson", "json-seq")) and kind in content:
            for line in filter(None, answer.body.decode().split("\n")):
                self.assertEqual(faults(json.loads(line.lstrip("\x1e")), POINT_FEATURE), [])
        for name, header in described.get("headers", {}).items():
            value = answer.headers.get(name.lower())
            header = resolve(header)
            self.assertTrue(value is not None or not header.get("required"), name)
            if value is not None:
                schema = resolve(header["schema"])
                typed = {"integer": int, "number": float}.get(schema.get("type"), str)(value)
                self.assertEqual(faults(typed, schema), [], name)
        self.assertIn("server-timing", answer.headers)
        return answer

    def pose(self, path, body, *arguments, status=200, server=None):
        answer = post_json(server or self.server, path, body, *arguments)
        self.assertEqual(answer.status, status, answer)
        return self.check(DOCUMENT["paths"][path]["post"], answer)


class Document(ContractCase):
    def test_is_served(self):
        answer = self.ask("/openapi.json")
        self.assertEqual((answer.status, answer.type, answer.body), (200, "application/json", FILE))
        again = self.ask("/openapi.json", "--header", "If-None-Match: " + answer.headers["etag"])
        self.assertEqual((again.status, again.body), (304, b""))
        self.assertEqual(self.ask("/openapi.json", "--head").headers["etag"], answer.headers["etag"])

    def test_has_the_version_of_the_server(self):
        result = execute([self.server.process.args[0], "--version"], capture_output=True, text=True, check=True)
        self.assertEqual(result.stdout.split(), ["ccdt-server", DOCUMENT["info"]["version"]])

    def test_has_valid_schemas(self):
        for name, described in DOCUMENT["components"]["schemas"].items():
            with self.subTest(name=name):
                Draft202012Validator.check_schema(described)
        referred = set(re.findall(r'"#/components/(\w+/[\w-]+)', FILE.decode()))
        known = {f"{kind}/{name}" for kind, members in DOCUMENT["components"].items() for name in members}
        self.assertEqual(referred, {name for name in known if not name.startswith("securitySchemes")})

    def test_has_examples_that_work(self):
        tried = 0
        for path, method, operation in operations():
            for media, content in operation.get("requestBody", {}).get("content", {}).items():
                for name, example in content.get("examples", {}).items():
                    with self.subTest(path=path, example=name):
                        self.assertEqual((method, media), ("post", "application/json"))
                        self.assertEqual(faults(example["value"], content["schema"]), [])
                        self.pose(path, example["value"])
                    tried += 1
        self.assertGreater(tried, 8)

    def test_lists_all_media_types_of_requests(self):
        kinds = DOCUMENT["paths"]["/halftone"]["post"]["requestBody"]["content"]
        self.assertEqual(set(kinds), {"application/octet-stream", "multipart/form-data", "application/json"})
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "picture.png"
            file.write_bytes(PICTURE)
            form = self.ask("/halftone", "--form", f"image=@{file}", "--form", "sites=20")
        plain = self.ask("/halftone?sites=20", "--header", "Content-Type: application/octet-stream", data=PICTURE)
        embedded = self.pose("/halftone", {**BODIES["/halftone"], "format": "png"})
        self.assertEqual(form.body, plain.body)
        self.assertEqual(form.body, embedded.body)


class Routes(ContractCase):
    def test_match_the_server(self):
        source = (SERVER / "routes" / "routes.cpp").read_text()
        found = re.findall(r'\{"(/[^"]*)", "([A-Z]+)", ConnectionClass::\w+, Access::\w+, &Routes::\w+,\s+'
                           r'(?:nullptr|find_operation\("/halftone"\))\}', source)
        self.assertEqual(len(found), source.count('{"/'))
        computed = re.findall(r'\{"(/[^"]*)", (?:\w+, )+"\w*", parse_\w+\}',
                              (SERVER / "requests" / "operation.h").read_text())
        self.assertEqual(set(computed), set(COMPUTING))
        found += [(path, "POST") for path in computed]
        self.assertEqual(sorted(found), sorted((path, method.upper()) for path, method, _ in operations()))

    def test_accept_the_documented_methods(self):
        for path, item in DOCUMENT["paths"].items():
            with self.subTest(path=path):
                methods = {method.upper() for method in item if method != "parameters"} | {"OPTIONS"}
                methods |= {"HEAD"} if "GET" in methods else set()
                here = concrete(path)
                allowed = self.ask(here, "--request", "OPTIONS").headers["allow"]
                self.assertEqual(set(allowed.split(", ")), methods)
                for method in {"GET", "POST", "PUT", "PATCH", "DELETE"} - methods:
                    answer = self.ask(here, "--request", method)
                    self.assertEqual(answer.status, 405, method)
                    for operation in (operation for other, _, operation in operations() if other == path):
                        self.check(operation, answer)

    def test_answer_get_as_documented(self):
        for path in ("/", "/capabilities", "/openapi.json", "/health", "/health/live", "/health/ready", "/metrics"):
            with self.subTest(path=path):
                answer = self.ask(path)
                self.assertEqual(answer.status, 200)
                self.check(DOCUMENT["paths"][path]["get"], answer)

    def test_unknown_paths_are_not_found(self):
        for path in ("/halftones", "/jobs", "/jobs/", "/openapi.yaml", "/health/dead"):
            self.assert_problem(self.ask(path), 404)

    def test_jobs_answer_as_documented(self):
        paths = DOCUMENT["paths"]
        for path in COMPUTING:
            with self.subTest(path=path):
                job = self.pose(path, BODIES[path], *LATER, status=202).headers["location"]
                self.check(paths["/jobs/{id}/events"]["get"], self.ask(job + "/events"))  # until the job has ended
                self.assertEqual(self.check(paths["/jobs/{id}"]["get"], self.ask(job)).json()["status"], "succeeded")
                result = self.check(paths["/jobs/{id}/result"]["get"], self.ask(job + "/result"))
                self.check(paths[path]["post"], result)
                gone = self.check(paths["/jobs/{id}"]["delete"], self.ask(job, "--request", "DELETE"))
                self.assertEqual(gone.status, 204)


NEED_A_WIDTH = [*(("format", name) for name in ("pdf", "eps", "hpgl", "gcode", "dxf")),
                *(("style", name) for name in ("circles", "spiral", "path"))]


def map_of(people):
    square = {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]]}
    return {"type": "FeatureCollection",
            "features": [{"type": "Feature", "properties": {"people": people}, "geometry": square}]}


# Members of a request for tiles, beside those of other requests.
TILES = {"domain": None, "polygon": [[0, 0], [9, 0], [9, 8]], "coordinates": "lonlat", "format": "pmtiles"}


def without_none(members):
    return {name: value for name, value in members.items() if value is not None}


class Options(ContractCase):
    # A request in which the option makes a difference.
    BASES = {("/halftone", "style"): {"format": "svg"}, ("/halftone", "antialias"): {"format": "png"},
             ("/halftone", "dot"): {"format": "png", "dots": "ink"}, ("/halftone", "alpha"): {"image": data_uri(SHADOW)}, ("/halftone", "foreground"): {"format": "png"},
             ("/halftone", "background"): {"format": "png"}, ("/halftone", "width"): {"format": "png", "height": 1},
             ("/halftone", "height"): {"format": "png", "width": 1},
             ("/halftone", "fit"): {"format": "png", "width": 30, "height": 10},
             ("/halftone", "gravity"): {"format": "png", "width": 10, "height": 30, "fit": "cover"},
             ("/sample", "style"): {"format": "svg"}, ("/sample", "multipoint"): {"format": "geojson"},
             **{(path, option): {"format": "gcode", "style": "spiral", "width_mm": 100}
                for path in ("/halftone", "/sample") for option in ("speed", "dwell", "machine", "dwell_unit", "pen_down", "pen_up")},
             **{(path, "split"): {"format": "svg", "width_mm": 100, "style": "stroke"} for path in ("/halftone", "/sample")},
             **{(path, "dpi"): {"format": "png", "width_mm": 10} for path in ("/halftone", "/sample")},
             **{(path, "jpeg_quality"): {"format": "jpeg"} for path in ("/halftone", "/sample")},
             **{(path, option): {"format": "svg", "paper": "2010x2010"} for path in ("/halftone", "/sample") for option in ("margin", "marks")},
             **{(path, "closed"): {"format": "svg", "style": "path", "width_mm": 100} for path in ("/halftone", "/sample")},
             **{(path, "pen"): {"format": "svg", "style": "spiral", "width_mm": 1} for path in ("/halftone", "/sample")},
             **{("/sample", option): {"domain": None, "geometry": map_of(20), "sites": "people", "format": "svg"} for option in ("outlines", "legend")},
             **{("/sample", option): TILES for option in ("minzoom", "maxzoom", "dots_per_tile")},
             ("/sample", "per"): {"domain": None, "geometry": map_of(20), "sites": "people"},
             ("/sample", "buffer"): {"domain": {"type": "rectangle", "width": 1, "height": 1}},
             ("/sample", "coordinates"): {"domain": None, "polygon": [[0, 0], [90, 0], [90, 80]]}}

    def base(self, path, option=""):
        return without_none({**BODIES[path], **self.BASES.get((path, option), {})})

    def refuse(self, path, option, value):
        answer = post_json(self.server, path, {**self.base(path), option: value})
        self.assertIn(answer.status, (400, 413), (option, value))
        self.check(DOCUMENT["paths"][path]["post"], answer)
        problem = answer.json()
        self.assertTrue(problem["errors"][0]["pointer"].startswith("/" + option), problem)
        self.assertNotEqual(faults({**self.base(path), option: value}, schema(SCHEMAS[path])), [], (option, value))
        return problem["detail"]

    def take(self, path, option, value, status=200):
        body = {**self.base(path, option), option: value}
        if option == "sites" and value > 1000:
            body.update({"iterations": 0, "format": "npy"})
        if option == "format" and value in ("mask", "mask16", "masknpy"):
            del body["sites"]
            body["domain"] = {"type": "torus", "width": 16, "height": 8}
        if (option, value) == ("format", "pmtiles"):
            body = without_none({**body, **TILES})
        if (option, value) in NEED_A_WIDTH or option == "minutes":
            body["width_mm"] = 100
        if option == "minutes":
            body.pop("sites", None)
        if option == "per" and value > 1000:
            body["geometry"] = map_of(20 * value)
        self.assertEqual(faults(body, schema(SCHEMAS[path])), [], (option, value))
        return self.pose(path, body, status=status)

    def test_match_the_server(self):
        for path, name in SCHEMAS.items():
            detail = self.refuse(path, "nonsense", 1)
            known = detail.split(" are ")[1].split(", ")
            self.assertEqual(sorted(known), sorted(set(properties(name)) - {"image"}), path)
        for option, name in (("domain", "Domain"), ("density", "Density")):
            detail = self.refuse("/sample", option, {"nonsense": 1})
            parts = [resolve(schema(name)), *resolve(schema(name)).get("oneOf", ())]
            members = {member for part in parts for member in part.get("properties", {})}
            self.assertEqual(sorted(detail.split(" are ")[1].split(", ")),
                             sorted(f"/{option}/{member}" for member in members))

    def test_match_the_server_in_queries(self):
        answer = self.ask("/halftone?nonsense=1", data=PICTURE)
        known = answer.json()["detail"].split(" are ")[1].split(", ")
        self.assertEqual(sorted(known), sorted(properties("HalftoneOptions")))

    def test_have_the_documented_ranges(self):
        tried = 0
        for path, option, described in options():
            for part in described.get("anyOf", [described]):
                step = 1 if part.get("type") == "integer" else 0.01
                for bound, outwards in (("minimum", -step), ("maximum", step)):
                    if bound in part:
                        with self.subTest(path=path, option=option, bound=bound):
                            self.take(path, option, part[bound])
                            self.refuse(path, option, part[bound] + outwards)
                        tried += 1
                if "exclusiveMinimum" in part:
                    with self.subTest(path=path, option=option):
                        self.take(path, option, part["exclusiveMinimum"] + step)
                        self.refuse(path, option, part["exclusiveMinimum"])
                    tried += 1
        self.assertGreater(tried, 25)

    def test_without_documented_bounds_have_none(self):
        for path, option, described in options():
            for part in described.get("anyOf", [described]):
                if part.get("type") == "number" and "maximum" not in part:
                    with self.subTest(path=path, option=option):
                        self.take(path, option, 1e300, 422 if option == "buffer" else 200)  # no place is as far inside

    def test_have_the_documented_enumerations(self):
        tried = 0
        for path, option, described in options():
            words = described.get("enum", [])
            for word in words:
                with self.subTest(path=path, option=option, word=word):
                    self.take(path, option, word)
            if words:
                detail = self.refuse(path, option, "nonsense").split("nonsense")[1]
                named = detail.split(" are ")[1].split(", ") if " are " in detail else re.findall(r"'(\w+)'", detail)
                self.assertEqual(sorted(named), sorted(words), option)
                tried += 1
        self.assertGreater(tried, 10)

    def test_have_the_documented_types(self):
        wrong = {"integer": 1.5, "number": "1", "boolean": "true", "string": 1, "array": {}}
        for path, option, described in options():
            if described.get("type") in wrong:
                with self.subTest(path=path, option=option):
                    self.refuse(path, option, wrong[described["type"]])

    def test_have_the_documented_defaults(self):
        others = {"seed": 1, "per": 2, "iterations": 6, "passes": 6, "quality": "best", "dot": 0.5, "detail": 1, "alpha": "linear", "levels": [0.2, 1], "fit": "cover", "gravity": [0, 1],
                  "tone": "perceptual", "foreground": "#123456", "background": "#123456",
                  "color": "cmyk", "style": "stroke", "closed": True, "margin": 20, "marks": True, "jpeg_quality": 50, "pen": 1, "speed": 50, "dwell": 1, "machine": "marlin", "method": "odt", "mesh": True, "coordinates": "lonlat",
                  "max_frequency": 5, "spectrum": True, "multipoint": False, "minzoom": 1, "dots_per_tile": 1, "buffer": 0.1, "format": "svg", "domain": {"type": "rectangle", "width": 2, "height": 1}}
        alike = {"on_deadline", "invalid"}  # these make no difference to a request that is valid and in time
        tried = set()
        for path, option, described in options():
            if "default" in described:
                with self.subTest(path=path, option=option):
                    body = self.base(path, option)
                    if option == "format":
                        body.pop("format", None)
                    left_out = self.pose(path, body)
                    given = self.take(path, option, described["default"])
                    self.assertEqual(left_out.type, given.type)
                    self.assertEqual(comparable(left_out.body), comparable(given.body))
                    if option not in alike:
                        other = self.take(path, option, others[option])
                        self.assertNotEqual(comparable(other.body), comparable(given.body))
                tried.add(option)
        self.assertEqual(tried - alike, set(others))

    def test_accept_documented_colours(self):
        for colour in ("#abc", "#aBcDeF", "teal"):
            self.take("/halftone", "foreground", colour)
            self.take("/halftone", "background", colour)
        for colour in ("Red", "#abcd", "012", "dark red"):
            self.refuse("/halftone", "foreground", colour)
        self.assertEqual(pixels(self.pose("/halftone", {**self.base("/halftone"), "format": "png",
                                                       "background": "transparent"}).body, "RGBA")[..., 3].min(), 0)

    def test_accept_documented_palettes(self):
        six = [f"#00{digit}" for digit in range(6)]
        for palette in ("#abc", "#abc, #aBcDeF ,black", ["#abc"], ["#abc", "#aBcDeF"], ",".join(six), six):
            self.take("/halftone", "palette", palette)
        for palette in ("", "Red", "#abc,", "#abc #000", [], ["Red"], [7], 7, ["#abc", "#abc"], six + ["#abc"],
                        ",".join(six + ["#abc"])):
            self.refuse("/halftone", "palette", palette)

    def test_accept_documented_levels(self):
        for levels in ("0,1", "0.1,0.9,1.2", " 0.1 , 0.9,1e-1", [0, 1], [0.1, 0.9, 10]):
            self.take("/halftone", "levels", levels)
        for levels in ("", "0.1", "0,1,1,1", "0;1", "a,b", [], [0.1], [0, 1, 1, 1], ["0", "1"], [-0.1, 1], [0, 1.1],
                       [0, 1, 0.09], [0, 1, 10.1], 0.1):
            self.refuse("/halftone", "levels", levels)


class PixelRequests(ContractCase):
    DOMAIN = {"type": "pixels", "width": 16, "height": 12}
    BASE = {"sites": 50, "domain": DOMAIN}

    def refuse(self, members):
        """Asserts that a body is refused, as its schema says, and returns the fields of the errors."""
        body = {**self.BASE, **members}
        answer = post_json(self.server, "/sample", body)
        self.assertEqual(answer.status, 400, members)
        self.check(DOCUMENT["paths"]["/sample"]["post"], answer)
        self.assertNotEqual(faults(body, schema("PixelRequest")), [], members)
        return answer.json()

    def test_match_the_server(self):
        known = self.refuse({"nonsense": 1})["detail"].split(" are ")[1].split(", ")
        self.assertEqual(sorted(known), sorted(properties("PixelRequest")))

    def test_are_answered_as_documented(self):
        for members in ({}, {"seed": 5, "on_deadline": "partial"}, {"calibration": {"width": 3}},
                        {"include": [[15, 11], {}], "sites": 192}, {"include": [{"y": 2, "height": 1}]},
                        {"density": {"width": 1, "height": 2, "values": [1, 2]}},
                        {"density": {"image": data_uri(PICTURE)}}):
            for word in properties("PixelRequest")["format"]["enum"]:
                with self.subTest(members=members, format=word):
                    body = {**self.BASE, **members, "format": word}
                    self.assertEqual(faults(body, schema("PixelRequest")), [])
                    answer = self.pose("/sample", body)
                    if word == "json":
                        self.assertEqual(faults(answer.json(), schema("PixelPoints")), [])
                        self.assertEqual(len(answer.json()["points"]), body["sites"])

    def test_are_refused_as_documented(self):
        for members, pointer in (
                ({"sites": 0}, "/sites"), ({"sites": 1.5}, "/sites"), ({"format": "svg"}, "/format"),
                ({"domain": {**self.DOMAIN, "width": 0}}, "/domain/width"),
                ({"domain": {**self.DOMAIN, "height": 65_536}}, "/domain/height"),
                ({"domain": {"type": "pixels", "width": 3}}, "/domain"), ({"calibration": {}}, "/calibration"),
                ({"calibration": {"height": 0}}, "/calibration/height"), ({"include": [[1]]}, "/include/0"),
                ({"include": [[1, -1]]}, "/include/0/1"), ({"include": [{"width": 0}]}, "/include/0/width"),
                ({"include": [{"z": 1}]}, "/include/0/z"), ({"include": {}}, "/include"), ({"seed": -1}, "/seed")):
            with self.subTest(members=members):
                self.assertEqual([error["pointer"] for error in self.refuse(members)["errors"]], [pointer])


class ChoiceRequests(ContractCase):
    BASE = {"sites": 3, "candidates": [[0, 0], [0.1, 0], [4, 0], [4, 3], [0, 3]]}

    def test_are_answered_as_documented(self):
        for members in ({}, {"seed": 5, "keep": [3]}, {"density": [1, 2, 0, 1, 1], "priority": [0, 1, 2, 3, 4]},
                        {"coordinates": "lonlat"}, {"candidates": [[0, 0, i] for i in range(9)], "domain": "solid"}):
            for word in properties("ChoiceRequest")["format"]["enum"]:
                with self.subTest(members=members, format=word):
                    body = {**self.BASE, **members, "format": word}
                    self.assertEqual(faults(body, schema("ChoiceRequest")), [])
                    answer = self.pose("/sample", body)
                    if word == "json":
                        self.assertEqual(faults(answer.json(), schema("ChosenPoints")), [])
                        self.assertEqual(len(answer.json()["indices"]), 3)


class SurfaceRequests(ContractCase):
    VALUES = {"domain": "surface", "density": "curvature", "fixed": "[[0,0,0]]", "crease": "45", "mesh": "true", "order": "progressive",
              "quality": "draft", "iterations": "1", "passes": "1", "seed": "5", "on_deadline": "partial"}

    def post(self, query, status=200):
        answer = self.ask("/sample?" + query, data=MESH)
        self.assertEqual(answer.status, status, answer)
        return self.check(DOCUMENT["paths"]["/sample"]["post"], answer)

    def test_match_the_server(self):
        known = self.post("sites=5&nonsense=1", 400).json()["detail"].split(" are ")[1].split(", ")
        self.assertEqual(sorted(known), sorted(properties("SurfaceOptions")))

    def test_are_answered_as_documented(self):
        self.assertEqual({*self.VALUES, "sites", "format"}, set(properties("SurfaceOptions")))
        for option, value in self.VALUES.items():
            with self.subTest(option):
                value = value.replace("[", "%5B").replace("]", "%5D")
                answer = self.post(f"sites=20&{option}={value}").json()
                self.assertEqual(faults(answer, schema("SurfacePoints")), [])
        for option, described in properties("SurfaceOptions").items():
            for word in described.get("enum", ()):
                with self.subTest(option, word=word):
                    self.post(f"sites=20&{option}={word}" + ("&mesh=true" if word in ("obj", "stl") else ""))

    def test_have_the_documented_defaults(self):
        for option, described in properties("SurfaceOptions").items():
            if "default" in described:
                with self.subTest(option):
                    given = self.post(f"sites=20&{option}={str(described['default']).lower()}")
                    self.assertEqual(comparable(given.body), comparable(self.post("sites=20").body))

    def test_have_the_documented_ranges(self):
        for option, described in properties("SurfaceOptions").items():
            for bound, outwards in (("minimum", -1), ("maximum", 1)):
                if bound in described and (option, bound) not in (("sites", "maximum"), ("iterations", "maximum")):
                    self.post(f"sites=2&{option}={described[bound] + outwards}" if option != "sites" else "sites=0", 400)
        self.post("sites=2&crease=0", 400)


class VolumeRequests(ContractCase):
    BODY = {"sites": 20, "domain": {"type": "torus", "width": 1, "height": 1, "depth": 1}}
    VALUES = {"seed": 5, "quality": "stealthy", "on_deadline": "partial", "fixed": [[0.5, 0.5, 0.5]],
              "order": "progressive", "mesh": True, "density": {"width": 1, "height": 1, "depth": 2, "values": [1, 2]}}

    def test_are_answered_as_documented(self):
        sides = {"width": 2, "height": 1, "depth": 0.5}
        self.assertEqual({*self.VALUES, *sides, "sites", "domain", "format"}, set(properties("VolumeRequest")))
        for members in (*({option: value} for option, value in self.VALUES.items()), {"domain": "box", **sides}):
            with self.subTest(members):
                body = {**self.BODY, **members}
                self.assertEqual(faults(body, schema("VolumeRequest")), [])
                self.assertEqual(faults(self.pose("/sample", body).json(), schema("VolumePoints")), [])

    def test_match_the_server(self):
        answers = {"VolumeRequest": self.pose("/sample", {**self.BODY, "nonsense": 1}, status=400),
                   "VolumeOptions": self.ask("/sample?domain=solid&nonsense=1", data=MESH)}
        for name, answer in answers.items():
            known = answer.json()["detail"].split(" are ")[1].split(";")[0].split(", ")
            self.assertEqual(sorted(known), sorted(properties(name)))

    def test_have_the_documented_defaults(self):
        for option, described in properties("VolumeRequest").items():
            if "default" in described:
                given = self.pose("/sample", {**self.BODY, option: described["default"]})
                self.assertEqual(comparable(given.body), comparable(self.pose("/sample", self.BODY).body))


class Formats(ContractCase):
    def test_match_the_document(self):
        for path, name in SCHEMAS.items():
            content = DOCUMENT["paths"][path]["post"]["responses"]["200"]["content"]
            words = properties(name)["format"]["enum"]
            given = BODIES[path] if path == "/analyze" else {**BODIES[path], "width_mm": 100}
            made = [self.pose(path, {**given, "format": word}).type.split(";")[0]
                    for word in words if not word.startswith(("mask", "pmtiles"))]
            tiles = without_none({**BODIES[path], **TILES}) if path == "/sample" else {}
            made += [self.pose(path, tiles).type] if tiles else []
            device = {"image": given.get("image"), "device": "1bit"}
            words = properties("DeviceOptions")["format"]["enum"] if path == "/halftone" else ()
            for_devices = [self.pose(path, {**device, "format": word}).type for word in words if word != "png"]
            words = properties("SurfaceOptions")["format"]["enum"] if path == "/sample" else ()
            words = [word for word in words if word not in properties(name)["format"]["enum"]]
            for_meshes = [self.ask(f"/sample?sites=9&mesh=true&format={word}", data=MESH).type for word in words]
            words = properties("VolumeRequest")["format"]["enum"][4:] if path == "/sample" else ()
            space = {**VolumeRequests.BODY, "sites": 200, "mesh": True}
            in_space = [self.pose(path, {**space, "format": word}).type for word in words]
            split = [] if path == "/analyze" else [self.pose(path, {**given, "format": "svg", "split": "ink"}).type]
            self.assertEqual(sorted(made + for_devices + for_meshes + in_space + split), sorted(content))
            body = {option: value for option, value in given.items() if option != "format"}
            for media in in_space:
                self.assertEqual(self.pose(path, space, "--header", "Accept: " + media).type, media)
            for media in set(content) - set(for_meshes) - set(in_space) - set(split):
                posed = device if media in for_devices else tiles if media == "application/vnd.pmtiles" else body
                answer = self.pose(path, {option: value for option, value in posed.items() if option != "format"},
                                   "--header", "Accept: " + media)
                self.assertEqual(answer.type.split(";")[0], media)
            for media in for_meshes:
                answer = self.ask("/sample?sites=9&mesh=true", "--header", "Accept: " + media, data=MESH)
                self.assertEqual(answer.type, media)


class Statuses(ContractCase):
    """Provokes the documented statuses, and looks for undocumented ones in the source."""

    flags = ("--max-sites=100",)

    # Rare statuses, which the tests named here provoke.
    ELSEWHERE = {("/health/ready", "503"): "test_lifecycle", ("/halftone", "507"): "job_store_test.cpp",
                 ("/sample", "507"): "job_store_test.cpp", ("/analyze", "507"): "job_store_test.cpp",
                 ("/jobs/{id}/result", "503"): "test_jobs", ("/jobs/{id}", "503"): "test_replicas"}

    def setUp(self):
        self.seen = set()

    def see(self, path, method, answer, status):
        self.assertEqual(answer.status, status, answer)
        self.check(DOCUMENT["paths"][path][method], answer)
        self.seen.add((path, str(status)))

    def see_computing(self, path):
        body = BODIES[path]
        answer = post_json(self.server, path, body)
        self.see(path, "post", answer, 200)
        known = ("--header", "If-None-Match: " + answer.headers["etag"])
        self.see(path, "post", post_json(self.server, path, body, *known), 304)
        self.see(path, "post", post_json(self.server, path, body, *LATER), 202)
        self.see(path, "post", post_json(self.server, path, "{"), 400)
        plain = {option: value for option, value in body.items() if option != "format"}
        self.see(path, "post", post_json(self.server, path, plain, "--header", "Accept: text/html"), 406)
        self.see(path, "post", self.ask(path, "--request", "POST"), 411)
        many = {"points": [[i / 101, 0.5] for i in range(101)]} if path == "/analyze" else {**body, "sites": 101}
        self.see(path, "post", post_json(self.server, path, many), 413)
        self.see(path, "post", post_json(self.server, path, body, "--header", "Content-Encoding: br"), 415)
        useless = {"/halftone": {"image": data_uri(file_of([[255]]))}, "/sample": CROSSING,
                   "/analyze": {"points": [[0, 0], [2, 2]]}}
        self.see(path, "post", post_json(self.server, path, useless[path]), 422)

    def see_locked(self, server, status):
        for path, method, operation in operations():
            if str(status) in operation["responses"]:
                arguments = ("--request", method.upper())
                data = b"{}" if method == "post" else None
                self.see(path, method, ask(server, concrete(path), *arguments, data=data), status)

    def see_late(self):
        with Server("--workers=1", "--timeout=0.3", "--max-connections=4") as server:
            self.see("/sample", "post", post_json(server, "/sample", ENDLESS), 504)
            job = post_json(server, "/sample", ENDLESS, *LATER).headers["location"]
            self.see("/jobs/{id}/result", "get", ask(server, job + "/result"), 409)
            self.see("/sample", "post", post_json(server, "/sample", ENDLESS), 503)
            self.see("/jobs/{id}", "delete", ask(server, job, "--request", "DELETE"), 204)
            self.see("/jobs/{id}/result", "get", ask(server, job + "/result"), 410)

    def see_parts(self, result):
        for asked, status in (("bytes=0-9", 206), ("bytes=99999-", 416)):
            self.see("/jobs/{id}/result", "get", self.ask(result, "--header", "Range: " + asked), status)

    def see_tiles(self):
        job = self.see_ended(self.server, without_none({**SAMPLE, **TILES, "minzoom": 1, "maxzoom": 1}), 200)
        tiles = job.replace("jobs", "tiles")
        self.see("/tiles/{id}.json", "get", self.ask(tiles + ".json"), 200)
        path = "/tiles/{id}/{z}/{x}/{y}.mvt"
        answer = self.ask(tiles + "/1/1/0.mvt")
        self.see(path, "get", answer, 200)
        known = ("--header", "If-None-Match: " + answer.headers["etag"])
        self.see(path, "get", self.ask(tiles + "/1/1/0.mvt", *known), 304)
        self.see(path, "get", self.ask(tiles + "/1/0/0.mvt"), 204)

    def see_documents(self):
        with Server(f"--docs={SERVER / 'page' / 'site'}") as server:
            answer = ask(server, "/docs/page.css")
            self.see("/docs/{path}", "get", answer, 200)
            known = ("--header", "If-None-Match: " + answer.headers["etag"])
            self.see("/docs/{path}", "get", ask(server, "/docs/page.css", *known), 304)

    def see_ended(self, server, body, status, path="/sample"):
        job = post_json(server, path, body, *LATER).headers["location"]
        self.see("/jobs/{id}/events", "get", ask(server, job + "/events"), 200)
        self.see("/jobs/{id}", "get", ask(server, job), 200)
        self.see("/jobs/{id}/result", "get", ask(server, job + "/result"), status)
        return job

    def test_match_the_document(self):
        for path in COMPUTING:
            self.see_computing(path)
        for path, method, operation in operations():
            if "404" in operation["responses"]:
                answer = self.ask(concrete(path), "--request", method.upper())
                self.see(path, method, answer, 404)
            elif "200" in operation["responses"] and method == "get":
                answer = self.ask(path)
                self.see(path, method, answer, 200)
                if "304" in operation["responses"]:
                    known = ("--header", "If-None-Match: " + answer.headers["etag"])
                    self.see(path, method, self.ask(path, *known), 304)
        result = self.see_ended(self.server, SAMPLE, 200) + "/result"
        known = ("--header", "If-None-Match: " + self.ask(result).headers["etag"])
        self.see("/jobs/{id}/result", "get", self.ask(result, *known), 304)
        self.see_parts(result)
        self.see_tiles()
        self.see_ended(self.server, CROSSING, 422)
        wide = {**BODIES["/halftone"], "image": data_uri(file_of([[0] * 1200])), "format": "webp", "scale": 16}
        self.see_ended(self.server, wide, 413, "/halftone")
        with Server("--job-timeout=0.1") as server:
            self.see_ended(server, ENDLESS, 504)
        with Server("--job-bytes=2KiB") as server:
            self.see_ended(server, {**SAMPLE, "sites": 100}, 507)
        self.see_late()
        with Server("--rate-limit=0.000001", "--rate-burst=1") as server:
            ask(server, "/metrics")
            self.see_locked(server, 429)
        with tempfile.NamedTemporaryFile("w") as file:
            file.write("alice:alice-0123456789abcdef\n")
            file.flush()
            with Server("--api-key-file=" + file.name) as server:
                self.see_locked(server, 401)
        self.see_streams()
        self.see_pictures()
        self.see_documents()
        documented = {(path, status) for path, _, operation in operations() for status in operation["responses"]
                      if not status.endswith("XX")}
        # Answers common to all routes that compute are provoked at only one of them.
        alike = {(path, status) for path in (*COMPUTING, "/halftone/{name}") for status in ("503", "504")}
        self.assertEqual(documented - self.seen - set(self.ELSEWHERE) - alike, set())
        self.assertEqual({status for _, status in alike} - {status for _, status in self.seen}, set())

    def see_pictures(self):
        def see(server, target, status, *arguments):
            answer = ask(server, target, *arguments)
            self.see("/halftone/{name}", "get", answer, status)
            return answer

        with tempfile.TemporaryDirectory() as folder:
            for name, file in (("cat", PICTURE), ("text", b"no picture"), ("white", file_of([[255]]))):
                (pathlib.Path(folder) / name).write_bytes(file)
            with Server(f"--pictures={folder}", "--max-sites=100") as server:
                tag = see(server, "/halftone/cat?sites=20", 200).headers["etag"]
                see(server, "/halftone/cat?sites=20", 304, "--header", "If-None-Match: " + tag)
                see(server, "/halftone/cat?sites=0", 400)
                see(server, "/halftone/cat?sites=20", 406, "--header", "Accept: text/html")
                see(server, "/halftone/cat?sites=101", 413)
                see(server, "/halftone/text", 415)
                see(server, "/halftone/white?sites=20", 422)
            with Server(f"--pictures={folder}", environment={"CCDT_SIGNING_KEY": 32 * "k"}) as server:
                see(server, "/halftone/cat?sites=20", 403)

    def see_streams(self):
        with Server("--max-streams=1", "--workers=1") as server:
            job = post_json(server, "/sample", ENDLESS, *LATER).headers["location"]
            with subprocess.Popen(["curl", "--silent", "--no-buffer", "--max-time", str(PATIENCE),
                                   server.url(job + "/events")],
                                  stdout=subprocess.PIPE) as stream:
                read_line(stream, "the first event of the job")
                self.see("/jobs/{id}/events", "get", ask(server, job + "/events"), 503)
                ask(server, job, "--request", "DELETE")

    def test_in_the_source_are_documented(self):
        source = "".join(file.read_text() for file in SERVER.rglob("*.cpp"))
        errors = set(re.findall(r"(?:\b(?:problem|busy)\(|\bProblem\{|\? )([45]\d\d)\b", source))
        errors |= set(re.findall(r"return ([45]\d\d);", (ROOT / "api" / "problem.cpp").read_text()))
        self.assertGreater(len(errors), 15)
        documented = {status for _, _, operation in operations() for status in operation["responses"]}
        for status in ("4XX", "5XX"):
            described = resolve(next(operation["responses"][status] for _, _, operation in operations()))
            documented |= set(re.findall(r"\b[45]\d\d\b", described["description"]))
        self.assertEqual(errors - documented, set())
        self.assertEqual({status for status in documented if re.fullmatch(r"[45]\d\d", status)} - errors, set())

    def test_in_the_readme_are_documented(self):
        rows = re.findall(r"^\| (\d{3}(?:, \d{3})*) \| ", (ROOT / "api" / "README.md").read_text(), re.MULTILINE)
        listed = {status for row in rows for status in re.findall(r"\b[2345]\d\d\b", row)}
        self.assertGreater(len(listed), 15)
        text = json.dumps([operation["responses"] for _, _, operation in operations()])
        for others in ("OtherOfClient", "OtherOfServer"):
            text += DOCUMENT["components"]["responses"][others]["description"]
        self.assertEqual({status for status in listed if status not in text}, set())


if __name__ == "__main__":
    unittest.main(verbosity=2)
