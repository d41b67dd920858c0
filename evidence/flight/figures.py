"""The figures of docs/evidence/flight.md. Tests: tests/evidence/flight/test_flight.py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from orchestration import Result

from ..paper import ORBIT, TITLES, Array
from ..plots import AMBER, BLUE, GREEN, PINK, RED, SKY, limit, name_axes, panels, patches, save
from .kept import Flights

_PHASES = ((1, "#fde8d0", "steering"), (2, "#e3eef8", "plan"), (3, "#e8f4e8", "hold"))


def errors(result: Result) -> tuple[Array, Array]:
    """Angle to LVLH, rad, and rate error, rad/s, of a run, from the plant's truth; each (n,)."""
    return result["judge.attitude_error"], np.asarray(np.linalg.norm(result["judge.rate_error_B"], axis=1))


def draw(flights: Flights, tumble: Result, hold: Result, folder: Path) -> None:
    """Draws all figures into a folder; `tumble` and `hold` are the scenarios that are shown."""
    drawn = {"settling": settling(flights), "bound": against_bound(flights), "nodes": nodes(flights)}
    drawn |= {"one": one(tumble), "holding": holding(hold)}
    save({f"flight-{name}": figure for name, figure in drawn.items()}, folder)


def _steps(ax: Any, times: Array, label: str, **style: Any) -> None:
    """The share that has settled over time, orbits."""
    t = np.sort(times[np.isfinite(times)])
    share = 100.0 * np.arange(len(t) + 1) / len(times)
    ax.step(np.concatenate(([1e-4], t, [3.0])), np.append(share, share[-1]), where="post", label=label, **style)


def settling(done: Flights) -> Any:
    """The share of tumbles settled over time, by scheme, beside the bound of momentum."""
    figure, axes = panels(1, 2, 5.6, 3.8, sharey=True)
    for ax, group, title in (
        (axes[0, 0], "nominal", "random tumbles, nominal"),
        (axes[0, 1], "errors", "random tumbles, all errors together"),
    ):
        least = done.least(group)
        _steps(
            ax, np.where(np.isnan(least), np.inf, least), "momentum bound: none sooner", color="0.35", linestyle="--"
        )
        _steps(ax, done.times(group), "planned controller, below 5°", color=BLUE, linewidth=2.0)
        _steps(ax, done.times(group, 1), "planned controller, below 1°", color=SKY, linewidth=1.2)
        _steps(ax, done.times(f"{group} tuned"), "the paper's law, tuned gains, bounded allocator", color=GREEN)
        _steps(ax, done.times(f"{group} paper"), "the paper's controller and allocator", color=RED)
        ax.set_xscale("log")
        ax.set_xlim(0.003, 3.0)
        ax.set_xticks([0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0], ["0.003", "0.01", "0.03", "0.1", "0.3", "1", "3"])
        ax.set_ylim(-2.0, 103.0)
        name_axes(ax, "time, orbits", "settled, % of the tumbles" if ax is axes[0, 0] else "", title)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=8, frameon=False, loc="outside lower center", ncols=3)
    return figure


def against_bound(done: Flights) -> Any:
    """Each tumble's time over its own bound, and over its initial rate."""
    figure, axes = panels(1, 2, 5.2, 3.6)
    for group, colour, label in (("nominal", BLUE, "nominal"), ("errors", RED, "all errors")):
        t, least = done.times(group), done.least(group)
        rate = done.column(group, "initial_rate_deg_s")
        style = {"s": 5, "color": colour, "alpha": 0.45, "linewidths": 0, "label": label}
        axes[0, 0].scatter(least, t, **style)
        axes[0, 1].scatter(rate, t, **style)
    ends = np.array([0.0, float(np.nanmax(done.least("nominal")))])
    for factor in (1, 2, 3):
        axes[0, 0].plot(ends, factor * ends, color="0.5", linewidth=0.8, linestyle=":")
        axes[0, 0].annotate(f"{factor}×", (ends[1], factor * ends[1]), fontsize=8, color="0.35")
    axes[0, 0].set_ylim(bottom=0.0)
    axes[0, 1].set_ylim(bottom=0.0)
    name_axes(axes[0, 0], "momentum bound, orbits", "settled below 5°, orbits", "settling time over momentum bound")
    name_axes(axes[0, 1], "initial rate, deg/s", "settled below 5°, orbits", "settling time over initial rate")
    axes[0, 1].legend(fontsize=8, frameon=False, markerscale=2.5)
    return figure


def nodes(done: Flights) -> Any:
    """V.B and V.C round the Earth."""
    figure, axes = panels(1, 2, 5.2, 3.3, sharey=True)
    for ax, which, name in ((axes[0, 0], "vb", "V.B"), (axes[0, 1], "vc", "V.C")):
        at = done.column(which, "node_deg")
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
        name_axes(
            ax, "longitude of the node, °E", "settled, orbits" if which == "vb" else "", f"{TITLES[name]}, SI units"
        )
    axes[0, 0].legend(fontsize=8, frameon=False)
    return figure


def one(r: Result) -> Any:
    """One tumble under all errors: truth, actuators and phases."""
    t, phase = r.time, r["controller.phase"]
    error, rate = errors(r)
    figure, axes = panels(2, 2, 5.6, 2.9, sharex=True)
    end = float(t[np.argmax(phase == 3)]) + 900.0
    top, bottom = axes
    top[0].semilogy(t, np.degrees(error), color=BLUE)
    limit(top[0], 5.0, 1.0)
    name_axes(top[0], "", "angle to LVLH, °", "a tumble under all errors")
    top[1].semilogy(t, rate, color=BLUE)
    limit(top[1], 1e-3)
    name_axes(top[1], "", "rate error, rad/s")
    for i, colour in enumerate((BLUE, RED, GREEN)):
        bottom[0].plot(t, r["plant.dipole"][:, i], color=colour, linewidth=0.7, label=f"rod {i + 1}")
    bottom[0].legend(fontsize=8, frameon=False, loc="lower right", ncols=3)
    name_axes(bottom[0], "time, s", "dipoles given, A m²")
    bottom[1].plot(t, 1e3 * r["plant.h_w"], color=PINK, label="flown")
    bottom[1].plot(t, 1e3 * r["controller.h_w_ref"], color="0.2", linewidth=0.8, linestyle="--", label="planned")
    limit(bottom[1], -30.0, 30.0)
    bottom[1].legend(fontsize=8, frameon=False, loc="lower right")
    name_axes(bottom[1], "time, s", "wheel momentum, mN m s")
    for ax in axes.flat:
        ax.set_xlim(0.0, end)
        for number, colour, _ in _PHASES:
            for begin, stop in _spans(t, phase == number):
                ax.axvspan(begin, min(stop, end), color=colour, zorder=0, linewidth=0)
    names, colours = [name for _, _, name in _PHASES], [colour for _, colour, _ in _PHASES]
    top[1].legend(handles=patches(names, colours), fontsize=8, frameon=False, loc="upper right")
    return figure


def _spans(t: Array, mask: Array) -> list[tuple[float, float]]:
    """Begin and end of each stretch of a mask."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], mask.astype(int), [0]))))
    step = float(t[1] - t[0])
    return [(float(t[a]), float(t[b - 1]) + step) for a, b in edges.reshape(-1, 2)]


def holding(r: Result) -> Any:
    """20 orbits of hold."""
    t = r.time / ORBIT
    error, _ = errors(r)
    figure, axes = panels(1, 2, 5.6, 3.0)
    axes[0, 0].semilogy(t, np.degrees(error), color=BLUE, linewidth=0.7)
    axes[0, 0].set_ylim(bottom=1e-3)
    name_axes(axes[0, 0], "time, orbits", "angle to LVLH, °", "20 orbits of hold, all errors")
    axes[0, 1].plot(t, 1e3 * r["plant.h_w"], color=AMBER, linewidth=0.8)
    limit(axes[0, 1], -30.0, 30.0)
    name_axes(axes[0, 1], "time, orbits", "wheel momentum, mN m s")
    for ax in axes.flat:
        ax.set_xlim(0.0, float(t[-1]))
    return figure
