# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays and other objects of Python, in and out."""

import io
import json
import os
import pickle
import re
import stat
import sys
import warnings
import zipfile

import ccdt
import numpy as np
import pytest
import shapely.geometry
from harness import DATA, PICTURES, POLYGONS, check_private_dev, execute
from PIL import Image
from profiles import DISPLAY_P3, rgb_profile

SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
HOUSE, SPOT = (DATA / "meshes" / name for name in ("house.obj", "spot.obj"))


def dots(picture, **options):
    return ccdt.halftone(picture, 100, format="json", **options).points


def raises(field, text):
    """Expects an error about a field, whose text matches."""
    class Expected:
        def __enter__(self):
            self.context = pytest.raises(ccdt.Error, match=text)
            self.info = self.context.__enter__()

        def __exit__(self, *arguments):
            handled = self.context.__exit__(*arguments)
            assert self.info.value.field == field
            return handled

    return Expected()


@pytest.mark.parametrize("layout", ["fortran", "strided", "reversed", "read-only", "big-endian", "one channel"])
def test_layouts_do_not_matter(ramp, layout):
    expected = dots(ramp)
    wide = np.zeros((48, 128), np.uint8)
    wide[:, ::2] = ramp
    fixed = ramp.copy()
    fixed.flags.writeable = False
    pictures = {"fortran": np.asfortranarray(ramp), "strided": wide[:, ::2],
                "reversed": np.ascontiguousarray(ramp[::-1, ::-1])[::-1, ::-1], "read-only": fixed,
                "big-endian": (ramp.astype(np.uint16) * 257).astype(">u2"),
                "one channel": ramp[..., None]}
    assert np.array_equal(dots(pictures[layout]), expected)


def test_types_with_the_same_values_give_the_same_dots(ramp):
    black_white = ramp > 127
    assert np.array_equal(dots(black_white), dots(black_white * np.uint8(255)))
    assert np.array_equal(dots(black_white.astype(np.float64)), dots(black_white))
    assert np.array_equal(dots(black_white.astype(np.float32), linear=True), dots(black_white))
    assert np.array_equal(dots(ramp.astype(np.int64)), dots(ramp))
    assert np.array_equal(dots(ramp.tolist()), dots(ramp))
    with pytest.warns(ccdt.Warning, match="almost black"):
        dots([[0, 1]])
    shades = ramp / 255
    assert np.allclose(dots(shades), dots(ramp), atol=0.05)
    assert not np.allclose(dots(shades, linear=True), dots(ramp), atol=0.05)


@pytest.mark.parametrize(("picture", "text"), [
    (np.zeros((0, 5), np.uint8), "at least one pixel"),
    (np.zeros(5, np.uint8), "shape"),
    (np.zeros((2, 2, 5), np.uint8), "shape"),
    (np.full((2, 2), 256), "int64 must have values from 0 to 255, not from 256 to 256"),
    ([[0, -1]], "from -1 to 0"),
    (np.zeros((2, 2), complex), "complex128"),
    (np.full((2, 2), np.nan), "nan"),
    (np.full((2, 2), np.inf), "inf"),
    (np.full((2, 2), 255.0), "from 0 to 1, not from 255 to 255"),
    (7, "not int"),
], ids=str)
def test_unusable_arrays_are_refused(picture, text):
    with raises("picture", text):
        ccdt.halftone(picture)


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@pytest.mark.parametrize("dtype", [bool, np.uint8, np.uint16, np.float32])
def test_masked_pixels_are_transparent(channels, dtype):
    picture = np.zeros((20, 20, channels), dtype)
    if channels % 2 == 0:
        picture[..., -1] = 1 if dtype in (bool, np.float32) else np.iinfo(dtype).max
    mask = np.zeros(picture.shape, bool)
    mask[:, :10, 0] = True
    found = dots(np.ma.array(picture, mask=mask))
    assert len(found) == 100 and (found[:, 0] > 10).all()
    assert np.array_equal(dots(np.ma.array(picture)), dots(picture))


def test_a_picture_of_one_pixel_has_dots():
    assert dots(np.zeros((1, 1), np.uint8)).shape == (100, 2)


def test_pictures_without_ink_are_refused():
    with pytest.raises(ccdt.Error) as refused:
        dots(np.full((8, 8), 255, np.uint8))
    assert refused.value.code == "unusable"


def test_images_of_pillow_equal_their_files(tmp_path):
    image = Image.fromarray(np.asarray(Image.open(PICTURES / "chelsea.png").resize((90, 60))))
    profile = rgb_profile(DISPLAY_P3, 1.8)
    for name, options in (("plain.png", {}), ("turned.jpg", {"exif": turned(image), "quality": 95}),
                          ("profile.png", {"icc_profile": profile})):
        image.save(tmp_path / name, **options)
        with Image.open(tmp_path / name) as opened:
            assert np.array_equal(dots(opened), dots(tmp_path / name)), name
    assert not np.array_equal(dots(tmp_path / "profile.png"), dots(tmp_path / "plain.png"))
    palette = image.convert("P")
    assert np.array_equal(dots(palette), dots(palette.convert("RGB")))
    inks = image.convert("CMYK")
    inks.save(tmp_path / "inks.tif")
    assert np.array_equal(dots(inks), dots(tmp_path / "inks.tif"))


def turned(image):
    """Returns EXIF data that turn an image by a quarter."""
    exif = image.getexif()
    exif[0x0112] = 6
    return exif


def test_files_are_given_in_several_ways(cat):
    expected = dots(cat)
    path = PICTURES / "chelsea.png"
    with open(path, "rb") as file:
        for picture in (path, str(path), file, io.BytesIO(cat), bytearray(cat)):
            assert np.array_equal(dots(picture), expected)


def test_broken_files_are_refused():
    with pytest.raises(ccdt.Error, match="PNG") as refused:
        ccdt.halftone(b"no picture")
    assert refused.value.code == "unsupported"


def test_points_are_an_array():
    points = ccdt.sample(SQUARE, 50)
    assert isinstance(points, np.ndarray) and points.dtype == np.float64 and points.shape == (50, 2)
    assert points.flags.writeable and points.base is not None
    assert ((points > 0) & (points < 1)).all()
    for part in (points[:10], points[0], points * 2, points.mean(axis=0)):
        assert type(part) is np.ndarray  # pylint: disable=unidiomatic-typecheck
    assert isinstance(points.mean(), float)
    assert points._repr_png_() == points.write("png")
    copy = points.copy()
    assert copy._repr_png_() is None
    with pytest.raises(AttributeError, match="part or a copy"):
        copy.write("csv")


def test_points_know_more(tmp_path):
    points = ccdt.sample(SQUARE, 50, mesh=True, order="progressive")
    assert np.array_equal(points.ranks, np.arange(50)) and points.ranks.dtype == np.uint32
    assert np.array_equal(points.vertices[:50], points)
    corners = points.vertices[points.triangles]
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (doubled > 0).all() and np.isclose(doubled.sum(), 2)
    assert len(points.variations) == 6 and points.variation > 0
    assert points.features is None and points.classes is None
    points.save(tmp_path / "points.geojson")
    assert (tmp_path / "points.geojson").read_bytes() == points.write("geojson")
    assert points.image().ndim == 2


def test_single_points_are_written_in_each_format():
    square = {"type": "Polygon", "coordinates": [[*SQUARE, SQUARE[0]]]}
    points = ccdt.sample(square, 5, multipoint=False)
    written = json.loads(points.write("geojson"))
    assert [each["geometry"]["coordinates"] for each in written["features"]] == points.tolist()
    assert points.write("csv") == ccdt.sample(square, 5).write("csv")


def test_choices_are_indices():
    points = np.random.default_rng(1).random((2000, 2))
    indices = ccdt.choose(points, 100)
    assert indices.shape == (100,) and (np.diff(indices) > 0).all()
    apart = np.linalg.norm(points[indices][:, None] - points[indices], axis=-1) + np.eye(100)
    assert apart.min() > 0.06  # a hexagonal grid has .107
    assert {3, 4} <= set(ccdt.choose(points, 100, keep=[3, 4])) & set(ccdt.choose(points, 100, keep=np.arange(2000) < 5))
    left = ccdt.choose(points, 100, density=points[:, 0] < 0.5)
    assert (points[left][:, 0] < 0.5).all()
    ranked = ccdt.choose(points, 100, order="progressive")
    assert set(ranked) == set(indices) and (np.diff(ranked) < 0).any()
    solid = ccdt.choose(np.random.default_rng(2).random((500, 3)), 20, domain="solid", seed=np.random.default_rng(3))
    assert len(solid) == 20
    kinds = np.where(points[:, 0] < 0.3, "a", "b")
    assert np.unique(kinds[ccdt.choose(points, 100, classes=kinds)], return_counts=True)[1][0] == round((kinds == "a").mean() * 100)
    assert (kinds[ccdt.choose(points, {"a": 7}, classes=kinds)] == ["a"] * 7).all()
    apart = points[ccdt.choose(points, spacing=0.1)]
    assert (np.linalg.norm(apart[:, None] - apart, axis=-1) + np.eye(len(apart)) >= 0.1).all() and len(apart) > 80
    hidden = np.ma.masked_array(points, np.arange(4000).reshape(2000, 2) < 1000)
    with pytest.warns(ccdt.Warning, match="without coordinates are left out: 500"):
        assert ccdt.choose(hidden, 100).min() >= 500


@pytest.mark.parametrize("arguments, options, field, text", [
    ((np.zeros((5, 4)), 1), {}, "points", r"\[n, 2\] or \[n, 3\], not \[5, 4\]"),
    ((np.zeros((5, 2)), 6), {}, "sites", "only 5 candidates"),
    ((np.zeros((5, 2)), 1.5), {}, "sites", "must be an integer"),
    ((np.zeros((5, 2)), 1), {"density": [1, 2]}, "density", "each of the 5 points"),
    ((np.zeros((5, 2)), 1), {"density": [1, 2, -1, 0, 0]}, "density", r"density\[2\] must be at least 0"),
    ((np.zeros((5, 2)), 1), {"priority": "rank"}, "priority", "no column 'rank'"),
    ((np.zeros((5, 2)), 1), {"keep": [5]}, "keep", "indices below 5"),
])
def test_unusable_choices_are_refused(arguments, options, field, text):
    with pytest.raises(ccdt.Error, match=text) as refused:
        ccdt.choose(*arguments, **options)
    assert refused.value.field.split("/")[0] == field


def test_dot_maps_have_features_and_classes():
    def feature(x, ones, twos):
        ring = [[x, 0], [x + 1, 0], [x + 1, 1], [x, 1], [x, 0]]
        return {"type": "Feature", "properties": {"ones": ones, "twos": twos},
                "geometry": {"type": "Polygon", "coordinates": [ring]}}

    collection = {"type": "FeatureCollection", "features": [feature(0, 10, 5), feature(1, 20, 15)]}
    points = ccdt.sample(collection, classes=["ones", "twos"], order="progressive")
    assert len(points) == 50
    assert np.array_equal(points.features, (points[:, 0] > 1).astype(int))
    assert np.bincount(points.classes).tolist() == [30, 20]
    assert sorted(points.ranks[points.classes == 1]) == list(range(20))
    counted = ccdt.sample(collection, "ones")
    assert np.bincount(counted.features).tolist() == [10, 20] and counted.classes is None


def test_features_without_points_give_a_warning():
    def feature(x, count):
        return {"type": "Feature", "properties": {"count": count}, "geometry":
                {"type": "Polygon", "coordinates": [[[x, 0], [x + 1, 0], [x + 1, 1], [x, 1], [x, 0]]]}}

    counties = {"type": "FeatureCollection", "features": [feature(2 * i, n) for i, n in enumerate([1, 0, "2", 1000])]}
    with pytest.warns(ccdt.Warning, match="^2 of 4 features have a count above 0, but no point") as given:
        points = ccdt.sample(counties, {"property": "count", "per": 100})
    assert points.features.tolist() == [3] * 10 and len(given) == 1
    assert points.warnings == (str(given[0].message),)


def test_geometries_of_shapely_are_domains():
    polygon = shapely.geometry.Polygon(SQUARE).difference(shapely.geometry.Point(0.5, 0.5).buffer(0.25))
    points = ccdt.sample(polygon, 80, avoid=shapely.geometry.box(0, 0, 0.2, 0.2))
    inside = polygon.difference(shapely.geometry.box(0, 0, 0.2, 0.2))
    assert all(inside.contains(shapely.geometry.Point(point)) for point in points)


def test_files_with_geojson_are_domains(tmp_path):
    path = POLYGONS / "Italy-110m.geojson"
    assert np.array_equal(ccdt.sample(path, 30), ccdt.sample(json.loads(path.read_text()), 30))
    (tmp_path / "a.geojson").write_text("{")
    with raises("domain", "a.geojson"):
        ccdt.sample(str(tmp_path / "a.geojson"), 30)


@pytest.mark.parametrize(("arguments", "options", "field", "text"), [
    ((None, 5), {}, "domain", "NoneType"),
    ((SQUARE, 0), {}, "sites", "1 to 2000000"),
    (([[0, 0], [1, np.nan], [1, 1]], 5), {}, "polygon/1/1", "finite"),
    (([[0, 0, 0], [1, 0, 0], [1, 1, 0]], 5), {}, "polygon", "[n, 2]"),
    ((SQUARE, 5), {"density": np.ones(3)}, "density", "[rows, columns]"),
    ((SQUARE, 5), {"density": [[1, -1]]}, "density/values/1", "at least 0"),
    ((SQUARE, 5), {"density": np.zeros((2, 2))}, "density/values", "zero"),
    ((SQUARE, 5), {"quality": "good"}, "quality", "draft"),
    ((SQUARE, 5), {"fixed": {1, 2}}, "fixed", "set"),
    ((SQUARE, 5), {"threads": 0}, "threads", "at least 1"),
    ((SQUARE, 5), {"seed": 2**53}, "seed", "9007199254740991"),
], ids=str)
def test_errors_name_the_field_and_the_limit(arguments, options, field, text):
    with raises(field, re.escape(text)):
        ccdt.sample(*arguments, **options)


def test_errors_do_not_speak_of_servers_and_urls():
    with raises("multipoint", "the limit is 2000000"):
        raise ccdt.Error._of("limit_exceeded", [("/multipoint", "there are 3; this server's limit (max-sites) is 2000000")])
    with raises("foreground", "must be a colour: #rgb, #rrggbb or a name of CSS such as teal$"):
        ccdt.halftone(np.zeros((4, 4)), 9, foreground="pale")


@pytest.mark.parametrize(("call", "field", "text"), [
    (lambda array: ccdt.sample(array, 5), "polygon/1/0", "polygon[1][0] must be finite, not masked"),
    (lambda array: ccdt.sample(SQUARE, 5, fixed=array), "fixed/1/0", "fixed[1][0] must be finite, not masked"),
    (ccdt.analyze, "points/1/0", "points[1][0] must be finite, not masked"),
    (lambda array: ccdt.sample(ccdt.Mesh(np.ma.column_stack([array, array])[:, :3], [[0, 1, 2]]), 5),
     "vertices/1/0", "vertices[1][0] must be finite, not masked"),
    (lambda array: ccdt.sample({"type": "Polygon", "coordinates": [array.filled(np.nan).tolist()]}, 5),
     "geometry/coordinates/0/1/0", "geometry/coordinates/0/1/0 must be finite"),
], ids=["polygon", "fixed", "points", "mesh", "geometry"])
def test_positions_must_not_be_masked(call, field, text):
    with raises(field, re.escape(text)):
        call(np.ma.masked_equal([[0, 0], [9, 0.5], [0.5, 0.5], [0, 1.0]], 9))


def test_masked_densities_are_zero():
    values = np.array([[1.0, 2], [3, 4]])
    for size in ((), (2,)):
        domain = ccdt.Box() if size else SQUARE
        grid = np.broadcast_to(values, (*size, 2, 2))
        expected = ccdt.sample(domain, 50, density=np.where(grid == 2, 0, grid))
        assert np.array_equal(ccdt.sample(domain, 50, density=np.ma.masked_equal(grid, 2)), expected)
        with pytest.warns(ccdt.Warning, match=f"density has {grid.size // 4} values that are NaN"):
            assert np.array_equal(ccdt.sample(domain, 50, density=np.where(grid == 2, np.nan, grid)), expected)
    mesh = ccdt.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    assert np.array_equal(ccdt.sample(mesh, 20, density=np.ma.masked_equal([1, 2, 3], 2)),
                          ccdt.sample(mesh, 20, density=[1, 0, 3]))


def test_several_errors_are_reported_at_once():
    with pytest.raises(ccdt.Error) as refused:
        ccdt.sample(SQUARE, 0, seed=-1)
    assert {field for field, _ in refused.value.errors} == {"sites", "seed"}
    again = pickle.loads(pickle.dumps(refused.value))
    assert (str(again), again.field, again.errors) == (str(refused.value), refused.value.field, refused.value.errors)


BOW = {"type": "Polygon", "coordinates": [[[0, 40], [9, 40], [0, 60], [9, 60], [0, 40]]]}


def test_warnings_point_at_the_caller():
    with pytest.warns(ccdt.Warning) as given:
        points = ccdt.sample(BOW, 20)
    assert [warning.filename for warning in given] == [__file__] * 2
    assert points.warnings == tuple(str(warning.message) for warning in given)
    degrees, repaired = points.warnings
    assert "degrees" in degrees and degrees == points.info["warnings"][0]["detail"]
    assert repaired == "the domain was repaired: " + points.info["repaired"][0]["detail"]
    assert pickle.loads(pickle.dumps(points)).warnings == points.warnings
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert ccdt.sample(SQUARE, 20).warnings == ccdt.sample(HOUSE, 20).warnings == ()


def test_pictures_with_several_frames_give_a_warning():
    frames = [Image.new("L", (32, 32), shade) for shade in (0, 90)]
    file = io.BytesIO()
    frames[0].save(file, "GIF", save_all=True, append_images=frames[1:])
    for options in ({}, {"device": "1bit"}):
        with pytest.warns(ccdt.Warning, match="frame"):
            picture = ccdt.halftone(file.getvalue(), **options)
        [text] = picture.warnings
        assert "frame" in text


def test_unknown_options_are_refused():
    with pytest.raises(TypeError, match="'site'.*quality"):
        ccdt.sample(SQUARE, 5, site=3)
    with pytest.raises(TypeError, match="'color'"):
        ccdt.halftone(np.zeros((2, 2), np.uint8), device="1bit", color="cmyk")


def test_dots_of_a_drawing_are_those_of_its_image(ramp):
    halftone = ccdt.halftone(ramp, 60, scale=8)
    assert halftone.image().shape == (48 * 8, 64 * 8) and (halftone.width, halftone.height) == (64, 48)
    assert len(halftone) == 60 and halftone.radius > 0 and halftone.inks == [] and halftone.ink is None
    [rings] = halftone.rings
    assert "rings" not in halftone.info and "points" not in halftone.info
    ink = 0
    for x, y in (ring.T for ring in rings):
        ink += (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2  # holes turn the other way
    drawn = (255 - halftone.image()).mean() / 255 * 64 * 48
    assert abs(abs(ink) - drawn) < 10
    assert halftone._repr_png_() == halftone.write("png")


def test_colours_have_inks(cat):
    listed = ccdt.halftone(cat, 300, color="cmyk", format="json")
    assert listed.inks == ["cyan", "magenta", "yellow", "black"] and set(listed.ink) <= {0, 1, 2, 3}
    assert listed.rings == [] and listed.radius > 0
    drawn = ccdt.halftone(cat, 300, color="cmyk")
    assert drawn.inks == ["cyan", "magenta", "yellow"] and drawn.ink is None and len(drawn) == 300
    assert len(drawn.rings) == 3 and all(len(rings) > 100 for rings in drawn.rings)
    assert drawn.image().shape[2] == 3


def test_options_of_some_formats_need_no_format(ramp, tmp_path):
    shape, saved = [[0, 0], [4, 0], [4, 3]], tmp_path / "a"
    for options, suffix, start in (({"paper": "a6"}, ".svg", b"<svg"), ({"paper": "a6", "split": "ink"}, ".zip", b"PK"),
                                   ({"width_mm": 50, "dpi": 100}, ".png", b"\x89PNG"),
                                   ({"jpeg_quality": 20}, ".jpg", b"\xff\xd8")):
        points = ccdt.sample(shape, 20, **options)
        assert np.array_equal(points, ccdt.sample(shape, 20))
        for result in (points, ccdt.halftone(ramp, 60, **options)):
            result.save(saved.with_suffix(suffix))
            assert saved.with_suffix(suffix).read_bytes().startswith(start)


def test_split_drawings_are_saved_as_archives(ramp, tmp_path):
    split = ccdt.halftone(ramp, 60, width_mm=50, split="ink", format="svg", dots="ink")
    with raises("split", "must end with .zip"):
        split.save(tmp_path / "a.svg")
    assert not (tmp_path / "a.svg").exists()
    split.save(tmp_path / "a.zip")
    split.save(tmp_path / "b.zip", format="hpgl")
    for name, extension in (("a.zip", ".svg"), ("b.zip", ".plt")):
        assert all(each.endswith(extension) for each in zipfile.ZipFile(tmp_path / name).namelist())
    with raises("split", ".zip is the extension"):
        ccdt.halftone(ramp, 60).save(tmp_path / "c.zip")


def test_halftones_are_written_in_other_formats(ramp, tmp_path):
    halftone = ccdt.halftone(ramp, 60, width_mm=50)
    for name in ("a.svg", "a.tif", "a.webp", "a.jpg", "a.pdf", "a.eps", "a.csv", "a.json", "a.npy"):
        halftone.save(tmp_path / name)
    assert np.array_equal(np.load(tmp_path / "a.npy")[:, :2], halftone.points)
    with raises("dots", "a pen can only add ink"):
        halftone.save(tmp_path / "a.gcode")
    with raises("format", "extension"):
        halftone.save(tmp_path / "a.heic")
    with raises("format", "bmp is not one of png"):
        halftone.write("bmp")
    with raises("width_mm", "pdf needs one of them"):
        ccdt.halftone(ramp, 60).write("pdf")
    assert not (tmp_path / "a.gcode").exists()
    device = ccdt.halftone(ramp, device="gray4")
    device.save(tmp_path / "a.bmp")
    assert np.array_equal(np.asarray(Image.open(tmp_path / "a.bmp").convert("L")), device.image())


FULL = """
import resource, ccdt
from ccdt.client import Answer
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
for result in (ccdt.sample(ccdt.Torus(), 500), Answer(bytes(2000), {})):
    for name in ("old.json", "new.json"):
        try:
            result.save(name)
        except OSError as error:
            print(error)
"""


def test_a_failure_to_write_changes_no_file(tmp_path):
    (tmp_path / "old.json").write_text("old")
    done = execute([sys.executable, "-c", FULL], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert done.stdout.splitlines() == [f"[Errno 27] File too large: '{name}.json'" for name in ("old", "new")] * 2
    assert [path.name for path in tmp_path.iterdir()] == ["old.json"]
    assert (tmp_path / "old.json").read_text() == "old"


def test_files_keep_their_mode_and_links(tmp_path):
    points = ccdt.sample(ccdt.Torus(), 20)
    old, new, link = (tmp_path / name for name in ("old.csv", "new.csv", "link.csv"))
    old.touch()
    old.chmod(0o604)
    link.symlink_to(old)
    mask = os.umask(0o027)
    try:
        points.save(link)
        points.save(new)
    finally:
        os.umask(mask)
    assert link.is_symlink() and old.read_bytes() == new.read_bytes() == points.write("csv")
    assert [stat.S_IMODE(path.stat().st_mode) for path in (old, new)] == [0o604, 0o640]
    assert len(list(tmp_path.iterdir())) == 3


def test_open_files_and_devices_are_written_directly(tmp_path):
    script = "import sys, ccdt; ccdt.sample(ccdt.Torus(), 20).save(sys.argv[1], 'csv')"
    # Without the trace of the expected failures.
    command = ["sh", "-c", '"$@" 2> /dev/null', "sh", sys.executable, "-c", script]
    check_private_dev(command, tmp_path, ccdt.sample(ccdt.Torus(), 20).write("csv"))


INTERRUPTED = """
import ccdt, os, signal
def interrupt(*_):
    signal.setitimer(signal.ITIMER_REAL, 0)
    raise ZeroDivisionError
signal.signal(signal.SIGALRM, interrupt)
os.mkfifo("pipe")
points = ccdt.sample(ccdt.Torus(), 5)  # imports NumPy, which an alarm would make an ImportError
try:
    signal.setitimer(signal.ITIMER_REAL, 0.1, 0.1)
    points.save("pipe", "csv")
except ZeroDivisionError:
    print("interrupted")
"""


def test_waiting_for_a_reader_can_be_interrupted(tmp_path):
    done = execute([sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert done.stdout == "interrupted\n"


def test_sizes_are_limited_for_each_format():
    strip = np.zeros((4, 400), np.uint8)
    with raises("width", "20000 x 200 pixels.*at most 16383"):
        ccdt.halftone(strip, 60, format="svg", width=20000).write("webp")
    listed = ccdt.halftone(np.zeros((600, 600), np.uint8), 60, format="json", scale=16)
    with raises("scale", "9600 x 9600 pixels.*64000000"):
        listed.image()


def test_results_can_be_pickled(ramp):
    points = ccdt.sample(ccdt.Torus(), 100, order="progressive")
    again = pickle.loads(pickle.dumps(points))
    assert np.array_equal(again, points) and np.array_equal(again.ranks, points.ranks)
    assert again.write("csv") == points.write("csv")
    halftone = ccdt.halftone(ramp, 60)
    again = pickle.loads(pickle.dumps(halftone))
    assert np.array_equal(again.points, halftone.points) and again.write() == halftone.write()
    device = ccdt.halftone(ramp, device="1bit")
    assert np.array_equal(pickle.loads(pickle.dumps(device)).image(), device.image())
    analysis = ccdt.analyze(points)
    assert np.array_equal(pickle.loads(pickle.dumps(analysis)).power, analysis.power)


def test_points_keep_the_mesh_of_an_open_file():
    with open(HOUSE, "rb") as file:
        points = ccdt.sample(file, 50)
    again = pickle.loads(pickle.dumps(points))
    expected = ccdt.analyze(np.asarray(points), HOUSE, modes=5)
    for each in (points, again):
        assert np.array_equal(ccdt.analyze(each, modes=5).power, expected.power)
    with open(SPOT, "rb") as file:
        inside = ccdt.sample(ccdt.Solid(file), 20)
    assert np.array_equal(pickle.loads(pickle.dumps(inside)), inside)


def test_analyze_measures_points_in_the_polygons_where_they_were_placed():
    corners = [[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]]
    points = ccdt.sample(corners, 2000)
    analysis = ccdt.analyze(points)
    assert analysis.low_frequency_power < 0.01
    assert 0.85 < analysis.mean_distance < 0.95
    ring = {"type": "Polygon", "coordinates": [[*corners, corners[0]]]}
    assert np.array_equal(ccdt.analyze(np.asarray(points), ring).power, analysis.power)
    with pytest.raises(ccdt.Error, match="outside"):
        ccdt.analyze(points, [[0, 0], [2, 0], [0, 2]])
    with pytest.raises(ccdt.Error, match="degrees"):
        ccdt.analyze(ccdt.sample(corners, 20, coordinates="lonlat"))


def test_analyze_takes_sets_and_refuses_others():
    sets = np.stack([ccdt.sample(ccdt.Torus(), 64, seed=seed) for seed in range(2)])
    assert ccdt.analyze(sets).sets == 2
    for points, text in ((np.zeros((3, 4)), r"\[n, 2 or 3\]"), ([[0, 0], [1]], "equal length")):
        with raises("points", text):
            ccdt.analyze(points)
    with raises("points/1", "domain|outside|inside"):
        ccdt.analyze([[0, 0], [2, 0]])
    with raises("points", r"\[n, 3\]"):
        ccdt.analyze([[0, 0], [1, 0]], ccdt.Box())
    with raises("points", r"\[n, 2 or 3\]"):
        ccdt.analyze(5)
    with raises("modes", "only for meshes"):
        ccdt.analyze(sets[0], modes=5)
    with raises("max_frequency", "not for meshes"):
        ccdt.analyze(np.zeros((2, 3)), HOUSE, max_frequency=2)
    with raises("spectrum", "not for meshes"):
        ccdt.analyze(np.zeros((2, 3)), HOUSE, spectrum=True)
    with raises("domain", "solid"):
        ccdt.analyze(np.zeros((2, 3)), ccdt.Solid("cube.obj"))
