"""The toy as an FMU, for all tests of the Python flavour."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmus.build import ensure
from tests.once import FOLDER

from ..toy import toy


@pytest.fixture(scope="session")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return ensure(toy(tmp_path_factory.mktemp("toy")), "python", FOLDER)
