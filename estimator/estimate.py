"""A step of the estimate: orbit, rate and attitude forward, start where there is no attitude, then each measurement.
Tests: tests/estimator/test_estimator.py."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from . import jumps, lasting, onboard
from .banked import Banked, Seen, by_bank
from .filter import propagated
from .health import ATTITUDE, FIELD, RATE, SUN, noticed
from .isolation import LASTS, compared, disturbance_sigma, gyro_lost, gyro_weighed, rate_chosen, unknown_torque
from .measurements import by_field, by_sun, by_tracker, started
from .orbit import with_orbit
from .parameters import Parameters
from .rates import Torques, turn_by_dynamics, turn_by_gyro
from .so3 import Array, exp, norm, orthonormalised
from .state import NO_MATRIX, ZERO, Estimate, Given, Measured

LIGHT_MIN = 0.5
"""Of the Sun that must be seen for its direction to count."""
FIELD_LASTS = 300.0
"""s, for which the last field is one still: its direction in N turns by 36 deg."""


def advanced(
    x: Estimate, new: Measured, given: Given, p: Parameters, h: float, banked: Banked | None = None
) -> Estimate:
    """The estimate h s later (0 at the start), with what is measured then; by a bank of filters, which it changes,
    where there is one."""
    x = replace(x, t=x.t + h)
    x = with_orbit(x, new.orbit, p, h)
    if not x.oriented:
        rate = x.rate if new.omega_B is None or not x.by_gyro else new.omega_B
        if banked is not None:
            banked.rate = rate
        return replace(x, rate=rate, b_B=x.b_B if new.b_B is None else new.b_B)
    field_N = p.field.at(x.t, x.r_N)
    sun_N = onboard.sun_direction(p.days + x.t / 86400.0)
    rods = p.rod_field @ given.dipole
    usable = bool((np.abs(given.dipole) <= p.dipole_limit).all())
    b_B = new.b_B - rods if usable and new.b_B is not None else None
    sunlight = onboard.sunlight(x.r_N, sun_N)
    sun_B = new.sun_B if sunlight > LIGHT_MIN else None
    variance = p.field_noise * p.field_noise + p.rod_field_error * p.rod_field_error * float(rods @ rods)
    x = replace(x, watch=tuple(replace(w, since=w.since + h, jumped=w.jumped + h) for w in x.watch))
    if banked is None:
        x = _followed(x, new, b_B, variance, given, p, h)
    x = _noticed(x, new, sun_B, h)
    if banked is None:
        x = _forward(rate_chosen(x, p), new.omega_B, field_N, given, p, h)
    if banked is not None:
        x = by_bank(x, banked, new, Seen(b_B, variance, sun_B, field_N, sun_N, sunlight), p, h)
        return _with_field(replace(x, R=orthonormalised(x.R)), b_B if x.watch[FIELD].trusted else None, field_N, h)
    if not x.tracking:
        x = started(x, new, sun_B, b_B, sun_N, field_N, math.sqrt(variance), p)
    x = compared(x, new.R_NB, sun_B, b_B, sun_N, field_N, variance, p)
    if new.R_NB is not None:
        x = by_tracker(x, new.R_NB, p)
    if sun_B is not None:
        x = by_sun(x, sun_B, sun_N, p)
    if b_B is not None:
        x = by_field(x, b_B, field_N, variance, p)
    for sensor, found in ((RATE, new.omega_B), (FIELD, b_B), (ATTITUDE, new.R_NB), (SUN, sun_B)):
        if found is not None:
            x = x.watched(sensor, replace(x.watch[sensor], since=0.0))
    b_B = b_B if x.watch[FIELD].trusted else None
    return _with_field(replace(x, R=orthonormalised(x.R)), b_B, field_N, h)


def _forward(x: Estimate, measured: Array | None, field_N: Array, given: Given, p: Parameters, h: float) -> Estimate:
    """Rate, attitude and covariance h s later."""
    if x.by_gyro:
        x = _by_gyro(x, measured, p, h)
        turned = x.momentum_B if given.wheel_torque_B is None else x.momentum_B + h * given.wheel_torque_B
        x = replace(x, momentum_B=turned if given.momentum_B is None else given.momentum_B)
    else:
        x = _by_dynamics(x, field_N, given, p, h)
        if measured is not None and p.rate_source == "gyro":
            x = gyro_weighed(x, measured, p)
    return replace(x, since_start=x.since_start + h)


def _followed(
    x: Estimate, new: Measured, b_B: Array | None, variance: float, given: Given, p: Parameters, h: float
) -> Estimate:
    """With the biases of gyro and magnetometer after their jumps."""
    if new.omega_B is not None:
        x = jumps.rate_followed(x, new.omega_B, given, p, h)
    return x if b_B is None else jumps.field_followed(x, b_B, variance)


def _noticed(x: Estimate, new: Measured, sun_B: Array | None, h: float) -> Estimate:
    """Each new measurement looked at for itself."""
    turns = None if new.R_NB is None else new.R_NB[(0, 1, 2), (1, 2, 0)]
    seen = ((RATE, new.omega_B, False), (FIELD, new.b_B, False), (ATTITUDE, turns, True), (SUN, sun_B, True))
    for sensor, v, every in seen:
        if v is not None:
            x = x.watched(sensor, noticed(x.watch[sensor], v, every))
    return jumps.undone(x)


def _with_field(x: Estimate, b_B: Array | None, field_N: Array, h: float) -> Estimate:
    """With the field to give out: the measured one, else the model's, else the last one, which the body turns under;
    none where that is too old."""
    age = x.b_age + h
    if b_B is not None:
        return replace(x, b_B=b_B - x.field_bias, b_age=0.0)
    if x.known:
        return replace(x, b_B=x.R.T @ field_N, b_age=age)
    return replace(x, b_B=ZERO if age > FIELD_LASTS else exp(-h * x.omega_B) @ x.b_B, b_age=age)


def _by_gyro(x: Estimate, measured: Array | None, p: Parameters, h: float) -> Estimate:
    """Rate, attitude and covariance h s later, by the gyro."""
    since, now = x.since_rate + h, x.rate if measured is None else measured
    turn = turn_by_gyro(x.omega_B, now - x.rate_bias, h, 0.0 if measured is None else since)
    walk = p.rate_random_walk * p.rate_random_walk * np.eye(3)
    step = exp(turn)
    x = replace(x, R=x.R @ step, anchor_B=step.T @ x.anchor_B, anchor_age=x.anchor_age + h)
    x = replace(x, rate=now, since_rate=since if measured is None else 0.0)
    return _spread(x, turn, -1.0, NO_MATRIX, walk, p.angle_random_walk, p, h)


def _by_dynamics(x: Estimate, field_N: Array, given: Given, p: Parameters, h: float) -> Estimate:
    """The same by the equations of motion; without an attitude the rate follows wheels, rods and measured field where
    a gyro has failed, which shows none."""
    wheel_B = given.wheel_torque_B
    if wheel_B is None:
        wheel_B = (given.momentum_B - x.momentum_B) / h if given.momentum_B is not None and h > 0.0 else ZERO
    after = x.momentum_B + h * wheel_B if given.momentum_B is None else given.momentum_B
    lost = gyro_lost(x, p)
    if not ((x.known or lost) and h > 0.0):
        return replace(x, momentum_B=after)
    r = norm(x.r_N)
    nadir = (math.sqrt(3.0 * p.gravitational_parameter / (r * r * r)) / r if x.known else 0.0) * x.r_N
    R, field_N = (x.R, field_N) if x.known else (np.eye(3), x.b_B)
    torques = Torques(p.J_B, p.J_inverse, p.rod_axes.T @ given.dipole, field_N, nadir, wheel_B, x.disturbance_B)
    growth = torques.growth(x.omega_B, x.momentum_B)
    R, turn, omega = turn_by_dynamics(R, x.omega_B, x.momentum_B, torques, h)
    unknown = unknown_torque(x.omega_B, R, torques) if lost else p.momentum_random_walk
    walk = unknown * unknown * p.J_inverse @ p.J_inverse.T
    lasting_B = math.exp(-h / LASTS) * x.disturbance_B
    x = replace(x, R=R if x.known else x.R, rate=omega + x.rate_bias, momentum_B=after, disturbance_B=lasting_B)
    return _spread(x, turn, 1.0, growth, walk, 0.0, p, h)


def _spread(
    x: Estimate, turn: Array, sign: float, F: Array, walk: Array, angle_walk: float, p: Parameters, h: float
) -> Estimate:
    if not (x.tracking and h > 0.0):
        return x
    lost = gyro_lost(x, p)
    push, lasts = (p.J_inverse, math.exp(-h / LASTS)) if lost else (NO_MATRIX, 1.0)
    bias_walk = math.sqrt(2.0 / LASTS) * disturbance_sigma(p) if lost else p.field_random_walk
    P, transition = propagated(x.P, turn, h, sign, F, walk, angle_walk, bias_walk, push, lasts)
    return replace(x, P=P, S=lasting.spread(x.S, transition, x.omega_B if x.by_gyro else ZERO, p, h))
