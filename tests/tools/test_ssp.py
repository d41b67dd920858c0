"""The system as a file: SSP archives written and read, ours and others', and container FMUs."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pyssp_standard
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

import orchestration
from orchestration import load

from ..orchestration import fmus
from .archives import printed, validate

pytestmark = pytest.mark.thorough

ROOT = Path(__file__).parents[2]
SCENARIOS = sorted((ROOT / "scenarios").glob("paper*.yaml"))


@pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda p: p.stem)
def test_a_scenario_comes_back_from_its_archive_and_gives_the_same_bits(scenario: Path, tmp_path: Path) -> None:
    archive = tmp_path / "adcs.ssp"
    printed("export", scenario, "--ssp", archive)
    validate(archive)
    direct, back = orchestration.run(scenario), orchestration.run(archive)
    assert back.labels == direct.labels
    assert np.array_equal(back.samples, direct.samples)
    assert [(o.name, o.passed) for o in back.outcomes] == [(o.name, o.passed) for o in direct.outcomes]
    assert back.scenario.figures == direct.scenario.figures
    assert back.warnings == []


def test_the_same_scenario_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one.ssp", "two.ssp"):
        printed("export", SCENARIOS[0], "--ssp", tmp_path / name)
    assert (tmp_path / "one.ssp").read_bytes() == (tmp_path / "two.ssp").read_bytes()


def test_every_connected_input_has_the_value_that_comes_to_it_at_the_start(tmp_path: Path) -> None:
    printed("export", SCENARIOS[0], "--ssp", tmp_path / "adcs.ssp")
    result = orchestration.run(SCENARIOS[0], {"duration": 0.1})
    with zipfile.ZipFile(tmp_path / "adcs.ssp") as archive:
        values = etree.fromstring(archive.read("resources/controller.ssv"))
    found = {p.get("name"): float(p[0].get("value")) for p in values.iter("{*}Parameter")}
    for i in range(3):
        assert found[f"omega_B[{i + 1}]"] == result["plant.omega_B"][0, i]
        for j in range(3):
            assert found[f"R_NB[{i + 1},{j + 1}]"] == result["plant.R_NB"][0, i, j]


LOOPS: dict[str, Callable[[str], str]] = {
    "as it is": lambda text: text,
    "at another rate": lambda text: text.replace("fmu: regulator.fmu\n", "fmu: regulator.fmu\n    every: 2\n"),
    "with a delay": lambda text: text.replace("record:", "delays: [motor.voltage]\nrecord:").replace(
        "inertia: 0.5", "inertia: 0.5\n      voltage: 0.25"
    ),
    "in parallel": lambda text: text.replace("step: 0.1 s", "step: 0.1 s\nexchange: parallel"),
    "with an item": lambda text: text.replace("inertia: 0.5", "inertia: 0.5\n      mode: brake\n      label: a b"),
    "two of one FMU": lambda text: text.replace(
        "connections:",
        "  other: {fmu: motor.fmu, start: {speed0: 0.5}}\nconnections:\n  - regulator.voltage -> other.voltage",
    ),
}


@pytest.mark.parametrize("change", LOOPS)
def test_a_loop_comes_back(loop: Path, change: str) -> None:
    loop.write_text(LOOPS[change](loop.read_text()))
    printed("export", loop.name, "--ssp", "loop.ssp", "--for-orchestrate")
    validate(Path("loop.ssp"))
    direct, back = orchestration.run(loop.name), orchestration.run("loop.ssp")
    assert back.labels == direct.labels
    assert np.array_equal(back.samples, direct.samples)


@pytest.mark.parametrize("options", [("--ssp-version", "2.0"), ("--numbers",), ("--ssp-version", "2.0", "--numbers")])
def test_an_archive_of_ssp_2_and_one_with_numbers_are_valid_and_come_back(loop: Path, options: tuple[str, ...]) -> None:
    loop.write_text(LOOPS["with an item"](loop.read_text()))
    printed("export", loop.name, "--ssp", "loop.ssp", *options)
    with zipfile.ZipFile("loop.ssp") as archive:
        documents = {n: archive.read(n) for n in archive.namelist() if n.endswith((".ssd", ".ssv"))}
        archive.extract("resources/motor.fmu")
    schemas = Path(pyssp_standard.__file__).parent / "resources" / "ssp2"
    for name, text in documents.items():
        kind = {".ssd": "Description", ".ssv": "ParameterValues"}[Path(name).suffix]
        root = etree.fromstring(text)
        etree.XMLSchema(etree.parse(schemas / f"SystemStructure{kind}.xsd")).assertValid(root)
        assert root.get("version") == ("2.0" if "2.0" in options else "1.0")
    assert (b"<ssv:Enumeration" in documents["resources/motor.ssv"]) == ("--numbers" not in options)
    assert validate_fmu("resources/motor.fmu") == []
    assert np.array_equal(orchestration.run("loop.ssp").samples, orchestration.run(loop.name).samples)


@pytest.mark.parametrize(
    ("times", "end"), [('startTime="0.0" stopTime="1.0"', 1.0), ('startTime="0.5" stopTime="2.0"', 1.5), ("", 2.0)]
)
def test_a_duration_that_another_tool_gives_an_archive_counts_and_one_that_it_leaves_out_stays(
    loop: Path, tmp_path: Path, times: str, end: float
) -> None:
    printed("export", loop.name, "--ssp", "loop.ssp")
    with zipfile.ZipFile("loop.ssp") as archive, zipfile.ZipFile("edited.ssp", "w") as edited:
        for name in archive.namelist():
            data = archive.read(name)
            if name == "SystemStructure.ssd":
                assert b'startTime="0.0" stopTime="2.0"' in data
                data = data.replace(b'startTime="0.0" stopTime="2.0"', times.encode())
            edited.writestr(name, data)
    direct, back = orchestration.run(loop.name), orchestration.run("edited.ssp")
    assert back.time[-1] == pytest.approx(end)
    assert np.array_equal(back.samples, direct.samples[: len(back.samples)])


def test_units_that_differ_are_converted_by_a_transformation_that_comes_back(loop: Path) -> None:
    spoilt = fmus.description("motor").replace(
        '<ScalarVariable name="voltage" valueReference="2" causality="input"><Real unit="V"',
        '<ScalarVariable name="voltage" valueReference="2" causality="input"><Real unit="mV"',
    )
    fmus.write(Path("motor.fmu"), spoilt, fmus.library())
    printed("export", loop.name, "--ssp", "loop.ssp")
    root = validate(Path("loop.ssp"))
    (transformation,) = root.iter("{*}LinearTransformation")
    assert float(transformation.get("factor")) == 1000.0
    assert transformation.getparent().get("suppressUnitConversion") == "true"
    assert np.array_equal(orchestration.run("loop.ssp").samples, orchestration.run(loop.name).samples)
    printed("export", loop.name, "--container", "loop.fmu")
    result = fmpy.simulate_fmu("loop.fmu", stop_time=2.0, output_interval=0.1, output=["motor.speed"])
    assert np.array_equal(result["motor.speed"], orchestration.run(loop.name)["motor.speed"])


def test_options_change_an_archive_s_run_as_they_change_a_scenario_s(loop: Path) -> None:
    printed("export", loop.name, "--ssp", "loop.ssp", "--step", "20 ms")
    printed("loop.ssp", "--duration", 1, "--set", "motor.speed0=0.5", "--out", "there")
    manifest = json.loads(Path("there/manifest.json").read_text())
    assert (manifest["steps"], manifest["scenario"]["step"]) == (50, 0.02)
    assert np.isclose(orchestration.run("loop.ssp", {"motor.speed0": 0.5})["motor.speed"][0], 0.5)


# ---------------------------------------------------------------- what others can do

ONLY_OURS: dict[str, tuple[Callable[[str], str], str]] = {
    "a delay of more than the order of the steps makes": (
        lambda text: LOOPS["in parallel"](LOOPS["with a delay"](text)),
        "delays: a parallel exchange delays what goes through an FMU by one more step; remedy: exchange: sequential",
    ),
    "a rate": (
        LOOPS["at another rate"],
        "loop.yaml:12: blocks.regulator.every: other tools step all blocks at one rate, and its FMU has no parameter "
        "sample_period",
    ),
}


@pytest.mark.parametrize("change", ONLY_OURS)
def test_what_other_tools_would_pass_over_is_refused_and_kept_on_demand(loop: Path, change: str) -> None:
    changed, message = ONLY_OURS[change]
    loop.write_text(changed(loop.read_text()))
    output = printed("export", loop.name, "--ssp", "loop.ssp", status=2)
    assert message in output
    assert "--for-orchestrate keeps it in an annotation, which no other tool reads" in output
    assert not Path("loop.ssp").exists()
    printed("export", loop.name, "--ssp", "loop.ssp", "--for-orchestrate")
    direct, back = orchestration.run(loop.name), orchestration.run("loop.ssp")
    assert np.array_equal(back.samples, direct.samples)
    assert back.scenario.faults == direct.scenario.faults


def test_both_annotations_stand_in_the_system_openmodelica_s_first_and_none_at_the_root(loop: Path) -> None:
    printed("export", loop.name, "--ssp", "loop.ssp")
    root = validate(Path("loop.ssp"))
    assert root.find("{*}Annotations") is None
    types = [entry.get("type") for entry in root.iterfind("{*}System/{*}Annotations/{*}Annotation")]
    assert types == ["org.openmodelica", "orchestrate.scenario"]
    (master,) = root.iterfind("{*}System/{*}Annotations/{*}Annotation/{*}Annotations/{*}SimulationInformation/*")
    assert (etree.QName(master).localname, master.get("stepSize")) == ("FixedStepMaster", "0.1")


def test_an_export_says_whose_code_it_runs_and_what_the_archive_does_not_carry(loop: Path) -> None:
    loop.write_text(loop.read_text().replace("duration:", "isolation: process\nduration:"))
    output = printed("export", loop.name, "--ssp", "loop.ssp")
    assert "note: runs the FMUs of others for one step, for the values at t = 0: motor, regulator" in output
    assert "note: the archive does not carry isolation: who runs it decides that" in output
    assert "isolation" not in load("loop.ssp").source.data


# ---------------------------------------------------------------- containers


def test_a_container_is_valid_says_units_and_items_and_runs_the_loop_as_we_do(loop: Path) -> None:
    printed("export", loop.name, "--container", "loop.fmu")
    assert validate_fmu("loop.fmu") == []
    about = fmpy.read_model_description("loop.fmu")
    variables = {v.name: v for v in about.modelVariables}
    assert (about.modelName, about.author) == ("loop", None)
    experiment = about.defaultExperiment
    assert [float(x) for x in (experiment.startTime, experiment.stopTime, experiment.stepSize)] == [0.0, 2.0, 0.1]
    assert variables["motor.speed"].unit == "rad/s"
    assert [(i.name, i.value) for i in variables["motor.mode"].declaredType.items] == [("normal", "1"), ("brake", "2")]
    assert (variables["motor.inertia"].min, variables["motor.inertia"].max) == ("0.001", "10")
    assert variables["motor.speed0"].start == "2.0"
    result = fmpy.simulate_fmu(
        "loop.fmu", stop_time=2.0, output_interval=0.1, output=["motor.speed"], start_values={"motor.speed0": 1.5}
    )
    direct = orchestration.run(loop.name, {"motor.speed0": 1.5})
    assert np.array_equal(result["motor.speed"], direct["motor.speed"])


def test_a_delay_that_the_order_of_the_steps_makes_is_exported_as_a_connection(loop: Path) -> None:
    loop.write_text(LOOPS["with a delay"](loop.read_text()))
    printed("export", loop.name, "--container", "loop.fmu", "--ssp", "loop.ssp")
    result = fmpy.simulate_fmu("loop.fmu", stop_time=2.0, output_interval=0.1, output=["motor.speed"])
    assert np.array_equal(result["motor.speed"], orchestration.run(loop.name)["motor.speed"])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            "at another rate",
            "loop.yaml:12: blocks.regulator.every: other tools step all blocks at one rate, and its FMU has no "
            "parameter sample_period; remedy: no 'every', and the slowest block's step for all",
        ),
    ],
)
def test_what_a_container_cannot_do_is_refused(loop: Path, change: str, message: str) -> None:
    loop.write_text(LOOPS[change](loop.read_text()))
    assert message in printed("export", loop.name, "--container", "loop.fmu", status=2)


def test_a_container_holds_no_two_instances_of_an_fmu_that_can_have_one_in_a_process(loop: Path) -> None:
    xml = fmus.description("motor").replace("<CoSimulation", '<CoSimulation canBeInstantiatedOnlyOncePerProcess="true"')
    fmus.write(loop.with_name("motor.fmu"), xml, fmus.library())
    printed("export", loop.name, "--container", "loop.fmu")
    loop.write_text(
        loop.read_text().replace("connections:", "  twin: {fmu: motor.fmu, start: {voltage: 0}}\nconnections:")
    )
    told = printed("export", loop.name, "--container", "loop.fmu", status=2)
    assert "blocks.twin.fmu: its FMU, which is that of motor, too, can have one instance in a process" in told


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "expected --ssp FILE.ssp or --container FILE.fmu, or both"),
        (["--ssp", "loop.zip"], "loop.zip: expected a name that ends in .ssp"),
        (["--ssp", "nowhere/loop.ssp"], "nowhere/loop.ssp: there is no folder nowhere"),
        (["--ssp", "loop.ssp", "--step", "0 s"], "--step 0 s"),
    ],
)  # fmt: skip
def test_wrong_options_are_told(loop: Path, arguments: list[str], message: str) -> None:
    assert message in printed("export", loop.name, *arguments, status=2)


def test_a_failing_block_cannot_be_exported(loop: Path) -> None:
    loop.write_text(loop.read_text().replace("inertia: 0.5", "inertia: 0.5\n      fault: 1"))
    assert "motor: fmi2DoStep" in printed("export", loop.name, "--ssp", "loop.ssp", status=3)
    assert not Path("loop.ssp").exists()
