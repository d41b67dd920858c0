"""A scenario from a file: YAML, or an SSP archive by its suffix."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..scenario import extends
from ..scenario import load as loading
from ..scenario.scenario import Scenario
from ..scenario.source import Source


def read(path: Path) -> Source:
    """The data of a scenario file with their lines. Raises InputError."""
    if path.suffix == ".fmu" and path.exists():
        remedy = f"remedy: orchestrate check {path} --as BLOCK, or orchestrate SCENARIO --swap BLOCK={path}"
        raise InputError(f"{path}: this is an FMU, expected a scenario; {remedy}")
    if path.suffix == ".ssp" and path.exists():
        from ..ssp import reader  # here, since it takes 20 ms and few scenarios are archives  # noqa: PLC0415

        return reader.read(path)
    return extends.read(path)


def load(scenario: str | Path | Mapping[str, Any] | Source, overrides: Mapping[str, Any] | None = None) -> Scenario:
    """A scenario from a file, or from the same data as a dictionary. Raises InputError.

    `overrides` are start values by `block.parameter`, and `step`, `duration` and `flavour`.
    """
    return loading.load(read(Path(scenario)) if isinstance(scenario, str | Path) else scenario, overrides)
