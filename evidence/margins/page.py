"""Writes docs/evidence/margins.md and its figure from docs/evidence/margins.json. Tests:
tests/evidence/margins/test_make.py."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

from .. import plots
from ..markdown import render
from ..paper import ORBIT, ROOT
from .cases import CASES, GAINS, PLACES, USUAL, VB, largest
from .make import KEPT

PAGE = ROOT / "docs" / "evidence" / "margins.md"
ABOUT = {(1, 1, 1): "aligned", (-1, -1, 1): "half a turn about z", (-1, 1, -1): "about y", (1, -1, -1): "about x"}
LOST = 0.5
"""Attitude error, deg, with which the scenario of the planned hold calls it lost."""
NOISY = 0.05
"""Error above which answers have decayed to rounding."""


def write() -> Path:
    """Writes both, and returns the page."""
    kept = json.loads(KEPT.read_text("utf-8"))
    plots.save({"margins": _figure(kept)}, ROOT / "docs" / "figures")
    PAGE.write_text(render(Path(__file__).parent, **fields(kept)), "utf-8")
    return PAGE


def fields(kept: dict[str, Any]) -> dict[str, Any]:
    """Returns what the template takes."""
    rows = sorted(kept["places"], key=lambda row: (list(CASES).index(row["case"]), row["place"]))
    of = {name: [row for row in rows if row["case"] == name] for name in CASES}
    followed = {name: found for name, found in of.items() if CASES[name].followed and found}
    return {
        "places": [_row(row) for row in rows if "disk" in row],
        "reasons": [_reason(row) for row in rows if row["refused"]],
        "left": [_left(name, found) for name, found in followed.items()],
        "orbits": [_orbits(name, found) for name, found in followed.items()],
        "errors": max(row["error"] for row in rows if "left" in row and not row["refused"]),
        "seconds": max((sum(row["seconds"] for row in found) for found in followed.values()), default=0.0),
        "linear": sum(not row["refused"] for found in followed.values() for row in found),
        "followed": len(PLACES) * sum(case.followed for case in CASES.values()),
        "equilibria": [_equilibrium(one) for one in kept["equilibria"]],
        "all": len(PLACES),
        "vb": [row for row in of[VB] if "disk" in row],
        "usual": [row for row in of[USUAL] if "disk" in row],
        "loss": next(one for one in kept["changes"] if (one["case"], one["name"]) == (VB, "delay")),
        "changes": [_change(one, of[VB]) for one in kept["changes"]],
        "flown": [
            [name, f"{max(row['flown'] for row in found):.2g}°"]
            for name, found in followed.items()
            if "flown" in found[0]
        ],
        "sensitivity": [
            [one["parameter"], f"{one['slope']:+.2g}", f"{one['apart']:.1g}"] for one in kept.get("sensitivity", [])
        ],
        "older": list(
            dict.fromkeys(
                row.get("case", f"delay, {row.get('name')}") for row in [*rows, *kept["delays"]] if "inputs" not in row
            )
        ),
        "slopes": [_slopes(one) for one in kept["equilibria"] if "slopes" in one],
        "delays": [_delay(row) for row in sorted(kept["delays"], key=lambda row: (row["name"], row["delay"]))],
        "losses": losses(kept["delays"]),
    }


def losses(rows: list[dict[str, Any]]) -> dict[str, tuple[float, float]]:
    """Returns the delay at which the answer to a pulse no longer decays, and that at which the flight is lost, s, each
    between two delays by the logarithm. A flight as it is has the answers of one without the watch."""
    found: dict[str, tuple[float, float]] = {}
    names = list(dict.fromkeys(row["name"] for row in rows))
    for name in names:
        of = sorted((row["delay"], row["left"], row["flown"], row["error"]) for row in rows if row["name"] == name)
        said = (
            of
            if name != "as it is"
            else sorted(
                (row["delay"], row["left"], row["flown"], row["error"])
                for row in rows
                if row["name"] == names_without(names)
            )
        )
        predicted = _crossing([(d, left) for d, left, _, error in said if error <= NOISY], 1.0)
        found[name] = predicted, _crossing([(d, flown) for d, _, flown, _ in of], LOST)
    return found


def names_without(names: list[str]) -> str:
    """Returns the name of the flights whose linear loop is that of the hold as it is."""
    return next(name for name in names if name == "no watch for failed rods")


def _crossing(points: list[tuple[float, float]], level: float) -> float:
    for (a, below), (b, above) in pairwise(points):
        if below < level <= above:
            return a + (b - a) * math.log(level / below) / math.log(above / below)
    return math.nan


def _left(name: str, rows: list[dict[str, Any]]) -> list[str]:
    """What is left after 200 s at each place."""
    by = {row["place"]: row for row in rows}
    cells = []
    for place in PLACES:
        row = by.get(place)
        cells.append("not measured" if row is None else "not linear" if row["refused"] else f"{row['left']:.2g}")
    return [name, *cells]


def _orbits(name: str, rows: list[dict[str, Any]]) -> list[str]:
    """What is left after an orbit at each place."""
    by = {row["place"]: row for row in rows}
    cells = []
    for place in PLACES:
        row = by.get(place)
        known = row is not None and "orbit" in row and row["wrong"] <= NOISY and row["left"] > 1e-4
        cells.append(f"{row['orbit']:.2g}" if row is not None and known else "none")
    rest = [row["rest"] for row in rows if "rest" in row]
    return [name, *cells, f"{100 * min(rest):.0f}%" if rest else ""]


def _delay(row: dict[str, Any]) -> list[str]:
    left = "not linear" if row["error"] > NOISY else f"{row['left']:.2f}"
    return [row["name"], f"{row['delay']:g} s", left, f"{row['flown']:.2g}°"]


def _row(row: dict[str, Any]) -> list[str]:
    up = f"{row['up']:.1f} dB" if math.isfinite(row["up"]) else "any"
    numbers = [f"{row['disk']:.3f}", up, f"{row['phase']:.1f}°", f"{row['delay']:.2f} s"]
    certain = [f"{100 * row['error']:.2g}%", f"{100 * row['change']:.2g}%"]
    return [row["case"], f"{row['place']}°", *numbers, *certain]


def _reason(row: dict[str, Any]) -> list[str]:
    return [row["case"], f"{row['place']}°", row["refused"].partition(": no p")[0].partition(" (its answer")[0]]


def _change(one: dict[str, Any], rows: list[dict[str, Any]]) -> list[str]:
    """A change that loses a hold, beside what the margins of V.B say of it."""
    said = "none"
    if one["case"] == VB:
        margin = {"delay": min(row["delay"] for row in rows), "gain": 10 ** (min(row["up"] for row in rows) / 20)}
        known = one["name"] in margin and one["end"] > 1.0
        said = f"{margin[one['name']]:.4g}" if known else "any" if one["name"] == "gain" else "none"
    lost = f"not lost to {one['end']:g}" if one["lost"] is None else f"{one['lost']:.4g}"
    return [one["case"], one["name"], f"{one['holds']:.4g}", lost, said]


def _slopes(one: dict[str, Any]) -> list[str]:
    """How the largest rate depends on parameters, 1/s for a relative change of one."""
    return [ABOUT[tuple(one["turn"])], *(f"{one['slopes'][name][0]:+.4f}" for name in GAINS)]


def _equilibrium(one: dict[str, Any]) -> list[str]:
    rates = sorted(one["rates"], key=abs)[1:]
    unstable = [rate for rate in rates if rate > 0.0]
    worst = largest(one["rates"])
    size = worst * ORBIT / math.log(10)
    return [ABOUT[tuple(one["turn"])], str(len(unstable)), f"{worst:+.5f} 1/s", f"10^{size:+.0f}", f"{one['rest']:.1g}"]


def _figure(kept: dict[str, Any]) -> Any:
    rows = kept["places"]
    figure, (axes,) = plots.panels(1, 3)
    colours = plots.BLUE, plots.RED, plots.GREEN, plots.PINK, plots.AMBER
    for name, colour in zip((VB, USUAL), colours, strict=False):
        good = sorted((row["place"], row["delay"]) for row in rows if row["case"] == name and "disk" in row)
        axes[0].plot(*zip(*good, strict=True), "o", color=colour, label=name)
    for name, colour in zip((name for name in CASES if CASES[name].followed), colours, strict=False):
        good = sorted(
            (row["place"], row["left"]) for row in rows if row["case"] == name and "left" in row and not row["refused"]
        )
        if good:
            axes[1].semilogy(*zip(*good, strict=True), "o-", color=colour, label=name)
    axes[1].axhline(1.0, color="0.6", lw=0.8)
    for name, colour in zip(dict.fromkeys(row["name"] for row in kept["delays"]), colours, strict=False):
        points = sorted(
            (row["delay"], row["left"], row["flown"], row["error"]) for row in kept["delays"] if row["name"] == name
        )
        linear = [(d, left) for d, left, _, error in points if error <= NOISY]
        axes[2].semilogy(*zip(*linear, strict=True), "o-", color=colour, label=f"{name}: answer left")
        axes[2].semilogy([d for d, *_ in points], [p[2] / LOST for p in points], "x--", color=colour)
    axes[2].axhline(1.0, color="0.6", lw=0.8)
    where = "place from the ascending node, deg"
    plots.name_axes(axes[0], where, "delay margin, s", "Holds with margins")
    plots.name_axes(axes[1], where, "left of a disturbance after 200 s", "Holds whose answers are followed")
    plots.name_axes(
        axes[2], "delay at the actuators, s", "left after 1000 s; error / 0.5 deg (x)", "Planned hold with a delay"
    )
    axes[0].set_ylim(0.0, 10.0)
    for ax in axes:
        ax.legend(fontsize=7)
    return figure
