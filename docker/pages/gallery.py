# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery: pictures, each with the command that makes it. The commands are run as they are shown."""

import csv
import dataclasses
import functools
import html
import json
import math
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import urllib.request

import numpy
from PIL import Image

import pictures
import space
import surface

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SAMPLES = ROOT / "server" / "page" / "site" / "samples"
POLYGONS = ROOT / "tests" / "data" / "polygons"
MESH = ROOT / "tests" / "data" / "meshes" / "spot.obj"
INPUTS = (*(SAMPLES / name for name in ("astronaut.jpg", "camera.jpg", "cat.jpg", "texas.geojson")),
          POLYGONS / "Switzerland-10m.geojson", MESH)

# Time limit of a command, in seconds. The slowest one takes less than two.
PATIENCE = 60

UNIT_TORUS = '{"type":"torus","width":1,"height":1}'
TORUS_IN_SPACE = '{"type":"torus","width":1,"height":1,"depth":1}'


@dataclasses.dataclass
class Exhibit:
    """A picture of the gallery.

    `command` is one line or several. The last one writes the picture into the current folder. `before` is the name of a
    file to show beside the picture, and its description. `draw(file, programs)` replaces the picture by a drawing of
    it, and returns the path of the drawing. `enlarged` is the number of CSS pixels per pixel of the picture. If it is
    None, the picture is as wide as its column.
    """

    caption: str
    alt: str
    command: str
    before: tuple = ()
    draw: object = None
    enlarged: float | None = None
    is_wide: bool = False

    def output(self):
        words = shlex.split(self.command)
        return words[len(words) - words[::-1].index("-o")]


@dataclasses.dataclass
class Section:
    """A section of the gallery. If `is_small` is set, its columns are as narrow as the screen of a phone."""

    title: str
    text: str
    exhibits: tuple
    is_small: bool = False


def svg(width, height, parts):
    """Returns the text of a drawing on white paper."""
    return "\n".join([f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
                      f'viewBox="0 0 {width} {height}">', f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
                      *parts, "</svg>", ""])


def draw_gcode(file, _):
    """Draws the path of a plotter: strokes and touches of the pen in black, other moves in blue."""
    pen_is_down, place, moves, strokes, touches = False, (0.0, 0.0), [], [], []
    for line in file.read_text().splitlines():
        if line.startswith("M3"):
            pen_is_down = True
            touches.append(place)
        elif line.startswith("M5"):
            pen_is_down = False
        elif found := re.match(r"G[01] X([-\d.]+) Y([-\d.]+)", line):
            goal = (float(found[1]), float(found[2]))
            (strokes if pen_is_down else moves).append((place, goal))
            place = goal
    scale = 8
    height = math.ceil(max(y for _, y in touches) + 1) * scale
    width = math.ceil(max(x for x, _ in touches) + 1) * scale

    def lines(segments):
        return "".join(f"M{scale * ax:.1f} {height - scale * ay:.1f}L{scale * bx:.1f} {height - scale * by:.1f}"
                       for (ax, ay), (bx, by) in segments)

    dots = "".join(f"M{scale * x:.1f} {height - scale * y:.1f}h.01" for x, y in touches)
    drawing = file.with_suffix(".gcode.svg")
    drawing.write_text(svg(width, height, [
        '<g fill="none" stroke-linecap="round">', f'<path d="{lines(moves)}" stroke="#7fb2e5" stroke-width="1"/>',
        f'<path d="{lines(strokes)}{dots}" stroke="#000000" stroke-width="5"/>', "</g>"]))
    return drawing


def draw_globe(file, _):
    """Draws points given by longitude and latitude as seen from far above 10 degrees east, 35 degrees north."""
    radius, middle = 380, 400
    east, north = math.radians(10), math.radians(35)
    dots = []
    for row in csv.DictReader(file.read_text().splitlines()):
        longitude, latitude = math.radians(float(row["x"])) - east, math.radians(float(row["y"]))
        depth = (math.sin(north) * math.sin(latitude) + math.cos(north) * math.cos(latitude) * math.cos(longitude))
        if depth > 0:
            x = math.cos(latitude) * math.sin(longitude)
            y = math.cos(north) * math.sin(latitude) - math.sin(north) * math.cos(latitude) * math.cos(longitude)
            # Seen from the side, a disc on the globe is an ellipse. Its shorter axis points to the middle.
            turn = math.degrees(math.atan2(-y, x))
            dots.append(f'<ellipse rx="{4 * depth:.2f}" ry="4" transform="translate({middle + radius * x:.1f} '
                        f'{middle - radius * y:.1f}) rotate({turn:.0f})"/>')
    drawing = file.with_suffix(".globe.svg")
    drawing.write_text(svg(2 * middle, 2 * middle, [
        f'<circle cx="{middle}" cy="{middle}" r="{radius}" fill="#eef3f8" stroke="#8a8a84"/>',
        '<g fill="#14406f">', *dots, "</g>"]))
    return drawing


def draw_surface(file, _, first=None):
    """Draws points on the surface of the mesh or, if the answer contains a triangulation, on the triangulation. `first`
    is the number of black points; the others are white.
    """
    answer = json.loads(file.read_text())
    drawing = file.with_suffix(".webp")
    surface.draw(answer, surface.read_obj(MESH), first).save(drawing, quality=80)
    return drawing


def draw_space(file, _):
    """Draws points in the unit cube as balls."""
    drawing = file.with_suffix(".webp")
    space.draw(json.loads(file.read_text())).save(drawing, quality=80)
    return drawing


def draw_thinner(file, _):
    """Draws the strokes of a drawing less wide, so that they can be told apart. Coordinates in hundredths of a
    millimetre are fine enough, and make the file smaller.
    """
    text = re.sub(r"\d+\.\d{3,}", lambda m: f"{float(m[0]):.2f}", file.read_text())
    drawing = file.with_suffix(".strokes.svg")
    drawing.write_text(re.sub(r'stroke-width="([\d.]+)"', lambda m: f'stroke-width="{0.45 * float(m[1]):g}"', text))
    return drawing


def draw_dithered(file, _):
    """Dithers a part of a photograph: pixels that are lighter than the threshold of the mask become white."""
    mask = numpy.asarray(Image.open(file)).astype(float)
    photograph = numpy.asarray(Image.open(file.parent / "camera.jpg").convert("L"))[40:360, 80:400]
    # Thresholds are for light, so the encoded values of the photograph are first converted to light.
    light = 255 * (photograph / 255) ** 2.2
    tiles = numpy.tile(mask, [-(-size // side) for size, side in zip(light.shape, mask.shape)])
    drawing = file.with_suffix(".dithered.png")
    Image.fromarray(light > tiles[:light.shape[0], :light.shape[1]]).save(drawing, optimize=True)
    return drawing


def draw_seen(file, programs):
    """Shows the colours that are seen on a device instead of those that are sent to it. The device gives the file its name."""
    colours = next(row for row in capabilities(programs)["halftone"]["devices"]["types"] if row["name"] == file.stem)
    values = numpy.asarray(Image.open(file).convert("RGB"))
    shown = values.copy()
    for sent, seen in zip(colours["sent"], colours["seen"]):
        shown[(values == tuple(bytes.fromhex(sent[1:]))).all(axis=2)] = tuple(bytes.fromhex(seen[1:]))
    drawing = file.with_suffix(".seen.png")
    Image.fromarray(shown).quantize(len(colours["seen"]), dither=Image.Dither.NONE).save(drawing, optimize=True)
    return drawing


@functools.cache
def capabilities(programs):
    """Returns the answer of a server to `GET /capabilities`."""
    with subprocess.Popen([programs / "ccdt-server", "--port=0", "--cache=0"], stderr=subprocess.PIPE,
                          text=True) as server:
        try:
            log, found = "", None
            while not found and (line := server.stderr.readline()):
                log += line
                found = re.search(r"listening on (\S+)", line)
            if not found:
                sys.exit(f"ccdt-server did not start:\n{log}")
            with urllib.request.urlopen(found[1] + "/capabilities", timeout=PATIENCE) as answer:
                return json.load(answer)
        finally:
            server.terminate()


def analysed(name, options, caption):
    """Returns an exhibit with points on a torus and their spectrum."""
    return Exhibit(caption, f"Points, their power spectrum, and the curve of their radially averaged power: {caption}",
                   f"ccdt sample --domain '{UNIT_TORUS}' --sites 1024{options} -o {name}.csv\n"
                   f"ccdt analyze {name}.csv -o {name}.svg", is_wide=True)


def device(name, photograph, title):
    """Returns an exhibit with a photograph on a device."""
    return Exhibit(title, f"The {photograph} on a device: {title}",
                   f"ccdt halftone {photograph}.jpg --device {name} --width 320 --height 240 --fit cover -o {name}.png",
                   draw=draw_seen, enlarged=1)


SECTIONS = (
    Section("Before and after", """A photograph becomes dots that reproduce its tones. These drawings are made for a
        screen, and tolerate scaling by the browser.""", (
            Exhibit("Light areas have dots of ink, dark areas holes in the ink.",
                    "A smiling astronaut in an orange suit, as black dots on white and white holes in black",
                    "ccdt halftone astronaut.jpg -o astronaut.webp",
                    before=("astronaut.jpg", "The photograph of the astronaut")),
            Exhibit("Fine detail, such as whiskers, gets more and smaller dots.", "The face of a cat as dots",
                    "ccdt halftone cat.jpg -o cat.webp", before=("cat.jpg", "The photograph of the cat")),
            Exhibit("The ink follows the edges of the picture.",
                    "A man with a camera on a tripod, as dots", "ccdt halftone camera.jpg -o camera.webp",
                    before=("camera.jpg", "The photograph of the man with the camera")),
        )),
    Section("Ink and paper", """Dots may be of ink, of bare paper, or of ink with holes. Ink and paper may have any
        colours.""", (
        Exhibit("Ink only, with dots of one size.", "The man with the camera as black dots on white",
                "ccdt halftone camera.jpg --dots ink -o ink.webp"),
        Exhibit("Paper only: light dots on a dark ground.", "The man with the camera as white dots on black",
                "ccdt halftone camera.jpg --dots paper -o paper.webp"),
        Exhibit("Blue ink on cream paper.", "The cat in dark blue on cream",
                "ccdt halftone cat.jpg --foreground '#1b3a6b' --background '#fbf3dc' -o blue.webp"),
        Exhibit("Large dots, and large holes in the ink.", "The cat as large dots",
                "ccdt halftone cat.jpg --dot 7 -o large.webp"),
    )),
    Section("Colour", """All inks have the same sites. They are mixed so that their mean colour is as near as possible to
        that of the picture.""", (
            Exhibit("Cyan, magenta and yellow.", "The astronaut in cyan, magenta and yellow ink",
                    "ccdt halftone astronaut.jpg --color cmyk --width 800 -o cmyk.webp",
                    before=("astronaut.jpg", "The photograph of the astronaut")),
            Exhibit("Risograph: fluorescent pink, blue and yellow.", "The astronaut in pink, blue and yellow ink",
                    "ccdt halftone astronaut.jpg --palette '#ff48b0,#0078bf,#ffe800' --width 800 -o riso.webp"),
            Exhibit("Risograph: bright red and teal on cream paper.", "The cat in red and teal ink on cream",
                    "ccdt halftone cat.jpg --palette '#f15060,#00838a' --background '#fbf6e9' --width 800 -o two.webp"),
        )),
    Section("Pens and plotters", """A pen draws dots of its own size, fills larger dots by spirals or circles, or
        connects all dots by a single line. Strokes are in the order of a short path.""", (
            Exhibit("One line through all dots.", "The man with the camera drawn by one continuous line",
                    "ccdt halftone camera.jpg --style path --sites 12000 --width-mm 180 -o path.svg",
                    before=("camera.jpg", "The photograph of the man with the camera")),
            Exhibit("A spiral in each dot. Here the pen is thinner than the spirals need, to show the strokes.",
                    "The man with the camera drawn by spirals",
                    "ccdt halftone camera.jpg --style spiral --pen 0.8 --sites 1800 --width-mm 130 -o spiral.svg",
                    draw=draw_thinner),
            Exhibit("Concentric circles, one pen for each ink, also thinner than needed.",
                    "The astronaut drawn by concentric circles in four colours",
                    "ccdt halftone astronaut.jpg --style circles --pen 1 --color cmyk --sites 2500 --width-mm 130 "
                    "-o circles.svg", draw=draw_thinner),
            Exhibit("G-code: touches of the pen, and in blue its way between them.",
                    "The path of a plotter that draws the man with the camera: dots, and blue lines between them",
                    "ccdt halftone camera.jpg --dot 0.8mm --width-mm 150 -o camera.gcode", draw=draw_gcode),
            Exhibit("A country as one line.", "Switzerland, filled by a line",
                    "ccdt sample Switzerland-10m.geojson --coordinates lonlat --sites 2500 --style path --width-mm 180 "
                    "-o line.svg"),
        )),
    Section("Maps and the globe", """Points are spread evenly in polygons, by number or by density, in the plane or on
        the surface of the earth.""", (
            Exhibit("One dot for 2,000 people in 2009: employed in blue, unemployed in orange.",
                    "A dot map of Texas: blue and orange dots, dense in the cities",
                    "ccdt sample texas.geojson --classes employed,unemployed --per 2000 --coordinates lonlat "
                    "--dot 0.02 -o texas.svg"),
            Exhibit("The whole earth: as many points per square kilometre at the poles as at the equator. The list of "
                    "points is drawn as seen from space.", "A globe covered evenly with points",
                    "ccdt sample --polygon '[[-180,-90],[180,-90],[180,90],[-180,90]]' --coordinates lonlat "
                    "--sites 3000 -o globe.csv", draw=draw_globe),
            Exhibit("The outline appears without being drawn.", "Switzerland as evenly spread points",
                    "ccdt sample Switzerland-10m.geojson --sites 2500 --coordinates lonlat -o switzerland.svg"),
            Exhibit("Points that follow a density, here in four steps.",
                    "A strip of points in four steps, each four times as dense as the one before",
                    "ccdt sample --domain '{\"type\":\"rectangle\",\"width\":2,\"height\":1}' "
                    "--density '{\"width\":4,\"height\":1,\"values\":[1,4,16,64]}' --sites 2500 --dot 0.004 "
                    "-o density.svg"),
        )),
    Section("Surfaces", """Points are spread evenly on the surface of a mesh, in exactly the requested number. Each has
        its triangle, barycentric coordinates and normal. The lists of points are drawn as discs on the surface.""", (
            Exhibit("Three thousand points on a cow.", "A toy cow, evenly covered with dots",
                    "ccdt sample spot.obj --sites 3000 -o cow.json", draw=draw_surface),
            Exhibit("Denser where the surface is bent.", "The cow, with more dots on its horns, ears and feet",
                    "ccdt sample spot.obj --sites 3000 --density curvature -o bent.json", draw=draw_surface),
            Exhibit("The triangulation of the points: a mesh of nearly equal triangles.",
                    "The cow as a mesh of small triangles of nearly equal size",
                    "ccdt sample spot.obj --sites 2000 --mesh -o triangles.json", draw=draw_surface),
            Exhibit("A progressive order: the first 500 points, in black, are spread evenly, too.",
                    "The cow, covered with white dots, some of which are black",
                    "ccdt sample spot.obj --sites 3000 --order progressive -o first.json",
                    draw=functools.partial(draw_surface, first=500)),
        )),
    Section("Space", """Points are spread evenly in boxes and tori in space, also by a density on voxels. The lists of
        points are drawn as balls, and the nearer ones are darker.""", (
            Exhibit("A torus: copies side by side fill space without seams.", "Balls, evenly spread in a cube",
                    f"ccdt sample --domain '{TORUS_IN_SPACE}' --sites 1500 -o torus.json", draw=draw_space),
            Exhibit("A density in four steps, each four times as dense as the one before.",
                    "Balls in a cube, few at its left side and many at its right side",
                    f"ccdt sample --domain '{TORUS_IN_SPACE.replace('torus', 'box')}' "
                    "--density '{\"width\":4,\"height\":1,\"depth\":1,\"values\":[1,4,16,64]}' --sites 2500 -o steps.json",
                    draw=draw_space),
            Exhibit("Thin slabs of a torus next to each other, and a slice of the spectrum: low frequencies are dark.",
                    "Points in four slabs, a spectrum with a dark disc in the middle, and its radially averaged power",
                    f"ccdt sample --domain '{TORUS_IN_SPACE}' --sites 8192 -o space.csv\n"
                    f"ccdt analyze space.csv --domain '{TORUS_IN_SPACE}' -o space.svg", is_wide=True),
        )),
    Section("Devices", """Electronic paper and label printers show one of a few colours in each pixel. The picture has
        exactly the pixels of the device, each of which is one pixel here, in the colours that are seen on it.""", (
            device("spectra6", "astronaut", "Spectra 6"), device("acep7", "astronaut", "Seven colours (ACeP)"),
            device("bwr", "cat", "Black, white and red"), device("gray16", "camera", "Sixteen greys"),
            device("gray4", "camera", "Four greys"), device("1bit", "camera", "Black and white"),
        ), is_small=True),
    Section("Point sets and their spectra", """Blue noise has no power at low frequencies: no clusters and no gaps. The
        dark disc in the middle of a spectrum shows this.""", (
            analysed("standard", "", "Capacity-Constrained Delaunay Triangulation: the disc is dark."),
            analysed("stealthy", " --quality stealthy", "With the quality stealthy, half of the disc is empty: less "
                     "than 1e-12 of the power of random points remains at each frequency."),
            analysed("random", " --method random", "Independent random points have clusters, gaps, and power at all "
                     "frequencies."),
        )),
    Section("Threshold masks and sets of pixels", """A mask is made once. Dithering with it then costs one comparison
        per pixel, in a shader or on a microcontroller.""", (
            Exhibit("A mask of 64 x 64 thresholds, five times enlarged. It tiles without seams.",
                    "A grey texture without visible structure",
                    "ccdt sample --domain '{\"type\":\"torus\",\"width\":64,\"height\":64}' --format mask -o mask.png",
                    enlarged=5),
            Exhibit("A photograph, dithered with a mask of 128 x 128 thresholds.",
                    "The man with the camera, dithered with a mask",
                    "ccdt sample --domain '{\"type\":\"torus\",\"width\":128,\"height\":128}' --format mask "
                    "-o mask-128.png", draw=draw_dithered, enlarged=1),
            Exhibit("Exactly 10,240 of 102,400 pixels, with a block in the middle, as for magnetic resonance imaging.",
                    "White pixels on black, evenly spread around a white square",
                    "ccdt sample --domain '{\"type\":\"pixels\",\"width\":320,\"height\":320}' --sites 10240 "
                    "--calibration '{\"width\":32,\"height\":32}' -o pixels.png", enlarged=1),
        ), is_small=True),
)

INTRODUCTION = """<p>Each picture was made by the command that stands below it, from the files that stand at the
<a href="#gallery-files">end of this page</a>. <a href="md_server_cli_README.html">The command line</a>
describes the program <code>ccdt</code>, and <a href="md_api_README.html">API</a> its options. Select a picture to see
it alone.</p>"""

CREDITS = """<p>The astronaut is Eileen Collins, photographed by NASA (public domain). The cat and the man with the
camera are sample data of scikit-image (CC0). Switzerland is by Natural Earth (public domain). The counties of Texas
are by the npm package us-atlas (ISC licence), derived from data of the Census Bureau (public domain), and the numbers
by the Bureau of Labor Statistics (public domain). The cow, Spot, is by Keenan Crane (public domain). More about them
is in
<a href="md_tests_data_README.html">Real inputs</a>.</p>"""


def run(exhibit, programs, folder):
    """Runs the commands of an exhibit in a folder, and returns the picture to show."""
    for command in exhibit.command.splitlines():
        program, *arguments = shlex.split(command)
        done = subprocess.run([programs / program, *arguments], cwd=folder, capture_output=True, text=True,
                              timeout=PATIENCE, check=False)
        if done.returncode != 0:
            sys.exit(f"this command of the gallery failed: {command}\n{done.stderr}")
    file = folder / exhibit.output()
    return exhibit.draw(file, programs) if exhibit.draw else file


def marked(command):
    """Returns the text of a command with a span for each word, so that lines break between words."""
    words = re.findall(r"\n|(?:'[^']*'|[^\s'])+", command)
    return " ".join(f"<span>{html.escape(word, quote=False)}</span>" for word in words).replace(
        " <span>\n</span> ", "\n")


def figure(exhibit, picture):
    """Returns the element that shows an exhibit."""
    def shown(path, alt, scale=1.0):
        return f'<a href="gallery/{path.name}">{pictures.element(path, alt, "gallery", scale)}</a>'

    before = shown(picture.with_name(exhibit.before[0]), exhibit.before[1]) if exhibit.before else ""
    kinds = {"pair": exhibit.before, "wide": exhibit.is_wide, "pixels": exhibit.enlarged}
    classes = " ".join(["exhibit", *(kind for kind, holds in kinds.items() if holds)])
    return (f'<figure class="{classes}"><div class="shown">{before}{shown(picture, exhibit.alt, exhibit.enlarged or 1)}'
            f"</div><figcaption>{html.escape(exhibit.caption)}</figcaption>"
            f"<pre><code>{marked(exhibit.command)}</code></pre></figure>")


def make(programs, folder):
    """Fills a folder with the pictures of the gallery, and returns the content of its page."""
    for path in INPUTS:
        shutil.copy(path, folder)
    shown = {path.name for path in INPUTS}
    parts = [INTRODUCTION]
    for section in SECTIONS:
        parts += [f"<h2>{section.title}</h2>", f"<p>{html.escape(' '.join(section.text.split()))}</p>",
                  f'<div class="exhibits{" small" if section.is_small else ""}">']
        for exhibit in section.exhibits:
            picture = run(exhibit, programs, folder)
            parts.append(figure(exhibit, picture))
            shown.add(picture.name)
        parts.append("</div>")
    files = ", ".join(f'<a href="gallery/{path.name}" download>{path.name}</a>' for path in INPUTS)
    parts += ['<h2 id="gallery-files">Files</h2>', CREDITS, f"<p>{files}</p>"]
    for path in folder.iterdir():
        if path.name not in shown:
            path.unlink()
    return "\n".join(parts) + "\n"
