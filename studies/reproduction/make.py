"""Computes everything that docs/reproduction.md shows, draws its figures and writes it."""

from __future__ import annotations

import hashlib
import math
import pickle
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .. import native
from ..paper import LIMITS, MASS, ORBIT, READINGS, ROOT, SCENARIOS, node
from ..processes import each
from ..samples import wrong_inertias
from ..setup import read
from . import convergence, figures, page, sweep
from .bounds import bounds
from .runs import Run, run


def orbit_hold(drag_moment: float | None = None) -> Run:
    """One orbit of LVLH hold, from rest in LVLH, with gravity gradient and drag.

    `drag_moment`, N m in SI units: what drag is scaled to, as it is at the end of the manoeuvre; None: as modelled.
    """
    one = sweep.drag_moments("V.B")[0] / sweep.DRAG_FACTORS[0]
    changes = {
        "plant.drag_factor": (1.0 if drag_moment is None else drag_moment / one) / MASS,
        "plant.Q0": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        "plant.omega_B0": [0.0, -2.0 * math.pi / ORBIT, 0.0],
    }
    return run("V.B", "a", changes, ORBIT)


def from_random(schedule: str, wrong: bool = False) -> convergence.Flown:
    """600 random starts under V.B's law with exact torque; `wrong`: on bodies 10% off what the law knows."""
    law = read(SCENARIOS["V.B"]).loop.controller
    return convergence.random_cases(law, schedule, J=wrong_inertias(law.J_B, 600, 4, 0.1) if wrong else None)


def from_edge() -> convergence.Flown:
    """Starts next to the unstable equilibria of V.B's law."""
    return convergence.from_the_edge(read(SCENARIOS["V.B"]).loop.controller)


@dataclass(frozen=True)
class Job:
    """One part of the study."""

    name: str
    call: Callable[..., Any]
    arguments: tuple[Any, ...] = ()


def jobs() -> list[Job]:
    """The longest first. One that returns a dictionary has a result for each manoeuvre."""
    made = [Job("node and K0", sweep.node_and_gain), Job("one by one", sweep.one_by_one)]
    made += [Job("K0 and L0", sweep.gains), Job("SI for an orbit", sweep.si_for_an_orbit)]
    made += [Job("starts at the edge", from_edge)]
    made += [Job(f"random starts, {s}", from_random, (s,)) for s in ("constant", "error")]
    made += [Job("random starts, wrong inertia", from_random, ("error", True))]
    made += [Job(f"step {s:g} s", sweep.node_and_step, (s,)) for s in sweep.STEPS]
    made += [Job(f"latch {k:g} {d:g}", sweep.latch, (k, d)) for k, d in ((0.65, 0.9), (0.4, 1.0))]
    made += [Job("wrong inertia", sweep.inertia_errors), Job("drag", sweep.drag)]
    made += [Job(f"{w}: bound {m:g} A m2", bounds, (w, m)) for w in SCENARIOS for m in (LIMITS[w][0], 25.0)]
    made += [Job(f"{w}: bound per mass", bounds, (w, LIMITS[w][0], MASS)) for w in SCENARIOS]
    made += [Job("hold over an orbit", orbit_hold), Job("with drag", orbit_hold, (1e-5,))]
    made += [Job(f"{w}: run {letter}", run, (w, letter)) for w in SCENARIOS for letter in READINGS]
    made += [Job("latched run", run, ("V.C", "a", node(200.0)))]
    return made


def compute(processes: int) -> dict[str, Any]:
    """The results of all jobs by name, with a progress bar.

    Each is kept in results/studies/reproduction/ under a hash of the sources, so that a study that was stopped goes on.
    """
    native.pin()  # once, before the processes ask for it
    kept = native.FOLDER / "reproduction" / _fingerprint()
    kept.mkdir(parents=True, exist_ok=True)
    wanted = jobs()
    done: dict[str, Any] = {}
    tasks = {job.name: (_kept, (job, kept)) for job in wanted}
    for name, result in each(tasks, processes):
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
    """A hash of what the results are made from: FMUs, scenarios, the blocks in Python, and this study but for its page."""
    digest = hashlib.sha256("".join(map(native.identity, (*native.PAPER, native.JUDGE))).encode())
    shown = ("page.py", "figures.py", "maps.py", "numbers.py")
    for folder, pattern in (
        ("plant", "*.py"),
        ("controller", "*.py"),
        ("scenarios", "paper_*.yaml"),
        ("scenarios/satellites", "*.yaml"),
        ("studies", "*.py"),
        ("studies/reproduction", "*.py"),
    ):
        for path in sorted((ROOT / folder).glob(pattern)):
            if path.name not in (*shown, "plots.py", "markdown.py", "__main__.py"):
                digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def make(processes: int = 2) -> Path:
    """Computes, draws and writes; returns the page."""
    done = compute(processes)
    figures.draw(done, ROOT / "docs" / "figures")
    target = ROOT / "docs" / "reproduction.md"
    target.write_text(page.text(done), "utf-8")
    return target
