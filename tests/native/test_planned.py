"""The planned controller's C as flight software calls it, in states that few flights reach."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from .direct import Direct


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_steering_ends_below_its_limit_and_begins_again_beyond_twice_the_limit(sign: float) -> None:
    """The momentum about e3 as a share of the limit; the wheel, along e1, takes none of it. The rate does not follow
    the commands, which would be taken for a larger inertia: it is not estimated."""
    direct = Direct("controller_planned")
    weak = {
        "J_B": 3.0 * np.eye(3),
        "steering_limit": 0.02,
        "dipole_max": 3.0,
        "reference": "inertial",
        "identify": False,
    }
    rates = {share: [0.0, 0.0, sign * share * 0.02 / 3.0] for share in (1.2, 0.9, 1.8, 2.2)}
    assert direct.start(**weak, omega_B=rates[1.2]) is None
    phases = []
    for rate in rates.values():
        for _ in range(40):
            assert direct.step(0.5, omega_B=rate) is None
        phases.append(direct.y.phase)
    assert phases == [1, 2, 2, 1]


def test_no_hold_begins_while_the_satellite_turns_though_it_points_well() -> None:
    direct = Direct("controller_planned")
    still = {"reference": "inertial", "identify": False}
    phases = {}
    for rate in (0.0, 2e-3):
        assert direct.start(**still, omega_B=[0.0, 0.0, rate]) is None
        for _ in range(130):
            assert direct.step(0.5, omega_B=[0.0, 0.0, rate]) is None
        phases[rate] = direct.y.phase
    assert phases == {0.0: 3, 2e-3: 2}


@pytest.mark.parametrize("rate", [1e100, 1e154, 1e300])
def test_a_rate_from_which_nothing_follows_is_forgotten_with_the_next_sample_but_one(rate: float) -> None:
    direct = Direct("controller_planned")
    for wrong in (rate, 0.0):
        assert direct.start() is None
        assert direct.step(0.5, omega_B=[wrong, wrong, 0.0]) is None
        assert direct.step(0.5) is None
        assert direct.step(0.5) is None
        assert np.abs(direct.y.tau_cmd_B).max() < 0.1


@pytest.mark.parametrize(("moments", "body"), [((1.1, 1.0, 1.7), True), ((0.75, 0.85, 1.95), False)])
def test_measurements_that_fit_no_body_leave_the_given_inertia(moments: tuple[float, ...], body: bool) -> None:
    """Rates by Euler's equations; no body has a moment above the sum of the others."""
    direct, J, h = Direct("controller_planned"), np.diag([1.0, 1.0, 1.95]), 0.5
    given = {"J_B": J, "identify_spread": 1.0, "rate_noise": 1e-6, "control_period": h}
    true, rate, changed = np.array(moments), np.array([0.05, -0.04, 0.06]), 0

    def acceleration(_: float, w: Any) -> Any:
        return -np.cross(w, true * w) / true

    assert direct.start(**given, omega_B=rate, h_w=0.0) is None
    for _ in range(40):
        rate = solve_ivp(acceleration, (0.0, h), rate, rtol=1e-10, atol=1e-14).y[:, -1]
        assert direct.step(h, omega_B=rate, h_w=0.0, u_applied=[0.0, 0.0, 0.0, 0.0]) is None
        estimate = np.array(direct.y.J_estimate_B).reshape(3, 3)
        assert max(np.diag(estimate)) <= 0.5 * np.trace(estimate) * (1.0 + 1e-8)
        changed += not np.array_equal(estimate, J)
    assert bool(changed) is body
