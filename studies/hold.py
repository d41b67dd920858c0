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


@dataclass(frozen=True)
class Hold:
    """What was found: angles in rad, largest wheel momentum over its limit, largest gap between intervals."""

    rms: float
    largest: float
    wheel: float
    gap: float


def best(p: plant.Parameters, begin: float) -> Hold:
    """Over one orbit from the plant's time `begin`, s: a local minimum of the mean square of the attitude error."""
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
    gaps = X[:, 1:] - ends
    error = ca.sumsqr(UNIT * within) / (PARTS * n)
    problem = {
        "x": ca.vertcat(ca.vec(X), ca.vec(U)),
        "f": error + EFFORT * ca.sumsqr(U) / n,
        "g": ca.vertcat(ca.vec(gaps), ca.sumsqr(X[:4, 0]) - 1.0, X[1:, -1] - X[1:, 0]),
    }
    l_max = SECONDS * p.wheel_momentum_max
    high = np.repeat(np.array([np.inf] * 7 + [l_max])[:, None], n + 1, axis=1)
    bounds = np.concatenate((high.T.ravel(), np.ones(4 * n)))
    rest = np.repeat(np.array([1.0, 0.0, 0.0, 0.0, *(SECONDS * turn), 0.0])[:, None], n + 1, axis=1)
    found = ca.nlpsol("hold", "ipopt", problem, SEARCH)
    end = found(x0=np.concatenate((rest.T.ravel(), np.zeros(4 * n))), lbx=-bounds, ubx=bounds, lbg=0.0, ubg=0.0)
    states, commands = np.split(np.asarray(end["x"]).ravel(), [8 * (n + 1)])
    states, commands = states.reshape(n + 1, 8).T, commands.reshape(n, 4).T
    turned = np.asarray(ca.Function("within", [X, U], [within])(states, commands))
    angle = 2.0 * np.arcsin(np.minimum(np.linalg.norm(turned, axis=0), 1.0))
    return Hold(
        math.sqrt(float(np.mean(angle**2))),
        float(angle.max()),
        float(np.abs(states[7]).max() / l_max),
        float(np.abs(np.asarray(end["g"])).max()),
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
