"""A matrix of zeros before the first attitude: simple masters, FMPy's reader of SSP archives among them, begin so."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from scipy.spatial.transform import Rotation

from fmus.build import ensure
from fmus.interface import load

from .host import Host

BLOCKS = ("controller", "controller_planned", "plant_judge")
ZEROS: dict[str, Any] = {"R_NB": np.zeros(9), "omega_B": np.zeros(3), "r_N": np.zeros(3), "v_N": np.zeros(3)}
FLIGHT: dict[str, Any] = {
    "R_NB": Rotation.from_rotvec([0.3, -0.7, 0.5]).as_matrix(),
    "omega_B": [0.001, -0.002, 0.003],
    "r_N": [6971000.0, 0.0, 0.0],
    "v_N": [0.0, -1052.3891, 7488.1109],
}


@pytest.fixture(params=[(block, flavour) for block in BLOCKS for flavour in load(block).flavours], ids="-".join)
def host(request: pytest.FixtureRequest) -> Iterator[Host]:
    with Host(ensure(*request.param)) as host:
        yield host


def _give(host: Host, values: dict[str, Any]) -> None:
    for name, value in values.items():
        host.set(name, value)


def _silent(host: Host) -> None:
    """No torque, the flag, and no small error that a claim could be met by."""
    y = host.outputs()
    assert y["no_attitude"] == 1
    assert y["attitude_error"] == math.pi
    for name in ("tau_cmd_B", "dipole_ff", "wheel_torque_ff"):
        assert not np.any(y.get(name, 0.0)), name


@pytest.mark.parametrize("at_start", [ZEROS, {}], ids=["zeros at the start", "starts, then zeros"])
def test_zeros_before_the_first_attitude_give_no_torque_and_a_flag(host: Host, at_start: dict[str, Any]) -> None:
    host.started(**at_start)
    if at_start:
        _silent(host)
    for k in range(3):
        _give(host, ZEROS)
        host.step(k)
        _silent(host)
    _give(host, FLIGHT)
    host.step(3)
    y = host.outputs()
    assert y["no_attitude"] == 0
    assert 0.0 < y["attitude_error"] < math.pi
    assert "tau_cmd_B" not in y or np.any(y["tau_cmd_B"])


def test_what_is_latched_at_the_start_is_latched_at_the_first_attitude(host: Host) -> None:
    host.started(**ZEROS)
    host.step(0, count=5)
    _give(host, FLIGHT)
    before_its_step = host.outputs()
    host.step(5)
    late = host.outputs()
    host.fmu.reset()
    host.started(**FLIGHT)
    prompt = host.outputs()
    if "phase" in late:  # the planned controller's field has turned with the Earth by 0.6 s
        assert late["phase"] == prompt["phase"]
        assert late["attitude_error"] == pytest.approx(prompt["attitude_error"], abs=1e-12)
        assert late["R_d"] == pytest.approx(prompt["R_d"], abs=1e-12)
    else:
        assert late == prompt == before_its_step


def test_zeros_after_an_attitude_are_refused(host: Host) -> None:
    host.started(**FLIGHT)
    host.step(0)
    host.set("R_NB", np.zeros(9))
    with pytest.raises(FMICallException):
        host.step(1)
    assert "R_NB" in host.log[-1][2]
    _give(host, FLIGHT)
    host.step(1)


@pytest.mark.parametrize("element", [0, 4, 8])
def test_a_matrix_that_is_nearly_zero_is_refused(host: Host, element: int) -> None:
    nearly = np.zeros(9)
    nearly[element] = 1e-300
    with pytest.raises(FMICallException):
        host.started(R_NB=nearly)


def test_a_state_that_waits_for_the_attitude_is_restored(host: Host) -> None:
    host.started(**ZEROS)
    host.step(0, count=2)
    waiting = host.serialized()
    _give(host, FLIGHT)
    host.step(2, count=6)
    end = host.outputs()
    host.restore(waiting)
    _silent(host)
    _give(host, FLIGHT)
    host.step(2, count=6)
    assert host.outputs() == end


@pytest.mark.parametrize("flavour", load("plant_sensors").flavours)
def test_sensors_hand_zeros_on_exactly(flavour: str) -> None:
    with Host(ensure("plant_sensors", flavour)) as host:
        host.started(attitude_noise=0.1, attitude_bias_B=[0.1, 0.2, 0.3], **ZEROS)
        for k in range(3):
            host.step(k)
            assert not np.any(host.get("R_NB_measured"))


@pytest.mark.parametrize("flavour", load("plant").flavours)
@pytest.mark.parametrize(("period", "duty"), [(1.0, 0.75), (0.7, 0.2), (0.0, 1.0), (1.0, 0.0)])
def test_the_mean_dipole_is_that_of_the_time_in_which_the_rods_were_on(
    flavour: str, period: float, duty: float
) -> None:
    """Closed form: how much of [t, t + h] lies within [k T, (k + duty) T], k = 0, 1, ..."""
    h = 0.3
    gain, command = np.array([1.0, 0.5, 2.0]), np.array([3.0, -40.0, 5.0])
    full = gain * np.clip(command, -25.0, 25.0)
    with Host(ensure("plant", flavour)) as host:
        host.started(rod_period=period, rod_duty=duty, rod_gain=gain, dipole_cmd=command)
        assert host.get("dipole_mean") == [0.0, 0.0, 0.0]
        for k in range(12):
            host.step(k, h)
            t = k * h
            on = [max(0.0, min(t + h, (n + duty) * period) - max(t, n * period)) for n in range(8)]
            share = sum(on) / h if period > 0.0 else 1.0
            np.testing.assert_allclose(host.get("dipole_mean"), share * full, rtol=1e-9, atol=1e-12)
