"""What a record shows beside the models. The filter does not see the Sun sensors that it is compared with, and no
constant depends on a row's number; docs/evidence/flight_data.md says which were chosen with the comparison in view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from estimator.bank import Noise, earths_light, exp
from inflight.attitude import LIGHT, Attitudes, attitudes, both_ways, steadied
from inflight.magnetometer import Calibration, calibrate, symmetric
from inflight.nutation import Inertia, Motion, forecast, identify, left_out, starting
from inflight.orbit import borders
from inflight.records import Flight

from .records import NORMALS

Floats = NDArray[np.float64]

NOISE = replace(Noise(), angle=5e-4)
"""Of rates by parabolas; the likelihood of the field chose it (parts.py)."""
LONG = 600.0
"""s; a record of at least this length is calibrated by itself."""
LIT = 0.25
"""Part of the Sun's current at normal incidence from which a face sees the Sun: the Earth gives so much at most."""
ALBEDO = 0.3
"""Mean of the Earth."""
AIR = 22e3
"""m by which the air makes the Earth's shadow larger; taken from an earlier look at these data."""
FIT = 100.0
"""s of a short record that are fitted; the rest is forecast."""
NUTATES = np.radians(0.15)
"""rad/s: a record whose rate across the spin varies more than this takes part in the inertia."""
FALSE = 15.0
"""deg rms, beyond which an attitude that is trusted is a false convergence that nobody reported."""


@dataclass(frozen=True)
class Sky:
    """Sun directions by currents against those by the attitude: rms and median, deg, and rows."""

    rms: float
    median: float
    rows: int
    common: float
    """deg: the turn of the body that all rows have in common; NaN where one angle alone is compared"""


def by_sun(flight: Flight, found: Attitudes) -> tuple[Floats, Floats]:
    """The Sun's part of the currents (n,3), of that at normal incidence, NaN without light or a unique attitude; and
    the model's direction to the Sun (n,3) in B.

    All faces have one gain, the median of currents over those of the model where it sees the Sun well.
    """
    orbit, currents = flight.orbit, np.full((len(flight.t), 3), np.nan)
    day = found.unique & (orbit.sunlight(AIR) > LIGHT)
    if flight.currents.size:
        currents[day] = flight.currents[day]
    sun_N, size = orbit.sun_N(), np.linalg.norm(orbit.r_N, axis=1)[:, None]
    sun_B, nadir_B = (np.einsum("nji,nj->ni", found.R, v) for v in (sun_N, -orbit.r_N / size))
    earth = earths_light(ALBEDO, orbit.r_N, sun_N)[:, None] * (0.5 * (1.0 + nadir_B @ NORMALS.T)) ** 2
    direct = sun_B @ NORMALS.T
    seen = (direct > 0.5) & np.isfinite(currents)
    gain = float(np.median(currents[seen] / (direct + earth)[seen])) if seen.any() else np.nan
    return currents / gain - earth, sun_B


def sky(flight: Flight, found: Attitudes) -> tuple[Sky | None, Floats, NDArray[np.bool_]]:
    """The error on the sky where three faces see the Sun; None without a row. Also the error, deg, of all such rows."""
    currents, sun_B = by_sun(flight, found)
    on = np.asarray((currents > LIT).all(axis=1))
    measured = np.where(on[:, None], currents, 1.0) @ NORMALS
    measured /= np.linalg.norm(measured, axis=1)[:, None]
    turn = np.cross(sun_B, measured)
    error = np.degrees(np.arctan2(np.linalg.norm(turn, axis=1), np.einsum("ni,ni->n", measured, sun_B)))
    return _of_errors(error[on], turn[on]), error, on


def pair(flight: Flight, found: Attitudes) -> Sky | None:
    """The same where two faces see the Sun and the third does not: of the angle about the third one's normal alone."""
    currents, sun_B = by_sun(flight, found)
    on = currents > LIT
    rows = on.sum(axis=1) == 2
    a, b = (np.where(on, v, 0.0)[rows] for v in (currents, sun_B @ NORMALS.T))
    turn, size = np.cross(a, b), np.linalg.norm(b, axis=1)
    error = np.degrees(np.arctan2(np.linalg.norm(turn, axis=1), np.einsum("ni,ni->n", a, b))) * size
    return _of_errors(error, np.zeros((0, 3)))


def silent(found: Attitudes, *seen: Sky | None) -> bool:
    """Returns whether an attitude is trusted from which the Sun sensors are far: a false convergence that was not
    reported.
    """
    return found.trusted and max((each.rms for each in seen if each is not None), default=0.0) > FALSE


def _of_errors(error: Floats, turn: Floats) -> Sky | None:
    if not len(error):
        return None
    common = float(np.degrees(np.linalg.norm(turn.mean(axis=0)))) if len(turn) else np.nan
    return Sky(float(np.sqrt(np.mean(error**2))), float(np.median(error)), len(error), common)


@dataclass(frozen=True)
class Edge:
    """A border of an eclipse: the model's time, and how much later the currents have it, s; less the part of the
    air."""

    entry: bool
    time: float
    late: float
    late_air: float


def edges(flight: Flight, found: Attitudes) -> list[Edge]:
    """Entries and exits: the time shift of the model's light that fits the currents best, within 90 s of it.

    The faces' part in the light is that of the attitude, turned about the spin by the angle, up to 30 deg, that fits
    best: an error of the attitude about the spin is no error of the time.
    """
    light, air, t = flight.orbit.sunlight(), flight.orbit.sunlight(AIR), flight.t
    whole = np.isfinite(flight.currents).all(axis=1) & bool(flight.currents.size)
    axis = flight.omega.mean(axis=0)
    sun_B = np.einsum("nji,nj->ni", found.R, flight.orbit.sun_N())
    turns = exp(np.outer(np.radians(np.arange(-30.0, 31.0, 3.0)), axis / max(np.linalg.norm(axis), 1e-12)))
    out = []
    for i in np.flatnonzero(np.diff((light > 0.5).astype(int))):
        near = (np.abs(t - t[i]) < 90.0) & found.unique & whole
        if near.sum() < 60 or t[i] - t[0] < 90.0 or t[-1] - t[i] < 90.0:
            continue
        faces = [np.maximum(0.0, sun_B[near] @ turn.T @ NORMALS.T) for turn in turns]
        late = [_shift(t, model, flight.currents[near], faces, t[near]) for model in (light, air)]
        out.append(Edge(bool(light[i] > 0.5), float(t[i]), *late))
    return out


def air_and_rest(found: Sequence[Edge]) -> tuple[float, float] | None:
    """Half of what the shadow of a record is longer than the model's, s, which is what air does, and the shift of its
    middle, s, which it does not; None without both an entry and an exit."""
    late = [[edge.late for edge in found if edge.entry is entry] for entry in (True, False)]
    if not all(late):
        return None
    entry, exit_ = float(np.mean(late[0])), float(np.mean(late[1]))
    return 0.5 * (exit_ - entry), 0.5 * (exit_ + entry)


def _shift(t: Floats, light: Floats, currents: Floats, faces: list[Floats], at: Floats) -> float:
    def misfit(shift: float) -> float:
        least = np.inf
        for face in faces:
            seen = np.interp(at - shift, t, light)[:, None] * face
            gain = (seen * currents).sum() / max((seen**2).sum(), 1e-12)
            least = min(least, float(((currents - gain * seen) ** 2).sum()))
        return least

    tried = np.arange(-25.0, 25.5, 1.0)
    first = tried[int(np.argmin([misfit(s) for s in tried]))]
    return float(minimize_scalar(misfit, bounds=(first - 1.0, first + 1.0), method="bounded").x)


@dataclass(frozen=True)
class Shown:
    """Results of a long record."""

    flight: Flight
    """With its rates by parabolas"""
    left: float
    """rad/s rms, what they leave of the rates"""
    calibration: Calibration
    constant: float
    """|B| rms with a constant gain, T"""
    crossed: dict[str, float]
    """|B| rms, T, with matrix and bias of other records and the own gain"""
    attitude: Attitudes
    apart: float
    """rad rms between the filters' attitudes and those back from the last row"""
    sky: Sky | None
    pair: Sky | None
    edges: list[Edge]


def long_record(measured: Flight, others: Sequence[Calibration] = (), names: Sequence[str] = ()) -> Shown:
    """A record of its own calibration: field and gyro alone give the attitude, the Sun sensors are withheld."""
    flight = steadied(measured)
    left = float(np.sqrt(np.mean((flight.omega - measured.omega) ** 2)))
    field_N = flight.orbit.field_N()
    size = np.linalg.norm(field_N, axis=1)
    edge = borders(flight.orbit)
    own = calibrate(flight.t, flight.m, size, breaks=edge)
    crossed = {
        n: calibrate(flight.t, flight.m, size, known=c, breaks=edge).rms for n, c in zip(names, others, strict=True)
    }
    field = symmetric(own).field(flight.t, flight.m)
    found = attitudes(flight, field, field_N, NOISE)
    merged, apart = both_ways(flight, field, field_N, NOISE, found)
    constant = calibrate(flight.t, flight.m, size, interval=1e9).rms
    three, two = sky(flight, found)[0], pair(flight, found)
    return Shown(flight, left, own, constant, crossed, found, apart, three, two, edges(flight, merged))


@dataclass(frozen=True)
class Free:
    """Forecasts of free motion, rad/s rms, with the noise of the gyro that the fit leaves."""

    inertia: Inertia
    noise: float
    rows: list[dict[str, Any]]
    """name, fitted, forecast, left_out (forecast with the inertia of the others), constant (that of a constant rate)"""

    def whole(self, key: str) -> float:
        """The rms over all records, by their rows."""
        squares = [row[key] ** 2 * row["rows"] for row in self.rows]
        return float(np.sqrt(sum(squares) / sum(row["rows"] for row in self.rows)))


def free_motion(motions: Sequence[Motion]) -> Free | None:
    """Ratios of inertia from the records that nutate, and each forecast; None where fewer than two do."""
    chosen = [m for m in motions if _usable(m)]
    if len(chosen) < 2:
        return None
    early = [m.until(FIT) for m in chosen]
    whole = identify(early)
    rows = []
    for i, (motion, part) in enumerate(zip(chosen, early, strict=True)):
        without = left_out(early, whole, i)
        late = motion.t > FIT
        measured = motion.omega[late]
        ahead = [forecast(motion, known, starting(part, known))[late] for known in (whole, without)]
        fitted = forecast(part, whole, starting(part, whole)) - part.omega
        rms = [
            float(np.sqrt(np.mean(e**2)))
            for e in (fitted, *(a - measured for a in ahead), part.omega.mean(0) - measured)
        ]
        rows.append(
            dict(zip(("fitted", "forecast", "left_out", "constant"), rms, strict=True))
            | {"name": motion.name, "rows": int(late.sum())}
        )
    return Free(whole, whole.rms, rows)


def _usable(motion: Motion) -> bool:
    first = motion.until(FIT)
    whole = motion.t[-1] > FIT + 30.0 and len(first.t) > 60 and float(np.diff(motion.t).max()) < 100.0
    return whole and float(max(first.omega[:, 0].std(), first.omega[:, 2].std())) > NUTATES
