"""Figures of a run, as its scenario's `figures` describe them: signals over time, two panels in a row.

Matplotlib is imported only when something is drawn.
"""

from __future__ import annotations

import importlib.util
import textwrap
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, ResultsError, reason
from ..fmu.model import Floats
from ..quantities import ONE, Unit, value_in
from ..scenario.figures import FigureEntry, Panel
from ..scenario.references import Reference
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from ..system import acting
from ..system.panels import unit_of
from .arrays import LARGEST
from .data import RunData
from .keys import Keys, below
from .lettering import plain, undrawn
from .phases import bands

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#999999")
"""Okabe and Ito's palette, which colour-blind readers can tell apart."""
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
    if importlib.util.find_spec("matplotlib") is None:
        raise InputError("figures need Matplotlib: pip install matplotlib")
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


def plot(result: RunData, names: Sequence[str] = ()) -> Any:
    """A figure of these signals over time, a panel for each; by default of those that expectations look at, or of all.

    At most `_PANELS_MAX` of them by default. A notebook shows it. Raises KeyError for a signal that was not recorded.
    """
    if importlib.util.find_spec("matplotlib") is None:
        raise InputError("figures need Matplotlib: pip install matplotlib")
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
    """What a notebook shows of a figure."""
    data = BytesIO()
    figure.savefig(data, format="png")
    return data.getvalue()


def draw_panel(axes: Any, panel: Panel, entry: FigureEntry, result: RunData, keys: Keys | None = None) -> None:
    """One panel of a figure, with its lines, shading and marks; what explains them goes into `keys`."""
    keys = Keys() if keys is None else keys
    low, high = entry.window or (result.time[0], result.time[-1])
    shown_rows = (result.time >= low) & (result.time <= high)
    time = result.time[shown_rows]
    legend = False
    colours = iter(COLOURS * 4)
    for place, reference in enumerate(panel.signals):
        size = 2.6 if place == 0 and len(panel.signals) > 1 else 1.2  # a like curve does not hide the wider one
        unit, drawn = curves(result, reference, panel)
        for name, values in drawn:
            position = len(axes.lines)
            shown = panel.names[position] if position < len(panel.names) else plain(name)
            axes.plot(time, _drawable(values[shown_rows], panel.scale), color=next(colours), lw=size, label=shown)
            legend = legend or position > 0
    notes = []
    if not any(np.isfinite(line.get_ydata()).any() for line in axes.lines):
        positive = "positive and " if panel.scale == "log" else ""
        notes.append(f"no value is {positive}at most {LARGEST:g} in size")
    levels = _drawable([value_in(line, unit) for line in panel.lines], panel.scale)
    for level in levels[np.isfinite(levels)]:
        axes.axhline(level, color="0.35", linewidth=0.8, linestyle=(0, (5, 3)))
        keys.line(plain(panel.lines_are), panel.label or plain(panel.signals[0]))
    if entry.shade and (held := result[entry.shade].astype(bool)[shown_rows]).any():
        grey = {"color": "0.85", "linewidth": 1.5}  # the edge keeps the shortest hold visible
        axes.fill_between(time, 0, 1, where=_widened(held), transform=axes.get_xaxis_transform(), **grey)
        keys.shade(plain(entry.shade))
    if entry.mark:
        for crossing in zero_crossings(time, result[entry.mark][shown_rows]):
            axes.axvline(crossing, color="0.35", linewidth=0.8, linestyle=":")
            keys.mark(plain(entry.mark), crossing)
    texts = acting.fault_sentences(result.scenario, result.models)
    for fault, text in zip(acting.faults(result.scenario), texts, strict=True):
        begin, end = max(fault.at, low), min(high if fault.until is None else fault.until, high)
        if begin < end:
            row, colour = keys.fault(plain(text))
            top = 1.0 - row * _FAULT_ROW
            # Its edge keeps the shortest one visible.
            axes.axvspan(begin, end, ymin=top - _FAULT_BAR, ymax=top, color=colour, linewidth=1.5)
            axes.axvline(begin, color=colour, linewidth=0.8)
    axes.set_yscale(panel.scale)
    _draw_bands(axes, result, low, high, keys)
    axes.set_xlim(low, high)
    axes.set_xlabel("\n".join(["time, s", *notes]), fontsize=9)
    axes.set_ylabel(
        f"{panel.label or plain(panel.signals[0])}" + (f", {unit}" if unit.name not in ("", "1") else ""), fontsize=9
    )
    axes.tick_params(labelsize=8)
    axes.grid(True, color="0.92", linewidth=0.6)
    axes.set_axisbelow(True)
    if result.scenario.cycle:
        cycle = result.scenario.cycle
        above = axes.secondary_xaxis("top", functions=(lambda t: t / cycle.period, lambda n: n * cycle.period))
        above.set_xlabel(cycle.name, fontsize=8)
        above.tick_params(labelsize=7)
    if legend:
        axes.legend(fontsize=8, edgecolor="none", framealpha=0.7)


def _drawable(values: Any, scale: str) -> Floats:
    """The values, nan for those beyond what is drawn, on a logarithmic axis also for those that are not positive."""
    numbers = np.asarray(values, np.float64)
    shown = (np.abs(numbers) <= LARGEST) & ((numbers > 0.0) | (scale != "log"))
    return np.where(shown, numbers, np.nan)


def _draw_bands(axes: Any, result: RunData, low: float, high: float, keys: Keys) -> None:
    """The phases of the run behind the curves, each with its name where there is room for it."""
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


def zero_crossings(time: Floats, values: Floats) -> list[float]:
    """Where a signal changes its sign, s, linear between samples."""
    found = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0)
    share = values[found] / (values[found] - values[found + 1])
    return (time[found] + share * (time[found + 1] - time[found])).tolist()


@np.errstate(over="ignore")
def curves(result: RunData, reference: str, panel: Panel) -> tuple[Unit, list[tuple[str, Floats]]]:
    """The unit of a panel's axis, and names and values of the curves that the panel draws of one signal."""
    variable = result.variable(reference)
    unit = unit_of(panel, variable)
    factor, offset = (variable.unit or ONE).conversion(unit)
    values = result[reference].reshape(len(result.time), -1).astype(float)
    if panel.measure == "norm":
        named = [(f"|{reference}|", np.sqrt((values * values).sum(axis=1)))]
    elif values.shape[1] == 1:
        named = [(reference, values[:, 0])]
    else:
        block = reference.split(".")[0]
        named = [(f"{block}.{variable.label(i)}", values[:, i]) for i in range(values.shape[1])]
    return unit, [(name, factor * column + offset) for name, column in named]


def _widened(held: Any) -> Any:
    """A sample longer at its end, so that a hold of one sample can be seen."""
    return held | np.concatenate(([False], held[:-1]))
