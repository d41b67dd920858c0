"""Rods that fail in a set of wheels: that they are found from the balance of momentum in closed loop, and used with
their gains. The witness is the plant's `rod_gain`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.plant.motion import FULL_INERTIA

from .loop import MOMENTUM, SETS, STILL, H, fly

TUMBLE = {**STILL, "q_NB0": [0.5, 0.5, -0.5, 0.5], "gravity_gradient": True}
TUMBLE["omega_B0"] = np.linalg.solve(FULL_INERTIA, [0.8 * MOMENTUM, -0.5 * MOMENTUM, 0.6 * MOMENTUM])
SOUND = np.ones(3)
PUSH = [4e-5, -4e-5, 3e-5]
"""N m, constant in the body: it keeps the rods at work in the hold."""


def gains_of(rod: int, gain: float) -> np.ndarray:
    return np.where(np.arange(1, 4) == rod, gain, 1.0)


def flown(
    duration: float, wheels: int, gains: Callable[[float], np.ndarray], start: dict[str, Any] | None = None
) -> list[dict[str, Any]]:
    """What the controller says at each sample, with |H| of the plant (`momentum`, N m s), while the rods have the gains
    that `gains` gives for a time, s."""
    said: list[dict[str, Any]] = []

    def each(i: int, seen: dict[str, Any], y: dict[str, Any], plant: Any) -> None:
        H_B = FULL_INERTIA @ seen["omega_B"] + seen["h_w"] @ SETS[wheels]["wheel_axis"]
        said.append({**y, "momentum": np.linalg.norm(H_B)})
        if not np.array_equal(gains((i + 1) * H), gains(i * H)):
            plant.set("rod_gain", gains((i + 1) * H))

    fly(duration, each, SETS[wheels], {**TUMBLE, **(start or {}), "rod_gain": gains(0.0)}, {}, rods=True)
    return said


@pytest.mark.parametrize(
    ("wheels", "rod", "gain"), [(3, 1, -1.0), (3, 2, 0.0), (4, 3, -1.0), (4, 1, 0.4), (4, 2, -0.5)]
)
def test_the_gain_of_a_failed_rod_is_found_and_the_right_rod_named(wheels: int, rod: int, gain: float) -> None:
    said = flown(3000.0, wheels, lambda _: gains_of(rod, gain), {"disturbance_torque_B": PUSH})
    assert {int(y["failed_rod"]) for y in said} == {0, rod}
    assert all(bool(y["rod_failed"]) == (y["failed_rod"] > 0) for y in said)
    assert said[-1]["rod_gains_estimate"] == pytest.approx(gains_of(rod, gain), abs=0.15)


@pytest.mark.parametrize("wheels", SETS)
def test_sound_rods_are_not_reported_and_nothing_changes_by_the_search(wheels: int) -> None:
    """Gains of 0.85 to 1.15, and a slow drift of what disturbs: a dipole of a tenth of the rods'."""
    sound = np.array([0.85, 1.15, 1.1])
    said = flown(3000.0, wheels, lambda _: sound, {"residual_dipole_B": [1.5, -1.0, 1.5]})
    assert not any(y["rod_failed"] or y["failed_rod"] for y in said)
    assert all(np.array_equal(y["rod_gains_estimate"], SOUND) for y in said)


def test_a_reversed_rod_leaves_no_more_momentum_than_sound_rods() -> None:
    reversed_one, sound = (flown(4000.0, 3, lambda _, gains=gains: gains) for gains in (gains_of(2, -1.0), SOUND))
    assert reversed_one[-1]["momentum"] < max(2.0 * sound[-1]["momentum"], 0.1 * MOMENTUM)


def test_a_rod_that_works_again_is_used_again_and_found_when_it_fails_again() -> None:
    times = (0.0, 2500.0, 6000.0)
    """s: reversed, works again, reversed."""

    def gains(t: float) -> np.ndarray:
        return SOUND if times[1] <= t < times[2] else gains_of(1, -1.0)

    said = flown(9000.0, 4, gains, {"disturbance_torque_B": PUSH})
    at = [int(y["failed_rod"]) for y in said]
    assert at[int(times[1] / H) - 1] == 1
    assert at[int(times[2] / H) - 1] == 0
    assert said[int(times[2] / H) - 1]["rod_gains_estimate"] == pytest.approx(SOUND)
    assert at[-1] == 1
    assert said[-1]["rod_gains_estimate"][0] == pytest.approx(-1.0, abs=0.15)


def test_while_the_telemetry_of_a_wheel_is_left_out_nothing_is_said_of_the_rods() -> None:
    said: list[Any] = []
    body = {**TUMBLE, "rod_gain": gains_of(1, -1.0), "disturbance_torque_B": PUSH}
    law = {"h_w_failed": [False, True, False, False]}
    fly(2000.0, lambda i, seen, y, it: said.append(y), SETS[3], body, law, rods=True)
    assert not any(y["rod_failed"] for y in said)


def test_a_momentum_that_stands_from_before_the_watch_on_is_no_failed_rod() -> None:
    """What the rods take of that wheel does not show."""
    said: list[Any] = []
    first: dict[int, Any] = {}

    def told(i: int, h_w: np.ndarray) -> np.ndarray:
        return np.array([h_w[0], first.setdefault(1, h_w[1]) if i > 50 else h_w[1], *h_w[2:]])

    body = {**TUMBLE, "disturbance_torque_B": PUSH}
    fly(1500.0, lambda i, seen, y, it: said.append(y), SETS[3], body, {}, None, lambda i: [False] * 4, True, told)
    assert not any(y["rod_failed"] for y in said)


def test_without_the_commands_nothing_is_said_of_the_rods() -> None:
    said: list[Any] = []
    body = {**TUMBLE, "rod_gain": gains_of(1, -1.0)}
    fly(600.0, lambda i, seen, y, it: said.append(y), SETS[3], body, {})
    assert not any(y["rod_failed"] for y in said)
    assert np.array_equal(said[-1]["rod_gains_estimate"], SOUND)
