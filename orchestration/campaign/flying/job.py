"""The pilot that flies the runs of a campaign, in this process or in a worker's: from an index, or a point of the unit
cube, to a row.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from uuid import uuid4

import numpy as np

from ...errors import printable
from ...expectations.metrics import Measure, MetricError, MetricObserver
from ...expectations.span import Limits
from ...fmu.model import Floats
from ...quantities import QuantityError
from ...session import flight
from ...session.open import Opened
from ...session.session import Session
from ..drawing.design import Design
from ..drawing.draws import Draws
from ..statistics.verdicts import Requirement
from .functions import Code, functions

OK, FAILED = "ok", "failed"
_REASON_MAX = 2000


@dataclass(frozen=True)
class CheckedRequirement(Requirement):
    """A requirement that fits the metrics and expectations."""

    metric: int | None
    """The place of its metric, or None for an expectation."""
    expectation: str | None
    limits: Limits | None
    """Of the metric, in whose unit its bound is."""
    expected: str
    """The bound in words."""

    @property
    def ends(self) -> tuple[float | None, float | None]:
        """Returns the bound in the metric's unit, low and high; None for none."""
        if self.limits is None:
            return None, None
        low, high = ((end - self.limits.offset) / self.limits.factor for end in (self.limits.low, self.limits.high))
        return low if math.isfinite(low) else None, high if math.isfinite(high) else None

    def met(self, metrics: Sequence[float | None], expectations: Mapping[str, bool]) -> bool:
        """Returns whether a run with these metrics and expectations meets it."""
        if self.expectation is not None:
            return expectations.get(self.expectation, False)
        assert self.metric is not None
        assert self.limits is not None
        value = metrics[self.metric]
        return value is not None and bool(self.limits.met(np.array(value * self.limits.factor + self.limits.offset)))


Cell = float | int | str | bool | None


@dataclass(frozen=True)
class Job:
    """All that a worker needs; it can be sent to one.

    The FMUs themselves go beside it, by the hashes of their contents.
    """

    opened: Opened
    draws: Draws
    design: Design
    measures: tuple[Measure, ...]
    requirements: tuple[CheckedRequirement, ...]
    codes: Mapping[str, Code]

    @property
    def expectations(self) -> list[str]:
        """Returns the names of the scenario's expectations that are evaluated."""
        return [check.expectation.name for check in self.opened.plan.checks]

    @property
    def columns(self) -> list[tuple[str, str]]:
        """Returns names and types of the dataset's columns: `int64`, `double`, `string`, `bool`."""
        return [
            ("index", "int64"),
            ("status", "string"),
            ("reason", "string"),
            ("wall", "double"),
            *((name, "double" if numbers else "string") for name, numbers in self.draws.columns),
            *((measure.metric.name, "double") for measure in self.measures),
            *((f"met: {one.name}", "bool") for one in self.requirements),
            *((f"expect: {name}", "bool") for name in self.expectations),
        ]

    def placed(self, files: Mapping[str, Path]) -> Job:
        """Returns the same with its FMUs in these files, by their hashes."""
        fmus = {name: replace(fmu, path=files[fmu.sha256]) for name, fmu in self.opened.fmus.items()}
        return replace(self, opened=replace(self.opened, fmus=fmus))


class Pilot:
    """Flies the runs of a job, one after the other, on FMUs that stay loaded."""

    def __init__(self, job: Job, anew: bool = False) -> None:
        """`anew`: FMUs are instantiated for each run, since a reset does not bring them back to their first state."""
        self.job, self.name = job, uuid4().hex
        self._functions = functions(dict(job.codes))
        self._nodes = [node for measure in job.measures for node in measure.needed]
        self._session = Session(job.opened, resets=not anew)

    def observers(self) -> list[MetricObserver]:
        """Returns one for each metric, for one run."""
        return [measure.observer(self._functions.get(measure.metric.python or "")) for measure in self.job.measures]

    def fly(self, index: int, point: Floats) -> list[Cell]:
        """Returns a row of the dataset: the run at this point, whose index is as given."""
        begun = perf_counter()
        job = self.job
        try:
            values = job.draws.at(point.tolist())
        except QuantityError as error:
            cells: list[Cell] = [None if not numbers else math.nan for _, numbers in job.draws.columns]
            return self._failed(index, str(error), cells, begun)
        cells = job.draws.cells(values)
        observers = self.observers()
        flown = flight.fly(self._session, job.draws.given(values), observers, self._nodes)
        if flown.reason is not None:
            return self._failed(index, flown.reason, cells, begun)
        try:
            metrics = [None if math.isnan(value := observer.value()) else value for observer in observers]
        except MetricError as error:
            return self._failed(index, str(error), cells, begun)
        expectations = {outcome.name: outcome.passed for outcome in flown.outcomes}
        met = [one.met(metrics, expectations) for one in job.requirements]
        wall = perf_counter() - begun
        return [index, OK, None, wall, *cells, *metrics, *met, *(expectations[name] for name in job.expectations)]

    def _failed(self, index: int, reason: str, cells: Sequence[Cell], begun: float) -> list[Cell]:
        return failed(self.job, index, reason, cells, perf_counter() - begun)

    def resets(self) -> bool:
        """Returns whether a run on reset FMUs gives what the first one gave: flies run 0, then another, then run 0
        again.
        """
        rows = [self.fly(0, np.full(self.job.draws.dimension, where)) for where in (0.5, 0.25, 0.5)]
        names = [name for name, _ in self.job.columns]
        return not differing(names, rows[0], rows[2])

    def close(self) -> None:
        """Ends the FMUs."""
        with suppress(OSError):
            self._session.close()


def failed(job: Job, index: int, reason: str, cells: Sequence[Cell], wall: float) -> list[Cell]:
    """Returns the row of a run that failed."""
    rest: list[Cell] = [None] * (len(job.measures) + len(job.requirements) + len(job.expectations))
    return [index, FAILED, printable(reason)[:_REASON_MAX], wall, *cells, *rest]


def lost(job: Job, index: int, point: Floats, reason: str) -> list[Cell]:
    """Returns the row of a run that ended its worker."""
    try:
        cells: Sequence[Cell] = job.draws.cells(job.draws.at(point.tolist()))
    except QuantityError:
        cells = [None for _ in job.draws.columns]
    return failed(job, index, reason, cells, 0.0)


def differing(columns: Sequence[str], row: Sequence[Cell], other: Sequence[Cell]) -> list[str]:
    """Returns the names of the columns in which two rows of one run differ; the reasons of failures and times count
    not.
    """
    return [
        name
        for name, x, y in zip(columns, row, other, strict=True)
        if name not in ("wall", "reason") and x != y and not (x != x and y != y)
    ]


RunRows = list[list[Cell]]
