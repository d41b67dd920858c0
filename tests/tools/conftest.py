"""The loop as archives and containers for the tests of other tools, and a loop of two small FMUs for those of SSP."""

from __future__ import annotations

from pathlib import Path

import pytest

from ..orchestration import fmus
from ..orchestration.wrong_inputs import SCENARIO
from . import measure


@pytest.fixture
def loop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A scenario of two real FMUs, dx/dt = u and u = -x, in a folder of its own."""
    fmus.write_pair(tmp_path)
    path = tmp_path / "loop.yaml"
    path.write_text(SCENARIO, "utf-8")
    monkeypatch.chdir(tmp_path)
    return path


@pytest.fixture(scope="session")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the FMUs, and the loop as SSP archive and as container for each step."""
    folder = tmp_path_factory.mktemp("tools")
    measure.prepare(folder)
    return folder
