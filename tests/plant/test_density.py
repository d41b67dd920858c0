"""The density against pymsis's NRLMSISE-00, which is the model's Fortran."""

from __future__ import annotations

import math
import socket
import urllib.request
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

import plant
from plant import tables
from plant.atmosphere import Atmosphere
from plant.tables import density as table
from plant.tables import density_fit
from tests.blocks import parameters

SOLAR = (70.0, 150.0, 230.0)
HEIGHTS = (150e3, 180e3, 250e3, 400e3, 600e3, 1000e3, 2000e3)


def orbit_place(t, radius, inclination, node_longitude, epoch):
    """Geodetic latitude, longitude (rad) and height (m): the Almanac's GMST and a fixed point, not the plant's own
    code."""
    days = (epoch - datetime(2000, 1, 1, 12, tzinfo=UTC)) / timedelta(days=1)
    gmst = math.radians(15.0) * (18.697374558 + 24.06570982441908 * np.array([days, days + t / 86400.0]))
    u = math.sqrt(3.986004418e14 / radius**3) * t
    raan = gmst[0] + node_longitude
    x = math.cos(raan) * math.cos(u) - math.sin(raan) * math.cos(inclination) * math.sin(u)
    y = math.sin(raan) * math.cos(u) + math.cos(raan) * math.cos(inclination) * math.sin(u)
    z = radius * math.sin(inclination) * math.sin(u)
    p = radius * math.hypot(x, y)
    latitude = math.asin(z / radius)
    e2 = 0.00669437999014
    for _ in range(20):
        N = 6378137.0 / math.sqrt(1.0 - e2 * math.sin(latitude) ** 2)
        latitude = math.atan2(z + e2 * N * math.sin(latitude), p)
    height = p * math.cos(latitude) + z * math.sin(latitude) - 6378137.0**2 / N
    return latitude, (math.atan2(y, x) - gmst[1]) % (2.0 * math.pi), height


def deviation_along_orbit(f107, date, ap, altitude, f107_average=None):
    """Largest |ln(density / pymsis)| over an orbit of 98 deg whose radius is the Earth's mean plus the altitude."""
    radius = 6371e3 + altitude
    mean = f107 if f107_average is None else f107_average
    p = parameters("plant", epoch=date, f107=f107, f107_average=mean, ap=ap, orbit_radius=radius)
    plant.check(p)
    epoch = datetime.fromisoformat(date)
    times = np.arange(0.0, 2.0 * math.pi / math.sqrt(3.986004418e14 / radius**3), 37.0)
    places = np.array([orbit_place(t, radius, p.inclination, p.node_longitude, epoch) for t in times])
    moments = [epoch + timedelta(seconds=t) for t in times]
    day = np.array([m.timetuple().tm_yday for m in moments])
    seconds = np.array([3600.0 * m.hour + 60.0 * m.minute + m.second for m in moments])
    theirs = density_fit.run(day, seconds, places[:, 0], places[:, 1], places[:, 2] / 1e3, f107, mean, ap)[:, 0]
    ours = np.array([p.air.flow(t)[1] for t in times])
    return np.abs(np.log(ours / theirs)).max()


@pytest.mark.parametrize("f107", SOLAR)
@pytest.mark.parametrize("date", ["2009-08-10T00:00:00Z", "2014-10-28T21:00:00Z"])
def test_density_follows_pymsis_along_the_papers_orbit(f107, date):
    assert deviation_along_orbit(f107, date, 4.0, 600e3) < 0.01


@pytest.mark.parametrize(("altitude", "ap"), [(200e3, 4.0), (400e3, 48.0), (600e3, 200.0), (1200e3, 4.0)])
def test_density_follows_pymsis_along_other_orbits(altitude, ap):
    assert deviation_along_orbit(120.0, "2003-03-10T06:30:00Z", ap, altitude, f107_average=160.0) < 0.012


def sampled_deviation(height, seed, f107, f107_average, ap, n=250, noon=False):
    """ln(density / pymsis) (n,) at random places and days; at noon UTC the season is the same to both."""
    random = np.random.default_rng(seed)
    day = random.integers(1, 366, n)
    seconds = np.full(n, 43200.0) if noon else np.floor(random.uniform(0.0, 86400.0, n))
    latitude, longitude = np.arcsin(random.uniform(-1.0, 1.0, n)), random.uniform(0.0, 2.0 * math.pi, n)
    theirs = density_fit.run(day, seconds, latitude, longitude, height / 1e3, f107, f107_average, ap)[:, 0]
    air = Atmosphere(tables.density_model(), f107, f107_average, ap)
    places = zip(latitude, longitude, day + seconds / 86400.0, strict=True)
    return np.log([air.density(lat, lon, height, d) for lat, lon, d in places] / theirs)


@pytest.mark.parametrize("height", HEIGHTS)
def test_density_follows_pymsis_at_random_places_in_all_seasons(height):
    for seed, f107 in enumerate(SOLAR):
        assert np.abs(sampled_deviation(height, seed, f107, f107, 4.0)).max() < 0.025


@pytest.mark.parametrize(
    ("f107", "f107_average", "ap"), [(60.0, 75.0, 0.0), (240.0, 170.0, 30.0), (110.0, 180.0, 400.0)]
)
def test_above_500_km_the_table_is_the_model_to_rounding(f107, f107_average, ap):
    for height in (500e3, 800e3, 1500e3):
        assert np.abs(sampled_deviation(height, 7, f107, f107_average, ap, noon=True)).max() < 2e-4


def test_the_committed_table_is_what_pymsis_gives():
    made = density_fit.fit(samples=4000, seed=3)
    committed = tables.density_model()
    rng = np.random.default_rng(4)
    for _ in range(100):
        f107, mean = rng.uniform(70.0, 230.0, 2)
        ap = rng.uniform(0.0, 100.0)
        latitude, longitude = math.asin(rng.uniform(-1.0, 1.0)), rng.uniform(0.0, 2.0 * math.pi)
        where = (latitude, longitude, rng.uniform(150e3, 2000e3), rng.uniform(1.0, 366.0))
        a, b = (Atmosphere(model, f107, mean, ap).density(*where) for model in (made, committed))
        assert a == pytest.approx(b, rel=3e-4)


def test_pymsis_with_given_indices_opens_no_connection(monkeypatch):
    def refuse(*_args, **_kwargs):
        raise AssertionError("a connection was opened")

    monkeypatch.setattr(socket.socket, "connect", refuse)
    monkeypatch.setattr(urllib.request, "urlopen", refuse)
    sampled_deviation(600e3, 1, 150.0, 150.0, 4.0, n=3)


def test_a_built_fmu_carries_the_same_table():
    carried = table.parse(tables.dump()[table.FILE])
    for name in ("terms", "coefficients", "ap_shape"):
        np.testing.assert_array_equal(getattr(carried, name), getattr(tables.density_model(), name))
    assert len(tables.dump()[table.FILE]) < 300_000


def test_writing_and_reading_the_table_keeps_it():
    model = tables.density_model()
    again = table.parse(table.dump(model))
    np.testing.assert_array_equal(again.terms, model.terms)
    np.testing.assert_array_equal(again.coefficients, model.coefficients)


@pytest.mark.parametrize(("f107", "expected"), [(70.0, 1.9e-14), (150.0, 2.6e-13), (230.0, 9.4e-13)])
def test_mean_density_over_an_orbit_at_600_km_has_the_known_size(f107, expected):
    p = parameters("plant", epoch="2009-10-28T00:00:00Z", f107=f107, f107_average=f107, ap=9.0)
    mean = np.mean([p.air.flow(t)[1] for t in np.arange(0.0, 5791.0, 60.0)])
    assert 1.0 / 1.4 < mean / expected < 1.4


def test_density_is_continuous_over_midnight_and_new_year():
    p = parameters("plant", epoch="2009-12-31T23:59:00Z")
    before, after = (p.air.exact(t)[3] for t in (60.0 - 1e-3, 60.0 + 1e-3))
    assert before == pytest.approx(after, abs=1e-5)


def test_interpolation_between_nodes_keeps_density_and_velocity():
    p = parameters("plant")
    errors = [np.abs(p.air.at(t) - p.air.exact(t)) for t in np.arange(3.0, 5800.0, 41.3)]
    worst = np.max(errors, axis=0)
    assert worst[:3].max() < 1e-9  # m/s
    assert worst[3] < 1e-9


@pytest.mark.parametrize("name", ["f107", "f107_average", "ap"])
@pytest.mark.parametrize("value", [-1.0, 1e4, math.nan])
def test_activity_out_of_range_is_refused_by_name_and_value(name, value):
    with pytest.raises(ValueError, match=rf"{name}: expected \d+ to \d+.*, found {value}"):
        plant.check(parameters("plant", **{name: value}))


@pytest.mark.parametrize(("radius", "end"), [(6378137.0 + 149e3, "lowest"), (6356752.0 + 2001e3, "highest")])
def test_an_orbit_outside_the_table_is_refused_with_the_range_unless_drag_is_off(radius, end):
    with pytest.raises(
        ValueError, match=rf"orbit_radius: expected heights .* 150 to 2000 km, .* found .* the {end} of"
    ):
        plant.check(parameters("plant", orbit_radius=radius))
    plant.check(parameters("plant", orbit_radius=radius, drag=False))


def test_an_eccentric_orbit_is_judged_by_perigee_and_apogee():
    r = [6778e3, 0.0, 0.0]
    for speed, end in ((7587.0, "lowest"), (8300.0, "highest")):
        with pytest.raises(ValueError, match=f"r_N0, v_N0: expected heights .* the {end} of the orbit"):
            plant.check(parameters("plant", orbit_start="position_velocity", r_N0=r, v_N0=[0.0, 0.0, speed]))
