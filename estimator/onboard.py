"""The estimator's own models of date, Sun, Earth's shadow and orbit; they may differ from the plant's.
Tests: tests/estimator/test_estimator.py."""

from __future__ import annotations

import math
import re
from datetime import UTC, datetime, timedelta

import numpy as np

from .so3 import Array, norm

EARTH_RATE = 7.292115855e-5
"""rad/s, of Greenwich relative to N."""
EARTH_RADIUS = 6378137.0
"""Equatorial, m."""
J2 = 1.082629821313e-3
SUN_RADIUS = 4.65e-3
"""Half the angle that the Sun takes up, rad."""
ORBIT_STEP = 10.0
"""Longest step of the orbit's integration, s."""

_J2000 = datetime(2000, 1, 1, 12, tzinfo=UTC)
_EPOCH = re.compile(r"\d{4}-\d\d-\d\d([T ]([01]\d|2[0-3]):\d\d(:\d\d([.,]\d+)?)?(Z|[+-]\d\d:\d\d)?)?", re.ASCII)


def parse_epoch(text: str) -> datetime:
    """A UTC date and time from the extended form of ISO 8601. Raises ValueError.

    2009-08-10, or 2009-08-10T12:00[:00[.5]] and Z, +00:00, -00:00 or nothing. A space may stand for the T and a comma
    for the point; digits beyond microseconds are dropped. Years 1 to 9999; no leap second.
    """
    try:
        if _EPOCH.fullmatch(text) is None:
            raise ValueError
        epoch = datetime.fromisoformat(text)
        if epoch.utcoffset() not in (None, timedelta(0)):
            raise ValueError
    except ValueError:
        raise ValueError(f"epoch: expected UTC in ISO 8601, such as 2009-08-10T12:00:00Z, found {text!r}") from None
    return epoch.replace(tzinfo=UTC)


def days_since_j2000(epoch: datetime) -> float:
    """Days of 86400 s from 2000-01-01 12:00 to `epoch`."""
    return (epoch - _J2000) / timedelta(days=1)


def year_of(days: float) -> float:
    """The decimal year of days from 2000-01-01T12:00."""
    return 2000.0 + (days + 0.5) / 365.25


def sidereal_angle(days: float) -> float:
    """Greenwich mean sidereal time, rad in [0, 2 pi): IAU 1982."""
    T = days / 36525.0
    seconds = 67310.54841 + (876600.0 * 3600.0 + 8640184.812866) * T + (0.093104 - 6.2e-6 * T) * T * T
    return math.modf(seconds / 86400.0)[0] * 2.0 * math.pi


def sun_direction(days: float) -> Array:
    """Unit vector (3,) from the Earth to the Sun in N: the low-precision formula of the Astronomical Almanac, 0.01
    deg."""
    mean_longitude = math.radians(280.460) + math.radians(0.9856474) * days
    anomaly = math.radians(357.528) + math.radians(0.9856003) * days
    longitude = mean_longitude + math.radians(1.915) * math.sin(anomaly) + math.radians(0.020) * math.sin(2.0 * anomaly)
    obliquity = math.radians(23.439) - math.radians(4e-7) * days
    s = math.sin(longitude)
    return np.array((math.cos(longitude), math.cos(obliquity) * s, math.sin(obliquity) * s))


def sunlight(r_N: Array, sun_N: Array) -> float:
    """Part of the Sun that a spherical Earth leaves uncovered at r_N (3,), m: 0 to 1, linear over the penumbra."""
    r = norm(r_N)
    if r <= EARTH_RADIUS:
        return 0.0
    from_nadir = math.acos(min(max(-float(r_N @ sun_N) / r, -1.0), 1.0))
    return min(max(0.5 + (from_nadir - math.asin(EARTH_RADIUS / r)) / (2.0 * SUN_RADIUS), 0.0), 1.0)


def orbit_after(r_N: Array, v_N: Array, h: float, mu: float, oblate: bool) -> tuple[Array, Array]:
    """Position and velocity (3,), m and m/s, after h s: two bodies, with J2 where the Earth is oblate;
    Runge and Kutta, order 4."""
    steps = max(1, math.ceil(h / ORBIT_STEP))
    dt = h / steps
    for _ in range(steps):
        v1, a1 = v_N, gravity(r_N, mu, oblate)
        v2, a2 = v_N + 0.5 * dt * a1, gravity(r_N + 0.5 * dt * v1, mu, oblate)
        v3, a3 = v_N + 0.5 * dt * a2, gravity(r_N + 0.5 * dt * v2, mu, oblate)
        v4, a4 = v_N + dt * a3, gravity(r_N + dt * v3, mu, oblate)
        r_N = r_N + dt / 6.0 * (v1 + 2.0 * (v2 + v3) + v4)
        v_N = v_N + dt / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
    return r_N, v_N


def gravity(r_N: Array, mu: float, oblate: bool) -> Array:
    """Acceleration (3,), m/s2, at r_N (3,), m, with the Earth's axis along Z (Montenbruck and Gill,
    Satellite Orbits, 3.2)."""
    r2 = float(r_N @ r_N)
    a = -mu / (r2 * math.sqrt(r2)) * r_N
    if oblate:
        z2 = 5.0 * r_N[2] * r_N[2] / r2
        a = a * (1.0 + 1.5 * J2 * (EARTH_RADIUS * EARTH_RADIUS / r2) * np.array((1.0 - z2, 1.0 - z2, 3.0 - z2)))
    return a
