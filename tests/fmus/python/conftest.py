"""The toy as an FMU, for all tests of the Python flavour."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmus.build import build
from tests.shared import once

from ..toy import toy


@pytest.fixture(scope="session")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return once(tmp_path_factory, "toy", lambda folder: build([toy(folder)], "python", folder)) / "toy.fmu"
