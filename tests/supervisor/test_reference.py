"""Where the modes point: against numeric derivatives, pymap3d's stations and SciPy's rotations."""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import datetime

import numpy as np
import pymap3d
import pytest
from pymap3d.sidereal import greenwichsrt, juliandate
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from supervisor import reference, slew
from supervisor.reference import EARTH_RATE, Reference

MU = 3.986004418e14
R0, V0 = np.array([6971e3, 3e5, -2e5]), np.array([200.0, -1052.0, 7600.0])
"""An orbit that is no circle."""
POINT = reference.point_on_earth(math.radians(5.0), math.radians(11.0), 300.0)
AXIS = np.array([0.6, 0.0, -0.8])


def _orbit() -> Callable[[float], tuple[np.ndarray, np.ndarray]]:
    def f(t: float, y: np.ndarray) -> np.ndarray:
        return np.array([*y[3:], *(-MU / np.linalg.norm(y[:3]) ** 3 * y[:3])])

    both = [
        solve_ivp(f, (0.0, end), [*R0, *V0], rtol=1e-12, atol=1e-6, dense_output=True).sol for end in (-20.0, 700.0)
    ]

    def at(t: float) -> tuple[np.ndarray, np.ndarray]:
        y = both[t >= 0.0](t)
        return y[:3], y[3:]

    return at


orbit = _orbit()


def nadir(t: float) -> Reference:
    return reference.lvlh(*orbit(t))


def steered(t: float, yaw: float = 0.4) -> Reference:
    r, v = orbit(t)
    h = np.cross(r, v)
    return reference.steered(sight(t), h / np.linalg.norm(h), yaw)


def sight(t: float) -> reference.Direction:
    return reference.line_of_sight(POINT, 0.3 + EARTH_RATE * t, *orbit(t), MU)


def slewing(t: float) -> Reference:
    """From an attitude that turns to LVLH, the whole of it a large turn about no fixed axis."""
    turned = Rotation.from_rotvec([1.4, -1.1, 0.9]).as_matrix()
    now = Reference(nadir(0.0).R_ref @ turned, np.array([0.002, -0.004, 0.003]), np.zeros(3))
    return slew.at(slew.begin(now, nadir(0.0), np.diag([2.0, 3.0, 4.0]), 0.02, 5e-4), t, nadir(t))


def rate_by_differences(of: Callable[[float], Reference], t: float, h: float) -> np.ndarray:
    """Of fourth order, from attitudes alone."""

    def over(s: float) -> np.ndarray:
        return Rotation.from_matrix(of(t - s).R_ref.T @ of(t + s).R_ref).as_rotvec() / (2 * s)

    return (4 * over(h) - over(2 * h)) / 3


@pytest.mark.parametrize("of", [nadir, steered, slewing])
@pytest.mark.parametrize("t", [15.0, 60.0, 130.0])
def test_rate_and_its_derivative_are_those_of_the_attitude(of: Callable[[float], Reference], t: float) -> None:
    y, h = of(t), 0.5
    np.testing.assert_allclose(y.R_ref.T @ y.R_ref, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(y.Omega_ref, rate_by_differences(of, t, h), rtol=0, atol=2e-10)
    one, two = (of(t + d).Omega_ref - of(t - d).Omega_ref for d in (h, 2 * h))
    differences = (8 * one - two) / (12 * h)
    np.testing.assert_allclose(y.dOmega_ref, differences, rtol=0, atol=2e-10)


def test_a_free_yaw_looks_at_its_point_and_turns_by_its_rate_with_none_about_the_line_of_sight() -> None:
    z = np.array([0.0, 0.0, 1.0])
    h, steps = 0.05, 400
    states = [reference.free(z, sight(0.0), nadir(0.0).R_ref)]
    for i in range(steps):
        states.append(reference.free(z, sight((i + 1) * h), states[-1].R_ref))
    for i in (50, 200, 350):
        y = states[i]
        np.testing.assert_allclose(y.R_ref[:, 2], sight(i * h).u, atol=1e-14)
        turn = Rotation.from_matrix(states[i - 1].R_ref.T @ states[i + 1].R_ref).as_rotvec() / (2 * h)
        np.testing.assert_allclose(y.Omega_ref, turn, rtol=0, atol=1e-9)
        assert y.Omega_ref[2] == pytest.approx(0.0, abs=1e-15)
        change = (states[i + 1].Omega_ref - states[i - 1].Omega_ref) / (2 * h)
        np.testing.assert_allclose(y.dOmega_ref, change, rtol=0, atol=1e-8)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.7, math.pi - 1e-9, math.pi])
def test_a_free_axis_is_brought_to_its_direction_by_the_smallest_turn(angle: float) -> None:
    before = Rotation.from_rotvec([0.2, -0.5, 1.1]).as_matrix()
    to = Rotation.from_rotvec(angle * np.array([0.0, 1.0, 0.0])).apply(before @ AXIS * 1.0)
    away = math.acos(np.clip(to @ (before @ AXIS), -1.0, 1.0))
    y = reference.free(AXIS, reference.Direction(to, np.zeros(3), np.zeros(3)), before)
    np.testing.assert_allclose(y.R_ref @ AXIS, to, atol=2e-6 if angle > 3.0 else 1e-14)
    assert Rotation.from_matrix(before.T @ y.R_ref).magnitude() == pytest.approx(away, abs=1e-6)


def test_steered_at_the_point_below_is_lvlh() -> None:
    r, v = orbit(30.0)
    h = np.cross(r, v)
    expected = nadir(30.0)
    down = reference.unit(-r, -v, MU / np.linalg.norm(r) ** 3 * r)
    y = reference.steered(down, h / np.linalg.norm(h), 0.0)
    for found, wanted in zip(y, expected, strict=True):
        np.testing.assert_allclose(found, wanted, atol=1e-15)


@pytest.mark.parametrize(
    ("latitude", "longitude", "height"), [(48.09, 11.28, 600.0), (-33.15, -70.67, 730.0), (78.23, 15.41, 450.0)]
)
def test_a_ground_station_is_where_pymap3d_has_it_and_sees_the_satellite_there(
    latitude: float, longitude: float, height: float
) -> None:
    point = reference.point_on_earth(math.radians(latitude), math.radians(longitude), height)
    np.testing.assert_allclose(point, pymap3d.geodetic2ecef(latitude, longitude, height), rtol=0, atol=1e-6)
    angle = 1.234
    turn = Rotation.from_rotvec([0.0, 0.0, angle])
    for shift in ([4e5, 2e5, -3e5], [-2e5, 9e5, 1e5], [-9e6, 1e6, 3e5]):
        fixed = point * (1.0 + 5e5 / np.linalg.norm(point)) + shift
        _, up, away = pymap3d.ecef2aer(*fixed, latitude, longitude, height)
        r = turn.apply(fixed)
        found = reference.elevation(point, math.radians(latitude), math.radians(longitude), angle, r)
        assert math.degrees(found) == pytest.approx(up, abs=1e-9)
        z = reference.line_of_sight(point, angle, r, V0, MU)
        np.testing.assert_allclose(r + away * z.u, turn.apply(point), rtol=0, atol=1e-6)


@pytest.mark.parametrize("epoch", ["2009-08-10T00:00:00Z", "1999-12-31T23:59:59", "2024-02-29T18:30:00+00:00"])
def test_the_angle_of_greenwich_is_that_of_pymap3d(epoch: str) -> None:
    days = juliandate(datetime.fromisoformat(epoch).replace(tzinfo=None))
    assert reference.sidereal_angle(epoch) == pytest.approx(greenwichsrt(days), abs=1e-6)  # a Julian date has 40 us
