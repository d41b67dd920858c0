"""The worst case within what varies: a search that asks for runs where the worst ones before lie.

Two fifths of the runs are spread evenly over the unit cube (scrambled Sobol' points); the worst of these starts a
CMA-ES (Hansen, arXiv:1604.00772; the package `cma`), which adapts the spread of a normal distribution to the runs that
it finds worst. Where it has settled, it starts again from the next worst of the first runs that lies elsewhere. It was
taken since it goes by ranks alone, so that a metric may jump or be infinite, asks for runs in batches, and finds more
in few runs than SciPy's differential evolution: on three functions of 3 and 6 coordinates with 100 to 1000 runs it
found a worse case than as many random runs in 99% of 144 trials, differential evolution in 92%
(tests/orchestration/campaign/bench_search.py).

What a search finds is a case, no probability. It depends on the seed and the batch, not on workers.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
from scipy.stats import qmc

from ..file.analysis import Search
from .metric_function import Floats, MetricFunction
from .sensitivity import _EDGE

_STEP = 0.1
"""Standard deviation with which the search starts, of the cube's side."""


class _Runs:
    """The runs of a search: what it may ask for, and the worst up to now."""

    def __init__(self, section: Search, function: MetricFunction) -> None:
        self.section, self.function = section, function
        self.sign = 1.0 if section.worst == "largest" else -1.0
        ends = np.where(function.bounded, _EDGE, 0.5 * (1.0 - section.within))
        self.low, self.span = ends, 1.0 - 2.0 * ends
        self.count = self.failed = 0
        self.worst, self.at = -math.inf, None
        self.history: list[tuple[int, float | None]] = []

    @property
    def left(self) -> int:
        """Runs that are still to be had; none when nothing can be worse."""
        return 0 if self.worst == math.inf else self.section.runs - self.count

    def badness(self, points: Floats) -> Floats:
        """Returns how bad the runs of points (n, d) of the searched cube are; -inf where a run failed, which is no
        case.
        """
        unit = self.low + self.span * points[:, : self.function.dimension]
        values = self.sign * self.function.fly(unit)[self.section.metric]
        self.count += len(points)
        self.failed += int(np.isnan(values).sum())
        values = np.where(np.isnan(values), -math.inf, values)
        if values.max() > self.worst:
            self.worst, self.at = float(values.max()), unit[values.argmax()]
            self.history.append((self.count, self.sign * self.worst if math.isfinite(self.worst) else None))
        return values


def run(section: Search, function: MetricFunction, seed: int) -> dict[str, Any]:
    """Searches and returns the worst case, for campaign.json."""
    import cma  # here, since it takes half a second to import  # noqa: PLC0415

    runs = _Runs(section, function)
    before = dict(function.reasons)
    d = max(2, function.dimension)  # cma asks for two coordinates; `_Runs` does not look at one too many
    batch = section.batch or max(8, 4 + int(3 * math.log(d)))
    rng = np.random.default_rng(seed)
    count = min(section.runs, max(batch, 2 * section.runs // 5))
    first = qmc.Sobol(d, rng=rng).random_base2(math.ceil(math.log2(count)))[:count]
    starts = _apart(first[np.argsort(-runs.badness(first), kind="stable")])
    spread = runs.worst
    options = {"bounds": [0.0, 1.0], "popsize": batch, "verbose": -9, "tolx": 0.02}
    options |= {"seed": math.nan, "randn": lambda *shape: rng.standard_normal(shape)}  # not NumPy's global numbers
    for restart in itertools.count():
        if runs.left < 2:
            break
        strategy = cma.CMAEvolutionStrategy(starts[restart % len(starts)], _STEP, options)
        while runs.left >= batch and not strategy.stop():
            points = np.array(strategy.ask())
            values = runs.badness(points)
            least = np.abs(values[np.isfinite(values)]).max(initial=0.0)  # a failed run is the last; cma wants a number
            strategy.tell(list(points), list(np.where(np.isfinite(values), -values, 10.0 * least + 1.0)))
        if 0 < runs.left < batch:
            runs.badness(np.array(strategy.ask(runs.left)))
    at = runs.at
    sign = runs.sign
    reasons = {text: more for text, n in function.reasons.items() if (more := n - before.get(text, 0))}
    return {
        "metric": section.metric,
        "worst": section.worst,
        "runs": runs.count,
        "failed": runs.failed,
        "reasons": reasons,
        "value": sign * runs.worst if at is not None and math.isfinite(runs.worst) else None,
        "endless": runs.worst == math.inf,
        "unit_point": None if at is None else at.tolist(),
        "values": None if at is None else function.values(at),
        "scenario": None if at is None else function.scenario(at),
        "spread": {"runs": count, "value": sign * spread if math.isfinite(spread) else None},
        "history": runs.history,
    }


def _apart(points: Floats) -> Floats:
    """Returns those of the points (n, d), the worst first, that lie apart from all worse ones."""
    kept: list[Floats] = []
    for point in points:
        if all(np.abs(point - other).max() > 4.0 * _STEP for other in kept):
            kept.append(point)
    return np.array(kept)
