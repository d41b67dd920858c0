"""The parameters: their check, and what follows from them alone. Tests: tests/estimator/test_estimator.py."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from . import onboard, tables
from .field import OnboardField
from .so3 import Array, norm

RATE_SOURCES = ("gyro", "dynamics")
UNIT_TOLERANCE = 1e-6
"""Of a direction's length."""


@dataclass(frozen=True)
class Parameters:
    """Units, frames and limits are those of fmus/interfaces/estimator.toml."""

    rate_source: str
    angle_random_walk: float
    rate_random_walk: float
    rate_bias_sigma: float
    rate_scale_sigma: float
    J_B: Array
    rod_axes: Array
    wheel_axis: Array
    """(3,), or (4, 3) of a set of wheels."""
    momentum_random_walk: float
    field_noise: float
    field_bias_sigma: float
    field_random_walk: float
    rod_field: Array
    rod_field_error: float
    dipole_limit: float
    sun_noise: float
    sun_sensor_axes: Array
    sun_sensor_noise: float
    albedo: float
    attitude_noise: float
    attitude_noise_boresight: float
    boresight_B: Array
    lasting_field: float
    lasting_field_scale: float
    lasting_rate_scale: float
    lasting_sun: float
    lasting_attitude: float
    gate: float
    bank: bool
    valid_sigma: float
    orbit_time: float
    j2: bool
    gravitational_parameter: float
    epoch: str
    field_model: str
    field_degree: int
    field_error: Array
    wheels: int = 1
    """How many of a set are there."""

    @cached_property
    def days(self) -> float:
        """The epoch as days from 2000-01-01T12:00."""
        return onboard.days_since_j2000(onboard.parse_epoch(self.epoch))

    @cached_property
    def field(self) -> OnboardField:
        """The onboard field at the epoch."""
        model, sidereal = tables.gauss_model(self.field_model), onboard.sidereal_angle(self.days)
        return OnboardField(model, onboard.year_of(self.days), self.field_degree, self.field_error, sidereal)

    @cached_property
    def J_inverse(self) -> Array:
        """(3,3)"""
        inverse: Array = np.linalg.inv(self.J_B).astype(np.float64)
        return inverse

    @cached_property
    def wheel_axes(self) -> Array:
        """Rows (wheels,3): unit axes of the wheels that are there."""
        axes = np.atleast_2d(self.wheel_axis)[: self.wheels]
        return np.array([axis / norm(axis) for axis in axes]).reshape(-1, 3)

    def of_wheels(self, each: Array | float) -> Array:
        """Returns what each wheel has along its axis, in body axes and all together (3,)."""
        whole = np.zeros(3)
        for value, axis in zip(np.atleast_1d(each), self.wheel_axes, strict=False):
            whole = whole + value * axis
        return whole

    @cached_property
    def tracker_axes(self) -> Array:
        """Rows (3,3): two axes across the star tracker's boresight, and that."""
        z = self.boresight_B / norm(self.boresight_B)
        across = np.eye(3)[int(np.argmin(np.abs(z)))]
        x = np.cross(across, z)
        x = x / norm(x)
        return np.array((x, np.cross(z, x), z))


_POSITIVE = (
    "field_noise sun_noise sun_sensor_noise attitude_noise attitude_noise_boresight gate gravitational_parameter"
).split()
_NOT_NEGATIVE = (
    "angle_random_walk rate_random_walk rate_bias_sigma rate_scale_sigma momentum_random_walk field_bias_sigma "
    "field_random_walk rod_field_error dipole_limit valid_sigma orbit_time albedo "
    "lasting_field lasting_field_scale lasting_rate_scale lasting_sun lasting_attitude"
).split()


def check(p: Parameters) -> None:
    """Raises ValueError with name, value and what is expected."""
    for names, low, expected in ((_POSITIVE, math.ulp(0.0), "above 0"), (_NOT_NEGATIVE, 0.0, "of at least 0")):
        for name in names:
            if not low <= (value := getattr(p, name)) < math.inf:
                raise ValueError(f"{name}: expected a finite number {expected}, found {value}")
    for name in ("rod_field", "field_error"):
        if not np.isfinite(value := getattr(p, name)).all():
            raise ValueError(f"{name}: expected finite numbers, found {value.tolist()}")
    if p.rate_source not in RATE_SOURCES:
        raise ValueError(f"rate_source: expected one of {', '.join(RATE_SOURCES)}, found {p.rate_source!r}")
    if p.bank and p.rate_source != "gyro":
        raise ValueError("bank: expected rate_source 'gyro', found 'dynamics'; the bank follows the measured rate")
    if p.field_model not in tables.NAMES:
        raise ValueError(f"field_model: expected one of {', '.join(tables.NAMES)}, found {p.field_model!r}")
    if not 1 <= p.field_degree <= tables.DEGREE:
        raise ValueError(f"field_degree: expected 1 to {tables.DEGREE}, found {p.field_degree}")
    if not 0 <= p.wheels <= (most := len(np.atleast_2d(p.wheel_axis))):
        raise ValueError(f"wheels: expected 0 to {most}, found {p.wheels}")
    for name, axes in (
        ("rod_axes", p.rod_axes),
        ("wheel_axis", np.atleast_2d(p.wheel_axis)[: p.wheels]),
        ("boresight_B", p.boresight_B[None]),
        ("sun_sensor_axes", p.sun_sensor_axes[p.sun_sensor_axes.any(axis=1)]),
    ):
        for axis in axes:
            if not abs(norm(axis) - 1.0) <= UNIT_TOLERANCE:
                raise ValueError(f"{name}: expected unit length, to {UNIT_TOLERANCE:g}, found {norm(axis)}")
    _check_inertia(p.J_B)
    model, year = tables.gauss_model(p.field_model), onboard.year_of(p.days)
    if not model.years[0] <= year <= model.valid_until:
        covered = f"{model.years[0]:.1f} to {model.valid_until:.1f}"
        raise ValueError(f"epoch: expected a date that {p.field_model} covers, {covered}, found {year:.3f}")


def _check_inertia(J: Array) -> None:
    if not np.isfinite(J).all():
        raise ValueError(f"J_B: expected finite numbers, found {J.tolist()}")
    if np.abs(J - J.T).max() > 1e-9 * np.abs(J).max():
        raise ValueError(f"J_B: expected a symmetric matrix, found {J.tolist()}")
    moments = np.linalg.eigvalsh(J)
    if not (moments[0] > 0.0 and 2.0 * moments[2] <= moments.sum() + 1e-9 * moments[2]):
        raise ValueError(
            f"J_B: expected the inertia of a body, each principal moment above 0 and at most the sum of the other two, "
            f"found moments {moments.tolist()}"
        )
