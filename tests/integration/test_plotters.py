"""Drawings by pens, read as the programs that drive them do."""

import re
import unittest
from xml.etree import ElementTree

from harness import PICTURES, ServerCase, post_json

CHELSEA = (PICTURES / "chelsea.png").read_bytes()
SVG = "{http://www.w3.org/2000/svg}"
LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"


def pens_of_vpype(svg):
    """The strokes of each layer, by the numbers that vpype's `read` gives: a group at the top is a layer. Its number is
    the digits of its label or, where there are none, those of its id or, where there are none, its place from 1. 0 counts
    as 1. What is at the top without a group is in layer 1."""
    root = ElementTree.fromstring(svg)
    pens = {}
    for place, group in enumerate(root.findall(SVG + "g"), 1):
        digits = re.sub("[^0-9]", "", group.get(LABEL) or "") or re.sub("[^0-9]", "", group.get("id") or "")
        number = max(int(digits), 1) if digits else place
        strokes = " ".join(path.get("d") for path in group.iter(SVG + "path"))
        pens[number] = pens.get(number, 0) + strokes.count("M")
    for path in root.findall(SVG + "path"):
        pens[1] = pens.get(1, 0) + path.get("d").count("M")
    return pens


class PlotterCase(ServerCase):
    def assert_refused(self, *cases):
        """@param cases  (query, field, words of the message)"""
        for query, field, words in cases:
            with self.subTest(query=query):
                answer = self.ask("/halftone" + query, data=CHELSEA)
                self.assertIn(answer.status, (400, 422), answer)
                problem = answer.json()
                self.assertEqual(problem["errors"][0]["pointer"], field)
                self.assertIn(words, problem["detail"])


class Refusals(PlotterCase):
    """Errors name the option and its limit."""

    def test_of_drawings_without_a_width(self):
        self.assert_refused(("?format=svg&style=spiral", "width_mm", "style=spiral"))

    def test_of_pens(self):
        self.assert_refused(("?pen=0", "pen", "0.01"), ("?pen=1e308", "pen", "0.01"),
                            ("?format=svg&width_mm=9000&sites=1&style=spiral&pen=0.01", "pen", "turns"))


class Layers(ServerCase):
    """vpype finds one layer for each pen."""

    def check(self, svg, sites):
        pens = pens_of_vpype(svg)
        self.assertEqual(list(pens.items()), list(enumerate(sites, 1)))
        self.assertTrue(ElementTree.fromstring(svg).get("viewBox").startswith("0 0 "))

    def test_of_inks(self):
        for inks in ("color=cmyk", "color=rgb", "palette=%23ff0000,%2300ff00,%230000ff,%23000000",
                     "palette=%23ff0000,%23fe0000,%2378f480", "color=gray"):
            with self.subTest(inks=inks):
                query = f"?sites=900&{inks}&format="
                answer = self.halftone(CHELSEA, query + "json").json()
                sites = [ink["sites"] for ink in answer["inks"]] if "inks" in answer else [answer["sites"]]
                self.check(self.halftone(CHELSEA, query + "svg&style=stroke&width_mm=100").body, sites)

    def test_have_ids_of_their_own(self):
        for colours in ("color=gray", "color=cmyk"):
            root = ElementTree.fromstring(self.halftone(CHELSEA, f"?sites=700&{colours}&dots=both&format=svg").body)
            ids = [part.get("id") for part in root.iter() if part.get("id")]
            self.assertEqual(len(set(ids)), len(ids))
            self.assertEqual([group.get("id") for group in root.findall(SVG + "g")], ["layer1", "layer2", "layer3"])

    def test_of_classes(self):
        land = {"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {"pop2010": 40, "pop2020": 60}, "geometry":
             {"type": "Polygon", "coordinates": [[[x, 0], [x + 1, 0], [x + 1, 1], [x, 1], [x, 0]]]}} for x in range(3)]}
        for counts, sites in (({"classes": ["pop2010", "pop2020"]}, [120, 180]), ({"sites": "pop2020"}, [180])):
            body = {"geometry": land, **counts, "format": "svg", "style": "stroke", "width_mm": 100}
            answer = post_json(self.server, "/sample", body)
            self.assertEqual(answer.status, 200, answer)
            self.check(answer.body, sites)


if __name__ == "__main__":
    unittest.main()
