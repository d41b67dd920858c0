"""The supervisor as a block: which mode it is in, and the reference of that mode.
Tests: tests/supervisor/test_modes.py."""

from __future__ import annotations

import math

import numpy as np

from .ahead import looked
from .modes import advance, reference_now
from .ports import (
    ATTITUDE_TOLERANCE,
    INERTIAL,
    NADIR,
    SAFE,
    SLEW,
    SUN,
    TARGET,
    Inputs,
    Outputs,
    Parameters,
    State,
    check,
    connected,
)
from .reference import EARTH_RATE, elevation, point_on_earth
from .so3 import require_rotation

__all__ = ["Inputs", "Outputs", "Parameters", "State", "check", "outputs", "start", "step"]

COMMANDS = (0, SAFE, NADIR, INERTIAL, TARGET, SUN)
LIMITS = {
    "target_latitude": (-0.5 * math.pi, 0.5 * math.pi),
    "target_longitude": (-2.0 * math.pi, 2.0 * math.pi),
    "target_height": (-12e3, 1e6),
}
"""Of a point on the Earth: rad, rad, m."""


def start(p: Parameters, u: Inputs) -> State:
    """The state at t = 0: safe, or in acquisition where nothing has to be waited for."""
    _check_inputs(u)
    return looked(advance(State(0.0), u, p, 0.0), u, p)


def step(x: State, u: Inputs, p: Parameters, h: float) -> tuple[State, Outputs]:
    """From t to t + h; u are the inputs at t + h."""
    _check_inputs(u)
    after = advance(x, u, p, h)
    other = (after.mode, after.destination, after.slew_start) != (x.mode, x.destination, x.slew_start)
    if other or after.t >= after.ahead_next - 1e-6 * h:  # since t is a sum of steps
        after = looked(after, u, p)
    return after, outputs(after, u, p)


def outputs(x: State, u: Inputs, p: Parameters) -> Outputs:
    """The reference at x.t, of the inputs as they stand."""
    _check_inputs(u)
    y = reference_now(x, u, p)
    return Outputs(
        R_ref=y.R_ref,
        Omega_ref=y.Omega_ref,
        dOmega_ref=y.dOmega_ref,
        t_ahead=x.t_ahead - x.t if x.ahead_next > 0.0 else x.t_ahead,
        turn_ahead=x.turn_ahead,
        Omega_ahead=x.Omega_ahead,
        mode=x.mode,
        destination=x.destination,
        safe_reason=x.safe_reason,
        slew_remaining=max(x.slew_start + x.slew_duration - x.t, 0.0) if x.mode == SLEW else 0.0,
        target_elevation=_target_elevation(x, u, p),
    )


def _target_elevation(x: State, u: Inputs, p: Parameters) -> float:
    coordinates = u.target_latitude, u.target_longitude, u.target_height
    if not all(connected(c) for c in coordinates):
        return -0.5 * math.pi
    point = point_on_earth(*coordinates)
    return elevation(point, *coordinates[:2], p.sidereal_angle_0 + EARTH_RATE * x.t, u.r_N)


def _check_inputs(u: Inputs) -> None:
    for name in ("R_NB", "omega_B", "r_N", "v_N", "R_goal", "sun_N", "b_B", "sun_B"):
        if not np.isfinite(value := getattr(u, name)).all():
            raise ValueError(f"{name}: expected finite numbers, found {value.tolist()}")
    for name in ("target_latitude", "target_longitude", "target_height", "sunlight", "attitude_bound"):
        if not math.isfinite(value := getattr(u, name)):
            raise ValueError(f"{name}: expected a finite number, found {value!r}")
    for name, (low, high) in LIMITS.items():
        value = getattr(u, name)
        if connected(value) and not low <= value <= high:
            raise ValueError(f"{name}: expected at least {low:g} and at most {high:g}, found {value!r}")
    if u.command >= 0 and u.command not in COMMANDS:
        raise ValueError(
            f"command: expected 0 (none), 1 (safe), 3 (nadir), 4 (inertial), 6 (target) or 7 (sun), found {u.command}"
        )
    if u.R_NB.any() and u.attitude_valid:
        require_rotation("R_NB", u.R_NB, ATTITUDE_TOLERANCE)
