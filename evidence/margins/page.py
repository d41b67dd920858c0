"""Writes docs/evidence/margins.md and its figure from docs/evidence/margins.json. Tests:
tests/evidence/margins/test_make.py."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from .. import plots
from ..markdown import render
from ..paper import ORBIT, ROOT
from .make import KEPT

PAGE = ROOT / "docs" / "evidence" / "margins.md"
ABOUT = {(1, 1, 1): "aligned", (-1, -1, 1): "half a turn about z", (-1, 1, -1): "about y", (1, -1, -1): "about x"}


def write() -> Path:
    """Writes both, and returns the page."""
    kept = json.loads(KEPT.read_text("utf-8"))
    plots.save({"margins": _figure(kept["places"])}, ROOT / "docs" / "figures")
    PAGE.write_text(render(Path(__file__).parent, **fields(kept)), "utf-8")
    return PAGE


def fields(kept: dict[str, Any]) -> dict[str, Any]:
    """Returns what the template takes."""
    rows = sorted(kept["places"], key=lambda row: (row["case"], row["place"]))
    good = [row for row in rows if not row["refused"] and row["case"].startswith("V.B")]
    least = min(good, key=lambda row: row["disk"])
    changes = {one["name"]: one for one in kept["changes"]}
    first = next(row for row in good if row["place"] == 0)
    return {
        "places": [_row(row) for row in rows],
        "equilibria": [_equilibrium(one) for one in kept["equilibria"]],
        "measured": len(good),
        "of": sum(row["case"].startswith("V.B") for row in rows),
        "least": least,
        "changes": changes,
        "margin": first["delay"],
    }


def _row(row: dict[str, Any]) -> list[str]:
    head = [row["case"], f"{row['place']}°"]
    if row["refused"]:
        reason = row["refused"].partition(": no peak")[0].partition(" (its answer")[0]
        return [*head, "none", "", "", "", reason]
    numbers = [f"{row['disk']:.3f}", f"{row['up']:.1f} dB", f"{row['phase']:.1f}°", f"{row['delay']:.2f} s"]
    return [*head, *numbers, f"within {100 * row['error']:.2g}%"]


def _equilibrium(one: dict[str, Any]) -> list[str]:
    # The rate nearest to zero is that of the wheel's momentum, which the law leaves as it is.
    rates = sorted(one["rates"], key=abs)[1:]
    unstable = [rate for rate in rates if rate > 0.0]
    worst = max(rates)
    size = worst * ORBIT / 2.302585
    return [ABOUT[tuple(one["turn"])], str(len(unstable)), f"{worst:+.5f} 1/s", f"10^{size:+.0f}", f"{one['rest']:.1g}"]


def _figure(rows: list[dict[str, Any]]) -> Any:
    figure, (axes,) = plots.panels(1, 2)
    names = list(dict.fromkeys(row["case"] for row in rows))
    for name, colour in zip(names, (plots.BLUE, plots.RED, plots.GREEN, plots.PINK), strict=False):
        good = [row for row in rows if row["case"] == name and not row["refused"]]
        good.sort(key=lambda row: row["place"])
        x = [row["place"] for row in good]
        none = [row["place"] for row in rows if row["case"] == name and row["refused"]]
        for ax, key in zip(axes, ("disk", "delay"), strict=True):
            ax.plot(x, [row[key] for row in good], "o", color=colour, label=name)
            ax.plot(none, [0.0] * len(none), "x", color=colour, clip_on=False, label=f"{name}: no margins")
    plots.name_axes(axes[0], "start from the ascending node, deg", "disk margin", "All channels at once")
    plots.name_axes(axes[1], "start from the ascending node, deg", "delay margin, s", "All channels alike")
    for ax, key in zip(axes, ("disk", "delay"), strict=True):
        ax.set_ylim(0.0, 1.15 * max(row[key] for row in rows if not row["refused"]))
        ax.set_xlim(-10, 325)
    axes[0].legend(fontsize=8, loc="center right")
    return figure
