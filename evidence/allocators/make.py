"""The paper's allocator and the bounded one under the paper's law, at nodes round the Earth: runs of the FMUs.

Each run lasts an orbit: the manoeuvre, which is judged by its first 1/15 of an orbit as the paper does, and the hold
that follows it. Tests: tests/evidence/allocators/test_allocators.py.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from orchestration.session.read import read

from .. import crew as campaigns
from ..paper import ATTITUDE_TOLERANCE, FOLDER, LIMITS, ORBIT, RATE_TOLERANCE, READINGS, ROOT, SCENARIOS, STEP, Array
from .metrics import END

NODES = np.arange(0.0, 360.0, 10.0)
"""Longitudes of the ascending node, degrees east."""
KEPT = ROOT / "docs" / "evidence" / "allocators.csv"
ALLOCATORS = {"allocator": "the paper's", "allocator_bounded": "bounded"}
WEIGHTS = (0.0, 0.0236, 0.05, 0.1, 0.2, 0.4)
"""What is tried for wheel_weight."""
RESULTS = FOLDER / "allocators"


@dataclass(frozen=True)
class Flown:
    """Figures of runs, one of each at every node; each (n,)."""

    settled: Array
    """From when on the errors stay within tolerance to the end of the manoeuvre, s; NaN where they do not."""
    out: Array
    """Share of the hold, from the end of the manoeuvre to that of the orbit, in which an error is out of tolerance."""
    wheel: Array
    """Largest |l_w| in the manoeuvre, N m s."""
    wheel_later: Array
    """Largest |l_w| in the hold, N m s."""
    dipole: Array
    """Largest dipole of a rod, A m2."""
    held: Array
    """Share of the run in which the commands are held."""
    latched: Array
    """Whether the run ends so."""

    @property
    def kept(self) -> Array:
        """Returns whether it settled in the manoeuvre and no error left its tolerance in the orbit."""
        return np.isfinite(self.settled) & (self.out == 0.0)


@dataclass(frozen=True)
class Case:
    """A manoeuvre ("V.B") with an allocator, and start values over the scenario's."""

    which: str
    allocator: str
    changes: Mapping[str, Any]


def campaign(name: str, case: Case, nodes: Sequence[float], duration: float = ORBIT) -> campaigns.Case:
    """A case at every node, deg; the fields of `Flown` are made of its metrics."""
    source = read(SCENARIOS[case.which]).with_entry(("blocks", "allocator", "fmu"), case.allocator)
    source = source.without([("expect",), ("figures",), ("holds",)])
    if case.allocator != "allocator":
        source = source.without([("blocks", "allocator", "start", "hold_fraction")])
    angle, rate = {"signal": "judge.attitude_error"}, {"signal": "judge.rate_error_B", "measure": "norm"}
    first, rest = {"before": END}, {"after": END + 0.5 * STEP}
    holding = {"signal": "allocator.holding"}
    metrics: dict[str, dict[str, Any]] = {
        "angle": {**angle, "settles": {"below": ATTITUDE_TOLERANCE}, **first},
        "rate": {**rate, "settles": {"below": RATE_TOLERANCE}, **first},
        "out": {"python": "metrics:out", "signals": [angle["signal"], rate["signal"]]},
        "wheel": {"signal": "plant.h_w", "statistic": "peak", **first},
        "wheel_later": {"signal": "plant.h_w", "statistic": "peak", **rest},
        "dipole": {"signal": "plant.dipole", "statistic": "peak"},
        "held": {**holding, "share": {"equals": True}},
        "latched": {**holding, "statistic": "final"},
    }
    data = {
        "name": re.sub(r"[^\w.]+", "_", name),
        "scenario": {**source.data, "step": STEP, "duration": duration, "record": {"interval": 1.0}},
        "set": dict(case.changes),
        "vary": {"plant.node_longitude": {"grid": [f"{float(x)} deg" for x in nodes]}},
        "sampling": "grid",
        "metrics": [{"name": key, **metric} for key, metric in metrics.items()],
    }
    return campaigns.case(data, Path(__file__).parent)


def figures_of(numbers: Callable[[str], Array]) -> Flown:
    """The figures of runs, from their metrics (n,) by name."""
    times = np.maximum(numbers("angle"), numbers("rate"))
    rest = [numbers(f.name) for f in fields(Flown) if f.name != "settled"]
    return Flown(np.where(np.isfinite(times), times, np.nan), *rest)


def comparison(letter: str = "a") -> dict[str, Case]:
    """Both manoeuvres with both allocators in one of READINGS, by name: `V.B allocator a`."""
    changes = READINGS[letter].changes
    return {f"{which} {name} {letter}": Case(which, name, changes) for which in SCENARIOS for name in ALLOCATORS}


def cases() -> dict[str, Case]:
    """Everything that the page shows: the comparison per unit of mass and in SI units, and `V.C wheel_weight 0.2`."""
    found = comparison("a") | comparison("c")
    for which in SCENARIOS:
        for w in WEIGHTS:
            found[f"{which} wheel_weight {w:g}"] = Case(which, "allocator_bounded", {"allocator.wheel_weight": w})
    return found


def compute(
    wanted: Mapping[str, Case], jobs: int = 2, nodes: Sequence[float] = tuple(NODES), results: Path = RESULTS
) -> dict[str, Flown]:
    """Flies the cases at every node, with a progress bar; those that were flown before are not flown again."""
    with campaigns.crew(jobs) as hands:
        return {n: figures_of(hands.fly(campaign(n, case, nodes), results).numbers) for n, case in wanted.items()}


def _flown(columns: Iterable[Array]) -> Flown:
    return Flown(**dict(zip((f.name for f in fields(Flown)), columns, strict=True)))


def save(done: Mapping[str, Flown], file: Path = KEPT) -> None:
    """Writes all runs, a line each, in the units of `Flown`."""
    with file.open("w", encoding="utf-8", newline="") as text:
        out = csv.writer(text, lineterminator="\n")
        out.writerow(["case", "node_deg", *(f.name for f in fields(Flown))])
        for name, flown in done.items():
            for row in zip(NODES, *(getattr(flown, f.name) for f in fields(Flown)), strict=True):
                out.writerow([name, *(f"{value:.6g}" for value in row)])


def load(file: Path = KEPT) -> dict[str, Flown]:
    """The runs of a file that `save` wrote, by case."""
    with file.open(encoding="utf-8", newline="") as text:
        lines = list(csv.reader(text))[1:]
    names = dict.fromkeys(line[0] for line in lines)
    return {name: _flown(np.array([line[2:] for line in lines if line[0] == name], float).T) for name in names}


COLUMNS: dict[str, Callable[[str, Flown], str]] = {
    "in the time claimed": lambda w, f: f"{int((f.settled < LIMITS[w][1]).sum())} of {len(f.settled)}",
    "settling, s": lambda w, f: _two(f.settled[np.isfinite(f.settled)], "{:.1f}"),
    "kept an orbit": lambda w, f: f"{int(f.kept.sum())} of {len(f.settled)}",
    "wheel, mN m s": lambda w, f: _two(1e3 * f.wheel, "{:.2f}"),
    "in the hold": lambda w, f: _two(1e3 * f.wheel_later, "{:.2f}"),
    "rods, A m²": lambda w, f: f"{f.dipole.max():.1f}",
    "latched": lambda w, f: f"{int(f.latched.sum())}",
}
"""What is shown of a case: a heading, and its text. Two numbers are median and worst."""


def _two(values: Array, form: str) -> str:
    return ", ".join(form.format(v) for v in (np.median(values), values.max())) if len(values) else "none settles"


def rows(done: Mapping[str, Flown], letter: str) -> list[list[str]]:
    """A row for each manoeuvre and allocator in one of READINGS."""
    return [
        [which, label, *(show(which, done[f"{which} {name} {letter}"]) for show in COLUMNS.values())]
        for which in SCENARIOS
        for name, label in ALLOCATORS.items()
    ]


def table(done: Mapping[str, Flown]) -> Any:
    """The comparison in the mass-normalised reading, for a terminal."""
    nodes = len(next(iter(done.values())).settled)
    found = Table(title=f"The paper's law from {nodes} nodes, per unit of mass; median, worst")
    for heading in ("", "allocator", *COLUMNS):
        found.add_column(heading)
    for row in rows(done, "a"):
        found.add_row(*row)
    return found
