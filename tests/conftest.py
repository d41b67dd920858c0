"""Fixtures that several test packages share."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmus.build import build


@pytest.fixture(scope="session")
def built_fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """This project's FMUs in the Python flavour, by block."""
    return build(flavour="python", out=tmp_path_factory.mktemp("fmus"))
