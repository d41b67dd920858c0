"""Wheels of a set that fail, by their momenta alone: dead, weak and reversed ones under a demand that is drawn.

Shows AB-3.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.blocks import PYRAMID

from .driver import running

BLOCK = "allocator_bounded_wheels"
FOUR: dict[str, Any] = {"wheels": 4, "wheel_axis": PYRAMID}


def watched(
    gain: float,
    seconds: int = 200,
    friction: float = 0.0,
    demand: float = 5e-4,
    turns: tuple[int, ...] = (),
    **parameters: Any,
) -> list[dict[str, Any]]:
    """Outputs of each second of a random demand, N m, whose wheels have momenta of 0.1 N m s; the second gives `gain`
    of its command, less friction, all of it from the first of `turns` on, s, `gain` from the next on, and so on."""
    rng, h, found = np.random.default_rng(5), np.zeros(4), []
    gains = np.array([1.0, gain, 1.0, 1.0])
    with running(BLOCK, **FOUR, b_B=[0.0, 0.0, 0.0], wheel_momentum_max=[0.1] * 4, **parameters) as it:
        for i in range(seconds):
            command = it.get("wheel_torque_cmd")
            if i in turns:
                gains[1] = gain if gains[1] == 1.0 else 1.0
            h = h + gains * np.sign(command) * np.maximum(np.abs(command) - friction, 0.0)
            it.set("h_w", h)
            it.set("tau_cmd_B", rng.normal(scale=demand, size=3))
            it.step(float(i), 1.0)
            found.append(it.outputs())
    return found


@pytest.mark.parametrize("gain", [0.0, 0.3])
def test_a_wheel_that_gives_less_than_half_is_found_and_the_others_give_its_part(gain: float) -> None:
    y = watched(gain)
    assert y[-1]["wheel_failed"].tolist() == [0, 1, 0, 0]
    first = next(i for i, each in enumerate(y) if each["wheel_failed"][1])
    assert 0 < first < 60
    for each in y[first:]:
        assert np.abs(each["tau_residual_B"]).max() < 6e-5  # some % of the preference, of demands of 5e-4 N m
    assert not any(each["wheel_failed"][i] for each in y for i in (0, 2, 3))


@pytest.mark.parametrize("gain", [-1.0, -0.8])
def test_a_reversed_wheel_is_found_by_its_trial_and_used_with_the_opposite_sign(gain: float) -> None:
    """The torque on the body is that of the wheels' true gains."""
    y = watched(gain)
    first = next(i for i, each in enumerate(y) if each["wheel_failed"][1])
    assert 0 < first < 60
    assert all(each["wheel_failed"].tolist() == [0, 1, 0, 0] for each in y[first : first + 2])
    for each in y[first + 2 :]:
        assert not each["wheel_failed"].any()
        assert each["wheel_reversed"].tolist() == [0, 1, 0, 0]
    assert not any(each["wheel_reversed"].any() for each in y[:first])
    gains = np.array([1.0, gain, 1.0, 1.0])
    given = np.array([-(gains * each["wheel_torque_cmd"]) @ PYRAMID for each in y])
    wanted = np.random.default_rng(5).normal(scale=5e-4, size=(len(y), 3))
    assert np.abs(given - wanted)[first + 2 :].max() < 6e-5 + 2.0 * (1.0 + gain) * 1e-3


def test_a_reversed_wheel_that_turns_round_again_is_used_by_its_new_sign() -> None:
    y = watched(-1.0, 700, turns=(100,))
    assert y[99]["wheel_reversed"].tolist() == [0, 1, 0, 0]
    assert not y[-1]["wheel_reversed"].any()
    assert not y[-1]["wheel_failed"].any()


def test_what_a_weak_wheel_gives_in_its_second_trial_is_countered_by_the_others() -> None:
    """The wheel gives 0.3: its trial at 0.2 of its limit puts 1.8e-4 N m on the body, unless the others know it."""
    y = watched(0.3, 3300)
    first = next(i for i, each in enumerate(y) if each["wheel_failed"][1])
    missed = []
    for each, demand in zip(y, np.random.default_rng(5).normal(scale=5e-4, size=(len(y), 3)), strict=True):
        missed.append(float(np.abs(-([1.0, 0.3, 1.0, 1.0] * each["wheel_torque_cmd"]) @ PYRAMID - demand).max()))
    assert y[-1]["wheel_failed"][1]
    assert max(missed[first : first + 2]) > 8e-5
    assert max(missed[first + 3000 :]) < 8e-5


@pytest.mark.parametrize(("gain", "friction"), [(1.0, 0.0), (0.7, 0.0), (1.0, 3e-5)])
def test_wheels_that_give_more_than_half_or_have_friction_are_not_reported(gain: float, friction: float) -> None:
    assert not any(each["wheel_failed"].any() for each in watched(gain, 500, friction))


def test_wheels_whose_friction_takes_the_commands_of_a_quiet_hold_are_not_reported() -> None:
    y = watched(1.0, 1000, friction=1.2e-4, demand=1e-4)
    assert max(np.abs(each["wheel_torque_cmd"]).max() for each in y) > 1e-4
    assert not any(each["wheel_failed"].any() for each in y)


def test_wheels_whose_momenta_are_told_a_sample_late_are_not_reported() -> None:
    h = late = np.zeros(4)
    with running(BLOCK, **FOUR, b_B=[0.0, 0.0, 0.0], tau_cmd_B=[2e-3, -1e-3, 1e-3]) as it:
        for i in range(20):
            late, h = h, h + 0.5 * it.get("wheel_torque_cmd")
            it.set("h_w", late)
            it.step(0.5 * i, 0.5)
            assert not it.outputs()["wheel_failed"].any()


def test_a_failed_wheel_is_tried_by_a_probe_and_one_that_is_not_looked_for_is_not_found() -> None:
    y = watched(0.0, 3300)
    first = next(i for i, each in enumerate(y) if each["wheel_failed"][1])
    assert all(each["wheel_failed"].tolist() == [0, 1, 0, 0] for each in y[first:])
    for begin in (first, first + 3002):  # at once, and 3000 s after that
        probes = [each["wheel_torque_cmd"][1] for each in y[begin : begin + 2]]
        assert probes == [0.2 * 3e-3, -0.2 * 3e-3]
        assert abs(y[begin - 1]["wheel_torque_cmd"][1]) < 0.1 * 3e-3 or begin == first
        assert abs(y[begin + 2]["wheel_torque_cmd"][1]) < 0.1 * 3e-3
    assert not any(each["wheel_failed"].any() for each in watched(0.0, find_failures=False))


@pytest.mark.thorough
def test_a_wheel_that_works_again_is_used_after_its_probe_each_time() -> None:
    """The probe is 3000 s after it was found. What a wheel gave before it failed is forgotten by half in 208 s."""
    begins, end = (1000, 5500), 9600
    y = watched(0.0, end, turns=(0, 1000, 2000, 5500, 6500))
    failed = [bool(each["wheel_failed"][1]) for each in y]
    for begin, until in zip(begins, (5500, end), strict=True):
        first = failed.index(True, begin)
        assert begin + 150 < first < begin + 400
        assert all(failed[first : first + 3002])
        assert not any(failed[first + 3006 : until])
    assert not any(failed[:1000])
    assert not any(each["wheel_failed"][i] for each in y for i in (0, 2, 3))


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_reversed_wheel_that_is_full_is_found_as_such(side: float) -> None:
    """Its drive lets no momentum beyond the limit; the demand asks for the way back only."""
    gains, limit = np.array([1.0, -1.0, 1.0, 1.0]), 0.03
    h = np.array([0.0, side * 0.02, 0.0, 0.0])
    with running(BLOCK, **FOUR, b_B=[0.0, 0.0, 0.0], h_w=h, tau_cmd_B=side * 2e-3 * PYRAMID[1]) as it:
        for i in range(200):
            h = np.clip(h + 0.5 * gains * it.get("wheel_torque_cmd"), -limit, limit)
            it.set("h_w", h)
            it.step(0.5 * i, 0.5)
        assert it.get("wheel_reversed").tolist() == [0, 1, 0, 0]
