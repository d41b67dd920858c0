"""The system as a file: SSP archives written and read, ours and others', and container FMUs.

Over 250 lines, since most are tables of what is refused, all made by the same few helpers.
"""

from __future__ import annotations

import json
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

import orchestration
from orchestration import load
from orchestration.ssp import structure
from tests.commands import orchestrate

from ..orchestration import fmus
from ..orchestration.wrong_inputs import SCENARIO

pytestmark = pytest.mark.thorough

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


def printed(*arguments: object, status: int = 0) -> str:
    """What a command prints that ends with this status."""
    result = orchestrate(*arguments)
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
    assert "a container passes values as they are, and these units differ" in printed(
        "export", loop.name, "--container", "loop.fmu", status=2
    )


def test_options_change_an_archive_s_run_as_they_change_a_scenario_s(loop: Path) -> None:
    printed("export", loop.name, "--ssp", "loop.ssp", "--step", "20 ms")
    printed("loop.ssp", "--duration", 1, "--set", "motor.speed0=0.5", "--out", "there")
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
        (lambda: foreign('<ssc:BooleanMappingTransformation><ssc:MapEntry source="true" target="false"/></ssc:BooleanMappingTransformation>'), "control.seen is fed through a BooleanMappingTransformation"),
        (lambda: foreign(values='<ssv:Parameter name="motor 1.spead0"><ssv:Real value="1"/></ssv:Parameter>'), "motor 1 has no variable 'spead0'; did you mean 'speed0'"),
        (lambda: foreign(system=_SYSTEM.replace("resources/motor.fmu", "../motor.fmu")), "refers to '../motor.fmu', which it does not hold"),
        (lambda: foreign(system=_SYSTEM.replace("resources/motor.fmu", "resources/nothing.fmu")), "refers to 'resources/nothing.fmu'"),
        (lambda: foreign(system='<ssd:System name="all"/>'), "the system has no components"),
        (lambda: foreign(system="<ssd:System"), "SystemStructure.ssd cannot be read"),
        (lambda: foreign(system=_SYSTEM.replace('name="regulator" source', 'name="regulator" type="application/x-ssp-package" source')), "control.regulator is a component that is no FMU"),
        (lambda: Path("foreign.ssp").write_bytes(b"PK"), "is a damaged or truncated zip archive"),
        (lambda: Path("foreign.ssp").write_bytes(Path("motor.fmu").read_bytes()), "is no SSP archive: it holds no SystemStructure.ssd"),
        (lambda: foreign(top=EXPERIMENT), "'step' is missing"),
    ],
)  # fmt: skip
def test_what_cannot_be_run_is_refused_by_name(loop: Path, spoil: Callable[[], object], message: str) -> None:
    spoil()
    output = printed("foreign.ssp", status=2)
    assert output.startswith("foreign.ssp")
    assert message in output
    assert "Traceback" not in output


_BINDING = "<ssd:ParameterBindings><ssd:ParameterBinding %s</ssd:ParameterBinding></ssd:ParameterBindings>"
_SCALED = "<ssc:LinearTransformation factor=%s/>"


def _connected(old: str, new: str) -> Callable[[], None]:
    assert old in _SYSTEM
    return lambda: foreign(system=_SYSTEM.replace(old, new), top=EXPERIMENT)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (_connected('startElement="motor 1"', 'startElement="motor1"'), "motor1.speed -> control.seen: the system has no element 'motor1'; did you mean 'motor 1'?"),
        (_connected('startElement="regulator" startConnector="speed"', 'startElement="regulator" startConnector="spead"'), "regulator has no connector 'spead'; did you mean 'speed'?"),
        (_connected('startConnector="voltage" endConnector="given"', 'startConnector="speed" endConnector="given"'), "both take a value"),
        (_connected("</ssd:Connections></ssd:System>", '<ssd:Connection startElement="regulator" startConnector="speed" endConnector="seen"/></ssd:Connections></ssd:System>'), "control.regulator.speed is fed already, by control.seen"),
        (_connected(_REGULATOR, _REGULATOR * 2), "there are two elements control.regulator; expected each name once"),
        (_connected(_connector("seen", "input"), _connector("seen", "input") * 2), "there are two connectors control.seen"),
        (lambda: foreign(_SCALED % '"nan"'), "attribute 'factor': 'nan' is not a valid value"),
        (lambda: foreign(_SCALED % '"NaN"'), "the factor nan and the offset 0; expected finite numbers"),
        (lambda: foreign(values='<ssv:Parameter name="motor 1.cooled"><ssv:Boolean value="maybe"/></ssv:Parameter>'), "a parameter set of the system is not valid by the schema of SSP 1.0:\n  line 1: Element"),
        (lambda: foreign(values='<ssv:Parameter name="motor 1.speed0"><ssv:Real value="fast"/></ssv:Parameter>'), "'fast' is not a valid value of the atomic type 'xs:double'"),
        (lambda: foreign(system=_SYSTEM % (_BINDING % 'type="text/csv">', "")), "given parameters of the type 'text/csv'"),
        (_connected("resources/motor.fmu", "resources/%%00.fmu"), "refers to 'resources/%00.fmu', which it does not hold"),
        (lambda: foreign(values='<ssv:Parameter name="motor 1.speed0"><ssv:Real value="1" unit="deg/s"/></ssv:Parameter>'), "foreign.ssp: the value '1' of motor 1.speed0: the unit 'deg/s' does not fit 'rad/s'"),
        (lambda: foreign(values='<ssv:Parameter name="motor 1.mode"><ssv:Real value="INF"/></ssv:Parameter>'), "foreign.ssp: the value 'INF' of motor 1.mode: cannot convert float infinity to integer"),
        (lambda: foreign(system=_SYSTEM.replace(_REGULATOR, _deep(200))), "SystemStructure.ssd cannot be read: Excessive depth"),
    ],
)  # fmt: skip
def test_what_is_misspelt_or_twice_is_refused_and_never_dropped(
    loop: Path, spoil: Callable[[], object], message: str
) -> None:
    spoil()
    assert message in printed("foreign.ssp", status=2)


def _deep(levels: int) -> str:
    return '<ssd:System name="s"><ssd:Elements>' * levels + "</ssd:Elements></ssd:System>" * levels


def test_offsets_and_factors_across_nested_systems_are_composed_from_the_inside_out(tmp_path: Path) -> None:
    """T = 2 (3 S + 5) + 7, as the matrices of the two affine maps multiply; the wrong order would give 3 (2 S + 7) +
    5."""
    inner = f"""<ssd:System name="outer"><ssd:Connectors>{_connector("a", "input")}</ssd:Connectors><ssd:Elements>
{_component("regulator", _connector("speed", "input"))}</ssd:Elements><ssd:Connections><ssd:Connection startConnector="a"
endElement="regulator" endConnector="speed"><ssc:LinearTransformation factor="2" offset="7"/></ssd:Connection></ssd:Connections></ssd:System>"""
    system = f"""<ssd:System {_NAMES} name="all"><ssd:Elements>{_MOTOR}{inner}</ssd:Elements><ssd:Connections><ssd:Connection startElement="motor 1"
startConnector="speed" endElement="outer" endConnector="a"><ssc:LinearTransformation factor="3" offset="5"/></ssd:Connection></ssd:Connections></ssd:System>"""
    read = structure.read(tmp_path, tmp_path, etree.fromstring(system))
    feed = read.source(structure.End(("outer", "regulator"), "speed"))
    composed = np.array([[2.0, 7.0], [0.0, 1.0]]) @ np.array([[3.0, 5.0], [0.0, 1.0]])
    assert feed == (structure.End(("motor 1",), "speed"), composed[0, 0], composed[0, 1], False)


def test_a_signal_that_is_fed_in_a_circle_is_refused(loop: Path) -> None:
    circle = f"""<ssd:System name="c"><ssd:Connectors>{_connector("a", "input")}{_connector("b", "output")}</ssd:Connectors>
<ssd:Connections><ssd:Connection startConnector="a" endConnector="b"/></ssd:Connections></ssd:System>"""
    foreign(system=f"""<ssd:System name="all"><ssd:Elements>{_MOTOR}{circle}</ssd:Elements><ssd:Connections>
<ssd:Connection startElement="c" startConnector="b" endElement="c" endConnector="a"/>
<ssd:Connection startElement="c" startConnector="b" endElement="motor 1" endConnector="voltage"/></ssd:Connections></ssd:System>""")  # fmt: skip
    assert "foreign.ssp: motor 1.voltage is fed in a circle" in printed("foreign.ssp", status=2)


def _annotated(data: object) -> str:
    text = data if isinstance(data, str) else json.dumps(data)
    return f'{EXPERIMENT}<ssd:Annotations><ssc:Annotation type="orchestrate.scenario"><scenario>{text}</scenario></ssc:Annotation></ssd:Annotations>'


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"isolation": "none"}, "the annotation orchestrate.scenario says 'isolation', which an archive does not decide"),
        ({"blocks": {"motor_1": {"isolation": "none"}}}, "blocks.motor_1 says 'isolation', which an archive does not decide"),
        ({"blocks": {"motor_1": {"timeout": 1e9}}}, "blocks.motor_1 says 'timeout'"),
        ({"blocks": {"motor_1": {"map": "/etc/passwd"}}}, "blocks.motor_1 says 'map'"),
        ({"blocks": {"motor_1": {"fmu": "/tmp/other.fmu"}}}, "blocks.motor_1 says 'fmu'"),
        ({"blocks": {"motor_1": {"interface": "/tmp/other.fmu"}}}, "blocks.motor_1 says 'interface'"),
        ({"blocks": {"motor_1": {"validation": "lenient"}}}, "blocks.motor_1 says 'validation'"),
        ({"flavour": "python"}, "says 'flavour'"),
        ({"blocks": {"motor_2": {}}}, "the archive has no component 'motor_2'; did you mean 'motor_1'?"),
        ({"blocks": ["motor_1"]}, "blocks: expected names with values, found a list"),
        ({"blocks": {"motor_1": 3}}, "blocks.motor_1: expected names with values, found 3"),
        (["step"], "expected names with values, found a list"),
        ("{", "the annotation orchestrate.scenario cannot be read"),
        ("[" * 100_000, "the annotation orchestrate.scenario cannot be read"),
        ({"step": {"a": 1}}, "step: expected a number"),
        ({"expect": 3}, "expect: expected a list, found 3"),
        ({"record": []}, "record: expected names with values, found a list"),
    ],
)  # fmt: skip
def test_an_annotation_decides_neither_over_guards_nor_over_files(loop: Path, data: object, message: str) -> None:
    foreign(top=_annotated(data))
    assert message in printed("foreign.ssp", status=2)


def test_an_archive_is_held_to_the_bounds_of_an_fmu(loop: Path) -> None:
    foreign(top=EXPERIMENT)
    data = bytearray(Path("foreign.ssp").read_bytes())
    at = data.rindex(b"PK\x01\x02")
    struct.pack_into("<H", data, at + 8, 1)
    Path("foreign.ssp").write_bytes(data)
    assert "foreign.ssp is encrypted: resources/regulator.fmu" in printed("foreign.ssp", status=2)
    struct.pack_into("<H", data, at + 8, 0)
    struct.pack_into("<I", data, at + 24, 3 * 10**9)
    Path("foreign.ssp").write_bytes(data)
    assert "foreign.ssp would unpack to 3 GB; expected at most 2 GB" in printed("foreign.ssp", status=2)


def test_an_archive_that_is_not_there_is_told(loop: Path) -> None:
    assert "nothing.ssp" in printed("nothing.ssp", status=2)


# ---------------------------------------------------------------- what others can do

ONLY_OURS: dict[str, tuple[Callable[[str], str], str]] = {
    "a delay": (LOOPS["with a delay"], "has no delays of single connections"),
    "a rate": (LOOPS["at another rate"], "loop.yaml:12: blocks.regulator.every: SSP steps all its blocks at one rate; expected 1"),
    "a fault": (lambda text: text.replace("record:", "faults: [{at: 1 s, freeze: motor.speed}]\nrecord:"), "faults: SSP has no faults"),
}  # fmt: skip


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


@pytest.mark.parametrize("scenario", ["flight_tumble", "fault_lost_magnetometer"])
def test_the_scenarios_with_rates_and_faults_are_refused(scenario: str, tmp_path: Path) -> None:
    for option, name in (("--ssp", "x.ssp"), ("--container", "x.fmu")):
        printed("export", ROOT / "scenarios" / f"{scenario}.yaml", option, tmp_path / name, status=2)


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


def test_without_the_toolbox_the_remedy_is_told(loop: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "fmu_manipulation_toolbox.assembly", None)
    output = printed("export", loop.name, "--container", "loop.fmu", status=2)
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
    assert message in printed("export", loop.name, *arguments, status=2)


def test_a_failing_block_cannot_be_exported(loop: Path) -> None:
    loop.write_text(loop.read_text().replace("inertia: 0.5", "inertia: 0.5\n      fault: 1"))
    assert "motor: fmi2DoStep" in printed("export", loop.name, "--ssp", "loop.ssp", status=3)
    assert not Path("loop.ssp").exists()
