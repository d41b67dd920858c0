"""SSP archives of others: systems within systems, mapped and converted values, and what is refused by name."""

from __future__ import annotations

import json
import struct
import zipfile
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

import orchestration
from orchestration import InputError, load
from orchestration.ssp import structure

from ..orchestration import fmus
from .archives import printed, validate

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


def _value(name: str, kind: str, value: object, more: str = "") -> str:
    return f'<ssv:Parameter name="{name}"><ssv:{kind} value="{value}"{more}/></ssv:Parameter>'


def _parameters(text: str) -> str:
    values = f'<ssv:ParameterSet version="1.0" name="p"><ssv:Parameters>{text}</ssv:Parameters></ssv:ParameterSet>'
    binding = f"<ssd:ParameterBinding><ssd:ParameterValues>{values}</ssd:ParameterValues>%s</ssd:ParameterBinding>"
    return f"<ssd:ParameterBindings>{binding}</ssd:ParameterBindings>"


def _connection(start: str, end: str, inner: str = "") -> str:
    """From one "element.connector" to another; a connector alone is the system's own."""
    ends = []
    for which, place in (("start", start), ("end", end)):
        element, _, connector = place.rpartition(".")
        ends += [f'{which}Element="{element}"'] * bool(element) + [f'{which}Connector="{connector}"']
    return f"<ssd:Connection {' '.join(ends)}" + (f">{inner}</ssd:Connection>" if inner else "/>")


def _system(head: str, connectors: str, elements: str, *connections: str) -> str:
    return (
        f"<ssd:System {head}>{connectors and f'<ssd:Connectors>{connectors}</ssd:Connectors>'}"
        f"{elements and f'<ssd:Elements>{elements}</ssd:Elements>'}"
        f"<ssd:Connections>{''.join(connections)}</ssd:Connections></ssd:System>"
    )


_MOTOR = _component("motor 1", _connector("voltage", "input") + _connector("speed", "output"))
_REGULATOR = _component("regulator", _connector("speed", "input") + _connector("voltage", "output"))
# The regulator stands in a system of its own, and the connection to it is told from its end.
_NESTED = _system(
    'name="control"',
    _connector("seen", "input") + _connector("given", "output"),
    _REGULATOR,
    _connection("regulator.speed", "seen"),
    _connection("regulator.voltage", "given"),
)
_SYSTEM = _system(
    'name="all"',
    "",
    _MOTOR + _NESTED,
    _connection("motor 1.speed", "control.seen", "%s"),
    _connection("control.given", "motor 1.voltage"),
).replace("<ssd:Elements>", "%s<ssd:Elements>", 1)
_VALUES = "".join(
    (
        _value("motor 1.speed0", "Real", 2),
        _value("motor 1.inertia", "Real", 0.5),
        _value("motor 1.mode", "Integer", 2),
        _value("control.regulator.gain", "Real", -1),
        _value("nobody.knows", "Real", 0.5),
    )
)


def foreign(
    transformation: str = "", values: str = _VALUES, mapping: str = "", system: str = _SYSTEM, top: str = ""
) -> None:
    """Writes foreign.ssp into the current folder, which holds the FMUs."""
    inner = system % (_parameters(values) % mapping, transformation) if "%s" in system else system
    head = f'<?xml version="1.0"?><ssd:SystemStructureDescription {_NAMES} version="1.0" name="a foreign one">'
    xml = f"{head}{inner}{top}</ssd:SystemStructureDescription>"
    with zipfile.ZipFile("foreign.ssp", "w") as archive:
        archive.writestr("SystemStructure.ssd", xml)
        for name in ("motor", "regulator"):
            archive.write(f"{name}.fmu", f"resources/{name}.fmu")


EXPERIMENT = '<ssd:DefaultExperiment startTime="0" stopTime="2"/>'
_TRUTH = (
    '<ssc:BooleanMappingTransformation><ssc:MapEntry source="true" target="false"/></ssc:BooleanMappingTransformation>'
)
_SOURCE = 'source="resources/regulator.fmu"'


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


def test_an_archive_runs_from_its_start_time_to_its_stop_time(loop: Path) -> None:
    foreign(top='<ssd:DefaultExperiment startTime="3" stopTime="4.5"/>')
    assert orchestration.run("foreign.ssp", {"step": 0.1}).time[-1] == 1.5


def test_the_archive_s_duration_goes_before_those_of_its_fmus(loop: Path) -> None:
    """Also where theirs are longer, and theirs count where the archive has none; its step is the shortest of theirs."""
    for name, stop, step in (("motor", 9, 0.1), ("regulator", 4, 0.5)):
        own = f'<DefaultExperiment stopTime="{stop}" stepSize="{step}"/><ModelVariables>'
        fmus.write(Path(f"{name}.fmu"), fmus.description(name).replace("<ModelVariables>", own), fmus.library())
    foreign(top=EXPERIMENT)
    scenario = load("foreign.ssp")
    assert (scenario.duration, scenario.step) == (2.0, 0.1)
    foreign()
    assert load("foreign.ssp").duration == 9.0


@pytest.mark.parametrize(("most", "refused"), [(3, True), (4, False)])
def test_an_archive_has_as_many_connections_as_are_read(
    loop: Path, monkeypatch: pytest.MonkeyPatch, most: int, refused: bool
) -> None:
    """Two between its systems, and two within one of them."""
    monkeypatch.setattr(structure, "CONNECTIONS_MAX", most)
    foreign(top=EXPERIMENT)
    with pytest.raises(InputError, match="more than 3 connections") if refused else nullcontext():
        load("foreign.ssp", {"step": 0.1})


def test_a_prefix_stands_before_the_names_of_a_binding(loop: Path) -> None:
    text = _value("speed0", "Real", 3)
    bound = _parameters(text).replace("<ssd:ParameterBinding>", '<ssd:ParameterBinding prefix="motor 1.">') % ""
    foreign(system=_SYSTEM % (bound, ""), top=EXPERIMENT)
    assert orchestration.run("foreign.ssp", {"step": 0.1})["motor_1.speed"][0] == 3.0


def test_components_whose_names_become_alike_have_names_of_their_own(loop: Path) -> None:
    ports = _connector("voltage", "input") + _connector("speed", "output")
    motors = "".join(
        _component("motor 1", ports).replace("motor 1", name) for name in ("motor 1", "motor-1", "motor+1", "motor.1")
    )
    fed = _connection("regulator.voltage", "motor+1.voltage")
    foreign(system=_system('name="all"', "", motors + _REGULATOR, fed), top=EXPERIMENT)
    scenario = load("foreign.ssp", {"step": 0.1})
    assert list(scenario.blocks) == ["motor_1", "motor_1_2", "motor_1_3", "motor_1_4", "regulator"]
    assert scenario.connections == ["regulator.voltage -> motor_1_3.voltage"]


def test_a_value_of_an_input_that_is_fed_counts_where_the_archive_has_delays(loop: Path) -> None:
    given = _VALUES + _value("motor 1.voltage", "Real", 4)
    foreign(values=given, top=EXPERIMENT)
    assert "voltage" not in load("foreign.ssp", {"step": 0.1}).blocks["motor_1"].start
    foreign(values=given, top=_annotated({"delays": ["motor_1.voltage"]}))
    assert load("foreign.ssp", {"step": 0.1}).blocks["motor_1"].start["voltage"] == 4.0


def test_a_value_of_the_system_beats_that_of_its_element(loop: Path) -> None:
    own = _component("motor 1", _connector("voltage", "input") + _connector("speed", "output"), _of_motor(7))
    foreign(system=_SYSTEM.replace(_MOTOR, own), top=EXPERIMENT)
    assert orchestration.run("foreign.ssp", {"step": 0.1})["motor_1.speed"][0] == 2.0
    foreign(values=_value("motor 1.inertia", "Real", 0.5), system=_SYSTEM.replace(_MOTOR, own), top=EXPERIMENT)
    assert orchestration.run("foreign.ssp", {"step": 0.1})["motor_1.speed"][0] == 7.0


def _of_motor(speed: float) -> str:
    return _parameters(_value("speed0", "Real", speed)) % ""


def test_values_are_mapped_and_converted(loop: Path) -> None:
    entry = '<ssm:MappingEntry source="spin" target="motor 1.speed0"/>'
    mapping = f'<ssm:ParameterMapping version="1.0">{entry}</ssm:ParameterMapping>'
    mapping = f"<ssd:ParameterMapping>{mapping}</ssd:ParameterMapping>"
    foreign(values=_value("spin", "Real", "30"), mapping=mapping, top=EXPERIMENT)
    assert orchestration.run("foreign.ssp", {"step": 0.1})["motor_1.speed"][0] == 30.0
    unit = '<ssc:BaseUnit s="-1" rad="1" factor="6.283185307179586"/>'
    units = f'</ssv:Parameters><ssv:Units><ssc:Unit name="turns">{unit}</ssc:Unit></ssv:Units>'
    given = _parameters(_value("motor 1.speed0", "Real", "2", ' unit="turns"')) % ""
    inner = _SYSTEM % (given.replace("</ssv:Parameters>", units), "")
    foreign(system=inner, top=EXPERIMENT)
    assert np.isclose(orchestration.run("foreign.ssp", {"step": 0.1})["motor_1.speed"][0], 4 * np.pi)


def test_a_unit_of_a_value_says_nothing_where_its_variable_has_none(loop: Path) -> None:
    foreign(values=_value("control.regulator.gain", "Real", -2, ' unit="V"'), top=EXPERIMENT)
    result = orchestration.run("foreign.ssp", {"step": 0.1})
    assert result.scenario.blocks["control_regulator"].start["gain"] == -2.0


@pytest.mark.parametrize(("factor", "status"), [(1000.0, 0), (1.0, 2), (0.001, 2)])
def test_a_connection_whose_factor_is_that_of_its_units_is_that_of_a_scenario(
    loop: Path, factor: float, status: int
) -> None:
    """From V to mV; the archive says that no other conversion is made."""
    old = 'name="voltage" valueReference="2" causality="input"><Real unit='
    text = fmus.description("motor")
    assert old in text
    fmus.write(Path("motor.fmu"), text.replace(f'{old}"V"', f'{old}"mV"'), fmus.library())
    plain = _connection("control.given", "motor 1.voltage")
    scaled = _connection("control.given", "motor 1.voltage", _SCALED % f'"{factor}"')
    kept = scaled.replace("<ssd:Connection ", '<ssd:Connection suppressUnitConversion="true" ')
    assert plain in _SYSTEM
    foreign(system=_SYSTEM.replace(plain, kept), top=EXPERIMENT)
    output = printed("run", "foreign.ssp", "--step", "0.1 s", "--quiet", status=status)
    assert ("which is no conversion of its units" in output) is (status == 2)


def test_an_input_that_nothing_feeds_keeps_the_fmu_s_start(loop: Path) -> None:
    foreign(top=EXPERIMENT)
    assert orchestration.run("foreign.ssp", {"step": 0.1}).scenario.blocks["control_regulator"].start["enabled"] is True


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda: foreign('<ssc:LinearTransformation factor="2"/>'),
         "factor 2 and the offset 0, which is no conversion of its units"),
        (lambda: foreign(_TRUTH), "control.seen is fed through a BooleanMappingTransformation"),
        (lambda: foreign(values=_value("motor 1.spead0", "Real", "1")),
         "motor 1 has no variable 'spead0'; did you mean 'speed0'"),
        (lambda: foreign(system=_SYSTEM.replace("resources/motor.fmu", "../motor.fmu")),
         "refers to '../motor.fmu', which it does not hold"),
        (lambda: foreign(system=_SYSTEM.replace("resources/motor.fmu", "resources/nothing.fmu")),
         "refers to 'resources/nothing.fmu'"),
        (lambda: foreign(system='<ssd:System name="all"/>'), "the system has no components"),
        (lambda: foreign(system="<ssd:System"), "SystemStructure.ssd cannot be read"),
        (lambda: foreign(system=_SYSTEM.replace(_SOURCE, f'type="application/x-ssp-package" {_SOURCE}')),
         "control.regulator is a component that is no FMU"),
        (lambda: Path("foreign.ssp").write_bytes(b"PK"), "is a damaged or truncated zip archive"),
        (lambda: Path("foreign.ssp").write_bytes(Path("motor.fmu").read_bytes()),
         "is no SSP archive: it holds no SystemStructure.ssd"),
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
_END = "</ssd:Connections></ssd:System>"


def _connected(old: str, new: str) -> Callable[[], None]:
    assert old in _SYSTEM
    return lambda: foreign(system=_SYSTEM.replace(old, new), top=EXPERIMENT)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (_connected('startElement="motor 1"', 'startElement="motor1"'),
         "motor1.speed -> control.seen: the system has no element 'motor1'; did you mean 'motor 1'?"),
        (
            _connected(
                'startElement="regulator" startConnector="speed"', 'startElement="regulator" startConnector="spead"'
            ),
            "regulator has no connector 'spead'; did you mean 'speed'?",
        ),
        (_connected('startConnector="voltage" endConnector="given"', 'startConnector="speed" endConnector="given"'),
         "both take a value"),
        (_connected(_END, _connection("regulator.speed", "seen") + _END),
         "control.regulator.speed is fed already, by control.seen"),
        (_connected(_REGULATOR, _REGULATOR * 2), "there are two elements control.regulator; expected each name once"),
        (_connected(_connector("seen", "input"), _connector("seen", "input") * 2),
         "there are two connectors control.seen"),
        (lambda: foreign(_SCALED % '"nan"'), "attribute 'factor': 'nan' is not a valid value"),
        (lambda: foreign(_SCALED % '"NaN"'), "the factor nan and the offset 0; expected finite numbers"),
        (lambda: foreign(values=_value("motor 1.cooled", "Boolean", "maybe")),
         "a parameter set of the system is not valid by the schema of SSP 1.0:\n  line 1: Element"),
        (lambda: foreign(values=_value("motor 1.speed0", "Real", "fast")),
         "'fast' is not a valid value of the atomic type 'xs:double'"),
        (lambda: foreign(system=_SYSTEM % (_BINDING % 'type="text/csv">', "")),
         "given parameters of the type 'text/csv'"),
        (_connected("resources/motor.fmu", "resources/%%00.fmu"),
         "refers to 'resources/%00.fmu', which it does not hold"),
        (lambda: foreign(values=_value("motor 1.speed0", "Real", "1", ' unit="deg/s"')),
         "foreign.ssp: the value '1' of motor 1.speed0: the unit 'deg/s' does not fit 'rad/s'"),
        (lambda: foreign(values=_value("motor 1.mode", "Real", "INF")),
         "foreign.ssp: the value 'INF' of motor 1.mode: cannot convert float infinity to integer"),
        (lambda: foreign(system=_SYSTEM.replace(_REGULATOR, _deep(200))),
         "SystemStructure.ssd cannot be read: Excessive depth"),
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
    first, then = (f'<ssc:LinearTransformation factor="{a}" offset="{b}"/>' for a, b in ((3, 5), (2, 7)))
    regulator, a = _component("regulator", _connector("speed", "input")), _connector("a", "input")
    inner = _system('name="outer"', a, regulator, _connection("a", "regulator.speed", then))
    between = _connection("motor 1.speed", "outer.a", first)
    system = _system(f'{_NAMES} name="all"', "", _MOTOR + inner, between)
    read = structure.read(tmp_path, tmp_path, etree.fromstring(system))
    feed = read.source(structure.End(("outer", "regulator"), "speed"))
    composed = np.array([[2.0, 7.0], [0.0, 1.0]]) @ np.array([[3.0, 5.0], [0.0, 1.0]])
    assert feed == (structure.End(("motor 1",), "speed"), composed[0, 0], composed[0, 1], False)


def test_a_signal_that_is_fed_in_a_circle_is_refused(loop: Path) -> None:
    ends = _connector("a", "input") + _connector("b", "output")
    circle = _system('name="c"', ends, "", _connection("a", "b"))
    fed = _connection("c.b", "c.a"), _connection("c.b", "motor 1.voltage")
    foreign(system=_system('name="all"', "", _MOTOR + circle, *fed))
    assert "foreign.ssp: motor 1.voltage is fed in a circle" in printed("foreign.ssp", status=2)


def _annotated(data: object) -> str:
    text = data if isinstance(data, str) else json.dumps(data)
    annotation = f'<ssc:Annotation type="orchestrate.scenario"><scenario>{text}</scenario></ssc:Annotation>'
    return f"{EXPERIMENT}<ssd:Annotations>{annotation}</ssd:Annotations>"


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"isolation": "none"},
         "the annotation orchestrate.scenario says 'isolation', which an archive does not decide"),
        ({"blocks": {"motor_1": {"isolation": "none"}}},
         "blocks.motor_1 says 'isolation', which an archive does not decide"),
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
