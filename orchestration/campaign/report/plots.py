"""The plots of a campaign's page as data for results/assets/plots.js: distributions, scatter, a search."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...quantities import with_unit
from ...results.arrays import Arrays
from ..statistics.bounds import fixed, sequence

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]
STEPS = 400
"""Steps of a distribution that are drawn, about."""
DOTS = 2000
"""Runs in a scatter plot, about."""
WORST = 25
"""Worst runs of a metric that every scatter plot keeps."""
_BEYOND = 3.0
"""How far a required bound may lie from the values, in their range, for the axis to reach to it."""
_FEWEST = 10
"""Runs that the plot of a distribution's tail shows at least."""


@dataclass(frozen=True)
class Metric:
    """A metric of all runs, and what is asked of it."""

    name: str
    text: str
    unit: str
    values: Floats
    """nan where a run failed."""
    low: float | None = None
    high: float | None = None
    """The bounds of its requirement."""
    probability: float | None = None
    confidence: float = 0.95
    met: Booleans | None = None
    """Which runs meet its requirement."""

    @property
    def label(self) -> str:
        """Returns the text at an axis."""
        return f"{self.name}, {self.unit}" if self.unit else self.name

    @property
    def lower_is_worse(self) -> bool:
        """Returns whether the requirement asks for large values only."""
        return self.low is not None and self.high is None

    @property
    def badness(self) -> Floats:
        """Returns how bad each run is: its value, less it, or how far it is outside of two bounds; +inf where it
        failed.
        """
        x = self.values
        if self.low is not None and self.high is not None:
            bad = np.maximum(self.low - x, x - self.high)
        else:
            bad = -x if self.lower_is_worse else x
        return np.where(np.isnan(x), np.inf, bad)

    def with_unit(self, value: float) -> str:
        """Returns a value of it."""
        return "never" if value == np.inf else with_unit(value, self.unit)


def plain(label: str, xlabel: str, xname: str, x: Floats, span: tuple[float, float], arrays: Arrays) -> dict[str, Any]:
    """Returns a plot of something over x, without its curves."""
    low, high = span if span[0] < span[1] else (span[0] - 0.5, span[0] + 0.5)
    return {
        "label": label, "xlabel": xlabel, "xname": xname, "range": [low, high], "x": arrays.add(x), "curves": [],
        "lines": [], "shade": [], "marks": [], "thinned": False,
    }  # fmt: skip


def curve(name: str, y: Floats, colour: int, arrays: Arrays, **more: Any) -> dict[str, Any]:
    """Returns a curve of a plot."""
    return {"name": name, "y": arrays.add(y), "colour": colour, "pale": False, "stepped": False, **more}


def distribution(metric: Metric, arrays: Arrays, repeated: bool, tail: bool = False) -> dict[str, Any] | None:
    """Returns the share of all runs up to a value, with bounds; or from a value on, where large ones are wanted.

    `tail` shows what is near the required probability only, and is None where there is none, or too few runs.
    """
    x = metric.values
    n = len(x)
    ordered = np.sort(x[np.isfinite(x)])
    if not len(ordered):
        return None
    above = metric.lower_is_worse
    values, firsts, counts = np.unique(ordered, return_index=True, return_counts=True)
    # Runs up to each value; from it on, with those that never come to an end, where large ones are wanted.
    hits = int((x == np.inf).sum()) + len(ordered) - firsts if above else (x == -np.inf).sum() + firsts + counts
    left = n - hits  # runs that are worse
    if tail:
        if metric.probability is None:
            return None
        near = left <= max(5.0 * (1.0 - metric.probability) * n, _FEWEST + left.min())
        if near.sum() < 3 or near.all():
            return None
        values, hits, left = values[near], hits[near], left[near]
    chosen = _spread(left, len(values))
    values, hits = values[chosen], hits[chosen]
    bounds = [(sequence if repeated else fixed)(int(k), n, metric.confidence) for k in hits]
    ends = [b for b in (metric.low, metric.high) if b is not None]
    reach = (1.0 if tail else _BEYOND) * (float(np.ptp(values)) or abs(float(values[0])) or 1.0)
    inside = [b for b in ends if values[0] - reach <= b <= values[-1] + reach]
    shown = plain(
        f"share of runs {'from a value on' if above else 'up to a value'}", metric.label, metric.name, values,
        (min([values[0], *inside]), max([values[-1], *inside])), arrays,
    )  # fmt: skip
    pale = {"pale": True, "bare": True, "stepped": True}
    shown["curves"] = [
        curve("lower bound", np.array([b.low for b in bounds]), 0, arrays, **pale),
        curve("upper bound", np.array([b.high for b in bounds]), 0, arrays, dashed=True, **pale),
        curve("share", hits / n, 0, arrays, stepped=True),
    ]
    shown["marks"] = inside
    shown["stepped"] = len(chosen) < len(left)  # not all steps are drawn
    if metric.probability is not None:
        shown["lines"], shown["lines_are"] = [metric.probability], "required probability"
    return shown


def bound_notes(metric: Metric, drawn: Sequence[dict[str, Any]]) -> list[str]:
    """Returns the notes on required bounds below a distribution: on those drawn, and on those beyond the axis."""
    ends = [b for b in (metric.low, metric.high) if b is not None]
    marked = [b for b in ends if any(b in plot["marks"] for plot in drawn)]
    beyond = [b for b in ends if b not in marked]
    notes = [f"dotted: {' and '.join(map(metric.with_unit, marked))}, as required"] if marked else []
    return notes + ([f"{' and '.join(map(metric.with_unit, beyond))}, as required, beyond the axis"] if beyond else [])


def _spread(left: NDArray[np.int64], n: int) -> NDArray[np.intp]:
    """Returns which of n steps to draw: evenly spread ones, and all of the tail's last, where the fewest runs are
    worse.
    """
    if n <= STEPS:
        return np.arange(n)
    far = np.argsort(left, kind="stable")[: STEPS // 4]
    return np.unique(np.r_[np.linspace(0, n - 1, STEPS - len(far)).round().astype(int), far])


def shown_runs(metrics: Sequence[Metric], failed: Booleans) -> NDArray[np.intp]:
    """Returns the rows that scatter plots show: all where they are few, else some at random, and the worst of each
    metric.
    """
    n = len(failed)
    if n <= DOTS:
        return np.arange(n)
    rng = np.random.default_rng(0)
    chosen = [rng.choice(n, DOTS, replace=False), rng.permutation(np.flatnonzero(failed))[:WORST]]
    for metric in metrics:
        chosen.append(rng.permutation(np.flatnonzero(np.isinf(metric.values)))[:WORST])
        bad = np.where(np.isfinite(metric.values), metric.badness, -np.inf)
        chosen.append(np.argpartition(bad, n - WORST)[n - WORST :])
    return np.unique(np.concatenate(chosen))


def scatter(
    metric: Metric,
    rows: NDArray[np.intp],
    x: Floats,
    xlabel: str,
    items: list[str] | None,
    index: NDArray[np.int64],
    arrays: Arrays,
) -> dict[str, Any]:
    """Returns a metric against a varied value (of the rows): runs that meet its requirement and others, endless and
    failed ones.
    """
    y = metric.values[rows]
    if items is not None:  # texts: beside each other, spread for the eye
        x = x + np.random.default_rng(0).uniform(-0.25, 0.25, len(x))
    order = np.argsort(x, kind="stable")
    x, y, index = x[order], y[order], index[rows][order]
    met = np.ones(len(y), bool) if metric.met is None else metric.met[rows][order]
    finite = np.isfinite(y)
    low, high = (float(y[finite].min()), float(y[finite].max())) if finite.any() else (0.0, 1.0)
    gap = 0.08 * ((high - low) or abs(high) or 1.0)
    margin = 0.02 * float(np.ptp(x)) if items is None else 0.2
    shown = plain(
        metric.label,
        xlabel,
        xlabel.rpartition(",")[0] or xlabel,
        x,
        (float(x[0]) - margin, float(x[-1]) + margin),
        arrays,
    )
    groups = [
        ("requirement met" if metric.met is not None else "runs", np.where(finite & met, y, np.nan), 0),
        ("requirement not met", np.where(finite & ~met, y, np.nan), 1),
        ("never (at the upper edge)", np.where(np.isposinf(y), high + gap, np.nan), 3),
        ("no value (at the lower edge)", np.where(np.isnan(y), low - gap, np.nan), 7),
    ]  # fmt: skip
    shown["curves"] = [curve(n, v, c, arrays, dots=True) for n, v, c in groups if not np.isnan(v).all()]
    shown["lines"] = [b for b in (metric.low, metric.high) if b is not None and low - gap <= b <= high + gap]
    shown["lines_are"] = "required bound"
    shown["runs"] = arrays.add(index.astype(np.float64))
    if items is not None:
        shown["items"] = items
    return shown


def search(searched: dict[str, Any], metric: Metric, arrays: Arrays) -> dict[str, Any] | None:
    """Returns the worst value up to a number of runs: of the search, and of the campaign's own runs in the order of
    their index.
    """
    history = [(runs, value) for runs, value in searched["history"] if value is not None]
    if not history:
        return None
    sign = 1.0 if searched["worst"] == "largest" else -1.0
    own = sign * metric.values[: searched["runs"]]
    running = np.maximum.accumulate(np.where(np.isfinite(own), own, -np.inf))
    x = np.unique(
        np.r_[[runs for runs, _ in history], searched["runs"], np.flatnonzero(np.diff(running, prepend=-np.inf)) + 1]
    ).astype(float)
    at = np.searchsorted([runs for runs, _ in history], x, side="right")
    worst = np.array([np.nan] + [value for _, value in history])[at]
    drawn = (
        sign * running[np.minimum(x.astype(int), max(len(running), 1)) - 1] if len(running) else np.full(len(x), np.nan)
    )
    drawn = np.where(np.isfinite(drawn) & (x <= len(running)), drawn, np.nan)
    shown = plain(f"{searched['worst']} {metric.label}", "runs", "runs", x, (0.0, float(searched["runs"])), arrays)
    shown["curves"] = [
        curve("search", worst, 1, arrays, stepped=True),
        curve("the campaign's own runs", drawn, 0, arrays, stepped=True),
    ]
    return shown
