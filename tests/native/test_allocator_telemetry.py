"""Telemetry of a wheel of a set that fails, and wheels that fail, on a free body: it turns by what the wheels took.

The body is that of a closed form: without a field its momentum and that of its wheels stay, J omega + sum h_i a_i = 0.

Shows AB-3.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from evidence.paper import Array
from tests.blocks import PYRAMID

from .driver import running

T, LIMIT, TORQUE = 0.5, 0.03, 3e-3
J = np.array([[2.1, 0.1, 0.0], [0.1, 3.0, -0.2], [0.0, -0.2, 3.1]])
SETS = {3: np.vstack((np.eye(3), [1.0, 0.0, 0.0])), 4: PYRAMID}
Told = Callable[[int, float, np.random.Generator], float]


def flown(
    wheels: int, told: Told, gain: Callable[[int], float] = lambda i: 1.0, count: int = 600, inertia: Array = J
) -> dict[str, Any]:
    """Outputs of each sample, and true momenta: the second wheel tells told(sample, h, rng) and gives gain(sample).

    The demand pulls to and fro each 10 s about an axis that is drawn, as slews do; telemetry and rate have noise.
    """
    axes, rng = SETS[wheels], np.random.default_rng(5)
    h, last = np.zeros(4), np.zeros(4)
    law = {"wheels": wheels, "wheel_axis": axes, "J_B": inertia, "command_period": T, "wheel_weight_ff": 0.01}
    outputs = ("wheel_failed", "wheel_reversed", "h_w_failed", "h_w_estimate")
    found: dict[str, list[Any]] = {name: [] for name in (*outputs, "h")}
    with running("allocator_bounded_wheels", **law, b_B=[0.0] * 3) as it:
        for i in range(count):
            gains = np.ones(4)
            gains[1] = gain(i)
            h = np.clip(h + T * gains * it.get("wheel_torque_cmd"), -LIMIT, LIMIT)
            if i % 40 == 0:
                pull = rng.normal(size=3)
                pull *= 1.5e-3 / np.linalg.norm(pull)
            omega = -np.linalg.solve(J, h[:wheels] @ axes[:wheels])
            last = h + rng.normal(scale=3e-6, size=4)
            last[1] = told(i, last[1], rng)
            it.set("h_w", last)
            it.set("omega_B", omega + rng.normal(scale=1e-5, size=3))
            it.set("wheel_torque_ff", np.zeros(4))
            it.set("tau_cmd_B", pull if i % 40 < 20 else -pull)
            it.step(T * i, T)
            for name in outputs:
                found[name].append(np.array(it.get(name)))
            found["h"].append(h)
    return {name: np.array(values) for name, values in found.items()}


class Frozen:
    """Repeats what it told at `begin`, until `end`."""

    def __init__(self, begin: int = 203, end: int = 10**9) -> None:
        self.begin, self.end, self.last = begin, end, 0.0

    def __call__(self, i: int, h: float, rng: np.random.Generator) -> float:
        self.last = self.last if self.begin <= i < self.end else h
        return self.last


def zero(i: int, h: float, rng: np.random.Generator) -> float:
    return h if i < 203 else 0.0


def noisy(i: int, h: float, rng: np.random.Generator) -> float:
    return h if i < 203 else h + 0.1 * LIMIT * rng.normal()


def biased(i: int, h: float, rng: np.random.Generator) -> float:
    return h if i < 203 else h + 0.2 * LIMIT


def quarter(i: int, h: float, rng: np.random.Generator) -> float:
    """Neither repeats nor jumps: only the body tells."""
    return h if i < 40 else 0.25 * h


@pytest.mark.parametrize("wheels", SETS)
@pytest.mark.parametrize(
    "told", [Frozen(), zero, noisy, biased, quarter], ids=["frozen", "zero", "noisy", "biased", "quarter"]
)
def test_a_wheel_whose_telemetry_fails_is_not_reported_and_its_momentum_goes_on(wheels: int, told: Told) -> None:
    y = flown(wheels, told)
    assert not y["wheel_failed"].any()
    others = [0, 2, 3][: wheels - 1]
    assert not y["h_w_failed"][:, others].any()
    assert not y["h_w_failed"][: 40 if told is quarter else 203].any()
    assert y["h_w_failed"][:, 1].any()
    off = np.abs(y["h_w_estimate"] - y["h"])[:-1] - T * TORQUE  # the estimate is that of the next sample
    assert off[:, others].max() < 1e-4
    lasting = {biased: 0.2, quarter: 0.75}.get(told, 0.0)  # of the limit: what a bias tells is taken, once it is steady
    assert off[260:, 1].max() < (lasting + 0.1) * LIMIT


@pytest.mark.parametrize("wheels", SETS)
@pytest.mark.parametrize("gain", [0.0, 0.25])
def test_a_wheel_that_fails_is_reported_whose_telemetry_is_right(wheels: int, gain: float) -> None:
    y = flown(wheels, lambda i, h, rng: h, lambda i: 1.0 if i < 20 else gain)
    first = int(np.argmax(y["wheel_failed"][:, 1]))
    assert 20 < first < 20 + 300
    assert y["wheel_failed"][first:, 1].all()
    assert not y["wheel_failed"][:, [0, 2, 3]].any()


@pytest.mark.parametrize("wheels", SETS)
def test_a_wheel_that_turns_round_is_used_with_the_opposite_sign(wheels: int) -> None:
    y = flown(wheels, lambda i, h, rng: h, lambda i: 1.0 if i < 20 else -1.0)
    first = int(np.argmax(y["wheel_failed"][:, 1]))
    assert 20 < first < 20 + 300
    assert not y["wheel_failed"][first + 4 :].any()  # the trial takes 2 s
    assert y["wheel_reversed"][first + 4 :, 1].all()
    assert not y["wheel_reversed"][:, [0, 2, 3]].any()
    assert not y["h_w_failed"][first + 20 :].any()


def test_a_wheel_that_fails_after_its_telemetry_is_found_by_the_body_alone() -> None:
    y = flown(3, Frozen(60), lambda i: 1.0 if i < 100 else 0.0)
    first = int(np.argmax(y["wheel_failed"][:, 1]))
    assert 100 < first < 500


def test_telemetry_that_comes_back_is_used_again_each_time() -> None:
    class Twice:
        def __init__(self) -> None:
            self.parts = Frozen(103, 200), Frozen(303, 400)

        def __call__(self, i: int, h: float, rng: np.random.Generator) -> float:
            return self.parts[i >= 250](i, h, rng)

    y = flown(4, Twice(), count=500)
    left_out = np.flatnonzero(y["h_w_failed"][:, 1])
    assert set(left_out) & set(range(103, 200))
    assert set(left_out) & set(range(303, 400))
    assert not set(left_out) & {*range(103), *range(230, 303), *range(430, 500)}
    assert np.abs(y["h_w_estimate"] - y["h"])[430:].max() < 1.1 * T * TORQUE


@pytest.mark.parametrize(("told", "failed"), [(zero, False), (quarter, True)])
def test_without_the_inertia_only_telemetry_that_repeats_or_jumps_is_left_out(told: Told, failed: bool) -> None:
    y = flown(4, told, inertia=np.zeros((3, 3)))
    assert y["wheel_failed"][:, 1].any() == failed
    assert y["h_w_failed"][:, 1].any() != failed
