"""What the planned controller of a set of wheels decides: tumbles that the wheels hold and those that they do not,
targets that jump, wheels that fail, and momentum in the hold."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from evidence.wheels.bound import least_time, of_plant
from tests.native.driver import Instance, running
from tests.plant.motion import FULL_INERTIA

from .loop import FOUR, MOMENTUM, SETS, STILL, TORQUE, H, fly, reach

TUMBLE = np.array([0.4, -0.5, 0.6]) / np.linalg.norm([0.4, -0.5, 0.6])
SHED, TURN, HOLD, DAMP = 1, 2, 3, 4


class Seen:
    """Errors in deg, phases and momenta of a flight."""

    def __init__(self, wanted: Any = None, dead: tuple[int, int] | None = None) -> None:
        self.error: list[float] = []
        self.phase: list[int] = []
        self.h_w: list[np.ndarray] = []
        self.momentum: list[float] = []
        self.reduced: list[bool] = []
        self.wanted, self.dead = wanted, dead

    def __call__(self, i: int, seen: dict[str, Any], y: dict[str, Any], it: Instance) -> None:
        self.error.append(np.degrees(y["attitude_error"]))
        self.phase.append(int(y["phase"]))
        self.h_w.append(seen["h_w"])
        self.momentum.append(float(np.linalg.norm(it.get("H_N"))))
        self.reduced.append(bool(y["reduced"]))
        if self.dead is not None and i == self.dead[0]:
            gains = np.ones(4)
            gains[self.dead[1]] = 0.0
            it.set("wheel_gain", gains)

    @property
    def phases(self) -> list[int]:
        return [p for i, p in enumerate(self.phase) if i == 0 or p != self.phase[i - 1]]


def tumbling(momentum: float) -> dict[str, Any]:
    rate = momentum * TUMBLE / np.linalg.norm(FULL_INERTIA @ TUMBLE)
    return {**STILL, "omega_B0": rate, "q_NB0": [0.5, 0.5, 0.5, 0.5]}


def test_a_tumble_that_the_wheels_hold_is_stopped_by_them_at_once_and_one_that_they_do_not_is_shed_first() -> None:
    small, large = Seen(), Seen()
    fly(800.0, small, SETS[3], tumbling(0.8 * MOMENTUM), {})
    fly(1300.0, large, SETS[3], tumbling(4.0 * MOMENTUM), {})
    assert small.phases == [DAMP, TURN, HOLD]
    assert small.phase.index(TURN) * H < 0.8 * MOMENTUM / 1.5e-3  # the torque of the wheels
    assert large.phases == [SHED, DAMP, TURN, HOLD]
    shed = large.phase.index(DAMP)
    assert large.momentum[shed] < np.sqrt(3.0) * MOMENTUM  # the most that three wheels at right angles bear
    assert shed * H < 4.0 * (4.0 - 0.5) * MOMENTUM / (25.0 * 3e-5)  # rods across a usual field
    assert max(small.error[-20:] + large.error[-20:]) < 0.01


def test_a_tumble_goes_on_the_way_that_it_turns_where_that_is_sooner_over() -> None:
    """About a principal axis the peak p of the rate v over the angle is p^2 = a angle + v^2/2, the time (2 p - v)/a."""
    axes, wheels = np.linalg.eigh(FULL_INERTIA)[1].T, SETS[3]["wheel_axis"][:3]
    axis = axes[0]
    along = FULL_INERTIA @ axis
    a, most = (reach(wheels, np.full(3, limit), along) for limit in (0.9 * TORQUE, 0.95 * MOMENTUM))
    rate, angle = 0.5 * most, np.radians(205.0)
    peak = np.sqrt(a * angle + 0.5 * rate**2)
    peak = min(peak, most + rate)  # what the body has needs no momentum of the wheels
    least = (2.0 * peak - rate) / a + (angle - (peak**2 - 0.5 * rate**2) / a) / peak
    seen = Seen()
    q = np.roll(Rotation.from_rotvec(-angle * axis).as_quat(), 1)
    body = {**SETS[3], "dipole_max": 1e-2}  # rods that shed next to nothing
    fly(2.0 * least, seen, body, {**STILL, "q_NB0": q, "omega_B0": rate * axis}, {"reference": "inertial"})
    assert max(seen.error) > 179.0
    settled = H * (np.flatnonzero(np.array(seen.error) > 0.5)[-1] + 1)
    assert 0.9 * least < settled < 1.1 * least + 2.0 * H


def test_each_target_that_jumps_is_turned_to_and_held_as_the_first() -> None:
    targets = [Rotation.from_rotvec(a).as_matrix() for a in ([0.0, 0.0, 0.0], [0.6, -0.3, 0.5], [-0.4, 0.2, 0.8])]
    push = {**STILL, "q_NB0": [1.0, 0.0, 0.0, 0.0], "disturbance_torque_B": [2e-5, -1e-5, 3e-5]}
    seen = Seen()
    fly(800.0, seen, FOUR, push, {}, lambda i: targets[(int(i * H) // 200) % 3])
    jumps = [400, 800, 1200]
    assert seen.phases == [TURN, HOLD] * 4
    for jump in jumps:
        assert seen.error[jump] > 30.0
        assert max(seen.error[jump + 300 : jump + 390]) < 1e-3  # the disturbance is countered each time


@pytest.mark.parametrize(("wheels", "limit"), [(4, 0.05), (3, 6.0)])
def test_a_wheel_that_dies_is_flown_without_by_three_others_or_by_two_and_the_rods(wheels: int, limit: float) -> None:
    seen = Seen(dead=(400, 1))
    push = {**STILL, "q_NB0": [1.0, 0.0, 0.0, 0.0], "disturbance_torque_B": [2e-6, -2e-6, 2e-6]}
    fly(2500.0, seen, SETS[wheels], push, {"reference": "inertial"})
    assert max(seen.error[100:]) < limit
    assert seen.reduced[-1] == (wheels == 3)
    assert not any(seen.reduced[:400])


def test_in_the_hold_the_rods_bring_the_wheels_to_their_targets() -> None:
    target = [4e-3, -4e-3, 4e-3, -4e-3]  # along the torques that cancel, and across
    target[0] += 5e-3
    seen = Seen()
    start = {**STILL, "q_NB0": [1.0, 0.0, 0.0, 0.0], "h_w0": [-5e-3, 5e-3, 0.0, 5e-3]}
    fly(4000.0, seen, FOUR, start, {"wheel_momentum_target": target, "reference": "inertial"})
    assert seen.h_w[-1] == pytest.approx(target, abs=5e-4)
    assert max(seen.error[100:]) < 0.01


def test_without_an_attitude_or_a_reference_the_wheels_damp_the_rate() -> None:
    Omega, goal = np.array([2e-3, -1e-3, 1e-3]), np.array([1e-3, 0.0, -1e-3])
    with running("controller_planned_wheels", **FOUR, R_NB=np.zeros((3, 3)), omega_B=Omega, b_B=[0.0] * 3) as it:
        y = it.outputs()
    expected = -FULL_INERTIA @ Omega / (2.0 * H) + np.cross(Omega, FULL_INERTIA @ Omega)
    assert y["tau_cmd_B"] == pytest.approx(0.9 * expected, rel=0.3)
    assert (y["phase"], y["attitude_error"]) == (DAMP, pytest.approx(np.pi))
    given = {"R_ref": np.zeros((3, 3)), "Omega_ref": goal, "dOmega_ref": np.zeros(3)}
    with running("controller_planned_wheels", **FOUR, **given, omega_B=goal, b_B=[0.0] * 3) as it:
        y = it.outputs()
    assert y["tau_cmd_B"] == pytest.approx(np.cross(goal, FULL_INERTIA @ goal), rel=1e-9)
    assert y["rate_error_B"] == pytest.approx(np.zeros(3), abs=1e-15)


def test_momentum_along_the_field_is_shed_in_less_than_five_times_the_proven_least_time() -> None:
    """Dipoles across it leave it where it is. The bound has rods at the best attitude, the controller in a tumble."""
    with running("plant_wheels", **FOUR, **STILL, q_NB0=[0.5, 0.5, 0.5, 0.5]) as it:
        b = it.get("b_B")
    rate = np.linalg.solve(FULL_INERTIA, 3.0 * MOMENTUM * b / np.linalg.norm(b))
    start = {**tumbling(1.0), "omega_B0": rate}
    seen = Seen()
    fly(1500.0, seen, FOUR, start, {})
    least = least_time(of_plant(FOUR, start))
    assert least is not None
    assert 50.0 < least < seen.phase.index(DAMP) * H < 5.0 * least
    assert (seen.phases[0], seen.phases[-3:]) == (SHED, [DAMP, TURN, HOLD])


def test_a_turn_with_one_of_three_wheels_stuck_at_two_thirds_of_its_momentum_ends_within_ten_minutes() -> None:
    """All momentum together is zero: the body turns by what the stuck wheel has, which the rods have to give it."""
    seen = Seen()
    rate = np.linalg.solve(FULL_INERTIA, [0.0, 0.0, -0.02])
    start = {**STILL, "q_NB0": [0.5, 0.5, 0.5, 0.5], "h_w0": [0.0, 0.0, 0.02, 0.0], "omega_B0": rate}
    fly(900.0, seen, SETS[3], {**start, "wheel_gain": [1.0, 1.0, 0.0, 1.0]}, {"reference": "inertial"})
    assert max(seen.error[1200:]) < 15.0
    assert max(seen.error[1700:]) < 1.0
