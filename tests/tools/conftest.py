from __future__ import annotations

from pathlib import Path

import pytest

from . import measure


@pytest.fixture(scope="session")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the FMUs, and the loop as SSP archive and as container for each step."""
    folder = tmp_path_factory.mktemp("tools")
    measure.prepare(folder)
    return folder
