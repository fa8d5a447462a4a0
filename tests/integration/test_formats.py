"""What answers can be made as, read back by the programs that they are made for."""

import csv
import io
import unittest

import numpy
import shapely.geometry

from harness import PICTURES, ServerCase, polygon, post_json

CAMERA = (PICTURES / "camera.png").read_bytes()
ITALY = {"sites": 500, "seed": 4, "geometry": polygon("Italy-110m.geojson")}


def by_csv(file):
    rows = list(csv.reader(io.StringIO(file.decode("ascii"), newline="")))
    return rows[0], numpy.array(rows[1:], dtype=float)


def by_numpy(file):
    return numpy.load(io.BytesIO(file), allow_pickle=False)


class FormatCase(ServerCase):
    def made(self, format_, **body):
        answer = post_json(self.server, "/sample", {**body, "format": format_})
        self.assertEqual(answer.status, 200, answer)
        return answer

    def dots(self, query, *arguments):
        answer = self.ask("/halftone" + query, *arguments, data=CAMERA)
        self.assertEqual(answer.status, 200, answer)
        return answer


class Points(FormatCase):
    """Every format holds the same doubles."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.expected = numpy.array(post_json(cls.server, "/sample", ITALY).json()["points"])

    def test_csv(self):
        answer = self.made("csv", **ITALY)
        self.assertEqual(answer.type, "text/csv; header=present")
        header, points = by_csv(answer.body)
        self.assertEqual(header, ["x", "y"])
        numpy.testing.assert_array_equal(points, self.expected)
        self.assertEqual(answer.body.count(b"\r\n"), 501)
        loaded = numpy.loadtxt(io.BytesIO(answer.body), delimiter=",", skiprows=1)
        numpy.testing.assert_array_equal(loaded, self.expected)

    def test_npy(self):
        answer = self.made("npy", **ITALY)
        self.assertEqual(answer.type, "application/x-npy")
        points = by_numpy(answer.body)
        self.assertEqual((points.dtype, points.flags.c_contiguous), (numpy.dtype("<f8"), True))
        numpy.testing.assert_array_equal(points, self.expected)
        # The same file to the byte, but for how many blanks are added.
        written = io.BytesIO()
        numpy.save(written, points)
        self.assertEqual(written.getvalue().replace(b" ", b"")[10:], answer.body.replace(b" ", b"")[10:])

    def test_geojson(self):
        answer = self.made("geojson", **ITALY)
        self.assertEqual(answer.type, "application/geo+json")
        feature = answer.json()
        read = shapely.geometry.shape(feature["geometry"])
        self.assertEqual((feature["type"], read.geom_type), ("Feature", "MultiPoint"))
        numpy.testing.assert_array_equal([(p.x, p.y) for p in read.geoms], self.expected)
        self.assertTrue(shapely.geometry.shape(ITALY["geometry"]).contains(read))
        properties = feature["properties"]
        self.assertEqual((properties["sites"], properties["seed"], properties["method"]), (500, 4, "ccdt"))
        self.assertEqual(self.made("geojson", **ITALY).body, answer.body)

    def test_one_point(self):
        one = {"sites": 1, "domain": {"type": "rectangle", "width": 1, "height": 1}}
        self.assertEqual(by_csv(self.made("csv", **one).body)[1].shape, (1, 2))
        self.assertEqual(by_numpy(self.made("npy", **one).body).shape, (1, 2))
        self.assertEqual(len(self.made("geojson", **one).json()["geometry"]["coordinates"]), 1)

    def test_many_points(self):
        many = {"sites": 200_000, "method": "random", "domain": {"type": "torus", "width": 1, "height": 1}}
        expected = numpy.array(post_json(self.server, "/sample", many).json()["points"])
        numpy.testing.assert_array_equal(by_numpy(self.made("npy", **many).body), expected)
        numpy.testing.assert_array_equal(by_csv(self.made("csv", **many).body)[1], expected)

    def test_halftone(self):
        expected = numpy.array(self.dots("?sites=700&format=json").json()["points"])
        table = self.dots("?sites=700&format=csv")
        self.assertEqual(table.type, "text/csv; header=present")
        numpy.testing.assert_array_equal(by_csv(table.body)[1], expected)
        array = self.dots("?sites=700&format=npy")
        self.assertEqual(array.type, "application/x-npy")
        numpy.testing.assert_array_equal(by_numpy(array.body), expected)


class Accepted(FormatCase):
    """Accept chooses where `format` does not."""

    def test_of_points(self):
        body = {"sites": 5, "domain": {"type": "rectangle", "width": 1, "height": 1}}
        for accept, type_ in (("text/csv", "text/csv; header=present"),
                              ("application/json;q=0.5, application/geo+json", "application/geo+json"),
                              ("application/x-npy, */*;q=0.1", "application/x-npy"),
                              ("application/json;q=0, application/*", "application/geo+json"),
                              ("*/*", "application/json"), ("", "application/json")):
            with self.subTest(accept=accept):
                answer = post_json(self.server, "/sample", body, "--header", "Accept: " + accept)
                self.assertEqual((answer.status, answer.type), (200, type_))
                self.assertEqual(answer.headers["vary"], "Accept")

    def test_of_a_halftone(self):
        for accept, type_ in (("image/*", "image/png"), ("text/csv;q=0.2, application/x-npy;q=0.3", "application/x-npy"),
                              ("*/*", "image/png")):
            with self.subTest(accept=accept):
                answer = self.dots("?sites=5", "--header", "Accept: " + accept)
                self.assertEqual((answer.type, answer.headers["vary"]), (type_, "Accept"))

    def test_format_wins(self):
        body = {"sites": 5, "domain": {"type": "rectangle", "width": 1, "height": 1}, "format": "csv"}
        answer = post_json(self.server, "/sample", body, "--header", "Accept: text/html")
        self.assertEqual(answer.type, "text/csv; header=present")


if __name__ == "__main__":
    unittest.main(verbosity=2)
