"""What is told of margins: lines, a table of the response (CSV), a plot, and the same as data.

Tests: tests/orchestration/cli/test_margins.py.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..errors import writing
from .analysis import Crossing, Margins, alike, disk, margins
from .measure import Response
from .search import Lost

HEADER = ("channel", "gain up", "gain down", "phase", "delay", "disk margin", "gains for certain", "phases for certain")
"""Of the last row, all channels at once: gain, phase and delay are the same in all, disk margins independent."""


@dataclass(frozen=True)
class Found:
    """The response of a loop and its margins; none of them where the measurement was refused."""

    name: str
    when: float
    """s"""
    response: Response
    each: Sequence[Margins] = ()
    together: Margins | None = None
    """Those for changes that are the same in all channels, and the disk margin of independent ones."""
    searched: list[Lost] = field(default_factory=list)

    @staticmethod
    def of(name: str, when: float, response: Response) -> Found:
        """Returns the margins of a response."""
        if response.refused:
            return Found(name, when, response)
        loops = [margins(response.omega, response.loops[:, i]) for i in range(len(response.labels))]
        return Found(name, when, response, loops, alike(response.omega, response.L))

    def rows(self) -> list[tuple[str, ...]]:
        """Returns the lines of the table under HEADER."""
        named = [*zip(self.response.labels, self.each, strict=False)]
        if self.together is not None and len(named) > 1:
            named.append(("all at once", self.together))
        rows: list[tuple[str, ...]] = []
        for label, m in named:
            phase = _at(m.phase, math.degrees(m.phase.value), "deg")
            row = label, _gain(m.gain_up), _gain(m.gain_down), phase, _at(m.delay, m.delay.value, "s")
            rows.append((*row, *_disk(m.disk)))
        return rows

    def lines(self) -> list[str]:
        """Returns what the searches found, beside what the margins say of the same change."""
        said = []
        for one in self.searched:
            change = one.change
            text = str(one)
            if self.together is not None and change.name in ("gain", "delay"):
                m, up = self.together, change.end > change.start
                margin = m.delay if change.name == "delay" else m.gain_up if up else m.gain_down
                text += f"; margin of all channels alike {margin.value:.4g}" if margin.omega == margin.omega else ""
            said.append(f"{text} ({one.flights} flights)")
        return said

    def data(self) -> dict[str, Any]:
        """Returns the same for JSON: gains as factors, phases in rad, delays in s, frequencies in rad/s."""
        response = self.response
        return {
            "scenario": self.name,
            "when": self.when,
            "refused": response.refused or None,
            "warnings": response.warnings,
            "sample": response.step,
            "channels": {
                label: _pairs(m) | {"amplitude": float(response.amplitude[i]), "error": float(response.error[i])}
                for i, (label, m) in enumerate(zip(response.labels, self.each, strict=False))
            },
            "searched": [one.data() for one in self.searched],
            "together": None if self.together is None else _pairs(self.together),
        }

    def save_table(self, path: Path) -> None:
        """Writes S, and the open loop of each channel with the others closed; a row for each frequency."""
        response, labels = self.response, self.response.labels
        n = range(len(labels))
        header = ["frequency [rad/s]"]
        header += [f"L {label} [{unit}]" for label in labels for unit in ("dB", "deg")]
        header += [f"S {labels[i]} <- {labels[j]} [{part}]" for i in n for j in n for part in ("re", "im")]
        with writing(path), path.open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(header)
            for omega, loops, S in zip(response.omega, response.loops, response.S, strict=True):
                row = [omega, *(v for L in loops for v in (20 * math.log10(abs(L)), math.degrees(np.angle(L))))]
                table.writerow([f"{v:.10g}" for v in (*row, *(p for z in S.ravel() for p in (z.real, z.imag)))])

    def figure(self) -> Figure:
        """Returns the plot: size and phase of each open loop, and how much of S stays below its limit."""
        response = self.response
        drawn = Figure(figsize=(8.0, 7.5), layout="constrained")
        size, phase, disks = drawn.subplots(3, 1, sharex=True)
        for i, label in enumerate(response.labels):
            L, m = response.loops[:, i], self.each[i]
            size.loglog(response.omega, np.abs(L), color=f"C{i}", label=label)
            angle = np.degrees(np.unwrap(np.angle(L)))
            phase.semilogx(response.omega, angle, color=f"C{i}")
            disks.loglog(response.omega, 1 / np.abs(response.S[:, i, i] - 0.5), color=f"C{i}")
            if math.isfinite(m.phase.value):
                size.plot(m.phase.omega, 1.0, "o", color=f"C{i}")
                phase.plot(m.phase.omega, np.interp(m.phase.omega, response.omega, angle), "o", color=f"C{i}")
        size.axhline(1.0, color="0.6", lw=0.8)
        phase.axhline(-180.0, color="0.6", lw=0.8)
        if self.together is not None:
            label = f"least for all at once: {self.together.disk.value:.3g}"
            disks.axhline(self.together.disk.value, color="k", ls="--", lw=0.8, label=label)
            disks.legend(loc="upper left")
        size.legend(loc="lower left")
        size.set(
            ylabel="size of L", title=f"{self.name}: open loop of each channel, the others closed, at {self.when:g} s"
        )
        phase.set(ylabel="phase of L, deg")
        disks.set(ylabel="disk margin 1/|S - 1/2|", xlabel="frequency, rad/s")
        for axes in (size, phase, disks):
            axes.grid(True, which="major", alpha=0.3)
        return drawn


def _gain(c: Crossing) -> str:
    if not 0.0 < c.value < math.inf:
        return "none"
    return _at(c, 20 * math.log10(c.value), "dB")


def _at(c: Crossing, value: float, unit: str) -> str:
    return f"{value:.4g} {unit} at {c.omega:.3g} rad/s" if math.isfinite(c.omega) else "none"


def _disk(c: Crossing) -> tuple[str, str, str]:
    sure = disk(c.value)
    high = f"{20 * math.log10(sure.high):.3g} dB" if math.isfinite(sure.high) else "any"
    return f"{c.value:.4g} at {c.omega:.3g} rad/s", f"±{high}", f"±{math.degrees(sure.phase):.3g} deg"


def _pairs(m: Margins) -> dict[str, Any]:
    crossings = ((key, getattr(m, key)) for key in ("gain_up", "gain_down", "phase", "delay", "disk"))
    return {
        name: {key: v if math.isfinite(v) else None for key, v in (("value", c.value), ("omega", c.omega))}
        for name, c in crossings
    }
