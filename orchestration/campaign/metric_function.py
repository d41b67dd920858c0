"""A campaign as a function of the unit cube, for what chooses its points itself: sensitivity analyses, searches."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..fmu.model import Floats
from .case import Case
from .drawing.expression import Expression
from .flying.batches import Batches, Crew
from .flying.job import OK
from .replay import scenario_text


class FlownMetrics:
    """The metric function of runs that are flown.

    Each coordinate is uniform in [0, 1) under the campaign's distributions.
    """

    def __init__(self, case: Case, flying: Crew) -> None:
        self._case, self._crew = case, flying
        job = case.job
        self.dimension: int = job.draws.dimension
        self.coordinates: list[str] = job.draws.coordinates
        self.entries: list[tuple[str, int, int]] = [(d.name, d.first, d.count) for d in job.draws.draws if d.count]
        """The name of each entry that is drawn, its first coordinate, and how many it has."""
        self.metrics: dict[str, str] = {m.metric.name: str(m.unit) for m in job.measures}
        """Their units, by name."""
        self.bounded: list[bool] = [
            end for d in job.draws.draws if not isinstance(d.sampler, Expression) for end in d.sampler.bounded
        ]
        """By coordinate, whether its distribution has ends."""
        self.reasons: dict[str, int] = {}
        """How many runs failed up to now, by reason."""
        self._first = [name for name, _ in job.columns].index(job.measures[0].metric.name) if job.measures else 0

    def __call__(self, unit: Floats) -> dict[str, Floats]:
        """The metrics (n,) by name at points (n, dimension); NaN where a run failed or gave none."""
        points = np.asarray(unit, float)
        if points.ndim != 2 or points.shape[1] != self.dimension:
            raise ValueError(f"expected points of shape (n, {self.dimension}), found {points.shape}")
        indices = np.arange(len(points))
        metrics = np.full((len(points), len(self.metrics)), np.nan)
        batches = Batches(indices, lambda chosen: points[chosen], self._crew.slots)
        for flown in self._crew.fly(batches):
            for row in flown.rows:
                cells: Any = row[self._first : self._first + len(self.metrics)]
                metrics[int(row[0] or 0)] = [np.nan if cell is None else cell for cell in cells]
                if row[1] != OK:
                    self.reasons[str(row[2])] = self.reasons.get(str(row[2]), 0) + 1
        return {name: metrics[:, i] for i, name in enumerate(self.metrics)}

    def values(self, unit: Floats) -> dict[str, Any]:
        """Returns the start values at a point (dimension,) by name, as `--set` takes them."""
        draws = self._case.job.draws
        return draws.given(draws.at(np.asarray(unit, float).tolist()))

    def scenario(self, unit: Floats) -> str:
        """A scenario in YAML that flies a point (dimension,)."""
        return scenario_text(self._case, self.values(unit), "a point of the campaign")
