"""Parameters of the sensors, their check, and what follows from them alone.
Tests: tests/plant/sensors/test_sensors.py."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .noise import Array

PERIOD_MIN = 1e-6
"""s."""
UNIT_TOLERANCE = 1e-6

_NOT_NEGATIVE = (
    "attitude_noise attitude_noise_about attitude_rate_max attitude_outage_interval rate_noise angle_random_walk "
    "rate_random_walk rate_instability rate_range rate_quantum field_noise field_range field_quantum sun_sensor_noise "
    "fine_sun_noise position_noise velocity_noise orbit_outage_interval wheel_momentum_noise dipole_noise"
).split()
_TIMES = "attitude_outage_duration rate_instability_time orbit_outage_duration".split()
_FINITE = (
    "attitude_bias_B attitude_boresight_B rate_bias_B rate_scale field_bias_B field_scale field_rod_coupling "
    "sun_sensor_axes fine_sun_axis_B wheel_momentum_bias"
).split()
_BETWEEN = {
    "attitude_sun_exclusion": (0.0, math.pi),
    "attitude_earth_exclusion": (0.0, math.pi),
    "sun_sensor_half_angle": (0.0, 0.5 * math.pi),
    "albedo": (0.0, 1.0),
    "sun_threshold": (1e-3, 1.0),
    "fine_sun_half_angle": (0.0, math.pi),
}
_PERIODS = "attitude_period rate_period field_period orbit_period sun_period telemetry_period".split()
"""In the order of the clocks."""


@dataclass(frozen=True)
class Parameters:
    """Units, frames and limits are those of fmus/interfaces/plant_sensors.toml."""

    attitude_noise: float
    attitude_noise_about: float
    attitude_bias_B: Array
    attitude_boresight_B: Array
    attitude_rate_max: float
    attitude_sun_exclusion: float
    attitude_earth_exclusion: float
    attitude_outage_interval: float
    attitude_outage_duration: float
    attitude_period: float
    rate_noise: float
    rate_bias_B: Array
    angle_random_walk: float
    rate_random_walk: float
    rate_instability: float
    rate_instability_time: float
    rate_scale: Array
    rate_range: float
    rate_quantum: float
    rate_period: float
    field_noise: float
    field_bias_B: Array
    field_scale: Array
    field_rod_coupling: Array
    field_range: float
    field_quantum: float
    field_period: float
    sun_sensor: str
    sun_sensor_axes: Array
    sun_sensor_half_angle: float
    sun_sensor_noise: float
    albedo: float
    sun_threshold: float
    fine_sun_axis_B: Array
    fine_sun_half_angle: float
    fine_sun_noise: float
    sun_period: float
    position_noise: float
    velocity_noise: float
    orbit_outage_interval: float
    orbit_outage_duration: float
    orbit_period: float
    wheel_momentum_noise: float
    dipole_noise: float
    telemetry_period: float
    sensor_period: float
    seed: int
    wheel_momentum_bias: Array | float = 0.0
    """(4,) of a set of wheels; one wheel has none."""

    @cached_property
    def periods(self) -> list[float]:
        """Period of each clock, s; 0: a measurement at every step."""
        return [getattr(self, name) or self.sensor_period for name in _PERIODS]

    @cached_property
    def period_names(self) -> list[str]:
        """Name of the parameter that gives each clock's period."""
        return [name if getattr(self, name) else "sensor_period" for name in _PERIODS]

    @cached_property
    def boresight(self) -> Array:
        return unit(self.attitude_boresight_B)

    @cached_property
    def fine_sun_axis(self) -> Array:
        return unit(self.fine_sun_axis_B)

    @cached_property
    def sun_axes(self) -> Array:
        """(6,3), rows: unit vectors, or zeros where there is no sensor."""
        return np.array([unit(row) if row.any() else row for row in self.sun_sensor_axes])

    @cached_property
    def has_sun_axes(self) -> Array:
        """(6,) 1 where there is a coarse sun sensor, else 0."""
        return self.sun_sensor_axes.any(axis=1).astype(float)

    @cached_property
    def turns_attitude(self) -> bool:
        """Returns whether the measured attitude differs from the true one."""
        return bool(self.attitude_noise > 0.0 or self.attitude_noise_about > 0.0 or self.attitude_bias_B.any())

    @cached_property
    def has_drift(self) -> bool:
        return self.rate_random_walk > 0.0 or self.rate_instability > 0.0

    @cached_property
    def has_rate_scale(self) -> bool:
        return bool(self.rate_scale.any())

    @cached_property
    def has_field_scale(self) -> bool:
        return bool(self.field_scale.any())

    @cached_property
    def has_rod_coupling(self) -> bool:
        return bool(self.field_rod_coupling.any())


def unit(x: Array) -> Array:
    """x/|x|"""
    return x / math.sqrt(x @ x)


def check(p: Parameters) -> None:
    """Raises ValueError with name, value and what is expected."""
    for name in _FINITE:
        if not np.isfinite(value := getattr(p, name)).all():
            raise ValueError(f"{name}: expected finite numbers, found {np.asarray(value).tolist()}")
    for name in _NOT_NEGATIVE:
        if not 0.0 <= (value := getattr(p, name)) < math.inf:
            raise ValueError(f"{name}: expected a finite number, at least 0, found {value}")
    for name in _TIMES:
        if not 0.0 < (value := getattr(p, name)) < math.inf:
            raise ValueError(f"{name}: expected a finite number above 0, found {value} s")
    for name, (low, high) in _BETWEEN.items():
        if not low <= (value := getattr(p, name)) <= high:
            raise ValueError(f"{name}: expected {low:g} to {high:.7g}, found {value}")
    for name in ("sensor_period", *_PERIODS):
        if not ((value := getattr(p, name)) == 0.0 or PERIOD_MIN <= value < math.inf):
            of_zero = "every step" if name == "sensor_period" else "sensor_period"
            raise ValueError(f"{name}: expected 0 ({of_zero}) or at least {PERIOD_MIN:g} s, found {value} s")
    for name in ("attitude_boresight_B", "fine_sun_axis_B"):
        if abs((length := float(np.linalg.norm(getattr(p, name)))) - 1.0) > UNIT_TOLERANCE:
            raise ValueError(f"{name}: expected a unit vector, to 1e-06, found the length {length}")
    for length in np.linalg.norm(p.sun_sensor_axes, axis=1).tolist():
        if length != 0.0 and abs(length - 1.0) > UNIT_TOLERANCE:
            raise ValueError(
                f"sun_sensor_axes: expected rows of unit length, to 1e-06, or zeros, found a row of length {length}"
            )
    if p.sun_sensor not in ("coarse", "fine"):
        raise ValueError(f"sun_sensor: expected coarse or fine, found {p.sun_sensor!r}")
    if not 0 <= p.seed < 2**31:
        raise ValueError(f"seed: expected 0 to {2**31 - 1}, found {p.seed}")
