"""The estimator's parts against closed forms and others' numbers; whole, against the truth, is in test_flights.py.

Shows ES-1.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import estimator
from estimator import onboard
from estimator.start import triad
from evidence.estimator import steady
from plant import tables
from plant.geomagnetic import Field
from plant.orbit import from_position_velocity
from tests.blocks import inputs, parameters

MU = 3.986004418e14
R_N, V_N = np.array((6971000.0, 0.0, 0.0)), np.array((0.0, -1052.3891, 7488.1109))
LIT = "2009-02-10T00:00:00Z"
"""At this date the Sun is seen from R_N."""


@pytest.mark.parametrize("case", steady.CASES)
def test_the_steady_state_under_a_star_tracker_is_farrenkopfs(case: tuple[float, float, float, float]) -> None:
    assert steady.of_filter(*case, updates=1500) == pytest.approx(steady.closed_form(*case), rel=0.01)


def test_the_sun_stands_where_vallado_has_it() -> None:
    """Fundamentals of Astrodynamics and Applications, example 5-1: 2 April 2006, 00:00 UTC, mean of date."""
    expected = np.array((0.9771945, 0.1924424, 0.0834308))
    found = onboard.sun_direction(onboard.days_since_j2000(onboard.parse_epoch("2006-04-02")))
    assert math.degrees(math.acos(found @ expected / np.linalg.norm(expected))) < 0.01


@pytest.mark.parametrize(
    ("along", "across", "light"), [(1.0, 0.0, 1.0), (-7e6, 6.2e6, 0.0), (-7e6, 6.5e6, 1.0), (0.0, 7e6, 1.0)]
)
def test_the_shadow_is_behind_the_earth(along: float, across: float, light: float) -> None:
    r_N = np.array((7e6, 0.0, 0.0)) if along == 1.0 else np.array((along, across, 0.0))
    assert onboard.sunlight(r_N, np.array((1.0, 0.0, 0.0))) == light


def test_the_onboard_field_is_that_of_the_plants_recursion() -> None:
    """Cunningham's recursion in Cartesian components there, Schmidt functions here."""
    p = parameters("estimator", field_degree=13)
    g, h = tables.field_model("igrf14").at(onboard.year_of(p.days))
    for position in (R_N, [3e6, -5e6, 4e6], [1.0, 2.0, -7e6]):
        angle = p.field.sidereal_angle + onboard.EARTH_RATE * 1000.0
        to_N = Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix()
        expected = to_N @ Field(g, h, 13).at(to_N.T @ np.array(position))
        assert p.field.at(1000.0, np.array(position)) == pytest.approx(expected, rel=1e-6, abs=1e-13)


@pytest.mark.parametrize("oblate", [False, True])
def test_the_orbit_goes_on_through_a_drop_out(oblate: bool) -> None:
    p = parameters("estimator", j2=oblate)
    u = inputs("estimator", r_N_measured=R_N, v_N_measured=V_N, orbit_sample=1)
    x = estimator.start(p, u)
    for _ in range(60):
        x, y = estimator.step(x, u, p, 10.0)
    r, _ = from_position_velocity(R_N, V_N, MU).position_velocity(600.0)
    off = float(np.linalg.norm(y.r_N - r))
    assert off < 0.01 if not oblate else 500.0 < off < 5000.0
    energy = 0.5 * y.v_N @ y.v_N - MU / np.linalg.norm(y.r_N)
    if oblate:
        r3, z = np.linalg.norm(y.r_N) ** 3, y.r_N[2]
        energy += MU * onboard.J2 * onboard.EARTH_RADIUS**2 / (2.0 * r3) * (3.0 * z * z / (y.r_N @ y.r_N) - 1.0)
        expected = 0.5 * V_N @ V_N - MU / 6971e3 - MU * onboard.J2 * onboard.EARTH_RADIUS**2 / (2.0 * 6971e3**3)
    else:
        expected = 0.5 * V_N @ V_N - MU / 6971e3
    assert energy == pytest.approx(expected, rel=1e-9)


def test_the_first_attitude_is_that_of_wahbas_problem_with_the_better_direction_exact() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        R = Rotation.random(random_state=rng)
        first, second = rng.normal(size=(2, 3))
        seen = R.inv().apply([first, second]) + 0.01 * rng.normal(size=(2, 3))
        unit = [v / np.linalg.norm(v) for v in (first, second, *seen)]
        expected, _ = Rotation.align_vectors(unit[:2], unit[2:], weights=[math.inf, 1.0])
        found = triad(seen[0], seen[1], first, second, 0.1)
        assert found is not None
        assert (Rotation.from_matrix(found).inv() * expected).magnitude() < 1e-7
    assert triad(first, first, first, second, 0.1) is None


def seen_by(R: np.ndarray, p: Any, **changes: Any) -> Any:
    """Inputs without noise of an attitude at t = 0 in light."""
    b, s = R.T @ p.field.at(0.0, R_N), R.T @ onboard.sun_direction(p.days)
    return inputs("estimator", b_B_measured=b, sun_B_measured=s, r_N_measured=R_N, v_N_measured=V_N, **changes)


@pytest.mark.parametrize("seed", range(5))
def test_any_attitude_is_known_at_once_in_light(seed: int) -> None:
    R = Rotation.random(random_state=seed).as_matrix()
    p = parameters("estimator", epoch=LIT)
    u = seen_by(R, p)
    y = estimator.outputs(estimator.start(p, u), u, p)
    assert pytest.approx(R, abs=1e-9) == y.R_NB
    assert y.sunlight == 1.0


def test_a_measurement_beyond_the_gate_is_counted_and_not_used() -> None:
    R = Rotation.random(random_state=7).as_matrix()
    p = parameters("estimator", epoch=LIT)
    u = seen_by(R, p)
    x = estimator.start(p, u)
    for _ in range(20):
        x, _ = estimator.step(x, u, p, 1e-3)
    x, y = estimator.step(x, replace(u, b_B_measured=-u.b_B_measured), p, 1e-3)
    assert y.rejected.tolist() == [1, 0, 0]
    assert y.nis[0] > p.gate
    assert pytest.approx(R, abs=1e-4) == y.R_NB
    for _ in range(50):
        x, y = estimator.step(x, replace(u, b_B_measured=-u.b_B_measured, sun_B_measured=np.zeros(3)), p, 1e-3)
    assert not y.attitude_valid, "after so many in a row the filter starts again"


def test_the_field_of_the_rods_is_taken_off_or_the_sample_is_left_out() -> None:
    R = Rotation.random(random_state=9).as_matrix()
    coupling, dipole = (
        1e-6 * np.array([[1.0, 0.2, 0.0], [0.0, -0.8, 0.1], [0.3, 0.0, 1.2]]),
        np.array((10.0, -5.0, 3.0)),
    )
    p = parameters("estimator", epoch=LIT, rod_field=coupling)
    u = seen_by(R, p, dipole=dipole)
    disturbed = replace(u, b_B_measured=u.b_B_measured + coupling @ dipole)
    _, y = estimator.step(estimator.start(p, disturbed), disturbed, p, 1e-3)
    assert pytest.approx(R, abs=1e-6) == y.R_NB
    assert y.b_B == pytest.approx(u.b_B_measured, abs=1e-12)
    limited = replace(p, dipole_limit=5.0)
    y = estimator.outputs(estimator.start(limited, disturbed), disturbed, limited)
    assert not y.R_NB.any()
