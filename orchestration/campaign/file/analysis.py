"""The analyses that a campaign asks for: sensitivities from a design of their own, and a search for the worst case."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...scenario.types import Model

Count = Annotated[int, Field(strict=True)]


class Sensitivity(Model):
    """The varied entries on which a metric depends, by runs of a design of their own."""

    method: Literal["sobol", "morris"] = "sobol"
    """sobol: shares of the variance (Saltelli's design); morris: mean effects, for many entries and few runs."""
    points: Annotated[Count, Field(ge=4, le=2**20)] = 256
    """sobol: base points, a power of two, each with 2 runs and one more for each varied entry; morris: trajectories,
    each with one run and one more for each varied entry."""

    @model_validator(mode="after")
    def _balanced(self) -> Sensitivity:
        if self.method == "sobol" and self.points & (self.points - 1):
            least = 1 << (self.points.bit_length() - 1)
            raise ValueError(f"points: expected a power of two, such as {least} or {2 * least}; found {self.points}")
        return self

    def runs(self, entries: int) -> int:
        """Returns the runs that it takes with so many varied entries."""
        return self.points * (entries + (2 if self.method == "sobol" else 1))


class Search(Model):
    """A search for the run with the worst value of a metric, within what varies."""

    metric: str = Field(strict=True, min_length=1)
    """The metric whose worst value is searched for."""
    worst: Literal["largest", "smallest"] = "largest"
    """Which of its values is the worst."""
    runs: Annotated[Count, Field(ge=20)] = 400
    """Runs that the search may take."""
    batch: Annotated[Count, Field(ge=4)] | None = None
    """Runs that are flown at once; default: 4 + 3 ln(d) of d coordinates, 8 at least. Choose more for a cluster."""
    within: Annotated[float, Field(gt=0.5, lt=1.0)] = 0.9973
    """Of a distribution without end (normal, log-normal), the central share that is searched; default: that of 3 sigma.
    """
