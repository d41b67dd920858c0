"""How one mode gives way to another: by state, by command, by eclipse, and back where the satellite is lost.

Shows SV-1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import supervisor
from supervisor.ports import ACQUIRE, INERTIAL, NADIR, SAFE, SLEW, SUN, TARGET
from tests.blocks import inputs, parameters

H = 1.0
TIMES = {"rate_time": 5.0, "settled_time": 4.0, "angle_time": 3.0, "attitude_time": 6.0, "ahead_horizon": 0.0}
GIVEN = {
    "target_latitude": 0.1,
    "target_longitude": 0.5,
    "target_height": 0.0,
    "sunlight": 1.0,
    "R_goal": Rotation.from_rotvec([0.4, -0.2, 0.3]).as_matrix(),
    "sun_N": [0.0, 0.6, -0.8],
}


class Flight:
    """A satellite that is where it should be, unless a test says otherwise."""

    def __init__(self, **changes: Any) -> None:
        self.p = parameters("supervisor", **{**TIMES, **changes})
        supervisor.check(self.p)
        self.u = inputs("supervisor", **GIVEN)
        self.x = supervisor.start(self.p, self.u)
        self.y = supervisor.outputs(self.x, self.u, self.p)

    def fly(self, steps: int = 1, on: bool = True, **changes: Any) -> int:
        """The mode after so many steps; `on`: the satellite follows the reference."""
        for _ in range(steps):
            u = replace(self.u, **changes)
            if on and self.y.R_ref.any() and "R_NB" not in changes:
                u = replace(u, R_NB=self.y.R_ref, omega_B=self.y.Omega_ref)
            self.x, self.y = supervisor.step(self.x, u, self.p, H)
        return self.y.mode

    def until(self, mode: int, limit: int = 5000, **changes: Any) -> int:
        """How many steps it takes to get there."""
        return next(n for n in range(1, limit) if self.fly(**changes) == mode)

    def pointing(self, command: int = 0) -> Flight:
        self.until({0: NADIR}.get(command, command), command=command)
        return self


def test_from_separation_to_nadir_by_rate_attitude_and_errors() -> None:
    flight = Flight()
    assert flight.y.mode == SAFE
    assert not flight.y.R_ref.any()
    assert flight.fly(20, omega_B=np.array([0.1, 0.0, 0.0]), on=False) == SAFE
    assert flight.fly(4) == SAFE
    assert flight.fly(1) == ACQUIRE
    assert flight.until(NADIR) == 4
    np.testing.assert_array_equal(flight.y.R_ref, supervisor.reference.lvlh(flight.u.r_N, flight.u.v_N).R_ref)


@pytest.mark.parametrize("unknown", [{"attitude_valid": False}, {"R_NB": np.zeros((3, 3))}])
def test_without_attitude_it_stays_safe_goes_on_for_a_time_and_then_is_safe_again(unknown: dict[str, Any]) -> None:
    flight = Flight()
    assert flight.fly(20, **unknown) == SAFE
    assert flight.fly(1) == ACQUIRE
    flight.pointing()
    assert flight.fly(5, **unknown) == NADIR
    assert flight.fly(1) == NADIR
    assert flight.fly(5, **unknown) == NADIR
    assert flight.fly(1, **unknown) == SAFE


@pytest.mark.parametrize("bound_lost", [0.5, np.pi])
def test_an_attitude_whose_bound_is_too_large_is_not_known_and_comes_back_by_itself(bound_lost: float) -> None:
    flight = Flight(bound_lost=bound_lost).pointing()
    assert flight.fly(6, attitude_bound=0.49) == NADIR
    assert flight.fly(5, attitude_bound=0.51) == NADIR
    assert flight.fly(1, attitude_bound=0.51) == (SAFE if bound_lost == 0.5 else NADIR)
    assert flight.y.safe_reason == (4 if bound_lost == 0.5 else 0)
    assert flight.until(NADIR) < 20
    assert flight.y.safe_reason == 0


def test_it_says_why_it_is_safe() -> None:
    flight = Flight()
    assert flight.y.safe_reason == 1
    flight.pointing()
    assert flight.y.safe_reason == 0
    flight.fly(1, command=SAFE)
    assert flight.y.safe_reason == 2
    flight.pointing()
    flight.until(SAFE, omega_B=np.array([0.06, 0.0, 0.0]), on=False, R_NB=flight.y.R_ref)
    assert flight.y.safe_reason == 3
    flight.pointing()
    flight.until(SAFE, attitude_valid=False)
    assert flight.y.safe_reason == 4


def test_a_rate_too_large_for_a_time_is_safe_mode_and_a_short_one_is_not() -> None:
    flight = Flight().pointing()
    fast = {"omega_B": np.array([0.06, 0.0, 0.0]), "on": False, "R_NB": flight.y.R_ref}
    assert flight.fly(4, **fast) == NADIR
    flight.fly(1)
    assert flight.fly(4, **fast) == NADIR
    assert flight.fly(1, **fast) == SAFE


def test_an_attitude_too_far_off_for_a_time_is_acquired_again() -> None:
    flight = Flight().pointing()
    off = {"R_NB": flight.y.R_ref @ Rotation.from_rotvec([0.4, 0.0, 0.0]).as_matrix()}
    assert flight.fly(2, **off) == NADIR
    assert flight.fly(1, **off) == ACQUIRE
    assert flight.y.destination == NADIR
    assert flight.until(NADIR) == 4


@pytest.mark.parametrize("command", [INERTIAL, TARGET, SUN])
def test_a_command_slews_from_the_present_reference_and_arrives(command: int) -> None:
    flight = Flight(slew_rate_max=0.02).pointing()
    before = flight.y
    assert flight.fly(1, command=command) == SLEW
    assert flight.y.destination == command
    np.testing.assert_allclose(flight.y.R_ref, before.R_ref, atol=1e-4)
    remaining = flight.y.slew_remaining
    largest, changes = 0.0, 0.0
    while flight.y.mode == SLEW:
        last = flight.y
        flight.fly(command=command)
        largest = max(largest, float(np.linalg.norm(flight.y.Omega_ref - last.Omega_ref)))
        changes += 1
    assert flight.y.mode == command
    assert changes == pytest.approx(remaining, abs=2.0)
    assert largest < 1e-4
    if command == INERTIAL:
        np.testing.assert_array_equal(flight.y.R_ref, GIVEN["R_goal"])
    if command == SUN:
        np.testing.assert_allclose(flight.y.R_ref @ flight.p.sun_axis_B, GIVEN["sun_N"], atol=1e-12)


def test_another_set_point_of_the_present_mode_is_another_slew_also_during_one() -> None:
    flight = Flight(slew_rate_max=0.02).pointing()
    flight.until(INERTIAL, command=INERTIAL)
    goals = [Rotation.from_rotvec(v).as_matrix() for v in ([0.9, 0.1, 0.3], [-0.5, 0.2, 0.0])]
    assert flight.fly(1, command=INERTIAL, R_goal=goals[0]) == SLEW
    flight.fly(50, command=INERTIAL, R_goal=goals[0])
    during = flight.y
    flight.fly(1, command=INERTIAL, R_goal=goals[1])
    np.testing.assert_allclose(flight.y.Omega_ref, during.Omega_ref, atol=2e-4)
    flight.until(INERTIAL, command=INERTIAL, R_goal=goals[1])
    np.testing.assert_array_equal(flight.y.R_ref, goals[1])


def test_in_eclipse_the_sun_gives_way_to_nadir_and_comes_back_with_the_light() -> None:
    flight = Flight(slew_rate_max=0.1, slew_torque_max=0.01).pointing()
    flight.until(SUN, command=SUN)
    assert flight.fly(1, command=SUN, sunlight=0.4) == SLEW
    assert flight.y.destination == NADIR
    flight.until(NADIR, command=SUN, sunlight=0.0)
    flight.until(SUN, command=SUN, sunlight=0.6)


def test_safe_by_command_is_at_once_and_recovery_goes_by_acquisition() -> None:
    flight = Flight().pointing()
    assert flight.fly(1, command=SAFE) == SAFE
    assert not flight.y.R_ref.any()
    assert flight.fly(10, command=SAFE) == SAFE
    assert flight.fly(1) == ACQUIRE


def test_times_of_zero_begin_in_acquisition_or_in_the_mode_itself() -> None:
    still: Callable[[np.ndarray], dict[str, Any]] = lambda R: {"R_NB": R, "omega_B": np.zeros(3)}  # noqa: E731
    p = parameters("supervisor", **{**TIMES, "rate_time": 0.0, "settled_time": 0.0, "first_mode": "inertial"})
    for turn, mode in ((0.0, INERTIAL), (0.5, ACQUIRE)):
        R = GIVEN["R_goal"] @ Rotation.from_rotvec([turn, 0.0, 0.0]).as_matrix()
        u = inputs("supervisor", **{**GIVEN, **still(R)})
        assert supervisor.outputs(supervisor.start(p, u), u, p).mode == mode


@pytest.mark.parametrize(("command", "missing"), [(4, "R_goal"), (6, "target_longitude"), (7, "sun_N")])
def test_a_mode_whose_set_point_is_missing_is_refused_by_its_name(command: int, missing: str) -> None:
    flight = Flight().pointing()
    absent = np.full_like(np.asarray(getattr(flight.u, missing), float), 1e9)
    with pytest.raises(ValueError, match=f"^{missing}: expected a value, since the mode"):
        flight.fly(command=command, **{missing: absent if absent.shape else float(absent)})
