"""Errors of pointing and knowledge, and their statistics over time and over an ensemble of flights.

Of an error e(t), a rotation vector (3,) rad, with means over windows of a stated length:

- absolute: |e|
- mean: |mean of e over a window|
- relative: |e - mean of its window|
- drift: |mean of a window - mean of the window a stated time later|

Statistics at a confidence P: `ensemble` is the value that a share P of the flights never exceeds, `temporal` the one
that the worst flight does not exceed for a share P of the time, `mixed` the one of all samples of all flights.
Tests: tests/design/review/test_budget.py has closed forms of a linear system driven by Gaussian noise.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from plant.so3 import Array

INDICES = ("absolute", "mean", "relative", "drift")


class Statistics(NamedTuple):
    """Statistics of the size of an error, rad."""

    ensemble: float
    temporal: float
    mixed: float


def rotation_vectors(Q: Array) -> Array:
    """Returns phi (n, 3) rad of Q = exp(phi^) (n, 3, 3); exact to rounding at small angles, right up to pi."""
    v = 0.5 * np.stack([Q[:, 2, 1] - Q[:, 1, 2], Q[:, 0, 2] - Q[:, 2, 0], Q[:, 1, 0] - Q[:, 0, 1]], axis=1)
    sine = np.linalg.norm(v, axis=1)
    angle = np.arctan2(sine, 0.5 * (np.trace(Q, axis1=1, axis2=2) - 1.0))
    vectors = v * np.divide(angle, sine, out=np.ones_like(sine), where=sine > 1e-12)[:, None]
    for i in np.flatnonzero((sine < 1e-6) & (angle > 3.0)):  # at pi the sine tells no axis
        column = (Q[i] + np.eye(3))[:, int(np.diag(Q[i]).argmax())]
        vectors[i] = angle[i] * column / np.linalg.norm(column)
    return vectors


def to_lvlh(R_NB: Array, r_N: Array, v_N: Array, R_d0: Array) -> Array:
    """Returns Q = R_d^T R (n, 3, 3) of attitudes along an orbit, R_d being R_d0 relative to LVLH [4]."""
    z = -r_N / np.linalg.norm(r_N, axis=1, keepdims=True)
    y = -np.cross(r_N, v_N)
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    R_d = np.stack([np.cross(y, z), y, z], axis=2) @ R_d0
    return np.asarray(R_d.transpose(0, 2, 1) @ R_NB)


def sizes(error: Array, step: float, window: float, apart: float) -> dict[str, Array]:
    """Returns by index its values along a flight.

    error (n, 3) rad at a constant step; `window` and `apart`, s, are cut to whole steps. A window begins at each
    sample. A flight shorter than a window has no values of the others.
    """
    count, later = (max(round(time / step), 1) for time in (window, apart))
    if len(error) < count:
        return {"absolute": np.linalg.norm(error, axis=1), **dict.fromkeys(INDICES[1:], np.empty(0))}
    windows = np.moveaxis(np.lib.stride_tricks.sliding_window_view(error, count, axis=0), 2, 1)
    means = windows.mean(axis=1)
    vectors = {
        "absolute": error,
        "mean": means,
        "relative": (windows - means[:, None]).reshape(-1, 3),
        "drift": means[later:] - means[:-later],
    }
    # no attitude is more than pi from another, though vectors near pi turn over
    return {name: np.minimum(np.linalg.norm(v, axis=1), math.pi) for name, v in vectors.items()}


def statistics(flights: Sequence[Array], confidence: float) -> Statistics:
    """Returns the statistics of the sizes (n,) of an error on each flight; nan without a flight."""
    flights = [values for values in flights if len(values)]
    if not flights:
        return Statistics(math.nan, math.nan, math.nan)
    return Statistics(
        quantile(np.array([values.max() for values in flights]), confidence),
        max(quantile(values, confidence) for values in flights),
        quantile(np.concatenate(flights), confidence),
    )


def quantile(values: Array, share: float) -> float:
    """The least value that at least this share of the values does not exceed."""
    place = max(math.ceil(share * len(values) - 1e-9) - 1, 0)
    return float(np.partition(values, place)[place])


def largest_covers(flights: int, share: float) -> float:
    """Returns the confidence with which the largest of so many flights bounds this share of all (Wilks 1941)."""
    return 1.0 - share**flights


def difference(a: Sequence[float], b: Sequence[float], confidence: float) -> tuple[float, float]:
    """Returns the mean of a - b of flights with the same draws, and half of its interval by Student's t; nan of one."""
    each = np.subtract(a, b)
    n = len(each)
    if n < 2:
        return float(each.mean()) if n else math.nan, math.nan
    t = float(stdtrit(n - 1, 0.5 + 0.5 * confidence))
    return float(each.mean()), t * float(each.std(ddof=1)) / math.sqrt(n)


def summed(nothing: float, alone: Iterable[float]) -> tuple[float, float]:
    """Returns the linear sum and the root of the sum of squares of errors, each flown alone.

    `nothing` is what a flight without any of them has, which is part of each: it counts once.
    """
    parts = [(max(value - nothing, 0.0), max(value**2 - nothing**2, 0.0)) for value in alone]
    return nothing + sum(a for a, _ in parts), math.sqrt(nothing**2 + sum(b for _, b in parts))


def of_flights(
    errors: Sequence[Array], step: float, window: float, apart: float, confidence: float
) -> Mapping[str, Statistics]:
    """Returns by index the statistics of errors (n, 3) rad on each flight."""
    each = [sizes(error, step, window, apart) for error in errors]
    return {name: statistics([one[name] for one in each], confidence) for name in INDICES}
