"""Flies the cases of docs/flight.md, keeps them in docs/flight.csv, and makes page and figures from it."""

from __future__ import annotations

import json
from pathlib import Path

from orchestration import InputError, Result
from orchestration.errors import hint

from .. import native
from ..paper import ROOT
from . import figures, kept, page
from .calls import calls
from .cases import BESIDE, SEEDS, TRIES, base, share
from .run import BLOCKS, FOLDER, Row, compute, fly
from .tried import all_cases

BOUNDED = {"nominal", "errors", "vb", "vc"}
"""Groups whose cases are set beside their momentum bound."""


def make(n: int = 1000, processes: int = 2) -> Path:
    """Flies, draws and writes; returns the page. With fewer than 1000 cases it is written beside the rows, not to docs/."""
    folder = ROOT / "docs" if n >= 1000 else FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    cases = all_cases(n)
    kept.save(folder / "flight.csv", cases, *compute(cases, BOUNDED, processes))
    return publish(folder)


def publish(folder: Path = ROOT / "docs") -> Path:
    """Makes page and figures from flight.csv in the folder; flies only the two scenarios that are drawn."""
    flights = kept.load(folder / "flight.csv")
    tumble = shown("tumble", "plant.dipole", "plant.wheel_torque", "controller.h_w_ref", "controller.tau_cmd_B")
    hold = shown("hold", "allocator.b_wheel")
    figures.draw(flights, tumble, hold, folder / "figures")
    target = folder / "flight.md"
    target.write_text(page.text(flights, hold, calls()), "utf-8")
    return target


def shown(scenario: str, *signals: str) -> Result:
    """A flight scenario as it stands, with more signals, for a figure."""
    data = base(scenario)
    interval = 10.0 if scenario == "hold" else 1.0
    data["record"] = {"interval": interval, "signals": [*data["record"]["signals"], *signals]}
    return native.run(data, native.pin(BLOCKS))


def seeds_text(n: int) -> str:
    """The seeds of a study with n cases, in words."""
    sets = [(n, "nominal"), (n, "errors"), (share(n, TRIES), "tried")]
    ranges = "; ".join(f"{name} {SEEDS[name]} to {SEEDS[name] + count - 1}" for count, name in sets)
    return f"seeds: {ranges}; the first {share(n, BESIDE)} of nominal and errors also by the other schemes"


def write_case(group: str, seed: int) -> tuple[Path, Row]:
    """Flies one case, and writes its scenario to a file that `orchestrate` runs. Raises InputError for one that is not there."""
    cases = {case.name: case for case in all_cases(1000) if case.seed == seed}
    name = f"{group}/{seed}"
    if name not in cases:
        groups = sorted({case.group for case in cases.values()})
        raise InputError(
            f"{name}: there is no such case{hint(name, cases)}; of this seed there are: {', '.join(groups) or 'none'}"
        )
    case = cases[name]
    row = fly(case, native.pin(BLOCKS))
    label = "".join(c if c.isalnum() else "_" for c in name)
    file = FOLDER / f"{label}.yaml"
    file.parent.mkdir(parents=True, exist_ok=True)
    data = {**case.data, "name": f"flight_{label}", "duration": row.get("duration", case.lengths[0])}
    file.write_text(json.dumps(data, indent=1), "utf-8")
    return file, row
