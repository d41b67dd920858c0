"""A CubeSat whose magnetometer freezes: the attitude is lost, it is safe, says so, and comes back by itself.

Shows SV-3.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from evidence.paper import ROOT
from orchestration import run

FROZEN, UNTIL, END = 800.0, 2900.0, 3600.0
BOUND = math.radians(30.0)
WIRES = [
    *(f"estimator.{name} -> supervisor.{name}" for name in ("R_NB", "omega_B", "r_N", "v_N")),
    *(f"estimator.{name} -> supervisor.{name}" for name in ("attitude_valid", "attitude_bound")),
    "sensors.sun_B_measured -> supervisor.sun_B",
    *(f"supervisor.{name} -> controller.{name}" for name in ("R_ref", "Omega_ref", "dOmega_ref")),
]


@pytest.fixture(scope="module")
def flown() -> dict[str, Any]:
    """From LVLH, with photodiodes and gyro alone while the magnetometer is frozen, an eclipse from about 2150 s on."""
    result = run(
        {
            "name": "frozen_field",
            "extends": str(ROOT / "scenarios" / "flight_cubesat.yaml"),
            "duration": END,
            "blocks": {
                "plant": {"start": {"Q0": np.eye(3).tolist(), "omega_B0": [0.0, -0.0011, 0.0]}},
                "supervisor": {
                    "fmu": "supervisor",
                    "every": 5,
                    "start": {
                        "safe_pointing": "sun",
                        "slew_torque_max": 1e-6,
                        "bound_lost": BOUND,
                        "attitude_time": 60.0,
                    },
                },
            },
            "connections": {"add": WIRES},
            "faults": [{"at": FROZEN, "until": UNTIL, "freeze": "sensors.b_B_measured"}],
            "expect": [],
            "figures": [],
            "consistency": {},
            "record": {
                "interval": 10.0,
                "signals": [
                    *("supervisor.mode", "supervisor.safe_reason", "plant.omega_B", "judge.attitude_error"),
                    *("estimate_judge.attitude_error", "estimator.attitude_bound"),
                ],
            },
        }
    )
    return {"time": result.time, **{name: result[name] for name in result}}


def test_it_is_safe_once_the_bound_is_too_large_for_a_time_and_back_when_the_field_is(flown: dict[str, Any]) -> None:
    time, reason, bound = flown["time"], flown["supervisor.safe_reason"], flown["estimator.attitude_bound"]
    lost = time[(bound > BOUND) & (time > FROZEN)][0]
    safe = time[(reason == 4) & (time > FROZEN)]
    assert safe[0] == pytest.approx(lost + 60.0, abs=10.0)
    assert ((safe >= safe[0]) & (safe <= UNTIL + 300.0)).all()
    assert flown["supervisor.mode"][-1] == 3
    assert reason[-1] == 0


def test_rates_are_damped_while_it_is_safe_and_the_attitude_is_held_again_at_the_end(flown: dict[str, Any]) -> None:
    safe = flown["supervisor.safe_reason"] == 4
    assert safe.sum() > 20
    assert np.degrees(np.linalg.norm(flown["plant.omega_B"], axis=1)[safe]).max() < 0.5
    assert np.degrees(flown["judge.attitude_error"][-1]) < 10.0


def test_the_error_of_the_estimate_stays_below_its_bound(flown: dict[str, Any]) -> None:
    late = flown["time"] > 60.0
    assert (flown["estimate_judge.attitude_error"] < flown["estimator.attitude_bound"])[late].all()
