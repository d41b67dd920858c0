"""Which mode comes next, and the reference of each.

Requirement: SV-1.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from . import safe, slew
from .ports import (
    ACQUIRE,
    ATTITUDE_TOLERANCE,
    BY_COMMAND,
    FIRST,
    INERTIAL,
    NADIR,
    NO_ATTITUDE,
    NOT_SAFE,
    SAFE,
    SLEW,
    SUN,
    TARGET,
    TOO_FAST,
    Inputs,
    Parameters,
    State,
    connected,
    require,
)
from .reference import EARTH_RATE, Direction, Reference, free, inertial, line_of_sight, lvlh, point_on_earth, steered
from .so3 import Array, norm, principal_angle, require_rotation

SUNLIT = 0.5
"""Below this sunlight the satellite is in eclipse."""
BORESIGHT_B = np.array((0.0, 0.0, 1.0))
"""The body axis that looks at a target."""


def advance(x: State, u: Inputs, p: Parameters, h: float) -> State:
    """The state at x.t + h."""
    bounded = not connected(u.attitude_bound) or u.attitude_bound <= p.bound_lost
    known = u.attitude_valid and bounded and bool(u.R_NB.any())
    rate = norm(u.omega_B)
    x = replace(
        x,
        t=x.t + h,
        calm=x.calm + h if rate < p.rate_acquire else 0.0,
        fast=x.fast + h if rate > p.rate_lost else 0.0,
        blind=0.0 if known else x.blind + h,
    )
    wanted = _wanted(u, p)
    spins = rate > p.rate_lost and x.fast >= p.rate_time
    if wanted == SAFE or (x.mode != SAFE and (spins or (not known and x.blind >= p.attitude_time))):
        reason = BY_COMMAND if wanted == SAFE else TOO_FAST if spins else NO_ATTITUDE
        kept = {n: getattr(x, n) for n in ("field_direction", "field_rate", "towards")} if x.mode == SAFE else {}
        x = State(x.t, safe_reason=reason, calm=x.calm, fast=x.fast, blind=x.blind, **kept)
        return safe.pointed(x, u, p, h)
    aim = _aim(wanted, u)
    if x.mode == SAFE:
        if not (x.calm >= p.rate_time and rate < p.rate_acquire and known):
            return safe.pointed(x, u, p, h)
        x = State(x.t, ACQUIRE, wanted, NOT_SAFE, aim, u.R_NB, x.calm, x.fast, x.blind)
    elif wanted != x.destination or not np.array_equal(aim, x.aim):
        x = _turned_to(x, wanted, aim, u, p)
    if x.mode == SLEW and x.t >= x.slew_start + x.slew_duration:
        x = replace(x, mode=x.destination)
    x = replace(x, kept=destination(x, u, p).R_ref)
    return _judged(x, u, p, h) if known else x


def _wanted(u: Inputs, p: Parameters) -> int:
    """The mode that is asked for: by the command, else the first one; in eclipse nothing is to be had from the Sun."""
    wanted = u.command if u.command > 0 else FIRST[p.first_mode]
    return NADIR if wanted == SUN and connected(u.sunlight) and u.sunlight < SUNLIT else wanted


def _turned_to(x: State, wanted: int, aim: Array, u: Inputs, p: Parameters) -> State:
    """On the way to another destination: by a slew from the present reference, in acquisition at once."""
    now = reference_now(x, u, p)
    x = replace(x, destination=wanted, aim=aim, kept=now.R_ref)
    if x.mode == ACQUIRE:
        return replace(x, settled=0.0)
    turn = slew.begin(now, destination(x, u, p), p.J_B, p.slew_rate_max, p.slew_torque_max)
    return replace(x, mode=SLEW, slew_start=x.t, slew_duration=turn.duration, phi0=turn.phi0, dphi0=turn.dphi0, off=0.0)


def _judged(x: State, u: Inputs, p: Parameters, h: float) -> State:
    """Acquisition ends where the errors have been small for a time, and begins where they have been large."""
    now = reference_now(x, u, p)
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


def reference_now(x: State, u: Inputs, p: Parameters) -> Reference:
    """The reference at x.t; in the mode safe no attitude, a matrix of zeros, and the rate x.towards in body axes."""
    if x.mode == SAFE:
        return Reference(np.zeros((3, 3)), x.towards, np.zeros(3))
    to = destination(x, u, p)
    if x.mode == SLEW:
        return slew.at(slew.Slew(x.slew_duration, x.phi0, x.dphi0), x.t - x.slew_start, to)
    return to


def destination(x: State, u: Inputs, p: Parameters) -> Reference:
    """The reference of the destination at x.t."""
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
    """Returns the target of a mode, as the state keeps it. Raises ValueError where an input that the mode
    needs is not connected."""
    aim = np.zeros(9)
    if wanted == INERTIAL:
        require("R_goal", u.R_goal, "the mode 'inertial' is asked for")
        require_rotation("R_goal", u.R_goal, ATTITUDE_TOLERANCE)
        aim[:] = u.R_goal.ravel()
    elif wanted == TARGET:
        for i, name in enumerate(("target_latitude", "target_longitude", "target_height")):
            require(name, getattr(u, name), "the mode 'target' is asked for")
            aim[i] = getattr(u, name)
    elif wanted == SUN:
        require("sun_N", u.sun_N, "the mode 'sun' is asked for")
    return aim
