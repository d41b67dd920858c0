"""A gyro or magnetometer whose measurement jumps by more than the satellite can turn: its bias has changed by that.

docs/how/health.md, Jumps. Tests: tests/estimator/test_jumps.py.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from .health import CALM, FIELD, RATE, jumped
from .parameters import Parameters
from .so3 import Array, cross, exp, norm
from .state import ZERO, Estimate, Given

RATE_JUMP, FIELD_JUMP = 2e-3, 5e-6
"""Least jumps: rad/s, T."""
FIELD_NOISE = 2.0
"""Deviations of the field's stated noise: the same."""
UNCERTAIN = 4.0
"""Of the usual mean square: variance of a jump in each axis."""


def rate_followed(x: Estimate, measured: Array, given: Given, p: Parameters, h: float) -> Estimate:
    """With the gyro's bias after its jump at a new measurement, rad/s, at the end of a step of h s."""
    watch = x.watch[RATE]
    dt = watch.since
    if not x.by_gyro or not dt > 0.0 or (given.momentum_B is None and given.wheel_torque_B is None):
        return x
    omega, wheel_B = x.omega_B, ZERO if given.wheel_torque_B is None else given.wheel_torque_B
    if given.momentum_B is not None and h > 0.0:
        wheel_B = (given.momentum_B - x.momentum_B) / h
    motor = p.J_inverse @ -wheel_B
    turning = p.J_inverse @ cross(p.J_B @ omega + x.momentum_B, omega)
    off = measured - x.rate - dt * (turning + motor)
    watch, jumps = jumped(watch, off, RATE_JUMP + dt * norm(motor))
    x = x.watched(RATE, watch)
    if not jumps:
        return x
    return replace(x, rate=x.rate + off, rate_bias=x.rate_bias + off, P=_doubted(x.P, 3, watch.usual))


def field_followed(x: Estimate, b_B: Array, variance: float) -> Estimate:
    """The same of the magnetometer, where x.b_B is that of its last measurement."""
    watch = x.watch[FIELD]
    dt = watch.since
    if not x.by_gyro or not dt > 0.0 or x.b_age > 0.0:
        return x
    off = b_B - x.field_bias - exp(-dt * x.omega_B) @ x.b_B
    watch, jumps = jumped(watch, off, max(FIELD_JUMP, FIELD_NOISE * math.sqrt(variance)))
    x = x.watched(FIELD, watch)
    return replace(x, field_bias=x.field_bias + off, P=_doubted(x.P, 6, watch.usual)) if jumps else x


def undone(x: Estimate) -> Estimate:
    """Without the jump of a sensor to where it is frozen."""
    gyro, field = x.watch[RATE], x.watch[FIELD]
    if gyro.jumped_to_rest:
        x = replace(x, rate=x.rate - gyro.jump, rate_bias=x.rate_bias - gyro.jump)
        x = x.watched(RATE, replace(gyro, jumped=CALM))
    if field.jumped_to_rest:
        x = replace(x, field_bias=x.field_bias - field.jump).watched(FIELD, replace(field, jumped=CALM))
    return x


def _doubted(P: Array, first: int, usual: float) -> Array:
    grown = np.zeros(9)
    grown[first : first + 3] = UNCERTAIN * usual
    return P + np.diag(grown)
