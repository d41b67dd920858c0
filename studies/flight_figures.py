"""The figures of docs/flight.md. Matplotlib is imported only when they are drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .claims import ORBIT
from .figures import AMBER, BLUE, GREEN, PINK, RED, SKY, name_axes, panels, save
from .flight import Done
from .flight_run import truth
from .vectors import Array

_PHASES = ((1, "#fde8d0", "steering"), (2, "#e3eef8", "plan"), (3, "#e8f4e8", "hold"))


def draw(done: Done, folder: Path) -> None:
    """Draws all figures into a folder."""
    save({f"flight-{name}": function(done) for name, function in _FIGURES.items()}, folder)


def _steps(ax: Any, times: Array, label: str, **style: Any) -> None:
    """The share that has settled over time, orbits."""
    t = np.sort(times[np.isfinite(times)])
    share = 100.0 * np.arange(len(t) + 1) / len(times)
    ax.step(np.concatenate(([1e-4], t, [3.0])), np.append(share, share[-1]), where="post", label=label, **style)


def settling(done: Done) -> Any:
    """The share of tumbles settled over time, by scheme, beside the bound of momentum."""
    figure, axes = panels(1, 2, 5.6, 3.8, sharey=True)
    for ax, group, title in (
        (axes[0, 0], "nominal", "nominal"),
        (axes[0, 1], "errors", "all errors together"),
    ):
        least = done.least(group)
        _steps(
            ax, np.where(np.isnan(least), np.inf, least), "momentum bound: none sooner", color="0.35", linestyle="--"
        )
        _steps(ax, done.times(group), "planned, below 5°", color=BLUE, linewidth=2.0)
        _steps(ax, done.times(group, 1), "planned, below 1°", color=SKY, linewidth=1.2)
        _steps(ax, done.times(f"{group}, tuned"), "law [8], tuned gains, bounded allocator", color=GREEN)
        _steps(ax, done.times(f"{group}, paper"), "the paper's scheme in SI units", color=RED)
        ax.set_xscale("log")
        ax.set_xlim(0.003, 3.0)
        ax.set_xticks([0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0], ["0.003", "0.01", "0.03", "0.1", "0.3", "1", "3"])
        ax.set_ylim(-2.0, 103.0)
        name_axes(ax, "time, orbits", "settled, % of the tumbles" if ax is axes[0, 0] else "", title)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=8, frameon=False, loc="outside lower center", ncols=3)
    return figure


def against_bound(done: Done) -> Any:
    """Each tumble's time over its own bound, and over its initial rate."""
    figure, axes = panels(1, 2, 5.2, 3.6)
    for group, colour, label in (("nominal", BLUE, "nominal"), ("errors", RED, "all errors")):
        t, least = done.times(group), done.least(group)
        rate = np.degrees([row.get("rate", np.nan) for _, row in done.of(group)])
        style = {"s": 5, "color": colour, "alpha": 0.45, "linewidths": 0, "label": label}
        axes[0, 0].scatter(least, t, **style)
        axes[0, 1].scatter(rate, t, **style)
    ends = np.array([0.0, float(np.nanmax(done.least("nominal")))])
    for factor in (1, 2, 3):
        axes[0, 0].plot(ends, factor * ends, color="0.5", linewidth=0.8, linestyle=":")
        axes[0, 0].annotate(f"{factor}×", (ends[1], factor * ends[1]), fontsize=8, color="0.35")
    axes[0, 0].set_ylim(bottom=0.0)
    axes[0, 1].set_ylim(bottom=0.0)
    name_axes(axes[0, 0], "momentum bound, orbits", "settled below 5°, orbits", "against each case's own bound")
    name_axes(axes[0, 1], "initial rate, deg/s", "settled below 5°, orbits", "against the initial rate")
    axes[0, 1].legend(fontsize=8, frameon=False, markerscale=2.5)
    return figure


def nodes(done: Done) -> Any:
    """V.B and V.C round the Earth."""
    figure, axes = panels(1, 2, 5.2, 3.3, sharey=True)
    for ax, which, name in ((axes[0, 0], "vb", "V.B"), (axes[0, 1], "vc", "V.C")):
        at = np.array([case.seed for case, _ in done.of(which)])
        for degrees, colour in ((5, BLUE), (1, SKY)):
            ax.plot(
                at,
                done.times(which, degrees),
                "o-",
                color=colour,
                markersize=3,
                linewidth=1.0,
                label=f"below {degrees}°",
            )
        ax.plot(at, done.least(which), "--", color="0.35", label="momentum bound")
        ax.set_ylim(bottom=0.0)
        ax.set_xticks(range(0, 361, 60))
        name_axes(ax, "longitude of the node, °E", "settled, orbits" if which == "vb" else "", f"{name} in SI units")
    axes[0, 0].legend(fontsize=8, frameon=False)
    return figure


def flight(done: Done) -> Any:
    """One tumble under all errors: truth, actuators and phases."""
    r = done.tumble
    t, phase = r.time, r["controller.phase"]
    error, rate = truth(*(r[f"plant.{name}"] for name in ("R_NB", "omega_B", "r_N", "v_N")))
    figure, axes = panels(2, 2, 5.6, 2.9, sharex=True)
    end = float(t[np.argmax(phase == 3)]) + 900.0
    top, bottom = axes
    top[0].semilogy(t, np.degrees(error), color=BLUE)
    for line in (5.0, 1.0):
        top[0].axhline(line, color="0.35", linewidth=0.8, linestyle="--")
    name_axes(top[0], "", "angle to LVLH, °")
    top[1].semilogy(t, rate, color=BLUE)
    top[1].axhline(1e-3, color="0.35", linewidth=0.8, linestyle="--")
    name_axes(top[1], "", "rate error, rad/s")
    for i, colour in enumerate((BLUE, RED, GREEN)):
        bottom[0].plot(t, r["plant.dipole"][:, i], color=colour, linewidth=0.7, label=f"rod {i + 1}")
    bottom[0].legend(fontsize=8, frameon=False, loc="lower right", ncols=3)
    name_axes(bottom[0], "time, s", "dipoles given, A m²")
    bottom[1].plot(t, 1e3 * r["plant.h_w"], color=PINK, label="flown")
    bottom[1].plot(t, 1e3 * r["controller.h_w_ref"], color="0.2", linewidth=0.8, linestyle="--", label="planned")
    for line in (-30.0, 30.0):
        bottom[1].axhline(line, color="0.35", linewidth=0.8, linestyle="--")
    bottom[1].legend(fontsize=8, frameon=False, loc="lower right")
    name_axes(bottom[1], "time, s", "wheel momentum, mN m s")
    for ax in axes.flat:
        ax.set_xlim(0.0, end)
        for number, colour, _ in _PHASES:
            for begin, stop in _spans(t, phase == number):
                ax.axvspan(begin, min(stop, end), color=colour, zorder=0, linewidth=0)
    from matplotlib.patches import Patch

    patches = [Patch(facecolor=colour, edgecolor="0.6", label=name) for _, colour, name in _PHASES]
    top[1].legend(handles=patches, fontsize=8, frameon=False, loc="upper right")
    return figure


def _spans(t: Array, mask: Array) -> list[tuple[float, float]]:
    """Begin and end of each stretch of a mask."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], mask.astype(int), [0]))))
    step = float(t[1] - t[0])
    return [(float(t[a]), float(t[b - 1]) + step) for a, b in edges.reshape(-1, 2)]


def holding(done: Done) -> Any:
    """20 orbits of hold."""
    r = done.hold
    t = r.time / ORBIT
    error, _ = truth(*(r[f"plant.{name}"] for name in ("R_NB", "omega_B", "r_N", "v_N")))
    figure, axes = panels(1, 2, 5.6, 3.0)
    axes[0, 0].semilogy(t, np.degrees(error), color=BLUE, linewidth=0.7)
    axes[0, 0].set_ylim(bottom=1e-3)
    name_axes(axes[0, 0], "time, orbits", "angle to LVLH, °")
    axes[0, 1].plot(t, 1e3 * r["plant.h_w"], color=AMBER, linewidth=0.8)
    for line in (-30.0, 30.0):
        axes[0, 1].axhline(line, color="0.35", linewidth=0.8, linestyle="--")
    name_axes(axes[0, 1], "time, orbits", "wheel momentum, mN m s")
    for ax in axes.flat:
        ax.set_xlim(0.0, float(t[-1]))
    return figure


_FIGURES = {"settling": settling, "bound": against_bound, "nodes": nodes, "one": flight, "holding": holding}
