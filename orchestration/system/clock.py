"""Time as a count of steps: every instant is n times the step, rounded once, never a sum."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ..errors import InputError
from ..fmu.model import Floats
from ..scenario.scenario import Scenario
from ..scenario.types import cycles

EXACT = 2**53
"""Whole numbers below it are exact as doubles."""
_MEMORY = 64 * 10**9
"""Bytes that a recording may take where the system does not tell how much memory there is."""
_SLOW_SAMPLES = 10**7
"""So many times can be computed where their step has too many digits for doubles."""


@dataclass(frozen=True)
class Clock:
    """`step` = `numerator / denominator` s exactly as written in decimals, so 3 steps of 0.1 s end at 0.3 s."""

    numerator: int
    denominator: int
    steps: int
    interval: int
    """Steps from sample to sample."""

    @property
    def step(self) -> float:
        return self.numerator / self.denominator

    def time(self, count: int) -> float:
        return count * self.numerator / self.denominator

    @property
    def samples(self) -> int:
        """The most samples of a run: after every interval, and at its end, which may come at any step."""
        return self.steps // self.interval + 1 + (self.interval > 1)

    def times(self, first: int, count: int, apart: int = 1) -> Floats:
        """The times of `count` instants from step `first` on, so many steps apart."""
        if (first + count * apart) * self.numerator < EXACT and self.denominator < EXACT:
            # Quotients of whole numbers that doubles hold exactly are rounded once.
            return np.arange(first, first + count * apart, apart, dtype=np.int64) * self.numerator / self.denominator
        whole = range(first, first + count * apart, apart)
        return np.fromiter((self.time(n) for n in whole), np.float64, count)

    def sample_times(self) -> Floats:
        """The times of the samples after whole intervals."""
        return self.times(0, self.steps // self.interval + 1, self.interval)


def clock(scenario: Scenario) -> tuple[Clock, list[str]]:
    """Counts of a scenario's times, and notes on them. Raises InputError where they do not divide."""
    step = Fraction(repr(scenario.step))
    steps, exact = steps_to(scenario, scenario.duration)
    notes = []
    # One that is counted in cycles seldom is a multiple, and is not meant to be.
    if not exact and cycles(scenario.source.data["duration"], scenario.source.data) is None:
        end = f"the run ends at {float(steps * step):.10g} s"
        notes.append(f"{scenario.duration:.10g} s is no multiple of the step, {scenario.step:.10g} s; {end}")
    if steps >= EXACT:
        message = f"{scenario.duration:.10g} s are more than {EXACT:.1g} steps of {scenario.step:.6g} s"
        raise InputError(scenario.error(("duration",), message))
    if not steps:
        message = f"expected at least one step, {scenario.step:.10g} s, found {scenario.duration:.10g} s"
        raise InputError(scenario.error(("duration",), message))
    asked = scenario.record.interval or scenario.step
    interval = whole(Fraction(repr(asked)) / step)
    if not interval:
        message = f"expected a multiple of the base step, {scenario.step:.10g} s, found {asked:.10g} s"
        raise InputError(scenario.error(("record", "interval"), f"{message}; nearest: {multiples_near(asked, step)}"))
    if interval > steps:
        message = f"expected at most the duration, {scenario.duration:.10g} s, found {asked:.10g} s"
        raise InputError(scenario.error(("record", "interval"), message))
    for name, entry in scenario.blocks.items():
        if entry.every > steps:
            message = f"{name} would never be stepped: the run has only {steps} base step{'s' if steps > 1 else ''}"
            raise InputError(scenario.error(("blocks", name, "every"), message))
    return Clock(step.numerator, step.denominator, steps, interval), notes


def steps_to(scenario: Scenario, time: float) -> tuple[int, bool]:
    """The count of base steps at a time, but for rounding; else the first after it, and False."""
    ratio = Fraction(repr(time)) / Fraction(repr(scenario.step))
    count = whole(ratio)
    return (math.ceil(ratio), False) if count is None else (count, True)


def check_size(scenario: Scenario, clock: Clock, columns: int) -> None:
    """Refuses a recording that this machine cannot hold. Raises InputError."""
    size = 8 * clock.samples * (columns + 1)
    try:
        memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        memory = _MEMORY
    if size > memory:
        message = f"the recording of {clock.samples:.4g} samples would take {size / 1e9:.3g} GB"
    elif clock.samples > _SLOW_SAMPLES and max(clock.steps * clock.numerator, clock.denominator) >= EXACT:
        message = f"a step of so many digits, {scenario.step!r} s, allows no more than {_SLOW_SAMPLES} samples"
    else:
        return
    raise InputError(scenario.error(("duration",), f"{message}; remedy: a longer record.interval, or fewer signals"))


def slack(time: float | Floats) -> Floats:
    """By how much an instant may lie beside a time and still be taken for it, s: for rounding."""
    return 1e-9 * np.maximum(1.0, np.abs(time))


def whole(ratio: Fraction) -> int | None:
    """The whole number that the ratio is, but for rounding."""
    nearest = round(ratio)
    return nearest if abs(ratio - nearest) <= Fraction(1, 10**9) * max(1, nearest) else None


def multiples_near(time: float, step: Fraction) -> str:
    """The multiples of a step on either side of a time, in words: "0.2 s or 0.3 s"."""
    low = max(1, math.floor(Fraction(repr(time)) / step))
    return " or ".join(f"{float(n * step):.10g} s" for n in (low, low + 1))
