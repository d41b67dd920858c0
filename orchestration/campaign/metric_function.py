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
from .statistics.metric_function import MetricFunction


def of_campaign(case: Case, crew: Crew) -> MetricFunction:
    """Returns the metric function of runs that a crew flies.

    Each coordinate is uniform in [0, 1) under the campaign's distributions.
    """
    job, draws = case.job, case.job.draws
    names = [measure.metric.name for measure in job.measures]
    columns = [name for name, _ in job.columns]
    first = columns.index(names[0]) if names else 0
    reasons: dict[str, int] = {}

    def fly(points: Floats) -> dict[str, Floats]:
        metrics = np.full((len(points), len(names)), np.nan)
        for flown in crew.fly(Batches(np.arange(len(points)), lambda chosen: points[chosen], crew.slots)):
            for row in flown.rows:
                cells: Any = row[first : first + len(names)]
                metrics[int(row[0] or 0)] = [np.nan if cell is None else cell for cell in cells]
                if row[1] != OK:
                    reasons[str(row[2])] = reasons.get(str(row[2]), 0) + 1
        return {name: metrics[:, i] for i, name in enumerate(names)}

    def scenario(point: Floats) -> str:
        return scenario_text(case, draws.given(draws.at(point.tolist())), "a point of the campaign")

    return MetricFunction(
        fly,
        values=lambda point: draws.texts(draws.at(point.tolist())),
        scenario=scenario,
        entries=[(draw.name, draw.first, draw.count) for draw in draws.draws if draw.count],
        coordinates=draws.coordinates,
        bounded=[end for d in draws.draws if not isinstance(d.sampler, Expression) for end in d.sampler.bounded],
        metrics={measure.metric.name: str(measure.unit) for measure in job.measures},
        reasons=reasons,
    )
