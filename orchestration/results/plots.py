"""What the plots of a page show, as data: curves, limits, spans and marks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..fmu.model import Floats, Variable
from ..quantities import ONE, QuantityError, Unit, value_in
from ..quantities import shown as unit_behind
from ..scenario.figures import FigureEntry, Panel
from ..system import acting
from .arrays import MARKS, Arrays, Span, few, kept
from .curves import axis, crossings, curves, spans, window
from .data import RunData

ROWS = 5000
"""Rows that a plot of the scenario's figures keeps, about."""
FEWER = 1200
"""The same for a plot of any other signal."""
CURVES = 12
"""Curves that a plot of any other signal shows at most."""
PLOTS = 200
"""Plots of other signals at most."""


@dataclass
class Curve:
    """A curve of a plot, in the plot's unit."""

    name: str
    values: Floats
    colour: int
    """Its place in the palette."""
    pale: bool = False
    """Wide and pale, for another curve to be drawn over it."""
    stepped: bool = False
    layer: int | None = None
    """Its signal's place where a plot shows several: 0 is wide, and later ones are dashed, so that none hides another.
    """


@dataclass
class Group:
    """A signal that no figure of the scenario shows: its plot, or the one value that it has."""

    name: str
    description: str
    plot: dict[str, Any] | None
    constant: str = ""
    note: str = ""
    expected: bool = False
    """Whether an expectation looks at it."""


def of_panel(
    result: RunData, entry: FigureEntry, panel: Panel, arrays: Arrays, over: RunData | None = None
) -> dict[str, Any]:
    """Returns the plot of a figure's panel; `over` is a run of the same scenario whose curves are drawn over these."""
    shown = window(result, entry)
    drawn: list[Curve] = []
    others: list[Curve] = []
    variables = list(dict.fromkeys(reference.whole for reference in panel.signals))
    for reference in panel.signals:
        layer = variables.index(reference.whole) if len(variables) > 1 and over is None else None
        unit, named = curves(result, reference, panel)
        theirs = _padded(over, reference, panel, len(result.time)) if over is not None else []
        for i, (label, values) in enumerate(named):
            place = len(drawn)
            name = panel.names[place] if place < len(panel.names) else label
            if i < len(theirs):
                others.append(Curve(f"{name}, theirs", theirs[i], place))
            drawn.append(Curve(name if over is None else f"{name}, ours", values, place, over is not None, layer=layer))
    return {
        **plot(result.time, axis(panel.label or panel.signals[0], unit), [*drawn, *others], arrays, ROWS, shown),
        "unit": unit_behind(unit),
        "scale": panel.scale,
        "lines": [value_in(line, unit) for line in panel.lines],
        "lines_are": panel.lines_are,
        "shade": _shaded(result, entry.shade, shown) if entry.shade else [],
        "marks": crossings(result, entry)[:MARKS],
    }


def _padded(result: RunData, reference: str, panel: Panel, rows: int) -> list[Floats]:
    """Returns a signal's curves with so many rows, gaps where the run is shorter; none where it lacks the signal."""
    if reference not in result:
        return []
    short = [values[:rows] for _, values in curves(result, reference, panel)[1]]
    return [np.concatenate([values, np.full(rows - len(values), np.nan)]) for values in short]


def _shaded(result: RunData, flag: str, shown: Span) -> list[Span]:
    """Returns when a boolean signal is true within the times that are shown."""
    low, high = shown
    found = spans(result.time, result[flag].ravel())
    return few([(max(a, low), min(b, high)) for a, b in found if a <= high and b >= low])


def faulty(result: RunData) -> list[Span]:
    """Returns when the scenario's faults act."""
    end = float(result.time[-1])
    spans = [
        (fault.at, end if fault.until is None else min(fault.until, end)) for fault in acting.faults(result.scenario)
    ]
    return [(a, b) for a, b in spans if a < b]


def others(result: RunData, arrays: Arrays, shown: Iterable[str] = ()) -> tuple[list[Group], int]:
    """Returns a group for each recorded variable that is not among those shown, and how many there are too many."""
    skipped = set(shown)
    names = list(dict.fromkeys(f"{node.block}.{node.element.variable}" for node in result.columns))
    names = [name for name in names if name not in skipped]
    end = float(result.time[-1])
    held = few([(a, end if b is None else b) for hold in result.holds for a, b in hold.spans])
    groups = []
    plots = 0
    for name in names:
        if plots == PLOTS:
            break
        groups.append(_group(result, name, arrays, held))
        plots += groups[-1].plot is not None
    return groups, len(names) - len(groups)


def _group(result: RunData, name: str, arrays: Arrays, held: list[Span]) -> Group:
    variable = result.variable(name)
    unit = variable.display_unit or variable.unit or ONE
    factor, offset = (variable.unit or ONE).conversion(unit)
    block = name.split(".")[0]
    nodes = [n for n in result.columns if n.block == block and n.element.variable == variable.name]
    labels = [variable.label(n.element.position) for n in nodes]
    values = np.column_stack([factor * result.column(node) + offset for node in nodes])
    if (values[0] == values).all():
        return Group(name, variable.description, None, _constant(variable, values[0], unit))
    named = list(zip(labels, values.T[:CURVES], strict=False))
    lines: list[float] = []
    expected = any(expectation.signal.whole == name for expectation in result.scenario.expect)
    rows = ROWS if expected and not result.scenario.figures else FEWER
    for expectation in result.scenario.expect:
        if expectation.always is None or variable.type == "boolean" or expectation.signal.whole != name:
            continue
        if expectation.measure == "norm" and len(nodes) == variable.size and named[-1][0] != f"|{variable.name}|":
            named.append((f"|{variable.name}|", np.sqrt(((values - offset) ** 2).sum(axis=1))))
        lines += _bounds(expectation.always, variable, unit)
    stepped = variable.type != "real"
    drawn = [Curve(label, column, i, stepped=stepped) for i, (label, column) in enumerate(named)]
    shown = {
        **plot(result.time, axis(variable.name, unit), drawn, arrays, rows),
        "unit": unit_behind(unit),
        "lines": list(dict.fromkeys(lines)),
        "shade": held,
    }
    left = len(labels) - CURVES
    note = f"{left} more elements are not drawn" if left > 0 else ""
    return Group(name, variable.description, shown, note=note, expected=expected)


def plot(
    time: Floats, label: str, drawn: Sequence[Curve], arrays: Arrays, rows: int, shown: Span | None = None
) -> dict[str, Any]:
    """Returns a plot with its curves, of which it keeps about so many rows."""
    low, high = shown or (float(time[0]), float(time[-1]))
    part = slice(int(np.searchsorted(time, low)), int(np.searchsorted(time, high, side="right")))
    values, time = np.column_stack([curve.values[part] for curve in drawn]), time[part]
    chosen = kept(values, rows)
    return {
        "label": label,
        "range": [low, high],
        "x": arrays.add(time[chosen]),
        "curves": [
            {
                "name": curve.name,
                "y": arrays.add(values[chosen, i]),
                "colour": curve.colour,
                "pale": curve.pale,
                "stepped": curve.stepped,
                **({} if curve.layer is None else {"layer": curve.layer}),
            }
            for i, curve in enumerate(drawn)
        ],
        "lines": [],
        "shade": [],
        "marks": [],
        "thinned": len(chosen) < len(time),
    }


def _bounds(bound: Any, variable: Variable, unit: Unit) -> list[float]:
    """Returns the numbers of a bound in the plot's unit; none of what is no number."""
    value = getattr(bound, bound.kind)
    factor, offset = (variable.unit or ONE).conversion(unit)
    ends = list(value) if isinstance(value, list) else [value]
    try:
        numbers = [value_in(v, unit) if isinstance(v, str) else factor * value_in(v, ONE) + offset for v in ends]
    except QuantityError:
        return []
    return [-numbers[0], numbers[0]] if bound.kind == "within" and len(numbers) == 1 else numbers


def _constant(variable: Variable, values: Floats, unit: Unit) -> str:
    items = {number: item for item, number in variable.items}

    def one(value: float) -> str:
        if variable.type == "boolean":
            return "true" if value else "false"
        return items.get(int(value), f"{value:.6g}") if items and np.isfinite(value) else f"{value:.6g}"

    text = ", ".join(one(value) for value in values[:CURVES].tolist()) + (", ..." if len(values) > CURVES else "")
    return axis(text if len(values) == 1 else f"[{text}]", unit, " ")
