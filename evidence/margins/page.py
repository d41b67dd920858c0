"""Writes docs/evidence/margins.md and its figure from docs/evidence/margins.json. Tests:
tests/evidence/margins/test_make.py."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from .. import plots
from ..markdown import render
from ..paper import ORBIT, ROOT
from .cases import CASES, PLACES, PLANNED
from .make import KEPT

PAGE = ROOT / "docs" / "evidence" / "margins.md"
ABOUT = {(1, 1, 1): "aligned", (-1, -1, 1): "half a turn about z", (-1, 1, -1): "about y", (1, -1, -1): "about x"}
VB = next(iter(CASES))


def write() -> Path:
    """Writes both, and returns the page."""
    kept = json.loads(KEPT.read_text("utf-8"))
    plots.save({"margins": _figure(kept["places"])}, ROOT / "docs" / "figures")
    PAGE.write_text(render(Path(__file__).parent, **fields(kept)), "utf-8")
    return PAGE


def fields(kept: dict[str, Any]) -> dict[str, Any]:
    """Returns what the template takes."""
    rows = sorted(kept["places"], key=lambda row: (list(CASES).index(row["case"]), row["place"]))
    good = [row for row in rows if "disk" in row]
    of = {name: [row for row in rows if row["case"] == name] for name in CASES}
    return {
        "places": [_row(row) for row in good],
        "reasons": [_reason(row) for row in rows if row["refused"] and "log" not in row],
        "multipliers": [_multipliers(row) for row in rows if "log" in row],
        "equilibria": [_equilibrium(one) for one in kept["equilibria"]],
        "all": len(PLACES),
        "vb": [row for row in of[VB] if "disk" in row],
        "usual": [row for row in of["usual law, four wheels"] if "disk" in row],
        "planned": [row for row in of[PLANNED] if "log" in row],
        "missing": [
            f"{name} ({len(found)} of {len(PLACES)})" for name, found in of.items() if len(found) < len(PLACES)
        ],
        "changes": {one["name"]: one for one in kept["changes"]},
        "delay": kept.get("delay"),
    }


def _row(row: dict[str, Any]) -> list[str]:
    up = f"{row['up']:.1f} dB" if math.isfinite(row["up"]) else "any"
    numbers = [f"{row['disk']:.3f}", up, f"{row['phase']:.1f}°", f"{row['delay']:.2f} s"]
    certain = [f"{100 * row['error']:.2g}%", f"{100 * row['change']:.2g}%"]
    return [row["case"], f"{row['place']}°", *numbers, *certain]


def _reason(row: dict[str, Any]) -> list[str]:
    return [row["case"], f"{row['place']}°", row["refused"].partition(": no p")[0].partition(" (its answer")[0]]


def _multipliers(row: dict[str, Any]) -> list[str]:
    factor = math.exp(10.0 * row["log"] / row["span"])
    seen = f"{100 * row['rest']:.2g}%"
    if row["rest"] > 0.1:
        return [row["case"], f"{row['place']}°", "none: the state is not seen", "", seen]
    return [row["case"], f"{row['place']}°", f"{math.exp(row['log']):.3g} in {row['span']:g} s", f"{factor:.3f}", seen]


def _equilibrium(one: dict[str, Any]) -> list[str]:
    # The rate nearest to zero is that of the wheel's momentum, which the law leaves as it is.
    rates = sorted(one["rates"], key=abs)[1:]
    unstable = [rate for rate in rates if rate > 0.0]
    worst = max(rates)
    size = worst * ORBIT / math.log(10)
    return [ABOUT[tuple(one["turn"])], str(len(unstable)), f"{worst:+.5f} 1/s", f"10^{size:+.0f}", f"{one['rest']:.1g}"]


def _figure(rows: list[dict[str, Any]]) -> Any:
    figure, (axes,) = plots.panels(1, 2)
    names = [name for name in CASES if any(row["case"] == name and "disk" in row for row in rows)]
    for name, colour in zip(names, (plots.BLUE, plots.RED, plots.GREEN, plots.PINK), strict=False):
        good = sorted((row["place"], row) for row in rows if row["case"] == name and "disk" in row)
        none = [row["place"] for row in rows if row["case"] == name and "disk" not in row]
        for ax, key in zip(axes, ("disk", "delay"), strict=True):
            ax.plot([place for place, _ in good], [row[key] for _, row in good], "o", color=colour, label=name)
            if none:
                ax.plot(none, [0.0] * len(none), "x", color=colour, clip_on=False, label=f"{name}: no margins")
    plots.name_axes(axes[0], "start from the ascending node, deg", "disk margin", "Each channel on its own")
    plots.name_axes(axes[1], "start from the ascending node, deg", "delay margin, s", "All channels alike")
    for ax, key in zip(axes, ("disk", "delay"), strict=True):
        ax.set_ylim(0.0, 1.2 * max(row[key] for row in rows if "disk" in row))
        ax.set_xlim(-10, 325)
    axes[1].legend(fontsize=8, loc="center right")
    return figure
