"""Positions by element sets are those of astropy's own frames, and the shadow is the plant's."""

from datetime import UTC, datetime

import numpy as np
import pytest
from astropy import units
from astropy.coordinates import ITRS, TEME, CartesianRepresentation
from astropy.time import Time
from astropy.utils.iers import conf

from inflight.orbit import MU, followed, instant, orbit_at, read_elements
from orchestration.errors import InputError
from plant.orbit import drifting, earth_fixed
from plant.sun import Sun, seen_from
from plant.time_scales import days_since_j2000

TLE = """1 52191U 22033AL  23247.77431173  .00022171  00000+0  61178-3 0  9997
2 52191  97.3601 329.3497 0007739 208.8387 151.2430 15.37072592 79491
"""
EPOCH = datetime(2023, 9, 4, 14, 48, 23, tzinfo=UTC)


@pytest.fixture
def elements(tmp_path):
    path = tmp_path / "tle.txt"
    path.write_text(TLE)
    return path


def test_n_is_teme_turned_to_the_earth_as_astropy_turns_it(elements):
    orbit = orbit_at(read_elements(elements), EPOCH, np.linspace(0.0, 5400.0, 7))
    with conf.set_temp("auto_download", False):
        time = Time(EPOCH) + orbit.t * units.s
        place = CartesianRepresentation(orbit.r_N.T * units.m)
        fixed = TEME(place, obstime=time).transform_to(ITRS(obstime=time)).cartesian.xyz.to_value(units.m).T
        ut1 = float(Time(EPOCH).delta_ut1_utc)
    ours = np.array([earth_fixed(t, orbit.gmst[0]).T @ r for t, r in zip(orbit.t, orbit.r_N, strict=True)])
    turn = 7.292115e-5 * ut1  # what UT1 taken as UTC leaves out
    c, s = np.cos(turn), np.sin(turn)
    ours = ours @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]).T
    assert np.abs(ours - fixed).max() < 25.0  # m; polar motion, which N leaves out, is 15 m


def test_the_field_along_the_orbit_is_that_of_ppigrf(elements):
    import ppigrf

    orbit = orbit_at(read_elements(elements), EPOCH, np.arange(0.0, 300.0, 1.0))
    field = orbit.field_N()
    for i in (0, 137, 299):
        r = earth_fixed(orbit.t[i], orbit.gmst[0]).T @ orbit.r_N[i]
        size = np.linalg.norm(r)
        theta, phi = np.degrees(np.arccos(r[2] / size)), np.degrees(np.arctan2(r[1], r[0]))
        parts = ppigrf.igrf_gc(size / 1e3, theta, phi, EPOCH.replace(tzinfo=None))
        assert np.linalg.norm(field[i]) == pytest.approx(np.linalg.norm(parts) * 1e-9, abs=2e-9)


def test_the_shadow_begins_and_ends_where_the_plant_has_it(elements):
    orbit = orbit_at(read_elements(elements), EPOCH, np.arange(0.0, 5400.0, 1.0))
    sun = Sun(days_since_j2000(EPOCH))
    plant = np.array([seen_from(r, sun.at(t))[1] for t, r in zip(orbit.t, orbit.r_N, strict=True)])
    assert 0.3 < plant.mean() < 0.7
    assert ((plant > 0.5) != (orbit.sunlight() > 0.5)).sum() <= 1
    assert orbit.sunlight(22e3).sum() < orbit.sunlight().sum() - 5.0


@pytest.mark.parametrize(("duration", "km"), [(0.0, 1e-3), (600.0, 1.0), (86400.0, 4.0)])
def test_a_plants_orbit_stays_near_that_of_sgp4(elements, duration, km):
    orbit = orbit_at(read_elements(elements), EPOCH, np.linspace(0.0, duration, 1000))
    values, near = followed(orbit)
    plant = drifting(np.array(values["r_N0"]), np.array(values["v_N0"]), MU)
    off = [np.linalg.norm(plant.position_velocity(t)[0] - r) for t, r in zip(orbit.t, orbit.r_N, strict=True)]
    assert max(off) < 1e3 * km
    assert float(near.split()[-5]) == pytest.approx(max(off) / 1e3, abs=0.11)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("97.3601", "97.3602", r"tle.txt:2: expected the check sum \d as the last digit, found '1'"),
        ("97.3601", "97.361", r"tle.txt:2: expected a line of 69 characters of an element set, found 68"),
        ("2 52191", "2 52919", r"tle.txt:2: expected a line that begins with '2 52191', found '2 52919'"),
        ("2 52191", "1 52191", r"tle.txt:2: expected a line that begins with '2 52191', found '1 52191'"),
    ],
)
def test_a_wrong_line_of_an_element_set_is_refused_at_its_line(tmp_path, old, new, message):
    path = tmp_path / "tle.txt"
    path.write_text(TLE.replace(old, new))
    with pytest.raises(InputError, match=message):
        read_elements(path)


def test_element_sets_that_are_too_old_are_refused(elements):
    with pytest.raises(InputError, match="the nearest element set is 118"):
        orbit_at(read_elements(elements), datetime(2024, 1, 1, tzinfo=UTC), np.zeros(1))


def test_seconds_of_tai_are_an_instant_of_utc():
    assert instant(1_700_000_037.0) == datetime.fromtimestamp(1_700_000_000, UTC)
