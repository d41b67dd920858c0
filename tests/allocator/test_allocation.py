"""[14]-[24] against NumPy's least-norm solution, SciPy's rotations and hand numbers.

Shows AL-1.
"""

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation

from allocator import allocation
from allocator.allocation import Singular

RNG = np.random.default_rng(14)
U_PAPER = np.array([[1, 1, -1], [1, -1, 1], [0, 0, np.sqrt(3)]]) / np.sqrt(3)


def unit(x):
    return x / np.linalg.norm(x)


def rods():
    return np.array([unit(v) for v in RNG.normal(size=(3, 3))])


def case():
    """A demand, a field, a rate, a wheel momentum and rods, none aligned with another."""
    return (
        RNG.normal(size=3) * 1e-4,
        unit(RNG.normal(size=3)) * RNG.uniform(2e-5, 6e-5),
        RNG.normal(size=3) * 0.05,
        RNG.uniform(-0.03, 0.03),
        rods(),
    )


CASES = [case() for _ in range(40)]
CASES += [(tau, b, omega, h, U_PAPER) for tau, b, omega, h, _ in CASES[:10]]


def field_torque(U, b_B):
    """[16] as a matrix, column i the torque of a unit dipole in rod i."""
    return np.cross(U, b_B).T


def test_wheel_and_rods_together_give_the_demand():
    for tau, b, omega, h, U in CASES:
        dipole, dh = allocation.allocate(tau, b, omega, h, U)
        by_rods = sum(np.cross(mu * u, b) for mu, u in zip(dipole, U, strict=True))
        e1 = np.array([1.0, 0.0, 0.0])
        by_wheel = -(dh * e1 + h * np.cross(omega, e1))
        np.testing.assert_allclose(by_rods + by_wheel, tau, rtol=0, atol=1e-13 * max(abs(dh), 1e-3))


def test_dipoles_are_numpys_least_norm_solution():
    for tau, b, omega, h, U in CASES:
        dipole, dh = allocation.allocate(tau, b, omega, h, U)
        wanted = tau + np.array([dh, omega[2] * h, -omega[1] * h])
        matrix = field_torque(U, b)
        least = np.linalg.lstsq(matrix, wanted, rcond=1e-9)[0]
        np.testing.assert_allclose(dipole, least, rtol=0, atol=1e-10 * np.linalg.norm(least))
        np.testing.assert_allclose(
            dipole, np.linalg.pinv(matrix, rcond=1e-9) @ wanted, rtol=0, atol=1e-10 * np.linalg.norm(least)
        )


def test_dipoles_waste_nothing_along_the_field():
    """The combination of rods whose moment lies along the field gives no torque; the least dipole has none of it."""
    for tau, b, omega, h, U in CASES:
        dipole, _ = allocation.allocate(tau, b, omega, h, U)
        idle = null_space(field_torque(U, b / np.linalg.norm(b)), rcond=1e-9)
        assert idle.shape == (3, 1)
        np.testing.assert_allclose(np.cross(idle[:, 0] @ U, b), 0.0, atol=1e-18)
        assert dipole @ idle[:, 0] == pytest.approx(0.0, abs=1e-11 * np.linalg.norm(dipole))


def test_wheel_supplies_all_of_the_demand_along_the_field():
    for tau, b, omega, h, _ in CASES:
        b_hat = unit(b)
        dh = allocation.wheel_torque(tau, b_hat, omega, h)
        reaction = allocation.wheel_reaction(dh, h, omega)
        assert reaction @ b_hat == pytest.approx(tau @ b_hat, abs=1e-14 * max(abs(dh), 1e-3))


def test_wheel_torque_and_dipoles_by_hand():
    # b = (0.6, 0, 0.8), 5e-5 T: [20] gives -(0.6e-3 - 0.8e-3 + 0 - 0.02 x 0.005 x 0.8)/0.6 = (0.2e-3 + 0.08e-3)/0.6.
    tau, b = np.array([1e-3, 2e-3, -1e-3]), 5e-5 * np.array([0.6, 0.0, 0.8])
    dipole, dh = allocation.allocate(tau, b, np.array([0.3, 0.02, -0.04]), 0.005, np.eye(3))
    assert dh == pytest.approx(0.28e-3 / 0.6)
    # tau_MT = tau + (dh, -0.04 x 0.005, -0.02 x 0.005) = (1.4667, 1.8, -1.1) mN m;
    # on orthogonal rods m = b x tau_MT/B^2.
    expected = np.cross(b, [1e-3 + 0.28e-3 / 0.6, 1.8e-3, -1.1e-3]) / 25e-10
    np.testing.assert_allclose(dipole, expected, rtol=1e-12)
    np.testing.assert_allclose(dipole, [-28.8, 36.6666667, 21.6], rtol=1e-8)


def test_wheel_reaction_is_the_loss_of_its_momentum_seen_from_the_turning_body():
    """tau_RW = -d(l_w e1)/dt taken in inertial axes, by finite differences [14]."""
    for _, _, omega, h, _ in CASES[:10]:
        dh, R, s = 2.3e-3, Rotation.random(random_state=1), 1e-4

        def momentum(t, R=R, omega=omega, h=h, dh=dh):
            return (R * Rotation.from_rotvec(omega * t)).apply([h + dh * t, 0.0, 0.0])

        loss = -(momentum(s) - momentum(-s)) / (2 * s)
        np.testing.assert_allclose(allocation.wheel_reaction(dh, h, omega), R.inv().apply(loss), rtol=0, atol=1e-11)


def test_rod_torque_is_dipole_cross_field():
    for tau, b, _, _, U in CASES[:10]:
        np.testing.assert_allclose(
            allocation.rod_torque(1e5 * tau, U, b), field_torque(U, b) @ (1e5 * tau), rtol=0, atol=1e-18
        )


def test_basis_is_orthonormal_across_the_field_and_starts_from_the_demand():
    for tau, b, *_ in CASES:
        b_hat = unit(b)
        n, c = allocation.plane(b_hat, tau)
        frame = np.column_stack([n, c, b_hat])
        np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-14)
        assert np.linalg.det(frame) == pytest.approx(1.0)
        np.testing.assert_allclose(n @ tau, np.linalg.norm(tau - (tau @ b_hat) * b_hat), rtol=1e-12)


def test_least_dipole_does_not_depend_on_the_basis(rng):
    for tau, b, omega, h, U in CASES:
        B, b_hat = allocation.field(b)
        rest = tau - allocation.wheel_reaction(allocation.wheel_torque(tau, b_hat, omega, h), h, omega)
        dipole = allocation.least_dipole(rest, tau, B, b_hat, U)
        for chooser in (rng.normal(size=3), b_hat, np.zeros(3), -tau):
            other = allocation.least_dipole(rest, chooser, B, b_hat, U)
            np.testing.assert_allclose(other, dipole, rtol=0, atol=1e-12 * np.linalg.norm(dipole))


@pytest.mark.parametrize("factor", [1.0, -1.0, 1.0 + 1e-15])
def test_demand_along_the_field_still_has_a_basis_and_is_met(factor):
    for _, b, omega, h, U in CASES:
        tau = 10.0 * factor * b
        n, c = allocation.plane(unit(b), tau)
        assert abs(n @ unit(b)) < 1e-15
        assert np.linalg.norm(n) == pytest.approx(1.0)
        assert np.linalg.norm(c) == pytest.approx(1.0)
        dipole, dh = allocation.allocate(tau, b, omega, h, U)
        given = field_torque(U, b) @ dipole + allocation.wheel_reaction(dh, h, omega)
        np.testing.assert_allclose(given, tau, rtol=0, atol=1e-13 * max(abs(dh), 1e-3))


def test_zero_demand_of_a_still_wheel_asks_for_nothing():
    for b in (CASES[0][1], np.array([0.0, 3e-5, 1e-5])):
        dipole, dh = allocation.allocate(np.zeros(3), b, np.array([0.1, 0.2, 0.3]), 0.0, U_PAPER)
        np.testing.assert_array_equal(dipole, 0.0)
        assert dh == 0.0


def test_zero_demand_of_a_spinning_wheel_cancels_its_gyroscopic_torque():
    _, b, omega, h, U = CASES[3]
    dipole, dh = allocation.allocate(np.zeros(3), b, omega, h, U)
    given = field_torque(U, b) @ dipole + allocation.wheel_reaction(dh, h, omega)
    assert np.linalg.norm(dipole) > 0.1
    np.testing.assert_allclose(given, 0.0, atol=1e-15)


@pytest.mark.parametrize("b1", [0.0, 1e-10, -1e-10])
def test_field_normal_to_the_wheel_is_singular_unless_nothing_is_wanted_along_it(b1):
    b_hat, still = np.array([b1, 1.0, 0.0]), np.zeros(3)
    with pytest.raises(Singular, match="normal to the wheel"):
        allocation.wheel_torque(np.array([0.0, 1e-6, 0.0]), b_hat, still, 0.0)
    assert allocation.wheel_torque(np.array([0.0, 0.0, 1e-3]), b_hat, still, 0.0) == 0.0
    with pytest.raises(Singular, match="normal to the wheel"):
        allocation.wheel_torque(np.zeros(3), b_hat, np.array([0.0, 0.0, 0.1]), 0.002)


def test_wheel_torque_grows_as_the_inverse_of_the_fields_part_along_the_wheel():
    for b1 in (1e-2, 1e-5, 1e-8, -1e-8):
        b_hat = unit(np.array([b1, 0.6, 0.8]))
        dh = allocation.wheel_torque(np.array([0.0, 0.0, 1e-3]), b_hat, np.zeros(3), 0.0)
        assert dh == pytest.approx(-0.8e-3 / b1, rel=1e-3)


@pytest.mark.parametrize("b_B", [[0.0, 0.0, 0.0], [1e-13, 0.0, 0.0], [1e-200, 1e-200, 0.0]])
def test_zero_field_is_singular(b_B):
    with pytest.raises(Singular, match="no direction"):
        allocation.allocate(np.zeros(3), np.array(b_B), np.zeros(3), 0.0, U_PAPER)


def test_coplanar_rods_are_singular_only_while_the_field_lies_in_their_plane():
    flat = np.array([[1.0, 0.0, 0.0], [0.6, 0.8, 0.0], [0.0, 1.0, 0.0]])
    tau, still = np.array([1e-4, -2e-4, 3e-4]), np.zeros(3)
    with pytest.raises(Singular, match="span no plane across the field"):
        allocation.allocate(tau, np.array([3e-5, 2e-5, 0.0]), still, 0.0, flat)
    b = np.array([3e-5, 2e-5, 1e-6])
    dipole, dh = allocation.allocate(tau, b, still, 0.0, flat)
    np.testing.assert_allclose(field_torque(flat, b) @ dipole - np.array([dh, 0, 0]), tau, rtol=0, atol=1e-13)


def test_demand_fraction_is_that_of_the_most_loaded_actuator():
    assert allocation.demand_fraction(np.array([3.0, -20.0, 1.0]), 1e-3, 25.0, 3e-3) == pytest.approx(0.8)
    assert allocation.demand_fraction(np.array([3.0, -5.0, 1.0]), -2.7e-3, 25.0, 3e-3) == pytest.approx(0.9)
    assert allocation.demand_fraction(np.array([3.0, -5.0, 9.0]), -1e-6, 10.0, 3e-3) == pytest.approx(0.9)
    assert allocation.demand_fraction(np.array([-8.0, 3.0, 1.0]), -1e-6, 10.0, 3e-3) == pytest.approx(0.8)
    assert allocation.demand_fraction(np.array([3.0, np.nan, 9.0]), 0.0, 10.0, 3e-3) == np.inf


LIMITS = {"dipole_max": 20.0, "wheel_torque_max": 2e-3, "wheel_momentum_max": 0.02}


def test_achieved_torque_clips_each_actuator():
    b, omega, U = CASES[0][1], CASES[0][2], CASES[0][4]
    given = allocation.achieved(np.array([30.0, -7.0, -50.0]), -9e-3, b, omega, 0.01, U, **LIMITS)
    expected = field_torque(U, b) @ [20.0, -7.0, -20.0] + [2e-3, -omega[2] * 0.01, omega[1] * 0.01]
    np.testing.assert_allclose(given, expected, rtol=0, atol=1e-17)


@pytest.mark.parametrize(
    ("h_w", "command", "turning"),
    [
        (0.02, 1e-3, 0.0),
        (0.02, -1e-3, -1e-3),
        (-0.02, -1e-3, 0.0),
        (-0.02, 1e-3, 1e-3),
        (0.021, 1e-3, 0.0),
        (0.0199999, 1e-3, 1e-3),
    ],
)
def test_a_full_wheel_turns_only_inwards(h_w, command, turning):
    given = allocation.achieved(np.zeros(3), command, CASES[0][1], np.array([0.1, 0.2, 0.3]), h_w, U_PAPER, **LIMITS)
    np.testing.assert_allclose(given, [-turning, -0.3 * h_w, 0.2 * h_w], rtol=0, atol=1e-17)
