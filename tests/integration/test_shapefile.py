# SPDX-License-Identifier: GPL-3.0-or-later
"""POST /sample with zipped shapefiles, compared with the same maps as GeoJSON."""

import io
import json
import struct
import tempfile
import unittest
import zipfile

from harness import ServerCase, polygon

POLYGON = 5


def record_of(rings):
    if not rings:
        return struct.pack("<i", 0)
    corners = [corner for ring in rings for corner in ring]
    starts = [sum(map(len, rings[:i])) for i in range(len(rings))]
    bounds = [pick(corner[axis] for corner in corners) for pick in (min, max) for axis in (0, 1)]
    return (struct.pack("<i4dii", POLYGON, *bounds, len(rings), len(corners)) + struct.pack(f"<{len(starts)}i", *starts)
            + b"".join(struct.pack("<dd", *corner) for corner in corners))


def shp_of(shapes):
    """Returns a .shp file with a record for each list of rings."""
    records = [record_of(rings) for rings in shapes]
    body = b"".join(struct.pack(">ii", number, len(record) // 2) + record
                    for number, record in enumerate(records, start=1))
    return (struct.pack(">i20xi", 9994, (100 + len(body)) // 2) + struct.pack("<ii", 1000, POLYGON)).ljust(100, b"\0") + body


def table_of(columns):
    """Returns a .dbf file. Each column has a type, a width, and the values of all records as bytes."""
    rows = list(zip(*[values for _, _, values in columns.values()], strict=True))
    widths = [width for _, width, _ in columns.values()]
    fields = b"".join(struct.pack("<11sc4xBB14x", name.encode(), kind.encode(), width, 0)
                      for name, (kind, width, _) in columns.items())
    head = struct.pack("<4BIHH20x", 3, 124, 1, 1, len(rows), 32 + len(fields) + 1, 1 + sum(widths))
    body = b"".join(b" " + b"".join(value.ljust(width) for value, width in zip(row, widths, strict=True)) for row in rows)
    return head + fields + b"\r" + body + b"\x1a"


def zip_of(files, compression=zipfile.ZIP_DEFLATED):
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", compression) as made:
        for name, content in files.items():
            made.writestr(name, content)
    return archive.getvalue()


def signed_area(ring):
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(ring, ring[1:] + ring[:1]))


def oriented(ring, clockwise):
    return ring if (signed_area(ring) < 0) == clockwise else ring[::-1]


def parts_of(name):
    """Returns the polygons of a file, with rings oriented as in shapefiles: outer ones clockwise."""
    given = polygon(f"{name}.geojson")
    given = given.get("geometry", given)
    parts = [given["coordinates"]] if given["type"] == "Polygon" else given["coordinates"]
    return [[oriented(ring, number == 0) for number, ring in enumerate(part)] for part in parts]


MAPS = [parts_of(name) for name in ("South-Africa-50m", "Italy-110m", "Switzerland-10m")]
PEOPLE = [60.605, 59.07, 8.7]
GEOJSON = json.dumps({"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {"people": people}, "geometry": {"type": "MultiPolygon", "coordinates": parts}}
    for parts, people in zip(MAPS, PEOPLE, strict=True)]}).encode()
SHP = shp_of([[ring for part in parts for ring in part] for parts in MAPS])
SHAPEFILE = zip_of({"maps/three.shp": SHP, "maps/three.dbf": table_of({"people": ("N", 12, [f"{people:12.3f}".encode() for people in PEOPLE])}), "maps/three.prj": "GEOGCS[]"})


class Shapefiles(ServerCase):
    def post(self, query, body, kind="application/zip"):
        return self.ask(f"/sample?{query}", "-H", f"Content-Type: {kind}", data=body)

    def test_points_equal_those_of_the_same_map_as_geojson(self):
        for query in ("sites=300&format=csv", "sites=200&coordinates=lonlat&format=npy",
                      "sites=people&per=0.5&coordinates=lonlat&properties=people&format=geojson"):
            with self.subTest(query):
                expected = self.post(query, GEOJSON, "application/geo+json")
                self.assertEqual(expected.status, 200, expected)
                for kind in ("application/zip", "application/x-zip-compressed", "application/octet-stream", ""):
                    self.assertEqual(self.post(query, SHAPEFILE, kind).body, expected.body, kind)

    def test_forms(self):
        expected = self.post("sites=50&format=csv&coordinates=lonlat", GEOJSON, "application/geo+json").body
        with tempfile.NamedTemporaryFile() as archive, tempfile.NamedTemporaryFile() as document:
            archive.write(SHAPEFILE)
            document.write(GEOJSON)
            archive.flush()
            document.flush()
            for part in (f"map=@{archive.name}", f"file=@{archive.name}", f"map=@{document.name}"):
                answer = self.ask("/sample?coordinates=lonlat", "-F", "sites=50", "-F", part, "-F", "format=csv")
                self.assertEqual(answer.body, expected, part)
            self.assert_problem(self.ask("/sample", "-F", "sites=50"), 400, "map")

    def test_jobs(self):
        query = "sites=50&format=csv"
        answer = self.ask(f"/sample?{query}", "-H", "Content-Type: application/zip", "-H", "Prefer: respond-async",
                          data=SHAPEFILE)
        self.assertEqual(answer.status, 202, answer)
        self.assertEqual(self.ask(answer.headers["location"] + "/events").status, 200)
        self.assertEqual(self.ask(answer.headers["location"] + "/result").body,
                         self.post(query, GEOJSON, "application/geo+json").body)

    def test_several_shapefiles(self):
        archive = zip_of({"a.shp": SHP, "folder/b.SHP": shp_of([MAPS[1][0]])})
        self.assert_problem(self.post("sites=9", archive), 422, "a, folder/b", "object")
        self.assertEqual(self.post("sites=9&object=b&format=csv", archive).status, 200)
        self.assert_problem(self.post("sites=9&object=c", archive), 422, "a, folder/b")
        self.assert_problem(self.post("sites=9&object=b&object=b", archive), 400, "twice")

    def test_hostile_archives(self):
        bomb = zip_of({"a.shp": bytes(200 << 20)})
        self.assertLess(len(bomb), 1 << 20)
        self.assert_problem(self.post("sites=9", bomb), 413, "max-body")
        damaged = bytearray(zip_of({"a.shp": SHP}, zipfile.ZIP_STORED))
        damaged[300] ^= 1
        self.assert_problem(self.post("sites=9", bytes(damaged)), 422, "CRC")
        self.assert_problem(self.post("sites=9", SHAPEFILE[:-30]), 422, "truncated")
        self.assert_problem(self.post("sites=9", zip_of({str(i): "" for i in range(1001)})), 413, "1000")
        self.assert_problem(self.post("sites=9", b"{}"), 422, "zip")
        self.assert_problem(self.ask("/analyze", "-H", "Content-Type: application/zip", data=SHAPEFILE), 415)

    def test_texts_are_needed_only_if_they_are_used(self):
        table = table_of({"name": ("C", 9, [b"stra\xdfe", b"b", b"c"]), "n": ("N", 4, [b"5", b"6", b"7"])})
        archive = zip_of({"a.shp": SHP, "a.dbf": table})
        for query, points in (("sites=9", 9), ("sites=n", 18), ("sites=n&properties=n", 18)):
            self.assertEqual(len(self.post(query + "&coordinates=lonlat", archive).json()["points"]), points, query)
        for query, pointer in (("sites=9&properties=name", "properties"), ("sites=9&properties=*", "properties"),
                               ("sites=name", "sites"), ("classes=n,name", "classes")):
            problem = self.assert_problem(self.post(query, archive), 422, "name", "names no encoding", ".cpg")
            self.assertEqual(problem["errors"][0]["pointer"], pointer)
        self.assert_problem(self.post("sites=m", archive), 400, "no feature has the property 'm'", "n")

    def test_encodings(self):
        for text, cpg in (("\u6771\u4eac", "shift_jis"), ("\u5317\u4eac", "gbk"), ("\u53f0\u5317", "big5"),
                          ("\uc11c\uc6b8", "euc_kr"), ("\u0141\u00f3d\u017a", "cp1250"), ("\u041c\u043e\u0441", "cp1251"),
                          ("K\u00f6ln", "cp850"), ("K\u00f6ln", "iso-8859-1"), ("\u0141\u00f3d\u017a", "utf-8")):
            with self.subTest(cpg):
                archive = zip_of({"a.shp": SHP, "a.cpg": cpg.upper(),
                                  "a.dbf": table_of({"name": ("C", 12, [text.encode(cpg)] * 3)})})
                answer = self.post("sites=9&coordinates=lonlat&properties=name", archive)
                self.assertEqual(answer.status, 200, answer)
                self.assertEqual(answer.json()["features"][0]["properties"], {"name": text})

    def test_reference_systems(self):
        degrees = 'GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984"],UNIT["Degree",0.0174532925199433]]'
        metres = f'PROJCS["Local_Grid",{degrees},UNIT["Meter",1.0]]'
        for prj, query, words in ((degrees, "", "coordinates=lonlat"), (degrees, "&coordinates=lonlat", ""),
                                  (metres, "", ""), (metres, "&coordinates=lonlat", "Local_Grid")):
            with self.subTest(prj=prj[:6], query=query):
                answer = self.post("sites=9" + query, zip_of({"a.shp": SHP, "a.prj": prj}))
                self.assertEqual(answer.status, 200, answer)
                found = [each["detail"] for each in answer.json().get("warnings", [])]
                self.assertEqual(len(found), bool(words), found)
                self.assertIn(words, "".join(found))

    def test_invalid_options_are_reported_like_those_with_geojson(self):
        self.assert_problem(self.post("sites=9&colour=red", SHAPEFILE), 400, "colour")
        self.assert_problem(self.post("", SHAPEFILE), 400, "sites")


if __name__ == "__main__":
    unittest.main()
