"""What the supervisor remembers, reached twice in both flavours: modes, slews, times, and the field in the mode safe.

The witnesses are a fresh instance that gets there for the first time, counts of steps and numeric derivatives.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supervisor.ports import ACQUIRE, INERTIAL, NADIR, SAFE, SLEW, SUN, TARGET
from supervisor.reference import EARTH_RATE
from tests.blocks import inputs, parameters
from tests.supervisor.test_modes import GIVEN, TIMES

from .twice import FLAVOURS, Step

pytestmark = pytest.mark.parametrize("flavour", FLAVOURS)
H = 1.0
QUICK = {"slew_rate_max": 0.1, "slew_torque_max": 0.1, "rate_lost": 0.2}
"""Slews that end within a visit, and at whose rate nothing is lost."""
ZEROS = np.zeros((3, 3))


def turned(*rotvec: float) -> Any:
    return Rotation.from_rotvec(rotvec).as_matrix()


class Flight:
    """A satellite that is where it should be, unless its inputs say otherwise."""

    def __init__(self, step: Step, u: Any) -> None:
        self._step, self.u = step, u
        self.y = step(u)

    def fly(self, steps: int = 1, **changes: Any) -> int:
        """The mode after so many steps."""
        for _ in range(steps):
            u = self.u
            if np.any(self.y["R_ref"]):
                u = replace(u, R_NB=self.y["R_ref"], omega_B=self.y["Omega_ref"])
            self.y = self._step(replace(u, **changes))
        return int(self.y["mode"])

    def to(self, mode: int, **changes: Any) -> int:
        """How many steps it takes to get there."""
        return next(n for n in range(1, 5000) if self.fly(**changes) == mode)

    def visit(self, steps: int, **changes: Any) -> list[Any]:
        """Mode and reference of each of so many steps."""
        return [(self.fly(**changes), self.y["R_ref"].copy(), self.y["Omega_ref"].copy()) for _ in range(steps)]


FAST, BLIND, OFF = {"omega_B": np.array([0.5, 0.0, 0.0])}, {"R_NB": ZEROS}, {"R_NB": turned(2.0, 1.0, 0.5)}
TIMERS: dict[str, tuple[int, dict[str, Any], int, int]] = {
    "fast": (NADIR, FAST, 5, SAFE),
    "blind": (NADIR, BLIND, 6, SAFE),
    "off": (NADIR, OFF, 3, ACQUIRE),
    "calm": (SAFE, {}, 5, ACQUIRE),
    "settled": (ACQUIRE, {}, 4, NADIR),
}
"""From a mode, under these inputs, after so many steps without a break, to another mode; TIMES has them."""
BREAK = {"calm": FAST, "settled": OFF}
"""What breaks it; else a step in which all is well."""


@pytest.mark.parametrize("name", TIMERS)
def test_a_time_that_must_pass_begins_anew_after_each_break(flavour, name):
    mode, cause, steps, to = TIMERS[name]
    p = parameters("supervisor", **TIMES)
    with flavour("supervisor", p, inputs("supervisor", **GIVEN), H) as step:
        flight = Flight(step, inputs("supervisor", **GIVEN))
        for _ in range(2):
            flight.to(NADIR)
            if mode == SAFE:
                flight.fly(command=SAFE, **FAST)
            elif mode == ACQUIRE:
                flight.to(ACQUIRE, **OFF)
            for _ in range(3):
                assert flight.fly(**BREAK.get(name, {})) == mode
                assert flight.fly(steps - 1, **cause) == mode
            assert flight.fly(1, **cause) == to


def test_a_time_that_had_passed_counts_for_nothing_the_next_time(flavour):
    """Without a step between that would break it: 3 s off end a mode, 4 s settled end the acquisition."""
    with flavour("supervisor", parameters("supervisor", **TIMES), inputs("supervisor", **GIVEN), H) as step:
        flight = Flight(step, inputs("supervisor", **GIVEN))
        flight.to(NADIR)
        for _ in range(2):
            assert (flight.fly(2, **OFF), flight.fly(1, **OFF)) == (NADIR, ACQUIRE)
            assert (flight.fly(3), flight.fly(1)) == (ACQUIRE, NADIR)
            flight.to(ACQUIRE, **OFF)
            flight.fly(3)
            there = {
                "command": INERTIAL,
                "R_goal": flight.y["R_ref"],
                "R_NB": flight.y["R_ref"],
                "omega_B": np.zeros(3),
            }
            assert (flight.fly(3, **there), flight.fly(1, **there)) == (ACQUIRE, INERTIAL)
            assert (flight.fly(2, **{**there, **OFF}), flight.fly(2, **OFF), flight.fly(1, **OFF)) == (
                INERTIAL,
                SLEW,
                ACQUIRE,
            )
            flight.to(NADIR)


def test_the_sun_is_turned_to_the_shortest_way_each_time_that_the_mode_safe_is_left(flavour):
    """About the axis across that of the body and the Sun: the turn is the angle between them, at last half a turn."""
    p = parameters("supervisor", **TIMES, sun_axis_B=[0.6, 0.0, 0.8])
    u = replace(inputs("supervisor", **GIVEN), command=SUN)
    opposite = Rotation.align_vectors([-np.array(u.sun_N)], [p.sun_axis_B])[0].as_matrix()
    with flavour("supervisor", p, replace(u, command=SAFE), H) as step:
        for R in (turned(0.4, -1.2, 0.3), turned(-1.0, 0.2, 2.0), turned(0.1, 2.0, -0.7), opposite):
            for _ in range(7):
                step(replace(u, command=SAFE, R_NB=R))
            y = step(replace(u, R_NB=R))
            assert y["mode"] == ACQUIRE
            away = np.arccos(max(R @ p.sun_axis_B @ u.sun_N, -1.0))
            assert Rotation.from_matrix(R.T @ y["R_ref"]).magnitude() == pytest.approx(away, abs=1e-7)
            np.testing.assert_allclose(y["R_ref"] @ p.sun_axis_B, u.sun_N, atol=1e-9)


def test_a_slew_that_is_left_for_the_sun_ends_the_shortest_way_from_where_it_was(flavour):
    """A twin that goes on shows where."""
    p = parameters("supervisor", **TIMES, **QUICK, sun_axis_B=[0.6, 0.0, 0.8])
    u, to = inputs("supervisor", **GIVEN), {"command": INERTIAL, "R_goal": turned(-1.2, 0.7, 2.0)}
    for steps in (4, 12):
        with flavour("supervisor", p, u, H) as step, flavour("supervisor", p, u, H) as other:
            flight, twin = Flight(step, u), Flight(other, u)
            for one in (flight, twin):
                one.to(NADIR)
                assert one.fly(steps, **to) == SLEW
            twin.fly(**to)
            flight.to(SUN, command=SUN)
            there = twin.y["R_ref"]
            away = np.arccos(there @ p.sun_axis_B @ u.sun_N)
            assert Rotation.from_matrix(there.T @ flight.y["R_ref"]).magnitude() == pytest.approx(away, abs=1e-9)


def test_each_mode_is_come_to_and_left_the_second_time_as_the_first(flavour):
    """Position, Sun and light stay: nothing but what is remembered could make a difference."""
    p, u = parameters("supervisor", **TIMES, **QUICK, sun_axis_B=[0.6, 0.0, 0.8]), inputs("supervisor", **GIVEN)
    goals = (turned(0.4, -0.2, 0.3), turned(-1.2, 0.7, 2.0))
    with flavour("supervisor", p, u, H) as step:
        flight = Flight(step, u)
        flight.to(NADIR)
        rounds = []
        for _ in range(3):
            seen = flight.visit(120, command=INERTIAL, R_goal=goals[0])
            seen += flight.visit(120, command=INERTIAL, R_goal=goals[1])
            seen += flight.visit(30, command=SUN)  # left during the slew
            seen += flight.visit(120, command=SUN, sunlight=0.0)
            seen += flight.visit(120, command=SUN)
            seen += flight.visit(9, command=SAFE)
            seen += flight.visit(20, command=NADIR)
            rounds.append([np.array(column) for column in zip(*seen, strict=True)])
    assert set(rounds[0][0]) == {SAFE, ACQUIRE, SLEW, NADIR, INERTIAL, SUN}
    for later in rounds[1:]:
        for one, first in zip(later, rounds[0], strict=True):
            np.testing.assert_allclose(one, first, atol=1e-9)


def test_slews_in_a_row_last_as_long_there_and_back_each_time(flavour):
    """Between two inertial attitudes, with no other mode between: each begins when it is asked for."""
    p, u = parameters("supervisor", **TIMES, **QUICK), inputs("supervisor", **GIVEN)
    goals = (turned(0.4, -0.2, 0.3), turned(-1.2, 0.7, 2.0))
    with flavour("supervisor", p, u, H) as step:
        flight = Flight(step, u)
        flight.to(NADIR)
        flight.visit(120, command=INERTIAL, R_goal=goals[0])
        visits = [flight.visit(120, command=INERTIAL, R_goal=goals[k % 2]) for k in range(1, 6)]
    lasted = [sum(row[0] == SLEW for row in visit) for visit in visits]
    assert 5 < lasted[0] < 115
    assert max(lasted) - min(lasted) <= 1
    assert {row[0] for visit in visits for row in visit} == {SLEW, INERTIAL}


def test_rate_and_acceleration_are_those_of_the_attitude_in_each_slew(flavour):
    """To and fro between two inertial attitudes: by central differences of the attitudes, and of the rates."""
    p, u, h = parameters("supervisor", **TIMES, **QUICK), inputs("supervisor", **GIVEN), 0.1
    goals = (turned(0.4, -0.2, 0.3), turned(-1.2, 0.7, 2.0))
    with flavour("supervisor", p, u, h) as step:
        flight = Flight(step, u)
        flight.to(NADIR)
        flight.to(INERTIAL, command=INERTIAL, R_goal=goals[0])
        for k in (1, 0):
            ys = [flight.y for _ in range(600) if flight.fly(command=INERTIAL, R_goal=goals[k]) == SLEW]
            assert len(ys) > 100
            R, omega, slope = (np.array([y[name] for y in ys]) for name in ("R_ref", "Omega_ref", "dOmega_ref"))
            turns = Rotation.from_matrix(R[:-2].transpose(0, 2, 1) @ R[2:]).as_rotvec() / (2.0 * h)
            np.testing.assert_allclose(omega[1:-1], turns, atol=4e-3 * np.abs(turns).max())
            np.testing.assert_allclose(
                slope[1:-1], (omega[2:] - omega[:-2]) / (2.0 * h), atol=2e-2 * np.abs(slope).max()
            )


def test_it_says_why_it_is_safe_each_time(flavour):
    """1 since the start, 2 by command, 3 by the rate, 4 without an attitude, 0 in other modes."""
    p, u = parameters("supervisor", **TIMES, **QUICK), inputs("supervisor", **GIVEN)
    with flavour("supervisor", p, u, H) as step:
        flight = Flight(step, u)
        assert flight.y["safe_reason"] == 1
        for _ in range(2):
            flight.to(NADIR)
            assert flight.y["safe_reason"] == 0
            flight.visit(2, command=SAFE)
            assert flight.y["safe_reason"] == 2
            flight.to(NADIR)
            flight.visit(60, **BLIND)
            assert flight.y["safe_reason"] == 4
            flight.to(NADIR)
            flight.visit(20, **FAST)
            assert flight.y["safe_reason"] == 3


def test_the_calm_is_counted_in_the_mode_safe_by_command_too(flavour):
    """Of a satellite that never turns: it is left at once when the command is taken back."""
    p = parameters("supervisor", **TIMES)
    with flavour("supervisor", p, inputs("supervisor", **GIVEN), H) as step:
        flight = Flight(step, inputs("supervisor", **GIVEN))
        for _ in range(2):
            flight.to(NADIR)
            assert flight.fly(10, command=SAFE) == SAFE
            assert flight.fly() == ACQUIRE


def test_another_point_on_the_ground_is_looked_at_each_time(flavour):
    """The points are given where the Earth's turn brings them to the same place."""
    p, u = parameters("supervisor", **TIMES, **QUICK), inputs("supervisor", **GIVEN)
    rounds = []
    with flavour("supervisor", p, u, H) as step:
        flight = Flight(step, u)
        n = 1 + flight.to(NADIR)
        for _ in range(3):
            seen = []
            for latitude in (0.1, -0.2):
                at = {"target_latitude": latitude, "target_longitude": 0.5 - EARTH_RATE * H * n}
                seen += flight.visit(100, command=TARGET, **at)
                n += 100
            rounds.append(np.array([R for _, R, _ in seen]))
            assert seen[-1][0] == TARGET
    np.testing.assert_allclose(rounds[2], rounds[1], atol=1e-9)
    assert np.linalg.norm(rounds[1][-1] - rounds[1][99]) > 0.2


RATE_N = np.array([0.0, 2e-3, 5e-4])
CALM = {"rate_time": 5.0, "safe_time": 50.0, "safe_pointing": "field", "rate_acquire": 0.5, "rate_lost": 1.0}


def in_field(
    t: float, R: Any, omega_B: Any = (0.0, 0.0, 0.0), rate: Any = RATE_N, about: Any = (0.0, 0.0, 3e-5)
) -> Any:
    """Inputs without an attitude in a field that turns."""
    b_N = Rotation.from_rotvec(t * rate).apply(about)
    return inputs("supervisor", R_NB=ZEROS, attitude_valid=False, b_B=R.T @ b_N, omega_B=np.array(omega_B))


def test_the_rate_of_the_field_turns_with_the_body_each_time(flavour):
    """After a turn by 90 deg in 9 s, a fifth of the filter's time, the field's rate is asked for in the body's axes of
    now, and so after the next turn; what a proportional law asks for is taken off."""
    p = parameters("supervisor", **CALM)
    R, spin = np.eye(3), np.array([0.0, 0.0, np.pi / 18.0])
    with flavour("supervisor", p, in_field(0.0, R), H) as step:
        t = 0.0
        for seconds, rate in ((400, 0.0 * spin), (9, spin), (1, 0.0 * spin), (9, spin), (1, 0.0 * spin)):
            for _ in range(seconds):
                t, R = t + H, R @ Rotation.from_rotvec(H * rate).as_matrix()
                u = in_field(t, R, rate)
                y = step(u)
            b = u.b_B / np.linalg.norm(u.b_B)
            away = np.cross(p.safe_axis_B, b)
            angle = np.arctan2(np.linalg.norm(away), b @ p.safe_axis_B)
            to = away / np.linalg.norm(away) * min(angle / p.safe_time, p.slew_rate_max, 0.5 * p.rate_acquire)
            wanted = R.T @ RATE_N
            across = wanted - (wanted @ b) * b
            assert y["Omega_ref"] - to == pytest.approx(across, abs=0.15 * np.linalg.norm(across))


@pytest.mark.parametrize(("rate_time", "waits"), [(0.0, 0), (5.0, 19)])
def test_rates_are_damped_before_the_axis_is_turned_and_again_where_they_grow_each_time(flavour, rate_time, waits):
    """Below 0.3 rad in safe_time it begins, slow or not before rate_time; once begun it goes on up to rate_acquire."""
    p = parameters("supervisor", **{**CALM, "rate_time": rate_time})
    slow, quick, fast = 0.29 / p.safe_time, 0.31 / p.safe_time, 1.01 * p.rate_acquire
    parts = ((20, quick, False), (1, fast, False), (waits, slow, False), (1, slow, True), (20, quick, True))
    with flavour("supervisor", p, in_field(0.0, np.eye(3), (0.0, 0.0, fast)), 0.25) as step:
        for steps, rate, turns in (*parts, (1, fast, False), *parts):
            for _ in range(steps):
                y = step(in_field(0.0, np.eye(3), (0.0, 0.0, rate)))
                assert bool(np.any(y["Omega_ref"])) == turns, (rate, turns)


def test_the_mode_safe_by_command_points_as_the_one_without_an_attitude(flavour):
    """The command is given at each step; what the field's filter and the calm have come to goes on through it, and so
    does the pointing where the rate grows to what would not let it begin."""
    p, seen = parameters("supervisor", **CALM), []
    for command in (0, SAFE):
        with flavour("supervisor", p, in_field(0.0, np.eye(3)), H) as step:
            spins = [(0.0, 0.0, 0.01 if t > 250 else 0.0) for t in range(300)]
            flown = [step(replace(in_field(H * t, np.eye(3), spins[t]), command=command)) for t in range(1, 300)]
            seen.append(np.array([y["Omega_ref"] for y in flown]))
    np.testing.assert_allclose(seen[1], seen[0], atol=1e-12)
    assert np.linalg.norm(seen[0][-1]) > 1e-3


def test_the_field_is_found_anew_each_time_that_the_mode_safe_is_come_to(flavour):
    """Where it stood and turned in the time before is forgotten: a fresh instance asks for the same."""
    p = parameters("supervisor", **TIMES, **{k: v for k, v in CALM.items() if k not in TIMES})
    lost = inputs("supervisor", **GIVEN, b_B=[0.0, 3e-5, 0.0])

    def visit(fly: Callable[[Any], Any], about: Any) -> Any:
        return [fly(replace(in_field(t, np.eye(3), about=about), command=SAFE))["Omega_ref"].copy() for t in range(40)]

    fields = ([0.0, 0.0, 3e-5], [3e-5, 0.0, 0.0], [0.0, 0.0, 3e-5])
    with flavour("supervisor", p, lost, H) as step:
        flight = Flight(step, lost)
        for about in fields:
            flight.to(NADIR)
            seen = visit(step, about)
            with flavour("supervisor", p, lost, H) as other:
                Flight(other, lost).to(NADIR)
                np.testing.assert_allclose(seen, visit(other, about), atol=1e-12)


@pytest.mark.parametrize(
    "axis", [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, -1.0], [0.0, 1.0, 1.0]]
)
def test_an_axis_that_points_away_from_the_sun_is_turned_over_about_one_across_it(flavour, axis):
    """By pi in safe_time, whichever the axis is."""
    axis = np.array(axis) / np.linalg.norm(axis)
    p = parameters("supervisor", safe_pointing="sun", sun_axis_B=axis, safe_time=2e3, rate_time=2.0)
    u = inputs("supervisor", sun_B=-axis, attitude_valid=False, command=SAFE)
    with flavour("supervisor", p, u, H) as step:
        rate = [step(u)["Omega_ref"] for _ in range(10)][-1]
    assert rate @ axis == pytest.approx(0.0, abs=1e-12)
    assert np.linalg.norm(rate) == pytest.approx(np.pi / 2e3)
