"""What explains a figure, once below its panels: phases, faults, dashed and dotted lines, shading."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass, field
from typing import Any

from .curves import crossings_text

_FAULTS = ("#c00000", "#e07b00", "#7b1fa2", "#5d4037")
"""Colours of the bars of faults, in turn."""
_FONT = 8
_LETTERS = 14.5
"""Letters of that size on an inch, about."""
_GAP = 0.06
"""Inches between what stands below one another."""


@dataclass
class Keys:
    """Keys of what is drawn in the panels of a figure, each once, as text for Matplotlib."""

    phases: dict[str, dict[str, Any]] = field(default_factory=dict)
    """The colour of each phase by its name."""
    lines: dict[str, list[str]] = field(default_factory=dict)
    """The panels with dashed lines, by what the lines are."""
    marks: dict[str, list[float]] = field(default_factory=dict)
    shades: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)

    def phase(self, name: str, colour: dict[str, Any]) -> None:
        self.phases.setdefault(name, colour)

    def line(self, what: str, panel: str) -> None:
        panels = self.lines.setdefault(what, [])
        if panel not in panels:
            panels.append(panel)

    def mark(self, signal: str, time: float) -> None:
        times = self.marks.setdefault(signal, [])
        if time not in times:
            times.append(time)

    def shade(self, signal: str) -> None:
        if signal not in self.shades:
            self.shades.append(signal)

    def fault(self, text: str) -> tuple[int, str]:
        """Returns the row of the fault's bar, from the top, and its colour."""
        if text not in self.faults:
            self.faults.append(text)
        row = self.faults.index(text)
        return row, _colour(row)

    def texts(self) -> list[tuple[str, str]]:
        """Returns what kind of thing each line explains, and the line; those of faults follow."""
        several = len(self.lines) > 1
        found = [("line", what + (f" ({', '.join(panels)})" if several else "")) for what, panels in self.lines.items()]
        found += [("mark", crossings_text(signal, times)) for signal, times in self.marks.items()]
        return found + [("shade", f"{signal} is true") for signal in self.shades]


def below(figure: Any, keys: Keys) -> None:
    """Makes the figure higher by what explains it, and writes that below the panels."""
    from matplotlib.legend import Legend  # optional, and slow to import  # noqa: PLC0415
    from matplotlib.lines import Line2D  # optional, and slow to import  # noqa: PLC0415
    from matplotlib.patches import Patch  # optional, and slow to import  # noqa: PLC0415

    width, height = figure.get_size_inches()
    look: dict[str, Any] = {
        "line": lambda: Line2D([], [], color="0.35", linewidth=0.8, linestyle=(0, (5, 3))),
        "mark": lambda: Line2D([], [], color="0.35", linewidth=0.8, linestyle=":"),
        "shade": lambda: Patch(color="0.85"),
    }
    letters = int(_LETTERS * width) - 6
    texts = [(look[kind](), text) for kind, text in keys.texts()]
    texts += [(Patch(color=_colour(row)), f"fault: {text}") for row, text in enumerate(keys.faults)]
    kinds = [(handle, _label(textwrap.fill(text, letters))) for handle, text in texts]
    phases = [(Patch(**colour), _label(name)) for name, colour in keys.phases.items()]
    widest = 6 + max((len(name) for name in keys.phases), default=0)
    columns = max(1, min(len(phases), letters // widest))
    placed: list[tuple[Legend, float]] = []
    total = 0.0
    for entries, ncols in ((kinds, 1), (phases, columns)):  # from the lower edge upwards
        if not entries:
            continue
        handles, labels = zip(*entries, strict=True)
        legend = Legend(figure, handles, labels, ncols=ncols, loc="lower left", fontsize=_FONT, frameon=False)
        legend.set_in_layout(False)
        figure.add_artist(legend)
        placed.append((legend, total))
        total += legend.get_window_extent().height / figure.dpi + _GAP
    if not placed:
        return
    figure.set_size_inches(width, height + total)
    for legend, bottom in placed:
        legend.set_bbox_to_anchor((0.01, bottom / (height + total)), figure.transFigure)
    share = total / (height + total)
    figure.get_layout_engine().set(rect=(0.0, share, 1.0, 1.0 - share))


def _colour(row: int) -> str:
    """Returns the colour of the bar of a fault."""
    return _FAULTS[row % len(_FAULTS)]


def _label(text: str) -> str:
    """Matplotlib leaves out what begins with an underscore."""
    return f" {text}" if text.startswith("_") else text
