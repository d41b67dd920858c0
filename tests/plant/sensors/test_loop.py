"""The sensors between plant, controller and allocator: the paper's first manoeuvre, flown on measurements."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from orchestration import load, run

SCENARIO = Path(__file__).parents[3] / "scenarios" / "paper_no_singularity.yaml"
MEASURED = ("R_NB", "omega_B", "r_N", "v_N", "b_B", "h_w")
NOISE = {
    "attitude_noise": "0.01 deg",
    "rate_noise": "1e-5 rad/s",
    "field_noise": "50 nT",
    "wheel_momentum_noise": "0.01 mN.m.s",
    "position_noise": "10 m",
    "velocity_noise": "1 cm/s",
}


def scenario(**start: Any) -> dict[str, Any]:
    """V.B with the sensors between the plant and the rest."""
    data = load(SCENARIO).source.data
    wires = [tuple(text.split(" -> ")) for text in data["connections"]]
    told = [
        (f"sensors.{source.removeprefix('plant.')}_measured" if source.startswith("plant.") else source, target)
        for source, target in wires
    ]
    wires = [(f"plant.{name}", f"sensors.{name}") for name in MEASURED] + told
    blocks = {
        **data["blocks"],
        "sensors": {"fmu": "plant_sensors", "start": start} if start else {"fmu": "plant_sensors"},
    }
    return {**data, "blocks": blocks, "connections": [" -> ".join(wire) for wire in wires], "figures": []}


def fly(data: dict[str, Any], duration: float, **changes: Any):
    data = {**data, "duration": duration, "expect": [], **changes}
    return run({key: value for key, value in data.items() if value != []})


def test_without_errors_the_loop_flies_as_without_sensors_to_the_bit():
    plain = fly({**load(SCENARIO).source.data, "figures": []}, 100.0)
    through = fly(scenario(), 100.0)
    for signal in ("plant.R_NB", "plant.omega_B", "plant.h_w", "allocator.dipole_cmd"):
        assert np.array_equal(plain[signal], through[signal]), signal


def test_the_order_puts_the_sensors_between_plant_and_law():
    assert fly(scenario(**NOISE), 1.0).manifest["order"] == ["plant", "sensors", "controller", "allocator", "judge"]


def test_the_manoeuvre_settles_on_noisy_measurements_whose_errors_are_those_asked_for():
    result = fly(scenario(**NOISE, seed=11), 386.1)
    off = result["sensors.omega_B_measured"] - result["plant.omega_B"]
    assert stats.kstest(off.ravel() / 1e-5, "norm").pvalue > 1e-6
    off = result["sensors.b_B_measured"] - result["plant.b_B"]
    assert stats.kstest(off.ravel() / 50e-9, "norm").pvalue > 1e-6
    turns = np.swapaxes(result["plant.R_NB"], 1, 2) @ result["sensors.R_NB_measured"]
    off = Rotation.from_matrix(turns).as_rotvec()
    assert stats.kstest(off.ravel() / np.radians(0.01), "norm").pvalue > 1e-6
    settled = result.time > 250.0
    assert np.degrees(result["controller.attitude_error"][settled]).max() < 2.0
    assert np.degrees(result["controller.attitude_error"][0]) > 80.0


@pytest.mark.parametrize("period", ["0 s", "0.5 s"])
def test_the_flavours_agree_in_the_loop(period):
    data = scenario(**NOISE, seed=3, sensor_period=period)
    native, python = (fly(data, 20.0, flavour=flavour) for flavour in ("native", "python"))
    for signal in ("plant.R_NB", "plant.omega_B", "sensors.b_B_measured", "sensors.r_N_measured"):
        largest = np.abs(python[signal]).max()
        assert np.abs(native[signal] - python[signal]).max() < 1e-9 * largest, signal


def test_with_a_period_the_noise_is_held():
    result = fly(scenario(**NOISE, sensor_period="0.5 s"), 20.0)
    found = result["sensors.omega_B_measured"]
    assert (np.abs(np.diff(found, axis=0)).max(axis=1) > 0.0).tolist() == [i % 5 == 0 for i in range(1, 201)]
