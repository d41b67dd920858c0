"""The orbit: Keplerian, circular as in the paper or from a given r and v, the node drifting with J2 on request.

N is true of date: its Z axis is the Earth's, and the Earth is turned in it by GMST.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .so3 import Array
from .time_scales import EARTH_RATE

WGS84_RADIUS = 6378137.0
"""Equatorial radius, m."""
WGS84_FLATTENING = 1.0 / 298.257223563
WGS84_J2 = 1.082629821313e-3
"""Second zonal harmonic of the WGS 84 ellipsoid (its C20 is -484.166774985e-6, fully normalised)."""

DRIFT_PASSES = 6
"""Each leaves about a thousandth of the last one's error."""


@dataclass(frozen=True)
class Orbit:
    """An elliptic orbit. At t = 0 its plane is spanned by `towards_perigee` and `along_perigee`, (3,)
    unit vectors in N."""

    semi_major_axis: float
    """m"""
    eccentricity: float
    mean_motion: float
    """rad/s"""
    mean_anomaly: float
    """at t = 0, rad; counted from `towards_perigee`"""
    towards_perigee: Array
    along_perigee: Array
    node_rate: float = 0.0
    """Rate at which the plane turns about N's Z axis, rad/s."""

    @cached_property
    def _plane(self) -> Array:
        """The two unit vectors as rows."""
        return np.array((self.towards_perigee, self.along_perigee))

    @property
    def inclination(self) -> float:
        """rad"""
        return math.acos(min(max(float(np.cross(self.towards_perigee, self.along_perigee)[2]), -1.0), 1.0))

    def with_node_rate(self, rate: float) -> Orbit:
        """The same orbit with its plane turning about N's Z axis, rad/s."""
        return replace(self, node_rate=rate)

    def position_velocity(self, t: float) -> tuple[Array, Array]:
        """r_N (3,) m and v_N (3,) m/s at time t, s; v_N is the derivative of r_N, the node's drift included."""
        a, e = self.semi_major_axis, self.eccentricity
        M = self.mean_anomaly + self.mean_motion * t
        E = _eccentric_anomaly(M, e) if e else M
        c, s = math.cos(E), math.sin(E)
        minor = math.sqrt(1.0 - e * e)
        E_rate = self.mean_motion / (1.0 - e * c)
        in_plane = np.array(((a * (c - e), a * minor * s), (-a * E_rate * s, a * minor * E_rate * c)))
        r, v = in_plane.dot(self._plane)
        if self.node_rate == 0.0:
            return r, v
        turn = rotation_about_z(self.node_rate * t)
        r, v = turn @ r, turn @ v
        return r, v + self.node_rate * np.array((-r[1], r[0], 0.0))


def circular(radius: float, inclination: float, raan: float, argument_of_latitude: float, mu: float) -> Orbit:
    """A circular orbit of this radius, m; angles in rad, mu in m3/s2."""
    ci, si = math.cos(inclination), math.sin(inclination)
    cn, sn = math.cos(raan), math.sin(raan)
    return Orbit(
        semi_major_axis=radius,
        eccentricity=0.0,
        mean_motion=math.sqrt(mu / radius**3),
        mean_anomaly=argument_of_latitude,
        towards_perigee=np.array((cn, sn, 0.0)),
        along_perigee=np.array((-sn * ci, cn * ci, si)),
    )


def from_position_velocity(r: Array, v: Array, mu: float) -> Orbit:
    """The elliptic orbit through r (3,) m with v (3,) m/s. Raises ValueError where they give none."""
    radius = math.sqrt(r @ r)
    h = np.cross(r, v)
    momentum = math.sqrt(h @ h)
    if radius == 0.0 or momentum <= 1e-6 * radius * math.sqrt(v @ v):
        raise ValueError(f"r_N0, v_N0: expected an orbit, found {r.tolist()} m and {v.tolist()} m/s, parallel or zero")
    energy = 0.5 * float(v @ v) - mu / radius
    if energy >= 0.0:
        raise ValueError(
            f"v_N0: expected below escape speed at r_N0, {math.sqrt(2 * mu / radius):.1f} m/s, found {v.tolist()} m/s"
        )
    a = -mu / (2.0 * energy)
    perigee = np.cross(v, h) / mu - r / radius
    e = math.sqrt(perigee @ perigee)
    e = e if e > 1e-12 else 0.0
    p_hat = perigee / e if e else r / radius
    q_hat = np.cross(h / momentum, p_hat)
    x, y = float(r @ p_hat), float(r @ q_hat)
    E = math.atan2(y / math.sqrt(1.0 - e * e), x + a * e)
    return Orbit(a, e, math.sqrt(mu / a**3), E - e * math.sin(E), p_hat, q_hat)


def j2_node_rate(semi_major_axis: float, eccentricity: float, inclination: float, mu: float) -> float:
    """Secular drift of the ascending node, rad/s: -3/2 n J2 (R_E/p)^2 cos i (Vallado, 4th ed., 9-37)."""
    p = semi_major_axis * (1.0 - eccentricity**2)
    n = math.sqrt(mu / semi_major_axis**3)
    return -1.5 * n * WGS84_J2 * (WGS84_RADIUS / p) ** 2 * math.cos(inclination)


def with_j2(path: Orbit, mu: float) -> Orbit:
    """The same orbit with its node drifting under J2."""
    return path.with_node_rate(j2_node_rate(path.semi_major_axis, path.eccentricity, path.inclination, mu))


def drifting(r: Array, v: Array, mu: float) -> Orbit:
    """The orbit through r (3,) m with v (3,) m/s whose node drifts with J2. Raises ValueError where they give none.

    v contains the plane's own turning, whose rate follows from the orbit in the plane: a fixed point.
    """
    path = with_j2(from_position_velocity(r, v, mu), mu)
    x, y, _ = r.tolist()
    for _ in range(DRIFT_PASSES):
        rate = path.node_rate
        path = with_j2(from_position_velocity(r, v - rate * np.array((-y, x, 0.0)), mu), mu)
    return path.with_node_rate(rate)


def lvlh(r: Array, v: Array) -> Array:
    """R_LVLH (3,3), columns in N: X along the velocity's horizontal part, Y = -h_hat, Z to nadir."""
    h = np.cross(r, v)
    z = -r / math.sqrt(r @ r)
    y = -h / math.sqrt(h @ h)
    return np.column_stack((np.cross(y, z), y, z))


def earth_fixed(t: float, gmst0: float) -> Array:
    """The rotation (3,3) from Earth-fixed axes to N at time t, s, GMST being gmst0, rad, at t = 0."""
    return rotation_about_z(gmst0 + EARTH_RATE * t)


def rotation_about_z(angle: float) -> Array:
    """The rotation (3,3) by an angle, rad, about Z."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def geodetic(r_earth: Array) -> tuple[float, float, float]:
    """Geodetic latitude, rad, longitude, rad, and height, m, on WGS 84 of an Earth-fixed position (3,), m.

    Bowring's formula, iterated: below 1e-12 rad for heights to 50,000 km.
    """
    x, y, z = r_earth.tolist()
    e2 = WGS84_FLATTENING * (2.0 - WGS84_FLATTENING)
    b = WGS84_RADIUS * (1.0 - WGS84_FLATTENING)
    p = math.hypot(x, y)
    beta = math.atan2(z * WGS84_RADIUS, p * b)
    latitude = 0.0
    for _ in range(3):
        sb, cb = math.sin(beta), math.cos(beta)
        latitude = math.atan2(z + e2 / (1.0 - e2) * b * sb**3, p - e2 * WGS84_RADIUS * cb**3)
        beta = math.atan2((1.0 - WGS84_FLATTENING) * math.sin(latitude), math.cos(latitude))
    s, c = math.sin(latitude), math.cos(latitude)
    height = p * c + z * s - WGS84_RADIUS * math.sqrt(1.0 - e2 * s * s)
    return latitude, math.atan2(y, x), height


def _eccentric_anomaly(M: float, e: float) -> float:
    """E from Kepler's equation M = E - e sin E, by Newton's method from E = M + e sin M.

    Without a limit to its change it diverges before the perigee where e is above 0.99.
    """
    E = M + e * math.sin(M)
    for _ in range(50):
        change = min(max((E - e * math.sin(E) - M) / (1.0 - e * math.cos(E)), -1.0), 1.0)
        E -= change
        if abs(change) < 1e-9 * max(1.0, abs(M)):
            break
    return E
