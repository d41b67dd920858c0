"""What OMSimulator's exchange, imitated, makes of the scenarios; docs/use/tools.md tells of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import orchestration

from .exchange import imitated, plain

pytestmark = pytest.mark.thorough

SCENARIOS = Path(__file__).parents[2] / "scenarios"
ERROR = "controller.attitude_error"


@pytest.mark.parametrize("name", ["paper_no_singularity", "fault_lost_magnetometer"])
def test_laws_without_memory_give_the_same_bits_in_omsimulator_s_order(name: str, tmp_path: Path) -> None:
    scenario = plain(SCENARIOS / f"{name}.yaml", 0.1, 60.0)
    assert np.array_equal(imitated(scenario, ERROR, tmp_path), np.asarray(orchestration.run(scenario)[ERROR]))


def test_the_fault_of_the_lost_magnetometer_is_what_differs_without_it() -> None:
    with_fault = orchestration.run(SCENARIOS / "fault_lost_magnetometer.yaml")
    without = orchestration.run(plain(SCENARIOS / "fault_lost_magnetometer.yaml", 0.1, 386.1))
    difference = np.abs(np.asarray(with_fault[ERROR]) - np.asarray(without[ERROR]))
    assert difference.max() == pytest.approx(0.033, abs=5e-4)
    assert with_fault.time[difference.argmax()] == pytest.approx(91.9, abs=0.5)
    assert with_fault.time[(difference >= 2e-3).argmax()] == pytest.approx(32.8, abs=0.5)


def test_u_applied_a_sample_later_explains_little_of_the_planned_controller_s_difference(tmp_path: Path) -> None:
    scenario = plain(SCENARIOS / "flight_vb.yaml", 0.5, 120.0)
    ours = np.asarray(orchestration.run(scenario)[ERROR])
    differences = []
    for late in ("", "u_applied"):
        (tmp_path / f"x{late}").mkdir()
        differences.append(np.abs(imitated(scenario, ERROR, tmp_path / f"x{late}", late) - ours).max())
    assert differences == [pytest.approx(0.039, abs=1e-3), pytest.approx(0.039, abs=1e-3)]
