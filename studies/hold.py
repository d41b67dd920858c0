"""The best hold that IPOPT finds for a satellite: a motion about the target that ends an orbit later as it began.

Nothing limits it but the actuators: the disturbance, the inertia and the field of the whole orbit are known. Where its error is
zero, the satellite can be held for good. Where it is not, the momentum that the disturbance brings along the field cannot be taken
out without leaving the target: the rods give no torque along the field, and the wheel is at its limit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

import controller.reference
import plant

from .motion import IPOPT, SECONDS, advanced
from .paper import Array

LONGEST = 30.0
"""s, of an interval of constant commands."""
PARTS = 3
"""Of an interval: the error counts at the beginning of each, so that no motion within an interval is free."""
TURN = 0.5
"""rad, of the free motion of a body with a full wheel in one interval."""
UNIT = 100.0
"""The error is counted in so many halves of a radian, about degrees."""
EFFORT = 1e-3
"""Weight of the mean square of the commands beside that of the error."""
SEARCH: dict[str, Any] = {**IPOPT, "ipopt": {**IPOPT["ipopt"], "max_iter": 600}}
WARM: dict[str, Any] = {**SEARCH, "ipopt": {**SEARCH["ipopt"], "mu_init": 1e-3}}
"""Options of a search that begins at the end of another."""


@dataclass(frozen=True)
class Hold:
    """What was found: angles in rad, largest wheel momentum over its limit, largest gap between intervals."""

    rms: float
    largest: float
    wheel: float
    gap: float


def best(p: plant.Parameters, begin: float, evenly: bool = False) -> Hold:
    """Over one orbit from the plant's time `begin`, s: a local minimum of the mean square of the attitude error.

    `evenly`: from there on the largest error is minimised, which takes some times longer.
    """
    problem = _problem(p, begin)
    motion, errors, closed = problem.motion, problem.errors, problem.closed
    mean = {"x": motion, "f": ca.sum1(errors) / errors.numel() + problem.effort, "g": closed}
    end = ca.nlpsol("hold", "ipopt", mean, SEARCH)(
        x0=problem.rest, lbx=-problem.bounds, ubx=problem.bounds, lbg=0.0, ubg=0.0
    )
    if evenly:
        of_motion = ca.Function("errors", [motion], [errors])
        largest = ca.MX.sym("largest")
        even = {
            "x": ca.vertcat(motion, largest),
            "f": largest + problem.effort,
            "g": ca.vertcat(closed, errors - largest),
        }
        end = ca.nlpsol("even_hold", "ipopt", even, WARM)(
            x0=ca.vertcat(end["x"], ca.mmax(of_motion(end["x"]))),
            lbx=np.append(-problem.bounds, 0.0),
            ubx=np.append(problem.bounds, np.inf),
            lbg=np.concatenate((np.zeros(closed.numel()), np.full(errors.numel(), -np.inf))),
            ubg=0.0,
        )
    return problem.measured(np.asarray(end["x"]).ravel()[: motion.numel()])


@dataclass(frozen=True)
class _Problem:
    """The motion's variables, with those of rest and their bounds.

    Errors (m,): UNIT times the sine of half the angle, squared. `closed` is zero where the motion closes. All without units.
    """

    motion: ca.MX
    errors: ca.MX
    effort: ca.MX
    closed: ca.MX
    rest: Array
    bounds: Array
    nodes: int

    def measured(self, found: Array) -> Hold:
        """What these values of the variables are."""
        errors, closed = ca.Function("hold", [self.motion], [self.errors, self.closed])(found)
        angle = 2.0 * np.arcsin(np.minimum(np.sqrt(np.asarray(errors)) / UNIT, 1.0))
        wheel = np.abs(found[7 : 8 * self.nodes : 8]).max() / self.bounds[7]
        return Hold(
            math.sqrt(float(np.mean(angle**2))),
            float(angle.max()),
            float(wheel),
            float(np.abs(np.asarray(closed)).max()),
        )


def _problem(p: plant.Parameters, begin: float) -> _Problem:
    """An orbit from the plant's time `begin`, s, that ends as it began."""
    times = _nodes(p, begin)
    n, h = len(times) - 1, float(times[1] - times[0]) / SECONDS
    parts = [i / (2 * PARTS) for i in range(2 * PARTS + 1)]
    fields = [np.array([_field(p, t + part * SECONDS * h) for t in times[:-1]]).T for part in parts]
    turn = np.array(controller.reference.lvlh(*p.orbit.position_velocity(begin)).Omega_d)
    x, u, at = ca.SX.sym("x", 8), ca.SX.sym("u", 4), [ca.SX.sym(f"field{i}", 3) for i in range(len(parts))]
    passed = [x]
    for i in range(PARTS):
        passed.append(advanced(p, turn, passed[-1], u, ca.SX(h / PARTS), at[2 * i : 2 * i + 3]))
    step = ca.Function("step", [x, u, *at], [passed[-1], ca.horzcat(*(each[1:4] for each in passed[:-1]))])
    X, U = ca.MX.sym("X", 8, n + 1), ca.MX.sym("U", 4, n)
    ends, within = step.map(n)(X[:, :-1], U, *map(ca.DM, fields))
    high = np.append(np.full(7, np.inf), SECONDS * p.wheel_momentum_max)
    rest = np.array([1.0, 0.0, 0.0, 0.0, *(SECONDS * turn), 0.0])
    return _Problem(
        motion=ca.vertcat(ca.vec(X), ca.vec(U)),
        errors=ca.sum1((UNIT * within) ** 2).T,
        effort=EFFORT * ca.sumsqr(U) / n,
        closed=ca.vertcat(ca.vec(X[:, 1:] - ends), ca.sumsqr(X[:4, 0]) - 1.0, X[1:, -1] - X[1:, 0]),
        rest=np.concatenate((np.tile(rest, n + 1), np.zeros(4 * n))),
        bounds=np.concatenate((np.tile(high, n + 1), np.ones(4 * n))),
        nodes=n + 1,
    )


def period(p: plant.Parameters) -> float:
    """Of the orbit, s."""
    return 2.0 * math.pi / p.orbit.mean_motion


def _nodes(p: plant.Parameters, begin: float) -> Array:
    """The ends of the intervals, s."""
    least = np.linalg.eigvalsh(p.body.J)[:2]
    free = math.sqrt(float(least.prod())) / p.wheel_momentum_max
    return np.linspace(begin, begin + period(p), math.ceil(period(p) / min(LONGEST, TURN * free)) + 1)


def _field(p: plant.Parameters, t: float) -> Array:
    """In LVLH (3,), T."""
    return np.asarray(controller.reference.lvlh(*p.orbit.position_velocity(t)).R_d).T @ p.field.at(t)
