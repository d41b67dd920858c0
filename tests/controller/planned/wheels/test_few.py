"""One wheel that works, or none: the plan of controller_planned for it, from the begin or from a failure on."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.native.driver import Instance

from .loop import FOUR, MEASURED, SETS, STILL, H, fly

COMMANDS = (
    "tau_cmd_B",
    "dipole_ff",
    "R_d",
    "Omega_d",
    "dOmega_d",
    "disturbance_B",
    "phase",
    "attitude_error",
    "rod_gains_estimate",
)
TUMBLE = {**STILL, "omega_B0": [0.004, -0.006, 0.005], "gravity_gradient": True}
LAWS = {"bandwidth": 0.2}


@pytest.mark.parametrize("rods", [False, True])
@pytest.mark.parametrize(("left", "built"), [(1, 1), (2, 3), (None, 3), (None, 0)])
def test_with_one_wheel_or_none_it_is_controller_planned_bit_by_bit(left: int | None, built: int, rods: bool) -> None:
    """`left` of those built works from the begin on; with the commands of the rods connected, and without."""
    asked = 0.0
    body: dict[str, Any] = {**FOUR, **SETS[3], "wheels": built}
    failed = [i != (left or 0) - 1 for i in range(4)]
    with Instance("controller_planned") as one:
        for name in ("J_B", "rod_axes", "rod_limits", "dipole_max"):
            if name in body:
                one.set(name, body[name])
        axis = body["wheel_axis"][left - 1] if left else [1.0, 0.0, 0.0]
        one.set("wheel_axis", axis)
        one.set("control_period", H)
        for name in ("wheel_torque_max", "wheel_momentum_max") if left is None else ():
            one.set(name, 1e-9)

        def each(i: int, seen: Any, y: Any, plant: Instance) -> None:
            nonlocal asked
            if rods:
                one.set("u_applied", [*plant.get("dipole_cmd"), asked])
            for name in MEASURED:
                one.set(name, (seen[name][left - 1] if left else 0.0) if name == "h_w" else seen[name])
            one.initialize() if i == 0 else one.step((i - 1) * H, H)
            its = one.outputs()
            for name in COMMANDS:
                np.testing.assert_array_equal(y[name], its[name], err_msg=f"{name} at sample {i}")
            wheels = np.zeros(4)
            if left:
                wheels[left - 1] = its["wheel_torque_ff"]
            np.testing.assert_array_equal(y["wheel_torque_ff"], wheels)
            assert y["reduced"]
            asked = its["wheel_torque_ff"]

        fly(60.0, each, body, TUMBLE, LAWS, failed=lambda i: failed, rods=rods)


def test_a_plan_begins_at_each_failure_that_leaves_one_wheel_and_the_set_goes_on_where_it_works_again() -> None:
    """Wheels 1 and 2 fail from 40 s to 80 s, and again from 120 s on."""
    body: dict[str, Any] = {**FOUR, **SETS[3]}
    fails = [(40.0 <= i * H < 80.0 or i * H >= 120.0) for i in range(1000)]
    reduced, error = [], []

    def each(i: int, seen: Any, y: Any, _: Instance) -> None:
        reduced.append(bool(y["reduced"]))
        error.append(float(y["attitude_error"]))
        if reduced[-1]:
            assert not y["wheel_torque_ff"][:2].any()

    fly(500.0, each, body, STILL, {}, failed=lambda i: [fails[i], fails[i], False, False])
    assert reduced == fails
    assert max(error[-100:]) < np.radians(3.0)
