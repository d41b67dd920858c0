"""What the optimiser found, flown: its commands by the plant open-loop, then the planned controller from where they
end. Tests: tests/evidence/optimum/test_least_time.py."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import numpy as np
from scipy.spatial.transform import Rotation

import plant
from controller.errors import errors as errors_of
from controller.reference import lvlh
from orchestration import run

from ..flight.cases import RATE
from ..flight.figures import errors
from ..flight.schemes import Data, change
from ..paper import ORBIT
from .courses import Course
from .problem import ANGLE


@dataclass(frozen=True)
class Check:
    """Check of one course."""

    angle: float
    """Largest over HOLD after T, rad."""
    rate: float
    """Largest rate error, rad/s."""
    gap: float
    """Between plant and course at T, rad."""
    inside: bool
    """Whether both are within the tolerance."""
    held_on: bool
    """Whether they are, and the planned controller, from T + HOLD on, keeps the angle for an
    orbit."""


def check(p: plant.Parameters, course: Course, scenario: Data) -> Check:
    """Flies a course of a scenario's run whose plant is p: with drag, the whole field model and the wheels' limits."""
    x, torques = plant.start(p, plant.Inputs(np.zeros(3), np.zeros(p.wheels))), p.of_wheels(p.wheel_torque_max)
    angle = rate = gap = 0.0
    T = int(np.argmin(np.abs(course.times - course.end)))
    for i, h in enumerate(np.diff(course.times).tolist(), 1):
        u = course.u[i - 1]
        x, _ = plant.step(x, plant.Inputs(p.dipole_max * u[:3], torques * u[3:]), p, h)
        reference = lvlh(*p.orbit.position_velocity(x.t))
        if i == T:
            gap = float((course.attitudes[i].inv() * Rotation.from_matrix(reference.R_d.T @ x.R)).magnitude())
        if i >= T:
            e = errors_of(x.R, x.Omega(p), reference)
            angle, rate = max(angle, e.angle), max(rate, float(np.linalg.norm(e.omega)))
    inside = angle < ANGLE and rate < RATE
    return Check(angle, rate, gap, inside, inside and _holds_on(p, x, scenario))


def _holds_on(p: plant.Parameters, x: plant.State, scenario: Data) -> bool:
    """Returns whether the planned controller, started here, keeps the angle for an orbit, and ends it with a rate error
    below RATE.
    """
    r, v = p.orbit.position_velocity(x.t)
    data = copy.deepcopy(scenario)
    later = datetime.fromisoformat(p.epoch).astimezone(UTC) + timedelta(seconds=x.t)
    data["shared"]["epoch"] = later.isoformat().replace("+00:00", "Z")
    starts: Data = {
        "orbit_start": "position_velocity",
        "r_N0": r,
        "v_N0": v,
        "Q0": lvlh(r, v).R_d.T @ x.R,
        "omega_B0": x.Omega(p),
        "h_w0": np.pad(x.l_w, (0, len(p.wheel_axis) - p.wheels)) if p.is_set else float(x.l_w[0]),
        "disturbance_torque_B": p.disturbance_torque_B,
    }
    change(data, {f"plant.{name}": value for name, value in starts.items()})
    angle, rate = errors(run({**data, "duration": ORBIT}))
    return bool((angle < ANGLE).all() and rate[-1] < RATE)
