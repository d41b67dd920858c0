"""The result of a run as users have it: its data, and the ways to keep them."""

from __future__ import annotations

from pathlib import Path

from . import figures
from .data import RunData
from .folder import write


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
        return write(self, Path(folder) if folder else Path("results") / self.scenario.name, format)

    def draw(self, folder: str | Path, format: str = "png") -> list[Path]:
        """Draws the scenario's figures into a folder; `format` is one that Matplotlib writes.

        Raises InputError without Matplotlib, and ResultsError where they cannot be written.
        """
        return figures.draw(self, Path(folder), format)
