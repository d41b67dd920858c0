"""The planned controller with a reference by its ports, without one, and without attitude.

Shows PL-2.
"""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.native.driver import Refused

from . import core, flat
from .block import (
    AS_MEASURED,
    KNOWN,
    SEARCHED,
    alike,
    at_target,
    feed,
    lvlh,
    near_target,
    orbit,
    run,
    started,
    tumbling,
)
from .truth import DAYS

ZEROS = np.zeros((3, 3))
INERTIAL = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix()
BESIDE = Rotation.from_rotvec([0.1, 0.2, -0.3]).as_matrix()


def rate_of_orbit(t):
    r, v = orbit(t)
    return np.linalg.norm(np.cross(r, v)) / (r @ r)


def with_reference(inputs, R_ref, Omega_ref):
    """The inputs with the reference at t."""
    return lambda t: {**inputs(t), "R_ref": R_ref(t), "Omega_ref": Omega_ref(t), "dOmega_ref": np.zeros(3)}


follow_rate = with_reference(tumbling, lambda t: ZEROS, lambda t: np.array([2e-3, -3e-3, 1e-3]))
no_reference = with_reference(tumbling, lambda t: ZEROS, lambda t: np.zeros(3))
to_lvlh = with_reference(near_target, lvlh, lambda t: [0.0, -rate_of_orbit(t), 0.0])
beside_lvlh = with_reference(
    near_target, lambda t: lvlh(t) @ BESIDE, lambda t: BESIDE.T @ [0.0, -rate_of_orbit(t), 0.0]
)
held = with_reference(near_target, lambda t: INERTIAL, lambda t: np.zeros(3))


def lost(inputs):
    return lambda t: {**inputs(t), "R_NB": ZEROS}


@pytest.mark.parametrize(
    ("by_ports", "parameters"),
    [(to_lvlh, {}), (beside_lvlh, {"R_d0": BESIDE}), (held, {"reference": 2, "R_d0": INERTIAL})],
)
def test_a_reference_by_the_ports_is_planned_for_as_the_same_one_by_the_parameter(by_ports, parameters):
    """Of LVLH and of an inertial attitude the ports give the present alone; the horizon has to follow from it."""
    with started(near_target, **parameters, **KNOWN) as by_parameter, started(by_ports, **KNOWN) as it:
        a, b = (run(i, 0.0, SEARCHED, inputs=f) for i, f in ((by_parameter, near_target), (it, by_ports)))
    assert {y["phase"] for y in a} == {2}
    assert all(alike(x, y, 1e-6) for x, y in zip(a, b, strict=True))


def backwards(t):
    """The rods that were at one of their limits are then at the other."""
    inputs = lost(no_reference)(t)
    return {**inputs, "omega_B": -np.array(inputs["omega_B"])}


@pytest.mark.parametrize("inputs", [no_reference, lost(no_reference), lost(tumbling), backwards])
def test_without_attitude_or_reference_rods_take_energy_and_the_wheel_comes_to_rest(inputs):
    with started(inputs, **AS_MEASURED) as it:
        for y in [it.outputs(), *run(it, 0.0, 3.0, inputs=inputs)]:
            assert y["phase"] == 4
            assert y["attitude_error"] == math.pi
    u = inputs(3.0)
    Omega, B = np.array(u["omega_B"]), np.array(u["b_B"])
    assert np.array_equal(y["rate_error_B"], Omega)
    dipole = np.array(y["dipole_ff"])
    powers = [Omega @ np.cross(rod * m, B) for rod, m in zip(flat.RODS, dipole, strict=True)]
    assert max(powers) <= 0.0
    assert sum(powers) < -1e-5
    assert np.abs(dipole).max() == pytest.approx(25.0)
    assert y["wheel_torque_ff"] == pytest.approx(-u["h_w"] / 10.0)
    given = np.cross(dipole @ flat.RODS, B) - np.cross(Omega, [u["h_w"], 0.0, 0.0]) - [y["wheel_torque_ff"], 0.0, 0.0]
    np.testing.assert_allclose(y["tau_cmd_B"], given, rtol=1e-12)


def test_each_time_that_the_attitude_is_lost_the_reference_is_gone_as_before_the_first_one():
    def sometimes(t):
        return lost(to_lvlh)(t) if t % 20.0 < 10.0 else to_lvlh(t)

    with started(sometimes, **KNOWN) as it:
        found = [it.outputs(), *run(it, 0.0, 60.0, inputs=sometimes)]
    gone = [y for y in found if y["no_attitude"]]
    assert [y["no_attitude"] for y in found] == [0.5 * i % 20.0 < 10.0 for i in range(121)]
    for y in gone:
        assert np.array_equal(y["R_d"], np.eye(3))
        assert not np.any(y["Omega_d"])
        assert not np.any(y["dOmega_d"])
        assert (y["h_w_ref"], y["phase"]) == (0.0, 4)
    assert max(np.abs(y["R_d"] - np.eye(3)).max() for y in found) > 0.1


@pytest.mark.parametrize("first", [near_target, lost(near_target)], ids=["from the start", "later"])
def test_zeros_for_an_attitude_are_refused_after_the_first_one_where_no_reference_is_connected(first):
    with started(first, **KNOWN) as it:
        run(it, 0.0, 1.0, inputs=first)
        run(it, 1.0, 1.5)
        with pytest.raises(Refused, match="R_NB"):
            run(it, 1.5, 2.0, inputs=lost(near_target))
        it.call("Reset")
        feed(it, lost(near_target)(0.0))
        it.initialize()
        assert it.get("no_attitude")


def test_at_the_start_the_onboard_field_is_that_of_the_epoch():
    """It turns with the Earth: 7e-5 rad in a second."""
    inputs = near_target(0.0)
    del inputs["b_B"]
    with started(lambda t: inputs) as it:
        expected = inputs["R_NB"].T @ core.field_at("igrf14", DAYS, 10, inputs["r_N"], 0.0)
        assert it.get("b_used_B") == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("inputs", [no_reference, lost(tumbling), follow_rate, lost(follow_rate)])
def test_far_from_the_rods_limits_the_rate_across_the_field_is_damped_by_L0(inputs):
    """Three rods at right angles: m x B = -L (omega - (omega.b) b), omega the rate less the one that is asked for."""

    def slow(t):
        return {**inputs(t), "omega_B": 0.01 * np.array(inputs(t)["omega_B"]), "h_w": 0.0}

    with started(slow, rod_axes=np.eye(3), L0=0.02 * np.eye(3)) as it:
        y = it.outputs()
    u = slow(0.0)
    b = np.array(u["b_B"]) / np.linalg.norm(u["b_B"])
    omega = np.array(u["omega_B"]) - u.get("Omega_ref", np.zeros(3))
    assert np.array_equal(y["rate_error_B"], omega)
    np.testing.assert_allclose(y["tau_cmd_B"], -0.02 * (omega - (omega @ b) * b), rtol=1e-12)


@pytest.mark.parametrize("absent", [1e9, 0.0])
def test_without_attitude_and_field_the_wheel_takes_up_the_turn_about_its_axis(absent):
    def blind(t):
        return {**lost(tumbling)(t), "b_B": np.full(3, absent), "h_w": 0.0, "omega_B": [-0.01, 0.02, 0.0]}

    with started(blind) as it:
        y = it.outputs()
    assert not np.any(y["dipole_ff"])
    assert y["wheel_torque_ff"] == pytest.approx(-2.13 * 0.01 / 10.0, rel=1e-6)


def test_a_reference_that_goes_ends_the_plan_and_one_that_comes_begins_the_search_anew_each_time():
    with started(to_lvlh) as it:
        assert run(it, 0.0, SEARCHED, inputs=to_lvlh)[-1]["phase"] == 2
        gone = {"R_ref": ZEROS, "Omega_ref": np.zeros(3), "dOmega_ref": np.zeros(3)}
        for t in (SEARCHED, 2.0 * SEARCHED + 4.0):
            y = run(it, t, t + 2.0, inputs=lambda t: {**near_target(t), **gone})[-1]
            assert (y["phase"], y["plan_cost"]) == (4, 0.0)
            back = run(it, t + 2.0, t + SEARCHED + 4.0, inputs=to_lvlh)
            assert back[0]["phase"] == 1
            assert back[-1]["phase"] == 2


def test_an_attitude_that_is_lost_and_found_begins_the_plan_anew_each_time():
    with started(to_lvlh) as it:
        run(it, 0.0, 10.0, inputs=to_lvlh)
        for t in (10.0, 20.0):
            for y in run(it, t, t + 2.0, inputs=lost(to_lvlh)):
                assert y["no_attitude"]
                assert y["phase"] == 4
            y = run(it, t + 2.0, t + 10.0, inputs=to_lvlh)[0]
            assert not y["no_attitude"]
            assert y["phase"] in (1, 2)


def bounded(bound, turns=0.0, axis=(0.0, 0.0, 1.0), **others):
    """At the target, with a bound on the attitude's error, rad; in a turn, rad/s."""

    def inputs(t):
        u = at_target(t)
        return {**u, "attitude_bound": bound, "omega_B": np.add(u["omega_B"], np.multiply(turns, axis)), **others}

    return inputs


def test_rates_are_damped_each_time_the_satellite_turns_after_its_attitude_is_lost_by_its_bound():
    """30 deg; 0.3 rad in T, which is 50 s."""
    good, poor = bounded(0.5), bounded(0.55)
    with started(poor, **KNOWN) as it:
        assert 4 not in {y["phase"] for y in run(it, 0.0, 2.0, inputs=bounded(0.55, 0.02))}, "it has not been held yet"
        assert run(it, 2.0, 120.0, inputs=poor)[-1]["phase"] == 3
        for t in (120.0, 140.0):
            assert 4 not in {y["phase"] for y in run(it, t, t + 2.0, inputs=poor)}, "calm"
            assert 4 not in {y["phase"] for y in run(it, t + 2.0, t + 4.0, inputs=bounded(0.5, 0.02))}, "known"
            assert run(it, t + 4.0, t + 6.0, inputs=bounded(0.55, 0.02))[-1]["phase"] == 4
            assert {y["phase"] for y in run(it, t + 6.0, t + 8.0, inputs=poor)} == {4}, "until it is known again"
            assert np.any(run(it, t + 8.0, t + 9.0, inputs=bounded(0.55, 0.004))[-1]["dipole_ff"])
            assert not np.any(run(it, t + 9.0, t + 10.0, inputs=bounded(0.55, 0.02))[-1]["dipole_ff"]), "it has grown"
            assert not np.any(run(it, t + 10.0, t + 11.0, inputs=poor)[-1]["dipole_ff"]), "until it is known again"
            assert run(it, t + 11.0, t + 20.0, inputs=good)[-1]["phase"] in (1, 2, 3)


def test_where_the_attitude_is_doubted_the_wheel_takes_the_turn_about_its_axis_up_to_its_limit_and_keeps_what_it_has():
    """Given to the body, the wheel's 30 mN m s turn it by 0.8 deg/s, and a wrong field may not damp that."""
    J, period, most = 2.13, 10.0, 0.03
    with started(bounded(0.5), **KNOWN) as it:
        run(it, 0.0, 120.0, inputs=bounded(0.5))
        for t, loaded, expected in (
            (120.0, 0.0, J * 0.008 / period),
            (130.0, most, 0.0),
            (140.0, -most, J * 0.008 / period),
        ):
            y = run(it, t, t + 2.0, inputs=bounded(0.55, 0.008, (1.0, 0.0, 0.0), h_w=loaded))[-1]
            assert (y["phase"], y["wheel_torque_ff"]) == (4, pytest.approx(expected, rel=0.05, abs=1e-6))
            run(it, t + 2.0, t + 10.0, inputs=bounded(0.5))


# ------------------------------------------------------------------------------------------- the reference to come

AXIS = np.array([0.6, 0.0, 0.8])
KNOTS = 1500.0 * np.arange(1, 17) * (np.arange(1, 17) + 6.0) / (16.0 * 22.0)


def turned(t):
    """An attitude that turns about two axes, about one of them quicker and slower, as over a station."""
    about = Rotation.from_rotvec(2.0 * np.arctan((t - 300.0) / 150.0) * AXIS)
    return Rotation.from_rotvec([0.0, -1e-3 * t, 0.0]) * about


def rate(t, h=1e-3):
    return (turned(t - h).inv() * turned(t + h)).as_rotvec() / (2 * h)


def given(t_ahead, attitude, rates):
    r, v = orbit(0.0)
    first = [r, v, attitude(0.0).as_matrix(), rates(0.0), np.zeros(3)]
    known = [(attitude(t).as_rotvec(), rates(t)) if t else (np.zeros(3), np.zeros(3)) for t in t_ahead]
    return [*first, t_ahead, [turn for turn, _ in known], [w for _, w in known]]


def test_between_the_times_that_are_given_the_target_follows_the_reference_to_come():
    times = np.linspace(0.0, 900.0, 181)
    R, Omega = core.targets_ahead(given(KNOTS, turned, rate), times)
    away = [(turned(t).inv() * Rotation.from_matrix(a)).magnitude() for t, a in zip(times, R, strict=True)]
    assert np.degrees(max(away)) < 0.12
    assert np.degrees(np.abs(Omega - [rate(t) for t in times]).max()) < 5e-3
    at_knots, _ = core.targets_ahead(given(KNOTS, turned, rate), KNOTS)
    for t, a in zip(KNOTS, at_knots, strict=True):
        np.testing.assert_allclose(a, turned(t).as_matrix(), atol=1e-12)


def test_the_rate_of_the_target_is_that_of_its_attitude():
    times = np.linspace(5.0, 1400.0, 40)
    h = 0.01
    R, Omega = core.targets_ahead(given(KNOTS, turned, rate), np.concatenate((times - h, times, times + h)))
    before, after = Rotation.from_matrix(R[:40]), Rotation.from_matrix(R[80:])
    np.testing.assert_allclose(Omega[40:80], (before.inv() * after).as_rotvec() / (2 * h), atol=1e-8)


def test_behind_the_last_time_the_target_keeps_its_body_rate_or_stays_with_lvlh():
    """With fewer times than there is room for: zeros at the end."""
    few = np.where(KNOTS < 400.0, KNOTS, 0.0)
    last = few.max()
    R, Omega = core.targets_ahead(given(few, turned, rate), np.array([last, 700.0]))
    np.testing.assert_allclose(Omega, [rate(last)] * 2, atol=1e-9)
    kept = turned(last) * Rotation.from_rotvec((700.0 - last) * rate(last))
    np.testing.assert_allclose(R[1], kept.as_matrix(), atol=1e-6)

    def nadir(t):
        return Rotation.from_matrix(lvlh(t))

    for times in (few, np.append(few[few > 0.0][:1], np.zeros(15)), np.zeros(16)):
        known = given(times, nadir, lambda t: np.array([0.0, -rate_of_orbit(t), 0.0]))
        R, _ = core.targets_ahead(known, np.array([1400.0]))
        np.testing.assert_allclose(R[0], lvlh(1400.0), atol=1e-9)


def test_a_time_to_come_within_a_sample_of_the_one_before_it_is_none():
    """The control's period is 0.5 s."""
    for step, taken in ((0.5, 0), (0.501, 1)):
        times = np.append([step], np.zeros(15))
        R, _ = core.targets_ahead(given(times, turned, rate), np.array([300.0]))
        last = step * taken
        kept = turned(last) * Rotation.from_rotvec((300.0 - last) * rate(last))
        np.testing.assert_allclose(R[0], kept.as_matrix(), atol=1e-6)


AHEAD = {"t_ahead": KNOTS, "turn_ahead": np.zeros((16, 3)), "Omega_ahead": np.zeros((16, 3))}


def test_fewer_times_than_there_is_room_for_are_taken():
    for count in (0, 1, 15, 16):
        few = np.where(np.arange(16) < count, KNOTS, 0.0)
        with started(lambda t, few=few: {**to_lvlh(t), **AHEAD, "t_ahead": few}) as it:
            assert it.get("phase") in (1, 2)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"turn_ahead": np.full((16, 3), 1e9)},
            "turn_ahead: expected to be connected: connect t_ahead, turn_ahead and Omega_ahead with R_ref",
        ),
        ({"t_ahead": KNOTS[::-1]}, "t_ahead: expected ascending times, zeros at the end where there are fewer"),
        ({"t_ahead": [10.0, 0.0, 15.0, *[0.0] * 13]}, "t_ahead: expected ascending times, zeros at the end"),
    ],
)
def test_a_reference_to_come_that_is_given_in_part_or_without_order_is_refused(changes, message):
    with pytest.raises(Refused, match=message), started(lambda t: {**to_lvlh(t), **AHEAD, **changes}):
        pass
