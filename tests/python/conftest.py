# SPDX-License-Identifier: GPL-3.0-or-later
"""Fixtures of all tests of the Python package. The environment variable PYTHONPATH names the folder of the package."""

import pathlib
import sys

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "integration"))

from harness import PICTURES, Server  # pylint: disable=wrong-import-position


@pytest.fixture(scope="session")
def server():
    """A running server."""
    with Server() as running:
        yield running


@pytest.fixture(scope="session")
def cat():
    """The bytes of a picture in colour."""
    return (PICTURES / "chelsea.png").read_bytes()


@pytest.fixture(scope="session")
def ramp():
    """A grey ramp, uint8 [48, 64]."""
    return np.tile(np.linspace(0, 255, 64).astype(np.uint8), (48, 1))
