"""The variational integrator of the plant beside RK4: error against cost, and what each keeps.

Tests: tests/evidence/verification/test_cost.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

import plant
from design.loop import read
from plant.attitude import COMPOSITIONS

from ..paper import SCENARIOS, Array
from ..plots import name_axes, panels
from .rk4 import angle_between, environment, pack, rk4, truth

ORBIT, MOMENTUM = 5760.0, 0.02
"""s, nearly; N m s, of the wheel, constant."""
STEPS: dict[int, tuple[float, ...]] = {
    2: (2.0, 1.0, 0.5, 0.25, 0.125),
    4: (6.0, 4.0, 2.0, 1.0, 0.5),
    6: (4.0, 2.0, 1.0, 0.5),
    0: (4.0, 2.0, 1.0, 0.5, 0.25),
}
"""s, by the order; 0 stands for RK4."""
EQUAL = {2: 1.0, 4: 3.0, 6: 4.0, 0: 2.0}
"""Steps of equal cost, s."""
NAMES = {2: "LGVI, order 2", 4: "LGVI, order 4 (Suzuki)", 6: "LGVI, order 6 (Yoshida)", 0: "RK4"}
STYLES = {2: ("#4477aa", "o"), 4: ("#228833", "s"), 6: ("#aa3377", "D"), 0: ("#555555", "^")}
COST = 23040.0
"""Evaluations at which the methods are compared in words: 4 a second over an orbit."""


@cache
def parameters(dipole: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> plant.Parameters:
    """Returns a tumble at 0.11 rad/s under gravity gradient and a dipole fixed in the body, A m2; full inertia."""
    J = [[2.53, 0.21, -0.17], [0.21, 3.04, 0.11], [-0.17, 0.11, 2.89]]
    start = {"J_B": J, "omega_B0": [0.0600, -0.0789, 0.0500], "h_w0": MOMENTUM, "drag": False}
    given = start | {"residual_dipole_B": list(dipole), "disturbance_torque_B": [0.0] * 3}
    return read(SCENARIOS["V.B"]).loop.change({f"plant.{name}": value for name, value in given.items()}).plant


def motion(order: int, step: float, duration: float, p: plant.Parameters) -> Iterator[plant.State]:
    """Yields the state after each step: of the plant block itself, or of RK4."""
    u = plant.Inputs(np.zeros(3), 0.0)
    p = replace(p, integrator_order=order or 4, step_max=step)
    x = plant.start(p, u)
    y, moment = pack(x.R, p.omega_B0, MOMENTUM), environment(p, p.residual_dipole_B)
    for i in range(round(duration / step)):
        if order:
            x, _ = plant.step(x, u, p, step)
        else:
            y = rk4(y, i * step, step, p.J_B, moment, lambda l_w: 0.0)
            Pi = p.J_B @ y[9:12] + MOMENTUM * p.wheel_axes[0]
            x = replace(x, t=(i + 1) * step, R=y[:9].reshape(3, 3), Pi=Pi)
        yield x


def errors_after_an_orbit() -> dict[int, list[tuple[float, float]]]:
    """Returns by order the evaluations of the moment and the attitude error, rad, of each of STEPS.

    In the plant a command may change at every step, so each step starts with an evaluation of its own.
    """
    p = parameters((10.0, -8.0, 6.0))
    start = pack(plant.start(p, plant.Inputs(np.zeros(3), 0.0)).R, p.omega_B0, MOMENTUM)
    y = truth(start, 0.0, ORBIT, p.J_B, environment(p, p.residual_dipole_B), lambda l_w: 0.0)
    true = y[:9].reshape(3, 3)
    found = {}
    for order, steps in STEPS.items():
        a_step = len(COMPOSITIONS[order]) + 1 if order else 4
        ends = ((step, list(motion(order, step, ORBIT, p))[-1]) for step in steps)
        found[order] = [(a_step * ORBIT / step, angle_between(x.R, true)) for step, x in ends]
    return found


@dataclass(frozen=True)
class Kept:
    """Quantities that a method keeps over ten orbits: each (n,), at times in orbits."""

    times: Array
    energy: Array
    """Error of the conserved energy over the kinetic energy."""
    orthogonality: Array
    """Largest element of R^T R - I."""


def structure_over_ten_orbits() -> dict[int, Kept]:
    """Returns by order, at EQUAL steps, what is kept under gravity gradient alone."""
    p, u = parameters(), plant.Inputs(np.zeros(3), 0.0)
    period = 2.0 * math.pi / p.orbit.mean_motion
    first = plant.outputs(plant.start(p, u), u, p).energy
    kinetic = 0.5 * float(p.omega_B0 @ p.J_B @ p.omega_B0)
    found = {}
    for order, step in EQUAL.items():
        every = round(60.0 / step)
        seen = [x for i, x in enumerate(motion(order, step, 10.0 * period, p), 1) if i % every == 0]
        energy = [abs(plant.outputs(x, u, p).energy - first) / kinetic for x in seen]
        orthogonal = [float(np.abs(x.R.T @ x.R - np.eye(3)).max()) for x in seen]
        found[order] = Kept(np.array([x.t for x in seen]) / period, np.array(energy), np.array(orthogonal))
    return found


def figure(errors: dict[int, list[tuple[float, float]]], structure: dict[int, Kept]) -> Any:
    """Returns accuracy over cost, and energy and orthogonality at equal cost."""
    drawn, axes = panels(1, 3, 4.4, 4.0)
    left, middle, right = axes[0]
    for order, points in errors.items():
        colour, marker = STYLES[order]
        left.loglog(*zip(*points, strict=True), marker=marker, color=colour, label=NAMES[order], markersize=5)
        kept, label = structure[order], f"{NAMES[order]}, {EQUAL[order]:g} s"
        for ax, values, least in ((middle, kept.energy, 1e-15), (right, kept.orthogonality, 1e-16)):
            ax.semilogy(kept.times, np.maximum.accumulate(np.maximum(values, least)), color=colour, label=label)
    name_axes(left, "evaluations of the moment in one orbit", "attitude error after one orbit, rad", "accuracy")
    name_axes(middle, "orbits", "energy error so far, relative", "energy, at equal cost")
    name_axes(right, "orbits", "largest element of $R^T R - I$ so far", "rotations stay rotations")
    left.legend(fontsize=8, frameon=False, loc="lower left")
    middle.legend(fontsize=8, frameon=False)
    return drawn


def table(errors: dict[int, list[tuple[float, float]]], structure: dict[int, Kept]) -> list[list[str]]:
    """Returns a row for each method."""
    return [
        [
            NAMES[order],
            f"{at(errors[order], COST):.1e}",
            f"{EQUAL[order]:g}",
            f"{kept.energy[kept.times <= 1.0].max():.1e}",
            f"{kept.energy.max():.1e}",
            f"{kept.orthogonality.max():.1e}",
        ]
        for order, kept in structure.items()
    ]


def at(points: list[tuple[float, float]], cost: float) -> float:
    """Returns the error at a cost, interpolated in the logarithms."""
    x, y = (np.log(c) for c in zip(*sorted(points), strict=True))
    return float(np.exp(np.interp(math.log(cost), x, y)))
