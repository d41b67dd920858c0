"""Computes everything that docs/evidence/reproduction.md shows, draws its figures and writes it."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from design.exact import Flown
from design.loop import read

from ..crew import crew
from ..paper import LIMITS, MASS, ORBIT, READINGS, ROOT, SCENARIOS, node
from ..samples import wrong_inertias
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


def from_random(schedule: str, wrong: bool = False) -> Flown:
    """600 random starts under V.B's law with exact torque; `wrong`: on bodies 10% off what the law knows."""
    law = read(SCENARIOS["V.B"]).loop.controller
    return convergence.random_cases(law, schedule, J=wrong_inertias(law.J_B, 600, 4, 0.1) if wrong else None)


def from_edge() -> Flown:
    """Starts next to the unstable equilibria of V.B's law."""
    return convergence.from_the_edge(read(SCENARIOS["V.B"]).loop.controller)


Part = tuple[str, Callable[..., Any], tuple[Any, ...]]
"""A part of the study: its name, and what computes it."""


def campaigns() -> list[Part]:
    """Returns what is flown as campaigns, whose first argument is the crew.

    One that returns a dictionary has a result for each manoeuvre.
    """
    made: list[Part] = [("node and K0", sweep.node_and_gain, ()), ("one by one", sweep.one_by_one, ())]
    made += [("SI for an orbit", sweep.si_for_an_orbit, ())]
    made += [(f"latch {k:g} {d:g}", sweep.latch, (k, d)) for k, d in ((0.65, 0.9), (0.4, 1.0))]
    return [*made, ("wrong inertia", sweep.inertia_errors, ()), ("drag", sweep.drag, ())]


def calls() -> list[Part]:
    """Returns what is computed without FMUs, the longest first."""
    made: list[Part] = [("starts at the edge", from_edge, ())]
    made += [(f"random starts, {s}", from_random, (s,)) for s in ("constant", "error")]
    made += [("random starts, wrong inertia", from_random, ("error", True))]
    made += [(f"{w}: bound {m:g} A m2", bounds, (w, m)) for w in SCENARIOS for m in (LIMITS[w][0], 25.0)]
    return [*made, *((f"{w}: bound per mass", bounds, (w, LIMITS[w][0], MASS)) for w in SCENARIOS)]


def runs() -> list[Part]:
    """Single runs."""
    made: list[Part] = [("hold over an orbit", orbit_hold, ()), ("with drag", orbit_hold, (1e-5,))]
    made += [(f"{w}: run {letter}", run, (w, letter)) for w in SCENARIOS for letter in READINGS]
    return [*made, ("latched run", run, ("V.C", "a", node(200.0)))]


def called(part: Part) -> Any:
    """The result of a part."""
    _, function, arguments = part
    return function(*arguments)


def compute(jobs: int) -> dict[str, Any]:
    """The results of all parts by name; campaigns that were stopped go on."""
    done: dict[str, Any] = {}
    with crew(jobs) as hands:
        for name, function, arguments in campaigns():
            result = function(hands, *arguments)
            done |= {f"{w}: {name}": seen for w, seen in result.items()} if isinstance(result, dict) else {name: result}
        parts = calls()
        done |= zip((name for name, _, _ in parts), hands.each("without FMUs", called, parts), strict=True)
    return done | {part[0]: called(part) for part in runs()}


def make(jobs: int = 2) -> Path:
    """Computes, draws and writes; returns the page."""
    done = compute(jobs)
    figures.draw(done, ROOT / "docs" / "figures")
    target = ROOT / "docs" / "evidence" / "reproduction.md"
    target.write_text(page.text(done), "utf-8")
    return target
