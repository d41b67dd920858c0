"""What the estimator remembers of its sensors, reached twice in both flavours: the second time is as the first.

The flight is that of tests/estimator/test_health.py: a body that turns, sound sensors with noise, and what is spoilt
here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimator.health import FROZEN, GOOD, INCONSISTENT
from plant.orbit import from_position_velocity
from tests.estimator.test_estimator import MU, R_N, V_N
from tests.estimator.test_health import STEP, measured, sensors

from .twice import FLAVOURS

pytestmark = pytest.mark.parametrize("flavour", FLAVOURS)
OFF = np.array((5e4, 0.0, 0.0))


def flown(flavour: Any, spoil: Callable[[int, Any], Any], steps: int) -> tuple[list[dict[str, Any]], list[float]]:
    """Outputs of each step, and how far the attitude is off, deg."""
    us = measured(False)
    ys, off = [], []
    with flavour("estimator", sensors(), us[0][2], STEP) as step:
        for k in range(1, steps):
            R, _, u = us[k]
            ys.append(step(spoil(k, u)))
            off.append(float(np.degrees(Rotation.from_matrix(ys[-1]["R_NB"].T @ R).magnitude())))
    return ys, off


def within(flags: list[bool], first: int, last: int) -> list[int]:
    return [i for i in range(first, last) if flags[i]]


@pytest.mark.parametrize(("sensor", "name"), [(0, "omega_B_measured"), (1, "b_B_measured"), (4, "sun_B_measured")])
def test_a_sensor_that_freezes_is_named_after_as_many_measurements_each_time(flavour, sensor, name):
    """After 20 that repeat the last one, and good again at the 20th that does not; 15 that repeat are no failure."""
    begins = (60, 130, 200)

    def spoil(k: int, u: Any) -> Any:
        since = max((begin for begin in (*begins, 260) if begin <= k), default=0)
        until = since + (15 if since == 260 else 35)
        return replace(u, **{name: getattr(measured(False)[since][2], name)}) if 0 < since <= k < until else u

    ys, _ = flown(flavour, spoil, 300)
    frozen = [y["health"][sensor] == FROZEN for y in ys]
    for begin in begins:
        there = within(frozen, begin - 1, begin + 69)
        # Step k is row k - 1; the one at `begin` is new, the 20th that repeats it is begin + 20.
        assert (there[0] + 1, there[-1] + 1) == (begin + 20, begin + 35 + 18)
        assert len(there) == there[-1] - there[0] + 1
    assert not within(frozen, 262, 299)


def test_rejections_of_a_frozen_sensor_count_for_nothing_once_it_is_back_each_time(flavour):
    """It freezes beyond the gate for 40 measurements and comes back wrong for 25, of which 20 end the freeze: fewer
    than 50 in a row, at which it would be inconsistent or the filter would begin anew."""
    begins, off = (60, 160), np.array((0.3, -0.4, 0.3))

    def spoil(k: int, u: Any) -> Any:
        begin = max((b for b in begins if b <= k), default=-1000)
        seen = measured(False)[begin][2].sun_B_measured if k < begin + 40 else u.sun_B_measured
        return replace(u, sun_B_measured=seen + off * (k < begin + 65))

    ys, off_by = flown(flavour, spoil, 260)
    seen = [y["health"][4] for y in ys]
    for begin in begins:
        assert seen[begin + 25 : begin + 58] == [FROZEN] * 33
        assert FROZEN not in seen[begin + 60 : begin + 100]
    assert INCONSISTENT not in seen
    assert all(np.any(y["R_NB"]) for y in ys[20:])
    assert max(off_by[50:]) < 2.0


def test_an_orbit_that_jumps_is_taken_after_as_many_fixes_that_agree_each_time(flavour):
    """After 20 in turn that agree with one before; 15 are forgotten where the known orbit comes back."""
    jumps = ((40, 55), (60, 75), (80, 120), (160, 200))

    def spoil(k: int, u: Any) -> Any:
        return replace(u, r_N_measured=u.r_N_measured + OFF * any(a <= k < b for a, b in jumps))

    ys, _ = flown(flavour, spoil, 240)
    wrong = [y["health"][2] == INCONSISTENT for y in ys]
    expected = [(40, 15), (60, 15), (80, 20), (120, 20), (160, 20), (200, 20)]
    assert within(wrong, 0, 239) == [k - 1 for begin, n in expected for k in range(begin, begin + n)]
    for k, at in ((75, 0.0), (105, OFF[0]), (150, 0.0), (190, OFF[0]), (230, 0.0)):
        assert ys[k - 1]["r_N"][0] - measured(False)[k][1][0] == pytest.approx(at, abs=100.0)
    assert ys[-1]["health"][2] == GOOD


def test_an_orbit_is_averaged_over_its_time_to_and_fro(flavour):
    """Fixes that are 100 m off, and then not: the exponential of a first-order filter, by steps of 1 s."""
    p, T = replace(sensors(), orbit_time=30.0), 30.0
    orbit, away = from_position_velocity(R_N, V_N, MU), 0.0

    def at(k: int, off: float) -> Any:
        r, v = orbit.position_velocity(float(k))
        return replace(measured(False)[0][2], r_N_measured=r + np.array((off, 0.0, 0.0)), v_N_measured=v)

    with flavour("estimator", p, at(0, 0.0), 1.0) as step:
        for k in range(1, 120):
            off = 100.0 if k // 30 % 2 else 0.0
            away += (off - away) / (T + 1.0)
            found = step(at(k, off))["r_N"][0] - orbit.position_velocity(float(k))[0][0]
            assert found == pytest.approx(away, abs=0.5), k


def test_without_the_gyro_for_a_while_the_rate_is_bridged_each_time(flavour):
    """Its measurements have numbers; where the number stays there is none. The rate of the body is constant."""
    gaps = ((60, 90), (150, 180), (240, 270))

    def gone(k: int) -> bool:
        return any(a <= k < b for a, b in gaps)

    numbers = np.cumsum([not gone(k) for k in range(300)])

    def spoil(k: int, u: Any) -> Any:
        return replace(u, rate_sample=int(numbers[k]), omega_B_measured=u.omega_B_measured + 0.05 * gone(k))

    ys, off = flown(flavour, spoil, 300)
    assert max(off[50:]) < 1.0
    ends = [
        np.linalg.norm(ys[b - 2]["attitude_sigma_B"]) / np.linalg.norm(ys[a - 2]["attitude_sigma_B"]) for a, b in gaps
    ]
    assert ends[1:] == pytest.approx(ends[:1] * 2, rel=0.5)


def test_before_an_attitude_the_last_field_is_given_for_five_minutes_each_time(flavour):
    """The body is at rest; then there is none."""
    first = measured(False)[0][2]
    none = replace(first, sun_B_measured=np.zeros(3), b_B_measured=np.zeros(3), omega_B_measured=np.zeros(3))
    with flavour("estimator", sensors(), replace(none, b_B_measured=first.b_B_measured), 10.0) as step:
        for _ in range(2):
            ys = [step(none) for _ in range(32)]
            assert [bool(np.any(y["b_B"])) for y in ys] == [True] * 30 + [False] * 2
            assert np.linalg.norm(ys[29]["b_B"]) == pytest.approx(np.linalg.norm(first.b_B_measured))
            assert not any(np.any(y["R_NB"]) for y in ys)
            step(replace(none, b_B_measured=first.b_B_measured))
