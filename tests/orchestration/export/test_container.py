"""A container: it prints nothing, takes any step of its host, has its parameters, and names who fails."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

import orchestration

from .host import Host

EXPORTED = "loop.fmu"


@pytest.fixture
def container(loop: Path) -> Path:
    return orchestration.export_loop(loop, loop.with_name(EXPORTED))


def test_a_container_prints_nothing_and_is_valid(container: Path) -> None:
    assert validate_fmu(str(container)) == []
    program = f"import fmpy; print(fmpy.simulate_fmu({str(container)!r}, stop_time=1)['motor.speed'][-1])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert re.fullmatch(r"[-\d.e]+\n", done.stdout)
    assert done.stderr == ""


def test_a_parameter_that_the_host_sets_counts_from_the_first_value_on(container: Path, loop: Path) -> None:
    host = Host(container)
    host.begin(motor__speed0=1.5, regulator__gain=-0.7)
    seen = [host.speed(), *host.fly([0.1 * k for k in range(21)])]
    ours = orchestration.run(loop, {"motor.speed0": 1.5, "regulator.gain": -0.7})["motor.speed"]
    assert seen == list(ours)
    host.end()


def test_a_step_of_any_length_makes_the_steps_of_the_scenario_that_end_in_it(container: Path, loop: Path) -> None:
    ours = list(orchestration.run(loop)["motor.speed"])
    host = Host(container)
    host.begin(start=10.0)
    added = [10.0]
    for _ in range(40):
        added.append(added[-1] + 0.05)
    assert host.fly(added) == [ours[k // 2] for k in range(1, 41)]
    host.fmu.reset()
    host.begin()
    assert host.fly([0.0, 0.5, 0.75, 1.0]) == [ours[5], ours[7], ours[10]]
    host.end()


def test_two_instances_of_a_process_do_not_see_each_other_in_a_folder_with_a_space(
    container: Path, tmp_path: Path
) -> None:
    odd = tmp_path / "weiße Möwe #1"
    odd.mkdir()
    first, second = Host(container), Host(Path(shutil.copy(container, odd)), "two")
    first.begin()
    second.begin(motor__speed0=3.0)
    assert first.speed() == 2.0
    assert second.speed() == 3.0
    assert not np.isclose(first.fly([0.0, 0.1])[0], second.fly([0.0, 0.1])[0])
    first.end()
    second.end()


def test_an_error_inside_is_told_with_the_block_and_the_call(loop: Path) -> None:
    path = orchestration.export_loop(loop, loop.with_name(EXPORTED))
    host = Host(path)
    host.fmu.setInteger([host.references["motor.fault"]], [1])
    host.begin()
    with pytest.raises(FMICallException):
        host.fmu.doStep(0.0, 0.1)
    assert any("motor: fmi2DoStep returned fmi2Error" in text for text in host.said)
    with pytest.raises(FMICallException):
        host.fmu.doStep(0.1, 0.1)
    assert any("fmi2DoStep: not allowed after an error" in text for text in host.said)
    host.end()


def test_it_declares_the_platforms_that_all_its_fmus_have_and_states_where_all_can_save_them(container: Path) -> None:
    with zipfile.ZipFile(container) as archive:
        folders = {name.split("/")[1] for name in archive.namelist() if name.startswith("binaries/")}
        inner = {name.split("/")[3] for name in archive.namelist() if re.match(r"resources/\d_motor/binaries/", name)}
    assert folders == inner == {fmpy.platform}
    assert not fmpy.read_model_description(str(container)).coSimulation.canGetAndSetFMUstate


def test_a_step_that_does_not_begin_where_the_last_one_ended_is_refused(container: Path) -> None:
    host = Host(container)
    host.begin()
    with pytest.raises(FMICallException):
        host.fmu.doStep(0.5, 0.1)
    assert any("begins where the last one ended" in text for text in host.said)
    host.end()


def test_the_same_system_gives_the_same_bytes(container: Path, loop: Path) -> None:
    before = container.read_bytes()
    assert orchestration.export_loop(loop, container).read_bytes() == before
