"""Parameters, inputs, state and outputs of the supervisor. Units, frames and limits are those of
fmus/interfaces/supervisor.toml. Tests: tests/supervisor/test_modes.py."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from .reference import sidereal_angle
from .so3 import Array

SAFE, ACQUIRE, NADIR, INERTIAL, SLEW, TARGET, SUN = range(1, 8)
"""The modes, as `mode`, `destination` and `command` count them."""
NOT_SAFE, SINCE_START, BY_COMMAND, TOO_FAST, NO_ATTITUDE = range(5)
"""Why it is in the mode safe, as `safe_reason` says it."""
FIRST = {"nadir": NADIR, "inertial": INERTIAL, "target": TARGET, "sun": SUN}
SAFE_POINTING = ("none", "field", "sun")
AHEAD = 16
"""Times at which the reference to come is given."""
ATTITUDE_TOLERANCE = 1e-4
"""max |R^T R - I| of R_NB and R_goal: single precision stays well below it."""
YEARS = (1900, 2100)
"""For which the polynomial of sidereal time holds."""
ABSENT_MIN = 0.999e9
"""An optional input that holds this or more is not connected; its start is 1e9, which a host may have rounded."""


@dataclass(frozen=True)
class Parameters:
    """J_B (3, 3), axes (3,) in body axes. Limits are those of fmus/interfaces/supervisor.toml."""

    J_B: Array
    slew_rate_max: float
    slew_torque_max: float
    ahead_horizon: float
    safe_pointing: str
    safe_axis_B: Array
    safe_time: float
    first_mode: str
    rate_acquire: float
    rate_lost: float
    rate_time: float
    settled_angle: float
    settled_rate: float
    settled_time: float
    angle_lost: float
    angle_time: float
    attitude_time: float
    bound_lost: float
    target_yaw: str
    target_yaw_angle: float
    sun_axis_B: Array
    epoch: str
    gravitational_parameter: float

    @cached_property
    def sidereal_angle_0(self) -> float:
        """Sidereal angle of Greenwich at t = 0, rad."""
        return sidereal_angle(self.epoch)


@dataclass(frozen=True)
class Inputs:
    """Matrices (3, 3), vectors (3,), the rest numbers; `command` counts the modes from 1, 0: first_mode."""

    R_NB: Array
    omega_B: Array
    r_N: Array
    v_N: Array
    attitude_valid: bool
    attitude_bound: float
    command: int
    R_goal: Array
    target_latitude: float
    target_longitude: float
    target_height: float
    sun_N: Array
    sunlight: float
    b_B: Array
    sun_B: Array


@dataclass(frozen=True)
class State:
    """The time, s, the modes, how long conditions have lasted, and the slew that goes on."""

    t: float
    mode: int = SAFE
    destination: int = SAFE
    """The mode that acquisition or slew leads to; the mode itself otherwise."""
    safe_reason: int = SINCE_START
    aim: Array = field(default_factory=lambda: np.zeros(9))
    """The target of the destination: R_goal, row by row, or latitude, longitude and height; zeros for the others."""
    kept: Array = field(default_factory=lambda: np.eye(3))
    """The attitude of a destination whose turn about its axis is free, at t."""
    calm: float = 0.0
    """s for which the rate has been below rate_acquire."""
    fast: float = 0.0
    """s for which it has been above rate_lost."""
    blind: float = 0.0
    """s without an attitude."""
    settled: float = 0.0
    """s for which the errors have been small, in acquisition."""
    off: float = 0.0
    """s for which the attitude has been too far from the reference."""
    slew_start: float = 0.0
    slew_duration: float = 0.0
    phi0: Array = field(default_factory=lambda: np.zeros(3))
    dphi0: Array = field(default_factory=lambda: np.zeros(3))
    field_direction: Array = field(default_factory=lambda: np.zeros(3))
    """In the mode safe: direction of the field, in body axes; zeros while none is measured."""
    field_rate: Array = field(default_factory=lambda: np.zeros(3))
    """Its rate relative to N, rad/s, in body axes."""
    towards: Array = field(default_factory=lambda: np.zeros(3))
    """In the mode safe: the rate that is asked for, rad/s, in body axes."""
    ahead_next: float = 0.0
    """s, when the reference to come is given anew; 0: it is not given."""
    t_ahead: Array = field(default_factory=lambda: np.zeros(AHEAD))
    """s, and not from now."""
    turn_ahead: Array = field(default_factory=lambda: np.zeros((AHEAD, 3)))
    Omega_ahead: Array = field(default_factory=lambda: np.zeros((AHEAD, 3)))


@dataclass(frozen=True)
class Outputs:
    """R_ref (3, 3), vectors (3,); of the reference to come times (16,), turns and rates (16, 3)."""

    R_ref: Array
    Omega_ref: Array
    dOmega_ref: Array
    t_ahead: Array
    turn_ahead: Array
    Omega_ahead: Array
    mode: int
    destination: int
    safe_reason: int
    slew_remaining: float
    target_elevation: float


def connected(value: Array | float) -> bool:
    """Returns whether an optional input is connected."""
    return not bool((np.abs(value) >= ABSENT_MIN).any())


def require(name: str, value: Array | float, why: str) -> None:
    """Raises ValueError where an optional input that is needed is not connected."""
    if not connected(value):
        raise ValueError(f"{name}: expected a value, since {why}, found 1e9 (not connected)")


def check(p: Parameters) -> None:
    """Raises ValueError with name, value and what is expected."""
    for name in ("slew_rate_max", "slew_torque_max", "rate_acquire", "rate_lost", "settled_angle", "settled_rate"):
        _positive(name, getattr(p, name))
    for name in ("angle_lost", "gravitational_parameter", "safe_time", "bound_lost"):
        _positive(name, getattr(p, name))
    for name in ("rate_time", "settled_time", "angle_time", "attitude_time", "ahead_horizon"):
        if not 0.0 <= (value := getattr(p, name)) < math.inf:
            raise ValueError(f"{name}: expected a finite number of at least 0, found {value!r}")
    if not math.isfinite(p.target_yaw_angle):
        raise ValueError(f"target_yaw_angle: expected a finite number, found {p.target_yaw_angle!r}")
    if p.first_mode not in FIRST:
        raise ValueError(f"first_mode: expected one of {', '.join(FIRST)}, found {p.first_mode!r}")
    if p.target_yaw not in ("steered", "free"):
        raise ValueError(f"target_yaw: expected one of steered, free, found {p.target_yaw!r}")
    if p.safe_pointing not in SAFE_POINTING:
        raise ValueError(f"safe_pointing: expected one of {', '.join(SAFE_POINTING)}, found {p.safe_pointing!r}")
    if not p.rate_acquire <= p.rate_lost:
        raise ValueError(f"rate_lost: expected at least rate_acquire, {p.rate_acquire!r}, found {p.rate_lost!r}")
    for name in ("sun_axis_B", "safe_axis_B"):
        if not abs(float(np.linalg.norm(axis := getattr(p, name))) - 1.0) <= 1e-6:
            raise ValueError(f"{name}: expected a vector of unit length, to 1e-06, found {axis.tolist()}")
    _inertia(p.J_B)
    sidereal_angle(p.epoch)
    if not YEARS[0] <= (year := int(p.epoch[:4])) <= YEARS[1]:
        raise ValueError(f"epoch: expected a year from {YEARS[0]} to {YEARS[1]}, found {year}")


def _positive(name: str, value: float) -> None:
    if not 0.0 < value < math.inf:
        raise ValueError(f"{name}: expected a finite number above 0, found {value!r}")


def _inertia(J: Array) -> None:
    if not np.isfinite(J).all():
        raise ValueError(f"J_B: expected finite numbers, found {J.tolist()}")
    if np.abs(J - J.T).max() > 1e-9 * np.abs(J).max():
        raise ValueError(f"J_B: expected a symmetric matrix, found {J.tolist()}")
    smallest, middle, largest = np.linalg.eigvalsh(J).tolist()
    if not smallest > 0.0:
        raise ValueError(f"J_B: expected a positive definite matrix, found its least eigenvalue {smallest:g}")
    if largest > (smallest + middle) * (1.0 + 1e-9):
        raise ValueError(
            f"J_B: expected the inertia of a body, each principal moment at most the sum of the other two, "
            f"found principal moments {smallest:g}, {middle:g}, {largest:g} kg m2"
        )
