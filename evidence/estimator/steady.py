"""The steady state of attitude and gyro bias under a star tracker: the filter's covariance and Farrenkopf's closed
form.

Farrenkopf, Analytic steady-state accuracy solutions for two common spacecraft attitude estimators, JGC 1 (1978); in
the form of Markley and Crassidis, Fundamentals of Spacecraft Attitude Determination and Control, 6.4: for one axis,
gyro and star tracker. Tests: tests/estimator/test_estimator.py.
"""

from __future__ import annotations

import math

import numpy as np

from estimator.filter import Innovation, corrected, propagated

CASES = ((5e-5, 4.4e-5, 3e-7, 0.5), (5e-5, 6e-6, 1e-8, 0.5), (3e-4, 1e-5, 1e-6, 2.0), (1e-3, 1e-4, 1e-7, 10.0))
"""Noise of the star tracker, rad; angle and rate random walk, rad and rad/s in 1 s; time between attitudes, s."""


def closed_form(sigma: float, angle_walk: float, rate_walk: float, T: float) -> tuple[float, float]:
    """Standard deviation of the attitude before and after a measurement, rad."""
    u, v = rate_walk * T**1.5 / sigma, angle_walk * math.sqrt(T) / sigma
    gamma = math.sqrt(1.0 + 0.25 * v * v + u * u / 48.0)
    zeta = gamma + 0.25 * u + 0.5 * math.sqrt(2.0 * gamma * u + v * v + u * u / 3.0)
    return sigma * math.sqrt(zeta * zeta - 1.0), sigma * math.sqrt(1.0 - zeta**-2)


def of_filter(sigma: float, angle_walk: float, rate_walk: float, T: float, updates: int = 4000) -> tuple[float, float]:
    """The same of the filter's covariance after so many updates from far off, at rest."""
    P = np.diag(np.repeat([1e-2, 1e-6, 0.0], 3))
    eye, zero = np.eye(3), np.zeros((3, 3))
    before = 0.0
    for _ in range(updates):
        P = propagated(P, np.zeros(3), T, -1.0, zero, rate_walk**2 * eye, angle_walk, 0.0, zero, 1.0)[0]
        before = math.sqrt(P[0, 0])
        P = corrected(P, Innovation(np.zeros(3), eye, zero, np.full(3, sigma * sigma)))[1]
    return before, math.sqrt(P[0, 0])
