"""docs/evidence/optimum.md and its figure, every number in them from docs/evidence/optimum.csv."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .. import markdown
from ..paper import ROOT, Array
from ..plots import BLUE, GREEN, RED, limit, name_axes, panels, save
from .kept import FILE, Line, load, others
from .problem import DEGREE, HOLD, MARGIN, ONE_WHEEL, UNLOADED, WIDE


def publish(folder: Path = ROOT / "docs" / "evidence") -> Path:
    """Draws and writes from the file in the folder; returns the page."""
    lines, other = least(load(folder / FILE), others(folder))
    save({"optimum": figure(lines)}, folder.parent / "figures")
    target = folder / "optimum.md"
    target.write_text(text(lines, other), "utf-8")
    return target


def least(lines: Sequence[Line], times: Mapping[int, float]) -> tuple[list[Line], int]:
    """The lines with the lesser of both times, and how many of the other search are less."""
    shorter = [times.get(line.run, math.inf) < line.best_s for line in lines]
    return [
        replace(line, best_s=times[line.run]) if less else line for line, less in zip(lines, shorter, strict=True)
    ], sum(shorter)


def column(lines: Sequence[Line], name: str) -> Array:
    """A column as numbers (n,)."""
    return np.array([getattr(line, name) for line in lines], float)


def figure(lines: Sequence[Line]) -> Any:
    """Flown over best found in their order, and both times over the bound."""
    drawn, axes = panels(1, 2, 5.2, 3.5)
    best, flown, least = (column(lines, name) for name in ("best_s", "flown_s", "bound_s"))
    ax = axes[0, 0]
    ax.plot(np.arange(1, len(lines) + 1), np.sort(flown / best), "o-", color=BLUE, markersize=3, linewidth=0.8)
    limit(ax, float(np.median(flown / best)))
    ax.set_ylim(bottom=1.0)
    name_axes(
        ax, "tumbles, in order", "time flown / best found", "time flown over the best time found (dashed: median)"
    )
    ax = axes[0, 1]
    order = np.argsort(best)
    ax.plot(best[order], flown[order], "o", color=RED, markersize=3, label="flown")
    ax.plot(best[order], best[order], "-", color=BLUE, linewidth=1.0, label="best found")
    ax.plot(best[order], least[order], "x", color=GREEN, markersize=4, label="momentum bound")
    ax.set_ylim(bottom=0.0)
    name_axes(ax, "best time found, s", "time, s", "flown, best found and bound")
    ax.legend(fontsize=8, frameon=False)
    return drawn


def text(lines: Sequence[Line], other: int) -> str:
    """The page; so many of the times are of another search."""
    best, flown, bound = (column(lines, name) for name in ("best_s", "flown_s", "bound_s"))
    ratio, rods = flown / best, column(lines, "rods_flown")
    bounded = bound > 1.0
    steered = column(lines, "handed_over_s") > 0.0
    rest = steered & np.isfinite(column(lines, "best_after_s"))
    after, after_best = (flown - column(lines, "handed_over_s"))[rest], column(lines, "best_after_s")[rest]
    loss = flown - best
    return markdown.render(
        Path(__file__).parent,
        n=len(lines),
        hold=f"{HOLD:.0f}",
        unloaded=UNLOADED,
        margin=MARGIN,
        degree=DEGREE,
        interval=f"{ONE_WHEEL.longest:.0f}",
        runs=_runs([line.run for line in lines]),
        best_over_bound=f"{np.median(best[bounded] / bound[bounded]):.2f}",
        ratio=f"{np.median(ratio):.2f}",
        worst=f"{ratio.max():.2f}",
        worst_run=lines[int(np.argmax(ratio))].run,
        rods_best=f"{np.median(column(lines, 'rods_best')):.2f}",
        rods_flown=f"{np.median(rods):.2f}",
        rods_least=f"{rods.min():.2f}",
        rods_most=f"{rods.max():.2f}",
        handed=int(steered.sum()),
        losses=[
            [
                name,
                f"{which.sum()}",
                *_medians(flown[which], best[which]),
                f"{100.0 * loss[which].sum() / loss.sum():.0f}%",
            ]
            for name, which in (("steering, then plan", steered), ("plan from the start", ~steered))
            if which.any()
        ],
        after_share=f"{100.0 * (after - after_best).sum() / loss[rest].sum():.0f}%" if rest.any() else "–",
        plan_share=f"{100.0 * (loss[~steered].sum() + (after - after_best).sum()) / loss.sum():.0f}%",
        after_flown=f"{np.median(after):.0f}" if rest.any() else "–",
        after_best=f"{np.median(after_best):.0f}" if rest.any() else "–",
        check_angle=f"{column(lines, 'check_angle_deg').max():.2f}",
        check_rate=f"{column(lines, 'check_rate_rad_s').max():.2g}",
        check_gap=f"{column(lines, 'check_gap_deg').max():.2g}",
        held=sum(line.held_on for line in lines),
        other=other,
        wide=sum(line.tried >= WIDE for line in lines),
        starts=WIDE,
        cases=max(line.run for line in lines) + 1,
        seconds=f"{np.median(column(lines, 'seconds')):.0f}",
        minutes=f"{column(lines, 'seconds').sum() / 60.0:.0f}",
    )


def _medians(*values: Array) -> list[str]:
    return [f"{np.median(v):.0f} s" for v in values]


def _runs(runs: Sequence[int]) -> str:
    """`0 to 11`, or a list."""
    whole = list(runs) == list(range(runs[0], runs[-1] + 1))
    return f"{runs[0]} to {runs[-1]}" if whole else ", ".join(map(str, runs))
