# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the wheel and the source archive of the package (PEP 517). Needs only CMake and the standard library, so that
pip needs no network.

    pip install .
    pip install . --config-settings build-dir=FOLDER

Without `build-dir`, the package is compiled in build/release of the source tree if server/run has built there, whose
objects it shares, and else in build/python. A `build-dir` that CMake has configured already is used as it is. Files in
the archives have the time SOURCE_DATE_EPOCH, if that variable is set.
"""

import base64
import gzip
import hashlib
import io
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import time
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
EARLIEST = 315532800  # 1980-01-01, which zip archives cannot precede


def version():
    """Returns the version of the project, which its build defines."""
    return re.search(r"^project\(ccdt VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE)[1]


def metadata():
    """Returns the text of the file METADATA in the wheel, and of PKG-INFO in the source archive."""
    return (f"Metadata-Version: 2.1\nName: ccdt\nVersion: {version()}\n"
            "Summary: Blue-noise dots: pictures as halftones, and evenly spread points\n"
            "License: GPL-3.0-or-later\nRequires-Python: >=3.9\nRequires-Dist: numpy\n"
            "Description-Content-Type: text/markdown\n\n" + (HERE / "README.md").read_text())


def tag():
    """Returns the tag of the wheel: versions of Python and of its binary interface, and platform."""
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


def is_configured(folder):
    """Returns whether CMake has written all files of a build folder. It may have failed after its cache was written."""
    return any((folder / name).exists() for name in ("build.ninja", "Makefile"))


def configure(folder):
    """Configures a build folder for this Python, after a failure or for another Python, too."""
    programs = [] if is_configured(folder) else ["-DCCDT_BUILD_PROGRAMS=OFF", "-DBUILD_TESTING=OFF"]
    generator = ["-G", "Ninja"] if shutil.which("ninja") and not is_configured(folder) else []
    try:
        subprocess.run(["cmake", "-S", ROOT, "-B", folder, "-U", "*Python_*", "-U", "PYTHON_*", *generator, *programs,
                        "-DCMAKE_BUILD_TYPE=Release", "-DCCDT_BUILD_PYTHON=ON",
                        f"-DPython_EXECUTABLE={sys.executable}"], check=True)
    except (FileNotFoundError, subprocess.CalledProcessError) as error:
        raise SystemExit(f"ccdt cannot be compiled: {error}. The messages of CMake above, if any, say what is missing. "
                         "On Debian 12, as root: docker/install build && apt-get install pybind11-dev libpython3-dev"
                         ) from None


def compile_package(given=None):
    """Compiles the package, and returns the build folder.

    Args:
        given: build folder. By default, it is chosen, and configured for this Python.
    """
    release = ROOT / "build" / "release"
    folder = pathlib.Path(given or (release if is_configured(release) else ROOT / "build" / "python")).resolve()
    if not given or not is_configured(folder):
        configure(folder)
    subprocess.run(["cmake", "--build", folder, "--parallel", str(os.cpu_count()), "--target", "ccdt_python"],
                   check=True)
    return folder


def timestamp():
    """Returns the time of the files in archives, in seconds."""
    return max(int(os.environ.get("SOURCE_DATE_EPOCH", time.time())), EARLIEST)


def add(wheel, name, data, listing):
    """Adds a file to the wheel, and its digest to the listing."""
    info = zipfile.ZipInfo(name, time.gmtime(timestamp())[:6])
    info.external_attr = 0o644 << 16
    info.compress_type = zipfile.ZIP_DEFLATED
    wheel.writestr(info, data)
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    listing.append(f"{name},sha256={digest},{len(data)}\n")


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Builds the wheel, and returns the name of its file. Called by pip."""
    folder = compile_package((config_settings or {}).get("build-dir"))
    name = f"ccdt-{version()}-{tag()}.whl"
    information = f"ccdt-{version()}.dist-info"
    wheel_text = f"Wheel-Version: 1.0\nGenerator: ccdt\nRoot-Is-Purelib: false\nTag: {tag()}\n"
    with tempfile.TemporaryDirectory() as installed:
        subprocess.run(["cmake", "--install", folder, "--component", "python", "--strip", "--prefix", installed],
                       check=True, stdout=subprocess.DEVNULL)
        package = next(pathlib.Path(installed).rglob("__init__.py")).parent
        listing = []
        with zipfile.ZipFile(pathlib.Path(wheel_directory) / name, "w") as wheel:
            for path in sorted(package.iterdir()):
                add(wheel, f"ccdt/{path.name}", path.read_bytes(), listing)
            add(wheel, f"{information}/METADATA", metadata().encode(), listing)
            add(wheel, f"{information}/WHEEL", wheel_text.encode(), listing)
            add(wheel, f"{information}/LICENSE", (ROOT / "LICENSE").read_bytes(), listing)
            add(wheel, f"{information}/RECORD", "".join([*listing, f"{information}/RECORD,,\n"]).encode(), [])
    return name


def sources():
    """Yields the path of each file in the source archive, and its bytes."""
    yield "PKG-INFO", metadata().encode()
    # pip expects this file at the top. The folder of the backend is relative to it.
    settings = (HERE / "pyproject.toml").read_text().replace('backend-path = ["."]', 'backend-path = ["api/python"]')
    yield "pyproject.toml", settings.encode()
    for path in (ROOT / "CMakeLists.txt", ROOT / "LICENSE", *sorted((ROOT / "core").rglob("*")),
                 *sorted((ROOT / "api").rglob("*"))):
        if path.is_file() and "__pycache__" not in path.parts:
            yield path.relative_to(ROOT).as_posix(), path.read_bytes()


def build_sdist(sdist_directory, config_settings=None):  # pylint: disable=unused-argument
    """Builds the source archive, and returns the name of its file. Called by build frontends."""
    base = f"ccdt-{version()}"
    unpacked = io.BytesIO()
    with tarfile.open(fileobj=unpacked, mode="w", format=tarfile.PAX_FORMAT) as archive:
        for name, data in sources():
            info = tarfile.TarInfo(f"{base}/{name}")
            info.size, info.mtime = len(data), timestamp()
            archive.addfile(info, io.BytesIO(data))
    packed = gzip.compress(unpacked.getvalue(), mtime=0)
    (pathlib.Path(sdist_directory) / f"{base}.tar.gz").write_bytes(packed)
    return f"{base}.tar.gz"
