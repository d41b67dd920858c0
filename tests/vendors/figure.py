"""Draws how much of each kind was proposed or named, from the rows of a measurement."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from . import kinds


def draw(rows: Sequence[dict[str, Any]], path: Path) -> None:
    """Writes a bar for each kind: right, missed, false."""
    figure = Figure(figsize=(7.5, 7.0), layout="constrained")
    axes = figure.subplots()
    names = [name for name in kinds.KINDS if any(name in row["kinds"] for row in rows)][::-1]
    for place, name in enumerate(names):
        some = [row for row in rows if name in row["kinds"]]
        false = sum(bool(row["false"]) for row in some)
        right = sum(not row["false"] and False not in (row["proposed"], row["named"]) for row in some)
        left = 0
        for count, colour in ((right, "#3b7d4f"), (len(some) - right - false, "#d9d9d9"), (false, "#c0392b")):
            axes.barh(place, count, left=left, color=colour, height=0.75)
            left += count
    axes.set_yticks(range(len(names)), names, fontsize=8)
    axes.set_xlabel("FMUs; a pair counts in both of its kinds")
    axes.set_title("Vendors' FMUs: explained in full (green), detected only (grey), false statement (red)", fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=110)
