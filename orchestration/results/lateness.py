"""What a report shows of a run in real time: figures, a histogram of the lateness, and the lateness over time."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..fmu.model import Floats
from ..master.deadlines import Pace, milliseconds
from .arrays import Arrays
from .plots import ROWS, Curve, plot

_LABELS = 8
"""Edges of the histogram's bins that are labelled, about."""
_SMALLEST = 1e-6
"""The first edge above zero, s."""
_NAMES = {
    "lateness": "lateness (to the end of the wait)",
    "jitter": "jitter (of the time from instant to instant)",
    "step": "base step without the wait",
}


def figures(pace: Pace) -> list[list[str]]:
    """Returns rows of a table: p50, p99, p99.9 and the largest."""
    return [[_NAMES[name], *map(milliseconds, values.values())] for name, values in pace.figures.items()]


def facts(pace: Pace) -> list[str]:
    """Returns what was asked for and what came of it, in sentences."""
    steps, late, overruns = len(pace.lateness), pace.late_steps, pace.overruns
    told = [
        f"factor {pace.factor:g}: a base step of {pace.clock.step:.6g} s has {milliseconds(pace.period)}",
        f"{late} of {steps} steps late, which is more than {milliseconds(pace.tolerance)} after they were due;"
        f" after a late step the run {'ends' if pace.stop else 'goes on'}",
        f"{overruns} overrun{'s' * (overruns != 1)}: steps that took longer than a base step has",
    ]
    if slowest := ", ".join(f"{name} {milliseconds(took)} at {at:.6g} s" for name, (took, at) in pace.slowest.items()):
        told.append(f"longest step of each block: {slowest}")
    if pace.moved:
        told.append(f"paused for {pace.paused:.3g} s, {pace.single_steps} single steps; the deadlines were moved")
    return told


def edges(values: Floats) -> Floats:
    """Returns edges of bins 1, 2, 5, 10, ... in s that hold all the values; smaller ones too, from 0 on."""
    sequence = [_SMALLEST * 10.0**power * m for power in range(12) for m in (1.0, 2.0, 5.0)]
    last = next(i for i, edge in enumerate(sequence) if edge > values.max() or i == len(sequence) - 1)
    first = max((i for i, edge in enumerate(sequence[:last]) if edge <= values.min()), default=None)
    return np.array([0.0, *sequence[: last + 1]] if first is None else sequence[first : last + 1])


def histogram(pace: Pace, arrays: Arrays) -> dict[str, Any]:
    """Returns the plot of how many base steps have a lateness between two edges."""
    values = np.clip(pace.lateness, 0.0, None)
    bounds = edges(values)
    counts = np.histogram(values, [*bounds[:-1], np.inf])[0]
    place = np.arange(len(bounds), dtype=np.float64)
    every = -(-len(bounds) // _LABELS)
    names = [_edge(edge) if i % every == 0 else "" for i, edge in enumerate(bounds.tolist())]
    curve = Curve("base steps", np.append(counts, 0.0), 0, stepped=True)
    shown = plot(place, "base steps", [curve], arrays, len(bounds))
    shown["curves"][0]["bare"] = True
    return {**shown, "xlabel": "lateness", "xname": "from", "items": names}


def over_time(pace: Pace, arrays: Arrays) -> dict[str, Any]:
    """Returns the plot of each base step's lateness."""
    curve = Curve("lateness", 1e3 * np.array(pace.lateness), 0)
    shown = plot(pace.times, "lateness, ms", [curve], arrays, ROWS)
    return {**shown, "lines": [1e3 * pace.tolerance], "lines_are": "tolerance"}


def _edge(edge: float) -> str:
    if edge >= 1.0:
        return f"{edge:.3g} s"
    return f"{1e3 * edge:.3g} ms" if edge >= 1e-3 else f"{1e6 * edge:.3g} us"
