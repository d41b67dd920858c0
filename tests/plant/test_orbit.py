"""The orbit: circular, from position and velocity, drifting with J2; frames and coordinates."""

from __future__ import annotations

import math

import numpy as np
import pytest

import plant
from plant import orbit
from tests.authorities import field, libration, orbits
from tests.plant.motion import checked, command

MU = 3.986004418e14


def test_a_circular_orbit_starts_at_its_node_going_north_at_the_papers_rate():
    p = checked()
    r, v = p.orbit.position_velocity(0.0)
    assert np.linalg.norm(r) == pytest.approx(6971e3, rel=1e-15)
    assert r[2] == 0.0
    assert v[2] > 0.0
    assert r @ v == pytest.approx(0.0, abs=1e-3)
    h = np.cross(r, v)
    assert math.degrees(math.acos(h[2] / np.linalg.norm(h))) == pytest.approx(98.0, abs=1e-12)
    assert p.orbit.mean_motion == pytest.approx(0.001085, abs=5e-7)
    assert 2.0 * math.pi / p.orbit.mean_motion == pytest.approx(5791.0, abs=2.0)


def test_a_circular_orbit_is_its_closed_form():
    """Spherical trigonometry: sin(declination) = sin i sin u, and u grows at sqrt(mu/a^3)."""
    i, u0 = 1.2, 0.7
    p = checked(inclination=i, argument_of_latitude=u0, orbit_radius=7.1e6)
    for t in (0.0, 1234.5, 9000.0):
        r, v = p.orbit.position_velocity(t)
        u = u0 + math.sqrt(MU / 7.1e6**3) * t
        assert r[2] == pytest.approx(7.1e6 * math.sin(i) * math.sin(u), abs=1e-5)
        assert v[2] == pytest.approx(math.sqrt(MU / 7.1e6) * math.sin(i) * math.cos(u), abs=1e-8)
        raan = p.gmst0 + p.node_longitude
        right_ascension = raan + math.atan2(math.cos(i) * math.sin(u), math.cos(u))
        assert math.remainder(math.atan2(r[1], r[0]) - right_ascension, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-12)


def test_the_node_stands_at_its_longitude_on_the_turning_earth():
    p = checked(node_longitude=math.radians(158.0))
    r, _ = p.orbit.position_velocity(0.0)
    on_earth = orbit.earth_fixed(0.0, p.gmst0).T @ r
    assert math.degrees(math.atan2(on_earth[1], on_earth[0])) == pytest.approx(158.0, abs=1e-12)
    # after one sidereal day the same meridian faces the same star
    day = orbit.earth_fixed(86164.0905, p.gmst0)
    assert day == pytest.approx(orbit.earth_fixed(0.0, p.gmst0), abs=1e-7)
    assert orbit.earth_fixed(100.0, 0.0)[1, 0] > 0.0  # eastward


def test_an_orbit_whose_node_drifts_starts_at_the_given_position_and_velocity_too():
    r, v = np.array([7.0e6, 1e5, 2e5]), np.array([100.0, -1300.0, 7400.0])
    p = checked(orbit_start="position_velocity", r_N0=r, v_N0=v, j2_node_drift=True)
    assert p.orbit.node_rate != 0.0
    r0, v0 = p.orbit.position_velocity(0.0)
    assert r0 == pytest.approx(r, abs=1e-6)
    assert v0 == pytest.approx(v, abs=1e-9)


def test_an_orbit_from_position_and_velocity_is_the_two_body_motion():
    assert orbits.two_body() < 0.05


@pytest.mark.parametrize("case", orbits.ORBITS)
def test_an_orbit_from_position_and_velocity_passes_through_them(case):
    r, v = map(np.array, orbits.ORBITS[case])
    path = orbit.from_position_velocity(r, v, MU)
    r0, v0 = path.position_velocity(0.0)
    assert r0 == pytest.approx(r, abs=1e-6)
    assert v0 == pytest.approx(v, abs=1e-9)
    back = path.position_velocity(-1000.0)
    assert orbits.integrated(*back, 1000.0) == pytest.approx(np.concatenate([r, v]), abs=1e-3)


def test_r_and_v_of_a_circular_orbit_give_that_orbit_again():
    circular = checked(inclination=0.9).orbit
    r, v = circular.position_velocity(777.0)
    again = orbit.from_position_velocity(r, v, MU)
    assert again.eccentricity < 1e-12
    for t in (0.0, 5000.0):
        for a, b in zip(again.position_velocity(t), circular.position_velocity(777.0 + t), strict=True):
            assert a == pytest.approx(b, rel=1e-9, abs=1e-3)


@pytest.mark.parametrize("eccentricity", [1e-9, 0.1, 0.7, 0.95, 0.995, 0.9999])
def test_keplers_equation_holds_round_the_orbit(eccentricity):
    for M in (*np.linspace(-7.0, 13.0, 41), *np.linspace(-0.2, 0.2, 401)):
        E = orbit._eccentric_anomaly(M, eccentricity)
        assert E - eccentricity * math.sin(E) == pytest.approx(M, abs=1e-13)


@pytest.mark.parametrize("drift", [False, True])
@pytest.mark.parametrize("start", ["circular", "position_velocity"])
def test_the_velocity_is_the_derivative_of_the_position_with_the_nodes_drift(start, drift):
    p = checked(orbit_start=start, r_N0=[6.8e6, 1e6, 2e6], v_N0=[-2.4e3, 2e3, 7.1e3], j2_node_drift=drift)
    for t in (0.0, 2345.6, 40000.0):
        h = 0.5
        r = [p.orbit.position_velocity(t + k * h)[0] for k in (-2, -1, 1, 2)]
        by_differences = (r[0] - 8.0 * r[1] + 8.0 * r[2] - r[3]) / (12.0 * h)
        assert p.orbit.position_velocity(t)[1] == pytest.approx(by_differences, abs=1e-6)
    if drift:  # 1e-7 rad/s of 7,000 km is far more than the tolerance above
        assert abs(p.orbit.node_rate) > 1e-8


def test_the_node_drifts_by_1_012_degrees_a_day_at_98_degrees_and_600_km():
    assert orbits.node_drift_98() == pytest.approx(1.012, abs=5e-4)


def test_the_node_follows_the_sun_at_97_79_degrees():
    assert orbits.sun_synchronous() == pytest.approx(0.98565, abs=1e-3)


def test_the_nodes_drift_is_what_j2s_acceleration_makes():
    assert orbits.node_drift_integrated() == pytest.approx(1.0, abs=5e-3)


def test_j2s_drift_falls_with_eccentricity_as_vallado_prints_it():
    """Proportional to (1 - e^2)^-2 at the same semi-major axis, westward for direct orbits, none over the poles."""
    a = 9e6
    circular = orbit.j2_node_rate(a, 0.0, 0.8, MU)
    assert orbit.j2_node_rate(a, 0.2, 0.8, MU) / circular == pytest.approx((1 - 0.04) ** -2, rel=1e-13)
    assert circular < 0.0
    assert orbit.j2_node_rate(a, 0.0, math.pi / 2, MU) == pytest.approx(0.0, abs=1e-22)


@pytest.mark.parametrize("case", orbits.ORBITS)
def test_lvlh_has_x_along_the_velocity_and_z_to_nadir(case):
    r, v = map(np.array, orbits.ORBITS[case])
    assert orbit.lvlh(r, v) == pytest.approx(libration.lvlh_from_definition(r, v), abs=1e-15)


def test_the_attitude_starts_at_q0_relative_to_lvlh():
    Q = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    p = checked(Q0=Q, argument_of_latitude=1.0)
    y = plant.outputs(plant.start(p, command()), command(), p)
    assert pytest.approx(libration.lvlh_from_definition(y.r_N, y.v_N) @ Q, abs=1e-15) == y.R_NB


def test_geodetic_coordinates_come_back_from_their_own_forward_formula():
    rng = np.random.default_rng(1)
    cases = [
        (lat, lon, h)
        for lat in (-math.pi / 2, -1e-9, 0.0, 0.3, math.pi / 2)
        for lon in (-3.0, 0.0, 1.5)
        for h in (0.0, 6e5, 4e7)
    ]
    cases += [(rng.uniform(-1.57, 1.57), rng.uniform(-3.14, 3.14), rng.uniform(-1e3, 5e7)) for _ in range(200)]
    for latitude, longitude, height in cases:
        found = orbit.geodetic(field.earth_fixed(latitude, longitude, height))
        assert found[0] == pytest.approx(latitude, abs=1e-12)
        assert found[2] == pytest.approx(height, abs=1e-6)
        if abs(latitude) < 1.57:
            assert found[1] == pytest.approx(longitude, abs=1e-12)


@pytest.mark.parametrize(
    ("r", "v", "message"),
    [
        ([7e6, 0.0, 0.0], [7e3, 0.0, 0.0], "parallel or zero"),
        ([0.0, 0.0, 0.0], [7e3, 0.0, 0.0], "parallel or zero"),
        ([7e6, 0.0, 0.0], [0.0, 11e3, 0.0], "escape speed"),
        ([7e6, 0.0, 0.0], [0.0, 6e3, 0.0], "100 km above the equator"),
        ([9.8e6, 0.0, 0.0], [0.0, 5.6e3, 0.0], "100 km above the equator"),  # its mean distance is 8,000 km
    ],
)
def test_a_start_that_gives_no_orbit_above_100_km_is_refused(r, v, message):
    with pytest.raises(ValueError, match=rf"r_N0.*{message}|{message}.*r_N0"):
        checked(orbit_start="position_velocity", r_N0=r, v_N0=v)
