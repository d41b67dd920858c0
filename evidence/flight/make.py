"""Flies the campaigns of docs/evidence/flight.md, writes docs/evidence/flight.csv from their datasets, and makes page
and figures from it."""

from __future__ import annotations

from pathlib import Path

from orchestration import Result, run

from ..crew import crew
from ..paper import FOLDER as STUDIES
from ..paper import ROOT
from . import figures, kept, page
from .bound import bound, starts
from .groups import all_groups
from .schemes import base

FOLDER = STUDIES / "flight"
BOUNDED = {"nominal", "errors", "vb", "vc"}
"""Groups whose flights are set beside their momentum bound."""


def make(n: int = 1000, jobs: int = 2) -> Path:
    """Flies, draws and writes; returns the page. With fewer than 1000 tumbles all of it goes to a folder of its own."""
    results = FOLDER if n >= 1000 else FOLDER / f"trial-{n}"
    folder = ROOT / "docs" / "evidence" if n >= 1000 else results
    folder.mkdir(parents=True, exist_ok=True)
    with crew(jobs) as hands:
        flown = [(group, hands.fly(group.case, results)) for group in all_groups(n)]
        bounds = {g.name: hands.each(f"bound of {g.name}", bound, starts(g)) for g, _ in flown if g.name in BOUNDED}
    kept.save(folder / "flight.csv", flown, bounds)
    return publish(folder)


def publish(folder: Path = ROOT / "docs" / "evidence") -> Path:
    """Makes page and figures from the files in the folder; flies only the two scenarios that are drawn."""
    flights = kept.load(folder / "flight.csv")
    tumble = shown("tumble", "controller.phase", "plant.dipole", "controller.h_w_ref")
    hold = shown("hold")
    figures.draw(flights, tumble, hold, folder.parent / "figures")
    target = folder / "flight.md"
    target.write_text(page.text(flights), "utf-8")
    return target


def shown(scenario: str, *signals: str) -> Result:
    """A flight scenario as it stands, with more signals, for a figure."""
    data = base(scenario)
    errors = ("judge.attitude_error", "judge.rate_error_B", "plant.h_w")
    data["record"] = {"interval": 10.0 if scenario == "hold" else 1.0, "signals": [*errors, *signals]}
    return run(data)
