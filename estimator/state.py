"""The estimator's state at a time, and its inputs over a step. Tests: tests/estimator/test_estimator.py."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np

from .parameters import Parameters
from .so3 import Array

ZERO, NO_MATRIX = np.zeros(3), np.zeros((3, 3))


class Measured(NamedTuple):
    """The measurements that are new at the end of a step; None where there is none."""

    omega_B: Array | None
    b_B: Array | None
    orbit: tuple[Array, Array] | None
    R_NB: Array | None
    sun_B: Array | None
    sun_sensors: Array | None
    """(6,); NaN where there is no such sensor"""


class Given(NamedTuple):
    """The actuators over a step: dipoles along the rods, A m2, dl/dt, N m, wheel momentum at its end, N m s."""

    dipole: Array
    wheel_torque: float | None
    h_w: float | None


@dataclass(frozen=True)
class Estimate:
    """All that the estimator knows at t, s."""

    t: float
    known: bool
    """There is an attitude."""
    tracking: bool
    """The filter runs: its covariance is that of the attitude."""
    oriented: bool
    """There is an orbit."""
    R: Array
    rate: Array
    """rad/s: that of the gyro as measured, or, without one, the estimated rate."""
    rate_bias: Array
    field_bias: Array
    P: Array
    since_rate: float
    """s since the gyro's last measurement."""
    r_N: Array
    v_N: Array
    since_orbit: float
    """s since the last measured orbit."""
    momentum: float
    """Wheel momentum, N m s."""
    b_B: Array
    anchored: bool
    """There is an earlier field, for a start without the Sun."""
    anchor_B: Array
    """As measured, turned on with the body."""
    anchor_N: Array
    """By the model."""
    anchor_age: float
    """s"""
    nis: Array
    rejected: Array
    in_a_row: Array

    @property
    def packed(self) -> Array:
        """All of it as one array, in which an FMU keeps it."""
        return np.concatenate([np.ravel(getattr(self, f.name)).astype(np.float64) for f in fields(self)])

    @classmethod
    def unpacked(cls, values: Array) -> Estimate:
        """The estimate of which `packed` made the array."""
        parts: dict[str, Any] = {}
        at = 0
        for f in fields(cls):
            shape = (9, 9) if f.name == "P" else (3, 3) if f.name == "R" else (3,) if f.type == "Array" else ()
            size = math.prod(shape)
            part = values[at : at + size].reshape(shape)
            parts[f.name] = part if shape else bool(part) if f.type == "bool" else float(part)
            at += size
        return cls(**parts)

    @property
    def omega_B(self) -> Array:
        """(3,) rad/s"""
        return self.rate - self.rate_bias


def blank(omega_B: Array, p: Parameters) -> Estimate:
    """Before the first measurement, with the rate that the gyro's port holds."""
    gyro = p.rate_source == "gyro"
    return Estimate(
        t=0.0,
        known=False,
        tracking=False,
        oriented=False,
        R=NO_MATRIX,
        rate=omega_B if gyro else ZERO,
        rate_bias=ZERO,
        field_bias=ZERO,
        P=start_covariance(math.pi, p),
        since_rate=0.0,
        r_N=ZERO,
        v_N=ZERO,
        since_orbit=0.0,
        momentum=0.0,
        b_B=ZERO,
        anchored=False,
        anchor_B=ZERO,
        anchor_N=ZERO,
        anchor_age=0.0,
        nis=ZERO,
        rejected=ZERO,
        in_a_row=ZERO,
    )


def start_covariance(attitude_sigma: float, p: Parameters) -> Array:
    """(9,9), with nothing known of the biases but their parameters."""
    sigmas = np.repeat((attitude_sigma, p.rate_bias_sigma, p.field_bias_sigma), 3)
    return np.diag(sigmas * sigmas)
