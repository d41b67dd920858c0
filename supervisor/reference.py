"""The target of a pointing mode: attitude (N from desired body), rate and its derivative in desired body axes."""

from __future__ import annotations

import math
import re
from datetime import UTC, datetime, timedelta
from typing import NamedTuple

import numpy as np

from .so3 import Array, norm, shortest

EARTH_RATE = 7.2921158553e-5
"""rad/s, of Greenwich mean sidereal time: N is true of date."""
RADIUS, FLATTENING = 6378137.0, 1.0 / 298.257223563
"""m; of the ellipsoid WGS 84."""
R_MIN, COLLINEAR = 1.0, 1e-9
"""m from the Earth's centre, and |r x v|/(|r||v|), below which an orbit has no plane."""


class Reference(NamedTuple):
    """R_ref (3,3), Omega_ref (3,) rad/s, dOmega_ref (3,) rad/s2."""

    R_ref: Array
    Omega_ref: Array
    dOmega_ref: Array


class Direction(NamedTuple):
    """A unit vector (3,) in N with its first and second derivative."""

    u: Array
    du: Array
    ddu: Array


def lvlh(r: Array, v: Array) -> Reference:
    """Z to nadir, Y against the orbit's normal, on any two-body orbit: Omega = (0, -n, 0), n = |r x v|/r^2. Raises
    ValueError.

    r (3,) m, v (3,) m/s.
    """
    h = np.cross(r, v)
    size = norm(r)
    if size < R_MIN or not norm(h) > COLLINEAR * size * norm(v):
        raise ValueError(
            f"r_N, v_N: expected a position and a velocity that span the orbit's plane, found r_N = {r.tolist()}, "
            f"v_N = {v.tolist()}"
        )
    z, y = -r / size, -h / norm(h)
    n = norm(h) / (size * size)
    dn = -2.0 * n * float(r @ v) / (size * size)
    return Reference(np.column_stack((np.cross(y, z), y, z)), np.array((0.0, -n, 0.0)), np.array((0.0, -dn, 0.0)))


def inertial(R: Array) -> Reference:
    """An attitude at rest."""
    return Reference(R, np.zeros(3), np.zeros(3))


def unit(p: Array, dp: Array, ddp: Array) -> Direction:
    """The direction of a vector that moves."""
    size = norm(p)
    u = p / size
    du = (dp - u * float(u @ dp)) / size
    change, bend = float(u @ dp), float(u @ ddp) + float(du @ dp)
    return Direction(u, du, (ddp - 2.0 * change * du - bend * u) / size)


def point_on_earth(latitude: float, longitude: float, height: float) -> Array:
    """(3,) m, Earth-fixed, of geodetic coordinates on WGS 84, rad, rad, m."""
    e2 = FLATTENING * (2.0 - FLATTENING)
    s, c = math.sin(latitude), math.cos(latitude)
    across = RADIUS / math.sqrt(1.0 - e2 * s * s)
    from_axis = (across + height) * c
    return np.array(
        (from_axis * math.cos(longitude), from_axis * math.sin(longitude), (across * (1.0 - e2) + height) * s)
    )


def line_of_sight(p_earth: Array, angle: float, r: Array, v: Array, mu: float) -> Direction:
    """From the satellite on its two-body orbit to a point on the Earth, whose angle of Greenwich is `angle`, rad."""
    c, s = math.cos(angle), math.sin(angle)
    x, y, z = p_earth.tolist()
    p = np.array((c * x - s * y, s * x + c * y, z))
    w = np.array((0.0, 0.0, EARTH_RATE))
    dp = np.cross(w, p)
    size = norm(r)
    return unit(p - r, dp - v, np.cross(w, dp) + (mu / (size * size * size)) * r)


def elevation(p_earth: Array, latitude: float, longitude: float, angle: float, r: Array) -> float:
    """Returns the elevation of the satellite at a point on the Earth, rad; the vertical is that of the ellipsoid."""
    c, s = math.cos(angle), math.sin(angle)
    x, y, z = r.tolist()
    up = np.array(
        (math.cos(latitude) * math.cos(longitude), math.cos(latitude) * math.sin(longitude), math.sin(latitude))
    )
    d = np.array((c * x + s * y, -s * x + c * y, z)) - p_earth
    return math.atan2(float(d @ up), norm(np.cross(d, up)))


def steered(z: Direction, normal: Array, yaw: float) -> Reference:
    """Z along a direction, X (turned back by `yaw` about Z) in the sense of flight: as LVLH where Z is nadir.

    normal (3,): that of the orbit, which does not move.
    """
    x = unit(np.cross(-normal, z.u), np.cross(-normal, z.du), np.cross(-normal, z.ddu))
    y = np.cross(z.u, x.u)
    dy = np.cross(z.du, x.u) + np.cross(z.u, x.du)
    ddy = np.cross(z.ddu, x.u) + 2.0 * np.cross(z.du, x.du) + np.cross(z.u, x.ddu)
    Omega = np.array((z.u @ dy, x.u @ z.du, y @ x.du))
    dOmega = np.array((z.du @ dy + z.u @ ddy, x.du @ z.du + x.u @ z.ddu, dy @ x.du + y @ x.ddu))
    c, s = math.cos(yaw), math.sin(yaw)
    turn = np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))
    return Reference(np.column_stack((x.u, y, z.u)) @ turn, turn.T @ Omega, turn.T @ dOmega)


def free(axis_B: Array, to: Direction, before: Array) -> Reference:
    """The body axis axis_B (3,) along a direction, by the smallest turn from the attitude `before` (3,3):
    no rate about it."""
    R = shortest(before @ axis_B, to.u) @ before
    return Reference(R, R.T @ np.cross(to.u, to.du), R.T @ np.cross(to.u, to.ddu))


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


def sidereal_angle(epoch: str) -> float:
    """Greenwich mean sidereal time, rad in [0, 2 pi), IAU 1982, of a date in UTC in ISO 8601. Raises ValueError."""
    T = days_since_j2000(parse_epoch(epoch)) / 36525.0
    seconds = 67310.54841 + T * (876600.0 * 3600.0 + 8640184.812866 + T * (0.093104 - T * 6.2e-6))
    return math.radians((seconds % 86400.0) / 240.0)
