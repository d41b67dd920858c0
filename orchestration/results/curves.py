"""The curves of a panel in its unit, and what is marked beside them: the same for a figure and for a page's plot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..fmu.model import Floats
from ..quantities import ONE, Unit, shown
from ..scenario.figures import FigureEntry, Panel
from ..system.panels import unit_of
from .arrays import Span
from .data import RunData

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#999999")
"""Okabe and Ito's palette, which colour-blind readers can tell apart."""
_CROSSINGS = 6
"""Crossings that are listed one by one."""


@np.errstate(over="ignore")
def curves(result: RunData, reference: str, panel: Panel) -> tuple[Unit, list[tuple[str, Floats]]]:
    """Returns the unit of a panel's axis, and names and values of the curves that the panel draws of one signal."""
    variable = result.variable(reference)
    unit = unit_of(panel, variable)
    factor, offset = (variable.unit or ONE).conversion(unit)
    values = result.rows(reference)
    if panel.measure == "norm":
        named = [(f"|{reference}|", np.sqrt((values * values).sum(axis=1)))]
    elif values.shape[1] == 1:
        named = [(reference, values[:, 0])]
    else:
        block = reference.split(".")[0]
        named = [(f"{block}.{variable.label(i)}", values[:, i]) for i in range(values.shape[1])]
    return unit, [(name, factor * column + offset) for name, column in named]


def axis(text: str, unit: Unit, between: str = ", ") -> str:
    """Returns the label of an axis: what it shows, and the unit if there is one."""
    return f"{text}{between}{unit}" if shown(unit) else text


def window(result: RunData, entry: FigureEntry) -> Span:
    """Returns the times between which a figure shows the run, s."""
    low, high = entry.window or (result.time[0], result.time[-1])
    return float(low), float(high)


def spans(time: Floats, true: NDArray[np.bool_]) -> list[Span]:
    """Returns from when to when something is true of the samples, s; the sample after the last such one ends a span."""
    edges = np.diff(true.astype(np.int8), prepend=0, append=0)
    begins, ends = np.flatnonzero(edges > 0), np.minimum(np.flatnonzero(edges < 0), len(true) - 1)
    return list(zip(time[begins].tolist(), time[ends].tolist(), strict=True))


def crossings(result: RunData, entry: FigureEntry) -> list[float]:
    """Returns when a figure's marked signal changes its sign, s, linear between samples."""
    if not entry.mark:
        return []
    low, high = window(result, entry)
    rows = (result.time >= low) & (result.time <= high)
    time, values = result.time[rows], result[entry.mark][rows]
    before = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0)
    share = values[before] / (values[before] - values[before + 1])
    return (time[before] + share * (time[before + 1] - time[before])).tolist()


def crossings_text(signal: str, times: Sequence[float]) -> str:
    """Returns when a signal is zero, the first times one by one."""
    more = f" and {len(times) - _CROSSINGS} more" if len(times) > _CROSSINGS else ""
    return f"{signal} = 0 at {', '.join(f'{time:.2f} s' for time in times[:_CROSSINGS])}{more}"
