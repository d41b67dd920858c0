"""The multiplicative extended Kalman filter: an error state (attitude, rate or its bias, bias of the field), its
covariance.

R_true = R exp(δ^); the other errors are additive. Lefferts, Markley and Shuster, Kalman filtering for spacecraft
attitude estimation, JGCD 5 (1982); Markley and Crassidis, Fundamentals of Spacecraft Attitude Determination and
Control, chapter 6. Tests: tests/estimator/test_estimator.py.

Requirement: ES-2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .so3 import Array, exp, right_jacobian

ATTITUDE, RATE, BIAS = slice(0, 3), slice(3, 6), slice(6, 9)
"""Where the three parts of the error stand; where the gyro has failed the last one is that of the disturbance."""


@dataclass(frozen=True)
class Innovation:
    """A measurement against its prediction: y (3,) = H_attitude δ + H_bias μ + noise of variances r (3,), independent.

    `lasting`: deviation of errors that last, beside r, for what is averaged.
    """

    y: Array
    H_attitude: Array
    H_bias: Array
    r: Array
    lasting: float = 0.0


def propagated(
    P: Array,
    turn: Array,
    h: float,
    sign: float,
    F: Array,
    walk: Array,
    angle_walk: float,
    bias_walk: float,
    push: Array,
    lasts: float,
) -> tuple[Array, Array]:
    """The covariance P (9,9) after h s, in which the body turns by `turn` (3,), rad, and the transition (9,9).

    The rate's error grows by F (3,3), 1/s, and by noise of `walk` (3,3), rad2/s3; it turns the attitude's error with
    `sign`: -1 for a gyro's bias, +1 for a rate. `angle_walk`, rad, and `bias_walk`, T, are standard deviations of 1 s.
    Where the last part is a torque, it pushes the rate by `push` (3,3), 1/(kg m2), and `lasts` of it is left after h.
    """
    transition, noise = np.eye(9), np.zeros((9, 9))
    growth = h * F
    transition[ATTITUDE, ATTITUDE] = exp(turn).T
    transition[ATTITUDE, RATE] = sign * h * right_jacobian(turn) @ (np.eye(3) + 0.5 * growth)
    transition[RATE, RATE] = np.eye(3) + growth + 0.5 * growth @ growth
    transition[RATE, BIAS], transition[BIAS, BIAS] = h * push, lasts * np.eye(3)
    noise[ATTITUDE, ATTITUDE] = h * angle_walk * angle_walk * np.eye(3) + h * h * h / 3.0 * walk
    noise[ATTITUDE, RATE] = noise[RATE, ATTITUDE] = sign * 0.5 * h * h * walk
    noise[RATE, RATE] = h * walk
    noise[BIAS, BIAS] = h * bias_walk * bias_walk * np.eye(3)
    P = transition @ P @ transition.T + noise
    return 0.5 * (P + P.T), transition


def corrected(P: Array, innovation: Innovation) -> tuple[Array, Array, float, Array, Array]:
    """Error state (9,), covariance (9,9) and normalised innovation squared of a measurement, its components over
    their deviations with what lasts (3,), and their gains (3,9); they are taken in turn.

    Each in Joseph's form, in which P stays positive whatever is rounded.
    """
    error, nis, scaled, gains = np.zeros(9), 0.0, [], []
    H = np.hstack((innovation.H_attitude, np.zeros((3, 3)), innovation.H_bias))
    for y, row, r in zip(innovation.y, H, innovation.r, strict=True):
        PH = P @ row
        s = float(row @ PH) + float(r)
        K = PH / s
        gains.append(K)
        left = float(y) - float(row @ error)
        error = error + left * K
        nis += left * left / s
        scaled.append(left / math.sqrt(s + innovation.lasting * innovation.lasting))
        M = P - np.outer(K, PH)
        P = M - np.outer(M @ row, K) + float(r) * np.outer(K, K)
        P = 0.5 * (P + P.T)
    return error, P, nis, np.array(scaled), np.array(gains)
