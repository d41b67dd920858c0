"""The estimator's state at a time, and its inputs over a step. Tests: tests/estimator/test_estimator.py."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from .health import BLANK, CALM, SENSORS, Watch
from .parameters import Parameters
from .so3 import Array

ZERO, NO_MATRIX, NO_LASTING = np.zeros(3), np.zeros((3, 3)), np.zeros((9, 27))


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
    """The actuators over a step: dipoles along the rods, A m2; of all wheels in body axes dl/dt, N m, and their
    momentum at its end, N m s."""

    dipole: Array
    wheel_torque_B: Array | None
    momentum_B: Array | None


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
    by_gyro: bool
    """The rate is the gyro's, not that of the equations of motion."""
    R: Array
    rate: Array
    """rad/s: that of the gyro as measured, or, without one, the estimated rate."""
    rate_bias: Array
    field_bias: Array
    P: Array
    S: Array
    """(9, 27): what each error that lasts makes of the error, beside P."""
    since_rate: float
    """s since the gyro's last measurement."""
    r_N: Array
    v_N: Array
    since_orbit: float
    """s since the last measured orbit."""
    momentum_B: Array
    """Of all wheels, N m s."""
    b_B: Array
    b_age: float
    """s since it was measured."""
    anchored: bool
    """There is an earlier field, for a start without the Sun."""
    anchor_B: Array
    """As measured, turned on with the body."""
    anchor_N: Array
    """By the model."""
    anchor_age: float
    """s"""
    disturbance_B: Array
    """N m; of the satellite where the gyro has failed."""
    nis: Array
    rejected: Array
    in_a_row: Array
    """Of each gated sensor's measurements, more that were rejected than were not."""
    watch: tuple[Watch, ...]
    """Of each sensor."""
    field_alone: Array
    """Averages in deviations: the field's strength, its angle to the Sun, nothing."""
    field_by_tracker: Array
    sun_by_tracker: Array
    """Of field and Sun against the star tracker."""
    field_calm: float
    """s for which field_alone has been small."""
    restarted: bool
    since_start: float
    """s"""
    fix_r_N: Array
    fix_v_N: Array
    """The last measured orbit, whether or not it was used."""
    since_fix: float
    """s"""
    fixes: float
    """In turn that agree with each other, where they do not with the orbit."""

    @property
    def packed(self) -> Array:
        """All of it as one array, in which an FMU keeps it."""
        return _packed(self)

    @classmethod
    def unpacked(cls, values: Array) -> Estimate:
        """The estimate of which `packed` made the array."""
        return _unpacked(cls, values, [0])

    def watched(self, sensor: int, watch: Watch) -> Estimate:
        """With another watch of a sensor."""
        return replace(self, watch=(*self.watch[:sensor], watch, *self.watch[sensor + 1 :]))

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
        by_gyro=gyro,
        R=NO_MATRIX,
        rate=omega_B if gyro else ZERO,
        rate_bias=ZERO,
        field_bias=ZERO,
        P=start_covariance(math.pi, p.rate_bias_sigma, p.field_bias_sigma),
        S=NO_LASTING,
        since_rate=0.0,
        r_N=ZERO,
        v_N=ZERO,
        since_orbit=0.0,
        momentum_B=ZERO,
        b_B=ZERO,
        b_age=0.0,
        anchored=False,
        anchor_B=ZERO,
        anchor_N=ZERO,
        anchor_age=0.0,
        disturbance_B=ZERO,
        nis=ZERO,
        rejected=ZERO,
        in_a_row=ZERO,
        watch=(BLANK,) * len(SENSORS),
        field_alone=ZERO,
        field_by_tracker=ZERO,
        sun_by_tracker=ZERO,
        field_calm=CALM,
        restarted=False,
        since_start=0.0,
        fix_r_N=ZERO,
        fix_v_N=ZERO,
        since_fix=0.0,
        fixes=0.0,
    )


def _packed(x: Estimate | Watch) -> Array:
    parts: list[Array] = []
    for f in fields(x):
        value = getattr(x, f.name)
        parts += [_packed(w) for w in value] if isinstance(value, tuple) else [np.ravel(value).astype(np.float64)]
    return np.concatenate(parts)


_MATRICES: dict[str, tuple[int, ...]] = {"P": (9, 9), "R": (3, 3), "S": (9, 27)}
_Kept = TypeVar("_Kept", Estimate, Watch)


def _unpacked(cls: type[_Kept], values: Array, at: list[int]) -> _Kept:
    parts: dict[str, Any] = {}
    for f in fields(cls):
        if f.name == "watch":
            parts[f.name] = tuple(_unpacked(Watch, values, at) for _ in SENSORS)
            continue
        shape = _MATRICES.get(f.name, (3,) if f.type == "Array" else ())
        part = values[at[0] : at[0] + math.prod(shape)].reshape(shape)
        parts[f.name] = part if shape else bool(part) if f.type == "bool" else float(part)
        at[0] += math.prod(shape)
    return cls(**parts)


def start_covariance(attitude_sigma: float, rate_sigma: float, bias_sigma: float) -> Array:
    """(9,9), with nothing known but deviations in each axis."""
    sigmas = np.repeat((attitude_sigma, rate_sigma, bias_sigma), 3)
    return np.diag(sigmas * sigmas)
