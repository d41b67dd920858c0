"""The blocks as FMUs of FMI 3.0: valid, the bits of FMI 2.0 by FMPy and in our loop, arrays, states, refusals."""

from __future__ import annotations

import shutil
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy import extract, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu
from lxml import etree

from fmus.build import build, ensure
from fmus.interface import BLOCKS, load
from fmus.native import package
from fmus.units import parse_unit
from orchestration import load as load_scenario
from orchestration import run
from orchestration.fmu.archive import open_fmu
from tests.blocks import folder, some
from tests.fmus.carried_data import played
from tests.once import built

ROOT = Path(__file__).parents[2]
SCENARIO = ROOT / "scenarios" / "paper_no_singularity.yaml"


def three(block: str) -> Path:
    """The FMU of FMI 3.0 for this machine, of the sources as they are."""

    def make(path: Path) -> None:
        path.write_bytes(package(load(block), folder(block), platforms="host", version=3))

    return built(f"{block}.fmu", [ensure(block, here=True), ROOT / "fmus" / "native" / "shell3"], make)


@pytest.mark.parametrize("block", some(BLOCKS, "controller", "plant"))
def test_fmpy_validates_the_fmu_and_gets_the_bits_of_fmi_2(block: str) -> None:
    assert validate_fmu(str(three(block))) == []
    given, expected = played(three(block), load(block)), played(ensure(block, here=True), load(block))
    np.testing.assert_array_equal(given.view(np.uint64), expected.view(np.uint64))


@pytest.mark.parametrize("block", some(BLOCKS, "allocator"))
def test_our_model_of_the_fmu_is_that_of_fmi_2(block: str) -> None:
    """Ports, shapes, units, limits, starts, items, feedthrough of the whole variables, and what is optional."""
    two, new = open_fmu(ensure(block, here=True)).model, open_fmu(three(block)).model
    for name, variable in two.variables.items():
        mixed = len({unit.name for unit in variable.units if unit}) > 1
        if mixed:  # as many scalars, which are read as one vector again
            assert name in new.variables or f"{name}[1]" in new.variables or f"{name}[1,1]" in new.variables
            continue
        other = new.variables[name]
        for part in ("causality", "type", "variability", "shape", "units", "minima", "maxima", "items", "optional"):
            assert getattr(other, part) == getattr(variable, part), (name, part)
    assert {e: two.starts[e] for e in two.starts if e in new.starts} == new.starts


def test_the_loop_flies_the_same_bits_with_blocks_of_either_version() -> None:
    data = {**load_scenario(SCENARIO).source.data, "duration": 5, "expect": [], "holds": [], "figures": []}
    ours = run(data)
    for chosen in (("controller",), ("plant", "controller", "allocator")):
        blocks: dict[str, Any] = {name: dict(entry) for name, entry in data["blocks"].items()}
        for name in chosen:
            blocks[name] |= {"fmu": str(three(name)), "isolation": "none"}
        theirs = run({**data, "blocks": blocks})
        for name in ours:
            np.testing.assert_array_equal(theirs[name], ours[name], err_msg=name)


@pytest.fixture
def controller(tmp_path: Path) -> Iterator[FMU3Slave]:
    it = slave(three("controller"), tmp_path / "controller")
    yield it
    it.freeInstance()


def slave(fmu: Path, unpacked: Path) -> FMU3Slave:
    extract(str(fmu), str(unpacked))
    about = read_model_description(str(unpacked))
    it = FMU3Slave(
        guid=about.instantiationToken,
        modelIdentifier=about.coSimulation.modelIdentifier,
        unzipDirectory=str(unpacked),
        instanceName="it",
    )
    it.instantiate(loggingOn=False)
    it.at = {v.name: v.valueReference for v in about.modelVariables}
    return it


def test_a_saved_state_continues_with_the_same_bits(controller: FMU3Slave) -> None:
    it, rate = controller, controller.at["omega_B"]
    it.enterInitializationMode()
    it.setFloat64([rate], [0.01, -0.02, 0.03])
    it.exitInitializationMode()
    it.doStep(0.0, 0.1)
    state = it.getFMUState()
    seen = []
    for _ in range(2):
        it.setFloat64([rate], [0.02, 0.01, -0.01])
        it.doStep(0.1, 0.1)
        seen.append(it.getFloat64([it.at["tau_cmd_B"], it.at["time"]][:1], nValues=3))
        it.setFMUState(state)
    assert seen[0] == seen[1]
    data = it.serializeFMUState(state)
    again = it.deserializeFMUState(data)
    assert it.serializeFMUState(again) == data
    it.freeFMUState(state)
    it.freeFMUState(again)


def test_time_is_where_the_last_step_ended(controller: FMU3Slave) -> None:
    controller.enterInitializationMode(startTime=2.0)
    controller.exitInitializationMode()
    controller.doStep(2.0, 0.5)
    assert controller.getFloat64([controller.at["time"]]) == [2.5]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda it: it.setFloat64([it.at["omega_B"]], [1.0, 2.0]), "has more values than were asked for"),
        (lambda it: it.setFloat64([it.at["omega_B"]], [1.0] * 4), "the number of values is not that of"),
        (lambda it: it.getFloat64([it.at["omega_B"] + 1]), "that of a variable of this FMU"),
        (lambda it: it.getInt32([it.at["omega_B"]]), r"fmi3GetInt32: omega_B\[1\] is of type Float64"),
        (lambda it: it.setFloat64([it.at["kappa0"]], [-1.0]), "fmi3SetFloat64: kappa0: expected a finite number, at"),
        (lambda it: it.setInt64([it.at["reference"]], [2**40]), "fmi3SetInt64: reference: expected 1 to 3, found"),
        (lambda it: it.doStep(0.0, 0.1), "fmi3DoStep: not allowed before fmi3EnterInitializationMode"),
        (lambda it: it.getClock([1]), "fmi3GetClock: not offered"),
        (lambda it: it.enterEventMode(), "fmi3EnterEventMode: not offered"),
    ],
)
def test_a_wrong_call_is_refused_with_the_name_of_the_function(
    controller: FMU3Slave, call: Any, message: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(FMICallException):
        call(controller)
    printed = capfd.readouterr().out
    assert "fmi2" not in printed
    import re

    assert re.search(message, printed), printed


def test_an_instance_of_another_type_or_token_is_refused(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    fmu = three("allocator")
    extract(str(fmu), str(tmp_path))
    it = FMU3Slave(guid="{0}", modelIdentifier="allocator", unzipDirectory=str(tmp_path), instanceName="it")
    with pytest.raises(Exception, match="[Ff]ail"):
        it.instantiate()
    assert "is not of this binary" in capfd.readouterr().out


def test_two_instances_live_side_by_side(tmp_path: Path) -> None:
    one, two = (slave(three("controller"), tmp_path / name) for name in ("one", "two"))
    for it, value in ((one, 0.01), (two, 0.02)):
        it.setFloat64([it.at["omega_B"]], [value, 0.0, 0.0])
    assert one.getFloat64([one.at["omega_B"]], nValues=3) == [0.01, 0.0, 0.0]
    one.freeInstance()
    assert two.getFloat64([two.at["omega_B"]], nValues=3) == [0.02, 0.0, 0.0]
    two.freeInstance()


@pytest.mark.parametrize("block", some(BLOCKS, "estimator"))
def test_units_arrays_terminals_and_build_description_are_those_of_the_interface(block: str) -> None:
    with zipfile.ZipFile(three(block)) as archive:
        root, terminals, building = (
            etree.fromstring(archive.read(name))
            for name in (
                "modelDescription.xml",
                "terminalsAndIcons/terminalsAndIcons.xml",
                "sources/buildDescription.xml",
            )
        )
        names = archive.namelist()
    for name in ("fmi3TerminalsAndIcons", "fmi3BuildDescription"):
        schema = etree.XMLSchema(file=str(Path(fmpy.__file__).parent / "schema" / "fmi3" / f"{name}.xsd"))
        schema.assertValid(terminals if "Terminals" in name else building)
    known = {entry.get("name") for entry in root.find("ModelVariables")}
    assert {m.get("variableName") for m in terminals.iter("TerminalMemberVariable")} <= known
    assert all(f"sources/{entry.get('name')}" in names for entry in building.iter("SourceFile"))
    for variable in load(block).variables.values():
        entries = [e for e in root.find("ModelVariables") if e.get("name").partition("[")[0] == variable.name]
        sizes = [int(np.prod([int(d.get("start")) for d in e.findall("Dimension")])) for e in entries]
        assert sum(sizes) == len(variable.elements), variable.name
    for unit in root.find("UnitDefinitions"):
        exponents = {k: int(v) for k, v in unit.find("BaseUnit").attrib.items() if k != "factor"}
        assert exponents == {k: int(v) for k, v in parse_unit(unit.get("name")).base_unit.items() if k != "factor"}


@pytest.mark.thorough
def test_the_command_builds_for_all_platforms_and_fmpy_compiles_the_sources(tmp_path: Path) -> None:
    path = build(["allocator"], out=tmp_path, version=3)["allocator"]
    with zipfile.ZipFile(path) as archive:
        places = sorted(n.split("/")[1] for n in archive.namelist() if n.startswith("binaries/"))
    assert places == ["aarch64-darwin", "aarch64-linux", "x86_64-darwin", "x86_64-linux", "x86_64-windows"]
    shipped = played(path, load("allocator"))
    if shutil.which("cmake"):
        from fmpy.build import build_platform_binary

        folder_, made = tmp_path / "unpacked", tmp_path / "build"
        made.mkdir()
        extract(str(path), str(folder_))
        build_platform_binary(str(folder_), str(made))
        again = shutil.make_archive(str(tmp_path / "again"), "zip", folder_)
        np.testing.assert_array_equal(played(Path(again), load("allocator")), shipped)
