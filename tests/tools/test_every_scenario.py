"""Every shipped scenario leaves: as a container, and as an archive that a plain C host flies with our bits.

What differs where a host steps all blocks at once, and in other tools: python -m tests.tools.exchanges.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

import orchestration
from orchestration import load
from orchestration.errors import InputError

from .archives import validate
from .exchanges import ARM, EMULATED, SCENARIOS, SOON, compared, in_tools, plain
from .exchanges import flown as by_host
from .sequential import flown

pytestmark = pytest.mark.thorough

ROOT = Path(__file__).parents[2]


@pytest.mark.skipif(sys.platform != "linux", reason="the host is written for Linux")
@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: path.stem)
def test_a_plain_c_host_flies_the_exported_scenario_with_our_bits(path: Path, tmp_path: Path) -> None:
    scenario = plain(path, SOON.get(path.stem, 40.0))
    assert all(difference.max() == 0.0 for difference in compared(scenario, tmp_path).values())
    validate(tmp_path / f"{scenario.name}.ssp")


ON_ARM = (
    "flight_estimated",
    "flight_pyramid_allocated",
    "flight_pyramid_estimated",
    "flight_three_wheels",
    "mission_day",
)
"""Of their blocks each of our FMUs but `allocator` is one, beside FMUs of changes."""


@pytest.mark.skipif(shutil.which(EMULATED[0]) is None, reason="needs qemu-aarch64 (Debian: qemu-user)")
@pytest.mark.skipif(not ARM.is_dir(), reason="needs the C library of Arm (Debian: libc6-arm64-cross)")
@pytest.mark.parametrize("name", ON_ARM)
def test_the_libraries_for_linux_on_arm_fly_the_loop_with_the_bits_of_x86_64(name: str, tmp_path: Path) -> None:
    scenario = plain(ROOT / "scenarios" / f"{name}.yaml", 10.0)
    archive = orchestration.export_loop(scenario, tmp_path / "adcs.ssp")
    outputs = ("plant.omega_B", "plant.dipole", "plant.wheel_torque", "plant.b_B", "judge.attitude_error")
    signals = [label for label in orchestration.run(scenario).labels if label.partition("[")[0] in outputs]
    step, count = float(scenario.step), round(scenario.duration / scenario.step)
    here, there = (by_host(archive, step, count, signals, 1, "sequential", arm) for arm in (False, True))
    assert here.shape == (count + 1, len(signals))
    assert np.ptp(here[:, signals.index("plant.omega_B[1]")]) > 0.0
    assert np.array_equal(there, here)


@pytest.mark.skipif(sys.platform != "linux", reason="the host is written for Linux")
@pytest.mark.parametrize("name", ["flight_vb", "flight_estimated"])
def test_planned_loops_fly_in_fmpy_libcosim_and_ecos_as_in_a_host_that_steps_all_at_once(name: str) -> None:
    path = ROOT / "scenarios" / f"{name}.yaml"
    _, seconds, in_order, at_once, *in_tool = in_tools(path, 10.0)
    assert (seconds, in_order) == ("10", "0")
    assert 1e-6 < float(at_once) < 0.1
    assert len(in_tool) == 3
    assert max(map(float, in_tool)) < 1e-9


LOOKED_AT = ("fault_stuck_wheel", "flight_three_wheels", "mission_day")
"""Whose container FMPy looks at whole, which takes longer than all flights; they have each kind of block."""


@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: path.stem)
def test_a_container_of_the_scenario_has_our_bits(path: Path, tmp_path: Path) -> None:
    scenario = plain(path, SOON.get(path.stem, 10.0))
    container = orchestration.export_loop(scenario, tmp_path / "adcs.fmu")
    assert path.stem not in LOOKED_AT or validate_fmu(str(container)) == []
    ours = orchestration.run(scenario)
    known = {v.name for v in fmpy.read_model_description(str(container)).modelVariables}
    names = [label.replace("][", ",") for label in ours.labels]
    assert set(names) <= known
    seen = [name for name in names if name.startswith(("plant.", "controller.", "estimator."))]
    step = float(scenario.step)
    result = fmpy.simulate_fmu(str(container), stop_time=scenario.duration, output_interval=step, output=seen)
    apart = round((len(result) - 1) / (len(ours.time) - 1))
    for name in seen:
        assert np.array_equal(result[name][::apart], ours.samples[:, names.index(name)]), name


FAULTS: dict[str, list[dict[str, Any]]] = {
    "a late signal": [{"at": 3, "until": 7, "freeze": "allocator.dipole_cmd"}],
    "a delayed signal": [{"at": 3, "cut": "estimator.dipole[2]", "to": 0.5}],
    "from the start": [{"at": 0, "until": 4.5, "bias": "sensors.b_B_measured", "by": [1e-6, 0, 0]}],
    "one upon another": [
        {"at": 2, "bias": "plant.omega_B", "by": [0.001, 0, 0]},
        {"at": 4.5, "until": 8, "freeze": "sensors.omega_B"},
    ],
    "a parameter over the timeline": [{"at": 2.5, "until": 6, "set": "plant.rod_gain[1] = 0.5"}],
    "a flag": [{"at": 3, "until": 6, "cut": "estimator.attitude_valid", "to": True}],
}


@pytest.mark.parametrize("name", FAULTS)
def test_faults_of_all_kinds_have_our_bits_at_rates_and_behind_delays(name: str, tmp_path: Path) -> None:
    flight = "mission_day" if name == "a flag" else "flight_estimated"
    source = plain(ROOT / "scenarios" / f"{flight}.yaml", 10.0).source.with_value("faults", FAULTS[name], "")
    timeline = [{"at": 1, "set": {"plant.rod_gain[1]": 0.9}}, {"at": 4, "set": {"plant.rod_gain[1]": 0.8}}]
    scenario = load(source.with_value("timeline", timeline, ""))
    archive = orchestration.export_loop(scenario, tmp_path / "adcs.ssp")
    validate(archive)
    ours = orchestration.run(scenario)
    signals = [label for label in ours.labels if label.startswith(("plant.omega_B", "allocator.dipole_cmd"))]
    wanted = np.column_stack([ours.samples[:, ours.labels.index(s)] for s in signals])[1:]
    step = float(scenario.step)
    theirs = np.array(flown(archive, step, round(10.0 / step), signals, adds_up=True))
    assert np.array_equal(theirs, wanted)
    back = orchestration.run(archive)
    assert np.array_equal(np.column_stack([back.samples[:, back.labels.index(s)] for s in signals])[1:], wanted)
    undisturbed = orchestration.run(load(source.without([("faults",), ("timeline",)])))
    assert not np.array_equal(undisturbed["plant.omega_B"], ours["plant.omega_B"])


def test_what_no_fmu_passes_on_is_refused_with_its_one_reason(tmp_path: Path) -> None:
    source = plain(SCENARIOS[0], 30.0).source.with_value("exchange", "parallel", "")
    with pytest.raises(
        InputError, match="faults: a parallel exchange delays what goes through an FMU by one more step"
    ):
        orchestration.export_loop(load(source), tmp_path / "adcs.ssp")
