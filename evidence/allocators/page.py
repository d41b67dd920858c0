"""docs/evidence/allocators.md and its figure, every number in them from docs/evidence/allocators.csv.
Tests: tests/evidence/allocators/test_allocators.py."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fmus.interface import load as load_interface

from .. import markdown
from ..paper import ORBIT, ROOT, SCENARIOS, TITLES
from ..plots import BLUE, RED, limit, name_axes, panels, save
from .make import ALLOCATORS, COLUMNS, NODES, WEIGHTS, Flown, rows


def write(done: Mapping[str, Flown]) -> Path:
    """Draws and writes; returns the page."""
    save({"allocators-wheel": figure(done)}, ROOT / "docs" / "figures")
    target = ROOT / "docs" / "evidence" / "allocators.md"
    target.write_text(text(done), "utf-8")
    return target


def figure(done: Mapping[str, Flown]) -> Any:
    """The wheel's peak over the orbit at every node; hollow where an error left its tolerance."""
    drawn, axes = panels(1, 2, 5.6, 3.4, sharey=True)
    most = load_interface("plant").variables["wheel_momentum_max"].start
    for ax, which in zip(axes[0], SCENARIOS, strict=True):
        for name, colour, marker in zip(ALLOCATORS, (RED, BLUE), "so", strict=True):
            f = done[f"{which} {name} a"]
            peak = 1e3 * np.maximum(f.wheel, f.wheel_later)
            ax.plot(NODES, peak, color=colour, linewidth=0.8, alpha=0.6)
            for kept, face in ((True, colour), (False, "white")):
                at = f.kept == kept
                ax.plot(NODES[at], peak[at], marker, color=colour, markerfacecolor=face, markersize=5)
            ax.plot([], [], marker + "-", color=colour, label=ALLOCATORS[name])
        limit(ax, 1e3 * most)
        ax.set_yscale("log")
        name_axes(
            ax,
            "node longitude, °E",
            "largest wheel momentum in an orbit, mN m s",
            f"{TITLES[which]}:\nhollow where the errors leave their tolerance",
        )
    axes[0][0].legend(fontsize=8, frameon=False, loc="upper left", bbox_to_anchor=(0.0, 0.93))
    return drawn


def text(done: Mapping[str, Flown]) -> str:
    """The page."""

    def count(name: str) -> dict[str, int]:
        runs = [done[f"{w} {name} a"] for w in SCENARIOS]
        return {
            "settled": sum(int(np.isfinite(f.settled).sum()) for f in runs),
            "kept": sum(int(f.kept.sum()) for f in runs),
            "latched": sum(int(f.latched.sum()) for f in runs),
        }

    start = {v.name: v.start for v in load_interface("allocator_bounded").of("parameter")}
    return markdown.render(
        Path(__file__).parent,
        nodes=len(NODES),
        total=len(SCENARIOS) * len(NODES),
        runs=f"{len(done) * len(NODES):,}",
        orbit=f"{ORBIT:.0f}",
        count={name: count(name) for name in ALLOCATORS},
        wheel_weight_ff=f"{start['wheel_weight_ff']:g}",
        header="|".join(["", "allocator", *COLUMNS]),
        mass=rows(done, "a"),
        si=markdown.finite(np.concatenate([done[f"{w} {name} c"].settled for w in SCENARIOS for name in ALLOCATORS])),
        weights=", ".join(f"{_kept(done, w)} with {w:g}" for w in WEIGHTS),
        best=f"{max(WEIGHTS, key=lambda w: _kept(done, w)):g}",
    )


def _kept(done: Mapping[str, Flown], weight: float) -> int:
    return sum(int(done[f"{which} wheel_weight {weight:g}"].kept.sum()) for which in SCENARIOS)
