"""The estimator's bank: what it says of attitudes that fit alike, of a wrong gyro scale and of currents.

Shows ES-3.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import estimator
from estimator.banked import Banked
from tests.blocks import inputs, parameters

R_N = np.array((6971000.0, 0.0, 0.0))
LIT = "2009-02-10T00:00:00Z"
"""At this date the Sun is seen from R_N."""
SPIN = np.array((0.1, -0.5, 0.07))


def fly(
    seconds: int, scale: float = 0.0, light: bool = False, bias: tuple[float, ...] = (0.0, 0.0, 0.0), **changes: object
) -> list[estimator.block.Outputs]:
    """A spin at one place with a gyro whose scale is off and a magnetometer with a bias; outputs of each second. The
    true attitude is exp(SPIN t)."""
    p = parameters("estimator", bank=True, epoch=LIT, field_noise=1e-7, angle_random_walk=1e-5, **changes)
    estimator.block.check(p)
    sun_N = estimator.onboard.sun_direction(p.days)
    down, lit = -R_N / np.linalg.norm(R_N), 0.3 * (6378137.0 / 6971000.0) ** 2 * max(0.0, sun_N[0])
    given, state = [], None
    for i in range(seconds + 1):
        R = Rotation.from_rotvec(SPIN * i).as_matrix()
        seen = p.sun_sensor_axes @ R.T @ sun_N
        earth = (0.5 * (1.0 + p.sun_sensor_axes @ R.T @ down)) ** 2
        u = inputs(
            "estimator",
            omega_B_measured=(1.0 + scale) * SPIN,
            b_B_measured=R.T @ p.field.at(float(i), R_N) + bias,
            r_N_measured=R_N,
            v_N_measured=np.zeros(3),
            sun_sensors=np.maximum(seen, 0.0) + lit * earth if light else np.full(6, 1e9),
        )
        if state is None:
            state = estimator.block.start(p, u)
            given.append(estimator.block.outputs(state, u, p))
        else:
            state, y = estimator.block.step(state, u, p, 1.0)
            given.append(y)
    return given


def off(R: np.ndarray, seconds: int) -> float:
    """deg from the true attitude."""
    truth = Rotation.from_rotvec(SPIN * seconds).as_matrix()
    return math.degrees(Rotation.from_matrix(R.T @ truth).magnitude())


def test_what_the_field_of_one_place_cannot_tell_is_doubtful_and_no_attitude_is_given() -> None:
    last = fly(5)[-1]
    assert last.attitude_doubtful == 1
    assert last.ambiguity > math.radians(30.0)
    assert not last.attitude_valid
    assert not last.R_NB.any()


def test_currents_and_field_give_attitude_and_gyro_scale() -> None:
    last = fly(60, scale=0.015, light=True)[-1]
    assert not last.attitude_doubtful
    assert last.attitude_valid
    assert off(last.R_NB, 60) < 1.0
    assert last.omega_B == pytest.approx(SPIN, abs=2e-3)
    assert np.linalg.norm(last.omega_B - SPIN) < 0.2 * np.linalg.norm(0.015 * SPIN)


def test_a_bias_of_the_magnetometer_is_estimated_where_one_is_stated() -> None:
    bias = (8e-7, -6e-7, 5e-7)
    known, unknown = (fly(90, light=True, bias=bias, field_bias_sigma=sigma)[-1] for sigma in (1e-6, 0.0))
    assert known.field_bias_B == pytest.approx(bias, abs=5e-8)
    assert known.b_B == pytest.approx(field_in(known.R_NB), abs=2e-7)
    assert off(known.R_NB, 90) < 0.3 < off(unknown.R_NB, 90)
    assert not unknown.field_bias_B.any()


def field_in(R: np.ndarray) -> np.ndarray:
    """The model's field in the axes of an attitude, after 90 s."""
    p = parameters("estimator", epoch=LIT)
    return R.T @ p.field.at(90.0, R_N)


def test_a_scale_that_cannot_be_is_doubtful() -> None:
    """15% where 0.3% is known: the field is followed by a scale or a bias far beyond what is known before."""
    last = fly(120, scale=0.15, light=True, rate_scale_sigma=0.003, rate_bias_sigma=3e-3, gate=1e9)[-1]
    assert last.attitude_doubtful == 2
    assert not last.attitude_valid


def test_a_field_that_leaves_the_attitude_for_good_starts_the_bank_again() -> None:
    p = parameters("estimator", bank=True, epoch=LIT, field_noise=1e-8, rate_bias_sigma=1e-6, rate_scale_sigma=0.0)
    B = p.field.at(0.0, R_N)
    u = inputs("estimator", b_B_measured=B, r_N_measured=R_N, v_N_measured=np.zeros(3), omega_B_measured=np.zeros(3))
    state = estimator.block.start(p, u)
    for _ in range(60):
        state, _ = estimator.block.step(state, u, p, 0.1)
    turned = replace(u, b_B_measured=np.array((B[1], -B[0], B[2])))
    count = []
    for _ in range(60):
        state, y = estimator.block.step(state, turned, p, 0.1)
        bank = Banked.unpacked(state.banked).bank
        count.append(0 if bank is None else len(bank.score))
    assert 0 in count
    assert count[-1] > 0
    assert y.nis[0] < p.gate


def test_a_bank_without_gyro_is_refused() -> None:
    with pytest.raises(ValueError, match="bank: expected rate_source 'gyro', found 'dynamics'"):
        estimator.block.check(parameters("estimator", bank=True, rate_source="dynamics"))


def test_a_bank_is_kept_as_one_array() -> None:
    p = parameters("estimator", bank=True)
    state = estimator.block.start(p, inputs("estimator"))
    again = Banked.unpacked(state.banked)
    assert again.bank is not None
    assert np.array_equal(again.packed, state.banked)
    assert len(again.bank.score) == 40
