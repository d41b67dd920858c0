"""The plan's units: another satellite is flown as the same one in other units, and its axes may have other names."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.native.driver import Instance, Refused

from . import core
from .block import BLOCK, feed, near_target, same, started, tumbling
from .states import AHEAD, FULL_J, R0, V0

GIVEN = {
    "K0": [4.5e-4, 5.0e-4, 5.5e-4],
    "L0": 0.05 * np.eye(3),
    "plan_period": 10.0,
    "steering_limit": 0.17,
    "disturbance_max": 4e-5,
    "residual_dipole_max": 1.25,
}
"""What was tuned for the paper's satellite."""


def outputs_after(seconds, inputs, **changes):
    with started(inputs, **changes) as it:
        for i in range(round(seconds / 0.5)):
            feed(it, inputs(0.5 * (i + 1)))
            it.step(0.5 * i, 0.5)
        return it.outputs()


@pytest.mark.parametrize("inputs", [near_target, tumbling])
def test_for_the_papers_satellite_what_is_computed_is_what_was_tuned(inputs):
    assert same(outputs_after(15.0, inputs), outputs_after(15.0, inputs, **GIVEN))


@pytest.mark.parametrize(("name", "value"), [("L0", 0.1 * np.eye(3)), ("K0", [1e-3, 2e-3, 3e-3])])
def test_a_gain_that_is_given_wins(name, value):
    def torque(**changes):
        return outputs_after(1.0, near_target, **changes)["tau_cmd_B"]

    assert not np.allclose(torque(**{name: value}), torque(), rtol=1e-6)


@pytest.mark.parametrize("inputs", [near_target, tumbling])
def test_rods_that_all_give_half_are_rods_of_half_the_dipole(inputs):
    half = outputs_after(15.0, inputs, dipole_max=12.5)
    assert same(outputs_after(15.0, inputs, rod_limits=[0.5, 0.5, 0.5]), half)
    assert not same(outputs_after(15.0, inputs), half)


def test_no_rod_is_asked_for_more_than_its_limit_and_the_plan_uses_it():
    limits = np.array([1.0, 0.4, 0.2])
    with started(tumbling, rod_limits=limits) as it:
        used = np.zeros(3)
        for i in range(200):
            feed(it, tumbling(0.5 * (i + 1)))
            it.step(0.5 * i, 0.5)
            used = np.maximum(used, np.abs(it.outputs()["dipole_ff"]))
    assert (used <= 25.0 * limits * (1.0 + 1e-12)).all()
    assert (used > 24.0 * limits).all()


def at_height(height):
    """near_target's inputs on a circular orbit at this height, m, over the radius of the field models."""

    def inputs(t):
        given = near_target(t)
        r, v = np.array(given["r_N"]), np.array(given["v_N"])
        radius = 6371.2e3 + height
        speed = math.sqrt(3.986004418e14 / radius)
        return {**given, "r_N": radius / np.linalg.norm(r) * r, "v_N": speed / np.linalg.norm(v) * v}

    return inputs


@pytest.mark.parametrize(("height", "forgotten"), [(350e3, 100.0), (400e3, 160.0), (600e3, 400.0)])
def test_the_disturbance_is_forgotten_sooner_where_drag_is_strong(height, forgotten):
    def disturbance(**changes):
        return outputs_after(60.0, at_height(height), **changes)["disturbance_B"]

    assert np.allclose(disturbance(), disturbance(disturbance_time=forgotten), rtol=1e-7, atol=0.0)
    assert not np.allclose(disturbance(), disturbance(disturbance_time=0.7 * forgotten), rtol=1e-6, atol=0.0)


# ------------------------------------------------------------ gains that cannot be stable


def spectral_radius(moment, stiffness, damping, period):
    """Of the errors from one sample to the next, the torque held between: double integrator, exactly discretised."""
    A = np.array([[1.0, period], [0.0, 1.0]])
    G = np.array([0.5 * period**2, period]) / moment
    return np.abs(np.linalg.eigvals(A - np.outer(G, [stiffness, damping]))).max()


def starts(**changes):
    with Instance(BLOCK) as it:
        feed(it, {**near_target(0.0), **changes})
        it.initialize()


@pytest.mark.parametrize("period", [0.1, 0.5])
@pytest.mark.parametrize("J", [FULL_J, np.diag([0.005, 0.03, 0.03])])
def test_a_damping_that_cannot_be_stable_at_this_period_is_refused_with_the_bound(period, J):
    least = np.linalg.eigvalsh(J)[0]
    stable, unstable = (share * 2.0 * least / period for share in (0.99, 1.01))
    assert spectral_radius(least, 1e-9 * least, stable, period) < 1.0 < spectral_radius(least, 0.0, unstable, period)
    given = {"J_B": J, "control_period": period}
    starts(**given, L0=stable * np.eye(3))
    with pytest.raises(Refused, match=r"L0: expected L0 control_period/J_B below 2 about each axis.*found 2\.02"):
        starts(**given, L0=unstable * np.eye(3))


def radius(J, K, L, period):
    """The same of a body, matrices in the place of numbers: about its equilibrium the law is -(tr(K) I - K) x - L v."""
    S, one = np.sum(K) * np.eye(3) - np.diag(K), np.eye(3)
    A = np.block([[one, period * one], [0.0 * one, one]])
    G = np.vstack([0.5 * period**2 * one, period * one]) @ np.linalg.inv(J)
    return np.abs(np.linalg.eigvals(A - G @ np.hstack([S, L]))).max()


TOO_STIFF = r"expected \(K0\[i\] \+ K0\[j\]\) control_period/L0 below 2 about each axis.*smaller K0.*found {}"


@pytest.mark.parametrize("d", [0.01, 0.1, 0.5, 1.0, 1.5, 1.9])
@pytest.mark.parametrize("share", [0.99, 1.01, 15.0])
def test_a_stiffness_that_its_damping_does_not_make_stable_is_refused_with_the_bound(d, share):
    """About the first axis of a slender body, on which the second and the third stiffness act."""
    J, period = np.diag([0.005, 0.03, 0.03]), 0.5
    L = d * J / period
    K = np.array([0.3, 0.48, 0.52]) * 2.0 * share * L[0, 0] / period
    gains = {"J_B": J, "K0": K, "L0": L, "control_period": period}
    if radius(J, K, L, period) < 1.0:
        starts(**gains)
    else:
        with pytest.raises(Refused, match="K0: " + TOO_STIFF.format(f"{2.0 * share:.3g}")):
            starts(**gains)


def test_of_full_matrices_what_is_accepted_is_stable_and_what_is_not_stable_is_refused(rng):
    """Axes that the matrices do not share: some gains that would be stable are refused too, but few."""
    found = []
    for _ in range(100):
        turn = Rotation.random(random_state=rng).as_matrix()
        J = turn @ np.diag(rng.uniform([1.0, 1.0, 1.2], [1.2, 2.0, 2.0])) @ turn.T
        turn = Rotation.random(random_state=rng).as_matrix()
        L = turn @ np.diag(rng.uniform(0.02, 2.0) * rng.uniform(0.8, 1.2, 3)) @ turn.T
        K = np.sort(rng.uniform(0.4, 2.0) * rng.uniform(0.8, 1.2, 3)) * np.trace(L) / 3.0
        try:
            starts(J_B=J, K0=K, L0=0.5 * (L + L.T), control_period=1.0)
            accepted = True
        except Refused:
            accepted = False
        found.append((accepted, bool(radius(J, K, L, 1.0) < 1.0)))
    assert (True, False) not in found
    assert found.count((True, True)) > 10
    assert found.count((False, False)) > 10
    assert found.count((False, True)) < 10


def test_a_stiffness_is_held_against_the_damping_that_is_computed_for_the_orbit():
    """On a wider orbit the rods give less, so that the computed damping is weaker."""
    low, J, period = near_target(0.0), 0.003 * np.eye(3), 2.0
    wide = {"r_N": 6.0 * low["r_N"], "v_N": low["v_N"] / math.sqrt(6.0)}
    body = {"J_B": J, "dipole_max": 0.6, "control_period": period}
    L = [0.9 * 0.003 / math.sqrt(0.003 / (0.6 * 5.77e-5 * (6371.2e3 / a) ** 3)) for a in (6971e3, 6.0 * 6971e3)]
    K = np.array([0.9, 1.0, 1.1]) * 2.0 * L[1] / period  # s = 4 d on the wide orbit
    assert radius(J, K, L[0] * np.eye(3), period) < 1.0 < radius(J, K, L[1] * np.eye(3), period)
    starts(**body, K0=K)
    with pytest.raises(Refused, match="K0: " + TOO_STIFF.format("4")):
        starts(**body, K0=K, **wide)


def test_a_stiffness_that_is_tuned_in_flight_is_held_against_the_computed_damping():
    with started() as it:
        it.set("K0", [0.8, 0.9, 1.0])
        with pytest.raises(Refused, match="K0: " + TOO_STIFF.format("19")):
            it.step(0.0, 0.5)


@pytest.mark.parametrize("slender", [10.0, 60.0, 200.0])
def test_the_mean_moment_of_a_slender_body_counts_as_at_most_ten_of_the_least(slender):
    """With which the computed gains are stable at each period that is accepted (docs/how/planned-scales.md)."""
    J, dipole = 0.003 * np.diag([1.0 / slender, 1.0, 1.0]), 0.6
    inertia = min(np.trace(J) / 3.0, 10.0 * J[0, 0])
    T = math.sqrt(inertia / (dipole * 5.77e-5 * (6371.2e3 / 7e6) ** 3))
    body = {"J_B": J, "dipole_max": dipole}
    starts(**body, control_period=0.18 * T)
    K = 0.45 * inertia / T**2 * np.array([0.9, 1.0, 1.1])
    L = min(0.9 * inertia / T, 0.5 * J[0, 0] / (0.18 * T)) * np.eye(3)
    assert radius(J, K, L, 0.18 * T) < 1.0
    with pytest.raises(Refused, match="control_period: expected at most 0.2 of"):
        starts(**body, control_period=0.22 * T)


@pytest.mark.parametrize("J", [1e-4, 1e-2, 1.0, 1e2, 1e4])
@pytest.mark.parametrize("dipole_max", [1e-2, 1.0, 1e2])
def test_what_is_computed_is_stable_whatever_the_satellite(J, dipole_max):
    """As the block says itself, where the computed gains are given to it: read off the torque of a pure rate error."""
    T = math.sqrt(0.7 * J / (dipole_max * 4.4e-5))
    period = min(0.1 * T, 0.5)
    body = {
        "J_B": J * np.diag([0.2, 0.9, 1.0]),
        "dipole_max": dipole_max,
        "wheel_momentum_max": J,
        "wheel_torque_max": J,
        "control_period": period,
    }
    y = outputs_after(1.0, near_target, **body)
    assert np.isfinite(y["tau_cmd_B"]).all()
    starts(**body, L0=min(0.9 * 0.7 * J / T, 0.1 * J / period) * np.eye(3))


def test_a_period_too_long_for_the_satellite_is_refused_with_the_share_of_its_time():
    """B as docs/how/planned-scales.md has it, T rounded to two digits: with J = 0.003 kg m2 and 0.6 A m2 it is 11 s at
    629 km."""
    body = {"J_B": np.diag([0.003, 0.003, 0.003]), "dipole_max": 0.6}
    B = 5.77e-5 * (6371.2 / 7000.0) ** 3
    assert round(math.sqrt(0.003 / (0.6 * B))) == 11
    starts(**body, control_period=0.19 * 11.0)
    with pytest.raises(Refused, match=r"control_period: expected at most 0.2 of .*found 0\.21"):
        starts(**body, control_period=0.21 * 11.0)


# ------------------------------------------------------------------------------------------- other units, other axes

U = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()


def alike(a, b):
    assert b.h == pytest.approx(a.h, rel=1e-12)
    assert np.abs(b.u - a.u).max() < 1e-6
    assert b.cost == pytest.approx(a.cost, rel=1e-8)


def test_a_satellite_a_hundred_times_as_large_in_all_gets_the_same_plan():
    small = core.Satellite(J=FULL_J)
    large = core.Satellite(
        J=100.0 * FULL_J,
        rods=100.0 * small.rods,
        wheel_torque_max=0.3,
        wheel_momentum_max=3.0,
        dipole_max=100.0 * small.dipole_max,
    )
    x = core.Motion(U, np.array([0.01, -0.02, 0.015]), 0.01)
    alike(core.plan(small, AHEAD, x, 5), core.plan(large, AHEAD, core.Motion(x.R, x.Omega, 1.0), 5))


def test_four_times_the_inertia_doubles_the_time_of_the_plan():
    x = core.Motion(U, np.zeros(3), 0.0)
    once, four = (core.plan(core.Satellite(J=f * FULL_J), AHEAD, x, 0) for f in (1.0, 4.0))
    assert four.h == pytest.approx(2.0 * once.h)


@pytest.mark.parametrize("turn", [np.eye(3)[[1, 2, 0]], np.eye(3)[[2, 0, 1]], np.diag([-1.0, -1.0, 1.0]), U])
def test_the_plan_does_not_depend_on_the_names_of_the_bodys_axes(turn):
    """Body vectors in new axes are `turn` times those in the old ones; the wheel's axis is one of them."""
    old = core.Satellite(J=FULL_J, disturbance_B=np.array([1e-5, -2e-5, 3e-5]), residual_B=np.array([0.1, 0.2, -0.3]))
    new = core.Satellite(
        J=turn @ old.J @ turn.T,
        rods=old.rods @ turn.T,
        wheel_axis=turn @ old.wheel_axis,
        disturbance_B=turn @ old.disturbance_B,
        residual_B=turn @ old.residual_B,
    )
    x = core.Motion(U, np.array([0.01, -0.02, 0.015]), 0.01)
    # The target in new axes is LVLH of the new names: an inertial target stands for it, whose axes can be renamed.
    ahead = [core.Ahead(R0, V0, target=2, R_d0=R) for R in (np.eye(3), turn.T)]
    y = core.Motion(x.R @ turn.T, turn @ x.Omega, x.h_w)
    alike(core.plan(old, ahead[0], x, 5), core.plan(new, ahead[1], y, 5))
