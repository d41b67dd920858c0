"""A tumble of docs/evidence/flight.md as the planned controller flies it, and commands flown open-loop by the plant."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

import plant
from controller.reference import lvlh
from orchestration import Result, run

from ..flight.bound import loop, starts
from ..flight.cases import HOLD as SETTLED_FOR
from ..flight.cases import LONG, RATE, Group
from ..flight.figures import errors
from ..flight.schemes import change
from .courses import Course
from .problem import ANGLE, HOLD

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
    """When the steering ended, s; 0 where there was none."""
    course: Course
    """Until HOLD after it was settled."""


def fly(group: Group, index: int) -> Flight:
    """One run of a group, flown in full."""
    data = change(copy.deepcopy(group.scenario), group.drawn()[index])
    result = run({**data, "duration": group.duration, "record": {"interval": 1.0, "signals": SIGNALS}})
    p = loop(starts(group)[index]).plant
    settled = _settled(result)
    planned = result["controller.phase"][1:] >= PLAN  # nothing is decided before the first sample
    return Flight(p, settled, float(np.argmax(planned)), _course(result, p, settled))


def _settled(result: Result) -> float:
    """From when on the angle is below ANGLE and the rate error below RATE, s, to the end of three orbits."""
    angle, rate = errors(result)
    outside = np.flatnonzero((angle >= ANGLE) | (rate >= RATE))
    time = float(result.time[outside[-1] + 1]) if len(outside) and outside[-1] + 1 < len(angle) else 0.0
    return time if time <= LONG - SETTLED_FOR and (angle[-1] < ANGLE and rate[-1] < RATE) else math.inf


def _course(result: Result, p: plant.Parameters, settled: float) -> Course:
    """The flown motion relative to LVLH, at each second."""
    n = int(min(settled, LONG - SETTLED_FOR) + HOLD) + 1
    r, v, R = (result[f"plant.{name}"][:n] for name in ("r_N", "v_N", "R_NB"))
    Q = np.array([lvlh(*at).R_d.T @ R_NB for *at, R_NB in zip(r, v, R, strict=True)])
    u = np.column_stack((result["plant.dipole"] / p.dipole_max, result["plant.wheel_torque"] / p.wheel_torque_max))[:n]
    return Course(result.time[:n], Rotation.from_matrix(Q), result["plant.omega_B"][:n], result["plant.h_w"][:n], u)
