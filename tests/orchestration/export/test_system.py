"""What other tools are given of a loop of two small FMUs: wires, values at t = 0, free ports, and changes in time."""

from __future__ import annotations

import math
import re
import zipfile
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import orchestration
from orchestration.errors import InputError
from orchestration.export.changes import Values, _of_signal, _of_value, with_inputs
from orchestration.export.system import Component, System, _converted, flat
from orchestration.fmu.archive import open_fmu
from orchestration.fmu.model import Element
from orchestration.session.open import open_scenario
from orchestration.system.faults import Setting
from orchestration.system.wiring import Node
from tests.commands import orchestrate
from tests.orchestration import fmus


@pytest.fixture
def millivolts(loop):
    """The loop with a motor in mV, at the speed 1.5 rad/s: the regulator gives -1.5 V at t = 0."""
    text = fmus.description("motor").replace(
        'valueReference="2" causality="input"><Real unit="V"', 'valueReference="2" causality="input"><Real unit="mV"'
    )
    assert 'unit="mV"' in text
    fmus.write(loop.with_name("motor.fmu"), text, fmus.library())
    return loop


def of(loop: Any, **changes: Any) -> tuple[System, Component, Component]:
    system = flat(orchestration.load(loop, changes))
    motor, regulator = (next(c for c in system.components if c.name == name) for name in ("motor", "regulator"))
    return system, motor, regulator


def values(component: Component) -> dict[str, Any]:
    return {value.name: value.value for value in component.values}


def test_a_connected_input_starts_with_what_comes_to_it_in_its_own_unit(millivolts):
    system, motor, regulator = of(millivolts, **{"motor.speed0": "1.5 rad/s"})
    first = orchestration.run(millivolts, {"motor.speed0": "1.5 rad/s"})
    volts = float(first["regulator.voltage"][0])
    assert volts not in (0.0, 1.0)
    assert values(motor)["voltage"] == pytest.approx(1000.0 * volts, rel=1e-15)
    assert values(regulator)["speed"] == 1.5
    wires = {(wire.source, wire.target): (wire.factor, wire.offset) for wire in system.wires}
    assert wires == {
        (("regulator", "voltage"), ("motor", "voltage")): (1000.0, 0.0),
        (("motor", "speed"), ("regulator", "speed")): (1.0, 0.0),
    }


def test_free_are_all_inputs_and_parameters_to_which_nothing_is_connected(loop):
    _, motor, regulator = of(loop)
    assert {port.name for port in motor.free} >= {"inertia", "speed0", "axis[1]", "axis[2]", "mode", "label", "poles"}
    assert not {port.name for port in motor.free} & {"voltage", "speed", "hot"}
    assert "speed" not in {port.name for port in regulator.free}
    assert {port.name for port in motor.ports} == {"voltage", "speed", "steps", "hot"}


def test_times_in_a_unit_of_the_scenario_s_own_do_not_keep_it_from_export(loop):
    loop.write_text(
        loop.read_text()
        + "cycle: {name: turns, period: 2 s}\n"
        + "live: {faults: [{name: no voltage, cut: motor.voltage, at: 0.5 turns}]}\n"
    )
    assert {c.name for c in of(loop)[0].components} == {"motor", "regulator"}


def test_a_rate_of_its_own_needs_an_fmu_that_can_keep_it(loop):
    loop.write_text(loop.read_text().replace("fmu: regulator.fmu\n", "fmu: regulator.fmu\n    every: 2\n"))
    with pytest.raises(InputError, match=r"regulator\.every: .* its FMU has no parameter sample_period"):
        flat(orchestration.load(loop))
    assert flat(orchestration.load(loop), kept=True).delays is None


@pytest.mark.parametrize(
    ("span", "every", "acts"),
    [((3, 7), 1, (0.3, 0.7)), ((3, 7), 2, (0.4, 0.8)), ((4, 8), 4, (0.4, 0.8)), ((1, math.inf), 5, (0.5, math.inf))],
)
def test_a_value_of_a_slow_block_is_set_at_its_next_step_and_set_back_at_the_next_after_its_end(span, every, acts):
    operation = _of_value(Setting("motor", (), span, "faults[1]"), 2.5, every, Fraction(1, 10))
    assert (operation.first, operation.until) == acts
    assert (operation.kind, operation.value, operation.before) == ("replace", 2.5, True)


CUT = "faults: [{cut: regulator.speed, at: 0.5 s}]\n"
"""In a connection, so that an FMU of changes stands before the regulator."""


def test_what_goes_through_an_fmu_of_changes_comes_to_the_block_as_it_leaves(loop):
    loop.write_text(loop.read_text() + CUT)
    system, _, _ = of(loop)
    into = {wire.target: (wire.source, wire.factor, wire.offset) for wire in system.wires}
    source, factor, offset = into["regulator", "speed"]
    assert (source[0], factor, offset) == ("regulator_changes", 1.0, 0.0)
    assert [c.name for c in system.components] == ["motor", "regulator", "regulator_changes"]
    assert {str(port.variable.unit) for port in system.components[2].ports if port.variable.type == "real"} == {"rad/s"}
    assert system.order.index("regulator_changes") == system.order.index("regulator") - 1


def test_changes_need_the_sequential_exchange_and_nothing_else_does(loop):
    parallel = loop.read_text() + "exchange: parallel\n"
    loop.write_text(parallel + CUT)
    with pytest.raises(
        InputError, match=r"faults: a parallel exchange delays .* by one more step; remedy: exchange: seq"
    ):
        flat(orchestration.load(loop))
    loop.write_text(loop.read_text().replace("exchange: parallel", "exchange: sequential"))
    assert len(flat(orchestration.load(loop)).components) == 3


def test_a_value_at_the_start_is_converted_with_the_offset_of_its_unit():
    link = SimpleNamespace(factor=2.0, offset=3.0)
    node = Node("motor", Element("speed", 0))
    assert Values(lambda node: 0.0, {node: 5}).of(link, node) == 13.0
    assert Values(lambda node: 0.0, {node: 5}).of(SimpleNamespace(factor=1.0, offset=-273.15), node) == -268.15


def test_only_the_parameters_that_are_set_are_declared_as_inputs(loop):
    fmu = open_fmu(loop.with_name("motor.fmu"))
    loop.with_name("other.fmu").write_bytes(with_inputs(fmu, frozenset({"inertia", "cooled"}), False))
    other = open_fmu(loop.with_name("other.fmu")).model.variables
    changed = {name for name, variable in fmu.model.variables.items() if other[name].causality != variable.causality}
    assert changed == {"inertia", "cooled"}
    assert (other["inertia"].causality, other["cooled"].causality) == ("input", "input")


@pytest.mark.parametrize("numbers", [True, False])
def test_items_are_numbers_where_that_is_asked_and_stay_items_else(loop, numbers):
    fmu = open_fmu(loop.with_name("motor.fmu"))
    loop.with_name("other.fmu").write_bytes(with_inputs(fmu, frozenset({"inertia"}), numbers))
    other = open_fmu(loop.with_name("other.fmu")).model.variables
    assert fmu.model.variables["mode"].type == "enumeration"
    changed = {name for name, variable in fmu.model.variables.items() if other[name].type != variable.type}
    assert changed == ({"mode"} if numbers else set())


@pytest.mark.parametrize(
    ("more", "delays"),
    [
        ("", ["motor.voltage"]),
        ("faults: [{cut: motor.voltage, at: 0.5 s}]\n", ["motor_changes.voltage_given"]),
        ("faults: [{cut: regulator.speed, at: 0.5 s}]\n", ["motor.voltage"]),
    ],
)
def test_what_a_later_block_gives_is_told_as_delayed_where_the_first_of_the_loop_takes_it(loop, more, delays):
    text = loop.read_text().replace("record:", "delays: [motor.voltage]\nrecord:")
    loop.write_text(text.replace("inertia: 0.5", "inertia: 0.5\n      voltage: 0.25") + more)
    assert list(flat(orchestration.load(loop)).delays) == delays


def test_a_law_in_python_is_refused_with_the_command_that_makes_an_fmu_of_it(loop):
    loop.with_name("law.py").write_text("def step(i, p, t, h):\n    return {}\n")
    text = loop.read_text("utf-8").replace("fmu: regulator.fmu", "python: law.py\n    interface: controller")
    loop.write_text(text, "utf-8")
    with pytest.raises(InputError, match=r"law\.py is a law in Python; .*orchestrate new controller FOLDER --from law"):
        flat(orchestration.load(loop))


@pytest.mark.parametrize(
    ("cut", "source", "target", "before"),
    [("regulator.speed", "motor", "regulator", False), ("motor.voltage", "regulator", "motor", True)],
)
def test_a_fault_of_a_signal_that_comes_a_step_later_acts_before_the_step(loop, cut, source, target, before):
    """Of two blocks the motor is stepped first: what it is given is the regulator's of the step before."""
    loop.write_text(loop.read_text() + f"faults: [{{cut: {cut}, at: 0.5 s}}]\n")
    (fault,) = open_scenario(orchestration.load(loop)).plan.circuit.faults.disturbances
    assert (fault.source.block, fault.target.block) == (source, target)
    operation = _of_signal(fault, {"motor": 0, "regulator": 1}, 1, Fraction(1, 10))
    assert (operation.first, operation.before) == (0.5, before)


def test_what_leaves_a_delay_is_passed_before_all_else_in_initialization(loop):
    text = loop.read_text().replace("record:", "delays: [regulator.speed]\nrecord:")
    loop.write_text(text.replace("{gain: -1,", "{gain: -1, speed: 0.25,"))
    system, _, _ = of(loop)
    (delayed,) = (wire for wire in system.wires if wire.target == ("regulator", "speed"))
    assert delayed.source[0] == "regulator_changes"
    assert system.initial[0] == delayed
    assert system.initial[-1].target[0] == "regulator_changes"
    orchestration.export_loop(loop, loop.with_name("loop.ssp"))
    back, direct = orchestration.run(loop.with_name("loop.ssp")), orchestration.run(loop)
    assert back["motor.speed"] == pytest.approx(direct["motor.speed"], rel=1e-12)
    loop.write_text(loop.read_text().replace("delays: [regulator.speed]\n", ""))
    assert np.abs(orchestration.run(loop)["motor.speed"] - direct["motor.speed"]).max() > 1e-3


def test_signals_without_a_unit_have_none_in_an_archive_and_behind_an_fmu_of_changes(loop):
    for name in ("motor", "regulator"):
        text = re.sub(r'(name="(?:voltage|speed)"[^>]*><Real) unit="[^"]*"', r"\1", fmus.description(name))
        fmus.write(loop.with_name(f"{name}.fmu"), text, fmus.library())
    loop.write_text(re.sub(r"(?s)expect:.*?(?=isolation)", "", loop.read_text()) + CUT)
    system, _, _ = of(loop)
    assert {port.variable.unit for port in system.components[2].ports if port.variable.type == "real"} == {None}
    assert orchestrate("export", loop.name, "--ssp", "loop.ssp").exit_code == 0
    with zipfile.ZipFile("loop.ssp") as archive:
        structure = archive.read("SystemStructure.ssd").decode()
    connectors = re.findall(r'name="(?:voltage|speed)" kind="\w+">\s*<ssc:(.*?)/>', structure)
    assert {kind.strip() for kind in connectors} == {"Real"}
    result, back = (orchestration.run(path)["motor.speed"] for path in (loop.name, "loop.ssp"))
    np.testing.assert_array_equal(back, result)


def test_an_input_that_nothing_feeds_keeps_its_value_in_an_archive(loop):
    text = loop.read_text().replace("  - regulator.voltage -> motor.voltage\n", "")
    loop.write_text(text.replace("inertia: 0.5", "inertia: 0.5\n      voltage: 3 V"))
    assert orchestrate("export", loop.name, "--ssp", "loop.ssp").exit_code == 0
    first, back = (orchestration.run(path)["motor.speed"] for path in (loop.name, "loop.ssp"))
    assert first[-1] > first[0] + 1.0
    np.testing.assert_array_equal(back, first)


def test_a_duration_in_the_scenario_s_own_times_stays_as_it_was_written(loop):
    text = loop.read_text().replace("duration: 2 s", "duration: 0.5 turns")
    loop.write_text(text + "cycle: {name: turns, period: 2 s}\n")
    assert orchestrate("export", loop.name, "--ssp", "loop.ssp").exit_code == 0
    assert orchestration.load("loop.ssp").source.data["duration"] == "0.5 turns"
    assert orchestration.run("loop.ssp").time[-1] == 1.0


@pytest.mark.parametrize(("at", "first"), [(0.0, 1.5), (1.0, 2.0)])
def test_an_input_starts_with_what_a_fault_from_the_start_on_gives_it_and_not_with_a_later_one(loop, at, first):
    loop.write_text(loop.read_text() + f"faults: [{{at: {at} s, bias: motor.speed, by: -0.5 rad/s}}]\n")
    system, _, _ = of(loop)
    result = orchestration.run(loop)
    assert result["regulator.voltage"][0] == pytest.approx(-first)
    given = {value.name: value.value for c in system.components for value in c.values if c.name == "motor"}
    assert given["voltage"] == pytest.approx(-first)


def test_a_value_that_is_not_converted_keeps_its_type():
    assert _converted(True, 1.0, 0.0) is True
    assert type(_converted(3, 1.0, 0.0)) is int
    assert _converted(3, 1.0, 1.0) == 4.0


def test_a_parameter_that_is_set_during_the_run_is_fed_and_no_other(loop):
    loop.write_text(loop.read_text() + "faults: [{at: 1 s, set: regulator.gain = -2}]\n")
    _, motor, regulator = of(loop)
    assert (motor.fed, regulator.fed) == (frozenset(), {"gain"})
    assert "gain" not in {port.name for port in regulator.free}
