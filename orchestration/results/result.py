"""The result of a run as users have it: its data, and the ways to keep them."""

from __future__ import annotations

from pathlib import Path

from ..errors import InputError
from ..scenario.scenario import Scenario
from . import figures
from .data import RunData
from .folder import write


def target(folder: str | Path | None, scenario: Scenario) -> Path:
    """The folder of a run's results, by default `results/<name of the scenario>`. Raises InputError for an empty name."""
    if folder == "":
        raise InputError("the folder of the results has an empty name; expected a folder such as results/run1")
    return Path("results") / scenario.name if folder is None else Path(folder)


class Result(RunData):
    """What a run recorded.

    `result["plant.omega_B"]` has shape (n, 3), `result["plant.R_NB"]` (n, 3, 3),
    `result["plant.omega_B[2]"]` (n,); `result.time` (n,). Booleans and whole numbers come as such.
    """

    def save(self, folder: str | Path | None = None, format: str = "csv") -> Path:
        """Writes the run's folder, by default `results/<name of the scenario>`, and returns it.

        `format` is csv, parquet or mat. Raises InputError for another one or where its package is missing,
        and ResultsError where the folder cannot be written.
        """
        return write(self, target(folder, self.scenario), format)

    def draw(self, folder: str | Path, format: str = "png") -> list[Path]:
        """Draws the scenario's figures into a folder; `format` is one that Matplotlib writes.

        Raises InputError without Matplotlib, and ResultsError where they cannot be written.
        """
        return figures.draw(self, Path(folder), format)
