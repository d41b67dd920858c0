"""The turns of the planned controller of a set of wheels: its limits by linear programming, its motion by closed form,
and slews in a loop against the least time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.native.driver import running
from tests.plant.motion import FULL_INERTIA

from .loop import FOUR, MOMENTUM, SETS, TORQUE, H, reach, slewed

BLOCK = "controller_planned_wheels"
NO_FIELD = {"b_B": [0.0, 0.0, 0.0]}


def axes_of(rng: np.random.Generator, n: int) -> np.ndarray:
    axes = rng.normal(size=(n, 3))
    return axes / np.linalg.norm(axes, axis=1, keepdims=True)


@pytest.mark.parametrize("wheels", [3, 4])
def test_acceleration_of_a_turn_is_the_most_that_linear_programming_finds_for_any_axes_and_limits(wheels: int) -> None:
    rng = np.random.default_rng(wheels)
    for _ in range(20):
        axes, torques = axes_of(rng, 4), rng.uniform(1e-3, 5e-3, 4)
        e, angle = axes_of(rng, 1)[0], rng.uniform(0.5, 3.0)
        body = {"J_B": FULL_INERTIA, "wheels": wheels, "wheel_axis": axes, "wheel_torque_max": torques}
        attitude = Rotation.from_rotvec(angle * e).as_matrix()
        with running(BLOCK, **body, reference="inertial", R_NB=attitude, torque_share=1.0, **NO_FIELD) as it:
            y = it.outputs()
        most = reach(axes[:wheels], torques[:wheels], FULL_INERTIA @ e)
        assert y["phase"] == 2
        assert y["dOmega_d"] == pytest.approx(-most * e, rel=1e-6, abs=1e-6 * most)


@pytest.mark.parametrize("h_w", [[0.0, 0.0, 0.0, 0.0], [0.004, -0.003, 0.001, 0.002]])
def test_a_turn_accelerates_coasts_and_brakes_within_the_momentum_that_is_left(h_w: list[float]) -> None:
    e, angle = np.array([2.0, -1.0, 2.0]) / 3.0, 2.5
    axes, along = FOUR["wheel_axis"], FULL_INERTIA @ e
    H_N = turned(angle, e) @ (np.array(h_w) @ axes)
    ball = [np.linalg.norm(H_N) * u for u in axes_of(np.random.default_rng(1), 300)]  # anywhere in the body
    way = [turned(angle * i / 16.0, e).T @ H_N for i in range(17)]
    slow = 0.95 * min(reach(axes, np.full(4, MOMENTUM), along, base) for base in (ball if any(h_w) else [0.0]))
    rate = max(slow, min(reach(axes, np.full(4, 0.85 * 0.95 * MOMENTUM), along, base) for base in way))
    with running(BLOCK, **FOUR, reference="inertial", R_NB=turned(angle, e), h_w=h_w, **NO_FIELD) as it:
        a = np.linalg.norm(it.get("dOmega_d"))
        rise, seen = rate / a, []
        # With momentum that takes its way through the body a turn that coasts may go on faster.
        for i in range(1, int((rise + 2.0 * H if any(h_w) else 2.0 * angle / rate) / H)):
            left, speed = profile(angle, a, rate, i * H)
            h = turned(left, e).T @ H_N + speed * along
            it.set("R_NB", turned(left, e))
            it.set("omega_B", -speed * e)
            it.set("h_w", np.linalg.pinv(axes.T) @ h)
            it.step((i - 1) * H, H)
            seen.append((-it.get("Omega_d") @ e - speed, Rotation.from_matrix(it.get("R_d")).magnitude() - left))
    assert a <= 0.9 * reach(axes, np.full(4, TORQUE), along) * (1.0 + 1e-9)
    tolerance = 0.02 * rate if any(h_w) else 1e-9  # of directions drawn
    assert np.abs([speed for speed, _ in seen]).max() < tolerance
    assert abs(seen[int(rise / H)][1]) < max(1e-8, tolerance / H * rise)


def turned(angle: float, e: np.ndarray) -> np.ndarray:
    return Rotation.from_rotvec(angle * e).as_matrix()


def profile(angle: float, a: float, rate: float, t: float) -> tuple[float, float]:
    """What is left of a turn at t, and its speed: the trapezoid."""
    rise = rate / a
    whole = angle / rate + rise
    if t < rise:
        return angle - 0.5 * a * t**2, a * t
    if t < whole - rise:
        return angle - rate * (t - 0.5 * rise), rate
    return (0.5 * a * (whole - t) ** 2, a * (whole - t)) if t < whole else (0.0, 0.0)


@pytest.mark.parametrize(
    ("wheels", "angle", "axis"),
    [(3, 10.0, [1.0, 2.0, -1.0]), (4, 30.0, [0.0, 0.0, 1.0]), (4, 90.0, [1.0, 1.0, 1.0]), (3, 180.0, [2.0, -1.0, 2.0])],
)
def test_a_slew_settles_within_12_tenths_of_the_least_time_and_two_samples(
    wheels: int, angle: float, axis: list[float]
) -> None:
    least, settled = slewed(wheels, angle, np.array(axis) / np.linalg.norm(axis))
    assert 0.9 * least < settled <= 1.2 * least + 2.0 * H


@pytest.mark.thorough
@pytest.mark.parametrize("wheels", SETS)
def test_slews_about_100_random_axes_settle_within_12_tenths_of_the_least_time_and_two_samples(wheels: int) -> None:
    rng = np.random.default_rng(49)
    for axis in axes_of(rng, 100):
        for angle in (10.0, 30.0, 90.0, 180.0):
            least, settled = slewed(wheels, angle, axis)
            assert settled <= 1.2 * least + 2.0 * H, (axis, angle)


def test_what_is_wrong_with_wheels_and_targets_is_refused() -> None:
    from tests.native.driver import Refused

    wrong: list[tuple[dict[str, Any], str]] = [
        ({"wheel_momentum_target": [0.02, 0.02, 0.02, 0.02]}, "wheel_momentum_target: expected a sum of at most half"),
        ({"wheel_momentum_target": [0.04, 0.0, 0.0, 0.0]}, "wheel_momentum_target: expected within"),
        ({"R_NB": np.diag([1.0, 1.0, 0.9])}, "R_NB: expected a rotation matrix"),
        ({"R_ref": np.eye(3)}, "R_ref: expected R_ref, Omega_ref and dOmega_ref connected, or none"),
    ]
    for changes, message in wrong:
        with pytest.raises(Refused, match=message):
            running(BLOCK, **{**FOUR, **changes})
