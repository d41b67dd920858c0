import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from controller import reference, so3

MU = 3.986004418e14


def test_lvlh_over_the_equator_going_north_by_hand():
    # On N's x axis, flying along its z: nadir is -x, the orbit's normal r x v is -y.
    ref = reference.lvlh(np.array([7.0e6, 0.0, 0.0]), np.array([0.0, 0.0, 7.0e3]))
    np.testing.assert_allclose(ref.R_d[:, 0], [0.0, 0.0, 1.0], atol=1e-15)
    np.testing.assert_allclose(ref.R_d[:, 1], [0.0, 1.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(ref.R_d[:, 2], [-1.0, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(ref.Omega_d, [0.0, -1.0e-3, 0.0], atol=1e-18)
    np.testing.assert_allclose(ref.dOmega_d, [0.0, 0.0, 0.0], atol=1e-21)


def test_lvlh_of_a_climbing_satellite_by_hand():
    # Climbing at 3 km/s slows the frame's turn: dn/dt = -2 n (r.v)/r^2 = -2 x 1e-3 x 3e3/7e6.
    ref = reference.lvlh(np.array([7.0e6, 0.0, 0.0]), np.array([3.0e3, 0.0, 7.0e3]))
    np.testing.assert_allclose(ref.R_d[:, 0], [0.0, 0.0, 1.0], atol=1e-15)
    np.testing.assert_allclose(ref.dOmega_d, [0.0, 6.0 / 7.0 * 1e-6, 0.0], rtol=1e-14, atol=1e-21)


def test_lvlh_rate_of_the_papers_orbit():
    r = 6.971e6
    v = math.sqrt(MU / r)
    inclination = math.radians(98.0)
    ref = reference.lvlh(np.array([r, 0.0, 0.0]), v * np.array([0.0, math.cos(inclination), math.sin(inclination)]))
    assert ref.Omega_d[1] == pytest.approx(-0.001085, abs=5e-7)
    assert 2 * math.pi / -ref.Omega_d[1] == pytest.approx(5791.0, abs=2.0)


def test_lvlh_rates_are_the_derivatives_of_its_attitude_on_an_eccentric_inclined_orbit():
    def two_body(_, y):
        return [*y[3:], *(-MU / np.linalg.norm(y[:3]) ** 3 * y[:3])]

    start = [5.1e6, -3.9e6, 2.2e6, 3.1e3, 6.9e3, 3.3e3]
    orbit = solve_ivp(two_body, (0.0, 3000.0), start, method="DOP853", rtol=1e-13, atol=1e-6, dense_output=True).sol
    h = 0.5
    for t in (100.0, 900.0, 2500.0):
        before, here, after = (reference.lvlh(orbit(s)[:3], orbit(s)[3:]) for s in (t - h, t, t + h))
        turn = Rotation.from_matrix(before.R_d.T @ after.R_d).as_rotvec() / (2 * h)
        np.testing.assert_allclose(turn, here.Omega_d, rtol=0, atol=3e-9 * np.linalg.norm(here.Omega_d) + 1e-10)
        change = (after.Omega_d - before.Omega_d) / (2 * h)
        assert abs(here.dOmega_d[1]) > 1e-7  # the orbit is eccentric enough to tell
        np.testing.assert_allclose(change, here.dOmega_d, rtol=1e-5, atol=1e-18)
        np.testing.assert_allclose(here.R_d.T @ here.R_d, np.eye(3), atol=1e-15)
        assert np.linalg.det(here.R_d) == pytest.approx(1.0)


def test_rate_reference_turns_with_its_body_rate():
    R_d0 = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
    rate = np.array([0.3, -0.2, 0.45])
    for t in (0.0, 1e-9, 3.7, 250.0):
        ref = reference.rate(R_d0, rate, t)
        expected = Rotation.from_matrix(R_d0) * Rotation.from_rotvec(t * rate)
        np.testing.assert_allclose(ref.R_d, expected.as_matrix(), atol=1e-13)
        np.testing.assert_array_equal(ref.Omega_d, rate)
        np.testing.assert_array_equal(ref.dOmega_d, np.zeros(3))
        h = 1e-5
        slope = (reference.rate(R_d0, rate, t + h).R_d - reference.rate(R_d0, rate, t - h).R_d) / (2 * h)
        np.testing.assert_allclose(slope, ref.R_d @ so3.hat(ref.Omega_d), atol=2e-9)


@pytest.mark.parametrize(
    ("r_N", "v_N"),
    [
        ([0.0, 0.0, 0.0], [0.0, 7.5e3, 0.0]),
        ([7e6, 0.0, 0.0], [0.0, 0.0, 0.0]),
        ([7e6, -7e6, 3e6], [-7e3, 7e3, -3e3]),
        ([1e-200, 0.0, 0.0], [0.0, 7.5e3, 0.0]),
    ],
)
def test_lvlh_without_an_orbits_plane_is_refused(r_N, v_N):
    with pytest.raises(ValueError, match=r"r_N, v_N: reference 'lvlh' expects .* found r_N = "):
        reference.lvlh(np.array(r_N), np.array(v_N))


@pytest.mark.parametrize(("angle", "spans"), [(2e-9, True), (0.5e-9, False)])
def test_lvlh_needs_a_velocity_a_billionth_of_a_radian_off_the_position(angle, spans):
    r_N, v_N = np.array([7e6, 0.0, 0.0]), 7.5e3 * np.array([math.cos(angle), 0.0, math.sin(angle)])
    if spans:
        assert reference.lvlh(r_N, v_N).Omega_d[1] == pytest.approx(-7.5e3 * angle / 7e6)
    else:
        with pytest.raises(ValueError, match="span the orbit's plane"):
            reference.lvlh(r_N, v_N)
