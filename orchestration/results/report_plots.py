"""What the plots of report.html show, as data: curves thinned out and packed, limits, spans and marks.

A number goes into the page as four bytes where these tell it well enough for a plot, in base64. Long runs are thinned
out row by row: of every stretch of time the rows stay at which a curve is lowest and highest, so no spike is lost.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..fmu.model import Floats, Variable
from ..quantities import ONE, QuantityError, Unit, value_in
from ..scenario.figures import FigureEntry, Panel
from ..scenario.references import split
from ..system.panels import unit_of
from .data import RunData
from .figures import curves, zero_crossings

ROWS = 5000
"""Rows that a plot of the scenario's figures keeps, about."""
FEWER = 1200
"""The same for a plot of any other signal."""
CURVES = 12
"""Curves that a plot of any other signal shows at most."""
PLOTS = 200
"""Plots of other signals at most."""
MARKS = 400
"""Spans and marks in a plot, about."""
_LARGEST, _SMALLEST = 1e30, 1e-30
"""Beyond the one nothing is drawn; below the other all is zero."""

Span = tuple[float, float]


@dataclass
class Arrays:
    """The arrays of a page, each once."""

    items: list[dict[str, str]] = field(default_factory=list)
    _places: dict[tuple[str, bytes], int] = field(default_factory=dict)

    def add(self, values: NDArray[Any]) -> int:
        """The array's place among all."""
        kind, data = _packed(values)
        place = self._places.setdefault((kind, data), len(self.items))
        if place == len(self.items):
            self.items.append({"type": kind, "data": base64.b64encode(data).decode("ascii")})
        return place


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


def of_panel(result: RunData, entry: FigureEntry, panel: Panel, arrays: Arrays, rows: int = ROWS) -> dict[str, Any]:
    """The plot of a figure's panel."""
    low, high = entry.window or (float(result.time[0]), float(result.time[-1]))
    drawn: list[tuple[str, Floats]] = []
    unit = ONE
    for reference in panel.signals:
        variable = result.variable(reference)
        unit = unit_of(panel, variable)
        factor, offset = (variable.unit or ONE).conversion(unit)
        drawn += [(name, factor * values + offset) for name, values in curves(result, reference, variable, panel)]
    named = [(panel.names[i] if i < len(panel.names) else name, values) for i, (name, values) in enumerate(drawn)]
    lines = [value_in(line, unit) for line in panel.lines]
    return {
        **_plot(result, _with_unit(panel.label or panel.signals[0], unit), named, arrays, rows, (low, high)),
        "lines": lines,
        "shade": shaded(result, entry.shade, (low, high)) if entry.shade else [],
        "marks": crossings(result, entry)[:MARKS],
        "linked": entry.window is None,
    }


def crossings(result: RunData, entry: FigureEntry) -> list[float]:
    """When a figure's marked signal changes its sign, s."""
    if not entry.mark:
        return []
    low, high = entry.window or (result.time[0], result.time[-1])
    rows = (result.time >= low) & (result.time <= high)
    return zero_crossings(result.time[rows], result[entry.mark][rows])


def shaded(result: RunData, flag: str, window: Span) -> list[Span]:
    """When a boolean signal is true."""
    true = result[flag].astype(np.int8).ravel()
    edges = np.diff(true, prepend=0, append=0)
    last = len(true) - 1
    begins, ends = np.flatnonzero(edges > 0), np.minimum(np.flatnonzero(edges < 0), last)
    found = zip(result.time[begins].tolist(), result.time[ends].tolist(), strict=True)
    return _few([(max(a, window[0]), min(b, window[1])) for a, b in found if a <= window[1] and b >= window[0]])


def faulty(result: RunData) -> list[Span]:
    """When the scenario's faults act."""
    end = float(result.time[-1])
    spans = [(fault.at, end if fault.until is None else min(fault.until, end)) for fault in result.scenario.faults]
    return [(a, b) for a, b in spans if a < b]


def others(result: RunData, arrays: Arrays, shown: Iterable[str] = ()) -> tuple[list[Group], int]:
    """A group for each recorded variable that is not among those shown, and how many there are too many."""
    skipped = set(shown)
    names = list(dict.fromkeys(f"{node.block}.{node.element.variable}" for node in result.columns))
    names = [name for name in names if name not in skipped]
    end = float(result.time[-1])
    held = _few([(a, end if b is None else b) for hold in result.holds for a, b in hold.spans])
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
    expected = any(_means(expectation.signal, name) for expectation in result.scenario.expect)
    rows = ROWS if expected and not result.scenario.figures else FEWER
    for expectation in result.scenario.expect:
        if expectation.always is None or variable.type == "boolean" or not _means(expectation.signal, name):
            continue
        if expectation.measure == "norm" and len(nodes) == variable.size and named[-1][0] != f"|{variable.name}|":
            named.append((f"|{variable.name}|", np.sqrt(((values - offset) ** 2).sum(axis=1))))
        lines += _bounds(expectation.always, variable, unit)
    plot = {
        **_plot(result, _with_unit(variable.name, unit), named, arrays, rows, None, variable.type != "real"),
        "lines": list(dict.fromkeys(lines)),
        "shade": held,
    }
    left = len(labels) - CURVES
    note = f"{left} more elements are not drawn" if left > 0 else ""
    return Group(name, variable.description, plot, note=note, expected=expected)


def _plot(
    result: RunData,
    label: str,
    named: Sequence[tuple[str, Floats]],
    arrays: Arrays,
    rows: int,
    window: Span | None = None,
    stepped: bool = False,
) -> dict[str, Any]:
    """The part that all plots have."""
    low, high = window or (float(result.time[0]), float(result.time[-1]))
    part = slice(int(np.searchsorted(result.time, low)), int(np.searchsorted(result.time, high, side="right")))
    values, time = np.column_stack([column[part] for _, column in named]), result.time[part]
    chosen = kept(values, rows)
    return {
        "label": label,
        "range": [low, high],
        "x": arrays.add(time[chosen]),
        "curves": [
            {"name": name, "y": arrays.add(values[chosen, i]), "stepped": stepped} for i, (name, _) in enumerate(named)
        ],
        "lines": [],
        "shade": [],
        "marks": [],
        "linked": True,
        "thinned": len(chosen) < len(time),
    }


def kept(values: NDArray[Any], rows: int) -> NDArray[np.intp]:
    """Which rows of (n, k) to keep, about so many: of each stretch those of every column's extremes, and all where few."""
    n, k = values.shape
    if n <= rows:
        return np.arange(n)
    size = -(-n // max(1, rows // (2 * k + 1)))
    whole = n // size
    chosen = [np.arange(0, n, size), np.array([n - 1])]
    for first, part in ((0, values[: whole * size]), (whole * size, values[whole * size :])):
        if not len(part):
            continue
        stretches = part.reshape(-1, min(size, len(part)), k)
        begins = first + size * np.arange(len(stretches))[:, None]
        ways = [stretches.argmin(axis=1), stretches.argmax(axis=1)]
        if (
            lost := np.isnan(stretches)
        ).any():  # a gap counts as lowest and highest to NumPy, and hides those beside it
            ways += [
                np.where(lost, np.inf, stretches).argmin(axis=1),
                np.where(lost, -np.inf, stretches).argmax(axis=1),
            ]
        chosen += [(begins + way).ravel() for way in ways]
    stays = np.zeros(n, bool)
    stays[np.concatenate(chosen)] = True
    return np.flatnonzero(stays)


def _packed(values: NDArray[Any]) -> tuple[str, bytes]:
    """Bytes, least first: one for booleans, four where seven figures are enough to tell neighbours, else eight."""
    if values.dtype == np.bool_:
        return "u1", values.astype(np.uint8).tobytes()
    values = np.asarray(values, np.float64)
    finite = np.abs(values) <= _LARGEST
    magnitudes = np.abs(values[finite])
    largest = float(magnitudes.max()) if len(magnitudes) else 0.0
    clean = np.where(finite, values, np.nan)
    if largest < _SMALLEST:
        return "f4", (0.0 * clean).astype("<f4").tobytes()
    spread = float(np.ptp(values[finite]))
    if 0.0 < spread < 1e-3 * largest:
        return "f8", clean.astype("<f8").tobytes()
    return "f4", clean.astype("<f4").tobytes()


def _few(spans: list[Span]) -> list[Span]:
    """Spans in order; where there are too many to see, neighbours are one."""
    spans = sorted(spans)
    if len(spans) <= MARKS:
        return spans
    gap = (spans[-1][1] - spans[0][0]) / MARKS
    joined = [spans[0]]
    for a, b in spans[1:]:
        if a - joined[-1][1] <= gap:
            joined[-1] = joined[-1][0], max(b, joined[-1][1])
        else:
            joined.append((a, b))
    return joined


def _means(reference: str, name: str) -> bool:
    parts = split(reference)
    return parts is not None and f"{parts[0]}.{parts[1]}" == name


def _bounds(bound: Any, variable: Variable, unit: Unit) -> list[float]:
    """The numbers of a bound in the plot's unit; none of what is no number."""
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
    return _with_unit(text if len(values) == 1 else f"[{text}]", unit, " ")


def _with_unit(text: str, unit: Unit, between: str = ", ") -> str:
    return text if unit.name in ("", "1") else f"{text}{between}{unit}"
