"""Everything that docs/reproduction.md shows, computed anew: the runs, and how they are spread over processes."""

from __future__ import annotations

import hashlib
import math
import os
import pickle
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from . import convergence, sweep
from .claims import CLAIMS, DURATION, MASS, ORBIT, READINGS, ROOT, SCENARIOS, STEP, constants
from .momentum_bound import MomentumBalance, Verdict
from .setup import PAPER, Loop, read
from .vectors import Array
from .watch import Seen, of_result

BOUND_NODES = np.arange(0.0, 360.0, 10.0)


@dataclass(frozen=True)
class Run:
    """One run through the FMUs: what was seen, and the signals for figures."""

    seen: Seen
    hold: str
    """What became of the hold, in words."""
    time: Array
    signals: dict[str, Array]


def run(which: str, letter: str = "a", changes: dict[str, Any] | None = None, duration: float = DURATION) -> Run:
    """Flies a manoeuvre with the FMUs, in one of READINGS, with further start values."""
    import orchestration

    reading = next(r for r in READINGS if r.letter == letter)
    start = {**reading.changes, **(changes or {})}
    setup = read(ROOT / SCENARIOS[which])
    n = setup.names
    result = orchestration.run(ROOT / SCENARIOS[which], {**start, "duration": duration, "step": STEP})
    wanted = {
        n["plant"]: "b_B h_w dipole dipole_saturated wheel_momentum_saturated omega_B tau_drag_B",
        n["controller"]: "tau_cmd_B attitude_error rate_error_B lyapunov gain_l",
        n["allocator"]: "dipole_cmd wheel_torque_cmd holding demand_fraction tau_residual_B b_wheel",
    }
    signals = {name: result[f"{block}.{name}"] for block, names in wanted.items() for name in names.split()}
    rods = _rod_fraction(setup.loop.change(start), signals)
    return Run(of_result(result, dict(n), rods), result.holds[0].text, result.time, signals)


def _rod_fraction(loop: Loop, s: dict[str, Array]) -> Array:
    """Largest demand of a rod over its limit at each sample, before the hold, by the allocator's own functions."""
    from allocator.allocation import Singular, allocate

    found = np.empty(len(s["h_w"]))
    for i in range(len(found)):
        try:
            m, _ = allocate(s["tau_cmd_B"][i], s["b_B"][i], s["omega_B"][i], float(s["h_w"][i]), loop.allocator.U)
            found[i] = np.abs(m).max() / loop.allocator.dipole_max
        except Singular:
            found[i] = np.inf
    return found


def orbit_hold(which: str, drag_moment: float | None = None) -> Run:
    """One orbit of LVLH hold, from rest in LVLH, with gravity gradient and drag.

    `drag_moment`, N m in SI units: what drag is scaled to, as it is at the end of the manoeuvre; None: as modelled.
    """
    one = sweep.drag_moments(which)[0] / sweep.DRAG_FACTORS[0]
    changes = {
        "plant.drag_factor": (1.0 if drag_moment is None else drag_moment / one) / MASS,
        "plant.Q0": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        "plant.omega_B0": [0.0, -2.0 * math.pi / ORBIT, 0.0],
    }
    return run(which, "a", changes, ORBIT)


@dataclass(frozen=True)
class Times:
    """Least times at BOUND_NODES, s; NaN beyond the horizon."""

    least: Array
    simple: Array
    at_claim: list[Verdict]
    """For the paper's own time and dipole."""


PAPER_LIMITS = {"V.B": (15.0, ORBIT / 30.0), "V.C": (20.0, ORBIT / 20.0)}
"""Dipole that the paper says each rod stays within, A m2, and the time it says the manoeuvre takes, s."""


def bounds(which: str, dipole_max: float, mass: float = 1.0) -> Times:
    """The momentum bound round the Earth."""
    loop = read(ROOT / SCENARIOS[which]).loop.change(constants(mass=mass))
    least, simple, at_claim = [], [], []
    for node in BOUND_NODES:
        p = loop.change({"plant.node_longitude": math.radians(node)})
        balance = MomentumBalance(p.plant, p.controller, dipole_max, horizon=1500.0)
        found = balance.least_time()
        least.append(math.nan if found.least is None else found.least)
        simple.append(math.nan if found.simple is None else found.simple)
        at_claim.append(balance.at(PAPER_LIMITS[which][1]))
    return Times(np.array(least), np.array(simple), at_claim)


def from_random(schedule: str, wrong: bool = False) -> convergence.Flown:
    law = read(ROOT / SCENARIOS["V.B"]).loop.controller
    J = sweep.wrong_inertias(law.J_B, 600, 4, 0.1) if wrong else None
    return convergence.random_cases(law, schedule, J=J)


def from_edge() -> convergence.Flown:
    return convergence.from_the_edge(read(ROOT / SCENARIOS["V.B"]).loop.controller)


@dataclass(frozen=True)
class Job:
    name: str
    call: Callable[..., Any]
    arguments: tuple[Any, ...]


def jobs() -> list[Job]:
    """The longest first. One that returns a dictionary has a result for each manoeuvre."""
    made = [Job("SI for an orbit", sweep.si_for_an_orbit, ()), Job("node and K0", sweep.node_and_gain, ())]
    made += [Job("one by one", sweep.one_by_one, ()), Job("K0 and L0", sweep.gains, ())]
    made += [Job(f"step {s:g} s", sweep.node_and_step, (s,)) for s in sweep.STEPS]
    made += [Job(f"random starts, {s}", from_random, (s,)) for s in ("constant", "error")]
    made += [Job("random starts, wrong inertia", from_random, ("error", True))]
    made += [Job("starts at the edge", from_edge, ())]
    made += [Job(f"latch {k:g} {d:g}", sweep.latch, (k, d)) for k, d in ((0.65, 0.9), (0.4, 1.0))]
    made += [Job("wrong inertia", sweep.inertia_errors, ()), Job("drag", sweep.drag, ())]
    both = tuple(CLAIMS)
    made += [Job(f"{w}: bound {m:g} A m2", bounds, (w, m)) for w in both for m in (PAPER_LIMITS[w][0], 25.0)]
    made += [Job(f"{w}: bound per mass", bounds, (w, PAPER_LIMITS[w][0], 50.0)) for w in both]
    made += [Job("hold over an orbit", orbit_hold, ("V.B",)), Job("with drag", orbit_hold, ("V.B", 1e-5))]
    made += [Job(f"{w}: run {r.letter}", run, (w, r.letter)) for w in both for r in READINGS]
    made += [Job("latched run", run, ("V.C", "a", {"plant.node_longitude": math.radians(200.0)}))]
    return made


def compute(processes: int) -> dict[str, Any]:
    """The results of all jobs by name, with a progress bar.

    Each is kept in results/reproduction/ under a hash of the sources, so that a run that was stopped goes on where it was.
    """
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from fmus.build import ensure

    for block in PAPER:  # once, before the processes ask for it
        ensure(block, "native")
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # BLAS threads would only get in the processes' way
    kept = ROOT / "results" / "reproduction" / _fingerprint()
    kept.mkdir(parents=True, exist_ok=True)
    done: dict[str, Any] = {}
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns) as progress, ProcessPoolExecutor(processes) as pool:
        wanted = jobs()
        task = progress.add_task("studies", total=len(wanted))
        futures = {pool.submit(_kept, job, kept): job.name for job in wanted}
        for future in as_completed(futures):
            name, result = futures[future], future.result()
            progress.update(task, advance=1, description=name)
            done |= {f"{w}: {name}": part for w, part in result.items()} if isinstance(result, dict) else {name: result}
    return done


def _kept(job: Job, folder: Path) -> Any:
    file = folder / f"{job.name.replace(' ', '_').replace(':', '')}.pickle"
    if file.exists():
        return pickle.loads(file.read_bytes())
    result = job.call(*job.arguments)
    part = file.with_suffix(".part")
    part.write_bytes(pickle.dumps(result))
    part.replace(file)
    return result


def _fingerprint() -> str:
    """A hash of what the results are made from: blocks, interfaces, scenarios, and these studies but for how they are shown."""
    digest = hashlib.sha256()
    for folder, pattern in (
        *((block, "**/*.py") for block in ("plant", "controller", "allocator")),
        ("plant/tables", "*.csv"),
        ("fmus/interfaces", "*.toml"),
        ("scenarios", "paper_*.yaml"),
        ("studies", "*.py"),
    ):
        for path in sorted((ROOT / folder).glob(pattern)):
            if path.name not in ("figures.py", "page.py", "__main__.py") or folder != "studies":
                digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def make(processes: int = 2) -> Path:
    """Computes, draws and writes; returns the page."""
    from . import figures, page

    done = compute(processes)
    figures.draw(done, ROOT / "docs" / "figures")
    target = ROOT / "docs" / "reproduction.md"
    target.write_text(page.text(done), "utf-8")
    return target
