"""docs/flight.md: how the planned controller and the bounded allocator fly the true satellite, over thousands of cases."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orchestration import Result

from . import flight_cases, flight_run
from .claims import ROOT
from .flight_cases import BESIDE, SEEDS, TRIES, Case, share
from .flight_run import FOLDER, Row
from .vectors import Array

BOUNDED = {"nominal", "errors", "vb", "vc"}
"""Groups whose cases are set beside their momentum bound."""


@dataclass(frozen=True)
class Done:
    """All that the page tells."""

    n: int
    """Random cases under each condition."""
    cases: list[Case]
    rows: dict[str, Row]
    """By the case's name."""
    bounds: dict[str, float | None]
    """Least times, s."""
    calls: Calls
    tumble: Result
    """scenarios/flight_tumble.yaml, for a figure."""
    hold: Result
    """scenarios/flight_hold.yaml, likewise."""

    def of(self, group: str) -> list[tuple[Case, Row]]:
        """The cases of a group, with their rows."""
        return [(case, self.rows[case.name]) for case in self.cases if case.group == group]

    def times(self, group: str, degrees: int = 5) -> Array:
        """When they settled, orbits; infinite where they did not."""
        found = [row.get(f"settled{degrees}") for _, row in self.of(group)]
        return np.array([np.inf if t is None else t / flight_cases.ORBIT for t in found])

    def least(self, group: str) -> Array:
        """Their momentum bounds, orbits; NaN beyond the horizon."""
        found = [self.bounds[case.name] for case, _ in self.of(group)]
        return np.array([np.nan if t is None else t / flight_cases.ORBIT for t in found])


@dataclass(frozen=True)
class Calls:
    """What a call of the controller takes, in processor time."""

    count: int
    median: float
    """s"""
    rarely: float
    """A thousandth of the calls takes longer than this, s."""
    worst: float
    memory: int | None
    """Bytes of an instance, all it remembers and works in; None where the C library does not tell."""


class _Timed:
    """A block of the loop whose calls are timed, get and set included."""

    def __init__(self, block: Any) -> None:
        self.block = block
        self.spent: list[float] = []
        self.current = 0.0

    def __getattr__(self, name: str) -> Any:
        return getattr(self.block, name)

    def set_inputs(self) -> None:
        self.current = time.thread_time()
        self.block.set_inputs()

    def do_step(self, at: float, step: float) -> None:
        self.block.do_step(at, step)

    def get_live(self) -> None:
        self.block.get_live()
        self.spent.append(time.thread_time() - self.current)

    def get_all(self) -> None:
        self.block.get_all()
        self.spent.append(time.thread_time() - self.current)


def calls(seeds: Sequence[int] = range(SEEDS["errors"], SEEDS["errors"] + 10)) -> Calls:
    """Flies tumbles under all errors in the loop of Python, and times every sample of the controller."""
    from orchestration import load
    from orchestration.instances.slave import Slave
    from orchestration.runner.plan import plan
    from orchestration.runner.run import run_blocks

    fmus = flight_run.pin()
    spent: list[float] = []
    memory = None
    for seed in seeds:
        data = flight_cases.flight("errors", seed, errors=True).data
        scenario = load({**data, "duration": 2000.0})
        opened = {name: flight_run.opened(fmus[entry.fmu]) for name, entry in scenario.blocks.items()}
        ready = plan(scenario, {name: fmu.model for name, (fmu, _) in opened.items()})
        with ExitStack() as stack:
            blocks: dict[str, Any] = {}
            for name, (fmu, folder) in opened.items():
                blocks[name] = Slave(name, fmu, folder)
                stack.callback(blocks[name].close)
            controller = blocks["controller"] = _Timed(blocks["controller"])
            run_blocks(ready, blocks, compiled=False)
            spent += controller.spent[1:]  # the first is of the initialization
            memory = flight_run.memory(controller.block.component)
    times = np.array(spent)
    return Calls(len(times), float(np.median(times)), float(np.quantile(times, 0.999)), float(times.max()), memory)


def shown(scenario: str, *signals: str) -> Result:
    """A flight scenario as it stands, with more signals, for a figure."""
    data = flight_cases.base(scenario)
    data["record"] = {
        "interval": 10.0 if scenario == "hold" else 1.0,
        "signals": [*data["record"]["signals"], *signals],
    }
    duration = data.pop("duration")
    return flight_run.run(data, duration, flight_run.pin())


def make(n: int = 1000, processes: int = 2) -> Path:
    """Flies, draws and writes; returns the page. With fewer than 1000 cases it is written beside the rows, not to docs/."""
    from . import flight_figures, flight_page

    cases = flight_cases.all_cases(n)
    rows, bounds = flight_run.compute(cases, BOUNDED, processes)
    done = Done(
        n,
        cases,
        rows,
        bounds,
        calls(),
        shown("tumble", "plant.dipole", "plant.wheel_torque", "controller.h_w_ref", "controller.tau_cmd_B"),
        shown("hold", "allocator.b_wheel"),
    )
    folder = ROOT / "docs" if n >= 1000 else FOLDER
    (folder / "figures").mkdir(parents=True, exist_ok=True)
    flight_figures.draw(done, folder / "figures")
    (folder / "flight.csv").write_text(table(done), "utf-8")
    target = folder / "flight.md"
    target.write_text(flight_page.text(done), "utf-8")
    return target


def table(done: Done) -> str:
    """Every case with a line: when it settled, s, its bound, s, and its hold's error, deg rms, and largest wheel momentum, mN m s."""
    lines = ["group,seed,settled_5deg_s,settled_1deg_s,momentum_bound_s,hold_rms_deg,wheel_max_mNms"]
    for case in done.cases:
        row, least = done.rows[case.name], done.bounds.get(case.name)
        times = ["" if row.get(k) is None else f"{row[k]:.0f}" for k in ("settled5", "settled1")]
        rest = (
            [f"{np.degrees(row['hold_rms']):.3g}", f"{1e3 * row['wheel_max']:.3g}"] if "hold_rms" in row else ["", ""]
        )
        group = case.group.replace(",", "")
        lines.append(",".join([group, f"{case.seed}", *times, "" if least is None else f"{least:.1f}", *rest]))
    return "\n".join(lines) + "\n"


def seeds_said(n: int) -> str:
    """The seeds of a study with n cases, in words."""
    sets = [
        (n, "nominal"),
        (n, "errors"),
        (share(n, TRIES), "tried"),
    ]
    said = "; ".join(f"{name} {SEEDS[name]} to {SEEDS[name] + count - 1}" for count, name in sets)
    return f"seeds: {said}; the first {share(n, BESIDE)} of nominal and errors also by the other schemes"


def write_case(group: str, seed: int) -> tuple[Path, Row]:
    """Flies one case, and writes its scenario to a file that `orchestrate` runs."""
    from orchestration import InputError
    from orchestration.errors import nearest

    cases = {case.name: case for case in flight_cases.all_cases(1000) if case.seed == seed}
    name = f"{group}/{seed}"
    if name not in cases:
        groups = sorted({case.group for case in cases.values()})
        raise InputError(
            f"{name}: there is no such case{nearest(name, cases)}; of this seed there are: {', '.join(groups) or 'none'}"
        )
    case = cases[name]
    row = flight_run.fly(case, flight_run.pin())
    label = "".join(c if c.isalnum() else "_" for c in name)
    file = FOLDER / f"{label}.yaml"
    file.parent.mkdir(parents=True, exist_ok=True)
    data = {**case.data, "name": f"flight_{label}", "duration": row.get("duration", case.lengths[0])}
    file.write_text(json.dumps(data, indent=1), "utf-8")
    return file, row
