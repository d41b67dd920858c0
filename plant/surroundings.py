"""The moments on the satellite that no command changes: functions of its attitude and of time alone, in body axes.
Tests: tests/plant/test_gravity_gradient.py."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from . import gravity_gradient, sun
from .atmosphere import AirAlongOrbit
from .drag import Drag
from .geomagnetic import FieldAlongOrbit
from .orbit import Orbit
from .so3 import Array
from .solar_pressure import SolarPressure, at_distance
from .sun import Sun


class Surroundings(NamedTuple):
    """At an attitude and a time."""

    r_N: Array
    v_N: Array
    """m, m/s"""
    r_hat_B: Array
    """The unit position."""
    rate_squared: float
    """mu/r^3, 1/s2"""
    b_B: Array
    """T"""
    tau_gg_B: Array
    tau_drag_B: Array
    """N m"""
    density: float
    """kg/m3; 0 without drag"""
    tau_solar_B: Array | None
    """N m; None without solar pressure."""


@dataclass
class Environment:
    """The surroundings of a satellite of inertia J (3,3), kg m2, on its orbit."""

    J: Array
    mu: float
    """m3/s2"""
    orbit: Orbit
    field: FieldAlongOrbit
    gravity_gradient: bool
    air: AirAlongOrbit | None
    """None without drag."""
    surface: Drag
    sun: Sun
    light: SolarPressure | None
    """None without solar pressure."""
    _last: tuple[Array, float, Surroundings] | None = None

    def at(self, R: Array, t: float) -> Surroundings:
        """At attitude R (3,3) and time t, s. The last are kept: a step's end, its outputs and the next
        start are one place."""
        if self._last is None or self._last[0] is not R or self._last[1] != t:
            self._last = R, t, self._evaluate(R.T, t)
        return self._last[2]

    def _evaluate(self, R_T: Array, t: float) -> Surroundings:
        r_N, v_N = self.orbit.position_velocity(t)
        r2 = float(r_N.dot(r_N))
        r = math.sqrt(r2)
        r_hat_B, rate_squared = R_T.dot(r_N) / r, self.mu / (r2 * r)
        tau_gg_B = tau_drag_B = np.zeros(3)
        density = 0.0
        if self.gravity_gradient:
            tau_gg_B = gravity_gradient.moment(r_hat_B, self.J, rate_squared)
        if self.air is not None:
            flow_N, density = self.air.flow(t)
            tau_drag_B = self.surface.moment(R_T.dot(flow_N), density)
        b_B = R_T.dot(self.field.at(t))
        tau_solar_B = None if self.light is None else self._solar(self.light, R_T, r_N, t)
        return Surroundings(r_N, v_N, r_hat_B, rate_squared, b_B, tau_gg_B, tau_drag_B, density, tau_solar_B)

    def _solar(self, light: SolarPressure, R_T: Array, r_N: Array, t: float) -> Array:
        place = self.sun.at(t)
        sun_N, sunlight = sun.seen_from(r_N, place)
        return light.moment(R_T.dot(sun_N), sunlight * at_distance(math.dist(place, r_N)))
