"""What the studies' figures share: colours, axes, legends, files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from .paper import ORBIT, Array

BLUE, RED, GREEN, PINK, SKY, AMBER = "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"


def save(figures: Mapping[str, Any], folder: Path) -> None:
    """Writes figures by their names, with nothing in a file that changes from day to day."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, figure in figures.items():
        figure.savefig(folder / f"{name}.png", dpi=130, metadata={"Software": None})


def panels(rows: int, columns: int, width: float = 4.6, height: float = 3.2, **options: Any) -> tuple[Any, Any]:
    """A figure of rows x columns axes, each `width` x `height` inches."""
    figure = Figure(figsize=(width * columns, height * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    for ax in axes.flat:
        ax.tick_params(labelsize=8)
        ax.grid(True, color="0.92", linewidth=0.6)
        ax.set_axisbelow(True)
    return figure, axes


def name_axes(ax: Any, x: str, y: str, title: str = "") -> None:
    """Labels of the axes, and a title."""
    ax.set_xlabel(x, fontsize=9)
    ax.set_ylabel(y, fontsize=9)
    if title:
        ax.set_title(title, fontsize=10)


def limit(ax: Any, *values: float, along: str = "y") -> None:
    """Dashed lines at limits."""
    for value in values:
        line = ax.axhline if along == "y" else ax.axvline
        line(value, color="0.3", linestyle=(0, (5, 3)), linewidth=0.9)


def orbits(ax: Any) -> None:
    """A second axis above a time axis in s, in orbits."""
    above = ax.secondary_xaxis("top", functions=(lambda t: t / ORBIT, lambda n: n * ORBIT))
    above.set_xlabel("orbits", fontsize=8)
    above.tick_params(labelsize=7)


def patches(names: Sequence[str], colours: Sequence[str], shown: Array | None = None) -> list[Any]:
    """Legend entries of a map's codes, of those that occur in `shown`."""
    codes = range(len(names)) if shown is None else np.unique(shown)
    return [Patch(facecolor=colours[i], edgecolor="0.5", label=names[i]) for i in codes]


def legend_below(figure: Any, handles: Sequence[Any]) -> None:
    """One legend for the whole figure, beneath it."""
    figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 5), fontsize=8, frameon=False)
