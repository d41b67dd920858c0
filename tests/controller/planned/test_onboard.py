"""What the controller knows ahead: field, dates, sidereal time, orbit, target."""

import math
from datetime import UTC, datetime, timedelta

import numpy as np
import ppigrf
import pytest
from pygeomag import GeoMag
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from tests import dates
from tests.authorities import field as authority
from tests.authorities import orbits

from . import core

J2000 = datetime(2000, 1, 1, 12, tzinfo=UTC)


def days_of(date):
    return (date - J2000) / timedelta(days=1)


# ------------------------------------------------------------------------------------------- dates


@pytest.mark.parametrize("text", dates.READ)
def test_a_date_is_as_many_days_after_j2000_as_the_calendar_says(text):
    assert core.days(text) == pytest.approx(days_of(dates.READ[text]), abs=1e-11)


def test_every_day_of_thirty_years_follows_the_day_before():
    dates = [datetime(2000, 1, 1, tzinfo=UTC) + timedelta(days=n) for n in range(31 * 365)]
    assert [core.days(d.strftime("%Y-%m-%dT00:00:00Z")) for d in dates] == [days_of(d) for d in dates]


@pytest.mark.parametrize("text", dates.REFUSED)
def test_what_is_no_utc_date_is_none(text):
    assert core.days(text) is None


def test_the_year_is_within_a_day_of_the_calendars():
    for n in range(0, 11000, 13):
        date = datetime(2000, 1, 1, tzinfo=UTC) + timedelta(days=n)
        start, end = datetime(date.year, 1, 1, tzinfo=UTC), datetime(date.year + 1, 1, 1, tzinfo=UTC)
        assert abs(core.year(days_of(date)) - date.year - (date - start) / (end - start)) < 1.0 / 365.0


@pytest.mark.parametrize("source", orbits.SIDEREAL)
def test_sidereal_time_is_as_published(source):
    date, degrees = orbits.SIDEREAL[source]
    assert math.remainder(core.sidereal(days_of(date)) - math.radians(degrees), 2 * math.pi) == pytest.approx(
        0.0, abs=2e-8
    )


# ------------------------------------------------------------------------------------------- field


def places(rng, n=40):
    return [
        (math.degrees(math.asin(rng.uniform(-1, 1))), rng.uniform(-180, 180), rng.uniform(300, 900)) for _ in range(n)
    ]


def ours(model, date, degree, latitude, longitude, height, seconds=0.0, error=(0, 0, 0)):
    """North, east, down, nT. N is turned from the Earth by the sidereal time of the date and of `seconds` after it."""
    lat, lon = math.radians(latitude), math.radians(longitude)
    days = days_of(date)
    turn = Rotation.from_rotvec([0, 0, core.sidereal(days) + 7.292115855e-5 * seconds]).as_matrix()
    r = authority.earth_fixed(lat, lon, height * 1e3)
    B = core.field_at(model, days, degree, turn @ r, seconds, error)
    return authority.north_east_down(lat, lon).T @ turn.T @ B * 1e9


def by_ppigrf(date, degree, latitude, longitude, height):
    found = ppigrf.igrf(longitude, latitude, height, date.replace(tzinfo=None), max_degree=degree)
    east, north, up = (float(np.squeeze(c)) for c in found)
    return np.array([north, east, -up])


@pytest.mark.parametrize(
    ("year", "degree"), [(2000, 13), (2003, 13), (2009, 13), (2009, 10), (2009, 1), (2015, 4), (2029, 13)]
)
@pytest.mark.thorough
def test_igrf_is_ppigrfs(year, degree, rng):
    date = datetime(year, 1, 1, tzinfo=UTC)
    for place in places(rng):
        # The onboard year counts 365.25 days each: up to 0.7 day off, at up to 150 nT a year.
        assert ours("igrf14", date, degree, *place) == pytest.approx(by_ppigrf(date, degree, *place), abs=0.35)


@pytest.mark.parametrize(("model", "year", "file"), [
    ("wmm2010", 2012.0, "wmm/WMM_2010.COF"), ("wmm2015", 2016.0, "wmm/WMM_2015v2.COF"),
    ("wmm2020", 2020.0, "wmm/WMM_2020.COF"), ("wmm2025", 2029.0, "wmm/WMM_2025.COF"),
])  # fmt: skip
def test_wmm_is_pygeomags(model, year, file, rng):
    theirs = GeoMag(coefficients_file=file)
    date = datetime(int(year), 1, 1, tzinfo=UTC)
    for latitude, longitude, height in places(rng):
        found = theirs.calculate(glat=latitude, glon=longitude, alt=height, time=year)
        assert ours(model, date, 12, latitude, longitude, height) == pytest.approx(
            [found.x, found.y, found.z], abs=0.35
        )


def test_the_field_turns_with_the_earth(rng):
    """Some hours after the epoch the field at a place fixed to the Earth is what it was."""
    date = datetime(2009, 8, 10, tzinfo=UTC)
    for place in places(rng, 5):
        assert ours("igrf14", date, 10, *place, seconds=20000.0) == pytest.approx(
            ours("igrf14", date, 10, *place), abs=1e-3
        )


def test_a_full_turn_takes_a_sidereal_day():
    r = np.array([5e6, 3e6, 4e6])
    day = 86164.0905
    first, later = (core.field_at("igrf14", 3508.5, 10, r, t) for t in (0.0, day))
    assert np.abs(core.field_at("igrf14", 3508.5, 10, r, 0.5 * day) - first).max() > 1e-7
    assert later == pytest.approx(first, abs=2e-12)


def test_an_error_of_the_dipole_is_the_field_of_that_dipole():
    r = np.array([3e6, -5e6, 4.5e6])
    error = np.array([3e-7, -2e-7, 1e-7])  # g10, g11, h11
    turn = Rotation.from_rotvec([0, 0, core.sidereal(3508.5)]).as_matrix()
    m = turn @ np.array([error[1], error[2], error[0]])
    d = np.linalg.norm(r)
    expected = (6371200.0 / d) ** 3 * (3.0 * (m @ r) * r / d**2 - m)
    wrong, right = (core.field_at("igrf14", 3508.5, 10, r, 0.0, e) for e in (error, np.zeros(3)))
    assert wrong - right == pytest.approx(expected, abs=1e-18 + 1e-9 * np.abs(expected).max())


def test_the_field_is_finite_and_continuous_at_the_poles():
    for z in (6.9e6, -6.9e6):
        at, beside = core.field_at("igrf14", 3508.5, 10, np.array([[0.0, 0.0, z], [1.0, -1.0, z]]))
        assert np.isfinite(at).all()
        assert np.abs(at - beside).max() < 1e-10


# ------------------------------------------------------------------------------------------- orbit and target

ORBITS = {
    "circular": ([6.971e6, 0.0, 0.0], [0.0, -1052.39, 7488.11]),
    "eccentric": ([6.8e6, 1e5, -2e5], [500.0, 2000.0, 9400.0]),
    "retrograde": ([0.0, 7.2e6, 0.0], [7000.0, 0.0, -2500.0]),
    "far out": ([2.0e7, -1.5e7, 5e6], [1500.0, 2500.0, -2200.0]),
    "from apogee": ([1.2e7, 0.0, 0.0], [0.0, 4200.0, 0.0]),
}


@pytest.mark.parametrize("name", ORBITS)
def test_the_orbit_ahead_is_that_of_two_bodies(name):
    r, v = (np.array(x, float) for x in ORBITS[name])

    def motion(t, x):
        return [*x[3:], *(-core.MU * x[:3] / np.linalg.norm(x[:3]) ** 3)]

    times = [-500.0, 0.0, 10.0, 300.0, 1500.0, 5000.0]
    for t in times:
        end = solve_ivp(motion, (0.0, t), [*r, *v], rtol=1e-12, atol=1e-6, method="DOP853").y[:, -1]
        r_t, v_t = core.orbit_at(r, v, t)
        assert r_t == pytest.approx(end[:3], abs=0.02)
        assert v_t == pytest.approx(end[3:], abs=2e-5)


def test_lvlh_looks_down_and_against_the_orbits_normal_and_turns_as_it_does():
    for r, v in ORBITS.values():
        r, v = np.array(r), np.array(v)
        R, Omega = core.lvlh(r, v)
        assert pytest.approx(np.eye(3), abs=1e-14) == R.T @ R
        assert np.linalg.det(R) == pytest.approx(1.0)
        assert R[:, 2] == pytest.approx(-r / np.linalg.norm(r))
        normal = np.cross(r, v)
        assert R[:, 1] == pytest.approx(-normal / np.linalg.norm(normal))
        later, before = (core.lvlh(*core.orbit_at(r, v, dt))[0] for dt in (0.5, -0.5))
        assert Rotation.from_matrix(before.T @ later).as_rotvec() == pytest.approx(Omega, abs=1e-9)


@pytest.mark.parametrize(
    "angle", [0.0, 1e-12, 1e-9, 1e-6, 1e-4, 0.01, 1.0, 2.5, 3.14, math.pi - 1e-5, math.pi - 1e-8, math.pi]
)
def test_the_logarithm_is_scipys_from_none_to_half_a_turn(angle, rng):
    axes = rng.normal(size=(50, 3))
    axes = np.vstack((axes / np.linalg.norm(axes, axis=1)[:, None], np.eye(3), -np.eye(3)))
    R = Rotation.from_rotvec(angle * axes).as_matrix()
    found = core.logs(R)
    # Half a turn may be told about either axis.
    back = Rotation.from_rotvec(found).as_matrix()
    assert np.abs(back - R).max() < 1e-12
    assert np.linalg.norm(found, axis=1) == pytest.approx(angle, abs=1e-15, rel=2e-9)
    if angle < math.pi - 1e-9:
        assert found == pytest.approx(angle * axes, abs=1e-12)
