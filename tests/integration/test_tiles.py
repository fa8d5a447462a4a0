# SPDX-License-Identifier: GPL-3.0-or-later
"""POST /sample with format=pmtiles, read by decoders that follow the specifications of PMTiles 3 and of vector tiles."""

import collections
import gzip
import json
import math
import struct
import unittest

from harness import ServerCase, post_json

PARTS = [([[5, 40], [9, 40], [9, 44], [5, 44]], 3000), ([[9, 40], [11, 40], [11, 44], [9, 44]], 12000)]
MAP = {"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {"a": count, "b": count // 3, "name": f"ü{count}", "dry": count < 5000},
     "geometry": {"type": "Polygon", "coordinates": [[*ring, ring[0]]]}} for ring, count in PARTS]}
REQUEST = {"geometry": MAP, "classes": ["a", "b"], "per": 2, "coordinates": "lonlat", "properties": ["name", "dry", "a"]}


def varint(data, at):
    value, shift = 0, 0
    while True:
        byte = data[at]
        value |= (byte & 127) << shift
        at, shift = at + 1, shift + 7
        if byte < 128:
            return value, at


def varints(data):
    values, at = [], 0
    while at < len(data):
        value, at = varint(data, at)
        values.append(value)
    return values


def fields(message):
    """Returns the numbers and the values of the fields of a message of Protocol Buffers."""
    found, at = [], 0
    while at < len(message):
        key, at = varint(message, at)
        if key & 7 == 0:
            value, at = varint(message, at)
        else:
            size, at = (8, at) if key & 7 == 1 else varint(message, at)
            value, at = message[at:at + size], at + size
        found.append((key >> 3, value))
    return found


def directory(data):
    numbers = varints(gzip.decompress(data))
    count, rest = numbers[0], numbers[1:]
    ids, runs, lengths, offsets = (rest[i * count:(i + 1) * count] for i in range(4))
    entries, tile, end = [], 0, 0
    for step, run, length, offset in zip(ids, runs, lengths, offsets, strict=True):
        tile += step
        start = end if offset == 0 else offset - 1
        entries.append((tile, run, start, length))
        end = start + length
    return entries


def place_of(number):
    """Returns the zoom, the column and the row of a tile from its number."""
    zoom = 0
    while number >= 4 ** zoom:
        number -= 4 ** zoom
        zoom += 1
    x = y = 0
    side = 1
    while side < 2 ** zoom:
        right = 1 & (number // 2)
        low = 1 & (number ^ right)
        if low == 0:
            if right == 1:
                x, y = side - 1 - x, side - 1 - y
            x, y = y, x
        x, y, number, side = x + side * right, y + side * low, number // 4, side * 2
    return zoom, x, y


class Archive:
    """The tiles of an archive: for each zoom, the position of each dot in the world, and its attributes, by id."""

    def __init__(self, data):
        assert data[:8] == b"PMTiles\3"
        self.numbers = struct.unpack_from("<11Q", data, 8)
        self.flags = tuple(data[96:102])
        self.bounds = [degrees / 1e7 for degrees in struct.unpack_from("<4i", data, 102)]
        root, root_size, about, about_size, leaves, _, tiles, size = self.numbers[:8]
        assert tiles + size == len(data) and root + root_size <= 16_384
        self.about = json.loads(gzip.decompress(data[about:about + about_size]))
        entries = directory(data[root:root + root_size])
        if entries[0][1] == 0:  # of other directories
            entries = [each for _, _, start, length in entries
                       for each in directory(data[leaves + start:leaves + start + length])]
        self.ids = [entry[0] for entry in entries]
        self.dots = collections.defaultdict(dict)
        self.most = 0
        for tile, run, start, length in entries:
            assert run == 1
            self.read(place_of(tile), gzip.decompress(data[tiles + start:tiles + start + length]))

    def read(self, place, tile):
        zoom, column, row = place
        (_, layer), = fields(tile)
        layer = fields(layer)
        keys = [value.decode() for number, value in layer if number == 3]
        values = [self.value(*fields(value)[0]) for number, value in layer if number == 4]
        assert dict(layer)[15] == 2 and dict(layer)[5] == 4096 and dict(layer)[1] == b"dots"
        features = [dict(fields(value)) for number, value in layer if number == 2]
        self.most = max(self.most, len(features))
        for feature in features:
            move, x, y = varints(feature[4])
            assert feature[3] == 1 and move == 9 and x % 2 == y % 2 == 0
            tags = varints(feature.get(2, b""))
            attributes = {keys[key]: values[value] for key, value in zip(tags[::2], tags[1::2], strict=True)}
            assert feature[1] not in self.dots[zoom]
            self.dots[zoom][feature[1]] = ((column + x / 8192) / 2 ** zoom, (row + y / 8192) / 2 ** zoom, attributes)

    @staticmethod
    def value(number, value):
        return {1: lambda: value.decode(), 3: lambda: struct.unpack("<d", value)[0], 7: lambda: bool(value)}[number]()


def on_map(longitude, latitude):
    return longitude / 360 + 0.5, 0.5 - math.log(math.tan(math.pi / 4 + math.radians(latitude) / 2)) / (2 * math.pi)


class Tiles(ServerCase):

    def archive(self, **options):
        answer = post_json(self.server, "/sample", {**REQUEST, "format": "pmtiles", **options})
        self.assertEqual((answer.status, answer.type), (200, "application/vnd.pmtiles"), answer)
        return Archive(answer.body)

    def test_every_zoom_is_nested_and_has_the_share_of_each_class(self):
        archive = self.archive(dots_per_tile=300)
        last = max(archive.dots)
        self.assertEqual(archive.flags, (1, 2, 2, 1, 0, last))
        self.assertEqual(archive.ids, sorted(archive.ids))
        self.assertEqual(archive.numbers[8:], (len(archive.ids),) * 3)
        self.assertLessEqual(archive.most, 300)
        counts = {"a": 7500, "b": 2500}
        for zoom, dots in archive.dots.items():
            for name, count in counts.items():
                shown = sum(attributes["class"] == name for _, _, attributes in dots.values())
                self.assertEqual(shown, math.floor(count / 4 ** (last - zoom) + 0.5), (zoom, name))
            after = archive.dots.get(zoom + 1, dots)
            for number, (x, y, attributes) in dots.items():
                self.assertEqual(after[number][2], attributes)
                self.assertLess(max(abs(x - after[number][0]), abs(y - after[number][1])) * 2 ** zoom, 1 / 4096)

    def test_dots_are_where_the_points_are(self):
        archive = self.archive(maxzoom=9, minzoom=9)
        points = post_json(self.server, "/sample", {**REQUEST, "order": "progressive"}).json()
        places = [on_map(*point) for point in points["points"]]
        expected = sorted((int(x * 512 * 4096), int(y * 512 * 4096)) for x, y in places)
        self.assertEqual(sorted((round(x * 512 * 4096), round(y * 512 * 4096)) for x, y, _ in archive.dots[9].values()),
                         expected)
        self.assertEqual(archive.bounds, [round(degrees, 7) for degrees in (
            *map(min, zip(*points["points"])), *map(max, zip(*points["points"])))])

    def test_dots_carry_properties(self):
        archive = self.archive(maxzoom=4)
        self.assertEqual(archive.about["vector_layers"][0]["fields"],
                         {"class": "String", "name": "Mixed", "dry": "Mixed", "a": "Mixed"})
        found = {json.dumps(attributes, ensure_ascii=False, sort_keys=True)
                 for _, _, attributes in archive.dots[4].values()}
        self.assertEqual(found, {json.dumps({"class": name, "name": f"ü{count}", "dry": count < 5000, "a": float(count)},
                                            ensure_ascii=False, sort_keys=True)
                                 for _, count in PARTS for name in "ab"})

    def test_many_tiles_have_several_directories(self):
        archive = self.archive(minzoom=14, maxzoom=14)
        self.assertGreater(len(archive.ids), 8000)
        self.assertEqual(len(archive.dots[14]), 10000)

    def test_one_dot_is_a_map(self):
        ring = [[10, 50], [11, 50], [11, 51]]
        answer = post_json(self.server, "/sample", {"polygon": ring, "sites": 1, "coordinates": "lonlat",
                                                    "format": "pmtiles"})
        self.assertEqual([*map(len, Archive(answer.body).dots.values())], [1])

    def test_names_what_is_missing(self):
        ring = [[10, 50], [11, 50], [11, 51]]
        polar = [[10, 80], [20, 80], [20, 89], [10, 89]]
        for members, status, field, words in (
                ({"polygon": ring}, 400, "/coordinates", "lonlat"),
                ({"polygon": ring, "coordinates": "lonlat", "order": "path"}, 400, "/order", "progressive"),
                ({"polygon": ring, "coordinates": "lonlat", "minzoom": 5, "maxzoom": 4}, 400, "/maxzoom", "minzoom"),
                ({"polygon": ring, "coordinates": "lonlat", "maxzoom": 23}, 400, "/maxzoom", "22"),
                ({"polygon": ring, "coordinates": "lonlat", "maxzoom": 4, "dots_per_tile": 9}, 400, "/dots_per_tile",
                 "only one"),
                ({"polygon": ring, "format": "csv", "maxzoom": 4}, 400, "/maxzoom", "pmtiles"),
                ({"polygon": polar, "coordinates": "lonlat"}, 422, "/format", "85.05")):
            answer = post_json(self.server, "/sample", {"sites": 100, "format": "pmtiles", **members})
            with self.subTest(members):
                self.assertEqual(answer.status, status, answer)
                self.assertEqual(answer.json()["errors"][0]["pointer"], field)
                self.assertIn(words, answer.json()["errors"][0]["detail"])


class TilesByHttp(ServerCase):
    """Tiles of a job, its TileJSON, and parts of its result."""

    flags = ("--cors-origin=*",)

    def job(self, **options):
        """Returns the id and the result of a finished job."""
        submitted = post_json(self.server, "/sample", {**REQUEST, "format": "pmtiles", **options},
                              "--header", "Prefer: respond-async")
        self.assertEqual(submitted.status, 202, submitted)
        location = submitted.headers["location"]
        self.ask(location + "/events")  # ends with the job
        result = self.ask(location + "/result")
        self.assertEqual(result.status, 200, result)
        return location.removeprefix("/jobs/"), result

    def check_tiles(self, job, data, most):
        """Compares tiles with those of the archive."""
        archive = Archive(data)
        step = max(1, len(archive.ids) // most)
        for tile in archive.ids[::step]:
            zoom, column, row = place_of(tile)
            answer = self.ask(f"/tiles/{job}/{zoom}/{column}/{row}.mvt")
            self.assertEqual((answer.status, answer.type), (200, "application/vnd.mapbox-vector-tile"), answer)
            alone = Archive.__new__(Archive)
            alone.dots, alone.most = collections.defaultdict(dict), 0
            alone.read((zoom, column, row), answer.body)
            self.assertLessEqual(alone.dots[zoom].items(), archive.dots[zoom].items())
            self.assertTrue(alone.dots[zoom])

    def test_are_those_of_the_archive(self):
        job, result = self.job(dots_per_tile=300)
        self.check_tiles(job, result.body, 60)

    def test_of_large_archives_are_found_by_several_directories(self):
        job, result = self.job(minzoom=13, maxzoom=14, per=0.4)
        self.assertGreater(len(result.body), 4 << 20)
        self.check_tiles(job, result.body, 40)

    def test_are_compressed_on_request_and_never_change(self):
        job, _ = self.job(maxzoom=4)
        path = f"/tiles/{job}/0/0/0.mvt"
        plain = self.ask(path)
        packed = self.ask(path, "--header", "Accept-Encoding: gzip")
        self.assertEqual((packed.headers["content-encoding"], packed.headers["etag"]), ("gzip", f'"{job}-0-0-0-gzip"'))
        self.assertNotIn("content-encoding", plain.headers)
        self.assertEqual(gzip.decompress(packed.body), plain.body)
        self.assertEqual(packed.headers["access-control-allow-origin"], "*")
        for answer in (plain, packed):
            self.assertEqual(answer.headers["vary"], "Accept-Encoding")
            again = self.ask(path, "--header", "If-None-Match: " + answer.headers["etag"])
            self.assertEqual((again.status, again.headers["etag"]), (304, answer.headers["etag"]))

    def test_are_absent_where_there_are_no_dots(self):
        job, _ = self.job(minzoom=2, maxzoom=4)
        self.assertEqual(self.ask(f"/tiles/{job}/4/0/0.mvt").status, 204)
        for place in ("1/0/0", "5/0/0", "4/16/0", "4/0/16", "4/-1/0", "4/0/x", "99/0/0"):
            self.assertEqual(self.ask(f"/tiles/{job}/{place}.mvt").status, 404, place)
        for path in (f"/tiles/{job}/4/0/0", f"/tiles/{job}/4/0.mvt", "/tiles/none/4/0/0.mvt", "/tiles/none.json"):
            self.assertEqual(self.ask(path).status, 404, path)
        other, _ = self.job(format="csv")
        answer = self.ask(f"/tiles/{other}.json")
        self.assertEqual(answer.status, 404)
        self.assertIn("pmtiles", answer.json()["detail"])

    def test_are_described_by_tilejson(self):
        job, result = self.job(minzoom=1, maxzoom=4)
        about = self.ask(f"/tiles/{job}.json").json()
        self.assertEqual(about["tilejson"], "3.0.0")
        self.assertEqual((about["minzoom"], about["maxzoom"]), (1, 4))
        self.assertEqual(about["bounds"], Archive(result.body).bounds)
        self.assertEqual(about["vector_layers"], Archive(result.body).about["vector_layers"])
        self.assertEqual(about["tiles"], [self.server.url(f"/tiles/{job}") + "/{z}/{x}/{y}.mvt"])
        secure = self.ask(f"/tiles/{job}.json", "--header", "X-Forwarded-Proto: https").json()
        self.assertTrue(secure["tiles"][0].startswith("https://"))

    def test_vanish_with_the_job(self):
        job, _ = self.job(maxzoom=4)
        self.assertEqual(self.ask(f"/tiles/{job}/0/0/0.mvt").status, 200)
        self.assertEqual(self.ask(f"/jobs/{job}", "--request", "DELETE").status, 204)
        self.assertEqual(self.ask(f"/tiles/{job}/0/0/0.mvt").status, 404)

    def test_parts_of_results(self):
        for options in ({"maxzoom": 4}, {"minzoom": 13, "maxzoom": 14, "per": 0.4}):
            job, result = self.job(**options)
            size = len(result.body)
            self.assertEqual(result.headers["accept-ranges"], "bytes")
            for asked, first, last in (("0-126", 0, 126), ("5-", 5, size - 1), ("-9", size - 9, size - 1),
                                       (f"{size - 3}-{size + 9}", size - 3, size - 1), (f"-{size + 1}", 0, size - 1),
                                       (f"{size // 2}-{size // 2 + 2_000_000}", size // 2,
                                        min(size // 2 + 2_000_000, size - 1))):
                with self.subTest(asked):
                    answer = self.ask(f"/jobs/{job}/result", "--header", "Range: bytes=" + asked)
                    self.assertEqual((answer.status, answer.headers["content-range"]),
                                     (206, f"bytes {first}-{last}/{size}"), answer)
                    self.assertEqual(answer.body, result.body[first:last + 1])
            for asked in (f"bytes={size}-", "bytes=-0"):
                answer = self.ask(f"/jobs/{job}/result", "--header", "Range: " + asked)
                self.assertEqual((answer.status, answer.headers["content-range"]), (416, f"bytes */{size}"), asked)
            for asked in ("bytes=2-1", "bytes=0-1,3-4", "bytes=x-", "lines=0-1", "bytes=-"):
                self.assertEqual(self.ask(f"/jobs/{job}/result", "--header", "Range: " + asked).status, 200, asked)
            for tag, status in ((f'"{job}"', 206), ('"other"', 200)):
                answer = self.ask(f"/jobs/{job}/result", "--header", "Range: bytes=0-1", "--header", "If-Range: " + tag)
                self.assertEqual(answer.status, status)

    def test_parts_of_texts_are_not_compressed(self):
        job, result = self.job(format="csv")
        answer = self.ask(f"/jobs/{job}/result", "--header", "Range: bytes=0-4999", "--header", "Accept-Encoding: gzip")
        self.assertEqual((answer.status, answer.body), (206, result.body[:5000]))
        self.assertEqual(answer.headers["etag"], result.headers["etag"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
