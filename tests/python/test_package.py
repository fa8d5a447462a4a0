# SPDX-License-Identifier: GPL-3.0-or-later
"""The package as a whole: its types, its installation by pip, its documentation and its example."""

import os
import re
import sys
import tarfile

import ccdt
import pytest
from harness import PICTURES, ROOT, execute
from PIL import Image

SOURCE = ROOT / "api" / "python"


def output_of(*command, **options):
    """Runs a program that must succeed, and returns its output."""
    done = execute(command, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_modules_are_loaded_when_they_are_needed():
    script = """
import sys, ccdt
print("numpy" in sys.modules, "ccdt._core" in sys.modules)
import numpy
ccdt.halftone(numpy.zeros((8, 8), numpy.uint8), 10)
print("ccdt._codec" in sys.modules)
"""
    assert output_of(sys.executable, "-c", script).split() == ["False", "False", "False"]


def test_names_are_listed_and_described():
    assert set(ccdt.__all__) <= set(dir(ccdt))
    for name in ccdt.__all__:
        assert getattr(ccdt, name).__doc__
    with pytest.raises(AttributeError, match="nothing"):
        ccdt.nothing  # pylint: disable=no-member,pointless-statement


def test_types_are_consistent(tmp_path):
    output_of("mypy", "--config-file", SOURCE / "pyproject.toml", "--cache-dir", tmp_path, SOURCE / "ccdt")


def test_pip_installs_the_package_without_network(tmp_path):
    """Uses the build folder of the tests, so that nothing is compiled again."""
    output_of(sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", tmp_path / "venv")
    environment = {**os.environ, "PYTHONPATH": "", "PIP_DISABLE_PIP_VERSION_CHECK": "1"}
    output_of(sys.executable, "-m", "pip", "--python", tmp_path / "venv/bin/python", "install", "--no-index",
              "--no-cache-dir", SOURCE, "--config-settings", f"build-dir={os.environ['CCDT_BUILD']}", env=environment)
    script = ("import ccdt, importlib.metadata as data; "
              "print(ccdt.__file__, data.version('ccdt'), ccdt.__version__, ccdt.sample(ccdt.Torus(), 9).shape)")
    output = output_of(tmp_path / "venv/bin/python", "-c", script, env=environment, cwd=tmp_path)
    assert output.startswith(str(tmp_path))
    version = re.search(r"^project\(ccdt VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE)[1]
    assert f" {version} {version} (9, 2)" in output


@pytest.fixture(name="cmake")
def fixture_cmake(tmp_path, monkeypatch):
    """A program `cmake` that notes its arguments, and fails if told so."""
    program = tmp_path / "bin" / "cmake"
    program.parent.mkdir()
    program.write_text('#!/bin/sh\necho "$@" >>"$CALLS"\nexit $STATUS\n')
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{program.parent}:{os.environ['PATH']}")
    monkeypatch.setenv("CALLS", str(tmp_path / "calls"))
    monkeypatch.setenv("STATUS", "0")
    monkeypatch.syspath_prepend(SOURCE)
    return lambda: (tmp_path / "calls").read_text().splitlines()


def test_a_build_is_repeated_after_a_failure(tmp_path, cmake, monkeypatch):
    import build_backend  # pylint: disable=import-error,import-outside-toplevel
    folder = tmp_path / "build"
    folder.mkdir()
    (folder / "CMakeCache.txt").write_text("")  # of a configuration that failed
    monkeypatch.setenv("STATUS", "1")
    with pytest.raises(SystemExit, match="docker/install build"):
        build_backend.compile_package(folder)
    monkeypatch.setenv("STATUS", "0")
    build_backend.compile_package(folder)
    (folder / "build.ninja").write_text("")
    build_backend.compile_package(folder)
    kinds = ["configure" if f"-DPython_EXECUTABLE={sys.executable}" in call else "build" for call in cmake()]
    assert kinds == ["configure", "configure", "build", "build"]


def build(function, folder):
    """Builds an archive at a fixed time, and returns its path."""
    folder.mkdir()
    script = (f"import build_backend, sys; "
              f"print(build_backend.{function}(sys.argv[1], {{'build-dir': sys.argv[2]}}))")
    output = output_of(sys.executable, "-c", script, folder, os.environ["CCDT_BUILD"], cwd=SOURCE,
                       env={**os.environ, "SOURCE_DATE_EPOCH": "1700000000"})
    return folder / output.split()[-1]


@pytest.mark.parametrize("function", ["build_wheel", "build_sdist"])
def test_archives_are_reproducible(function, tmp_path):
    first, second = (build(function, tmp_path / name).read_bytes() for name in ("first", "second"))
    assert first == second


def test_the_source_archive_can_be_built(tmp_path):
    """CMake configures the unpacked archive, which therefore has all files that it names."""
    with tarfile.open(build("build_sdist", tmp_path / "packed")) as archive:
        archive.extractall(tmp_path)
    (root,) = tmp_path.glob("ccdt-*")
    assert 'backend-path = ["api/python"]' in (root / "pyproject.toml").read_text()
    assert (root / "PKG-INFO").read_text().startswith("Metadata-Version: 2.1\nName: ccdt\n")
    output_of("cmake", "-S", root, "-B", tmp_path / "build", "-G", "Ninja", "-DCCDT_BUILD_PROGRAMS=OFF",
              "-DCCDT_BUILD_PYTHON=ON", "-DBUILD_TESTING=OFF")
    assert "ccdt_python" in output_of("ninja", "-C", tmp_path / "build", "-t", "targets", "all")


def test_the_example_of_the_project_makes_a_picture(tmp_path):
    (tmp_path / "photo.jpg").symlink_to(PICTURES / "chelsea.png")  # recognised by its first bytes
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / "README.md").read_text(), re.MULTILINE | re.DOTALL)
    output_of(sys.executable, "-c", "\n".join(block for block in blocks if "import ccdt\n" in block), cwd=tmp_path)
    assert Image.open(tmp_path / "dots.png").size == (1203, 800)


def test_examples_of_the_readme_run(tmp_path):
    (tmp_path / "photo.jpg").symlink_to(PICTURES / "chelsea.png")  # recognised by its first bytes
    blocks = re.findall(r"^```python\n(.*?)^```", (SOURCE / "README.md").read_text(), re.MULTILINE | re.DOTALL)
    local = [block for block in blocks if "localhost" not in block]
    assert len(local) > 2
    output_of(sys.executable, "-c", "\n".join(local), cwd=tmp_path)
    assert Image.open(tmp_path / "dots.png").size == (1203, 800)


def test_examples_of_the_readme_call_the_server(server, tmp_path):
    (tmp_path / "photo.jpg").symlink_to(PICTURES / "chelsea.png")
    blocks = re.findall(r"^```python\n(.*?)^```", (SOURCE / "README.md").read_text(), re.MULTILINE | re.DOTALL)
    remote = [block.replace("http://localhost:8080", server.url("")) for block in blocks if "localhost" in block]
    assert remote
    output_of(sys.executable, "-c", "\n".join(remote), cwd=tmp_path)
    assert (tmp_path / "dots.svg").read_bytes().startswith(b"<svg")


def test_the_gallery_makes_its_pictures(tmp_path):
    output_of(sys.executable, SOURCE / "examples" / "gallery.py", tmp_path)
    pictures = sorted(path.name for path in tmp_path.iterdir())
    assert pictures == ["colour.png", "device.png", "halftone.png", "map.png", "mask.png", "spectrum.png"]
    for name in pictures:
        with Image.open(tmp_path / name) as picture:
            low, high = picture.convert("L").getextrema()
            assert high - low > 100, name
