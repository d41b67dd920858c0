"""A tumble as the planned controller flies it. Tests: tests/evidence/optimum/test_least_time.py."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

import plant
from controller.reference import lvlh
from orchestration import Result, run

from ..flight.cases import HOLD as SETTLED_FOR
from ..flight.cases import RATE
from ..flight.figures import errors
from ..flight.schemes import change
from .courses import Course
from .problem import ANGLE, HOLD
from .tumbles import Tumbles

PLAN = 2
"""The controller's phase from the hand-over by the steering on."""
SIGNALS = (
    "plant.R_NB plant.omega_B plant.r_N plant.v_N plant.h_w plant.dipole plant.wheel_torque controller.phase "
    "judge.attitude_error judge.rate_error_B"
).split()


@dataclass(frozen=True)
class Flight:
    """A tumble, flown."""

    plant: plant.Parameters
    settled: float
    """s; infinite where it does not settle for good."""
    handed_over: float
    """When the steering ended, s; 0 where there was none, as with a set of wheels."""
    course: Course
    """Until HOLD after it was settled."""


def fly(tumbles: Tumbles, index: int) -> Flight:
    """One run, flown in full."""
    data = change(copy.deepcopy(tumbles.scenario), tumbles.starts[index])
    record = {"interval": tumbles.sample, "signals": SIGNALS}
    result = run({**data, "duration": tumbles.duration, "record": record})
    p = tumbles.plant_of(index)
    settled = _settled(result)
    planned = result["controller.phase"][1:] >= PLAN  # nothing is decided before the first sample
    handed_over = 0.0 if p.is_set else float(result.time[np.argmax(planned)])
    return Flight(p, settled, handed_over, _course(result, p, settled))


def _settled(result: Result) -> float:
    """From when on the angle is below ANGLE and the rate error below RATE, s, to the end of the flight."""
    angle, rate = errors(result)
    outside = np.flatnonzero((angle >= ANGLE) | (rate >= RATE))
    time = float(result.time[outside[-1] + 1]) if len(outside) and outside[-1] + 1 < len(angle) else 0.0
    return time if time <= result.time[-1] - SETTLED_FOR and (angle[-1] < ANGLE and rate[-1] < RATE) else math.inf


def _course(result: Result, p: plant.Parameters, settled: float) -> Course:
    """The flown motion relative to LVLH, at each sample."""
    n = int(np.searchsorted(result.time, min(settled, result.time[-1] - SETTLED_FOR) + HOLD - 1e-6)) + 1
    r, v, R = (result[f"plant.{name}"][:n] for name in ("r_N", "v_N", "R_NB"))
    Q = np.array([lvlh(*at).R_d.T @ R_NB for *at, R_NB in zip(r, v, R, strict=True)])
    of_wheels = (result[f"plant.{name}"].reshape(len(result.time), -1) for name in ("h_w", "wheel_torque"))
    l_w, torques = (values[:, : p.wheels] for values in of_wheels)
    u = np.column_stack((result["plant.dipole"] / p.dipole_max, torques / p.of_wheels(p.wheel_torque_max)))[:n]
    return Course(result.time[:n], Rotation.from_matrix(Q), result["plant.omega_B"][:n], l_w[:n], u)
