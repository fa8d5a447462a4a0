# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks the includes of the code: folders may include only those below them, server -> api -> core, and there are no
cycles among the subfolders of a folder, among the shelves of core, or among files, where a source file and its header
count as one. Every other library has a rule that lists the files that include it.

Usage: include_directions.py ROOT         check the source tree
       include_directions.py --self-check  check that violations are found
"""

import pathlib
import re
import sys
import tempfile

FOLDERS = ("core", "api", "server")
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)

# Headers that any file may include: those of the standard library, of the C library and of Linux, and our own.
FREE = re.compile(r"^(?:[a-z_]+|(?:core|ccdt|tests)/.*|(?:arpa|linux|netinet|sys)/.*"
                  r"|(?:fcntl|grp|malloc|netdb|poll|pthread|sched|signal|spawn|unistd)\.h)$")

# The other headers, and the files or folders that may include them. The first match decides.
RULES = (
    (re.compile(r"^server/"), ("server/",)),
    (re.compile(r"^api/"), ("api/", "server/")),
    (re.compile(r"^tl/"), ("core/base/result.h", "core/ccdt/relax/border.h", "core/geometry/delaunay.h",
                           "server/http/problem.h")),
    (re.compile(r"^CGAL/"), ("core/geometry/delaunay.cpp", "core/geometry/delaunay3.cpp")),
    (re.compile(r"^boost/multiprecision/"), ("core/geometry/delaunay.cpp",)),
    (re.compile(r"^Eigen/"), ("core/points/analysis/laplacian_modes.cpp",)),
    (re.compile(r"^gemmi/"), ("core/base/pocketfft_lines.h",)),
    (re.compile(r"^OpenImageIO/"), ("api/image/library_reader.cpp",)),
    (re.compile(r"^avif/"), ("api/image/avif_reader.cpp",)),
    (re.compile(r"^lcms2"), ("api/image/colour_profile.cpp",)),
    (re.compile(r"^gif_lib\.h$"), ("api/image/gif_reader.cpp",)),
    (re.compile(r"^libheif/|^libde265/"), ("api/image/heic_reader.cpp",)),
    (re.compile(r"^jpeglib\.h$"), ("api/image/ink_jpeg.cpp", "api/image/jpeg_writer.cpp")),
    (re.compile(r"^png\.h$"), ("api/image/png_writer.cpp", "api/python/png_pixels.cpp")),
    (re.compile(r"^tiffio\.h$"), ("api/image/tiff_reader.cpp", "api/image/tiff_writer.cpp")),
    (re.compile(r"^webp/"), ("api/image/webp_writer.cpp",)),
    (re.compile(r"^zlib\.h$"), ("api/image/colour_tags.cpp", "api/image/png_writer.cpp", "api/output/pmtiles.cpp",
                                "server/http/compression.cpp")),
    (re.compile(r"^protozero/"), ("api/output/dot_tiles.cpp", "api/output/pmtiles.cpp")),
    (re.compile(r"^shapefil\.h$"), ("api/map/shapefile_reader.cpp",)),
    (re.compile(r"^iconv\.h$"), ("api/map/code_page.cpp",)),
    (re.compile(r"^zip\.h$"), ("api/map/zip_archive.cpp",)),
    (re.compile(r"^nlohmann/"), ("api/capabilities.cpp", "api/json/", "api/problem.cpp")),
    (re.compile(r"^pybind11/"), ("api/python/",)),
    (re.compile(r"^librsvg/"), ("api/output/svg_renderer.cpp",)),
    (re.compile(r"^cairo"), ("api/output/cairo_drawing.cpp", "api/output/letters.cpp")),
    (re.compile(r"^curl/"), ("server/fetch/fetcher_main.cpp", "server/http/http_client.cpp")),
    (re.compile(r"^sqlite3\.h$"), ("server/jobs/sqlite.",)),
    (re.compile(r"^hiredis/"), ("server/redis/redis_connection.cpp",)),
    (re.compile(r"^openssl/(?:ssl|err)"), ("server/redis/redis_connection.cpp",)),
    (re.compile(r"^openssl/sha"), ("server/redis/redis_script.cpp",)),
    (re.compile(r"^openssl/(?:evp|hmac)"), ("server/requests/digest.",)),
    (re.compile(r"^prometheus/"), ("server/monitoring/metrics.cpp",)),
    (re.compile(r"^seccomp\.h$"), ("server/decoder/decoder_sandbox.cpp",)),
    (re.compile(r"^httplib\.h$"), ("server/http/http_library.cpp",)),
    (re.compile(r"^spdlog/|^fmt/"), ("server/monitoring/log.cpp",)),
)


def includes(root, folder):
    """Yields pairs of a file and a file that it includes."""
    for path in sorted((root / folder).rglob("*")):
        if path.suffix in (".h", ".cpp"):
            for included in INCLUDE.findall(path.read_text()):
                yield path.relative_to(root).as_posix(), included


def violations(root):
    for folder in FOLDERS:
        for name, included in includes(root, folder):
            allowed = next((by for rule, by in RULES if rule.search(included)), ())
            if not FREE.match(included) and not name.startswith(allowed):
                yield f"{name} includes {included}"


def subfolder(name):
    return pathlib.PurePath(name).parent.as_posix()


def shelf(name):
    """Returns the subfolder of core in which a file lies, at whatever depth."""
    return "/".join(pathlib.PurePath(name).parts[:2])


def unit(name):
    """Returns the common name of a header and its source file."""
    return pathlib.PurePath(name).with_suffix("").as_posix()


def graph(root, folder, node_of):
    """Returns the nodes of a folder, each with the other nodes of the folder that it includes."""
    included_by = {}
    for name, included in includes(root, folder):
        node, other = node_of(name), node_of(included)
        if other.startswith(folder) and other != node:
            included_by.setdefault(node, set()).add(other)
    return included_by


def cycles(root):
    """Yields the subfolders and the files that belong to a cycle of includes or include one."""
    for folder in FOLDERS:
        for node_of in (subfolder, unit) + ((shelf,) if folder == "core" else ()):
            left = graph(root, folder, node_of)
            while free := [node for node in left if not left[node] & left.keys()]:
                for node in free:
                    del left[node]
            for node, others in sorted(left.items()):
                yield f"{node} belongs to a cycle or includes one: {', '.join(sorted(others & left.keys()))}"


def self_check():
    planted = {
        "core/a.h": "api/run/options.h",
        "core/b.cpp": "server/config/config.h",
        "core/c.h": "httplib.h",
        "core/d.cpp": "nlohmann/json.hpp",
        "core/e.cpp": "OpenImageIO/imageio.h",
        "core/f.cpp": "spdlog/spdlog.h",
        "core/g.cpp": "png.h",
        "core/h.h": "unknown/library.h",
        "core/mesh/h.cpp": "CGAL/Polygon_2.h",
        "core/base/fft.h": "gemmi/third_party/pocketfft_hdronly.h",
        "api/i.cpp": "server/http/http.h",
        "api/j.h": "httplib.h",
        "api/k.cpp": "spdlog/logger.h",
        "api/l.h": "OpenImageIO/imageio.h",
        "api/s.cpp": "librsvg/rsvg.h",
        "api/image/v.cpp": "lcms2.h",
        "api/image/w.cpp": "pybind11/numpy.h",
        "api/image/image_codec.cpp": "jpeglib.h",
        "api/map/x.cpp": "shapefil.h",
        "server/work/y.cpp": "zip.h",
        "server/m.cpp": "nlohmann/json.hpp",
        "server/n.cpp": "OpenImageIO/imageio.h",
        "server/http/v.cpp": "httplib.h",
        "server/t.cpp": "seccomp.h",
        "server/jobs/u.cpp": "sqlite3.h",
        "server/redis/w.cpp": "hiredis/hiredis.h",
    }
    harmless = {
        "core/geometry/delaunay.cpp": "CGAL/Polygon_2.h",
        "core/base/pocketfft_lines.h": "gemmi/third_party/pocketfft_hdronly.h",
        "api/image/library_reader.cpp": "OpenImageIO/imageio.h",
        "api/image/colour_profile.cpp": "lcms2.h",
        "api/image/ink_jpeg.cpp": "jpeglib.h",
        "api/map/shapefile_reader.cpp": "shapefil.h",
        "api/map/zip_archive.cpp": "zip.h",
        "api/output/svg_renderer.cpp": "librsvg/rsvg.h",
        "api/python/module.cpp": "pybind11/pybind11.h",
        "api/o.cpp": "core/base/result.h",
        "server/decoder/decoder_sandbox.cpp": "seccomp.h",
        "server/http/http_library.cpp": "httplib.h",
        "server/jobs/sqlite.h": "sqlite3.h",
        "server/redis/redis_connection.cpp": "hiredis/hiredis.h",
        "server/p.cpp": "api/run/options.h",
        "core/q.cpp": "vector",
    }
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, included in (planted | harmless).items():
            path = root / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(f"#pragma once\n  #  include <{included}>\n")
        expected = sorted(f"{name} includes {included}" for name, included in planted.items())
        found = sorted(violations(root))
        if found != expected:
            sys.exit(f"expected {expected}\nfound {found}")
        check_cycles(root)


def check_cycles(root):
    planted = {"server/one/a.h": "server/two/a.h", "server/two/a.h": "server/three/a.h",
               "server/three/a.cpp": "server/one/a.h", "server/four/a.h": "server/five/a.h",
               "core/one/a.cpp": "core/two/a.h", "core/two/a.cpp": "core/one/b.h",
               "api/one/a.h": "api/one/b.h", "api/one/b.h": "api/one/a.h", "api/one/c.h": "api/one/d.h",
               "core/six/a.cpp": "core/six/b.h", "core/six/b.h": "core/six/a.h", "core/six/c.cpp": "core/six/c.h",
               "core/seven/one/a.h": "core/eight/one/a.h", "core/eight/two/b.h": "core/seven/two/b.h"}
    for name, included in planted.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f'#include "{included}"\n')
    found = [line.split()[0] for line in cycles(root)]
    if found != ["core/one", "core/two", "core/six/a", "core/six/b", "core/eight", "core/one", "core/seven", "core/two",
                 "api/one/a", "api/one/b",
                 "server/one", "server/three", "server/two", "server/one/a", "server/three/a", "server/two/a"]:
        sys.exit(f"found {found}")


def main():
    if sys.argv[1:] == ["--self-check"]:
        self_check()
        return
    root = pathlib.Path(sys.argv[1])
    missing = [folder for folder in FOLDERS if not (root / folder).is_dir()]
    found = list(violations(root)) + list(cycles(root))
    for line in missing + found:
        print(line)
    sys.exit(1 if missing or found else 0)


if __name__ == "__main__":
    main()
