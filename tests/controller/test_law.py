"""The law [8] against a body that SciPy integrates; see loop.py.

Shows CT-1.
"""

import numpy as np
import pytest
from scipy.optimize import approx_fprime
from scipy.spatial.transform import Rotation

import controller
from controller import law, morse
from tests.controller import loop

SAMPLES = [
    Rotation.identity(),
    Rotation.from_rotvec([0.0, 1e-9, 0.0]),
    *Rotation.random(6, random_state=3),
    Rotation.from_rotvec((np.pi - 1e-9) * np.array([0.48, -0.6, 0.64])),
    Rotation.from_rotvec(np.pi * np.array([0.0, 0.6, 0.8])),
]


def turned(Q, x):
    return Q @ Rotation.from_rotvec(x).as_matrix()


@pytest.mark.parametrize("choice", morse.PHI)
def test_gradient_of_the_error_function_by_finite_differences(choice):
    K = np.array([0.7, 1.1, 1.9])
    for rotation in SAMPLES:
        Q = rotation.as_matrix()
        slope = morse.phi(choice, 0.8, morse.trace(K, Q))[1]

        def value(x, Q=Q):
            return morse.phi(choice, 0.8, morse.trace(K, turned(Q, x)))[0]

        h = 1e-5
        numerical = [(value(h * e) - value(-h * e)) / (2 * h) for e in np.eye(3)]
        # Along dQ/dt = Q omega^ the function changes by -Phi' omega . sum k_i e_i x Q^T e_i [7].
        np.testing.assert_allclose(-slope * morse.slope_direction(K, Q), numerical, rtol=0, atol=2e-9)


def test_slope_direction_is_the_papers_sum():
    K = np.array([0.7, 1.1, 1.9])
    for rotation in SAMPLES:
        Q = rotation.as_matrix()
        paper = sum(k * np.cross(e, Q.T @ e) for k, e in zip(K, np.eye(3), strict=True))
        np.testing.assert_allclose(morse.slope_direction(K, Q), paper, rtol=0, atol=1e-15)


@pytest.mark.parametrize("choice", morse.PHI)
def test_phi_rises_from_zero_with_slope_one_and_bends_down(choice):
    assert morse.phi(choice, 2.0, 0.0) == (0.0, 1.0)
    assert morse.phi(choice, 2.0, -1e-17) == (0.0, 1.0)
    assert morse.phi(choice, 2.0, 1e-12)[0] == pytest.approx(1e-12, rel=1e-9)
    for x in (0.3, 2.0, 9.0):
        value, slope = morse.phi(choice, 2.0, x)
        assert value == pytest.approx(loop.PHI[choice](x, 2.0), rel=1e-14)
        assert slope == pytest.approx(
            (loop.PHI[choice](x + 1e-5, 2.0) - loop.PHI[choice](x - 1e-5, 2.0)) / 2e-5, rel=1e-9
        )
        assert 0.0 < slope <= 1.0


@pytest.mark.parametrize("reference", ["lvlh", "inertial", "rate", "given"])
@pytest.mark.parametrize("phi", morse.PHI)
@pytest.mark.parametrize("gravity", [True, False])
def test_lyapunov_function_falls_by_exactly_what_the_damping_takes(reference, phi, gravity, rng):
    """dV/dt = -omega.L omega, from finite differences of a V made of inertial vectors, along the body's own motion."""
    p = loop.law(reference=reference, phi=phi, compensate_gravity=gravity)
    h = 1e-5
    for rotation, Omega in zip(SAMPLES, rng.normal(size=(len(SAMPLES), 3)), strict=True):
        y, t = loop.state(rotation, Omega), 0.9
        dy = loop.derivative(p, t, y)
        slope = (loop.energy(p, t + h, y + h * dy) - loop.energy(p, t - h, y - h * dy)) / (2 * h)
        omega = loop.rate_error(p, t, y)
        assert slope == pytest.approx(-loop.LAMBDA * omega @ loop.L0 @ omega, abs=2e-7)


@pytest.mark.parametrize("reference", ["lvlh", "inertial", "rate", "given"])
def test_closed_loop_obeys_the_error_dynamics(reference, rng):
    """J domega/dt along the body's motion is the right side of [6] once [8] stands in it; all its components."""
    p = loop.law(reference=reference, phi="logarithm")
    K, L = loop.KAPPA * loop.K0, loop.LAMBDA * loop.L0
    t, h = 0.9, 1e-5
    for rotation, Omega in zip(SAMPLES, rng.normal(size=(len(SAMPLES), 3)), strict=True):
        y = loop.state(rotation, Omega)
        dy = loop.derivative(p, t, y)
        domega = (loop.rate_error(p, t + h, y + h * dy) - loop.rate_error(p, t - h, y - h * dy)) / (2 * h)
        R_d, w_d = loop.desired(p, t, y[7:10], y[10:13])
        Q, psi, omega = (R_d.inv() * rotation).as_matrix(), rotation.inv().apply(w_d), loop.rate_error(p, t, y)
        slope = 1.0 / (1.0 + K @ (1 - np.diag(Q)) / p.phi_scale)
        restoring = slope * sum(k * np.cross(e, Q.T @ e) for k, e in zip(K, np.eye(3), strict=True))
        # What is left of the gyroscopic terms does no work on omega.
        turning = (
            loop.J @ np.cross(omega, psi) - np.cross(omega, loop.J @ (omega + psi)) - np.cross(psi, loop.J @ omega)
        )
        assert omega @ turning == pytest.approx(0.0, abs=1e-13)
        np.testing.assert_allclose(loop.J @ domega, -L @ omega + restoring + turning, rtol=0, atol=1e-8)


@pytest.mark.fly
@pytest.mark.parametrize(
    ("reference", "rotation", "Omega"), [("lvlh", SAMPLES[3], [1.2, -0.9, 0.7]), ("rate", SAMPLES[6], [-2.0, 1.0, 1.5])]
)
@pytest.mark.thorough
def test_a_tumble_settles_and_its_lyapunov_value_never_rises(reference, rotation, Omega):
    p = loop.law(reference=reference)
    solution = loop.fly(p, rotation, np.array(Omega), 60.0)
    times = np.linspace(0.0, 60.0, 601)
    values = []
    for t in times:
        y = solution(t)
        out = controller.outputs(controller.State(t, 0.0, 0.0), loop.block_inputs(y, p, t), p)
        values.append(out.lyapunov)
        assert out.lyapunov == pytest.approx(loop.energy(p, t, y), abs=1e-12)
        np.testing.assert_allclose(out.rate_error_B, loop.rate_error(p, t, y), rtol=0, atol=1e-12)
    assert np.diff(values).max() < 1e-9
    dissipated = np.array([solution(t)[13] for t in times])
    np.testing.assert_allclose(values + dissipated, values[0], rtol=0, atol=2e-7)
    assert out.attitude_error < 1e-3
    assert values[-1] < 1e-6 * values[0]


HALF_TURNS = [np.diag(d) for d in ([1.0, 1, 1], [1.0, -1, -1], [-1.0, 1, -1], [-1.0, -1, 1])]


@pytest.mark.parametrize("reference", ["lvlh", "inertial", "rate"])
def test_identity_and_the_three_half_turns_are_equilibria_of_the_error(reference):
    p = loop.law(reference=reference)
    for Q in HALF_TURNS:
        R_d, w_d = loop.desired(p, 0.9, loop.ORBIT[:3], loop.ORBIT[3:])
        rotation = R_d * Rotation.from_matrix(Q)
        y = loop.state(rotation, rotation.inv().apply(w_d))
        h, dy = 1e-5, loop.derivative(p, 0.9, y)
        domega = (loop.rate_error(p, 0.9 + h, y + h * dy) - loop.rate_error(p, 0.9 - h, y - h * dy)) / (2 * h)
        np.testing.assert_allclose(domega, 0.0, atol=1e-8)
        np.testing.assert_allclose(loop.rate_error(p, 0.9, y), 0.0, atol=1e-15)


@pytest.mark.parametrize(("Q", "unstable"), list(zip(HALF_TURNS, [0, 3, 2, 1], strict=True)))
def test_only_the_identity_is_stable_and_each_half_turn_has_its_own_index(Q, unstable):
    p = loop.law(reference="inertial", compensate_gravity=False)

    def closed_loop(x):
        """d(zeta, omega)/dt near Q: R = R_d Q exp(zeta^); at zeta near 0, dzeta/dt = omega to first order."""
        rotation = loop.R_D0 * Rotation.from_matrix(Q) * Rotation.from_rotvec(x[:3])
        return np.array([*x[3:], *loop.acceleration(p, 0.0, loop.state(rotation, x[3:]))])

    matrix = np.column_stack([(closed_loop(1e-6 * e) - closed_loop(-1e-6 * e)) / 2e-6 for e in np.eye(6)])
    K, L = np.diag(loop.KAPPA * loop.K0), loop.LAMBDA * loop.L0
    hessian = np.trace(K @ Q) * np.eye(3) - K @ Q
    inverse = np.linalg.inv(loop.J)
    closed_form = np.block([[np.zeros((3, 3)), np.eye(3)], [-inverse @ hessian, -inverse @ L]])
    found, expected = (np.sort_complex(np.linalg.eigvals(m)) for m in (matrix, closed_form))
    np.testing.assert_allclose(found, expected, atol=1e-7)
    assert (found.real > 1e-3).sum() == unstable
    assert (found.real < -1e-3).sum() == 6 - unstable


def test_gravity_gradient_is_that_of_its_potential():
    """[2]: M_g^ = (dU/dR)^T R - R^T (dU/dR), dU/dR by differences; what of U depends on R is 3/2 mu/r^3 r_B.J r_B."""
    mu, r_N = 3.986004418e14, np.array([4.1e6, -5.2e6, 2.3e6])
    r = np.linalg.norm(r_N)
    for rotation in SAMPLES:

        def potential(R):
            r_B = R.reshape(3, 3).T @ r_N / r
            return 1.5 * r_B @ loop.J @ r_B

        R = rotation.as_matrix()
        V = approx_fprime(R.ravel(), potential, 1e-7).reshape(3, 3)
        scale = mu / r**3
        skew = V.T @ R - R.T @ V
        expected = np.array([skew[2, 1], skew[0, 2], skew[1, 0]]) * scale
        np.testing.assert_allclose(law.gravity_gradient(mu, loop.J, R, r_N), expected, rtol=0, atol=3e-6 * scale)


def test_gravity_gradient_by_hand():
    """A body pitched 45 deg, J = diag(2, 3, 4): 3 n^2 (J1 - J3) sin 45 cos 45 about Y, n^2 = 1e-6 at mu/r^3 = 1e-6."""
    R = Rotation.from_euler("y", 45, degrees=True).as_matrix()
    M_g = law.gravity_gradient(1e-6 * 7e6**3, np.diag([2.0, 3.0, 4.0]), R, np.array([0.0, 0.0, -7e6]))
    np.testing.assert_allclose(M_g, [0.0, 3e-6, 0.0], atol=1e-18)
    with pytest.raises(ValueError, match=r"r_N: expected .* found"):
        law.gravity_gradient(1e14, loop.J, np.eye(3), np.zeros(3))
