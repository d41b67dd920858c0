"""Metrics of a run: held against the blocks before it, measured during it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from ..errors import InputError
from ..fmu.model import Floats, Model
from ..foreign import told
from ..quantities import ONE, SECOND, QuantityError, Unit, parse_unit
from ..scenario.metrics import BOUNDS, Metric
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from ..system import signals
from ..system.phases import phases
from ..system.wiring import Node
from .span import Limits, Sight, limits, one_number, sight, window

Function = Callable[[Floats, dict[str, Floats]], float]
"""A metric in Python: of the times (n,) s and the signals by name, (n,) or (n, elements) in the units of their ports.
"""


@dataclass(frozen=True)
class Measure:
    """A metric that fits the blocks."""

    metric: Metric
    unit: Unit
    text: str
    """The metric in words."""
    sight: Sight | None
    """None for a Python function."""
    limits: Limits | None = None
    """Of the bound, where the metric has one; else its unit and the factor into it, without ends."""
    given: tuple[tuple[str, tuple[Node, ...]], ...] = ()
    """The signals of a Python function, and their elements."""

    @property
    def needed(self) -> list[Node]:
        if self.sight is not None:
            return self.sight.needed
        return list(dict.fromkeys(node for _, nodes in self.given for node in nodes))

    def observer(self, function: Function | None = None) -> MetricObserver:
        """Returns what observes one run; `function` is that of a metric in Python."""
        if self.sight is None:
            assert function is not None
            return FunctionObserver(self, function)
        return BoundObserver(self) if self.metric.kind in BOUNDS else StatisticObserver(self)


def prepare(
    places: signals.Places, key: Key, metric: Metric, models: Mapping[str, Model], scenario: Scenario
) -> Measure:
    """Returns a metric held against the blocks; `key` is its place in the file. Raises InputError."""
    kind = metric.kind
    if metric.signal is None:
        given = [
            (str(name), tuple(signals.find(places, (*key, "signals", i), name, models)[1]))
            for i, name in enumerate(metric.signals)
        ]
        with places.naming((*key, "unit")):
            unit = parse_unit(metric.unit) if metric.unit else ONE
        text = f"{metric.python} of {', '.join(map(str, metric.signals))}"
        return Measure(metric, unit, text, None, None, tuple(given))
    seen = sight(places, key, metric, metric.signal, models, scenario.duration, phases(scenario, models))
    if kind in BOUNDS:
        bound = getattr(metric, kind)
        with places.naming((*key, kind, bound.kind)):
            held = limits(metric.signal, seen.variable, bound)
        with places.naming((*key, "unit")):
            unit = _unit(metric.unit, ONE if kind == "share" else SECOND)
        return Measure(metric, unit, f"{_WORDS[kind]} {seen.name} {_is(held)}{window(metric)}", seen, held)
    if seen.variable.type == "enumeration" and kind == "statistic" and metric.statistic not in ("final",):
        message = f"{metric.signal} is {seen.variable.kind} and has no {metric.statistic}"
        raise InputError(places.error((*key, "statistic"), f"{message}; expected share, or statistic: final"))
    if not one_number(seen) and metric.statistic not in ("peak", "maximum", "minimum"):
        message = f"{metric.signal} is {seen.variable.kind}; remedy: one element, or measure: norm"
        raise InputError(places.error((*key, "statistic"), message))
    own = seen.variable.unit or ONE
    with places.naming((*key, "unit")):
        unit = _unit(metric.unit, own)
    none = Limits(unit, *own.conversion(unit), -math.inf, math.inf, False, "")
    return Measure(metric, unit, f"{metric.statistic} of {seen.name}{window(metric)}", seen, none)


_WORDS = {"settles": "time from which to the end", "reaches": "first time at which", "share": "share of time in which"}


def _is(held: Limits) -> str:
    return held.text if held.number else f"= {held.text}"


def _unit(name: str | None, own: Unit) -> Unit:
    if name is None:
        return own
    unit = parse_unit(name)
    if not unit.fits(own):
        raise QuantityError(f"the unit {name!r} does not fit that of the metric, {own}")
    return unit


class MetricObserver(Protocol):
    """Takes in a run piece by piece, and has its number in the end. Where the pieces end changes no bit of it."""

    measure: Measure

    def see(self, time: Floats, columns: Mapping[Node, Floats]) -> None:
        """Takes in the samples that follow those before."""

    def value(self) -> float:
        """Returns the metric in its unit; NaN where there was no sample to look at. Raises MetricError."""


class MetricError(ValueError):
    """A metric in Python raised, or returned no number."""


class _Sighted:
    """The samples that observers of one signal look at."""

    def __init__(self, measure: Measure) -> None:
        assert measure.sight is not None
        assert measure.limits is not None
        self.measure, self.sight, self.limits = measure, measure.sight, measure.limits
        self.samples = 0

    def see(self, time: Floats, columns: Mapping[Node, Floats]) -> None:
        if not len(time):
            return
        _, chosen = self.sight.chosen(time, columns)
        if not chosen.all():
            if not chosen.any():
                return
            time, columns = time[chosen], {node: columns[node][chosen] for node in self.sight.nodes}
        self.samples += len(time)
        self._take(time, self.sight.values(columns, self.limits.factor, self.limits.offset))

    def _take(self, time: Floats, values: Floats) -> None:
        raise NotImplementedError


class StatisticObserver(_Sighted):
    """The observer of `statistic`."""

    _sum = 0.0
    _low, _high = math.inf, -math.inf
    _final = math.nan

    def _take(self, time: Floats, values: Floats) -> None:
        kind = self.measure.metric.statistic
        if kind in ("mean", "rms"):
            one = values[:, 0]
            summed = np.concatenate(([self._sum], one * one if kind == "rms" else one))
            self._sum = float(np.add.accumulate(summed)[-1])  # in order, so the same however the run is cut
        elif kind == "final":
            self._final = float(values[-1, 0])
        else:
            self._low, self._high = min(self._low, float(values.min())), max(self._high, float(values.max()))

    def value(self) -> float:
        if not self.samples:
            return math.nan
        mean = self._sum / self.samples
        return {
            "final": self._final,
            "maximum": self._high,
            "mean": mean,
            "minimum": self._low,
            "peak": max(abs(self._low), abs(self._high)),
            "rms": math.sqrt(max(mean, 0.0)),
        }[str(self.measure.metric.statistic)]


class BoundObserver(_Sighted):
    """The observer of `settles`, `reaches` and `share`; a sample meets the bound where all of its elements do."""

    _since: float | None = None
    """From when on the bound has been met up to now, s."""
    _first = math.inf
    _met = 0

    def _take(self, time: Floats, values: Floats) -> None:
        met = self.limits.met(values).all(axis=1)
        self._met += int(met.sum())
        if self._first == math.inf and met.any():
            self._first = float(time[met.argmax()])
        outside = np.flatnonzero(~met)
        if not len(outside):
            self._since = float(time[0]) if self._since is None else self._since
        else:
            last = outside[-1] + 1
            self._since = float(time[last]) if last < len(time) else None

    def value(self) -> float:
        if not self.samples:
            return math.nan
        kind, unit = self.measure.metric.kind, self.measure.unit
        if kind == "share":
            return self._met / self.samples / unit.factor
        seconds = self._first if kind == "reaches" else math.inf if self._since is None else self._since
        return seconds / unit.factor


class FunctionObserver:
    """The observer of a function in Python; it keeps what it is shown up to the end of the run."""

    def __init__(self, measure: Measure, function: Function) -> None:
        self.measure, self._function = measure, function
        self._time: list[Floats] = []
        self._values: list[Floats] = []

    def see(self, time: Floats, columns: Mapping[Node, Floats]) -> None:
        self._time.append(np.array(time))
        self._values.append(np.column_stack([columns[node] for node in self.measure.needed]))

    def value(self) -> float:
        place = {node: i for i, node in enumerate(self.measure.needed)}
        values = np.concatenate(self._values)
        given: dict[str, Any] = {}
        for name, nodes in self.measure.given:
            columns = values[:, [place[node] for node in nodes]]
            given[name] = columns[:, 0] if len(nodes) == 1 else columns
        called = self.measure.metric.python
        try:
            number = float(self._function(np.concatenate(self._time), given))
        except BaseException as error:  # sys.exit in it would end the worker
            raise MetricError(f"{self.measure.metric.name}: {called} raised {told(error)}") from None
        if math.isnan(number):
            raise MetricError(f"{self.measure.metric.name}: {called} returned nan; expected a number")
        return number
