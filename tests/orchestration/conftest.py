from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.machine import lacking

from . import fmus
from .results import browser
from .wrong_inputs import SCENARIO


@pytest.fixture
def loop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A scenario of two real FMUs, in this process: dx/dt = u and u = -x. The current folder is its own."""
    fmus.write_pair(tmp_path)
    path = tmp_path / "loop.yaml"
    path.write_text(SCENARIO + "isolation: none\n", "utf-8")
    monkeypatch.chdir(tmp_path)
    return path


@pytest.fixture(scope="session")
def chromium() -> Iterator[browser.Tab]:
    """A browser with one page."""
    path = browser.executable()
    if path is None:
        lacking("no Chromium on this machine (Debian: apt-get install chromium)")
    with browser.launched(path) as tab:
        yield tab
