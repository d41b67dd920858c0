"""Slews: closed forms of the quintic, limits, and continuity where they begin and end.

Shows SV-2.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supervisor import reference, slew
from supervisor.reference import Reference

J = np.array([[2.13, 0.1, 0.2], [0.1, 3.04, 0.3], [0.2, 0.3, 3.09]])
REST = np.zeros(3)
TO = reference.inertial(np.eye(3))
EIGENAXIS = np.array([0.48, -0.6, 0.64])


@pytest.mark.parametrize("angle", [1e-6, 0.3, 1.9, math.pi])
@pytest.mark.parametrize("torque", [1e-5, 1e-2])
def test_from_rest_to_rest_it_is_the_quintic_about_the_eigenaxis_at_exactly_one_limit(
    angle: float, torque: float
) -> None:
    """theta(x) = theta0 (1 - 10 x^3 + 15 x^4 - 6 x^5): peaks 15/8 theta0/T and 10/sqrt(3) theta0/T^2 at x = 1/2 and (3
    - sqrt 3)/6."""
    rate_max = 0.01
    now = reference.inertial(Rotation.from_rotvec(angle * EIGENAXIS).as_matrix())
    found = slew.begin(now, TO, J, rate_max, torque)
    T = found.duration
    unit = np.linalg.norm(J @ EIGENAXIS)
    assert max(1.875 * angle / T / rate_max, 10 / math.sqrt(3) * angle * unit / T**2 / torque) == pytest.approx(
        1.0, rel=1e-6
    )
    for x in (0.0, (3 - math.sqrt(3)) / 6, 0.5, 0.8, 1.0):
        y = slew.at(found, x * T, TO)
        share = 1 - 10 * x**3 + 15 * x**4 - 6 * x**5
        left = Rotation.from_matrix(y.R_ref).as_rotvec()
        assert abs(abs(left @ EIGENAXIS) - angle * share) < 1e-9  # of a half turn either sense is the shortest
        np.testing.assert_allclose(np.cross(left, EIGENAXIS), 0.0, atol=1e-8)
        assert np.linalg.norm(y.Omega_ref) == pytest.approx(30 * angle / T * (x - x * x) ** 2, abs=1e-9 * angle / T)
    steepest = slew.at(found, 0.5 * T, TO).Omega_ref
    hardest = slew.at(found, (3 - math.sqrt(3)) / 6 * T, TO).dOmega_ref
    assert np.linalg.norm(steepest) <= rate_max * (1 + 1e-9)
    assert np.linalg.norm(J @ hardest) <= torque * (1 + 1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_with_an_initial_rate_attitude_and_rate_are_continuous_and_the_torque_stays_within_its_limit(seed: int) -> None:
    rng = np.random.default_rng(seed)
    torque, rate_max = 2e-4, 0.02
    now = Reference(Rotation.random(random_state=rng).as_matrix(), rng.normal(scale=2e-3, size=3), REST)
    to = Reference(Rotation.random(random_state=rng).as_matrix(), rng.normal(scale=1e-3, size=3), REST)
    found = slew.begin(now, to, J, rate_max, torque)
    begin = slew.at(found, 0.0, to)
    np.testing.assert_allclose(begin.R_ref, now.R_ref, atol=1e-12)
    np.testing.assert_allclose(begin.Omega_ref, now.Omega_ref, atol=1e-14)
    end = slew.at(found, found.duration * (1 - 1e-9), to)
    np.testing.assert_allclose(end.R_ref, to.R_ref, atol=1e-9)
    np.testing.assert_allclose(end.Omega_ref, to.Omega_ref, atol=1e-9)
    np.testing.assert_allclose(end.dOmega_ref, to.dOmega_ref, atol=1e-9)
    # The turn itself: seen from a destination at rest it is exp(phi^).
    turns = [Rotation.from_matrix(slew.at(found, s, TO).R_ref) for s in np.linspace(0.0, found.duration, 401)]
    phi = np.array([_near(turn.as_rotvec(), found.phi0) for turn in turns])
    h = found.duration / 400
    assert np.linalg.norm(np.diff(phi, 2, axis=0) @ J, axis=1).max() / h**2 <= torque * (1 + 1e-3)
    assert np.linalg.norm(np.diff(phi, axis=0), axis=1).max() / h <= rate_max * (1 + 1e-9)


def _near(phi: np.ndarray, like: np.ndarray) -> np.ndarray:
    """The rotation vector of the same turn beyond pi where that continues `like`."""
    angle = np.linalg.norm(phi)
    return phi if phi @ like >= 0.0 or angle < 2.0 else phi * (1.0 - 2.0 * math.pi / angle)


def test_nothing_to_turn_takes_no_time() -> None:
    assert slew.begin(TO, TO, J, 0.01, 1e-4).duration == 0.0
