"""The Sun and eclipses against astropy: its Sun by ERFA's ephemeris, and straight rays past the ellipsoid to the Sun's
rim.

Nothing is downloaded: the ephemeris is built in, and UT1 has no say in what is compared.
"""

from __future__ import annotations

import math
from datetime import UTC, datetime, timedelta

import numpy as np

from plant import sun
from plant.time_scales import days_since_j2000
from tests.authorities.registry import authority
from tests.plant.motion import checked

EQUATOR, POLE = 6378137.0, 6356752.314245
"""m (NIMA TR8350.2, WGS 84)"""
RIM = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
ORBITS = (
    {"epoch": "2009-08-10T00:00:00Z"},
    {"epoch": "2026-03-20T15:00:00Z", "inclination": 0.9, "node_longitude": 1.0},
    {"epoch": "2024-12-21T09:00:00Z", "inclination": 1.7, "node_longitude": -0.4, "orbit_radius": 7.2e6},
)


def astropy_sun(dates: list[datetime]) -> np.ndarray:
    """Apparent positions of the Sun (n,3), m, in N: of the true pole and the mean equinox of date."""
    # Heavy, and optional: the command and the tests leave these comparisons out where astropy is not installed.
    import erfa
    from astropy.coordinates import get_sun
    from astropy.time import Time

    times = Time([date.replace(tzinfo=None) for date in dates], scale="utc")
    tt = times.tt
    gcrs = get_sun(times).cartesian.xyz.to_value("m").T
    place = np.einsum("nij,nj->ni", erfa.pnm06a(tt.jd1, tt.jd2), gcrs)  # to the true equator and equinox of date
    equinoxes = np.asarray(erfa.ee06a(tt.jd1, tt.jd2))
    c, s = np.cos(equinoxes), np.sin(equinoxes)
    return np.column_stack((c * place[:, 0] + s * place[:, 1], c * place[:, 1] - s * place[:, 0], place[:, 2]))


@authority(
    "Sun",
    "Apparent direction from the Earth's centre, 400 dates from 1975 to 2026: largest difference",
    source="astropy, get_sun",
    needs="astropy:astropy",
    tolerance=0.005,
    unit="deg",
)
def sun_direction() -> float:
    dates = [datetime(1975, 1, 1, tzinfo=UTC) + timedelta(days=47.3 * i) for i in range(400)]
    worst = 0.0
    for date, theirs in zip(dates, astropy_sun(dates), strict=True):
        ours = np.array(sun.Sun(days_since_j2000(date)).at(0.0))
        sine = np.linalg.norm(np.cross(ours, theirs)) / np.linalg.norm(ours) / np.linalg.norm(theirs)
        worst = max(worst, math.degrees(math.asin(sine)))
    return worst


def rim_blocked(r_N: np.ndarray, S_N: np.ndarray) -> int:
    """To how many of 720 points on the Sun's rim the straight ray meets the ellipsoid."""
    towards = (S_N - r_N) / np.linalg.norm(S_N - r_N)
    u = np.cross(towards, [0.3, 0.5, 0.8])
    u /= np.linalg.norm(u)
    v = np.cross(towards, u)
    ends = S_N + 695.7e6 * (np.cos(RIM)[:, None] * u + np.sin(RIM)[:, None] * v)
    axes = np.array([EQUATOR, EQUATOR, POLE])
    o, d = r_N / axes, (ends - r_N) / axes
    od, dd = d @ o, (d * d).sum(axis=1)
    return int(((od < 0.0) & (od * od > dd * (o @ o - 1.0))).sum())


@authority(
    "Sun",
    "Instants at which penumbra and umbra begin and end, three orbits: largest difference",
    source="astropy's Sun, rays past WGS 84 to its rim",
    needs="astropy:astropy",
    tolerance=1.0,
    unit="s",
)
def eclipse_instants() -> float:
    worst, compared = 0.0, 0
    for orbit in ORBITS:
        p = checked(**orbit)
        epoch = datetime.fromisoformat(p.epoch)
        period = 2.0 * math.pi / p.orbit.mean_motion
        ends = astropy_sun([epoch, epoch + timedelta(seconds=period)])

        def r(t: float, p=p) -> np.ndarray:
            return p.orbit.position_velocity(t)[0]

        def theirs(t: float, r=r, ends=ends, period=period) -> int:
            return rim_blocked(r(t), ends[0] + t / period * (ends[1] - ends[0]))

        def ours(t: float, r=r, p=p) -> float:
            return sun.seen_from(r(t), p.sun.at(t))[1]

        conditions = (
            (lambda t, theirs=theirs: theirs(t) > 0, lambda t, ours=ours: ours(t) < 1.0),  # penumbra
            (lambda t, theirs=theirs: theirs(t) == len(RIM), lambda t, ours=ours: ours(t) <= 0.0),  # umbra
        )
        grid = np.linspace(0.0, period, 400)
        for expected, found in conditions:
            instants = [_changes(expected, grid), _changes(found, grid)]
            assert len(instants[0]) == len(instants[1]), orbit
            compared += len(instants[0])
            worst = max([worst, *np.abs(np.subtract(*instants))])
    assert compared >= 8, f"only {compared} instants"
    return worst


def _changes(condition, grid) -> list[float]:
    """Where a condition begins or ends to hold, s, by bisection."""
    held = [condition(t) for t in grid]
    found = []
    for i in np.flatnonzero(np.diff(held)):
        low, high = grid[i], grid[i + 1]
        while high - low > 1e-3:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if condition(middle) == held[i] else (low, middle)
        found.append(0.5 * (low + high))
    return found
