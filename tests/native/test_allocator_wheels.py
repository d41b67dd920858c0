"""The bounded allocator for a set of wheels: SciPy on the whole problem, one of its wheels beside the allocator of one
wheel, the null space of four wheels, and what it refuses.

Shows AB-3.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.optimize import lsq_linear

from tests.blocks import PYRAMID

from .driver import Instance, Refused, assert_first_of_set, running

BLOCK = "allocator_bounded_wheels"
FOUR: dict[str, Any] = {"wheels": 4, "wheel_axis": PYRAMID}


def units(rng: np.random.Generator, n: int) -> np.ndarray:
    axes = rng.normal(size=(n, 3))
    return axes / np.linalg.norm(axes, axis=1, keepdims=True)


def drawn_set(rng: np.random.Generator) -> dict[str, Any]:
    """Up to three rods and none to four wheels, each with its own axis and limits."""
    return {
        "rods": int(rng.integers(4)),
        "wheels": int(rng.integers(5)),
        "rod_axes": units(rng, 3),
        "rod_limits": rng.uniform(0.2, 1.0, 3),
        "dipole_max": 10.0 ** rng.uniform(-1.0, 1.5),
        "wheel_axis": units(rng, 4),
        "wheel_torque_max": 10.0 ** rng.uniform(-3.3, -2.0, 4),
        "wheel_momentum_max": rng.uniform(0.01, 0.05, 4),
        "wheel_momentum_target": rng.choice([0.0, 5e-3, -8e-3], 4),
        "command_period": float(rng.choice([0.5, 5.0])),
        "desaturation_time": float(rng.choice([10.0, 100.0])),
        "rod_weight": 10.0 ** rng.uniform(-7.0, -6.0),
        "wheel_weight": 10.0 ** rng.uniform(-2.5, -0.5),
        "wheel_weight_ff": 10.0 ** rng.uniform(-2.5, -0.5),
    }


def drawn_inputs(rng: np.random.Generator) -> dict[str, Any]:
    """Demands that are met and ten times too large, with wheels still, running and past their limits."""
    optional = {
        "dipole_ff": rng.uniform(-30.0, 30.0, 3),
        "wheel_torque_ff": rng.uniform(-4e-3, 4e-3, 4),
        "rod_gains": rng.choice([1.0, 0.8, 0.0, -1.0], 3),
        "wheel_gains": rng.choice([1.0, 1.0, 0.7, 0.0, -1.0], 4),
    }
    return {
        "tau_cmd_B": rng.normal(size=3) * 10.0 ** rng.uniform(-5.0, -1.5),
        "b_B": rng.normal(size=3) * 3e-5,
        "omega_B": rng.normal(size=3) * 0.03,
        "h_w": rng.uniform(-0.055, 0.055, 4) * rng.choice([0.0, 0.5, 1.0], 4),
        **{name: value if rng.random() < 0.4 else np.full_like(value, 1e9) for name, value in optional.items()},
    }


def problem(p: dict[str, Any], u: dict[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Residuals as a matrix and a vector, and the box, in shares of the limits, from the equations of the interface."""
    n, k = p["rods"], p["wheels"]
    rod_gains, wheel_gains = (np.where(np.abs(u[x]).max() > 9e8, 1.0, u[x]) for x in ("rod_gains", "wheel_gains"))
    axes, most = p["wheel_axis"][:k], p["wheel_momentum_max"][:k]
    h_w, torque_max, T = u["h_w"][:k], p["wheel_torque_max"][:k], p["command_period"]
    low, high = -torque_max, torque_max.copy()
    for i in range(k):
        ahead = np.sort([(-most[i] - h_w[i]) / T, (most[i] - h_w[i]) / T]) * (1.0 if wheel_gains[i] >= 0.0 else -1.0)
        low[i], high[i] = max(low[i], min(ahead.min(), 0.0)), min(high[i], max(ahead.max(), 0.0))
    limit = np.concatenate((p["dipole_max"] * p["rod_limits"][:n], p["wheel_torque_max"][:k]))
    low, high = np.concatenate((-limit[:n], low)), np.concatenate((limit[:n], high))
    with_ff = np.abs(u["wheel_torque_ff"]).max() < 9e8
    to_target = -(h_w - p["wheel_momentum_target"][:k]) / p["desaturation_time"]
    dipole = np.zeros(n) if np.abs(u["dipole_ff"]).max() > 9e8 else u["dipole_ff"][:n]
    preferred = np.clip(np.concatenate((dipole, u["wheel_torque_ff"][:k] if with_ff else to_target)), low, high)
    weight = np.array([p["rod_weight"]] * n + [p["wheel_weight_ff" if with_ff else "wheel_weight"]] * k)
    columns = [g * np.cross(a, u["b_B"]) for g, a in zip(rod_gains, p["rod_axes"][:n], strict=False)]
    columns += [-g * a for g, a in zip(wheel_gains, axes, strict=False)]
    torque = np.array(columns).reshape(-1, 3).T
    r = u["tau_cmd_B"] + np.cross(u["omega_B"], h_w @ axes)
    A = np.vstack((torque * limit, np.diag(weight * limit)))
    return A, np.concatenate((r, weight * preferred)), low / limit, high / limit


def compare_with_scipy(count: int, seed: int) -> tuple[int, int]:
    """Flies `count` cases; returns how many have a command at a limit, and how many are SciPy's to 1e-6."""
    rng = np.random.default_rng(seed)
    binding = same = 0
    for k in range(count):
        if k % 20 == 0:
            p = drawn_set(rng)
            it = running(BLOCK, **p)
        u = drawn_inputs(rng)
        for name, value in u.items():
            it.set(name, value)
        y = it.outputs()
        n, m = p["rods"], p["wheels"]
        assert not y["dipole_cmd"][n:].any()
        assert not y["wheel_torque_cmd"][m:].any()
        A, b, low, high = problem(p, u)
        limit = np.concatenate((p["dipole_max"] * p["rod_limits"][:n], p["wheel_torque_max"][:m]))
        x = np.concatenate((y["dipole_cmd"][:n], y["wheel_torque_cmd"][:m])) / limit
        given = A[:3] @ x
        r = b[:3] - given
        np.testing.assert_allclose(y["tau_residual_B"], r, rtol=1e-9, atol=1e-16 + 1e-12 * np.abs(b[:3]).max())
        if not n + m:
            same += 1
            continue
        assert ((low - 1e-12 <= x) & (x <= high + 1e-12)).all()
        open_ = high - low > 1e-15  # SciPy wants room
        z = np.zeros(n + m)
        z[open_] = lsq_linear(A[:, open_], b, (low[open_], high[open_]), method="bvls", tol=1e-15, max_iter=500).x
        ours, theirs = (float(np.sum((A @ v - b) ** 2)) for v in (x, z))
        assert ours <= theirs * (1.0 + 1e-9) + 1e-26
        binding += bool((np.minimum(x - low, high - x) < 1e-9).any())
        same += bool(np.abs(x - z).max() < 1e-6)
    return binding, same


def test_scipy_finds_no_better_commands_for_any_set_within_the_limits() -> None:
    binding, same = compare_with_scipy(400, seed=1)
    assert binding > 200
    assert same > 380


@pytest.mark.thorough
def test_scipy_finds_no_better_commands_in_ten_thousand_cases() -> None:
    binding, same = compare_with_scipy(10_000, seed=2)
    assert binding > 5_000
    assert same > 9_500


def test_one_wheel_of_the_set_is_the_allocator_of_one_wheel_bit_by_bit() -> None:
    rng = np.random.default_rng(3)
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    with (
        running("allocator_bounded", wheel_axis=axis) as one,
        running(BLOCK, wheel_axis=np.vstack((axis, rng.normal(size=(3, 3)) / 9.0)), find_failures=False) as four,
    ):
        for i in range(100):
            u = drawn_inputs(rng)
            for name in ("tau_cmd_B", "b_B", "omega_B", "dipole_ff", "rod_gains"):
                one.set(name, u[name])
                four.set(name, u[name])
            for name in ("h_w", "wheel_torque_ff"):
                one.set(name, u[name][0])
                four.set(name, u[name])
            for it in (one, four):
                it.step(0.5 * i, 0.5)
            assert_first_of_set(one.outputs(), four.outputs())


def flown(count: int, **changes: Any) -> np.ndarray:
    """Momenta of wheels that follow the commands of 500 s without demand and field, each second."""
    h = np.asarray(changes.pop("h_w"), float)
    with running(BLOCK, **FOUR, b_B=[0.0, 0.0, 0.0], h_w=h, wheel_weight=0.1, **changes) as it:
        momenta = [h]
        for i in range(count):
            h = h + it.get("wheel_torque_cmd")
            it.set("h_w", h)
            it.step(float(i), 1.0)
            momenta.append(h)
    return np.array(momenta)


NULL = null_space(PYRAMID.T)[:, 0]


def test_four_wheels_leave_rest_along_their_null_space_and_the_total_momentum_stays() -> None:
    """Without a field nothing but the wheels acts, so their sum stays; each ends at the least momentum asked for."""
    start = np.array([1e-3, -2e-3, 1.5e-3, 0.5e-3])
    momenta = flown(600, h_w=start, null_space_momentum=8e-3)
    np.testing.assert_allclose((momenta - start) @ PYRAMID, 0.0, atol=2e-4)
    moved = momenta[-1] - start
    along = moved @ NULL
    assert np.abs(moved - along * NULL).max() < 2e-4
    assert np.abs(momenta[-1]).min() > 7.5e-3


def test_without_the_parameter_the_wheels_go_to_their_target_along_the_null_space() -> None:
    target = 6e-3 * NULL * 2.0
    momenta = flown(600, h_w=np.zeros(4), wheel_momentum_target=target)
    np.testing.assert_allclose(momenta[-1], target, atol=1e-4)
    assert np.abs(flown(600, h_w=target)[-1]).max() < 1e-4


def test_wheels_near_their_limits_move_away_from_them_along_the_null_space() -> None:
    start = 0.058 * NULL  # of 0.03 each
    momenta = flown(600, h_w=start, null_space_momentum=5e-3)
    assert np.abs(momenta[-1]).max() < 0.0252
    assert np.abs(momenta[-1]).min() > 4.9e-3


def test_a_wheel_beside_its_wanted_band_moves_to_the_nearest_edge_and_one_within_it_rests() -> None:
    inside = 0.02 * NULL
    np.testing.assert_allclose(flown(50, h_w=inside, null_space_momentum=5e-3)[-1], inside, atol=1e-9)
    outside = flown(600, h_w=0.008 * NULL, null_space_momentum=5e-3)[-1]
    np.testing.assert_allclose(outside, 0.010 * NULL, atol=2e-5)


def test_the_rods_bring_the_wheels_to_their_target_where_the_field_turns() -> None:
    """The demand is zero, the field turns: what the wheels give up the rods take, so the body feels little."""
    h, worst = np.array([0.02, -0.015, 0.01, 0.0]), 0.0
    target = np.array([2e-3, -2e-3, 1e-3, 0.0])
    axes = np.vstack((np.eye(3), [1.0, 0.0, 0.0]))
    law = {"wheels": 3, "wheel_axis": axes, "wheel_momentum_target": target, "wheel_weight": 0.02}
    with Instance(BLOCK) as it:
        for name, value in {**law, "rod_axes": np.eye(3), "desaturation_time": 200.0}.items():
            it.set(name, value)
        it.set("h_w", h)
        it.initialize()
        for i in range(4000):
            angle = 2.0 * math.pi * i / 3000.0
            it.set("b_B", 3e-5 * np.array([math.cos(angle), math.sin(angle), 0.5]))
            it.set("h_w", h)
            it.step(float(i), 1.0)
            h = h + it.get("wheel_torque_cmd")
            worst = max(worst, float(np.abs(it.get("tau_residual_B")).max()))
    np.testing.assert_allclose(h, target, atol=2e-4)
    assert worst < 1e-6  # of 1e-4 N m that the wheels give up at first


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"wheels": 2, "wheel_axis": [[1.0, 0.0, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]}, "axis.2"),
        ({"rods": 2, "rod_axes": [[1.0, 0.0, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 0.0]]}, "rod_axes.2"),
        ({"wheels": 5}, "wheels: expected 0 to 4, found 5"),
        ({**FOUR, "wheel_weight": 1e-5}, "wheel_weight: expected at least 0.0001 with several wheels, found 1e-05"),
        (
            {**FOUR, "null_space_momentum": 0.02},
            "null_space_momentum: expected at most half of each wheel_momentum_max",
        ),
        ({**FOUR, "J_B": np.diag([1.0, 1.0, 3.0])}, "J_B: expected the inertia of a body"),
        ({**FOUR, "wheel_momentum_target": [0.0, 0.04, 0.0, 0.0]}, "wheel_momentum_target: expected within wheel_mom"),
    ],
)
def test_sets_that_cannot_be_allocated_to_are_refused_by_name(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(Refused, match=message):
        running(BLOCK, **changes)


def test_rods_and_wheels_that_are_not_there_are_not_looked_at() -> None:
    nothing = {"rods": 0, "wheels": 0, "rod_axes": np.zeros((3, 3)), "wheel_axis": np.zeros((4, 3))}
    with running(BLOCK, **nothing, tau_cmd_B=[1e-3, 2e-3, 3e-3], h_w=[0.1] * 4, omega_B=[0.1, 0.2, 0.3]) as it:
        y = it.outputs()
    assert not y["dipole_cmd"].any()
    assert not y["wheel_torque_cmd"].any()
    np.testing.assert_array_equal(y["tau_residual_B"], [1e-3, 2e-3, 3e-3])
    assert y["demand_fraction"] == 0.0


def test_friction_is_learned_and_given_back_on_both_sides_of_zero_speed() -> None:
    """A wheel of closed form: its momentum changes by the command less Coulomb friction along its path."""
    friction, T = np.array([0.0, 4e-5, 0.0, 1e-4]), 0.5
    h = np.array([1e-3, 1.2e-3, -1e-3, 2e-3])
    missed = []
    with running(BLOCK, **FOUR, b_B=[0.0, 0.0, 0.0], h_w=h, wheel_weight_ff=0.1) as it:
        for i in range(1600):
            command = it.get("wheel_torque_cmd")
            wanted = it.get("wheel_torque_ff")
            sign = np.sign(h)
            end = h + T * (command - friction * sign)
            crosses = h * end < 0.0  # then friction turns round where the wheel stands still
            first = np.where(crosses, np.abs(h) / np.maximum(np.abs(command - friction * sign), 1e-12), 0.0)
            end = np.where(crosses, (T - first) * (command + friction * sign), end)
            if i > 0:
                missed.append(np.abs((end - h) / T - wanted))
            h = end
            torque = 1.1e-4 * math.cos(i / 120.0) * NULL / np.abs(NULL).max()
            it.set("wheel_torque_ff", torque)
            it.set("h_w", h)
            it.step(T * i, T)
            assert not it.outputs()["wheel_failed"].any()
        it.set("h_w", np.zeros(4))
        for side in (1.0, -1.0, 0.0):  # from rest friction is against the motion that is wanted
            wanted = side * 1e-4 * NULL / np.abs(NULL).max()
            it.set("wheel_torque_ff", wanted)
            given = it.get("wheel_torque_cmd")
            np.testing.assert_allclose(given, wanted + friction * np.sign(wanted), atol=3e-6)
    assert np.max(missed[:20]) > 3e-5
    late = np.array(missed[800:])  # a sample in which a wheel crosses zero is not exact
    assert late.max(axis=1).mean() < 1e-6
    assert (late > 3e-6).any(axis=1).mean() < 0.02


def test_a_dead_wheel_is_found_by_commands_that_friction_could_take_and_one_that_sticks_is_moved() -> None:
    """Commands of 0.4 % of the torque; of the second case the friction is 4 % and holds the wheel at first."""
    for gain, friction in ((0.0, 0.0), (1.0, 1.2e-4)):
        rng, h, found = np.random.default_rng(3), np.zeros(4), []
        with running(BLOCK, **FOUR, b_B=[0.0, 0.0, 0.0], wheel_weight_ff=0.1) as it:
            for i in range(1200):
                command = it.get("wheel_torque_cmd")
                beyond = np.maximum(np.abs(command[1]) - friction, 0.0) * np.sign(command[1])
                h = h + 0.5 * np.where(np.arange(4) == 1, gain * beyond, command)
                torque = 1.2e-5 * np.sign(math.sin(i / 60.0)) * NULL / np.abs(NULL).max()
                it.set("wheel_torque_ff", torque + rng.normal(scale=1e-7, size=4))
                it.set("h_w", h)
                it.step(0.5 * i, 0.5)
                found.append(it.get("wheel_failed").tolist())
        assert found[-1] == [False, gain == 0.0, False, False]
        assert not any(each[k] for each in found for k in (0, 2, 3))
        assert gain == 0.0 or not np.any(found)
