"""Figures of a run, as its scenario's `figures` describe them: signals over time, two panels in a row.

Matplotlib is imported only when something is drawn.

Tests: tests/orchestration/results/test_keys.py, test_views.py, test_outputs.py.
"""

from __future__ import annotations

import importlib.util
import textwrap
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, ResultsError, reason
from ..fmu.model import Floats
from ..quantities import Unit, value_in
from ..scenario.figures import FigureEntry, Panel
from ..scenario.references import Reference
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from ..system import acting
from .arrays import LARGEST
from .curves import COLOURS, axis, crossings, curves, spans, window
from .data import RunData
from .keys import Keys, below
from .lettering import plain, undrawn
from .phases import bands

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PANEL_SIZE = (5.2, 3.4)
"""inches"""
_ACROSS = 2
"""Panels in a row."""
_FAULT_BAR, _FAULT_ROW = 0.025, 0.035
"""Height of the bar that marks a fault, and from one bar to the next, as shares of the panel's."""
_LABELLED = 0.02
"""Share of a panel's width from which a phase has its name in it."""
_TITLE = 56
"""Letters of a title above a panel's width."""
_PANELS_MAX = 6
"""Panels of a plot for which no signals are named."""


def require(scenario: Scenario) -> None:
    """Refuses to go on without what figures need, before a run is spent on them, and text that cannot be drawn.

    Between two `$` Matplotlib draws mathematics.
    """
    _require_matplotlib()
    texts: dict[Key, str] = {}
    for i, entry in enumerate(scenario.figures):
        texts["figures", i, "title"] = entry.title
        for j, panel in enumerate(entry.panels):
            place: Key = ("figures", i, "panels", j)
            texts[*place, "label"] = panel.label
            texts.update({(*place, "names", k): name for k, name in enumerate(panel.names)})
    if scenario.cycle:
        texts["cycle", "name"] = scenario.cycle.name
    errors = [scenario.error(key, error) for key, text in texts.items() if "$" in text and (error := undrawn(text))]
    if errors:
        raise InputError(*errors)


def _require_matplotlib() -> None:
    if importlib.util.find_spec("matplotlib") is None:
        raise InputError("figures need Matplotlib: pip install matplotlib")


def draw(result: RunData, folder: Path, format: str = "png") -> list[Path]:
    """Draws every figure of the scenario into the folder and returns the files.

    Raises InputError without Matplotlib, and ResultsError where they cannot be written.
    """
    require(result.scenario)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return [_draw(entry, result, folder / f"{entry.name}.{format}") for entry in result.scenario.figures]
    except OSError as error:
        raise ResultsError(f"figures cannot be written: {error.filename or folder}: {reason(error)}") from None


def _draw(entry: FigureEntry, result: RunData, file: Path) -> Path:
    from matplotlib.figure import Figure  # optional, and slow to import  # noqa: PLC0415

    across = min(_ACROSS, len(entry.panels))
    rows = -(-len(entry.panels) // across)
    figure = Figure(figsize=(_PANEL_SIZE[0] * across, _PANEL_SIZE[1] * rows), dpi=150, layout="constrained")
    grid = figure.add_gridspec(rows, across)
    keys = Keys()
    for i, panel in enumerate(entry.panels):
        row, column = divmod(i, across)
        alone = column == 0 and i == len(entry.panels) - 1
        axes = figure.add_subplot(grid[row, :] if alone else grid[row, column])
        draw_panel(axes, panel, entry, result, keys)
    title = textwrap.fill(entry.title or entry.name, _TITLE * across) if "$" not in entry.title else entry.title
    figure.suptitle(title if entry.title else plain(title), fontsize=11)
    below(figure, keys)
    figure.savefig(file, metadata={"Software": None} if file.suffix == ".png" else None)
    return file


def plot(result: RunData, names: Sequence[str] = ()) -> Figure:
    """Returns a figure of these signals over time, a panel for each, which a notebook shows.

    By default they are those that expectations look at, or all, at most `_PANELS_MAX`. Raises KeyError for a signal
    that was not recorded.
    """
    _require_matplotlib()
    from matplotlib.figure import Figure  # optional, and slow to import  # noqa: PLC0415

    expected = [e.signal for e in result.scenario.expect if e.signal in result]
    chosen = list(names) or list(dict.fromkeys(expected or result))[:_PANELS_MAX]
    for name in chosen:
        result[name]
    entry = FigureEntry(name="plot", panels=[Panel(signals=[Reference(name)]) for name in chosen])
    width, height = _PANEL_SIZE
    figure = type("Plot", (Figure,), {"_repr_png_": _png})(
        figsize=(1.5 * width, 0.8 * height * len(chosen)), dpi=100, layout="constrained"
    )
    keys = Keys()
    for panel, axes in zip(entry.panels, np.ravel(figure.subplots(len(chosen), 1)), strict=True):
        draw_panel(axes, panel, entry, result, keys)
    below(figure, keys)
    return figure


def _png(figure: Any) -> bytes:
    """Returns the picture that a notebook shows of a figure."""
    data = BytesIO()
    figure.savefig(data, format="png")
    return data.getvalue()


def draw_panel(axes: Any, panel: Panel, entry: FigureEntry, result: RunData, keys: Keys | None = None) -> None:
    """Draws one panel of a figure, with its lines, shading and marks; what explains them goes into `keys`."""
    keys = Keys() if keys is None else keys
    low, high = window(result, entry)
    notes, unit = _draw_curves(axes, panel, result, low, high)
    levels = _drawable([value_in(line, unit) for line in panel.lines], panel.scale)
    for level in levels[np.isfinite(levels)]:
        axes.axhline(level, color="0.35", linewidth=0.8, linestyle=(0, (5, 3)))
        keys.line(plain(panel.lines_are), panel.label or plain(panel.signals[0]))
    for begin, end in spans(result.time, result[entry.shade].astype(bool)) if entry.shade else ():
        if begin <= high and end >= low:
            axes.axvspan(begin, end, color="0.85", linewidth=1.5)  # the edge keeps the shortest hold visible
            keys.shade(plain(entry.shade or ""))
    for crossing in crossings(result, entry):
        axes.axvline(crossing, color="0.35", linewidth=0.8, linestyle=":")
        keys.mark(plain(entry.mark or ""), crossing)
    _draw_faults(axes, result, low, high, keys)
    axes.set_yscale(panel.scale)
    _draw_bands(axes, result, low, high, keys)
    axes.set_xlim(low, high)
    axes.set_xlabel("\n".join(["time, s", *notes]), fontsize=9)
    axes.set_ylabel(axis(panel.label or plain(panel.signals[0]), unit), fontsize=9)
    axes.tick_params(labelsize=8)
    axes.grid(True, color="0.92", linewidth=0.6)
    axes.set_axisbelow(True)
    if cycle := result.scenario.cycle:
        above = axes.secondary_xaxis("top", functions=(lambda t: t / cycle.period, lambda n: n * cycle.period))
        above.set_xlabel(cycle.name, fontsize=8)
        above.tick_params(labelsize=7)


def _draw_curves(axes: Any, panel: Panel, result: RunData, low: float, high: float) -> tuple[list[str], Unit]:
    """Draws the curves with their legend; returns what there is to note, and the unit of the axis."""
    rows = (result.time >= low) & (result.time <= high)
    colours = iter(COLOURS * 4)
    for place, reference in enumerate(panel.signals):
        size = 2.6 if place == 0 and len(panel.signals) > 1 else 1.2  # a like curve does not hide the wider one
        unit, drawn = curves(result, reference, panel)
        for name, values in drawn:
            position = len(axes.lines)
            shown = panel.names[position] if position < len(panel.names) else plain(name)
            values = _drawable(values[rows], panel.scale)
            axes.plot(result.time[rows], values, color=next(colours), lw=size, label=shown)
    if len(axes.lines) > 1:
        axes.legend(fontsize=8, edgecolor="none", framealpha=0.7)
    if any(np.isfinite(line.get_ydata()).any() for line in axes.lines):
        return [], unit
    return [f"no value is {'positive and ' * (panel.scale == 'log')}at most {LARGEST:g} in size"], unit


def _draw_faults(axes: Any, result: RunData, low: float, high: float, keys: Keys) -> None:
    texts = acting.fault_sentences(result.scenario, result.models)
    for fault, text in zip(acting.faults(result.scenario), texts, strict=True):
        begin, end = max(fault.at, low), min(high if fault.until is None else fault.until, high)
        if begin < end:
            row, colour = keys.fault(plain(text))
            top = 1.0 - row * _FAULT_ROW
            # Its edge keeps the shortest one visible.
            axes.axvspan(begin, end, ymin=top - _FAULT_BAR, ymax=top, color=colour, linewidth=1.5)
            axes.axvline(begin, color=colour, linewidth=0.8)


def _drawable(values: Any, scale: str) -> Floats:
    """Returns the values, nan for those beyond what is drawn, on a logarithmic axis also for those not positive."""
    numbers = np.asarray(values, np.float64)
    shown = (np.abs(numbers) <= LARGEST) & ((numbers > 0.0) | (scale != "log"))
    return np.where(shown, numbers, np.nan)


def _draw_bands(axes: Any, result: RunData, low: float, high: float, keys: Keys) -> None:
    """Draws the phases of the run behind the curves, each with its name where there is room for it."""
    for band in bands(result):
        begin, end = max(band.begin, low), min(band.end, high)
        if begin >= end:
            continue
        colour = {"color": COLOURS[band.colour % len(COLOURS)], "alpha": 0.16, "linewidth": 0.0}
        axes.axvspan(begin, end, zorder=0, **colour)
        keys.phase(plain(band.name), colour)
        if end - begin > _LABELLED * (high - low):
            axes.annotate(
                plain(band.name),
                (0.5 * (begin + end), 0.95 - len(keys.faults) * _FAULT_ROW),
                xycoords=axes.get_xaxis_transform(),
                rotation=90,
                fontsize=6,
                color="0.35",
                horizontalalignment="center",
                verticalalignment="top",
                bbox={"facecolor": "white", "alpha": 0.7, "linewidth": 0.0, "pad": 0.8},
            )
