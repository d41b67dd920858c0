"""The geomagnetic field of a spherical-harmonic model.

With V + iW = (a/r)^(n+1) P_nm(sin phi) exp(i m lambda) and the potential a sum(g V + h W), the field
is B = -grad. The solid harmonics come from Cunningham's recursion in Cartesian, Earth-fixed,
geocentric components, so nothing is singular at the poles (Montenbruck and Gill, Satellite Orbits,
section 3.2). The models' coefficients are Schmidt semi-normalised and are brought to the
recursion's normalisation once. Tests: tests/plant/test_field.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .along_orbit import AlongOrbit
from .orbit import Orbit, earth_fixed
from .so3 import Array

REFERENCE_RADIUS = 6371200.0
"""a of every WMM and IGRF model, m (geocentric)."""


@dataclass(frozen=True)
class FieldModel:
    """A field model: coefficient sets at one or more epochs, linear in time between, secular variation after.

    g, h (epochs, degree + 1, degree + 1) nT, Schmidt semi-normalised, [.., n, m]; g_dot, h_dot (degree + 1,
    degree + 1) nT/year from the last epoch on.
    """

    name: str
    epochs: tuple[float, ...]
    valid_until: float
    g: Array
    h: Array
    g_dot: Array
    h_dot: Array

    def covers(self, year: float) -> bool:
        """Returns whether a decimal year lies within the model's years."""
        return self.epochs[0] <= year <= self.valid_until

    def at(self, year: float, extrapolate: bool = False) -> tuple[Array, Array]:
        """g and h at a decimal year. Raises ValueError where the model does not cover it, unless told to
        extrapolate."""
        first = self.epochs[0]
        if not (self.covers(year) or extrapolate):
            raise ValueError(
                f"epoch: expected {first:.1f} to {self.valid_until:.1f}, which field_model {self.name!r} covers "
                f"(or another model, or field_extrapolate), found {year:.3f}"
            )
        last = len(self.epochs) - 1
        if year >= self.epochs[last] or last == 0:
            elapsed = year - self.epochs[last]
            return self.g[last] + elapsed * self.g_dot, self.h[last] + elapsed * self.h_dot
        i = max(k for k, epoch in enumerate(self.epochs[:-1]) if epoch <= max(year, first))
        share = (year - self.epochs[i]) / (self.epochs[i + 1] - self.epochs[i])
        return self.g[i] + share * (self.g[i + 1] - self.g[i]), self.h[i] + share * (self.h[i + 1] - self.h[i])


class Field:
    """The field at one date, to a given degree."""

    def __init__(self, g: Array, h: Array, degree: int) -> None:
        """g, h (>= degree + 1, >= degree + 1), nT, Schmidt semi-normalised."""
        self.degree = degree
        n = np.arange(degree + 1)
        # Schmidt to unnormalised: sqrt((2 - delta_m0) (n - m)!/(n + m)!); nT to T.
        scale = np.zeros((degree + 1, degree + 1))
        for i in range(1, degree + 1):
            for m in range(i + 1):
                scale[i, m] = 1e-9 * math.sqrt((1 if m == 0 else 2) * math.factorial(i - m) / math.factorial(i + m))
        self._c = scale * (g - 1j * h)[: degree + 1, : degree + 1]  # Re(c (V + iW)) = g V + h W
        self._raise = (n[:, None] - n + 2.0) * (n[:, None] - n + 1.0)
        self._vertical = n[:, None] - n + 1.0

    def at(self, position: Array) -> Array:
        """B (3,), T, at a position (3,), m; both in Earth-fixed geocentric Cartesian components."""
        N = self.degree + 1
        r2 = float(position @ position)
        if r2 == 0.0:
            raise ValueError("the geomagnetic field is not defined at the centre of the Earth")
        x, y, z = (position * (REFERENCE_RADIUS / r2)).tolist()
        rho2 = REFERENCE_RADIUS**2 / r2
        Z = np.zeros((N + 1, N + 1), complex)
        Z[0, 0] = math.sqrt(rho2)
        for m in range(N + 1):
            if m:
                Z[m, m] = (2 * m - 1) * complex(x, y) * Z[m - 1, m - 1]
            if m < N:
                Z[m + 1, m] = (2 * m + 1) * z * Z[m, m]
            for n in range(m + 2, N + 1):
                Z[n, m] = ((2 * n - 1) * z * Z[n - 1, m] - (n + m - 1) * rho2 * Z[n - 2, m]) / (n - m)
        above = Z[1:, :-1]  # [n, m] holds V_(n+1),m + i W_(n+1),m
        right = Z[1:, 1:]  # (n+1), (m+1)
        left = self._raise[:, 1:] * Z[1:, :-2]  # (n+1), (m-1), for m >= 1
        c = self._c
        B_z = float((self._vertical * (c * above).real).sum())
        up = c * right
        down = c[:, 1:] * left
        # For m = 0 there is no lower term, and its share of the upper one counts twice.
        B_x = 0.5 * float(up.real.sum() + up[:, 0].real.sum() - down.real.sum())
        B_y = 0.5 * float(up.imag.sum() + up[:, 0].imag.sum() + down.imag.sum())
        return np.array((B_x, B_y, B_z))


class FieldAlongOrbit(AlongOrbit):
    """B_N along an orbit as a function of time alone.

    Against the model itself the interpolation errs by less than 1e-3 nT on a low orbit, below the
    models' own resolution of 0.1 nT.
    """

    def __init__(self, field: Field, orbit: Orbit, gmst0: float) -> None:
        super().__init__()
        self._field, self._orbit, self._gmst0 = field, orbit, gmst0

    def exact(self, t: float) -> Array:
        """B_N (3,), T, at time t, s, from the model itself."""
        to_N = earth_fixed(t, self._gmst0)
        r, _ = self._orbit.position_velocity(t)
        return to_N @ self._field.at(to_N.T @ r)
