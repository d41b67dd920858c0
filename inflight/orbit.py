"""Position by element sets (SGP4), in N, with the geomagnetic field there and the Earth's shadow.

SGP4 gives TEME: the true equator, the mean equinox. From it to the Earth turns GMST about Z, which is how N turns to
the Earth in this project, so TEME is taken as N; read as the mean equator and equinox of date, N is off by nutation,
0.005 deg. UT1 is taken as UTC (0.9 s at most: 0.4 km along the equator). Tests: tests/inflight/test_orbit.py."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sgp4.api import SGP4_ERRORS, Satrec, SatrecArray

from orchestration.errors import InputError, Place, Problem, reason
from orchestration.results.whole import content
from orchestration.scenario.orbit import Ephemeris
from plant import sun
from plant.geomagnetic import Field
from plant.orbit import WGS84_FLATTENING, WGS84_RADIUS, drifting
from plant.tables.field_models import from_package
from plant.time_scales import EARTH_RATE, days_since_j2000, decimal_year, gmst, parse_epoch

Floats = NDArray[np.float64]

AGE_MAX = 7.0
"""Days from the nearest element set beyond which a position is refused."""
_J2000_JD = 2451545.0
MU = 3.986004418e14
"""m3/s2, by default that of the plant."""
FITTED = 300
"""Instants of an orbit, at most, to which a plant's is fitted."""
FIELD_STEP = 10.0
"""Of the nodes between which the field is interpolated, s; the error is below 1 nT."""


@dataclass(frozen=True)
class Orbit:
    """Positions of a satellite at some instants."""

    epoch: datetime
    """UTC of t = 0."""
    t: Floats
    """(n,) s"""
    r_N: Floats
    v_N: Floats
    """(n, 3) m, m/s"""
    age: float
    """Days between the element set and the middle of the instants."""

    @property
    def utc(self) -> str:
        """The epoch as text."""
        return f"{self.epoch:%Y-%m-%dT%H:%M:%S.%f}".rstrip("0").rstrip(".") + "Z"

    @property
    def gmst(self) -> Floats:
        """(n,) rad"""
        return gmst(self.epoch) + EARTH_RATE * self.t

    def sun_N(self) -> Floats:
        """(n, 3) unit vectors to the Sun, by the plant's model."""
        days = days_since_j2000(self.epoch) + (self.t + sun.TT_UTC) / 86400.0
        return _unit(np.array([sun.position(day / 36525.0) for day in days]) - self.r_N)

    def field_N(self, degree: int = 13, model: str = "igrf14") -> Floats:
        """(n, 3) T: the field along the orbit, by cubic interpolation between nodes."""
        from scipy.interpolate import CubicSpline  # takes long, and not every command needs it  # noqa: PLC0415

        if np.ptp(self.t) > 4 * FIELD_STEP and len(self.t) > 5:
            nodes = np.arange(self.t.min(), self.t.max() + FIELD_STEP, FIELD_STEP)
            at = CubicSpline(self.t, self.r_N)(nodes) if np.all(np.diff(self.t) > 0) else self.r_N
            return np.asarray(CubicSpline(nodes, self._fields(nodes, at, degree, model))(self.t))
        return self._fields(self.t, self.r_N, degree, model)

    def _fields(self, t: Floats, r_N: Floats, degree: int, model: str) -> Floats:
        field = Field(*from_package(model).at(decimal_year(self.epoch)), degree)
        turn = _about_z(gmst(self.epoch) + EARTH_RATE * t)
        fixed = np.einsum("nij,nj->ni", turn, r_N)
        return np.einsum("nji,nj->ni", turn, np.array([field.at(r) for r in fixed]))

    def sunlight(self, air: float = 0.0) -> Floats:
        """(n,) the part of the Sun that the Earth leaves uncovered: a conical shadow of the ellipsoid, `air` m larger.

        Along Z the space is stretched by 1/(1 - f), which makes a sphere of the ellipsoid.
        """
        stretch = np.array((1.0, 1.0, 1.0 / (1.0 - WGS84_FLATTENING)))
        r, s = self.r_N * stretch, _unit(self.sun_N() * stretch)
        size = np.linalg.norm(r, axis=1)
        from_nadir = np.arccos(np.clip(-np.einsum("ni,ni->n", r, s) / size, -1.0, 1.0))
        edge = np.arcsin((WGS84_RADIUS + air) / size)
        half = 4.65e-3
        return np.clip(0.5 + (from_nadir - edge) / (2.0 * half), 0.0, 1.0)


def borders(orbit: Orbit) -> Floats:
    """Times, s, at which the satellite enters or leaves the Earth's shadow."""
    return np.asarray(orbit.t[1:][np.diff((orbit.sunlight() > 0.5).astype(int)) != 0])


def read_elements(path: Path) -> list[Satrec]:
    """Returns the element sets of a file of two-line elements, names between them or not. Raises InputError."""
    try:
        lines = content(path).decode("utf-8").splitlines()
    except (OSError, ValueError) as error:
        why = reason(error) if isinstance(error, (OSError, UnicodeDecodeError)) else error
        raise InputError(f"{path} cannot be read: {why}") from None
    sets = []
    for number, line in enumerate(lines, start=1):
        if not line.startswith("1 "):
            continue
        second = lines[number].rstrip() if number < len(lines) else ""
        for at, text, begins in ((number, line.rstrip(), line[:7]), (number + 1, second, f"2 {line[2:7]}")):
            if wrong := _wrong(text, begins):
                raise InputError(Problem(wrong, place=Place(str(path), at)))
        sets.append(Satrec.twoline2rv(line, second))
    if not sets:
        raise InputError(f"{path}: expected two-line element sets, found none")
    return sets


def ephemeris(path: Path, start: str, t: Floats) -> Ephemeris:
    """Returns what a scenario's `orbit` takes: `r_N` and `v_N` at t (n,), s, from UTC `start`, and a plant's start
    values that follow them. Raises InputError."""
    try:
        epoch = parse_epoch(start)
    except ValueError as error:
        raise InputError(f"start: {error}") from None
    orbit = orbit_at(read_elements(path), epoch, t)
    return Ephemeris({"r_N": ("m", orbit.r_N), "v_N": ("m/s", orbit.v_N)}, lambda: followed(orbit))


def _wrong(line: str, begins: str) -> str:
    """Returns why a line is none of an element set that begins with a line's number and the satellite's; nothing where
    it is.
    """
    if len(line) != 69:
        return f"expected a line of 69 characters of an element set, found {len(line)}"
    if not line.startswith(begins):
        return f"expected a line that begins with {begins!r}, found {line[:7]!r}"
    total = str(sum(int(c) if c.isdigit() else c == "-" for c in line[:68]) % 10)
    return "" if line[68] == total else f"expected the check sum {total} as the last digit, found {line[68]!r}"


def orbit_at(sets: Sequence[Satrec], epoch: datetime, t: Floats) -> Orbit:
    """Returns the orbit at times t (n,), s from an epoch in UTC, by the nearest element set. Raises InputError."""
    jd = _J2000_JD + days_since_j2000(epoch)
    middle = jd + float(np.median(t)) / 86400.0
    nearest = min(sets, key=lambda s: abs(s.jdsatepoch + s.jdsatepochF - middle))
    age = middle - nearest.jdsatepoch - nearest.jdsatepochF
    if not abs(age) <= AGE_MAX:
        raise InputError(
            f"the nearest element set is {abs(age):.1f} days from {epoch:%Y-%m-%dT%H:%M:%SZ}; expected at most "
            f"{AGE_MAX:g}"
        )
    whole = np.floor(jd)
    e, r, v = SatrecArray([nearest]).sgp4(np.full(len(t), whole), jd - whole + t / 86400.0)
    if e.any():
        raise InputError(f"SGP4 refuses the element set: {SGP4_ERRORS[int(e[e > 0][0])]}")
    return Orbit(epoch, t, 1e3 * r[0], 1e3 * v[0], age)


def followed(orbit: Orbit) -> tuple[dict[str, Any], str]:
    """Returns the start values with which a plant follows an orbit from its first instant, t = 0, on, and how near.

    The plant's own orbit, Keplerian with J2's drift of the node, is fitted to positions and velocities, a metre per
    second as a kilometre. What it leaves are J2's periodic terms, a few kilometres.
    """
    from scipy.optimize import least_squares  # takes long, and not every command needs it  # noqa: PLC0415

    chosen = np.unique(np.linspace(0, len(orbit.t) - 1, FITTED).astype(int))
    t, wanted = orbit.t[chosen], np.hstack((orbit.r_N, orbit.v_N))[chosen]
    scale = np.repeat((1e3, 1.0), 3)  # m, m/s

    def off(x: Floats) -> Floats:
        own = drifting(1e3 * x[:3], x[3:], MU)
        return ((np.array([own.position_velocity(s) for s in t]).reshape(-1, 6) - wanted) / scale).ravel()

    found = least_squares(off, wanted[0] / scale, x_scale=1e-3 * np.abs(wanted).max(axis=0) / scale)
    r, v = 1e3 * found.x[:3], found.x[3:]
    left = np.linalg.norm(found.fun.reshape(-1, 6)[:, :3], axis=1)
    start = {"orbit_start": "position_velocity", "r_N0": r.tolist(), "v_N0": v.tolist(), "j2_node_drift": True}
    return start | {
        "epoch": orbit.utc
    }, f"its orbit follows that of SGP4 within {max(left.max(), 0.05):.1f} km over {t[-1]:.10g} s"


def instant(tai: float) -> datetime:
    """Returns the UTC of seconds of TAI since 1970-01-01, as a record counts them."""
    from orchestration.telemetry.times import unix  # noqa: PLC0415

    return datetime(1970, 1, 1, tzinfo=UTC) + timedelta(seconds=unix(tai))


def _about_z(angle: Floats) -> Floats:
    """(n, 3, 3): from N to the Earth."""
    c, s, zero = np.cos(angle), np.sin(angle), np.zeros_like(angle)
    return np.array([[c, s, zero], [-s, c, zero], [zero, zero, zero + 1.0]]).transpose(2, 0, 1)


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))
