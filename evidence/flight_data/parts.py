"""Parts of the records, each as if it were all that there is, and the settings of the filters among which the fields
chose; and what rates by parabolas bring on spins with known answers.

Tests: tests/evidence/flight_data/test_study.py."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from inflight.attitude import attitudes, steadied
from inflight.magnetometer import symmetric
from inflight.records import Flight

from .study import NOISE, Shown, long_record
from .synthetic import angle, spinning

CUTS = {
    "first half": (0, 1 / 2),
    "second half": (1 / 2, 1),
    "first two thirds": (0, 2 / 3),
    "last two thirds": (1 / 3, 1),
    "a sixth to 0.6": (1 / 6, 0.6),
    "first 0.3": (0, 0.3),
    "0.2 to 0.7": (0.2, 0.7),
}


def cut(item: tuple[Flight, str]) -> Shown:
    """Returns what one of the CUTS of a record shows."""
    flight, name = item
    begin, end = CUTS[name]
    first, length = flight.t[0], float(np.ptp(flight.t))
    chosen = (flight.t >= first + begin * length) & (flight.t <= first + end * length)
    return long_record(replace(flight.part(chosen), name=f"{flight.name}, {name}"))


TRIED = {
    "as used": NOISE,
    "angle 1e-3": replace(NOISE, angle=1e-3),
    "rates as measured, angle 2e-3": replace(NOISE, angle=2e-3),
    "walk 1e-6": replace(NOISE, bias_walk=1e-6),
    "walk 1e-4": replace(NOISE, bias_walk=1e-4),
}
"""Noise of the angle, rad in 1 s, and walk of the gyro's bias, rad/s in 1 s, of which the field's likelihood chose."""


def likelihood(item: tuple[Flight, Shown, str]) -> float:
    """Logarithm of the likelihood of a record's field with one of TRIED, by the best filter."""
    measured, shown, tried = item
    flight = measured if "as measured" in tried else shown.flight
    field, field_N = symmetric(shown.calibration).field(flight.t, flight.m), flight.orbit.field_N()
    return attitudes(flight, field, field_N, TRIED[tried]).likelihood


def known(number: int) -> list[tuple[float, float]]:
    """A synthetic spin of 600 s with rates as measured, and by parabolas: rms and largest angle, deg, to the truth
    where the attitude is trusted, NaN where it is not at the end.

    The gyro is off by 1% and 1.7 deg/s, the calibration by 2% in each element, one deviation each.
    """
    rng = np.random.default_rng((520, number))
    bias = 0.03 * rng.normal(size=3) * (1.0, 0.3, 1.0)
    flight, R, B, _ = spinning(100 + number, 600, 0.01 * rng.normal(), tuple(bias), float(rng.uniform(0.0, 5400.0)))
    wrong = 0.02 * rng.normal(size=(3, 3))
    field = flight.m @ (np.eye(3) + 0.5 * (wrong + wrong.T))
    found = []
    for each, noise in ((flight, TRIED["rates as measured, angle 2e-3"]), (steadied(flight), NOISE)):
        seen = attitudes(each, field, B, noise)
        off = np.degrees(angle(R, seen.R)[seen.unique])
        found.append((float(np.sqrt(np.mean(off**2))), float(off.max())) if seen.trusted else (np.nan, np.nan))
    return found
