"""The result of a run as users have it: its data, and the ways to keep them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from ..errors import InputError
from ..quantities import ONE, QuantityError, value_in
from ..scenario.scenario import Scenario
from . import figures, frames
from .data import RunData
from .differences import Differences, compare
from .folder import write
from .html import rows
from .settling import Settling, settling

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame
    from xarray import Dataset


def target(folder: str | Path | None, scenario: Scenario) -> Path:
    """Returns the folder of a run's results, by default `results/<name of the scenario>`.

    Raises InputError for an empty name.
    """
    if folder == "":
        raise InputError("the folder of the results has an empty name; expected a folder such as results/run1")
    return Path("results") / scenario.name if folder is None else Path(folder)


class Result(RunData):
    """Record of a run.

    `result["plant.omega_B"]` has shape (n, 3), `result["plant.R_NB"]` (n, 3, 3),
    `result["plant.omega_B[2]"]` (n,); `result["plant.h_w", "mN.m.s"]` is in that unit; `result.time` (n,).
    Booleans and whole numbers come as such.
    `result.units["plant.omega_B"]` is the unit.
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

    @property
    def signals(self) -> list[str]:
        """Returns the names of the recorded signals, each of which is a key."""
        return list(self)

    def plot(self, *names: str) -> Figure:
        """Returns a Matplotlib figure of these signals over time, a panel for each; of those that expectations look at
        by default.

        A notebook shows it. Raises KeyError for a signal that was not recorded, and InputError without Matplotlib.
        """
        return figures.plot(self, names)

    def settling(self, name: str, below: float | str) -> Settling:
        """Returns since when a recorded signal, or the norm of a vector, stays below a limit, with rms and largest
        value from then on, in the signal's unit.

        `below` is in this unit, or text with another: `result.settling("judge.attitude_error", "1 deg")`. Samples are
        the recorded ones. Raises InputError.
        """
        unit = self.variable(name).unit or ONE
        try:
            limit = value_in(below, unit)
        except QuantityError as error:
            raise InputError(f"below {below}: {error}") from None
        return settling(self.time, np.asarray(self[name], np.float64), limit)

    def compare(self, other: RunData) -> Differences:
        """Returns the largest and rms difference of each signal that both results have, at the instants that both have.

        Raises ValueError where they have no instant in common.
        """
        return compare(self, other)

    def to_pandas(self) -> DataFrame:
        """Returns a pandas DataFrame: the index is time in s, a column for each element, units in `attrs["units"]`."""
        return frames.to_pandas(self)

    def to_xarray(self) -> Dataset:
        """Returns an xarray Dataset: vectors on the shared dimension `axis`, matrices on `row` and `axis`.

        Units are among the attributes.
        """
        return frames.to_xarray(self)

    def _ipython_key_completions_(self) -> list[str]:
        """Returns what a notebook offers behind `result["`."""
        return self.signals

    def __repr__(self) -> str:
        return f"<Result {self._text()}>"

    def _text(self) -> str:
        """Returns the run in a line."""
        ended = "failed at" if self.failure else "interrupted at" if self.interrupted else "ran"
        met = sum(outcome.passed for outcome in self.outcomes)
        claims = f", {met} of {len(self.outcomes)} expectations met" if self.outcomes else ""
        claims += f", {left} not evaluated" if (left := len(self.not_evaluated)) else ""
        recorded = f"{len(self)} signals, {len(self.time)} samples"
        return f"{self.scenario.name}: {ended} {self.reached:.10g} s, {recorded}{claims}"

    def _repr_html_(self) -> str:
        """Returns what a notebook shows: the run in a line, and its expectations."""
        cells = [(o.status, o.name, o.text, o.expected) for o in (*self.outcomes, *self.not_evaluated)]
        head = Markup("<tr><th>outcome</th><th>expectation</th><th>found</th><th>expected</th></tr>")
        table = Markup("<table>{}{}</table>").format(head, rows(cells)) if cells else ""
        failure = Markup("<pre>{}</pre>").format(self.failure) if self.failure else ""
        return Markup("<p><b>Result</b> {}</p>{}{}").format(self._text(), failure, table)
