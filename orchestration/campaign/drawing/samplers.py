"""Distributions as functions of the unit cube: each takes `count` numbers, uniform in [0, 1), and gives a value.

So every way of sampling, plain random numbers, Latin hypercubes and Sobol's sequence, draws from the same
distributions.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import log_ndtr, ndtr, ndtri, ndtri_exp

from ...fmu.model import Floats

_SMALLEST = 2.0**-54
"""In the place of 0, whose normal quantile is infinite; the generator's next number is four times as large."""
_TINY = 1e-290
"""Probabilities below this one lose digits, so their logarithms are taken."""


class Sampler:
    """A distribution."""

    finite = True
    """Whether its values have ends in each of the numbers that it takes."""

    @property
    def count(self) -> int:
        """Returns how many numbers it takes."""
        return 1

    @property
    def bounded(self) -> tuple[bool, ...]:
        """Returns whether the values have ends there, of each number that it takes."""
        return (self.finite,) * self.count

    def value(self, u: Sequence[float]) -> Any:
        """Returns its value at `count` numbers in [0, 1)."""
        raise NotImplementedError


def _quantile(u: Any) -> Floats:
    """Returns quantiles of the standard normal distribution."""
    return np.asarray(ndtri(np.maximum(u, _SMALLEST)), float)


def _far(below: Floats, above: Floats, share: Floats) -> Floats:
    """Returns quantiles of the standard normal distribution between two ends in its lower tail, by logarithms of
    probabilities.

    With A and B the probabilities below `above` and `below`: log(share A + (1 - share) B) = log A + log(share + (1 -
    share) B/A).
    """
    with np.errstate(all="ignore"):
        upper = log_ndtr(above)
        z = ndtri_exp(upper + np.log(share + (1.0 - share) * np.exp(log_ndtr(below) - upper)))
    return np.where(np.isfinite(upper), z, above)  # beyond 1e154 deviations the distribution is its end


@dataclass(frozen=True)
class Uniform(Sampler):
    """low + u (high - low), element by element."""

    low: Floats
    high: Floats

    @property
    def count(self) -> int:
        return self.low.size

    def value(self, u: Sequence[float]) -> Any:
        return _plain(self.low + np.reshape(u, self.low.shape) * (self.high - self.low))


@dataclass(frozen=True)
class Normal(Sampler):
    """mean + deviation z, z standard normal between `low` and `high`, element by element."""

    mean: Floats
    deviation: Floats
    low: float = -math.inf
    high: float = math.inf

    @property
    def count(self) -> int:
        return self.mean.size

    @property
    def bounded(self) -> tuple[bool, ...]:
        return (math.isfinite(self.low) and math.isfinite(self.high),) * self.count

    def value(self, u: Sequence[float]) -> Any:
        given = np.clip(np.reshape(u, self.mean.shape), _SMALLEST, 1.0 - _SMALLEST)
        if self.low == -math.inf and self.high == math.inf:
            return _plain(self.mean + self.deviation * _quantile(given))
        a, b = (self.low - self.mean) / self.deviation, (self.high - self.mean) / self.deviation
        mirrored = a > 0.0  # the upper tail, of which the lower one has more digits
        below, above = np.where(mirrored, -b, a), np.where(mirrored, -a, b)
        share = np.where(mirrored, 1.0 - given, given)
        z = ndtri(ndtr(below) + share * (ndtr(above) - ndtr(below)))
        if (far := ndtr(above) < _TINY).any():
            z = np.where(far, _far(below, above, share), z)
        z = np.where(mirrored, -z, z)
        return _plain(np.clip(self.mean + self.deviation * z, self.low, self.high))


@dataclass(frozen=True)
class Correlated(Sampler):
    """mean + root z, z standard normal: normal with the covariance `root root^T`."""

    mean: Floats
    root: Floats
    finite = False

    @property
    def count(self) -> int:
        return self.mean.size

    def value(self, u: Sequence[float]) -> Any:
        z = _quantile(u)
        # Summed in the order of the elements, so that no library's way of multiplying has a say in the last digit.
        return [
            math.fsum([m, *(float(a * b) for a, b in zip(row, z, strict=True))])
            for m, row in zip(self.mean, self.root, strict=True)
        ]


def root_of(covariance: Floats) -> Floats:
    """Returns a matrix R with R R^T = covariance (n, n), which may be singular.

    Raises ValueError where it is no covariance.
    """
    if covariance.ndim != 2 or covariance.shape[0] != covariance.shape[1] or not np.isfinite(covariance).all():
        raise ValueError("expected a square matrix of finite numbers")
    if not np.allclose(covariance, covariance.T, rtol=1e-12, atol=0.0):
        raise ValueError("expected a symmetric matrix")
    values, vectors = np.linalg.eigh(covariance)
    if values[0] < -1e-12 * max(values[-1], 0.0):
        raise ValueError(f"expected no negative eigenvalue, found {values[0]:.4g}")
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)), float)


@dataclass(frozen=True)
class LogNormal(Sampler):
    """median exp(sigma z), z standard normal, element by element."""

    median: Floats
    sigma: float
    finite = False

    @property
    def count(self) -> int:
        return self.median.size

    def value(self, u: Sequence[float]) -> Any:
        return _plain(self.median * np.exp(self.sigma * _quantile(np.reshape(u, self.median.shape))))


@dataclass(frozen=True)
class Integers(Sampler):
    """A whole number from `low` to `high`, both included."""

    low: int
    high: int

    def value(self, u: Sequence[float]) -> Any:
        n = self.high - self.low + 1
        return self.low + min(int(u[0] * n), n - 1)


@dataclass(frozen=True)
class Pick(Sampler):
    """One of the values; `ends` are their summed weights, of which the last is 1."""

    values: tuple[Any, ...]
    ends: tuple[float, ...]
    axis: bool = False
    """Whether a grid goes through the values in turn."""

    def value(self, u: Sequence[float]) -> Any:
        return self.values[min(bisect_right(self.ends, u[0]), len(self.values) - 1)]


@dataclass(frozen=True)
class Rotation(Sampler):
    """A unit quaternion [q0, q1, q2, q3], scalar first, q0 >= 0, uniform over SO(3).

    K. Shoemake, Uniform random rotations, in Graphics Gems III, 1992.
    """

    @property
    def count(self) -> int:
        return 3

    def value(self, u: Sequence[float]) -> Any:
        near, far = math.sqrt(1.0 - u[0]), math.sqrt(u[0])
        a, b = 2.0 * math.pi * u[1], 2.0 * math.pi * u[2]
        q = [far * math.cos(b), near * math.sin(a), near * math.cos(a), far * math.sin(b)]
        return [-x for x in q] if q[0] < 0.0 else q


@dataclass(frozen=True)
class Sphere(Sampler):
    """A vector of some length, its direction uniform over the sphere: height and azimuth are uniform (Archimedes)."""

    length: float | Sampler

    @property
    def count(self) -> int:
        return 2 if isinstance(self.length, float) else 2 + self.length.count

    @property
    def bounded(self) -> tuple[bool, ...]:
        return (True, True, *(() if isinstance(self.length, float) else self.length.bounded))

    def value(self, u: Sequence[float]) -> Any:
        length = self.length if isinstance(self.length, float) else self.length.value(u[2:])
        z, azimuth = 2.0 * u[0] - 1.0, 2.0 * math.pi * u[1]
        level = math.sqrt(max(0.0, 1.0 - z * z))
        return [length * level * math.cos(azimuth), length * level * math.sin(azimuth), length * z]


def _plain(values: Floats) -> Any:
    """Returns a float, or a list of them."""
    return np.asarray(values, float).tolist()
