"""The figures of the reproduction page. Matplotlib is imported only when they are drawn."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from . import sweep
from .claims import CLAIMS, HOLDS, ORBIT, OUTCOMES, all_hold, hold_outcome, outcome
from .reproduction import BOUND_NODES, PAPER_LIMITS, Run, Times
from .vectors import Array
from .watch import Seen

BLUE, RED, GREEN, PINK, SKY, AMBER = "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"
_OUTCOME_COLOURS = (GREEN, "#b3e2cd", AMBER, RED, "#5b2000")
_HOLD_COLOURS = ("#d9d9d9", GREEN, SKY, RED, "#5b2000")


def draw(done: dict[str, Any], folder: Path) -> None:
    """Draws all figures into a folder."""
    save({f"repro-{name}": function(done) for name, function in _FIGURES.items()}, folder)


def save(figures: Mapping[str, Any], folder: Path) -> None:
    """Writes figures by their names, with nothing in a file that changes from day to day."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, figure in figures.items():
        figure.savefig(folder / f"{name}.png", dpi=130, metadata={"Software": None})


def panels(rows: int, columns: int, width: float = 4.6, height: float = 3.2, **options: Any) -> tuple[Any, Any]:
    """A figure of rows x columns axes, each `width` x `height` inches."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width * columns, height * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    for ax in axes.flat:
        ax.tick_params(labelsize=8)
        ax.grid(True, color="0.92", linewidth=0.6)
        ax.set_axisbelow(True)
    return figure, axes


def name_axes(ax: Any, x: str, y: str, title: str = "") -> None:
    ax.set_xlabel(x, fontsize=9)
    ax.set_ylabel(y, fontsize=9)
    if title:
        ax.set_title(title, fontsize=10)


def _orbits(ax: Any) -> None:
    above = ax.secondary_xaxis("top", functions=(lambda t: t / ORBIT, lambda n: n * ORBIT))
    above.set_xlabel("orbits", fontsize=8)
    above.tick_params(labelsize=7)


def lyapunov(done: dict[str, Any]) -> Any:
    """V, dV/dt and the share of the demand that is met, for both manoeuvres in reading (a)."""
    figure, axes = panels(2, 3)
    for row, which in zip(axes, CLAIMS, strict=True):
        r: Run = done[f"{which}: run a"]
        t, s = r.time, r.signals
        row[0].plot(t, 1e3 * s["lyapunov"], color=BLUE)
        name_axes(row[0], "time, s", "V, mJ", f"{which}: Lyapunov function [11]")
        measured = np.gradient(s["lyapunov"], t)
        L = s["gain_l"][:, None] * sweep.constants()["controller.L0"][0][0]
        expected = -(L * s["rate_error_B"] ** 2).sum(axis=1)
        row[1].plot(t, 1e6 * measured, color=BLUE, label="dV/dt as flown")
        row[1].plot(t, 1e6 * expected, color=RED, linestyle="--", label="−ω·Lω (constant gains, exact torque)")
        name_axes(row[1], "time, s", "µW", f"{which}: dV/dt")
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
            "1 − |unmet|/|demand|, %",
            f"{which}: share of the demand met" + (" (start)" if held.any() else ""),
        )
        for ax in row if not held.any() else row[:2]:
            ax.set_xlim(0, t[-1])
            _orbits(ax)
    return figure


def momentum(done: dict[str, Any]) -> Any:
    """Least times against the longitude of the node, in SI units."""
    figure, axes = panels(1, 2, 5.6, 3.6, sharey=True)
    for ax, which in zip(axes[0], CLAIMS, strict=True):
        limit, claimed = PAPER_LIMITS[which]
        for dipole, colour in ((limit, RED), (25.0, BLUE)):
            times: Times = done[f"{which}: bound {dipole:g} A m2"]
            ax.plot(BOUND_NODES, times.least, color=colour, marker=".", label=f"{dipole:g} A m² a rod: convex bound")
            ax.plot(
                BOUND_NODES, times.simple, color=colour, linestyle=":", label=f"{dipole:g} A m² a rod: along ΔH only"
            )
        ax.axhline(claimed, color="0.2", linestyle=(0, (5, 3)), linewidth=1)
        ax.text(346, claimed - 24, f"the paper: {claimed:.0f} s", fontsize=8, color="0.2", ha="right")
        ax.set_xlim(0, 350)
        ax.set_ylim(0, None)
        name_axes(
            ax, "node longitude, °E", "least time, s", f"{which} in SI units: times below each line are impossible"
        )
        ax.legend(fontsize=8, frameon=False, loc="lower right", ncols=2)
    return figure


def _map(ax: Any, code: Array, x: Array, y: Array, colours: tuple[str, ...]) -> None:
    from matplotlib.colors import ListedColormap

    cmap = ListedColormap(colours)
    ax.grid(False)
    ax.pcolormesh(x, y, code, cmap=cmap, vmin=-0.5, vmax=len(colours) - 0.5, shading="nearest")


def _legend(figure: Any, names: tuple[str, ...], colours: tuple[str, ...], shown: Array) -> None:
    """What the colours mean, of those that occur in `shown`."""
    from matplotlib.patches import Patch

    handles = [Patch(facecolor=colours[i], edgecolor="0.5", label=names[i]) for i in np.unique(shown)]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), fontsize=8, frameon=False)


def _both(done: dict[str, Any], key: str, shape: tuple[int, int]) -> Array:
    """0 where V.B and V.C keep every claim, 1 where V.B alone, 2 where V.C alone, 3 where neither."""
    b, c = (all_hold(w, done[f"{w}: {key}"]).reshape(shape) for w in CLAIMS)
    return np.select([b & c, b, c], [0, 1, 2], 3)


_BOTH = ("both", "V.B only", "V.C only", "neither")
_BOTH_COLOURS = (GREEN, SKY, AMBER, "#eeeeee")


def _maps(
    done: dict[str, Any], key: str, x: Array, y: Array, labels: tuple[str, str], nominal: tuple[float, float]
) -> Any:
    from matplotlib.patches import Patch

    figure, axes = panels(1, 3, 4.6, 4.0, sharey=True)
    shape = (len(y), len(x))
    codes = [outcome(which, done[f"{which}: {key}"]).reshape(shape) for which in CLAIMS]
    for ax, which, code in zip(axes[0][:2], CLAIMS, codes, strict=True):
        _map(ax, code, x, y, _OUTCOME_COLOURS)
        name_axes(ax, labels[0], labels[1] if which == "V.B" else "", which)
    _map(axes[0][2], _both(done, key, shape), x, y, _BOTH_COLOURS)
    name_axes(axes[0][2], labels[0], "", "every claim holds in")
    for ax in axes[0]:
        ax.plot(*nominal, marker="+", color="black", markersize=10, markeredgewidth=1.5)
    handles = [Patch(facecolor=c, edgecolor="0.5", label=n) for n, c in zip(_BOTH, _BOTH_COLOURS, strict=True)]
    axes[0][2].legend(handles=handles, fontsize=8, loc="upper right", framealpha=0.9)
    _legend(figure, OUTCOMES, _OUTCOME_COLOURS, np.array(codes))
    return figure


def nodes(done: dict[str, Any]) -> Any:
    return _maps(
        done,
        "node and K0",
        sweep.NODES,
        sweep.K_SCALES,
        ("node longitude, °E", "K₀'s scale, N m (before /50)"),
        (158.0, 0.65),
    )


def gains(done: dict[str, Any]) -> Any:
    return _maps(
        done,
        "K0 and L0",
        sweep.K_SCALES,
        sweep.L_SCALES,
        ("K₀'s scale, N m (before /50)", "L₀'s scale, N m s (before /50)"),
        (0.65, 0.9),
    )


def steps(done: dict[str, Any]) -> Any:
    """Node longitude against control step."""
    figure, axes = panels(1, 2, 5.6, 3.4, sharey=True)
    rows = np.arange(len(sweep.STEPS))
    shown = []
    for ax, which in zip(axes[0], CLAIMS, strict=True):
        code = np.array([outcome(which, done[f"{which}: step {s:g} s"]) for s in sweep.STEPS])
        shown.append(code)
        _map(ax, code, sweep.NODES, rows, _OUTCOME_COLOURS)
        ax.set_yticks(rows, [f"{s:g}" for s in sweep.STEPS])
        ax.plot(158.0, sweep.STEPS.index(0.1), marker="+", color="black", markersize=10, markeredgewidth=1.5)
        name_axes(ax, "node longitude, °E", "control step, s" if which == "V.B" else "", which)
    _legend(figure, OUTCOMES, _OUTCOME_COLOURS, np.array(shown))
    return figure


def latch(done: dict[str, Any]) -> Any:
    """What became of V.C's hold against node longitude, and one run that latches."""
    figure, axes = panels(1, 3, 4.8, 3.6)
    ax = axes[0][0]
    settings = (("latch 0.65 0.9", "K₀ 0.65, L₀ 0.9"), ("latch 0.4 1", "K₀ 0.4, L₀ 1.0"))
    code = np.array([hold_outcome(done[key]) for key, _ in settings])
    _map(ax, code, np.arange(360.0), np.arange(2), _HOLD_COLOURS)
    ax.set_yticks([0, 1], [text for _, text in settings], rotation=90, va="center")
    name_axes(ax, "node longitude, °E", "", "V.C: what becomes of the hold")
    r: Run = done["latched run"]
    since = np.nonzero(r.signals["holding"])[0][0]
    for ax, values, label, colour in (
        (axes[0][1], np.degrees(r.signals["attitude_error"]), "attitude error, °", BLUE),
        (axes[0][2], 1e3 * r.signals["h_w"], "wheel momentum, mN m s", RED),
    ):
        ax.plot(r.time, values, color=colour)
        ax.axvspan(r.time[since], r.time[-1], color="0.9", zorder=0)
        ax.set_xlim(0, r.time[-1])
        name_axes(ax, "time, s", label, "V.C, node at 200° E; shaded: held")
        _orbits(ax)
    for y in (-30.0, 30.0):
        axes[0][2].axhline(y, color="0.3", linestyle=(0, (5, 3)), linewidth=0.9)
    _legend(figure, HOLDS, _HOLD_COLOURS, code)
    return figure


def convergence(done: dict[str, Any]) -> Any:
    """Random starts with exact torque."""
    figure, axes = panels(1, 3, 4.6, 3.3)
    for schedule, colour, text in (("constant", BLUE, "constant gains"), ("error", RED, "gains [10]")):
        f = done[f"random starts, {schedule}"]
        axes[0][0].plot(np.degrees(f.initial_angle), f.converged, ".", markersize=3, color=colour, label=text)
    name_axes(axes[0][0], "initial attitude error, °", "settled at, s", "600 random starts, exact torque")
    axes[0][0].legend(fontsize=8, frameon=False)
    f = done["random starts, error"]
    rose = f.steps_up > 0
    axes[0][1].plot(np.degrees(f.initial_angle[rose]), 100 * f.largest_rise[rose], ".", color=RED)
    axes[0][1].set_xlim(0, 180)
    name_axes(
        axes[0][1],
        "initial attitude error, °",
        "rise of V, % of V(0)",
        f"gains [10]: V rose in {rose.sum()} of {len(rose)}",
    )
    f = done["random starts, wrong inertia"]
    both = (done["random starts, error"].converged, f.converged)
    top = max(np.nanmax(b) for b in both)
    bins = np.linspace(100.0, top + 5.0, 40)
    axes[0][2].hist(both[0], bins, color="0.75", label="inertia known")
    axes[0][2].hist(both[1], bins, histtype="step", color=RED, label="inertia off by up to 10%")
    axes[0][2].legend(fontsize=8, frameon=False)
    name_axes(axes[0][2], "settled at, s", "cases", "gains [10], exact torque")
    return figure


def robustness(done: dict[str, Any]) -> Any:
    """Drag that the law does not know, and inertia errors, with the actuators in the loop."""
    figure, axes = panels(1, 3, 4.6, 3.3)
    for which, colour in zip(CLAIMS, (BLUE, RED), strict=True):
        seen: Seen = done[f"{which}: drag"]
        axes[0][0].loglog(
            sweep.drag_moments(which), np.degrees(seen.attitude_error), color=colour, marker=".", label=which
        )
        seen = done[f"{which}: wrong inertia"]
        axes[0][1].hist(seen.settled, np.arange(165.0, 240.0, 3.0), histtype="step", color=colour, label=which)
        axes[0][1].axvline(PAPER_LIMITS[which][1], color=colour, linestyle=(0, (5, 3)), linewidth=0.9)
        axes[0][2].hist(seen.dipole, np.arange(10.0, 22.0, 0.5), histtype="step", color=colour, label=which)
    axes[0][0].axvline(1e-5, color="0.3", linestyle=(0, (5, 3)), linewidth=0.9)
    axes[0][0].text(8e-6, 0.2, "the paper's 10⁻⁵ N m", fontsize=8, ha="right", va="bottom")
    name_axes(axes[0][0], "drag moment at the end (SI), N m", "attitude error at the end, °", "unmodelled drag")
    axes[0][1].set_xlim(165, 240)
    name_axes(axes[0][1], "settled at, s", "cases of 200", "inertia off by up to 10%")
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
        r: Run = done[key]
        s, minutes = r.signals, r.time / 60.0
        if colour == BLUE:
            axes[0][0].plot(minutes, s["b_wheel"], color=BLUE)
        axes[0][1].semilogy(minutes[1:], np.degrees(s["attitude_error"][1:]), color=colour, label=text)
        axes[0][2].semilogy(minutes[1:], s["demand_fraction"][1:], color=colour, label=text)
    axes[0][0].axhline(0.0, color="0.3", linewidth=0.8)
    name_axes(axes[0][0], "time, min", "b₁ (unit field along the wheel)", "LVLH hold, one orbit, node at 158° E")
    axes[0][1].set_ylim(1e-6, None)
    name_axes(axes[0][1], "time, min", "attitude error, °", "what drag leaves")
    axes[0][1].legend(fontsize=8, frameon=False)
    axes[0][2].axhline(0.8, color="0.3", linestyle=(0, (5, 3)), linewidth=0.9)
    axes[0][2].set_ylim(1e-8, 3.0)
    name_axes(axes[0][2], "time, min", "largest demand over limit", "dashed: the hold's 80%")
    for ax in axes[0]:
        ax.set_xlim(0, minutes[-1])
    return figure


_FIGURES = {
    "lyapunov": lyapunov,
    "momentum": momentum,
    "nodes": nodes,
    "gains": gains,
    "steps": steps,
    "latch": latch,
    "convergence": convergence,
    "robustness": robustness,
    "orbit": orbit,
}
