"""The figures of docs/evidence/reproduction.md."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..paper import LIMITS, TITLES, constants
from ..plots import BLUE, GREEN, RED, legend_below, limit, name_axes, orbits, panels, patches, save
from . import maps, sweep
from .bounds import NODES
from .claims import CLAIMS, HOLDS, hold_outcome

_HOLD_COLOURS = ("#d9d9d9", "#009e73", "#56b4e9", "#d55e00", "#5b2000")


def draw(done: dict[str, Any], folder: Path) -> None:
    """Draws all figures into a folder."""
    save({f"repro-{name}": function(done) for name, function in _FIGURES.items()}, folder)


def lyapunov(done: dict[str, Any]) -> Any:
    """V, dV/dt and the share of the demand that is met, for both manoeuvres in reading (a)."""
    figure, axes = panels(2, 3)
    for row, which in zip(axes, CLAIMS, strict=True):
        r = done[f"{which}: run a"]
        t, s = r.time, r.signals
        row[0].plot(t, 1e3 * s["lyapunov"], color=BLUE)
        name_axes(row[0], "time, s", "Lyapunov function V, mJ", TITLES[which])
        measured = np.gradient(s["lyapunov"], t)
        L = s["gain_l"][:, None] * constants()["controller.L0"][0][0]
        expected = -(L * s["rate_error_B"] ** 2).sum(axis=1)
        row[1].plot(t, 1e6 * measured, color=BLUE, label="dV/dt as flown")
        row[1].plot(t, 1e6 * expected, color=RED, linestyle="--", label="−ω·Lω (constant gains, exact torque)")
        name_axes(row[1], "time, s", "dV/dt, µW", "rate of V")
        row[1].legend(fontsize=8, frameon=False)
        demand = np.linalg.norm(s["tau_cmd_B"], axis=1)
        met = 1.0 - np.linalg.norm(s["tau_residual_B"], axis=1) / np.maximum(demand, 1e-300)
        row[2].plot(t, 100.0 * met, color=GREEN)
        row[2].set_ylim(0.0, 105.0)
        held = s["holding"].astype(bool)
        if held.any():
            row[2].axvspan(t[held][0], t[held][-1] + 0.1, color="0.8")
            row[2].set_xlim(-0.05, 3.0)
        name_axes(
            row[2],
            "time, s",
            "torque demand met, %",
            "share of the demanded torque that is met" + ("\n(first 3 s; shaded: held)" if held.any() else ""),
        )
        for ax in row if not held.any() else row[:2]:
            ax.set_xlim(0, t[-1])
            orbits(ax)
    return figure


def momentum(done: dict[str, Any]) -> Any:
    """Least times against the longitude of the node, in SI units."""
    figure, axes = panels(1, 2, 5.6, 3.6, sharey=True)
    for ax, which in zip(axes[0], CLAIMS, strict=True):
        rods, claimed = LIMITS[which]
        for dipole, colour in ((rods, RED), (25.0, BLUE)):
            times = done[f"{which}: bound {dipole:g} A m2"]
            ax.plot(NODES, times.least, color=colour, marker=".", label=f"{dipole:g} A m² a rod: bound")
            ax.plot(NODES, times.simple, color=colour, linestyle=":", label=f"{dipole:g} A m² a rod: along ΔH only")
        limit(ax, claimed)
        ax.text(346, claimed - 24, f"the paper: {claimed:.0f} s", fontsize=8, color="0.2", ha="right")
        ax.set_xlim(0, 350)
        ax.set_ylim(0, None)
        name_axes(
            ax, "node longitude, °E", "least time, s", f"{TITLES[which]}, SI units:\ntimes below a line are impossible"
        )
        ax.legend(fontsize=8, frameon=False, loc="lower right", ncols=2)
    return figure


def latch(done: dict[str, Any]) -> Any:
    """Returns what became of V.C's hold against node longitude, and one run that latches."""
    figure, axes = panels(1, 3, 4.8, 3.6)
    ax = axes[0][0]
    settings = (("latch 0.65 0.9", "K₀ 0.65, L₀ 0.9"), ("latch 0.4 1", "K₀ 0.4, L₀ 1.0"))
    code = np.array([hold_outcome(done[key]) for key, _ in settings])
    maps.draw(ax, code, np.arange(360.0), np.arange(2), _HOLD_COLOURS)
    ax.set_yticks([0, 1], [text for _, text in settings], rotation=90, va="center")
    name_axes(ax, "node longitude, °E", "", f"{TITLES['V.C']}: the hold")
    r = done["latched run"]
    since = np.nonzero(r.signals["holding"])[0][0]
    for ax, values, label, colour in (
        (axes[0][1], np.degrees(r.signals["attitude_error"]), "attitude error, °", BLUE),
        (axes[0][2], 1e3 * r.signals["h_w"], "wheel momentum, mN m s", RED),
    ):
        ax.plot(r.time, values, color=colour)
        ax.axvspan(r.time[since], r.time[-1], color="0.9", zorder=0)
        ax.set_xlim(0, r.time[-1])
        name_axes(ax, "time, s", label, "a run that latches, node at 200° E; shaded: held")
        orbits(ax)
    limit(axes[0][2], -30.0, 30.0)
    legend_below(figure, patches(HOLDS, _HOLD_COLOURS, code))
    return figure


def convergence(done: dict[str, Any]) -> Any:
    """Random starts with exact torque."""
    figure, axes = panels(1, 3, 4.6, 3.3)
    for schedule, colour, text in (
        ("constant", BLUE, "constant gains"),
        ("error", RED, "gains that follow the errors"),
    ):
        f = done[f"random starts, {schedule}"]
        axes[0][0].plot(np.degrees(f.initial_angle), f.converged, ".", markersize=3, color=colour, label=text)
    name_axes(axes[0][0], "initial attitude error, °", "settled at, s", "settling of 600 random starts, exact torque")
    axes[0][0].legend(fontsize=8, frameon=False)
    f = done["random starts, error"]
    rose = f.steps_up > 0
    axes[0][1].plot(np.degrees(f.initial_angle[rose]), 100 * f.largest_rise[rose], ".", color=RED)
    axes[0][1].set_xlim(0, 180)
    name_axes(
        axes[0][1],
        "initial attitude error, °",
        "rise of V, % of V(0)",
        f"gains that follow the errors: V rose in {rose.sum()} of {len(rose)}",
    )
    f = done["random starts, wrong inertia"]
    both = (done["random starts, error"].converged, f.converged)
    top = max(np.nanmax(b) for b in both)
    bins = np.linspace(100.0, top + 5.0, 40)
    axes[0][2].hist(both[0], bins, color="0.75", label="inertia known")
    axes[0][2].hist(both[1], bins, histtype="step", color=RED, label="inertia off by up to 10%")
    axes[0][2].legend(fontsize=8, frameon=False)
    name_axes(axes[0][2], "settled at, s", "cases of 600", "inertia known and wrong, exact torque")
    return figure


def robustness(done: dict[str, Any]) -> Any:
    """Drag that the law does not know, and inertia errors, with the actuators in the loop."""
    figure, axes = panels(1, 3, 4.6, 3.3)
    for which, colour in zip(CLAIMS, (BLUE, RED), strict=True):
        seen = done[f"{which}: drag"]
        axes[0][0].loglog(
            sweep.drag_moments(which), np.degrees(seen.attitude_error), color=colour, marker=".", label=which
        )
        seen = done[f"{which}: wrong inertia"]
        axes[0][1].hist(seen.settled, np.arange(165.0, 240.0, 3.0), histtype="step", color=colour, label=which)
        axes[0][1].axvline(LIMITS[which][1], color=colour, linestyle=(0, (5, 3)), linewidth=0.9)
        axes[0][2].hist(seen.dipole, np.arange(10.0, 22.0, 0.5), histtype="step", color=colour, label=which)
    limit(axes[0][0], 1e-5, along="x")
    axes[0][0].text(8e-6, 0.2, "the paper's 10⁻⁵ N m", fontsize=8, ha="right", va="bottom")
    name_axes(
        axes[0][0],
        "drag moment at the end (SI), N m",
        "attitude error at the end, °",
        "drag that the law does not know",
    )
    axes[0][1].set_xlim(165, 240)
    name_axes(axes[0][1], "settled at, s", "cases of 200", "inertia off by up to 10% (dashed: the paper's time)")
    name_axes(axes[0][2], "largest dipole of a rod, A m²", "cases of 200", "inertia off by up to 10%")
    for ax in axes[0]:
        ax.legend(fontsize=8, frameon=False)
    return figure


def orbit(done: dict[str, Any]) -> Any:
    """LVLH hold over an orbit."""
    figure, axes = panels(1, 3, 4.6, 3.2)
    for key, colour, text in (
        ("hold over an orbit", BLUE, "drag as modelled"),
        ("with drag", RED, "drag of 10⁻⁵ N m (SI)"),
    ):
        r = done[key]
        s, minutes = r.signals, r.time / 60.0
        if colour == BLUE:
            axes[0][0].plot(minutes, s["b_wheel"], color=BLUE)
        axes[0][1].semilogy(minutes[1:], np.degrees(s["attitude_error"][1:]), color=colour, label=text)
        axes[0][2].semilogy(minutes[1:], s["demand_fraction"][1:], color=colour, label=text)
    axes[0][0].axhline(0.0, color="0.3", linewidth=0.8)
    name_axes(axes[0][0], "time, min", "b₁, unit field along the wheel axis", "LVLH hold over an orbit, node at 158° E")
    axes[0][1].set_ylim(1e-6, None)
    name_axes(axes[0][1], "time, min", "attitude error, °", "attitude error left by drag")
    axes[0][1].legend(fontsize=8, frameon=False)
    limit(axes[0][2], 0.8)
    axes[0][2].set_ylim(1e-8, 3.0)
    name_axes(axes[0][2], "time, min", "largest demand over its limit", "demand (dashed: where commands are held)")
    for ax in axes[0]:
        ax.set_xlim(0, minutes[-1])
    return figure


_FIGURES = {
    "lyapunov": lyapunov,
    "momentum": momentum,
    "nodes": maps.nodes,
    "latch": latch,
    "convergence": convergence,
    "robustness": robustness,
    "orbit": orbit,
}
