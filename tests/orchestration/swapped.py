"""A loop with another team's FMU beside it, and the commands on it."""

from __future__ import annotations

from pathlib import Path

from . import fmus, vendor
from .wrong_inputs import SCENARIO

STEP = "<ModelVariables>"
"""What follows a DefaultExperiment in their description."""


def swapped(folder: Path, monkeypatch, *changes, scenario: str = SCENARIO, isolated: bool = False, **options) -> Path:
    """A folder with loop.yaml, its two FMUs, and vendor.fmu with mapping.yaml for the regulator.

    They run in this process unless `isolated`, since starting one for each takes longer than all else.
    """
    fmus.write_pair(folder)
    vendor.write(folder, *changes, runnable=True, **options)
    path = folder / "loop.yaml"
    path.write_text(scenario + ("" if isolated else "isolation: none\n"), "utf-8")
    monkeypatch.chdir(folder)
    return path
