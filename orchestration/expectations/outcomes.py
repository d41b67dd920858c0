"""A run held against an expectation.

Longer than 250 lines: outcome, key figures and settling are taken from the same samples in one pass.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..fmu.model import Floats
from ..quantities import shown, with_unit
from ..scenario.expectations import Expectation
from ..scenario.timeline import either
from ..system.clock import slack
from ..system.wiring import Node
from .checks import Check, changes_of_sign


@dataclass(frozen=True)
class Outcome:
    """The outcome of an expectation. `margin` is positive where the bound is met; both are in `unit`."""

    name: str
    signal: str
    expected: str
    passed: bool
    found: float | str | None
    """The worst value for `always`, the best one for `ever`, the count for `zeros`; None without a sample.

    That of an enumeration is the name of its item, and that of the signal of `phases` the name of its phase, where it
    has one of that number.
    """
    unit: str
    margin: float | None
    time: float | None
    """When it has this value, s."""
    samples: int
    note: str = ""
    open: bool = False
    """Whether the run ended before this could be decided."""

    @property
    def status(self) -> str:
        """`met`, `failed`, or `not reached` where there was no sample, or the run ended too early to decide."""
        return "met" if self.passed else "failed" if self.samples and not self.open else "not reached"

    @property
    def text(self) -> str:
        """Returns the value that decides, and when it occurred."""
        if self.found is None:
            return self.note
        if isinstance(self.found, str):
            value = self.found
        elif self.expected.endswith((" true", " false")):
            value = str(bool(self.found)).lower()
        else:
            value = with_unit(self.found, self.unit)
        if self.expected.startswith("always") and self.passed and self.margin is None:
            return value  # at all times
        return value if self.time is None else f"{value} at {self.time:.5g} s"


@dataclass(frozen=True)
class NotEvaluated(Outcome):
    """An expectation that the run cannot be held against, since a swapped block lacks what it reads."""

    @property
    def status(self) -> str:
        return "not evaluated"


def not_evaluated(expectation: Expectation, reason: str) -> NotEvaluated:
    """Returns the outcome of an expectation that could not be looked at; it counts neither as met nor as failed."""
    how = "always" if expectation.always else "ever"
    bound = expectation.always or expectation.ever
    value = getattr(bound, bound.kind) if bound else None
    text = f"[{', '.join(map(str, value))}]" if isinstance(value, list) else str(value)
    text = text.lower() if isinstance(value, bool) else text
    expected = f"{how} {bound.kind} {text}" if bound else changes_of_sign(expectation.zeros or 0)
    return NotEvaluated(expectation.name, _signal(expectation), expected, False, None, "", None, None, 0, reason)


@dataclass(frozen=True)
class Highlight:
    """The key figures of a signal: its value at the end and that of largest magnitude; of a vector, by its largest
    element.
    """

    signal: str
    unit: str
    final: float
    peak: float
    time: float
    """When the peak is, s."""

    @property
    def text(self) -> str:
        """Returns the peak and its time."""
        return f"{with_unit(self.peak, self.unit)} at {self.time:.5g} s"


@dataclass(frozen=True)
class Settled:
    """Course of a signal until it keeps the bound of an expectation that says `always`, over the whole run."""

    signal: str
    expected: str
    unit: str
    time: float | None
    """From which on each step keeps it, s; None where the last one does not."""
    rms: float
    """From then on, of the norm of a vector; nan where it does not keep it."""
    largest: float

    @property
    def texts(self) -> tuple[str, str, str]:
        """Returns since when, and rms and largest value from then on."""
        if self.time is None:
            return "not at the end", "", ""
        return f"{self.time:.5g} s", with_unit(self.rms, self.unit), with_unit(self.largest, self.unit)


class ExpectationObserver:
    """Takes in an expectation's signal piece by piece, and has its outcome in the end."""

    def __init__(self, check: Check) -> None:
        self.check = check
        self._samples = 0
        self._inside = False
        """Whether a sample lay in the span of time, whatever `when` says."""
        self._worst: tuple[float, float, float] | None = None
        """Of the sample that decides: margin, value and time."""
        self._sign = 0.0
        self._changes = 0
        self._changed: float | None = None
        self._final = 0.0
        self._now = -math.inf
        """The time of the last sample, s."""
        self._peak: tuple[float, float] | None = None
        """The value of largest magnitude, and its time."""
        self._broken = False
        """Whether a sample of the whole run broke the bound."""
        self._since: float | None = None
        """The first sample after the last one that did."""
        self._sum, self._count_since, self._largest = 0.0, 0, 0.0

    def see(self, time: Floats, columns: Mapping[Node, Floats]) -> None:
        """Takes in the samples that follow those before."""
        if not len(time):
            return
        self._now = float(time[-1])
        check = self.check
        values = check.sight.values(columns, check.limits.factor, check.limits.offset)
        self._highlight(time, values)
        if check.expectation.always is not None and check.limits.number:
            self._settle(time, values)
        inside, chosen = check.sight.chosen(time, columns)
        self._inside |= inside
        if chosen.any():
            self._samples += (samples := int(np.count_nonzero(chosen)))
            if samples < len(time):
                time, values = time[chosen], values[chosen]
            (self._bound if check.expectation.zeros is None else self._count)(time, values)

    def _bound(self, time: Floats, values: Floats) -> None:
        check, always = self.check, self.check.expectation.always is not None
        margins = check.limits.margins(values)
        worst = margins.argmin(axis=1)
        of_sample = margins[np.arange(len(time)), worst]  # a sample is as good as its worst element
        sample = int(of_sample.argmin() if always else of_sample.argmax())
        margin = float(of_sample[sample])
        if self._worst is None or (margin < self._worst[0] if always else margin > self._worst[0]):
            self._worst = margin, float(values[sample, worst[sample]]), float(time[sample])

    def _count(self, time: Floats, values: Floats) -> None:
        signs = np.sign(values[:, 0])
        some = signs != 0.0
        signs = np.concatenate(([self._sign or 0.0], signs[some]))
        changes = np.flatnonzero(signs[1:] * signs[:-1] < 0.0)
        self._changes += len(changes)
        if len(changes) and self._changed is None:
            self._changed = float(time[some][changes[0]])
        self._sign = float(signs[-1])

    def _settle(self, time: Floats, values: Floats) -> None:
        margins = self.check.limits.margins(values).min(axis=1)
        broken = np.flatnonzero(~(margins > 0.0 if self.check.limits.strict else margins >= 0.0))
        if len(broken):
            self._broken, self._since = True, None
            self._sum, self._count_since, self._largest = 0.0, 0, 0.0
            time, values = time[broken[-1] + 1 :], values[broken[-1] + 1 :]
        if len(time):
            squares = np.einsum("ij,ij->i", values, values)
            self._since = float(time[0]) if self._since is None else self._since
            self._sum, self._count_since = self._sum + float(squares.sum()), self._count_since + len(time)
            self._largest = max(self._largest, float(np.sqrt(squares.max())))

    @property
    def settled(self) -> Settled | None:
        """Returns since when the bound is kept; None where it always was, or where it is none for a number."""
        if not self._broken:
            return None
        unit, n = shown(self.check.limits.unit), self._count_since
        rms = math.sqrt(self._sum / n) if n else math.nan
        signal = _signal(self.check.expectation)
        return Settled(signal, self.check.expected, unit, self._since, rms, self._largest if n else math.nan)

    def _highlight(self, time: Floats, values: Floats) -> None:
        largest = values[:, 0]
        if values.shape[1] > 1:
            largest = values[np.arange(len(time)), np.abs(values).argmax(axis=1)]
        peak = int(np.abs(largest).argmax())
        self._final = float(largest[-1])
        if self._peak is None or abs(largest[peak]) > abs(self._peak[0]):
            self._peak = float(largest[peak]), float(time[peak])

    def outcome(self, early: bool = False) -> Outcome:
        """Returns the outcome of the samples up to now. `early` says that the run ended before its time.

        What the rest of the run could still have changed is open then.
        """
        outcome = self._outcome()
        before = self.check.expectation.before
        if not early or (before is not None and self._now >= before - slack(before)):
            return outcome
        if self.check.expectation.zeros is not None:
            decided = self._changes > self.check.expectation.zeros
        else:
            # One sample decides: against `always`, or for `ever`.
            decided = bool(self._samples) and outcome.passed == (self.check.expectation.ever is not None)
        return outcome if decided else replace(outcome, passed=False, open=True)

    def _outcome(self) -> Outcome:
        check, expectation, samples = self.check, self.check.expectation, self._samples
        if not samples:
            never = self._inside and _never(expectation)
            return _outcome(check, False, None, None, None, 0, never or "no sample lies in this span of time")
        if expectation.zeros is not None:
            if self._sign == 0.0:
                return _outcome(check, False, None, None, None, samples, "always 0, so it has no sign")
            passed = self._changes == expectation.zeros
            return _outcome(check, passed, float(self._changes), None, self._changed, samples)
        assert self._worst is not None
        margin, value, time = self._worst
        limits = check.limits
        passed = margin > 0.0 if limits.strict else margin >= 0.0
        found = check.items.get(value, value)
        return _outcome(check, passed, found, margin if limits.low != limits.high else None, time, samples)

    @property
    def highlight(self) -> Highlight | None:
        """Returns the signal's final and peak values; None for what is no number."""
        if self._peak is None or not self.check.limits.number:
            return None
        return Highlight(_signal(self.check.expectation), shown(self.check.limits.unit), self._final, *self._peak)


def _outcome(
    check: Check,
    passed: bool,
    value: float | str | None,
    margin: float | None,
    time: float | None,
    samples: int,
    note: str = "",
) -> Outcome:
    expectation = check.expectation
    unit = "" if expectation.zeros is not None else shown(check.limits.unit)
    return Outcome(
        expectation.name, _signal(expectation), check.expected, passed, value, unit, margin, time, samples, note
    )


def highlights(observers: Iterable[ExpectationObserver]) -> list[Highlight]:
    """Returns final and peak values of the numbers that the expectations look at, each once."""
    by_signal: dict[str, Highlight] = {}
    for observer in observers:
        if (highlight := observer.highlight) is not None:
            by_signal.setdefault(highlight.signal, highlight)
    return list(by_signal.values())


def settlings(observers: Iterable[ExpectationObserver]) -> list[Settled]:
    """Returns since when signals keep the bounds that they broke before, each once."""
    found = (observer.settled for observer in observers)
    return list({(one.signal, one.expected): one for one in found if one is not None}.values())


def _never(expectation: Expectation) -> str:
    """Returns why no sample of the window is looked at."""
    if expectation.during is None:
        return f"{expectation.when} is never true"
    condition = f" at which {expectation.when} is true" if expectation.when else ""
    return f"there is no sample in the phase {either(expectation.during)}{condition}"


def _signal(expectation: Expectation) -> str:
    return f"|{expectation.signal}|" if expectation.measure == "norm" else expectation.signal
