"""The Sun: its apparent position, and how much of it the Earth leaves visible.

Mean elements of the Earth's orbit with the largest perturbations: Meeus, Astronomical Formulae for Calculators (1979),
ch. 18, on the elements of his Astronomical Algorithms (1998), ch. 25. Nutation: its two largest terms, ch. 22.
"""

from __future__ import annotations

import math

import numpy as np

from .orbit import WGS84_FLATTENING, WGS84_RADIUS
from .so3 import Array

AU = 149597870700.0
SUN_RADIUS = 695.7e6
"""m (IAU 2012 resolution B2, IAU 2015 resolution B3)"""
TT_UTC = 69.184
"""s, from 2017 on; over a century the difference is below 70 s, in which the Sun moves by 0.0008 deg."""
NODE_INTERVAL = 600.0
"""s between two evaluations; on the straight line between them the direction errs by less than 2e-9 rad."""
DISC_MAX = 0.005
"""Above the sine of the Sun's angular radius, with a margin for the scaling of an ellipsoid to a sphere."""

PERTURBATIONS = (
    (0.00134, 351.984, 22518.7541),
    (0.00154, 254.078, 45037.5082),
    (0.00200, 157.048, 32964.3577),
    (0.00179, 207.854, 445267.1142),
    (0.00178, 161.390, 20.2),
)
"""Of the longitude: amplitude, deg, phase, deg, and its rate, deg a century, of cosines: Venus twice, Jupiter, the Moon
and a long period."""


def position(T: float) -> tuple[float, float, float]:
    """Position of the Sun from the Earth's centre in N, m; T: Julian centuries of terrestrial time from J2000.

    Its direction is the apparent one, with the Earth's aberration. N has the true pole of date and the mean equinox,
    since GMST turns the Earth in it. Off by less than 0.005 deg from 1950 to 2050.
    """
    L = math.radians(280.46646 + T * (36000.76983 + 0.0003032 * T))  # mean longitude
    M = math.radians(357.52911 + T * (35999.05029 - 0.0001537 * T))  # mean anomaly
    e = 0.016708634 - T * (0.000042037 + 0.0000001267 * T)
    center = (
        (1.914602 - T * (0.004817 + 0.000014 * T)) * math.sin(M)
        + (0.019993 - 0.000101 * T) * math.sin(2.0 * M)
        + 0.000289 * math.sin(3.0 * M)
    )
    for amplitude, phase, rate in PERTURBATIONS:
        center += amplitude * math.cos(math.radians(phase + rate * T))
    center = math.radians(center)
    distance = 1.000001018 * (1.0 - e * e) / (1.0 + e * math.cos(M + center))  # au
    aberration = math.radians(-20.4898 / 3600.0) / distance
    node = math.radians(125.04452 - 1934.136261 * T)  # of the Moon's orbit
    nutation = math.radians((-17.20 * math.sin(node) - 1.32 * math.sin(2.0 * L)) / 3600.0)
    tilt = math.radians(
        23.43929111 - 0.013004167 * T + (9.20 * math.cos(node) + 0.57 * math.cos(2.0 * L)) / 3600.0
    )  # obliquity
    longitude = L + center + aberration + nutation
    x, y, z = math.cos(longitude), math.sin(longitude) * math.cos(tilt), math.sin(longitude) * math.sin(tilt)
    back = nutation * math.cos(tilt)  # the equation of the equinoxes: from the true equinox to the mean one
    c, s = math.cos(back), math.sin(back)
    r = AU * distance
    return r * (c * x + s * y), r * (c * y - s * x), r * z


class Sun:
    """The Sun over the time t, s, of a simulation that starts `days` after J2000, UTC."""

    def __init__(self, days: float) -> None:
        self._days = days
        self._number: int | None = None
        self._start = self._change = (0.0, 0.0, 0.0)

    def at(self, t: float) -> tuple[float, float, float]:
        """Position from the Earth's centre in N, m. The nodes follow from the epoch alone, so keeping two is no
        memory."""
        s = t / NODE_INTERVAL
        k = math.floor(s)
        if k != self._number:
            (x0, y0, z0), (x1, y1, z1) = self._exact(k), self._exact(k + 1)
            self._number, self._start, self._change = k, (x0, y0, z0), (x1 - x0, y1 - y0, z1 - z0)
        u, (x, y, z), (dx, dy, dz) = s - k, self._start, self._change
        return x + u * dx, y + u * dy, z + u * dz

    def _exact(self, number: int) -> tuple[float, float, float]:
        return position((self._days + (number * NODE_INTERVAL + TT_UTC) / 86400.0) / 36525.0)


def seen_from(r_N: Array, sun: tuple[float, float, float]) -> tuple[Array, float]:
    """sun_N (3,), the unit vector to the Sun from r_N (3,), m, and sunlight, 0 to 1.

    sunlight is the part of the Sun's disc that an Earth without air leaves visible: 1 - A/(pi a^2), A the overlap of
    two discs (Montenbruck and Gill, Satellite Orbits, 3.4.2). A ray misses the ellipsoid of WGS 84 where it misses,
    with Z stretched by 1/(1 - f), the sphere of its equator.
    """
    x, y, z = r_N.tolist()
    dx, dy, dz = sun[0] - x, sun[1] - y, sun[2] - z
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    sun_N = np.array((dx / distance, dy / distance, dz / distance))
    along = x * dx + y * dy + z * dz / (1.0 - WGS84_FLATTENING) ** 2
    if along >= 0.0:
        return sun_N, 1.0  # the Earth is behind
    z, dz = z / (1.0 - WGS84_FLATTENING), dz / (1.0 - WGS84_FLATTENING)
    r2, d2 = x * x + y * y + z * z, dx * dx + dy * dy + dz * dz
    r = math.sqrt(r2)
    across2 = r2 - along * along / d2
    margin = DISC_MAX * r
    if across2 >= (WGS84_RADIUS + margin) ** 2:
        return sun_N, 1.0
    if margin < WGS84_RADIUS and across2 <= (WGS84_RADIUS - margin) ** 2:
        return sun_N, 0.0
    d = math.sqrt(d2)
    a, b = math.asin(SUN_RADIUS / d), math.asin(min(WGS84_RADIUS / r, 1.0))
    return sun_N, disc_left(a, b, math.atan2(math.sqrt(max(across2, 0.0)), -along / d))


def disc_left(a: float, b: float, c: float) -> float:
    """The part of a disc of radius a that one of radius b leaves uncovered, their centres c apart."""
    if c >= a + b:
        return 1.0
    if c <= abs(b - a):
        return 0.0 if b >= a else 1.0 - (b / a) ** 2
    x = 0.5 * (c * c + a * a - b * b) / c
    y = math.sqrt(max(a * a - x * x, 0.0))
    overlap = a * a * math.atan2(y, x) + b * b * math.atan2(y, c - x) - c * y
    return min(max(1.0 - overlap / (math.pi * a * a), 0.0), 1.0)
