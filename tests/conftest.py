"""Fixtures that several test packages share."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmus.build import blocks_of, ensure


@pytest.fixture(scope="session")
def built_fmus() -> dict[str, Path]:
    """This project's FMUs in the Python flavour, by block; built once for all processes of the tests."""
    return {block: ensure(block, "python") for block in blocks_of("python")}
