"""The onboard model of the geomagnetic field: spherical harmonics at one date.
Tests: tests/estimator/test_estimator.py."""

from __future__ import annotations

import math

import numpy as np

from .onboard import EARTH_RATE
from .so3 import Array
from .tables import GaussModel

RADIUS = 6371200.0
"""m, of the field models."""
POLE = 1e-7
"""Of r: nearer to the axis the longitude is taken as zero."""


class OnboardField:
    """The field at a date, up to a degree.

    g and h (degree + 1, degree + 1), T, Schmidt semi-normalised, by degree n and order m. The Schmidt functions follow
    by recursion over n, all orders at once: P_nm = a_nm c P_(n-1)m - b_nm P_(n-2)m.
    """

    def __init__(self, model: GaussModel, year: float, degree: int, error: Array, sidereal_angle: float) -> None:
        """`error` (3,), T, is added to g10, g11, h11; `sidereal_angle`, rad, is that of Greenwich at t = 0."""
        g, h = model.at(year)
        size = degree + 1
        self.degree, self.sidereal_angle = degree, sidereal_angle
        self.g, self.h = 1e-9 * g[:size, :size], 1e-9 * h[:size, :size]
        self.g[1, 0] += error[0]
        self.g[1, 1] += error[1]
        self.h[1, 1] += error[2]
        n, m = np.arange(size)[:, None], np.arange(size)
        root = np.sqrt(np.where(m < n, n * n - m * m, 1))
        self.a = np.where(m < n, (2 * n - 1) / root, 0.0)
        self.b = np.where(m < n - 1, np.sqrt(np.maximum((n - 1) ** 2 - m * m, 0)) / root, 0.0)
        self.order = m

    def at(self, t: float, r_N: Array) -> Array:
        """B_N (3,), T, at t, s, after the epoch and r_N (3,), m."""
        angle = self.sidereal_angle + EARTH_RATE * t
        ca, sa = math.cos(angle), math.sin(angle)
        X, Y, Z = r_N.tolist()
        x, y, r = ca * X + sa * Y, ca * Y - sa * X, math.sqrt(X * X + Y * Y + Z * Z)
        from_axis = math.hypot(x, y)
        rho = max(from_axis, POLE * r)
        c, s = Z / r, rho / r  # of the colatitude
        longitude = math.atan2(y, x) if from_axis == rho else 0.0
        P, dP = self._functions(c, s)
        cm, sm = np.cos(self.order * longitude), np.sin(self.order * longitude)
        power = (RADIUS / r) ** (np.arange(self.degree + 1) + 2)
        along = self.g * cm + self.h * sm
        up = float(power * (np.arange(self.degree + 1) + 1) @ (along * P).sum(axis=1))
        south = -float(power @ (along * dP).sum(axis=1))
        east = float(power @ (self.order * (self.g * sm - self.h * cm) * P).sum(axis=1)) / s
        outward, cl, sl = up * s + south * c, math.cos(longitude), math.sin(longitude)
        bx, by = outward * cl - east * sl, outward * sl + east * cl
        return np.array((ca * bx - sa * by, sa * bx + ca * by, up * c - south * s))

    def _functions(self, c: float, s: float) -> tuple[Array, Array]:
        """Schmidt functions of the colatitude and their derivatives, by degree and order."""
        P, dP = np.zeros((2, self.degree + 1, self.degree + 1))
        P[0, 0] = 1.0
        for n in range(1, self.degree + 1):
            below, dbelow = (P[n - 2], dP[n - 2]) if n > 1 else (np.zeros_like(P[0]), np.zeros_like(P[0]))
            P[n] = self.a[n] * c * P[n - 1] - self.b[n] * below
            dP[n] = self.a[n] * (c * dP[n - 1] - s * P[n - 1]) - self.b[n] * dbelow
            d = math.sqrt((2 * n - 1) / (2 * n)) if n > 1 else 1.0
            P[n, n] = d * s * P[n - 1, n - 1]
            dP[n, n] = d * (s * dP[n - 1, n - 1] + c * P[n - 1, n - 1])
        P[0, 0] = 0.0  # no monopole
        return P, dP
