"""Margins from a frequency response: gain, phase, delay and disk margins of a loop, and of all channels at once.

Classical margins: K. J. Astrom, R. M. Murray, Feedback Systems, 10.3. Disk margins: P. Seiler, A. Packard, P. Gahinet,
An introduction to disk margins, IEEE Control Systems 40 (2020), with skew 0: the loop keeps its stability under every
factor (2 + d)/(2 - d) with a complex |d| < alpha, alpha = 1/max |S - 1/2|. For channels that change independently, the
structured singular value of S - I/2 stands in place of the modulus; its bound by scaling is exact up to three channels.

Tests: tests/orchestration/margins/test_analysis.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import linear_sum_assignment, minimize

from ..fmu.model import Floats

Complex = NDArray[np.complex128]
FINE = 4
"""Points that are looked at from line to line."""
LEAST = 0.1
"""Factor on the gain down to which a margin is told: S is the same size there, and measured no better than to 0.01 of
its largest; a crossing at 0.09 was seen to hold down to 0.06."""


@dataclass(frozen=True)
class Crossing:
    """A margin and the frequency, rad/s, to which it belongs; infinite, with NaN, where there is none in the band."""

    value: float
    omega: float


@dataclass(frozen=True)
class Margins:
    """The least change that brings a loop to the limit of stability."""

    gain_up: Crossing
    """Factor above 1."""
    gain_down: Crossing
    """Factor below 1; 0 where there is none."""
    phase: Crossing
    """rad of lag or lead"""
    delay: Crossing
    """s"""
    disk: Crossing
    """alpha, at most 2"""


@dataclass(frozen=True)
class Disk:
    """Guarantee of a disk margin: gains and, apart from them, phases that may change by so much."""

    low: float
    high: float
    phase: float
    """rad"""


NONE = Crossing(math.inf, math.nan)
NOTHING = 1e-300
"""In the place of a gain of zero, such as that of the place of a wheel that is not there."""


def disk(alpha: float) -> Disk:
    """Returns what a disk margin means for gains alone and for phases alone."""
    alpha = min(alpha, 2.0)
    high = (2 + alpha) / (2 - alpha) if alpha < 2.0 else math.inf
    return Disk(1 / high, high, 2 * math.atan(alpha / 2))


def margins(omega: Floats, L: Complex) -> Margins:
    """Returns the margins of one loop, L (lines,) at omega (lines,) rad/s, for a closed loop that is stable as it
    is."""
    x = np.log(omega)
    size, angle = CubicSpline(x, np.log(np.maximum(np.abs(L), NOTHING))), np.unwrap(np.angle(L))
    turn = CubicSpline(x, angle)
    ups: list[Crossing] = []
    downs: list[Crossing] = []
    lowest, highest = (math.floor(v / math.pi) for v in (angle.min(), angle.max() + math.pi))
    for k in range(lowest, highest + 1):
        if k % 2:
            for at in _roots(turn, k * math.pi):
                factor = math.exp(-float(size(at)))
                if factor > LEAST:
                    (ups if factor > 1.0 else downs).append(Crossing(factor, math.exp(at)))
    phases, delays = [], []
    if L[-1].real < 0.0 and abs(L[-1].imag) < 1e-6 * abs(L[-1].real):  # at half of the sampling frequency
        (ups if L[-1].real > -1.0 else downs).append(Crossing(-1.0 / float(L[-1].real), float(omega[-1])))
    for at in _roots(size, 0.0):
        lag = (float(turn(at)) + math.pi) % (2 * math.pi)
        phases.append(Crossing(min(lag, 2 * math.pi - lag), math.exp(at)))
        delays.append(Crossing(lag / math.exp(at), math.exp(at)))
    return Margins(
        min(ups, key=_value, default=NONE),
        max(downs, key=_value, default=Crossing(0.0, math.nan)),
        min(phases, key=_value, default=NONE),
        min(delays, key=_value, default=NONE),
        disk_margin(omega, (1.0 / (1.0 + L))[:, None, None]),
    )


def loci(L: Complex) -> Complex:
    """Returns the eigenvalues of L (lines, channels, channels) as curves (lines, channels).

    A gain or delay that is the same in all channels makes the loop unstable where it does so for one of them.
    """
    curves = np.linalg.eigvals(L)
    for before, now in pairwise(curves):
        _, order = linear_sum_assignment(np.abs(before[:, None] - now))
        now[:] = now[order]
    return np.asarray(curves)


def alike(omega: Floats, L: Complex) -> Margins:
    """Returns the margins for changes that are the same in all channels; the disk of independent ones."""
    each = [margins(omega, curve) for curve in loci(L).T]
    return Margins(
        min((m.gain_up for m in each), key=_value),
        max((m.gain_down for m in each), key=_value),
        min((m.phase for m in each), key=_value),
        min((m.delay for m in each), key=_value),
        disk_margin(omega, np.asarray(np.linalg.inv(np.eye(L.shape[1]) + L))),
    )


def disk_margin(omega: Floats, S: Complex) -> Crossing:
    """Returns alpha for channels that change independently, S = (I + L)^-1 (lines, channels, channels)."""
    x = np.log(omega)
    fine = np.unique(np.concatenate([np.linspace(a, b, FINE) for a, b in pairwise(x)]))
    matrices = CubicSpline(x, S)(fine) - 0.5 * np.eye(S.shape[1])
    bounds = np.linalg.norm(matrices, 2, axis=(1, 2))
    largest, worst = 0.0, 0
    for i in np.argsort(-bounds):
        if bounds[i] <= largest:
            break  # scaling only makes it less
        if (size := structured(matrices[i])) > largest:
            largest, worst = size, int(i)
    return Crossing(1.0 / largest, math.exp(fine[worst]))


def structured(M: Complex) -> float:
    """Returns the least largest singular value of D M D^-1 over positive diagonal D: mu for independent complex
    factors."""
    n = len(M)
    if n == 1:
        return float(abs(M[0, 0]))

    def size(logs: Floats) -> float:
        d = np.exp(np.append(logs, 0.0))
        return float(np.linalg.norm(M * d[:, None] / d, 2))

    off = np.abs(M) + 1e-12 * np.abs(M).max()
    start = [0.5 * math.log(off[n - 1, :].sum() / off[i, :].sum()) for i in range(n - 1)]
    found = minimize(size, start, method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-7})
    return min(float(found.fun), size(np.zeros(n - 1)))


def _roots(curve: CubicSpline, value: float) -> Iterable[float]:
    """Returns where the curve has this value, within its lines."""
    found = curve.solve(value, extrapolate=False)
    return [float(x) for x in found if np.isfinite(x)]


def _value(crossing: Crossing) -> float:
    return crossing.value
