"""The geomagnetic field against pygeomag and ppigrf, which evaluate it in spherical harmonics of their own."""

from __future__ import annotations

import math
from datetime import datetime, timedelta
from functools import cache
from importlib.metadata import version

import numpy as np
import ppigrf
import pygeomag

import plant
from plant import tables
from plant.geomagnetic import Field
from tests.authorities.registry import authority
from tests.plant.motion import checked, command

FILES = {
    "wmm2010": ("wmm/WMM_2010.COF", 2010.0),
    "wmm2015": ("wmm/WMM_2015v2.COF", 2015.0),
    "wmm2020": ("wmm/WMM_2020.COF", 2020.0),
    "wmm2025": ("wmm/WMM_2025.COF", 2025.0),
}
PYGEOMAG = f"pygeomag {version('pygeomag')}"


def earth_fixed(latitude: float, longitude: float, height: float) -> np.ndarray:
    """Position, m, of geodetic coordinates, rad and m, on WGS 84 (NIMA TR8350.2, 4-14)."""
    a, b = 6378137.0, 6356752.314245
    N = a * a / math.hypot(a * math.cos(latitude), b * math.sin(latitude))
    horizontal = (N + height) * math.cos(latitude)
    return np.array(
        [
            horizontal * math.cos(longitude),
            horizontal * math.sin(longitude),
            (b * b / (a * a) * N + height) * math.sin(latitude),
        ]
    )


def north_east_down(latitude: float, longitude: float) -> np.ndarray:
    """Columns: the unit vectors in Earth-fixed components; geodetic or geocentric as the latitude is."""
    sp, cp, sl, cl = math.sin(latitude), math.cos(latitude), math.sin(longitude), math.cos(longitude)
    return np.array([[-sp * cl, -sl, -cp * cl], [-sp * sl, cl, -cp * sl], [cp, 0.0, -sp]])


def places(count: int, seed: int):
    """Random latitude, longitude, rad, height, m, and years since the epoch; the poles' and the datum's neighbourhood
    too."""
    rng = np.random.default_rng(seed)
    for i in range(count):
        latitude = math.asin(rng.uniform(-1.0, 1.0)) if i > 3 else (-1) ** i * math.radians(89.99 if i < 2 else 1e-3)
        yield latitude, rng.uniform(-math.pi, math.pi), rng.uniform(0.0, 2000e3), rng.uniform(0.0, 5.0)


@cache
def against_pygeomag(model: str) -> float:
    """Largest difference of a component, nT, at 60 random places and dates."""
    file, first = FILES[model]
    reference = pygeomag.GeoMag(coefficients_file=file)
    worst = 0.0
    for latitude, longitude, height, years in places(60, seed=int(first)):
        year = round(first + years * 0.999, 3)
        theirs = reference.calculate(math.degrees(latitude), math.degrees(longitude), height / 1e3, year)
        ours = Field(*tables.field_model(model).at(year), 12).at(earth_fixed(latitude, longitude, height))
        ned = north_east_down(latitude, longitude).T @ ours * 1e9
        worst = max(worst, float(np.abs(ned - [theirs.x, theirs.y, theirs.z]).max()))
    return worst


def _register(model: str) -> None:
    def measure() -> float:
        return against_pygeomag(model)

    measure.__name__ = f"field_{model}"
    authority(
        "Field",
        f"{model.upper()[:3]} {model[3:]}, 60 random places to 2000 km and dates: largest component's difference",
        source=PYGEOMAG,
        unit="nT",
        tolerance=0.1,
    )(measure)


for _model in FILES:
    _register(_model)


def year_of(date: datetime) -> float:
    """The decimal year: the fraction of this year elapsed."""
    start = datetime(date.year, 1, 1)
    return date.year + (date - start) / (datetime(date.year + 1, 1, 1) - start)


def year_as_ppigrf_counts(date: datetime) -> float:
    """ppigrf interpolates by days between epochs five years apart, leap days included: up to 0.25 nT from counting
    years."""
    first = 5 * (date.year // 5)
    start = datetime(first, 1, 1)
    return first + 5.0 * ((date - start) / (datetime(first + 5, 1, 1) - start))


@authority(
    "Field",
    "IGRF-14, 60 random places to 2000 km and dates, 1905 to 2029: largest component's difference",
    source=f"ppigrf {version('ppigrf')}",
    unit="nT",
    tolerance=0.1,
)
@cache
def field_igrf14() -> float:
    rng = np.random.default_rng(14)
    worst = 0.0
    for latitude, longitude, height, _ in places(60, seed=14):
        date = datetime(1905, 1, 1) + timedelta(days=float(rng.uniform(0.0, 124.0 * 365.25)))
        east, north, up = (
            float(np.squeeze(c))
            for c in ppigrf.igrf(math.degrees(longitude), math.degrees(latitude), height / 1e3, date)
        )
        ours = Field(*tables.field_model("igrf14").at(year_as_ppigrf_counts(date)), 13).at(
            earth_fixed(latitude, longitude, height)
        )
        ned = north_east_down(latitude, longitude).T @ ours * 1e9
        worst = max(worst, float(np.abs(ned - [north, east, -up]).max()))
    return worst


def sidereal(date: datetime) -> float:
    """GMST, rad, by the linear form of the USNO (Astronomical Almanac; 0.1 s over the century)."""
    days = (date - datetime(2000, 1, 1, 12)) / timedelta(days=1)
    return math.radians((280.46061837 + 360.98564736629 * days) % 360.0)


@authority(
    "Field",
    "The plant's b_B along an orbit in 2012, through sidereal time, geodetic coordinates and attitude: largest "
    "difference",
    source=f"{PYGEOMAG}, GMST of the Astronomical Almanac",
    unit="nT",
    tolerance=0.1,
)
@cache
def field_at_the_satellite() -> float:
    epoch = datetime(2012, 6, 20, 7, 30)
    p = checked(
        field_model="wmm2010",
        field_degree=12,
        epoch="2012-06-20T07:30:00Z",
        omega_B0=[0.01, -0.02, 0.015],
        step_max=2.0,
    )
    reference = pygeomag.GeoMag(coefficients_file="wmm/WMM_2010.COF")
    x, worst = plant.start(p, command()), 0.0
    for i in range(12):
        y = plant.outputs(x, command(), p)
        theta = sidereal(epoch + timedelta(seconds=i * 97.3))
        turn = np.array(
            [[math.cos(theta), -math.sin(theta), 0.0], [math.sin(theta), math.cos(theta), 0.0], [0.0, 0.0, 1.0]]
        )
        latitude, longitude, height = geodetic_by_search(turn.T @ y.r_N)
        year = year_of(epoch)  # the plant's field is that of the epoch
        theirs = reference.calculate(math.degrees(latitude), math.degrees(longitude), height / 1e3, year)
        b_N = turn @ north_east_down(latitude, longitude) @ [theirs.x, theirs.y, theirs.z]
        worst = max(worst, float(np.abs(y.b_B * 1e9 - y.R_NB.T @ b_N).max()))
        x, _ = plant.step(x, command(), p, 97.3)
    return worst


def geodetic_by_search(r: np.ndarray) -> tuple[float, float, float]:
    """Inverse of `earth_fixed` by SciPy's root finder."""
    from scipy.optimize import fsolve

    longitude, radius = math.atan2(r[1], r[0]), float(np.linalg.norm(r))
    start = [math.asin(r[2] / radius), (radius - 6.37e6) / 1e6]
    latitude, height = fsolve(
        lambda q: (
            (earth_fixed(q[0], longitude, q[1] * 1e6) - r)[[2, 0]] / 1e6
            if abs(r[0]) > abs(r[1])
            else (earth_fixed(q[0], longitude, q[1] * 1e6) - r)[[2, 1]] / 1e6
        ),
        start,
        xtol=1e-13,
    )
    return float(latitude), longitude, float(height * 1e6)


@authority(
    "Field",
    "Interpolation between nodes 10 s apart, 400 random times on orbits of 300, 600 and 1500 km: largest "
    "difference from the model",
    source="the model itself",
    unit="nT",
    tolerance=1e-3,
)
@cache
def interpolation() -> float:
    worst = 0.0
    for radius in (6671e3, 6971e3, 7871e3):
        field = checked(orbit_radius=radius, inclination=1.5).field
        for t in np.random.default_rng(5).uniform(-100.0, 6000.0, 134):
            worst = max(worst, float(np.abs(field.at(t) - field.exact(t)).max()) * 1e9)
    return worst
