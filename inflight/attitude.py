"""A flight through the bank: attitudes row by row, when they are unique, and what the gyro's scale and bias are."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from estimator.bank import (
    GYRO,
    MARGIN,
    PRUNE_ANGLE,
    PRUNE_EVERY,
    PRUNE_MARGIN,
    STRAIN_MAX,
    TURNS,
    UNIQUE,
    Bank,
    Faces,
    Noise,
    by_field,
    by_light,
    propagate,
    started,
)

from .records import Flight

Floats = NDArray[np.float64]

LIGHT = 0.99
"""Part of the Sun above which currents count."""


STEADY = 15.0
"""s before and after a row, within which the rate of a body that turns freely is a parabola of time."""


def steadied(flight: Flight) -> Flight:
    """The same with rates by parabolas through the rows within STEADY s of each, for a body that turns freely.

    In its own axes such a rate changes slowly. The gyro's noise does not, and what of it has the frequency of the spin
    turns the spin axis of a filter in space, which no torque does.
    """
    t, rates = flight.t, np.empty_like(flight.omega)
    for i in range(len(t)):
        rows = slice(*np.searchsorted(t, (t[i] - STEADY, t[i] + STEADY), side="left"))
        off = (t[rows] - t[i]) / STEADY
        weight = np.sqrt(1.0 - off**2)[:, None]
        terms = np.vander(off, 3, increasing=True)
        rates[i] = np.linalg.lstsq(weight * terms, weight * flight.omega[rows], rcond=None)[0][0]
    return replace(flight, omega=rates)


AS_A_START = np.pi / TURNS
"""rad, deviation of the turn at a start: what a gap leaves with as much is started anew."""


@dataclass(frozen=True)
class Attitudes:
    """Results of the bank."""

    R: Floats
    """(n,3,3) N from B, of the filter that was the most likely at that row"""
    omega: Floats
    """(n,3) rad/s, without bias and scale"""
    ambiguity: Floats
    """(n,) rad: from the best attitude to the farthest that is not excluded"""
    nis: Floats
    """(n,) of the field, of the best filter before it takes the field"""
    bias: Floats
    scale: Floats
    covariance: Floats
    """(6,6) of bias and scale at the end"""
    strain: float
    """The largest bias or scale at the end, in deviations of what was known before"""
    likelihood: float = np.nan
    """Its logarithm, of all measurements by the best filter at the end, up to a constant"""

    @property
    def trusted(self) -> bool:
        """Returns whether the attitude became unique and the gyro's errors are such as were expected."""
        return bool(self.unique[-1]) and self.strain <= STRAIN_MAX

    @property
    def unique(self) -> NDArray[np.bool_]:
        """(n,) whether the attitude is unique, now and from now on."""
        good = self.ambiguity < UNIQUE
        return np.asarray(np.logical_and.accumulate(good[::-1])[::-1])

    def verdict(self) -> str:
        """Returns what a user has to know: whether the attitude became unique, and when, or why it is no attitude to
        trust.
        """
        unique = self.unique
        if self.strain > STRAIN_MAX:
            return f"doubtful: the gyro's errors would be {self.strain:.0f} times what was known before"
        if not unique.any():
            return f"ambiguous to the end: attitudes {np.degrees(self.ambiguity[-1]):.0f} deg apart fit alike"
        return f"unique from row {int(unique.argmax()) + 1} of {len(unique)}"


def attitudes(flight: Flight, field: Floats, field_N: Floats, noise: Noise, faces: Faces | None = None) -> Attitudes:
    """The attitude of a flight by its gyro, its calibrated field (n,3), T, and, with `faces`, its currents."""
    t, omega = flight.t, flight.omega
    n = len(t)
    R, rate, ambiguity, nis = np.zeros((n, 3, 3)), np.zeros((n, 3)), np.zeros(n), np.zeros(n)
    lit = flight.orbit.sunlight() > LIGHT if faces is not None else np.zeros(n, bool)
    sun_N = flight.orbit.sun_N() if faces is not None else np.zeros((n, 3))
    bank: Bank = started(field[0], field_N[0], noise)
    for i in range(n):
        if i:
            before = _deviation(bank)
            propagate(bank, omega[i - 1], omega[i], t[i] - t[i - 1], noise)
            if before < AS_A_START <= _deviation(bank):
                bank = started(field[i], field_N[i], noise)
        innovation = field[i] - bank.R[bank.best].T @ field_N[i]
        nis[i] = innovation @ innovation / noise.field**2
        by_field(bank, field[i], field_N[i], noise)
        if faces is not None and lit[i] and np.isfinite(flight.currents[i]).all():
            by_light(bank, flight.currents[i], faces, sun_N[i], flight.orbit.r_N[i], noise)
        best = bank.best
        R[i], ambiguity[i] = bank.R[best], bank.ambiguity(MARGIN)
        rate[i] = (omega[i] - bank.bias[best]) / (1.0 + bank.scale[best])
        if i % PRUNE_EVERY == PRUNE_EVERY - 1:
            bank.pruned(PRUNE_MARGIN, PRUNE_ANGLE)
    best = bank.best
    bias, scale = bank.bias[best], bank.scale[best]
    covariance, likelihood = bank.P[best][np.ix_(GYRO, GYRO)], float(bank.score[best])
    return Attitudes(R, rate, ambiguity, nis, bias, scale, covariance, bank.strain(noise), likelihood)


def _deviation(bank: Bank) -> float:
    """rad: of the turn of the best filter, about the axis on which it is the largest."""
    return float(np.sqrt(np.linalg.eigvalsh(bank.P[bank.best, :3, :3])[-1]))


def both_ways(
    flight: Flight, field: Floats, field_N: Floats, noise: Noise, found: Attitudes
) -> tuple[Attitudes, float]:
    """The same filters back from the last row: `found` with their attitudes where its own are not unique, and the rms
    angle, rad, between both where both are, NaN without such a row.

    The start of one has no part in the other, so two that have converged to different attitudes show. Backwards the
    rate, and with it its bias, has the opposite sign.
    """
    back = replace(flight, t=flight.t[-1] - flight.t[::-1], omega=-flight.omega[::-1])
    seen = attitudes(back, field[::-1], field_N[::-1], noise)
    R, rate, ambiguity, unique = seen.R[::-1], -seen.omega[::-1], seen.ambiguity[::-1], seen.unique[::-1]
    both, own = found.unique & unique, found.unique
    cosine = 0.5 * (np.einsum("nij,nij->n", found.R[both], R[both]) - 1.0)
    apart = float(np.sqrt(np.mean(np.arccos(np.clip(cosine, -1.0, 1.0)) ** 2))) if both.any() else np.nan
    merged = replace(
        found,
        R=np.where(own[:, None, None], found.R, R),
        omega=np.where(own[:, None], found.omega, rate),
        ambiguity=np.where(own, found.ambiguity, np.where(unique, ambiguity, np.pi)),
    )
    return merged, apart
