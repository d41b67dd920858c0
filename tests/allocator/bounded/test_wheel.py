"""The bounded allocator's wheel: drawn to rest, and never past its momentum.

Shows AB-2.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.blocks import inputs
from tests.native.driver import Instance

from .problems import BLOCK, P, given


def test_a_running_wheel_is_drawn_to_rest_at_the_price_stated():
    """The share w^2/(w^2 + b1^2) of -l/T, where rods can make good what lies across the field."""
    for b1 in (0.0, 0.05, 0.1, 0.3, 0.8, 1.0):
        b = np.array([b1, math.sqrt(1.0 - b1**2), 0.0])
        u = inputs(BLOCK, b_B=3e-5 * b, h_w=6e-3)
        y = given(u, replace(P, rod_weight=1e-8))
        expected = -6e-3 / 60.0 * 0.01 / (0.01 + b1**2)
        assert y.wheel_torque_cmd == pytest.approx(expected, rel=1e-4)
        assert abs(y.tau_residual_B @ b) == pytest.approx(abs(b1 * expected), rel=1e-4, abs=1e-15)
        assert np.linalg.norm(y.tau_residual_B) <= 0.1 * 1e-4 / 2.0 + 1e-12


@pytest.mark.parametrize("period", [0.1, 0.5, 12.0])
def test_the_wheel_meets_its_momentum_limit_at_the_end_of_the_period_and_not_before(period):
    p = replace(P, command_period=period)
    for h_w in (0.0299, 0.03 - 1e-3 * period, 0.03, 0.0, -0.02):
        u = inputs(BLOCK, tau_cmd_B=[-0.05, 0.0, 0.0], b_B=[3e-5, 0.0, 0.0], h_w=h_w)
        expected = min(0.003, (0.03 - h_w) / period)
        assert given(u, p).wheel_torque_cmd == pytest.approx(expected, rel=1e-12, abs=1e-18)
        mirrored = replace(u, tau_cmd_B=-u.tau_cmd_B, h_w=-h_w)
        assert given(mirrored, p).wheel_torque_cmd == pytest.approx(-expected, rel=1e-12, abs=1e-18)


def test_a_wheel_past_its_limit_is_not_driven_further_and_may_come_back():
    b = [3e-5, 0.0, 0.0]
    for h_w in (0.03 + 1e-17, 0.031, 0.1):
        out, back = (inputs(BLOCK, tau_cmd_B=[tau, 0.0, 0.0], b_B=b, h_w=h_w) for tau in (-1e-3, 1e-3))
        assert given(out).wheel_torque_cmd == 0.0
        assert given(back).wheel_torque_cmd == pytest.approx(-1e-3 / 1.01 - 0.01 / 1.01 * h_w / 60.0)


@pytest.mark.fly
def test_the_wheel_never_passes_its_limit_on_the_plant_over_hours():
    """A tumbling satellite whose demand would fill the wheel at once: the plant itself never has to cut its torque."""
    near, full, expected, h = 0, 0.0, 0.0, 2.0
    with Instance("plant") as body, Instance(BLOCK) as law:
        body.set("omega_B0", [0.01, 0.02, -0.015])
        body.set("drag", False)
        law.set("command_period", h)
        law.set("wheel_weight", 0.0)
        body.initialize()
        law.initialize()
        for k in range(5400):  # three hours
            body.step(h * k, h)
            h_w = body.get("h_w")
            assert h_w == pytest.approx(expected, abs=1e-16)
            full, near = max(full, abs(h_w)), near + (abs(h_w) > 0.029)
            for name in ("b_B", "omega_B", "h_w"):
                law.set(name, body.get(name))
            law.set("tau_cmd_B", 2e-3 * np.array([math.cos(1e-3 * k), 0.3, math.sin(0.05 * k)]))
            law.step(h * k, h)
            for name in ("dipole_cmd", "wheel_torque_cmd"):
                body.set(name, law.get(name))
            expected = h_w + h * law.get("wheel_torque_cmd")
    assert near > 500
    assert full == pytest.approx(0.03, abs=1e-16)
