# SPDX-License-Identifier: GPL-3.0-or-later
"""The pages of the documentation: links, headings, pictures. CCDT_SITE is the folder of the pages."""

import html.parser
import os
import pathlib
import re
import shlex
import unittest
import urllib.parse

import numpy
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SITE = pathlib.Path(os.environ["CCDT_SITE"])
MAX_MEAN_BYTES = 21_000  # of a page with its pictures; a new header adds a page


class Page(html.parser.HTMLParser):
    """The parts of a page that the tests examine."""

    def __init__(self, path):
        super().__init__()
        self.path = path
        self.text = path.read_text()
        self.anchors, self.links, self.sources, self.headings, self.images, self.tags = set(), [], [], [], [], []
        self.feed(self.text)

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.tags.append((tag, values))
        self.anchors |= {values[name] for name in ("id", "name") if name in values}
        if "href" in values:
            (self.links if tag == "a" else self.sources).append(values["href"])
        if "src" in values:
            self.sources.append(values["src"])
        if re.fullmatch("h[1-6]", tag):
            self.headings.append(int(tag[1]))
        if tag == "img":
            self.images.append(values)


PAGES = {path.name: Page(path) for path in sorted(SITE.glob("*.html"))}
FILES = {path.relative_to(SITE).as_posix() for path in SITE.rglob("*") if path.is_file()}


class Pages(unittest.TestCase):
    def test_link_to_existing_places(self):
        for page in PAGES.values():
            for link in {*page.links, *page.sources}:
                address = urllib.parse.urlsplit(link)
                if address.scheme in ("http", "https", "mailto"):
                    continue
                name, place = urllib.parse.unquote(address.path), urllib.parse.unquote(address.fragment)
                with self.subTest(page=page.path.name, link=link):
                    self.assertIn(name or page.path.name, FILES)
                    if place:
                        self.assertIn(place, PAGES[name or page.path.name].anchors)

    def test_load_nothing_from_other_hosts(self):
        for page in PAGES.values():
            self.assertEqual([source for source in page.sources if ":" in source], [], page.path.name)

    def test_satisfy_the_content_security_policy(self):
        for page in PAGES.values():
            inline = [(tag, values) for tag, values in page.tags
                      if tag in ("script", "style", "iframe") or any(name == "style" or name.startswith("on")
                                                                      for name in values)]
            self.assertEqual(inline, [], page.path.name)

    def test_have_headings_in_order(self):
        for page in PAGES.values():
            with self.subTest(page=page.path.name):
                self.assertEqual(page.headings.count(1), 1)
                self.assertEqual(page.headings[0], 1)
                steps = [after - before for before, after in zip(page.headings, page.headings[1:])]
                self.assertLessEqual(max(steps, default=0), 1)

    def test_describe_their_pictures(self):
        for page in PAGES.values():
            for image in page.images:
                with self.subTest(page=page.path.name, image=image):
                    self.assertTrue(image["src"] == "icon.svg" or image["alt"])
                    self.assertTrue(image["width"].isdecimal() and image["height"].isdecimal())
                    self.assertTrue(image["src"] == "icon.svg" or image["loading"] == "lazy")

    def test_are_small(self):
        self.assertLess(sum((SITE / name).stat().st_size for name in FILES) / len(PAGES), MAX_MEAN_BYTES)

    def test_contain_no_path_of_this_machine(self):
        for page in PAGES.values():
            self.assertNotIn(str(ROOT), page.text, page.path.name)
            self.assertNotIn("/tmp/", page.text.replace("/tmp/ccdt", ""), page.path.name)

    def test_include_all_readmes(self):
        readmes = [path for top in ("core", "api", "server", "docker") for path in (ROOT / top).rglob("README.md")]
        readmes += [ROOT / "README.md", ROOT / "tests" / "README.md", ROOT / "CHANGELOG.md"]
        readmes += (ROOT / "tests" / "bench" / "results").glob("*.md")
        expected = [re.search("^# (.*)$", path.read_text(), re.MULTILINE)[1].replace("`", "") for path in readmes]
        shown = [re.sub("<[^>]*>", "", re.search("<h1>(.*?)</h1>", page.text, re.DOTALL)[1]).strip()
                 for page in PAGES.values()]
        for title in expected:
            self.assertEqual(shown.count(title), expected.count(title), title)

    def test_list_readmes_in_the_order_in_which_one_learns(self):
        listed = re.findall("<small>(.*?)</small>", PAGES["reference.html"].text)
        learned = ["README.md", "api/README.md", "api/sample/README.md", "core/README.md", "core/ccdt/README.md",
                   "core/ccdt/polish/README.md", "server/README.md", "server/jobs/README.md", "tests/README.md",
                   "tests/bench/results/torus.md"]
        self.assertEqual([path for path in listed if path in learned], learned)

    def test_list_public_headers_first(self):
        titles = re.findall("<h([23])>(.*?)</h", PAGES["reference.html"].text)
        self.assertEqual(titles[:3], [("2", "Pages"), ("2", "Public headers"), ("3", "core/include/ccdt")])
        self.assertIn(("3", "api/include/ccdt"), titles[:titles.index(("2", "Internals"))])

    def test_list_all_headers(self):
        listed = PAGES["reference.html"].text
        for top in ("core", "api", "server"):
            for path in (ROOT / top).rglob("*.h"):
                self.assertIn(f">{path.name}</a>", listed)


class Gallery(unittest.TestCase):
    page = PAGES["gallery.html"]
    figures = re.findall(r"<figure.*?</figure>", page.text, re.DOTALL)

    def commands(self, figure):
        text = re.sub("<[^>]*>", "", re.search("<pre>(.*?)</pre>", figure, re.DOTALL)[1])
        return [shlex.split(line) for line in html.unescape(text).splitlines()]

    def test_shows_each_kind_of_picture(self):
        self.assertGreater(len(self.figures), 25)
        words = {word for figure in self.figures for command in self.commands(figure) for word in command}
        for word in ("halftone", "sample", "analyze", "ink", "paper", "cmyk", "--palette", "path", "spiral", "circles",
                     "camera.gcode", "texas.geojson", "lonlat", "spot.obj", "spectra6", "stealthy", "mask"):
            self.assertIn(word, words)

    def test_shows_what_the_commands_write(self):
        for figure in self.figures:
            *_, command = self.commands(figure)
            with self.subTest(command=command):
                self.assertEqual(command[0], "ccdt")
                stem = pathlib.Path(command[command.index("-o") + 1]).stem
                shown = re.findall('<img src="gallery/([^"]*)"', figure)
                self.assertEqual(pathlib.Path(shown[-1]).name.split(".")[0], stem)

    def test_pictures_are_not_empty(self):
        for figure in self.figures:
            name = re.findall('<img src="([^"]*)"', figure)[-1]
            with self.subTest(picture=name):
                path = SITE / name
                if path.suffix == ".svg":
                    self.assertGreater(len(re.findall("<(?:circle|ellipse)|[ML][-0-9.]", path.read_text())), 500)
                else:
                    values = numpy.asarray(Image.open(path).convert("L"), dtype=float)
                    self.assertGreater(values.std(), 20)

    def test_uses_listed_files_only(self):
        listed = set(re.findall('href="gallery/([^"]*)" download', self.page.text))
        for figure in self.figures:
            first = self.commands(figure)[0]
            taken = {word for word in first if re.search(r"\.(jpg|geojson|obj)$", word)}
            self.assertLessEqual(taken, listed, first)


if __name__ == "__main__":
    unittest.main(verbosity=2)
