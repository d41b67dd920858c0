"""The orbit against two-body and J2 motion integrated by SciPy, and sidereal time against published examples."""

from __future__ import annotations

import math
from datetime import UTC, datetime
from functools import cache

import numpy as np
from scipy.integrate import solve_ivp

from plant import orbit, time_scales
from tests.authorities.registry import authority
from tests.plant.motion import checked

MU, RE = 3.986004418e14, 6378137.0
J2 = math.sqrt(5.0) * 484.166774985e-6
"""WGS 84's C20 (NIMA TR8350.2, table 5.1), unnormalised."""


def acceleration(t, y, j2):
    r = y[:3]
    d2 = float(r @ r)
    a = -MU / d2**1.5 * r
    if j2:
        z2 = r[2] ** 2 / d2
        a = a - 1.5 * j2 * MU * RE**2 / d2**2.5 * r * (np.array([1.0, 1.0, 3.0]) - 5.0 * z2)
    return np.concatenate([y[3:], a])


def integrated(r, v, t, j2=0.0) -> np.ndarray:
    s = solve_ivp(acceleration, (0.0, t), np.concatenate([r, v]), method="DOP853", rtol=1e-13, atol=1e-7, args=(j2,))
    return s.y[:, -1]


ORBITS = {
    "near circular": ([6971e3, 0.0, 0.0], [0.0, -1052.389, 7488.1109]),
    "eccentric": ([4.1e6, -5.2e6, 3.3e6], [5.3e3, 5.1e3, 4.6e3]),
    "equatorial": ([-7.2e6, 1.1e6, 0.0], [-0.9e3, -7.9e3, 0.0]),
    "retrograde, inbound": ([1.2e7, 3e6, 6e6], [-3.0e3, -3.8e3, 2.4e3]),
}


@authority(
    "Orbit",
    "Position after 20,000 s from four pairs of r and v, eccentricity to 0.4: largest difference",
    source="two-body equations by SciPy's DOP853",
    unit="m",
    tolerance=0.05,
)
@cache
def two_body() -> float:
    worst = 0.0
    for r, v in ORBITS.values():
        path = orbit.from_position_velocity(np.array(r), np.array(v), MU)
        for t in (3000.0, 20000.0):
            worst = max(worst, float(np.abs(path.position_velocity(t)[0] - integrated(r, v, t)[:3]).max()))
    return worst


def node_drift(inclination_deg: float, radius: float = RE + 600e3) -> float:
    """deg/day, of the plant's orbit with j2_node_drift, from where it crosses the equator 150 revolutions apart."""
    p = checked(orbit_radius=radius, inclination=math.radians(inclination_deg), node_longitude=0.5, j2_node_drift=True)
    later = 150.0 * 2.0 * math.pi * math.sqrt(radius**3 / MU)
    (x0, y0, _), (x1, y1, z1) = p.orbit.position_velocity(0.0)[0], p.orbit.position_velocity(later)[0]
    assert abs(z1) < 0.1
    turned = math.remainder(math.atan2(y1, x1) - math.atan2(y0, x0), 2.0 * math.pi)
    return math.degrees(turned) / later * 86400.0


@authority(
    "Orbit",
    "Drift of the node by J2 at 600 km and 98 deg",
    source="Vallado, 4th ed., 9.6",
    unit="deg/day",
    expected=1.012,
    tolerance=5e-4,
)
def node_drift_98() -> float:
    return node_drift(98.0)


@authority(
    "Orbit",
    "The same at 97.79 deg: sun-synchronous",
    source="360 deg in a tropical year of 365.2422 days",
    unit="deg/day",
    expected=360.0 / 365.2422,
    tolerance=1e-3,
)
def sun_synchronous() -> float:
    return node_drift(97.79)


@authority(
    "Orbit",
    "The same at 98 deg over the drift under J2's acceleration itself, over 30 orbits",
    source="J2's acceleration by SciPy's DOP853",
    unit="",
    expected=1.0,
    tolerance=5e-3,
)
@cache
def node_drift_integrated() -> float:
    radius, i = RE + 600e3, math.radians(98.0)
    speed = math.sqrt(MU / radius)
    period = 2.0 * math.pi * math.sqrt(radius**3 / MU)
    t = np.linspace(0.0, 30.0 * period, 3001)
    start = [radius, 0.0, 0.0, 0.0, speed * math.cos(i), speed * math.sin(i)]
    s = solve_ivp(acceleration, (0.0, t[-1]), start, method="DOP853", rtol=1e-11, atol=1e-4, t_eval=t, args=(J2,))
    h = np.cross(s.y[:3].T, s.y[3:].T)
    rate = np.polyfit(t, np.unwrap(np.arctan2(h[:, 0], -h[:, 1])), 1)[0]
    return node_drift(98.0) / (math.degrees(float(rate)) * 86400.0)


SIDEREAL = {
    "Vallado, 4th ed., example 3-5": (datetime(1992, 8, 20, 12, 14, tzinfo=UTC), 152.578787886),
    "Astronomical Almanac, GMST at J2000.0": (datetime(2000, 1, 1, 12, tzinfo=UTC), 280.46061837),
    "Meeus, Astronomical Algorithms, example 12.a": (
        datetime(1987, 4, 10, tzinfo=UTC),
        15.0 * (13 + 10 / 60 + 46.3668 / 3600),
    ),
    "Meeus, Astronomical Algorithms, example 12.b": (
        datetime(1987, 4, 10, 19, 21, tzinfo=UTC),
        15.0 * (8 + 34 / 60 + 57.0896 / 3600),
    ),
}


@authority(
    "Orbit",
    "Greenwich mean sidereal time at four published dates: largest difference",
    source="; ".join(SIDEREAL),
    unit="deg",
    tolerance=1e-6,
)
def sidereal_time() -> float:
    return max(abs(math.degrees(time_scales.gmst(date)) - degrees) for date, degrees in SIDEREAL.values())
