"""The controller without attitude or reference, and what it stores when a reference comes, goes or jumps.

That a given reference is followed in full, its rate's derivative among it, test_law.py shows on the error dynamics.

Shows CT-3.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import controller
from controller.reference import lvlh
from tests.blocks import inputs, parameters

from . import loop

ZEROS = np.zeros((3, 3))
R_NB = Rotation.from_rotvec([0.4, -0.3, 0.8]).as_matrix()
GIVEN = {"R_ref": np.eye(3), "Omega_ref": np.array([0.01, 0.02, -0.01]), "dOmega_ref": np.array([1e-4, -2e-4, 3e-4])}


@pytest.mark.parametrize("Q", [np.eye(3), Rotation.from_rotvec([0.3, -1.2, 0.5]).as_matrix()])
def test_the_values_of_an_attitude_at_rest_in_lvlh_by_the_ports_give_what_the_parameters_give(Q) -> None:
    p = parameters("controller", reference="lvlh", R_d0=Q)
    u = inputs("controller", R_NB=R_NB, omega_B=[0.01, 0.02, 0.03])
    R_d, Omega_d, dOmega_d = lvlh(u.r_N, u.v_N)
    by_ports = replace(u, R_ref=R_d @ p.desired_attitude_0, Omega_ref=Q.T @ Omega_d, dOmega_ref=Q.T @ dOmega_d)
    x = controller.start(p, u)
    assert vars(x) == pytest.approx(vars(controller.start(p, by_ports)))
    y, of_ports = controller.outputs(x, u, p), controller.outputs(x, by_ports, p)
    for name, value in vars(y).items():
        np.testing.assert_allclose(getattr(of_ports, name), value, rtol=1e-13, atol=1e-17)


AT_REST = {"R_ref": ZEROS, "Omega_ref": np.zeros(3)}


@pytest.mark.parametrize("missing", [{"R_NB": ZEROS}, AT_REST, {"R_NB": ZEROS, **AT_REST}])
@pytest.mark.parametrize("schedule", ["error", "constant"])
def test_without_attitude_or_reference_the_law_takes_exactly_the_energy_of_its_damping(missing, schedule) -> None:
    """A free body under tau: dV/dt = -Omega.L Omega with V its kinetic energy, by differences of Euler's equation."""
    p = loop.law(gain_schedule=schedule)
    for Omega in np.random.default_rng(3).normal(size=(5, 3)):
        u = inputs("controller", **{**GIVEN, "R_NB": R_NB, **missing, "omega_B": Omega})
        y = controller.outputs(controller.start(p, u), u, p)
        h = 1e-6
        after = Omega + h * np.linalg.solve(loop.J, y.tau_cmd_B - np.cross(Omega, loop.J @ Omega))
        power = 0.5 * (after @ loop.J @ after - Omega @ loop.J @ Omega) / h
        rate = math.dist(Omega, (0, 0, 0))
        scale = p.lambda0 * (p.c1 + rate) / (p.c2 + rate) if schedule == "error" else p.lambda0
        assert y.gain_l == pytest.approx(scale)
        assert power == pytest.approx(-scale * Omega @ loop.L0 @ Omega, rel=1e-4)
        assert y.lyapunov == pytest.approx(0.5 * Omega @ loop.J @ Omega)
        assert (y.gain_k, y.attitude_error) == (0.0, math.pi)
        assert y.no_attitude == ("R_NB" in missing)


@pytest.mark.parametrize("R_NB", [ZEROS, R_NB])
def test_where_only_the_attitude_of_the_reference_is_missing_its_rate_is_followed_in_body_axes(R_NB) -> None:
    """tau = -L (Omega - Omega_ref); its rate is not used where the reference has an attitude and the satellite none."""
    p = parameters("controller", gain_schedule="constant")
    Omega = np.array([0.03, -0.01, 0.02])
    u = inputs("controller", **{**GIVEN, "R_NB": R_NB, "R_ref": ZEROS, "omega_B": Omega})
    y = controller.outputs(controller.start(p, u), u, p)
    np.testing.assert_allclose(y.tau_cmd_B, -p.lambda0 * p.L0 @ (Omega - GIVEN["Omega_ref"]), rtol=1e-14)
    np.testing.assert_array_equal(y.rate_error_B, Omega - GIVEN["Omega_ref"])
    at_rest = inputs("controller", **{**GIVEN, "R_NB": ZEROS, "omega_B": Omega})
    np.testing.assert_array_equal(controller.outputs(controller.start(p, at_rest), at_rest, p).rate_error_B, Omega)


def test_a_time_without_reference_begins_the_gain_schedule_anew_and_a_jump_does_not() -> None:
    """[10] divides by a2 + |zeta(0)|: of the first attitude with a reference, and of the first after a time without."""
    p = parameters("controller")
    first = inputs("controller", R_NB=R_NB, **GIVEN)
    x, y = controller.step(controller.start(p, first), first, p, 0.1)
    jumped = replace(first, R_ref=Rotation.from_rotvec([0.0, 2.0, 0.0]).as_matrix())
    x, after_jump = controller.step(x, jumped, p, 0.1)
    angle = Rotation.from_matrix(R_NB).magnitude()
    assert y.gain_k == pytest.approx(p.kappa0 * (p.a1 + angle) / (p.a2 + angle))
    assert after_jump.gain_k == pytest.approx(p.kappa0 * (p.a1 + after_jump.attitude_error) / (p.a2 + angle))
    x, without = controller.step(x, replace(first, R_ref=ZEROS), p, 0.1)
    assert without.gain_k == 0.0
    x, anew = controller.step(x, jumped, p, 0.1)
    assert anew.gain_k == pytest.approx(p.kappa0 * (p.a1 + anew.attitude_error) / (p.a2 + anew.attitude_error))
    assert anew.gain_k != after_jump.gain_k


def test_an_attitude_that_is_lost_is_taken_only_from_one_who_gives_a_reference() -> None:
    p = parameters("controller")
    for given, taken in ((GIVEN, True), ({}, False)):
        u = inputs("controller", R_NB=R_NB, omega_B=[0.01, 0.0, 0.0], **given)
        x, _ = controller.step(controller.start(p, u), u, p, 0.1)
        lost = replace(u, R_NB=ZEROS)
        if taken:
            x, y = controller.step(x, lost, p, 0.1)
            assert y.no_attitude
            assert y.tau_cmd_B[0] < 0.0
            assert not controller.step(x, u, p, 0.1)[1].no_attitude
        else:
            with pytest.raises(ValueError, match="R_NB: expected a rotation matrix"):
                controller.step(x, lost, p, 0.1)
