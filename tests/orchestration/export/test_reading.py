"""Values, factors and times of an SSP archive as a scenario has them, each by itself."""

from __future__ import annotations

import re
import zipfile
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace

import pytest

from orchestration import load
from orchestration.errors import InputError
from orchestration.export import system
from orchestration.export.changes import _of_signal, start_of
from orchestration.export.ssp import Style, parameter_set
from orchestration.export.system import Value, _worth, flat
from orchestration.fmu.model import Element, Variable
from orchestration.quantities import parse_unit
from orchestration.ssp.reader import _changed, _check_transformation, _times, start_value
from orchestration.ssp.structure import Given
from orchestration.system.wiring import Node
from tests.commands import orchestrate
from tests.tools.test_foreign_ssp import _SYSTEM, EXPERIMENT, _connection, _value, foreign

from .. import vendor

SPEED = Variable("speed", "parameter", unit=parse_unit("rad/s"))
MODE = Variable("mode", "parameter", type="enumeration", items=(("normal", 1), ("brake", 2)))


@pytest.mark.parametrize(
    ("given", "variable", "value"),
    [
        (Given("Boolean", "true"), Variable("x", "input", type="boolean"), True),
        (Given("Boolean", "1"), Variable("x", "input", type="boolean"), True),
        (Given("Boolean", "false"), Variable("x", "input", type="boolean"), False),
        (Given("Boolean", "0"), Variable("x", "input", type="boolean"), False),
        (Given("Integer", "2"), MODE, "brake"),
        (Given("Real", "1.0"), MODE, "normal"),
        (Given("Enumeration", "brake"), MODE, "brake"),
        (Given("Integer", "-7"), Variable("x", "parameter", type="integer"), -7),
        (Given("Real", "2.5"), SPEED, 2.5),
        (Given("Real", "60", parse_unit("rpm")), SPEED, 6.283185307179586),
        (Given("Real", "2", parse_unit("V")), Variable("x", "parameter"), 2.0),
        (Given("String", "a b"), Variable("x", "parameter", type="string"), "a b"),
    ],
)
def test_a_value_of_a_parameter_set_has_the_type_and_the_unit_of_its_variable(given, variable, value):
    found = start_value(given, variable)
    assert found == pytest.approx(value) if isinstance(value, float) else found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    ("source", "target", "asked", "suppressed", "fits"),
    [
        ("V", "mV", (1.0, 0.0), False, True),  # units do it
        ("V", "mV", (1000.0, 0.0), True, True),
        ("V", "mV", (1.0, 0.0), True, False),
        ("V", "mV", (0.001, 0.0), True, False),
        ("V", "V", (1.0, 0.0), True, True),
        ("degC", "K", (1.0, 273.15), True, True),
        ("degC", "K", (1.0, 273.15 + 1e-6), True, False),
        (None, "V", (1.0, 0.0), True, True),
        ("V", None, (1.0, 0.0), False, True),
        (None, None, (1.0, 0.0), True, True),
        (None, "V", (2.0, 0.0), False, False),
        (None, None, (1.0, 1.0), True, False),
    ],
)
def test_a_transformation_of_a_connection_is_that_of_its_units_or_none(source, target, asked, suppressed, fits):
    a, b = (Variable("x", "output", unit=unit and parse_unit(unit)) for unit in (source, target))
    try:
        _check_transformation(Path("a.ssp"), "a.x -> b.x", a, b, asked, suppressed)
        refused = False
    except InputError:
        refused = True
    assert refused is not fits


@pytest.mark.parametrize(
    ("stated", "annotated", "changed"),
    [(2.0, "2 s", False), (2.0, 2.0, False), (3.0, "2 s", True), (120.0, "2 min", False), (None, "2 s", False),
     (2.0, None, False), (2.0, "3 orbits", False), (0.0, "2 s", True)],
)  # fmt: skip
def test_a_duration_is_changed_where_the_archive_has_another_than_its_annotation(stated, annotated, changed):
    assert _changed(stated, annotated) is changed


def test_an_archive_lasts_from_its_start_to_its_stop_and_else_as_long_as_its_longest_fmu():
    fmus = [
        SimpleNamespace(description=SimpleNamespace(defaultExperiment=SimpleNamespace(stepSize=step, stopTime=stop)))
        for step, stop in (("0.5", "4"), ("0.1", "9"), (None, None))
    ]
    fmus.append(SimpleNamespace(description=SimpleNamespace(defaultExperiment=None)))
    assert _times(None, fmus) == {"step": 0.1, "duration": 9.0}
    assert _times({"startTime": "3", "stopTime": "4.5"}, fmus) == {"step": 0.1, "duration": 1.5}
    assert _times(None, fmus[2:]) == {}


def test_an_element_starts_with_the_scenario_s_value_or_else_that_of_its_fmu():
    speed, mode, other = (Element(name, 0) for name in ("speed", "mode", "other"))
    plan = SimpleNamespace(starts={"a": [SimpleNamespace(element=speed, value=2.0)]})
    start = start_of(plan, {"a": {speed: 1.0, mode: "brake"}, "b": {speed: True}})
    assert [start(Node("a", e)) for e in (speed, mode, other)] == [2.0, 0.0, 0.0]
    assert start(Node("b", speed)) == 1.0


@pytest.mark.compile
def test_a_value_of_an_input_counts_where_nothing_feeds_it_and_a_fed_one_takes_what_comes(loop: Path) -> None:
    given = _value("control.regulator.enabled", "Boolean", "false") + _value("control.regulator.speed", "Real", 7)
    foreign(values=given, top=EXPERIMENT)
    start = load("foreign.ssp", {"step": 0.1}).blocks["control_regulator"].start
    assert start["enabled"] is False
    assert "speed" not in start


@pytest.mark.compile
def test_an_input_whose_connection_begins_at_nothing_is_as_one_without(loop: Path) -> None:
    outer = _connection("motor 1.speed", "control.seen", "%s")
    assert outer in _SYSTEM
    foreign(system=_SYSTEM.replace(outer, "%s"), top=EXPERIMENT)
    scenario = load("foreign.ssp", {"step": 0.1})
    assert scenario.blocks["control_regulator"].start["speed"] == 0.0
    assert [str(c) for c in scenario.connections] == ["control_regulator.voltage -> motor_1.voltage"]


def test_text_and_items_are_written_where_they_are_not_the_fmus_own_and_numbers_always():
    for kind, value, own, written in (
        ("string", "a", "a", False), ("string", "a", "b", True), ("enumeration", 1, 1, False),
        ("enumeration", 2, 1, True), ("real", 1.0, 1.0, True), ("boolean", True, True, True),
    ):  # fmt: skip
        assert _worth(Variable("x", "parameter", type=kind), value, own) is written


@pytest.mark.parametrize(
    ("begin", "delayed", "at_start"), [(0, False, True), (0, True, False), (1, False, False), (1, True, False)]
)
def test_a_fault_acts_at_the_start_where_it_begins_there_and_its_signal_is_not_delayed(begin, delayed, at_start):
    fault = SimpleNamespace(behind=lambda *_: 0, kind="bias", span=(begin, 10), value=2.0, delayed=delayed)
    made = _of_signal(fault, {}, 1, Fraction("0.1"))
    assert made.at_start is at_start


@pytest.mark.compile
def test_an_archive_says_the_units_of_numbers_and_the_items_of_enumerations(loop):
    loop.write_text(loop.read_text("utf-8").replace("inertia: 0.5", "inertia: 0.5\n      mode: brake"), "utf-8")
    assert orchestrate("export", loop.name, "--ssp", "loop.ssp").exit_code == 0
    with zipfile.ZipFile("loop.ssp") as archive:
        structure = archive.read("SystemStructure.ssd").decode()
        values = archive.read("resources/motor.ssv").decode()
    assert re.search(r'name="speed" kind="output">\s*<ssc:Real unit="rad/s"', structure)
    assert re.search(r'name="inertia">\s*<ssv:Real value="0.5" unit="kg.m2"', values)
    assert re.search(r'name="mode">\s*<ssv:Enumeration value="brake"', values)


@pytest.mark.compile
def test_a_block_with_a_mapping_is_not_exported(loop):
    vendor.write(loop.parent, runnable=True)
    mapped = "fmu: vendor.fmu\n    interface: regulator.fmu\n    map: {file: mapping.yaml}"
    text = loop.read_text("utf-8")
    assert {component.name for component in flat(load(loop)).components} == {"motor", "regulator"}
    loop.write_text(text.replace("fmu: regulator.fmu", mapped), "utf-8")
    with pytest.raises(InputError, match="its ports are mapped to those of another interface"):
        flat(load(loop))


@pytest.mark.parametrize("numbers", [False, True])
def test_items_are_items_unless_numbers_are_asked_for(numbers):
    style = Style(numbers=True) if numbers else Style()
    text = parameter_set([Value("mode", MODE, 2)], style).decode()
    assert ("<ssv:Integer" in text) is numbers
    assert ('<ssv:Enumeration value="brake"' in text) is not numbers


@pytest.mark.compile
@pytest.mark.parametrize("inside", ["<ssv:ParameterMapping/>", '<ssm:ParameterMapping version="1.0" colour="red"/>'])
def test_a_mapping_that_is_written_in_the_archive_is_held_to_its_format(loop, inside):
    foreign(mapping=f"<ssd:ParameterMapping>{inside}</ssd:ParameterMapping>", top=EXPERIMENT)
    with pytest.raises(InputError, match="a parameter mapping"):
        load("foreign.ssp", {"step": 0.1})


@pytest.mark.compile
def test_an_export_takes_the_project_s_fmus_for_all_platforms(loop, monkeypatch):
    asked, opened = [], system.open_fmus
    monkeypatch.setattr(system, "open_fmus", lambda of, here=True: asked.append(here) or opened(of, here))
    flat(load(loop))
    assert asked == [False]
