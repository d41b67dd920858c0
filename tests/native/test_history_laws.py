"""What controller, allocator, judge and sensors remember, reached twice in both flavours.

The witnesses are a fresh instance that gets there for the first time, and counts of steps.
"""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.blocks import inputs, parameters

from .driver import Refused
from .twice import FLAVOURS

pytestmark = pytest.mark.parametrize("flavour", FLAVOURS)
H = 1.0
ZEROS = np.zeros((3, 3))


def turned(*rotvec: float) -> Any:
    return Rotation.from_rotvec(rotvec).as_matrix()


def test_gains_are_scheduled_from_the_errors_with_which_each_attitude_came_back(flavour):
    """kappa0 (a1 + angle)/(a2 + angle_0), lambda0 (c1 + rate)/(c2 + rate_0) with the paper's gains, of [10]."""
    p, u = parameters("controller", reference="inertial"), inputs("controller", R_ref=np.eye(3))
    u = replace(u, Omega_ref=np.zeros(3), dOmega_ref=np.zeros(3))
    with flavour("controller", p, replace(u, R_NB=turned(0.5, 0.0, 0.0)), H) as step:
        for angle_0, rate_0 in ((0.5, 0.2), (1.5, 0.1), (0.5, 0.2), (2.5, 0.0)):
            assert step(replace(u, R_NB=ZEROS))["no_attitude"]
            for angle, rate in ((angle_0, rate_0), (0.3, 0.05), (1.0, 0.3)):
                y = step(replace(u, R_NB=turned(0.0, angle, 0.0), omega_B=np.array([rate, 0.0, 0.0])))
                assert y["gain_k"] == pytest.approx(0.098 * (3.5 + angle) / (35.0 + angle_0), rel=1e-12)
                assert y["gain_l"] == pytest.approx(1.47 * (2.1 + rate) / (21.0 + rate_0), rel=1e-12)


def test_a_hold_holds_the_command_before_it_each_time(flavour):
    p = parameters("allocator")
    u = inputs("allocator", b_B=[2e-5, 1e-5, -3e-5])
    demand = np.array([3e-5, -2e-5, 4e-5])
    with flavour("allocator", p, u, H) as step:
        for share in (1.0, -0.5, 0.3):
            before = step(replace(u, tau_cmd_B=share * demand))
            assert not before["holding"]
            for _ in range(2):
                held = step(replace(u, tau_cmd_B=1e3 * demand))
                assert held["holding"]
                for name in ("dipole_cmd", "wheel_torque_cmd"):
                    np.testing.assert_array_equal(held[name], before[name])


def test_before_the_first_command_a_hold_gives_none(flavour):
    """Along the field a demand of exactly the fraction of what the wheel can give is held; no limit is reached."""
    p = parameters("allocator", wheel_torque_max=2.0**-9, hold_fraction=1.0)
    u = inputs("allocator", b_B=[2.0**-15, 0.0, 0.0], tau_cmd_B=[2.0**-9, 0.0, 0.0])
    with flavour("allocator", p, u, H) as step:
        for _ in range(2):
            y = step(u)
            assert y["demand_fraction"] == 1.0
            assert y["holding"]
            assert not np.any(y["dipole_cmd"])
            assert y["wheel_torque_cmd"] == 0.0


def test_zeros_for_an_attitude_are_taken_before_the_first_one_and_refused_after_it(flavour):
    """Where no reference is connected: each flight anew."""
    for block in ("controller", "plant_judge"):
        p, good = parameters(block), inputs(block)
        for _ in range(2):
            with flavour(block, p, replace(good, R_NB=ZEROS), H) as step:
                for _ in range(2):
                    step(replace(good, R_NB=ZEROS))
                for _ in range(2):
                    step(good)
                with pytest.raises((ValueError, Refused)):
                    step(replace(good, R_NB=ZEROS))


def test_each_outage_loses_the_signal_and_counts_nothing_and_each_return_counts_on(flavour):
    p = parameters("plant_sensors", attitude_outage_interval=20.0, attitude_outage_duration=10.0,
                   orbit_outage_interval=30.0, orbit_outage_duration=10.0)  # fmt: skip
    u = inputs("plant_sensors")
    with flavour("plant_sensors", p, u, H) as step:
        count, fixes, gone, lost = 1, 1, 0, 0
        at = np.array(u.r_N)
        for i in range(1, 300):
            y = step(replace(u, r_N=u.r_N + i, R_NB=turned(0.01 * i, 0.0, 0.0)))
            there = bool(np.any(y["R_NB_measured"]))
            count += there
            assert y["attitude_sample"] == count
            fixed = int(y["orbit_sample"]) == fixes + 1
            fixes += fixed
            at = u.r_N + i if fixed else at
            assert y["orbit_sample"] == fixes
            assert y["r_N_measured"] == pytest.approx(at, abs=1e-9)
            gone += not there
            lost += not fixed
    # Shares of 1/3 and 1/4, in outages of 10 s: deviations of 25 and 22 over 300 s.
    assert 30 < gone < 180
    assert 20 < lost < 150


def test_a_step_of_more_than_a_thousand_million_sample_periods_is_refused_by_name(flavour):
    p, u = parameters("plant_sensors", sensor_period=2e-6), inputs("plant_sensors")
    for h, refused in ((1999.0, False), (2001.0, True)):
        with flavour("plant_sensors", p, u, h) as step:
            for _ in range(2):
                with pytest.raises((ValueError, Refused), match="sensor_period") if refused else nullcontext():
                    step(u)
