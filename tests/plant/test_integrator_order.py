"""The order of the integrator, measured against DOP853 under forcing, with the wheel spinning and commands of a fixed
period."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import plant
from evidence.verification.rk4 import angle_between, environment, pack, rk4, truth
from plant import attitude
from plant.geomagnetic import FieldAlongOrbit
from tests.plant import manoeuvre
from tests.plant.motion import FULL_INERTIA, bare, checked, command, fly, measured_order


@pytest.mark.parametrize(("order", "bound"), [(2, 2e-4), (4, 5e-8), (6, 3e-10)])
def test_the_error_under_forcing_with_the_wheel_spinning_up_and_down_is_small(order, bound):
    """The order itself is an authority: tests/authorities/integrator.py."""
    p = manoeuvre.parameters(order, min(manoeuvre.STEPS[order]))
    assert manoeuvre.error(manoeuvre.flown(p), p, manoeuvre.true_end(p)) < bound


def test_suzukis_order_4_lies_far_below_the_paper_pages_yoshida_triple_jump(monkeypatch):
    p = manoeuvre.parameters(4, 1.0)
    y = manoeuvre.true_end(p)
    suzuki = manoeuvre.error(manoeuvre.flown(p), p, y)
    outer = 1.0 / (2.0 - 2.0 ** (1.0 / 3.0))
    monkeypatch.setitem(attitude.COMPOSITIONS, 4, (outer, 1.0 - 2.0 * outer, outer))
    yoshida = manoeuvre.error(manoeuvre.flown(p), p, y)
    assert yoshida > 20.0 * suzuki


@pytest.mark.parametrize("order", [2, 4, 6])
def test_a_composition_is_symmetric_and_its_substeps_add_up_to_the_step(order):
    shares = attitude.COMPOSITIONS[order]
    assert sum(shares) == pytest.approx(1.0, abs=1e-15)
    assert shares == tuple(reversed(shares))
    # Conditions of order: the sums of odd powers below the order vanish (Hairer, Lubich, Wanner, V.3).
    for power in range(3, order, 2):
        assert sum(s**power for s in shares) == pytest.approx(0.0, abs=1e-13)


E1 = np.array([1.0, 0.0, 0.0])


def test_a_step_makes_the_discrete_action_stationary():
    """L_d = (1/h) tr[(I - F) J_d] - 1/2 lm tr(e1^ F), differentiated by numbers at both ends of the step.

    Varying R and R+ on the right, F goes to exp(-eta^) F and F exp(eta^); the slopes are minus the momentum with
    the first half kick, and the momentum before the second. Order alone cannot tell this from its neighbours.
    """
    h, l_m, force = 1.7, 0.9, np.array([0.02, -0.03, 0.01])
    J, Pi, R = FULL_INERTIA, np.array([0.9, -0.7, 0.8]), Rotation.random(random_state=1).as_matrix()
    body = attitude.Body(J, np.linalg.inv(J))
    R_next, Pi_next, _ = attitude.lgvi_step(
        R, Pi, force, lambda R, t, Omega: -2.0 * force, body, 0.0, h, l_m * E1, 0.3 * E1
    )
    F, J_d = R.T @ R_next, 0.5 * np.trace(J) * np.eye(3) - J
    e1_hat = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])

    def action(F):
        return np.trace((np.eye(3) - F) @ J_d) / h - 0.5 * l_m * np.trace(e1_hat @ F)

    def slope(vary):
        def along(eta, k):
            return action(vary(Rotation.from_rotvec(k * 1e-3 * eta).as_matrix()))

        return [(8.0 * (along(e, 1) - along(e, -1)) - along(e, 2) + along(e, -2)) / 12e-3 for e in np.eye(3)]

    assert slope(lambda turn: turn.T @ F) == pytest.approx(-(Pi + 0.5 * h * force), abs=1e-11)
    assert slope(lambda turn: F @ turn) == pytest.approx(Pi_next - 0.5 * h * -2.0 * force, abs=1e-11)


def test_a_step_back_returns_to_the_start():
    p = checked(J_B=FULL_INERTIA)
    moment = environment(p, [300.0, -400.0, 200.0])
    body = attitude.Body(p.J_B, np.linalg.inv(p.J_B))
    R, Pi = p.R_NB0, np.array([0.3, -0.2, 0.25])
    ahead = attitude.lgvi_step(R, Pi, moment(R, 5.0, Pi), moment, body, 5.0, 1.5, 0.013 * E1, 0.016 * E1)
    back = attitude.lgvi_step(*ahead, moment, body, 6.5, -1.5, 0.013 * E1, 0.010 * E1)
    assert np.abs(back[0] - R).max() < 1e-15
    assert np.abs(back[1] - Pi).max() < 1e-15


def test_yoshidas_composition_takes_the_field_at_nodes_outside_the_step(monkeypatch):
    asked = []
    at = FieldAlongOrbit.at
    p = checked(integrator_order=6, step_max=1.0)
    x = fly(p, command(), 1.0, 3)[-1]
    monkeypatch.setattr(FieldAlongOrbit, "at", lambda field, t: asked.append(t) or at(field, t))
    plant.step(x, command([1.0, 2.0, 3.0]), checked(integrator_order=6, step_max=1.0), 1.0)  # which keep nothing yet
    # Partial sums of the coefficients in Yoshida (1990), table 1, solution A.
    nodes = np.cumsum([0.0, 0.784513610477560, 0.235573213359357, -1.17767998417887, 1.315186320683906])
    assert set(np.round(3.0 + nodes, 9)) <= set(np.round(asked, 9))
    assert min(asked) < 2.85
    assert max(asked) > 4.15


def test_with_nodes_forced_into_the_step_order_6_is_lost(monkeypatch):
    """So the nodes outside matter: a clamped time is a moment of the wrong date."""
    p = manoeuvre.parameters(6, 1.0, gravity_gradient=False)
    y = manoeuvre.true_end(p)
    at = FieldAlongOrbit.at
    errors = {}
    for step in manoeuvre.STEPS[6]:
        p = manoeuvre.parameters(6, step, gravity_gradient=False)
        monkeypatch.setattr(
            FieldAlongOrbit,
            "at",
            lambda field, t, s=step: at(field, min(max(t, s * round(t / s - 0.4)), s * round(t / s + 0.4))),
        )
        errors[step] = manoeuvre.error(manoeuvre.flown(p), p, y)
    assert measured_order(errors) < 4.0


def rate_dependent_case(order: int, implicit: bool) -> dict[float, float]:
    """A damped body with a moment that depends on R, t and Omega; the wheel spins up."""
    damping = np.array([[0.09, 0.02, 0.0], [0.01, 0.12, -0.02], [0.0, 0.03, 0.07]])
    sun = np.array([0.02, -0.03, 0.01])

    def moment(R, t, Omega):
        return R.T @ (sun * np.cos(0.3 * t)) - damping @ Omega

    J, Omega, duration, torque = FULL_INERTIA, np.array([0.08, -0.1, 0.07]), 8.0, 2e-3
    y = truth(pack(np.eye(3), Omega, 0.01), 0.0, duration, J, moment, lambda l_w: torque)
    errors = {}
    for step in (2.0, 1.0, 0.5, 0.25):
        R, rate = bare(
            order,
            step,
            round(duration / step),
            np.eye(3),
            Omega,
            J,
            moment,
            wheel=lambda t: 0.01 + torque * t,
            wheel_mean=lambda t0, t1: 0.01 + torque * 0.5 * (t0 + t1),
            rate_dependent=implicit,
        )
        errors[step] = angle_between(R, y[:9].reshape(3, 3)) + float(np.abs(rate - y[9:12]).max())
    return errors


@pytest.mark.parametrize(("order", "tolerance"), [(2, 0.1), (4, 0.15), (6, 0.3)])
def test_a_rate_dependent_moment_keeps_the_order(order, tolerance):
    assert measured_order(rate_dependent_case(order, implicit=True)) == pytest.approx(order, abs=tolerance)


def test_a_rate_dependent_moment_taken_explicitly_loses_it():
    assert measured_order(rate_dependent_case(4, implicit=False)) < 1.5


def test_the_command_of_a_step_acts_over_that_step_alone():
    """Two commands in turn are what DOP853 makes of each over its own period: nothing is carried over the change."""
    p = manoeuvre.parameters(6, 0.25)
    first, second = command([400.0, 0.0, 0.0]), command([-400.0, 300.0, 0.0], 2e-3)
    x = plant.step(plant.step(plant.start(p, second), first, p, 1.0)[0], second, p, 1.0)[0]
    y = pack(p.R_NB0, p.omega_B0, p.h_w0)
    y = truth(y, 0.0, 1.0, p.J_B, environment(p, p.rods_to_body @ first.dipole_cmd), lambda l_w: 0.0)
    y = truth(y, 1.0, 2.0, p.J_B, environment(p, p.rods_to_body @ second.dipole_cmd), lambda l_w: 2e-3)
    assert manoeuvre.error(x, p, y) < 1e-10


def test_rk4_the_reference_has_order_4_and_is_the_more_accurate_at_a_step_than_order_2():
    p = manoeuvre.parameters(2, 1.0)
    moment = environment(p, [300.0, -200.0, 100.0])
    y0 = pack(p.R_NB0, p.omega_B0, p.h_w0)
    system = (p.J_B, moment, lambda l_w: 2e-3)
    true = truth(y0, 0.0, 8.0, *system)
    errors = {}
    for step in (1.0, 0.5, 0.25):
        y = y0
        for i in range(round(8.0 / step)):
            y = rk4(y, i * step, step, *system)
        errors[step] = float(np.abs(y - true).max())
    assert measured_order(errors) == pytest.approx(4.0, abs=0.2)
    u = command(np.linalg.solve(p.rods_to_body, [300.0, -200.0, 100.0]), 2e-3)
    x = fly(p, u, 1.0, 8)[-1]
    assert errors[1.0] < 0.1 * np.abs(x.R.ravel() - true[:9]).max()


def test_a_body_that_turns_too_far_in_one_step_is_refused_with_the_remedy():
    p = checked(omega_B0=[3.0, -4.0, 5.0], step_max=1.0)
    with pytest.raises(ValueError, match=r"step_max: expected a turn below about 1 rad in an internal step.*found h J"):
        fly(p, command(), 1.0, 50)


def test_a_communication_step_is_divided_into_the_fewest_equal_parts_within_step_max(monkeypatch):
    p = checked(step_max=0.1, integrator_order=2)
    lengths = []
    step = attitude.lgvi_step
    monkeypatch.setattr("plant.block.lgvi_step", lambda *a: lengths.append(a[6]) or step(*a))
    x = plant.start(p, command())
    for h, count in ((0.1, 1), (0.3, 3), (0.25, 3), (0.05, 1), (1.0, 10)):
        lengths.clear()
        plant.step(x, command(), p, h)
        assert lengths == pytest.approx([h / count] * count)
