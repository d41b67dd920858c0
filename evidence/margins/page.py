"""Writes docs/evidence/margins.md and its figure from docs/evidence/margins.json. Tests:
tests/evidence/margins/test_make.py."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from .. import plots
from ..markdown import render
from ..paper import ORBIT, ROOT
from .cases import CASES, FOUR, PLACES, PLANNED, THREE, USUAL, VB, largest
from .make import KEPT

PAGE = ROOT / "docs" / "evidence" / "margins.md"
ABOUT = {(1, 1, 1): "aligned", (-1, -1, 1): "half a turn about z", (-1, 1, -1): "about y", (1, -1, -1): "about x"}
LOST = 0.5
"""Attitude error, deg, with which the scenario of the planned hold calls it lost."""
NOISY = 0.05
"""Error above which answers have decayed to rounding."""
MARGINS = tuple(name for name, case in CASES.items() if not case.followed)
"""The holds that have margins of a moment."""
BENEATH = 1e-4
"""What is left after 200 s with which nothing is left to see after an orbit."""


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
        "places": [_range(name, [row for row in of[name] if "disk" in row]) for name in MARGINS],
        "reasons": [_reason(row) for row in rows if row["refused"]],
        "decays": [_decay(name, found) for name, found in followed.items()],
        "errors": max(row["error"] for row in rows if "left" in row and not row["refused"]),
        "forgets": [end(row["left"] for row in of[PLANNED]) for end in (min, max)],
        "lost": LOST,
        "linear": sum(not row["refused"] for found in followed.values() for row in found),
        "followed": len(PLACES) * sum(case.followed for case in CASES.values()),
        "equilibria": [_equilibrium(one) for one in kept["equilibria"]],
        "all": len(PLACES),
        "vb": [row for row in of[VB] if "disk" in row],
        "usual": [row for row in of[USUAL] if "disk" in row],
        "sets": [row for name in (THREE, FOUR) for row in of[name] if "disk" in row],
        "loss": next(one for one in kept["changes"] if (one["case"], one["name"]) == (VB, "delay")),
        "changes": [_change(one, of[VB]) for one in kept["changes"]],
        "delays": [_delay(name, *both, kept["delays"]) for name, both in losses(kept["delays"]).items()],
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


def _decay(name: str, rows: list[dict[str, Any]]) -> list[str]:
    """Returns what is left of a disturbance after 200 s and after an orbit, from the least place to the most."""
    linear = [row for row in rows if not row["refused"]]
    known = [row for row in linear if "orbit" in row and row["wrong"] <= NOISY and row["left"] > BENEATH]
    left, orbits = _ends([row["left"] for row in linear]), _ends([row["orbit"] for row in known])
    if len(linear) < len(rows):
        left += f"; not linear at {len(rows) - len(linear)} places"
    rest = f"{100 * min(row['rest'] for row in known):.0f}%" if known else "none"
    flown = f"{max(row['flown'] for row in rows):.2g}°" if "flown" in rows[0] else "none"
    return [name, left, orbits, rest, flown]


def _ends(values: Sequence[float]) -> str:
    return f"{min(values):.2g} to {max(values):.2g}" if values else "none"


def _delay(name: str, predicted: float, lost: float, rows: list[dict[str, Any]]) -> list[str]:
    """The delays that lose a planned hold, and those between which it is seen to be lost, with their errors."""
    flown = sorted((row["delay"], row["flown"]) for row in rows if row["name"] == name)
    ends = max(one for one in flown if one[1] < LOST), min(one for one in flown if one[1] >= LOST)
    seen = [f"{delay:g} s ({error:.2g}°)" for delay, error in ends]
    return [name, f"{predicted:.2f} s", f"{lost:.2f} s", f"{100 * (predicted / lost - 1):.0f}%", *seen]


def _range(name: str, rows: list[dict[str, Any]]) -> list[str]:
    """The margins of a hold, from the least place to the most."""

    def ends(key: str, form: str, unit: str) -> str:
        low, high = (format(end(row[key] for row in rows), form) for end in (min, max))
        return f"{low}{unit}" if low == high else f"{low} to {high}{unit}"

    most = [f"{100 * max(row[key] for row in rows):.2g}%" for key in ("error", "change")]
    margins = [ends("disk", ".3f", ""), ends("up", ".1f", " dB"), ends("phase", ".1f", "°"), ends("delay", ".2f", " s")]
    return [name, f"{len(rows)} of {len(PLACES)}", *margins, *most]


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
    for name, colour in zip(MARGINS, colours, strict=False):
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
