"""Makes the table of the density model: NRLMSISE-00's expansions, found from its own output.

    python -m plant.tables.density_fit

samples pymsis (version 0, NRLMSISE-00; indices given, so nothing is downloaded) at 12,000 random places, days
and activities, solves each sample for the eleven quantities of plant.atmosphere, and fits their expansions
by least squares. The expansions are those of the model itself, so what is left of the fit is the rounding
of pymsis, which counts in single precision. The only module of the plant that needs pymsis.
Tests: tests/plant/test_density.py.
"""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pymsis
from scipy.optimize import least_squares

from .. import atmosphere
from ..atmosphere import ACTIVITY, AZIMUTH, DAY, QUANTITIES, DensityModel
from ..so3 import Array
from .density import FILE, dump


def fit(samples: int = 12000, seed: int = 1) -> DensityModel:
    """Fits the model to pymsis."""
    random = np.random.default_rng(seed)
    quiet = _Samples(random, samples, ap=4.0)
    terms = _quiet_terms()
    design = _design(terms, quiet)
    measured = quiet.quantities()
    still = np.linalg.lstsq(design, measured, rcond=None)[0]
    # Ap: first the function of Ap at one place, then its distribution over the Earth.
    shape = _ap_shape()
    storm = _Samples(random, samples, ap=random.uniform(0.0, 200.0, samples))
    storm_terms = _storm_terms()
    place = _design(storm_terms, storm)
    excess = storm.quantities() - _design(terms, storm) @ still
    factor = np.array([_ap_function(storm.ap, *ab) for ab in shape.T]).T
    moved = np.column_stack(
        [np.linalg.lstsq(place * factor[:, [q]], excess[:, q], rcond=None)[0] for q in range(len(QUANTITIES))]
    )
    all_terms = np.vstack((terms, storm_terms))
    coefficients = np.vstack((still, moved))
    # Drop what does not rise above single precision's noise in any sample.
    size = np.vstack(
        (np.abs(design).max(0)[:, None] * np.abs(still), (np.abs(place)).max(0)[:, None] * np.abs(moved) * 30.0)
    )
    noise = 2e-5 * np.array((600.0, 400.0, 15.0, *[1.0] * 8))
    coefficients[size < noise] = 0.0
    kept = coefficients.any(axis=1)
    return DensityModel(all_terms[kept], coefficients[kept], shape)


class _Samples:
    """Places, days and activities, and what NRLMSISE-00 gives there."""

    def __init__(self, random: np.random.Generator, n: int, ap: float | np.ndarray) -> None:
        self.day: Array = random.integers(1, 366, n).astype(np.float64) + 0.5  # noon's season, see atmosphere.harmonics
        self.seconds = np.floor(random.uniform(0.0, 86400.0, n))
        self.latitude = np.arcsin(random.uniform(-1.0, 1.0, n))
        self.longitude = random.uniform(0.0, 2.0 * np.pi, n)
        self.f107, self.f107_average = random.uniform(60.0, 300.0, (2, n))
        self.ap = np.broadcast_to(np.asarray(ap, float), n)

    def run(self, height_km: float) -> np.ndarray:
        return run(
            self.day, self.seconds, self.latitude, self.longitude, height_km, self.f107, self.f107_average, self.ap
        )

    def quantities(self) -> np.ndarray:
        """(n, 11): T_inf from far above, the profile from 130 and 200 km, the species from 500 to 1000 km."""
        T_inf = self.run(2500.0)[:, _TEMPERATURE]
        cooler = [np.log(T_inf - self.run(height)[:, _TEMPERATURE]) for height in (130.0, 200.0)]
        zeta = [_geopotential(self.latitude, height) for height in (130.0, 200.0)]
        s = (cooler[0] - cooler[1]) / (zeta[1] - zeta[0])
        drop = np.exp(cooler[0] + s * zeta[0])
        temperatures = np.array((T_inf, T_inf - drop, s * drop))
        logarithms = np.empty((len(T_inf), len(_COLUMNS)))
        # Heavy species underflow single precision high up; O2 is out of diffusive equilibrium below.
        for height, names in ((500.0, ("N2", "Ar")), (650.0, ("O2", "O", "N", "hot O")), (1000.0, ("He", "H"))):
            out = self.run(height)
            ratio = atmosphere.profile(self.latitude, 1e3 * height, temperatures)
            for name in names:
                i = atmosphere.SPECIES.index(name)
                logarithms[:, i] = np.log(out[:, _COLUMNS[i]]) - ratio[i]
        return np.column_stack((temperatures.T, logarithms))


_COLUMNS = (1, 2, 3, 4, 5, 6, 7, 8)
"""Of N2, O2, O, He, H, Ar, N and anomalous O in pymsis's output."""
_TEMPERATURE = 10


def run(  # type: ignore[no-untyped-def]
    day, seconds, latitude, longitude, height_km, f107, f107_average, ap
) -> np.ndarray:
    """pymsis's output (n, 11) for NRLMSISE-00 on whole days of 2001, 1 to 365; angles in rad.

    With the indices given pymsis opens no connection and reads no file of indices.
    """
    n = len(day)
    dates = np.datetime64("2001-01-01", "s") + (86400 * (np.floor(day) - 1) + seconds).astype("timedelta64[s]")
    wide = [np.broadcast_to(np.asarray(x, float), n) for x in (height_km, f107, f107_average, ap)]
    return pymsis.calculate(
        dates, np.degrees(longitude), np.degrees(latitude), *wide[:3], np.tile(wide[3][:, None], 7), version=0
    ).astype(float)


def _geopotential(latitude: np.ndarray, height_km: float) -> np.ndarray:
    cos_2 = np.cos(2.0 * latitude)
    radius = 2e-5 * 980.616 * (1.0 - 0.0026373 * cos_2) / (3.085462e-6 + 2.27e-9 * cos_2)
    return (height_km - 120.0) * (radius + 120.0) / (radius + height_km)


def _design(terms: np.ndarray, at: _Samples) -> np.ndarray:
    """(samples, terms), the function of Ap left out."""
    P, azimuth, season = atmosphere.harmonics(at.latitude, at.longitude, at.day - 0.5 + at.seconds / 86400.0)
    season = _whole_days(at)
    x, y = (at.f107 - at.f107_average) / 100.0, (at.f107_average - 150.0) / 100.0
    solar = np.array((np.ones_like(x), x, x * x, y, y * y, x * y, np.ones_like(x)))
    n, m, a, d, s = terms.T
    return (P[n, m] * azimuth[a] * season[d] * solar[s]).T


def _whole_days(at: _Samples) -> np.ndarray:
    return atmosphere.harmonics(at.latitude, at.longitude, at.day)[2]


def _terms(places, azimuths, days, activities) -> list[tuple[int, ...]]:  # type: ignore[no-untyped-def]
    chosen = (
        places,
        [AZIMUTH.index(a) for a in azimuths],
        [DAY.index(d) for d in days],
        [ACTIVITY.index(s) for s in activities],
    )
    return [(*p, a, d, s) for p, a, d, s in product(*chosen)]


_ANNUAL, _SEMIANNUAL = ("cos day", "sin day"), ("cos 2day", "sin 2day")


def _quiet_terms() -> np.ndarray:
    """The terms of NRLMSISE-00 at Ap = 4, where its geomagnetic terms vanish."""
    solar = ("1", "x", "x2", "y")
    terms = _terms([(0, 0)], "1", ["1"], ("x", "x2", "y", "y2", "xy"))
    terms += _terms([(n, 0) for n in range(7)], "1", ["1"], ["1"]) + _terms([(2, 0)], "1", ["1"], "y")
    terms += _terms([(0, 0)], "1", _ANNUAL, "1") + _terms([(0, 0), (2, 0), (1, 0)], "1", _SEMIANNUAL, "1")
    terms += _terms([(1, 0), (3, 0)], "1", _ANNUAL, solar)
    for m, fixed, annual in ((1, (1, 3, 5), (2,)), (2, (2, 4), (3, 5)), (3, (3,), (4, 6))):
        wave = (AZIMUTH[2 * m - 1], AZIMUTH[2 * m])
        terms += _terms([(n, m) for n in fixed], wave, ["1"], solar)
        terms += _terms([(n, m) for n in annual], wave, _ANNUAL, solar)
    longitude, universal = ("cos lon", "sin lon"), ("cos UT", "sin UT")
    terms += _terms([(n, 1) for n in range(1, 7)], longitude, ["1"], "1y")
    terms += _terms([(n, 1) for n in (1, 3, 5)], longitude, _ANNUAL, "1y")
    terms += _terms([(n, 0) for n in range(7)], universal, ["1"], "1y")
    terms += _terms([(n, 0) for n in range(8)], universal, _ANNUAL, "1y")
    terms += _terms([(n, 2) for n in (3, 5, 7)], ("cos(UT+2lon)", "sin(UT+2lon)"), ["1"], "1y")
    return np.array(terms)


def _storm_terms() -> np.ndarray:
    """The geomagnetic terms of NRLMSISE-00 with the daily Ap."""
    longitude = ("cos lon", "sin lon")
    terms = _terms([(0, 0), (2, 0), (4, 0)], "1", ["1"], ["ap"])
    terms += _terms([(1, 0), (3, 0), (5, 0)], "1", _ANNUAL, ["ap"])
    terms += _terms([(1, 1), (3, 1), (5, 1)], ("cos LT", "sin LT"), ["1"], ["ap"])
    terms += _terms([(n, 1) for n in range(1, 8)], longitude, ["1"], ["ap"])
    terms += _terms([(n, 1) for n in (1, 3, 5)], longitude, _ANNUAL, ["ap"])
    terms += _terms([(1, 0), (3, 0), (5, 0)], ("cos UT", "sin UT"), ["1"], ["ap"])
    return np.array(terms)


def _ap_function(ap: np.ndarray, a: float, b: float) -> np.ndarray:
    d = ap - 4.0
    return d + (b - 1.0) * (d + np.expm1(-a * d) / a)


def _ap_shape() -> np.ndarray:
    """a and b (2, 11) of each quantity's function of Ap, from its course at one place."""
    n = 101
    at = _Samples(np.random.default_rng(0), n, ap=np.linspace(0.0, 200.0, n))
    for array, value in zip(
        (at.day, at.seconds, at.latitude, at.longitude, at.f107, at.f107_average),
        (80.5, 43200.0, 1.1, 1.0, 150.0, 150.0),
        strict=True,
    ):
        array[:] = value
    values = at.quantities()
    change = values - values[2]
    shapes = []
    for q in range(len(QUANTITIES)):
        if np.abs(change[:, q]).max() < 1e-4 * max(1.0, np.abs(values[:, q]).max()):
            shapes.append((0.01, 1.0))
            continue
        scale = change[-1, q]

        def misfit(parameters: np.ndarray, q: int = q, scale: float = scale) -> np.ndarray:
            a, b, c = parameters
            return c * _ap_function(at.ap, np.exp(a), b) / 100.0 - change[:, q] / scale

        found = least_squares(misfit, (-4.0, 0.3, 1.0), xtol=1e-14, ftol=1e-14, gtol=1e-14)
        shapes.append((float(np.exp(found.x[0])), float(found.x[1])))
    return np.array(shapes).T


if __name__ == "__main__":
    Path(__file__).with_name(FILE).write_bytes(dump(fit()))
