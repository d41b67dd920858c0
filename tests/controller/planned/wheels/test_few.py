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
    """`left` of those built works from the begin on, the others stand; with the commands of the rods connected, and
    without."""
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

        works = [float(not one) for one in failed]
        fly(60.0, each, body, {**TUMBLE, "wheel_gain": works}, LAWS, failed=lambda i: failed, rods=rods)


def test_a_plan_begins_at_each_failure_that_leaves_one_wheel_and_the_set_goes_on_where_it_works_again() -> None:
    """Wheels 1 and 2 fail from 40 s to 80 s, and again from 120 s on."""
    body: dict[str, Any] = {**FOUR, **SETS[3]}
    fails = [(40.0 <= i * H < 80.0 or i * H >= 120.0) for i in range(4000)]
    reduced, error = [], []

    def each(i: int, seen: Any, y: Any, _: Instance) -> None:
        reduced.append(bool(y["reduced"]))
        error.append(float(y["attitude_error"]))
        if reduced[-1]:
            assert not y["wheel_torque_ff"][:2].any()

    fly(2000.0, each, body, STILL, {}, failed=lambda i: [fails[i], fails[i], False, False])
    assert reduced == fails
    assert max(error[-100:]) < np.radians(3.0)


@pytest.mark.parametrize("along", [1, 2])
def test_of_two_wheels_left_the_one_along_which_the_field_lies_is_planned_and_the_other_comes_to_rest(
    along: int,
) -> None:
    """The wheels' axes are the body's; the other's momentum is taken away by what the rods give at 30 uT, or at once as
    far as the body has the opposite."""
    field = 3e-5 * np.eye(3)[along]
    other = 3 - along
    with Instance("controller_planned_wheels") as law:
        for name, value in {**FOUR, **SETS[3], "reference": "inertial", "b_B": field}.items():
            law.set(name, value)
        law.initialize()
        for i in range(100):
            law.step(i * H, H)
        momentum = np.zeros(4)
        momentum[other] = 0.01
        law.set("h_w", momentum)
        law.set("wheel_failed", [True, False, False, False])
        law.step(100 * H, H)
        slow = law.get("wheel_torque_ff")[other]
        rate = np.linalg.solve(FOUR["J_B"], -momentum[:3])
        law.set("omega_B", rate)
        law.step(101 * H, H)
        fast = law.get("wheel_torque_ff")[other]
        law.set("h_w", [0.0, *np.where(np.arange(1, 4) == along, 0.01, 0.0)])
        law.step(102 * H, H)
        assert law.get("wheel_torque_ff")[other] == pytest.approx(0.0, abs=1e-12)
        dipole = law.get("dipole_max")
    assert slow == pytest.approx(-0.3 * 3e-5 * dipole, rel=1e-9)
    assert fast == pytest.approx(-0.01 / (10.0 * H), rel=1e-9)
