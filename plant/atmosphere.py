"""Density of the upper atmosphere: NRLMSISE-00 above 150 km, from tabulated expansions.

Above the turbopause each species of NRLMSISE-00 is in diffusive equilibrium on a Bates profile of
temperature (Walker, J. Atmos. Sci. 22, 1965). So eleven quantities describe a place: three of its
temperature profile and the logarithms of eight species' densities at 120 km. Each is an expansion in

    P_nm(sin latitude) x (local time, longitude, universal time) x (day of the year) x (solar activity)

whose coefficients are tabulated (plant.tables.density); height enters in closed form. Nothing is
interpolated in height. The expansions are those of the model itself, so above 500 km what is left is rounding.
Picone, Hedin, Drob and Aikin, J. Geophys. Res. 107(A12), 2002. Tests: tests/plant/test_density.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .along_orbit import AlongOrbit
from .orbit import Orbit, earth_fixed, geodetic
from .so3 import Array
from .time_scales import EARTH_RATE

LOWEST, HIGHEST = 150e3, 2000e3
"""Heights, m, between which the density is given; below, mixing and chemistry end the diffusive equilibrium."""

TEMPERATURES = ("exospheric temperature", "temperature at 120 km", "temperature gradient")
"""K, K, K/km: T = T_inf - (T_inf - T_120) exp(-s zeta), the gradient being s (T_inf - T_120)."""
SPECIES = ("N2", "O2", "O", "He", "H", "Ar", "N", "hot O")
"""ln of the density at 120 km, 1/m3. Hot ("anomalous") oxygen has its own temperature and profile."""
QUANTITIES = TEMPERATURES + SPECIES

AZIMUTH = (
    "1",
    "cos LT",
    "sin LT",
    "cos 2LT",
    "sin 2LT",
    "cos 3LT",
    "sin 3LT",
    "cos lon",
    "sin lon",
    "cos UT",
    "sin UT",
    "cos(UT+2lon)",
    "sin(UT+2lon)",
)
"""LT: local mean solar time as an angle, lon: longitude, UT: universal time as an angle."""
DAY = ("1", "cos day", "sin day", "cos 2day", "sin 2day")
"""day: 2 pi day/365."""
ACTIVITY = ("1", "x", "x2", "y", "y2", "xy", "ap")
"""x = (F10.7 - its 81-day mean)/100, y = (81-day mean - 150)/100, ap: `DensityModel.ap_shape`'s function."""
DEGREE, ORDER = 7, 3

Places = float | Array
"""A value, or an array of values at several places."""

_MASSES = np.array((28.0, 32.0, 16.0, 4.0, 1.0, 40.0, 14.0, 16.0))
_THERMAL_DIFFUSION = np.array((0.0, 0.0, 0.0, -0.38, -0.38, 0.17, 0.0))
_AMU = 1.66e-27
_GAS_CONSTANT = 831.4
"""1e-2 J/(mol K), for gravity in cm/s2, masses in g/mol and heights in km, as NRLMSISE-00 has them."""
_BASE = 120.0
_HOT_TEMPERATURE, _HOT_BASE, _HOT_SCALE = 4000.0, 550.0, 76.0
"""K, km, km: profile of hot oxygen."""


@dataclass(frozen=True)
class DensityModel:
    """The table. Row k of `terms` (K, 5) names a term by n, m and its places in AZIMUTH, DAY and ACTIVITY.

    coefficients (K, 11) belong to QUANTITIES. ap_shape (2, 11) holds a, b of the function of Ap,
    d + (b - 1)(d + (exp(-a d) - 1)/a) with d = Ap - 4.
    """

    terms: np.ndarray
    coefficients: Array
    ap_shape: Array


class Atmosphere:
    """The atmosphere at given solar and geomagnetic activity."""

    def __init__(self, model: DensityModel, f107: float, f107_average: float, ap: float) -> None:
        """f107 of the day before, f107_average over 81 days, both 1e-22 W/(m2 Hz); ap the day's mean."""
        factors = activity(f107, f107_average, ap, model.ap_shape)
        weighted = model.coefficients * factors[model.terms[:, 4]]
        places, row = np.unique(model.terms[:, :4], axis=0, return_inverse=True)
        self._terms = places.T
        self._coefficients = np.zeros((len(places), len(QUANTITIES)))
        np.add.at(self._coefficients, row.ravel(), weighted)

    def density(self, latitude: float, longitude: float, height: float, day: float) -> float:
        """Mass density, kg/m3, hot oxygen included, as it acts on a satellite.

        Geodetic latitude and longitude, rad; height m, within LOWEST and HIGHEST; day: day of the year,
        UTC, 1.0 at the start of 1 January, not wrapped at its end.
        """
        n, m, azimuth, season = self._terms
        P, waves, seasons = harmonics(latitude, longitude, day)
        values = (P[n, m] * waves[azimuth] * seasons[season]) @ self._coefficients
        logarithms = values[3:] + profile(latitude, height, values[:3])
        return _AMU * float(_MASSES @ np.exp(logarithms))


class AirAlongOrbit(AlongOrbit):
    """The air along an orbit: its density, and the satellite's velocity relative to it."""

    def __init__(self, atmosphere: Atmosphere, orbit: Orbit, gmst0: float, day0: float) -> None:
        """gmst0, rad, and day0, the day of the year (1.0 at its start), at t = 0."""
        super().__init__()
        self._atmosphere, self._orbit, self._gmst0, self._day0 = atmosphere, orbit, gmst0, day0

    def flow(self, t: float) -> tuple[Array, float]:
        """v_N - omega_earth x r_N (3,), m/s, and the density, kg/m3, at time t, s: the air turns with the Earth."""
        values = self.at(t)
        return values[:3], math.exp(values[3])

    def exact(self, t: float) -> Array:
        """(4,): the velocity relative to the air, m/s, and ln of the density, kg/m3."""
        r, v = self._orbit.position_velocity(t)
        place = geodetic(earth_fixed(t, self._gmst0).T @ r)
        density = self._atmosphere.density(*place, self._day0 + t / 86400.0)
        return np.array((v[0] + EARTH_RATE * r[1], v[1] - EARTH_RATE * r[0], v[2], math.log(density)))


def activity(f107: float, f107_average: float, ap: float, ap_shape: Array) -> Array:
    """The factors ACTIVITY, (7, 11): one column for each quantity, since Ap acts differently on each."""
    x, y = (f107 - f107_average) / 100.0, (f107_average - 150.0) / 100.0
    common = np.array((1.0, x, x * x, y, y * y, x * y))
    a, b = ap_shape
    d = ap - 4.0
    return np.vstack((np.tile(common[:, None], len(QUANTITIES)), d + (b - 1.0) * (d + np.expm1(-a * d) / a)))


def harmonics(latitude: Places, longitude: Places, day: Places) -> tuple[Array, Array, Array]:
    """P_nm (8, 4, ...), AZIMUTH (13, ...) and DAY (5, ...) at places and days (...): floats or arrays of one shape."""
    universal = 2.0 * np.pi * (day % 1.0)
    local = universal + longitude
    cs = [(np.cos(k * local), np.sin(k * local)) for k in (1, 2, 3)]
    cs += [(np.cos(x), np.sin(x)) for x in (longitude, universal, universal + 2.0 * longitude)]
    one = np.ones_like(local)
    # NRLMSISE-00 takes the date's whole number; noon's value is kept and the rest is made continuous.
    year = (2.0 * np.pi / 365.0) * (day - 0.5)
    season = np.array([one, np.cos(year), np.sin(year), np.cos(2.0 * year), np.sin(2.0 * year)])
    return legendre(latitude), np.array([one, *(f for pair in cs for f in pair)]), season


def legendre(latitude: Places) -> Array:
    """P_nm(sin latitude) (8, 4, ...), unnormalised, without Condon and Shortley's sign."""
    s, c = np.sin(latitude), np.cos(latitude)
    P = np.zeros((DEGREE + 1, ORDER + 1, *np.shape(latitude)))
    P[0, 0] = 1.0
    for m in range(ORDER + 1):
        if m:
            P[m, m] = (2 * m - 1) * c * P[m - 1, m - 1]
        P[m + 1, m] = (2 * m + 1) * s * P[m, m]
        for n in range(m + 2, DEGREE + 1):
            P[n, m] = ((2 * n - 1) * s * P[n - 1, m] - (n + m - 1) * P[n - 2, m]) / (n - m)
    return P


def profile(latitude: Places, height: Places, temperatures: Array) -> Array:
    """ln of each species' density over that at 120 km, (8, ...), at a height, m, from TEMPERATURES (3, ...)."""
    T_inf, T_base, gradient = temperatures
    z = 1e-3 * height
    cos_2 = np.cos(2.0 * latitude)
    surface_gravity = 980.616 * (1.0 - 0.0026373 * cos_2)  # cm/s2
    radius = 2e-5 * surface_gravity / (3.085462e-6 + 2.27e-9 * cos_2)  # km
    gravity = surface_gravity / (1.0 + _BASE / radius) ** 2
    zeta = (z - _BASE) * (radius + _BASE) / (radius + z)  # geopotential height above 120 km
    s = gradient / (T_inf - T_base)
    cooling = np.log(T_base / (T_inf - (T_inf - T_base) * np.exp(-s * zeta)))
    gamma = np.multiply.outer(_MASSES[:7], gravity / (s * _GAS_CONSTANT * T_inf))
    thermal_diffusion = np.multiply.outer(_THERMAL_DIFFUSION, cooling)
    species = (1.0 + gamma) * cooling + thermal_diffusion - gamma * (s * zeta)
    weight = 16.0 / (_GAS_CONSTANT * _HOT_TEMPERATURE)
    gravity_hot = surface_gravity / (1.0 + _HOT_BASE / radius) ** 2
    decay = _HOT_SCALE * gravity_hot * np.expm1(-(z - _HOT_BASE) / _HOT_SCALE)
    hot = -weight * (gravity * zeta + decay)
    return np.concatenate((species, [hot]))
