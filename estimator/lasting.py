"""Errors of the sensors that last: what they make of the estimate, beside the covariance, which takes noise for white.

A consider analysis (Schmidt, 1966; Markley and Crassidis, Fundamentals of Spacecraft Attitude Determination and
Control, section 12.3.4): S (9, 27) is the error of the estimate for each error that lasts at one standard deviation.
The filter does not estimate them; its gains say what they do. Tests: tests/estimator/test_bound.py.

Requirement: ES-5.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from .filter import ATTITUDE, BIAS, RATE, Innovation
from .parameters import Parameters
from .so3 import Array, norm
from .state import NO_LASTING, Estimate

OFFSET, SCALE, GYRO = slice(0, 3), slice(3, 12), slice(12, 15)
"""Columns: an offset of the field, a matrix that distorts it by rows, the gyro's scale."""
SUN, TRACKER, START = slice(15, 18), slice(18, 21), slice(21, 24)
"""Turns of Sun, star tracker and first attitude."""
DRIFT, GROWS = slice(24, 27), 600.0
"""An offset of the field that has grown for minutes, by e in GROWS, s: of one that lasts the bias takes most."""
SURE = 2.5758293035489004
"""Of the root of a quadratic form's mean: a normal number is below it, in magnitude, with 99%."""


def lasting(sensor: int, innovation: Innovation, p: Parameters) -> Array:
    """(3, 27): what the errors that last add to the innovation of field, Sun or star tracker (0, 1, 2)."""
    G = np.zeros((3, 27))
    if sensor == 0:
        skew = innovation.H_attitude
        b = np.array((skew[2, 1], skew[0, 2], skew[1, 0]))
        G[:, OFFSET] = G[:, DRIFT] = p.lasting_field * np.eye(3)
        G[:, SCALE] = p.lasting_field_scale * np.kron(np.eye(3), b)
    elif sensor == 1:
        G[:, SUN] = p.lasting_sun * innovation.H_attitude
    else:
        G[:, TRACKER] = p.lasting_attitude * innovation.H_attitude
    return G


def begun(off: float) -> Array:
    """S of a first attitude that is `off` rad off about each axis by errors that last."""
    S = NO_LASTING.copy()
    S[ATTITUDE, START] = off * np.eye(3)
    return S


def spread(S: Array, transition: Array, omega_B: Array, p: Parameters, h: float) -> Array:
    """S after a step of h s: the gyro's scale turns the attitude as a bias of its part of omega_B does."""
    S = transition @ S
    S[:, DRIFT] *= math.exp(-h / GROWS)
    S[ATTITUDE, GYRO] += p.lasting_rate_scale * transition[ATTITUDE, RATE] * omega_B
    return S


def corrected(S: Array, gains: Array, innovation: Innovation, G: Array) -> Array:
    """S after a measurement whose components were taken in turn with `gains` (3, 9)."""
    for K, attitude, bias, g in zip(gains, innovation.H_attitude, innovation.H_bias, G, strict=True):
        S = S - np.outer(K, attitude @ S[ATTITUDE] + bias @ S[BIAS] + g)
    return S


def bound(x: Estimate, doubtful: bool, p: Parameters) -> float:
    """rad: the attitude's error is below it with 99%; pi without an attitude.

    Of all normal errors with the same mean square the one about a single axis exceeds 2.58 times its root most often
    (Szekely and Bakirov, Probability Theory and Related Fields 126, 2003), so no shape of the covariance matters.
    """
    if not x.tracking or doubtful:
        return math.pi
    square = float(np.trace(x.P[ATTITUDE, ATTITUDE]) + (x.S[ATTITUDE, : DRIFT.start] ** 2).sum())
    if p.bank:
        field = p.lasting_field / norm(x.b_B) + p.lasting_field_scale
        square += field * field + p.lasting_sun * p.lasting_sun
    return min(SURE * math.sqrt(square), math.pi)


def without_rate(x: Estimate, sign: float) -> Estimate:
    """Returns where the gyro is left out (-1: the rate's error is minus that of its bias) or comes back (0)."""
    S = x.S.copy()
    S[RATE] *= sign
    S[BIAS] = 0.0
    return replace(x, S=S)
