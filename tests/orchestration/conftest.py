from __future__ import annotations

from pathlib import Path

import pytest

from . import fmus
from .wrong_inputs import SCENARIO


@pytest.fixture
def loop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A scenario of two real FMUs, in this process: dx/dt = u and u = -x. The current folder is its own."""
    fmus.write_pair(tmp_path)
    path = tmp_path / "loop.yaml"
    path.write_text(SCENARIO + "isolation: none\n", "utf-8")
    monkeypatch.chdir(tmp_path)
    return path
