"""Time as a count of steps: every instant is n times the step, rounded once, never a sum."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from .block import Floats
from .errors import InputError
from .scenario import Scenario


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
        return self.steps // self.interval + 1

    def sample_times(self) -> Floats:
        tick, exact = self.interval * self.numerator, 2**53
        if tick * self.samples < exact and self.denominator < exact:
            return np.arange(self.samples, dtype=np.int64) * tick / self.denominator
        return np.array([n * tick / self.denominator for n in range(self.samples)])


def clock(scenario: Scenario) -> tuple[Clock, list[str]]:
    """Counts of a scenario's times, and what is to be said of them. Raises InputError where they do not divide."""
    step = Fraction(repr(scenario.step))
    steps = _whole(Fraction(repr(scenario.duration)) / step)
    notes = []
    if steps is None:
        steps = math.ceil(Fraction(repr(scenario.duration)) / step)
        end = float(steps * step)
        notes.append(
            f"{scenario.duration:.10g} s is no multiple of the step, {scenario.step:.10g} s; the run ends at {end:.10g} s"
        )
    interval = scenario.record.interval or scenario.step
    every = _whole(Fraction(repr(interval)) / step)
    if not every:
        low = max(1, math.floor(Fraction(repr(interval)) / step))
        near = " or ".join(f"{float(n * step):.10g} s" for n in (low, low + 1))
        key = ("record", "interval")
        message = (
            f"expected a multiple of the base step, {scenario.step:.10g} s, found {interval:.10g} s; nearest: {near}"
        )
        raise InputError(scenario.error(key, message))
    if every > steps:
        message = f"expected at most the duration, {scenario.duration:.10g} s, found {interval:.10g} s"
        raise InputError(scenario.error(("record", "interval"), message))
    for name, entry in scenario.blocks.items():
        if entry.every > steps:
            message = f"{name} would never be stepped: the run has only {steps} base step{'s' if steps > 1 else ''}"
            raise InputError(scenario.error(("blocks", name, "every"), message))
    return Clock(step.numerator, step.denominator, steps, every), notes


def _whole(ratio: Fraction) -> int | None:
    """The whole number that the ratio is, but for rounding."""
    nearest = round(ratio)
    return nearest if abs(ratio - nearest) <= Fraction(1, 10**9) * max(1, nearest) else None
