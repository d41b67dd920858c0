"""The C and the Python of each block give the same outputs: 1e-9 relative in every port, on random inputs and
options.

Shows CT-1, CT-2, CT-3, AL-1, AL-2, AB-1, SV-1, SV-2, ES-1, ES-3.
"""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

import allocator.bounded
from fmus.interface import ABSENT_MIN
from tests.blocks import inputs, module, parameters

from .agreement import assert_same
from .drawn import CASES
from .driver import Instance


@pytest.mark.parametrize("case", CASES)
def test_outputs_in_initialization_and_over_steps_agree(case: str) -> None:
    rng = np.random.default_rng(4)
    block = case.partition(",")[0]
    python = module(block)
    compared = 0
    for _ in range(100):
        p, u = CASES[case](rng)
        python.check(p)
        with Instance(block) as native:
            native.set_all(p)
            native.set_all(u)
            native.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
            native.call("EnterInitializationMode")
            x = python.start(p, u)
            assert_same(native.outputs(), python.outputs(x, u, p), block)
            native.call("ExitInitializationMode")
            for i in range(5):
                _, u = CASES[case](rng)
                native.set_all(u)
                assert_same(native.outputs(), python.outputs(x, u, p), block)  # Get after Set, before doStep
                native.step(0.1 * i, 0.1)
                x, y = python.step(x, u, p, 0.1)
                assert_same(native.outputs(), y, block)
                compared += 1
    assert compared == 500


@pytest.mark.parametrize("input_", ["dipole_ff", "wheel_torque_ff", "rod_gains"])
@pytest.mark.parametrize("share", [0.5, 1.0 - 1e-15, 1.0, 1.0 + 1e-15, 1.001, 1e3])
def test_both_flavours_take_an_optional_input_for_unconnected_from_the_same_magnitude_on(
    input_: str, share: float
) -> None:
    python = allocator.bounded
    p = parameters("allocator_bounded")
    ordinary = inputs("allocator_bounded", tau_cmd_B=[1e-4, 2e-4, -1e-4], b_B=[2e-5, 1e-5, -3e-5], h_w=0.01)
    x = python.start(p, ordinary)
    unconnected = python.outputs(x, ordinary, p)
    for sign in (1.0, -1.0):
        size = sign * share * ABSENT_MIN
        u = replace(ordinary, **{input_: size if input_ == "wheel_torque_ff" else np.array([3.0, size, -2.0])})
        y = python.outputs(x, u, p)
        with Instance("allocator_bounded") as native:
            native.set_all(p)
            native.set_all(u)
            native.initialize()
            assert_same(native.outputs(), y, "allocator_bounded")
        assert np.array_equal(y.dipole_cmd, unconnected.dipole_cmd) == (share >= 1.0)


@pytest.mark.parametrize(
    "epoch",
    [
        *("1900-01-01T00:00:00Z", "1900-02-28T23:59:59Z", "1900-03-01T00:00:00Z", "1999-12-31T23:59:59.75Z"),
        *("2000-02-28T12:00:00Z", "2000-02-29T12:00:00Z", "2000-03-01T12:00:00Z", "2000-12-31T00:00:01Z"),
        *("2012-02-29T06:30:15.5Z", "2023-02-28T23:00:00Z", "2023-03-01T01:00:00Z", "2024-02-29T00:00:00Z"),
        *("2024-12-31T23:59:59Z", "2025-01-01T00:00:00Z", "2026-07-31T18:00:00Z", "2026-08-01T00:00:00Z"),
    ],
)
def test_both_flavours_count_days_as_the_calendar_of_python_does(epoch: str) -> None:
    """A day more turns the node by 0.986 deg, 120 km, and a second by 0.5 km."""
    days = (datetime.fromisoformat(epoch) - datetime(2000, 1, 1, 12, tzinfo=UTC)) / timedelta(days=1)
    century = days / 36525.0
    seconds = 67310.54841 + (876600.0 * 3600.0 + 8640184.812866) * century + 0.093104 * century**2 - 6.2e-6 * century**3
    angle = math.radians(seconds / 240.0)  # Greenwich mean sidereal time, IAU 1982
    p = parameters("plant", epoch=epoch, field_model="igrf14", node_longitude=0.0)
    found = module("plant").outputs(module("plant").start(p, inputs("plant")), inputs("plant"), p).r_N
    expected = p.orbit_radius * np.array([math.cos(angle), math.sin(angle), 0.0])
    np.testing.assert_allclose(found, expected, atol=1.0)
    with Instance("plant") as it:
        it.set_all(p)
        it.initialize()
        np.testing.assert_allclose(it.get("r_N"), expected, atol=1.0)
