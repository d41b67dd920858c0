"""The supervisor as a block: which mode it is in, and the reference of that mode."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from . import slew
from .ports import (
    ACQUIRE,
    FIRST,
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
from .reference import (
    EARTH_RATE,
    Direction,
    Reference,
    elevation,
    free,
    inertial,
    line_of_sight,
    lvlh,
    point_on_earth,
    steered,
)
from .so3 import Array, norm, principal_angle, require_rotation

__all__ = ["Inputs", "Outputs", "Parameters", "State", "check", "outputs", "start", "step"]

ATTITUDE_TOLERANCE = 1e-4
"""max |R^T R - I| of R_NB and R_goal: single precision stays well below it."""
SUNLIT = 0.5
"""Below this sunlight the satellite is in eclipse."""
COMMANDS = (0, SAFE, NADIR, INERTIAL, TARGET, SUN)
NO_REFERENCE = Reference(np.zeros((3, 3)), np.zeros(3), np.zeros(3))
BORESIGHT_B = np.array((0.0, 0.0, 1.0))
"""The body axis that looks at a target."""


def start(p: Parameters, u: Inputs) -> State:
    """The state at t = 0: safe, or in acquisition where nothing has to be waited for."""
    return _next(State(0.0), u, p, 0.0)


def step(x: State, u: Inputs, p: Parameters, h: float) -> tuple[State, Outputs]:
    """From t to t + h; u are the inputs at t + h."""
    x = _next(x, u, p, h)
    return x, outputs(x, u, p)


def outputs(x: State, u: Inputs, p: Parameters) -> Outputs:
    """The reference at x.t, of the inputs as they stand."""
    _check_inputs(u)
    y = _reference(x, u, p)
    return Outputs(
        R_ref=y.R_ref,
        Omega_ref=y.Omega_ref,
        dOmega_ref=y.dOmega_ref,
        mode=x.mode,
        destination=x.destination,
        slew_remaining=max(x.slew_start + x.slew_duration - x.t, 0.0) if x.mode == SLEW else 0.0,
        target_elevation=_target_elevation(x, u, p),
    )


# ---------------------------------------------------------------- modes


def _next(x: State, u: Inputs, p: Parameters, h: float) -> State:
    """The state at x.t + h."""
    _check_inputs(u)
    known = u.attitude_valid and bool(u.R_NB.any())
    rate = norm(u.omega_B)
    x = replace(
        x,
        t=x.t + h,
        calm=x.calm + h if rate < p.rate_acquire else 0.0,
        fast=x.fast + h if rate > p.rate_lost else 0.0,
        blind=0.0 if known else x.blind + h,
    )
    wanted = _wanted(u, p)
    if wanted == SAFE or (x.mode != SAFE and _is_lost(x, rate, known, p)):
        return State(x.t, calm=x.calm, fast=x.fast, blind=x.blind)
    aim = _aim(wanted, u)
    if x.mode == SAFE:
        if not (x.calm >= p.rate_time and rate < p.rate_acquire and known):
            return x
        x = replace(x, mode=ACQUIRE, destination=wanted, aim=aim, kept=u.R_NB, settled=0.0, off=0.0)
    elif wanted != x.destination or not np.array_equal(aim, x.aim):
        x = _turned_to(x, wanted, aim, u, p)
    if x.mode == SLEW and x.t >= x.slew_start + x.slew_duration:
        x = replace(x, mode=x.destination)
    x = replace(x, kept=_destination(x, u, p).R_ref)
    return _judged(x, u, p, h) if known else x


def _wanted(u: Inputs, p: Parameters) -> int:
    """The mode that is asked for: by the command, else the first one; in eclipse nothing is to be had from the Sun."""
    wanted = u.command if u.command > 0 else FIRST[p.first_mode]
    return NADIR if wanted == SUN and connected(u.sunlight) and u.sunlight < SUNLIT else wanted


def _is_lost(x: State, rate: float, known: bool, p: Parameters) -> bool:
    return (not known and x.blind >= p.attitude_time) or (rate > p.rate_lost and x.fast >= p.rate_time)


def _turned_to(x: State, wanted: int, aim: Array, u: Inputs, p: Parameters) -> State:
    """On the way to another destination: by a slew from the present reference, in acquisition at once."""
    now = _reference(x, u, p)
    x = replace(x, destination=wanted, aim=aim, kept=now.R_ref)
    if x.mode == ACQUIRE:
        return replace(x, settled=0.0)
    turn = slew.begin(now, _destination(x, u, p), p.J_B, p.slew_rate_max, p.slew_torque_max)
    return replace(x, mode=SLEW, slew_start=x.t, slew_duration=turn.duration, phi0=turn.phi0, dphi0=turn.dphi0, off=0.0)


def _judged(x: State, u: Inputs, p: Parameters, h: float) -> State:
    """Acquisition ends where the errors have been small for a time, and begins where they have been large."""
    now = _reference(x, u, p)
    Q = now.R_ref.T @ u.R_NB
    angle, rate = principal_angle(Q), norm(u.omega_B - Q.T @ now.Omega_ref)
    if x.mode == ACQUIRE:
        settled = angle < p.settled_angle and rate < p.settled_rate
        x = replace(x, settled=x.settled + h if settled else 0.0)
        return replace(x, mode=x.destination, off=0.0) if settled and x.settled >= p.settled_time else x
    off = angle > p.angle_lost
    x = replace(x, off=x.off + h if off else 0.0)
    return replace(x, mode=ACQUIRE, settled=0.0) if off and x.off >= p.angle_time else x


# ---------------------------------------------------------------- references


def _reference(x: State, u: Inputs, p: Parameters) -> Reference:
    if x.mode == SAFE:
        return NO_REFERENCE
    to = _destination(x, u, p)
    if x.mode == SLEW:
        return slew.at(slew.Slew(x.slew_duration, x.phi0, x.dphi0), x.t - x.slew_start, to)
    return to


def _destination(x: State, u: Inputs, p: Parameters) -> Reference:
    if x.destination == INERTIAL:
        return inertial(x.aim.reshape(3, 3))
    if x.destination == SUN:
        return free(p.sun_axis_B, Direction(_sun(u), np.zeros(3), np.zeros(3)), x.kept)
    if x.destination == TARGET:
        latitude, longitude, height = x.aim[:3].tolist()
        point = point_on_earth(latitude, longitude, height)
        z = line_of_sight(point, p.sidereal_angle_0 + EARTH_RATE * x.t, u.r_N, u.v_N, p.gravitational_parameter)
        if p.target_yaw == "free":
            return free(BORESIGHT_B, z, x.kept)
        h = np.cross(u.r_N, u.v_N)
        return steered(z, h / norm(h), p.target_yaw_angle)
    return lvlh(u.r_N, u.v_N)


def _sun(u: Inputs) -> Array:
    if not 0.5 < (size := norm(u.sun_N)) < 2.0:
        raise ValueError(f"sun_N: expected a unit vector, found {u.sun_N.tolist()}")
    return u.sun_N / size


def _aim(wanted: int, u: Inputs) -> Array:
    """What a mode points at, as the state keeps it. Raises ValueError where an input that the mode needs is not connected."""
    aim = np.zeros(9)
    if wanted == INERTIAL:
        _require("R_goal", u.R_goal, "inertial")
        require_rotation("R_goal", u.R_goal, ATTITUDE_TOLERANCE)
        aim[:] = u.R_goal.ravel()
    elif wanted == TARGET:
        for i, name in enumerate(("target_latitude", "target_longitude", "target_height")):
            _require(name, getattr(u, name), "target")
            aim[i] = getattr(u, name)
    elif wanted == SUN:
        _require("sun_N", u.sun_N, "sun")
    return aim


def _require(name: str, value: Array | float, mode: str) -> None:
    if not connected(value):
        raise ValueError(f"{name}: expected a value, since the mode '{mode}' is asked for, found 1e9 (not connected)")


def _target_elevation(x: State, u: Inputs, p: Parameters) -> float:
    coordinates = u.target_latitude, u.target_longitude, u.target_height
    if not all(connected(c) for c in coordinates):
        return -0.5 * math.pi
    point = point_on_earth(*coordinates)
    return elevation(point, *coordinates[:2], p.sidereal_angle_0 + EARTH_RATE * x.t, u.r_N)


def _check_inputs(u: Inputs) -> None:
    for name in ("R_NB", "omega_B", "r_N", "v_N", "R_goal", "sun_N"):
        if not np.isfinite(value := getattr(u, name)).all():
            raise ValueError(f"{name}: expected finite numbers, found {value.tolist()}")
    for name in ("target_latitude", "target_longitude", "target_height", "sunlight"):
        if not math.isfinite(value := getattr(u, name)):
            raise ValueError(f"{name}: expected a finite number, found {value!r}")
    if u.command >= 0 and u.command not in COMMANDS:
        raise ValueError(
            f"command: expected 0 (none), 1 (safe), 3 (nadir), 4 (inertial), 6 (target) or 7 (sun), found {u.command}"
        )
    if u.R_NB.any() and u.attitude_valid:
        require_rotation("R_NB", u.R_NB, ATTITUDE_TOLERANCE)
