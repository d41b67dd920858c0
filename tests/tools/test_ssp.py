"""The system as a file: SSP archives written and read, ours and others', and container FMUs."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from click.testing import CliRunner
from fmpy.validation import validate_fmu
from lxml import etree

import orchestration
from orchestration import load
from orchestration.cli.main import main

from ..orchestration import fmus
from ..orchestration.wrong_inputs import SCENARIO

ROOT = Path(__file__).parents[2]
SCENARIOS = sorted((ROOT / "scenarios").glob("paper*.yaml"))
SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"


@pytest.fixture
def loop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A scenario of two real FMUs, dx/dt = u and u = -x, in a folder of its own."""
    fmus.write_pair(tmp_path)
    path = tmp_path / "loop.yaml"
    path.write_text(SCENARIO, "utf-8")
    monkeypatch.chdir(tmp_path)
    return path


def orchestrate(*arguments: object, status: int = 0) -> str:
    result = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert result.exit_code == status, result.output
    return result.output


def validate(path: Path) -> etree._Element:
    """Every file of an archive against the schemas of SSP 1.0; returns the structure."""
    with zipfile.ZipFile(path) as archive:
        found = {}
        for name in archive.namelist():
            kind = {".ssd": "Description", ".ssv": "ParameterValues"}.get(Path(name).suffix)
            if kind:
                found[name] = etree.fromstring(archive.read(name))
                etree.XMLSchema(etree.parse(SCHEMAS / f"SystemStructure{kind}.xsd")).assertValid(found[name])
    return found["SystemStructure.ssd"]


@pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda p: p.stem)
def test_a_scenario_comes_back_from_its_archive_and_gives_the_same_bits(scenario: Path, tmp_path: Path) -> None:
    archive = tmp_path / "adcs.ssp"
    orchestrate("export", scenario, "--ssp", archive)
    validate(archive)
    direct, back = orchestration.run(scenario), orchestration.run(archive)
    assert back.labels == direct.labels
    assert np.array_equal(back.samples, direct.samples)
    assert [(o.name, o.passed) for o in back.outcomes] == [(o.name, o.passed) for o in direct.outcomes]
    assert back.scenario.figures == direct.scenario.figures
    assert back.warnings == []


def test_the_same_scenario_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one.ssp", "two.ssp"):
        orchestrate("export", SCENARIOS[0], "--ssp", tmp_path / name)
    assert (tmp_path / "one.ssp").read_bytes() == (tmp_path / "two.ssp").read_bytes()


def test_every_connected_input_has_the_value_that_comes_to_it_at_the_start(tmp_path: Path) -> None:
    orchestrate("export", SCENARIOS[0], "--ssp", tmp_path / "adcs.ssp")
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
    orchestrate("export", loop.name, "--ssp", "loop.ssp")
    validate(Path("loop.ssp"))
    direct, back = orchestration.run(loop.name), orchestration.run("loop.ssp")
    assert back.labels == direct.labels
    assert np.array_equal(back.samples, direct.samples)


def test_units_that_differ_are_converted_by_a_transformation_that_comes_back(loop: Path) -> None:
    spoilt = fmus.description("motor").replace(
        '<ScalarVariable name="voltage" valueReference="2" causality="input"><Real unit="V"',
        '<ScalarVariable name="voltage" valueReference="2" causality="input"><Real unit="mV"',
    )
    fmus.write(Path("motor.fmu"), spoilt, fmus.library())
    orchestrate("export", loop.name, "--ssp", "loop.ssp")
    root = validate(Path("loop.ssp"))
    (transformation,) = root.iter("{*}LinearTransformation")
    assert float(transformation.get("factor")) == 1000.0
    assert transformation.getparent().get("suppressUnitConversion") == "true"
    assert np.array_equal(orchestration.run("loop.ssp").samples, orchestration.run(loop.name).samples)
    assert "a container passes values as they are, and these units differ" in orchestrate(
        "export", loop.name, "--container", "loop.fmu", status=2
    )


def test_options_change_an_archive_s_run_as_they_change_a_scenario_s(loop: Path) -> None:
    orchestrate("export", loop.name, "--ssp", "loop.ssp", "--step", "20 ms")
    orchestrate("loop.ssp", "--duration", 1, "--set", "motor.speed0=0.5", "--out", "there")
    manifest = json.loads(Path("there/manifest.json").read_text())
    assert (manifest["steps"], manifest["scenario"]["step"]) == (50, 0.02)
    assert np.isclose(orchestration.run("loop.ssp", {"motor.speed0": 0.5})["motor.speed"][0], 0.5)


# ---------------------------------------------------------------- archives of others

_NAMES = " ".join(
    f'xmlns:{p}="http://ssp-standard.org/SSP1/SystemStructure{n}"'
    for p, n in (("ssd", "Description"), ("ssc", "Common"), ("ssv", "ParameterValues"), ("ssm", "ParameterMapping"))
)


def _component(name: str, connectors: str, more: str = "") -> str:
    return (
        f'<ssd:Component name="{name}" source="resources/{name.partition(" ")[0]}.fmu"><ssd:Connectors>{connectors}'
        f"</ssd:Connectors>{more}</ssd:Component>"
    )


def _connector(name: str, kind: str) -> str:
    return f'<ssd:Connector name="{name}" kind="{kind}"><ssc:Real/></ssd:Connector>'


def _parameters(text: str) -> str:
    return f'<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues><ssv:ParameterSet version="1.0" name="p"><ssv:Parameters>{text}</ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues>%s</ssd:ParameterBinding></ssd:ParameterBindings>'


_MOTOR = _component("motor 1", _connector("voltage", "input") + _connector("speed", "output"))
_REGULATOR = _component("regulator", _connector("speed", "input") + _connector("voltage", "output"))
# The regulator stands in a system of its own, and the connection to it is told from its end.
_NESTED = f"""<ssd:System name="control"><ssd:Connectors>{_connector("seen", "input")}{_connector("given", "output")}</ssd:Connectors>
<ssd:Elements>{_REGULATOR}</ssd:Elements><ssd:Connections>
<ssd:Connection startElement="regulator" startConnector="speed" endConnector="seen"/>
<ssd:Connection startElement="regulator" startConnector="voltage" endConnector="given"/></ssd:Connections></ssd:System>"""
_SYSTEM = f"""<ssd:System name="all">%s<ssd:Elements>{_MOTOR}{_NESTED}</ssd:Elements><ssd:Connections>
<ssd:Connection startElement="motor 1" startConnector="speed" endElement="control" endConnector="seen">%s</ssd:Connection>
<ssd:Connection startElement="control" startConnector="given" endElement="motor 1" endConnector="voltage"/></ssd:Connections></ssd:System>"""
_VALUES = (
    '<ssv:Parameter name="motor 1.speed0"><ssv:Real value="2"/></ssv:Parameter>'
    '<ssv:Parameter name="motor 1.inertia"><ssv:Real value="0.5"/></ssv:Parameter>'
    '<ssv:Parameter name="motor 1.mode"><ssv:Integer value="2"/></ssv:Parameter>'
    '<ssv:Parameter name="control.regulator.gain"><ssv:Real value="-1"/></ssv:Parameter>'
    '<ssv:Parameter name="nobody.knows"><ssv:Real value="0.5"/></ssv:Parameter>'
)


def foreign(
    transformation: str = "", values: str = _VALUES, mapping: str = "", system: str = _SYSTEM, top: str = ""
) -> None:
    """Writes foreign.ssp into the current folder, which holds the FMUs."""
    inner = system % (_parameters(values) % mapping, transformation) if "%s" in system else system
    xml = f'<?xml version="1.0"?><ssd:SystemStructureDescription {_NAMES} version="1.0" name="a foreign one">{inner}{top}</ssd:SystemStructureDescription>'
    with zipfile.ZipFile("foreign.ssp", "w") as archive:
        archive.writestr("SystemStructure.ssd", xml)
        for name in ("motor", "regulator"):
            archive.write(f"{name}.fmu", f"resources/{name}.fmu")


EXPERIMENT = '<ssd:DefaultExperiment startTime="0" stopTime="2"/>'


def test_an_archive_of_systems_within_systems_runs(loop: Path) -> None:
    foreign(top=EXPERIMENT)
    validate(Path("foreign.ssp"))
    loop.write_text(loop.read_text().replace("inertia: 0.5", "inertia: 0.5\n      mode: brake"))
    source = load(loop.name).source.without([("expect",)])
    direct = orchestration.run(load(source))
    result = orchestration.run("foreign.ssp", {"step": 0.1})
    assert (result.scenario.name, list(result.models)) == ("a_foreign_one", ["motor_1", "control_regulator"])
    assert np.array_equal(result["motor_1.speed"], direct["motor.speed"])
    assert result.scenario.blocks["motor_1"].start["mode"] == "brake"


def test_values_are_mapped_and_converted(loop: Path) -> None:
    mapping = '<ssd:ParameterMapping><ssm:ParameterMapping version="1.0"><ssm:MappingEntry source="spin" target="motor 1.speed0"/></ssm:ParameterMapping></ssd:ParameterMapping>'
    foreign(values='<ssv:Parameter name="spin"><ssv:Real value="30"/></ssv:Parameter>', mapping=mapping, top=EXPERIMENT)
    assert orchestration.run("foreign.ssp", {"step": 0.1})["motor_1.speed"][0] == 30.0
    units = '</ssv:Parameters><ssv:Units><ssc:Unit name="turns"><ssc:BaseUnit s="-1" rad="1" factor="6.283185307179586"/></ssc:Unit></ssv:Units>'
    given = _parameters('<ssv:Parameter name="motor 1.speed0"><ssv:Real value="2" unit="turns"/></ssv:Parameter>') % ""
    inner = _SYSTEM % (given.replace("</ssv:Parameters>", units), "")
    foreign(system=inner, top=EXPERIMENT)
    assert np.isclose(orchestration.run("foreign.ssp", {"step": 0.1})["motor_1.speed"][0], 4 * np.pi)


def test_an_input_that_nothing_feeds_keeps_the_fmu_s_start(loop: Path) -> None:
    foreign(top=EXPERIMENT)
    assert orchestration.run("foreign.ssp", {"step": 0.1}).scenario.blocks["control_regulator"].start["enabled"] is True


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda: foreign('<ssc:LinearTransformation factor="2"/>'), "factor 2 and the offset 0, which is no conversion of its units"),
        (lambda: foreign("<ssc:BooleanMappingTransformation/>"), "control.seen is fed through a BooleanMappingTransformation"),
        (lambda: foreign(values='<ssv:Parameter name="motor 1.spead0"><ssv:Real value="1"/></ssv:Parameter>'), "motor 1 has no variable 'spead0'; did you mean 'speed0'"),
        (lambda: foreign(system=_SYSTEM.replace("resources/motor.fmu", "../motor.fmu")), "refers to '../motor.fmu', which it does not hold"),
        (lambda: foreign(system=_SYSTEM.replace("resources/motor.fmu", "resources/nothing.fmu")), "refers to 'resources/nothing.fmu'"),
        (lambda: foreign(system='<ssd:System name="all"/>'), "the system has no components"),
        (lambda: foreign(system="<ssd:System"), "SystemStructure.ssd cannot be read"),
        (lambda: foreign(system=_SYSTEM.replace('name="regulator" source', 'name="regulator" type="application/x-ssp-package" source')), "control.regulator is a component that is no FMU"),
        (lambda: Path("foreign.ssp").write_bytes(b"PK"), "is no SSP archive, or a damaged one"),
        (lambda: Path("foreign.ssp").write_bytes(Path("motor.fmu").read_bytes()), "is no SSP archive: it holds no SystemStructure.ssd"),
        (lambda: foreign(top=EXPERIMENT), "'step' is missing"),
    ],
)  # fmt: skip
def test_what_cannot_be_run_is_refused_by_name(loop: Path, spoil: Callable[[], object], message: str) -> None:
    spoil()
    output = orchestrate("foreign.ssp", status=2)
    assert output.startswith("foreign.ssp")
    assert message in output
    assert "Traceback" not in output


def test_an_archive_that_is_not_there_is_told(loop: Path) -> None:
    assert "nothing.ssp" in orchestrate("nothing.ssp", status=2)


# ---------------------------------------------------------------- containers


def test_a_container_is_valid_says_units_and_items_and_runs_the_loop_as_we_do(loop: Path) -> None:
    orchestrate("export", loop.name, "--container", "loop.fmu")
    assert validate_fmu("loop.fmu") == []
    about = fmpy.read_model_description("loop.fmu")
    variables = {v.name: v for v in about.modelVariables}
    assert (about.modelName, about.author) == ("loop", None)
    assert variables["motor.speed"].unit == "rad/s"
    assert variables["motor.mode"].description.endswith("(1: normal, 2: brake)")
    assert variables["motor.speed0"].start == "2.0"
    result = fmpy.simulate_fmu(
        "loop.fmu", stop_time=2.0, output_interval=0.1, output=["motor.speed"], start_values={"motor.speed0": 1.5}
    )
    direct = orchestration.run(loop.name, {"motor.speed0": 1.5})
    assert np.array_equal(result["motor.speed"], direct["motor.speed"])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("with a delay", "a container has no delays of single connections"),
        (
            "at another rate",
            "loop.yaml:12: blocks.regulator.every: a container steps all its blocks at one rate; expected 1 "
            "(remedy: no 'every', and the slowest block's step for all)",
        ),
    ],
)
def test_what_a_container_cannot_do_is_refused(loop: Path, change: str, message: str) -> None:
    loop.write_text(LOOPS[change](loop.read_text()))
    assert message in orchestrate("export", loop.name, "--container", "loop.fmu", status=2)


def test_without_the_toolbox_the_remedy_is_told(loop: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "fmu_manipulation_toolbox.assembly", None)
    output = orchestrate("export", loop.name, "--container", "loop.fmu", status=2)
    assert "pip install fmu-manipulation-toolbox" in output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "expected --ssp FILE.ssp or --container FILE.fmu, or both"),
        (["--ssp", "loop.zip"], "loop.zip: expected a name that ends in .ssp"),
        (["--ssp", "nowhere/loop.ssp"], "nowhere/loop.ssp: there is no folder nowhere"),
        (["--ssp", "loop.ssp", "--step", "0 s"], "--step 0 s"),
    ],
)
def test_wrong_options_are_told(loop: Path, arguments: list[str], message: str) -> None:
    assert message in orchestrate("export", loop.name, *arguments, status=2)


def test_a_failing_block_cannot_be_exported(loop: Path) -> None:
    loop.write_text(loop.read_text().replace("inertia: 0.5", "inertia: 0.5\n      fault: 1"))
    assert "motor: fmi2DoStep" in orchestrate("export", loop.name, "--ssp", "loop.ssp", status=3)
    assert not Path("loop.ssp").exists()
