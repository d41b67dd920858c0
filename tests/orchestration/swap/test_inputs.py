"""Inputs that only theirs has, which a mapping connects to signals of the scenario.

Theirs takes the motor's speed by such an input, `rate` in rpm, and ours by `speed`, which the mapping ignores: what
theirs gives is right only where the extra input is fed, in every instant and in its unit.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from orchestration import run
from orchestration.acceptance import feedthrough, inputs
from orchestration.acceptance.check import check
from orchestration.acceptance.vector import play
from orchestration.fmu.interfaces import Interface, reference
from orchestration.scenario.mapping import Mapping
from orchestration.swap.conversion import is_rate
from orchestration.swap.fit import fit
from tests.commands import orchestrate

from .. import mocks
from ..mocks import real
from ..swapped import swapped
from ..vendor import MAPPING
from ..wrong_inputs import SCENARIO
from .behind import unit

FED = MAPPING.replace("  speed: rate\n", "") + "ignore: [speed]\ninputs: {rate: motor.speed}\n"
SWAP = ("--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")


def fed(folder: Path, monkeypatch, *changes, mapping: str = FED, scenario: str = SCENARIO) -> Path:
    path = swapped(folder, monkeypatch, *changes, scenario=scenario)
    Path("mapping.yaml").write_text(mapping)
    return path


def speed_and_voltage(folder: str = "out"):
    table = np.genfromtxt(f"{folder}/signals.csv", delimiter=",", names=True)
    return table["motorspeed"], table["regulatorvoltage"]


def test_an_input_that_only_theirs_has_takes_a_signal_of_the_scenario_in_its_own_unit(tmp_path, monkeypatch):
    path = fed(tmp_path, monkeypatch)
    ours = run(path)
    result = orchestrate(path.name, *SWAP, "--out", "out")
    assert result.exit_code == 0, result.output
    speed, voltage = speed_and_voltage()
    np.testing.assert_allclose(speed, ours["motor.speed"], rtol=1e-13)
    np.testing.assert_allclose(voltage, ours["regulator.voltage"], rtol=1e-13)
    scenario = json.loads(Path("out/manifest.json").read_text())["scenario"]
    assert "motor.speed -> regulator.rate" in scenario["connections"]
    again = run(scenario)
    np.testing.assert_array_equal(again["motor.speed"], speed)


def test_theirs_is_stepped_after_what_feeds_it_even_where_it_declares_no_dependence(tmp_path, monkeypatch):
    motor = SCENARIO[SCENARIO.index("  motor:") : SCENARIO.index("  regulator:")]
    last = SCENARIO.replace(motor, "").replace("connections:", f"{motor}connections:")
    path = fed(tmp_path, monkeypatch, ('<Unknown index="5" dependencies="3"/>', '<Unknown index="5"/>'), scenario=last)
    assert orchestrate(path.name, *SWAP, "--out", "out").exit_code == 0
    speed, voltage = speed_and_voltage()
    np.testing.assert_allclose(voltage, -speed, rtol=1e-13)


def test_a_comparison_gives_theirs_the_signal_of_the_run_of_ours(tmp_path, monkeypatch):
    path = fed(tmp_path, monkeypatch)
    result = orchestrate("compare", path.name, *SWAP, "--out", "out")
    assert result.exit_code == 0, result.output
    differences = {d["output"]: d for d in json.loads(Path("out/comparison.json").read_text())["open_loop"]}
    assert differences["voltage"]["largest"] < 1e-14
    Path("mapping.yaml").write_text(FED.replace("inputs: {rate: motor.speed}", "start: {rate: 0}"))
    assert orchestrate("compare", path.name, *SWAP, "--out", "out").exit_code == 1


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("{rite: motor.speed}", "their FMU has no variable 'rite'; did you mean 'rate'?"),
        ("{command: motor.speed}", "command is of causality output, expected input"),
        ("{enabled: motor.hot}", "enabled stands for our enabled, whose signal it takes"),
        ("{rate: motor.sped}", "motor has no output 'sped'; did you mean 'speed'?"),
        ("{rate: engine.speed}", "there is no block 'engine'"),
        ("{rate: motor.steps}", "motor.steps is integer, regulator.rate is real"),
        ("{rate: speed}", "expected block.variable, found 'speed'"),
        ("{rate: regulator.command}", "regulator has no output 'command'"),
    ],
)
def test_what_cannot_be_connected_is_refused_with_the_line_of_the_mapping(tmp_path, monkeypatch, entry, message):
    path = fed(tmp_path, monkeypatch, mapping=FED.replace("{rate: motor.speed}", entry))
    result = orchestrate(path.name, *SWAP)
    assert (result.exit_code, message in result.stderr) == (2, True), result.stderr
    line = next(line for line in result.stderr.splitlines() if message in line)
    assert line.strip().startswith("mapping.yaml:5: inputs"), line


def test_an_input_is_not_both_connected_and_given_a_value(tmp_path, monkeypatch):
    path = fed(tmp_path, monkeypatch, mapping=FED + "start: {rate: 1}\n")
    assert "motor.speed feeds rate, as inputs in the mapping says" in orchestrate(path.name, *SWAP).stderr


def loop():
    """A sensor's field and a law that lacks it in our interface and has it in theirs."""
    field = real("b_B", "output", shape=(3,), unit=unit("T"))
    plant = mocks.model("plant", real("tau", "input"), field, real("rate", "output"), feedthrough={"b_B": ["tau"]})
    ours = mocks.model("law", real("rate", "input"), real("tau", "output"))
    mag = real("mag", "input", shape=(3,), unit=unit("nT"))
    theirs = mocks.model("law", real("rate", "input"), mag, real("tau", "output"), feedthrough={"tau": ["mag"]})
    return Interface("law", ours, {}, frozenset(), {"plant": plant}), theirs


@pytest.mark.parametrize(
    ("signal", "level", "text"),
    [
        ("plant.b_B", None, ""),
        ("plant.rate", "error", "the shapes differ: plant.rate is a real scalar, law.mag is a real [3]"),
        ("plant.b", "error", "plant has no output 'b'"),
        ("sensors.b_B", "note", "whether a scenario has the block sensors is seen when it runs"),
    ],
)
def test_a_check_holds_the_signal_against_the_other_blocks_of_the_project(signal, level, text):
    interface, theirs = loop()
    findings = []
    inputs.look(fit(interface, theirs, Mapping.model_validate({"inputs": {"mag": signal}})), findings)
    assert [(f.level, text in f.text) for f in findings] == ([(level, True)] if level else [])


def test_a_check_sees_the_loop_that_the_connection_closes_and_names_the_connection_that_is_missing():
    interface, theirs = loop()
    found = fit(interface, theirs, Mapping.model_validate({"inputs": {"mag": "plant.b_B"}}))
    findings = []
    feedthrough.look(found, findings)
    assert any(f.level == "error" and "an algebraic loop through " in f.text for f in findings)
    (missing,) = fit(interface, theirs).errors
    assert "'inputs: {mag: BLOCK.OUTPUT}' there; plant.b_B has its unit and shape" in missing.remedy


def test_a_test_vector_is_not_run_where_the_mapping_needs_signals_that_it_does_not_hold(tmp_path, monkeypatch):
    fed(tmp_path, monkeypatch)
    fitted = check(Path("vendor.fmu"), "regulator.fmu", Path("mapping.yaml"))[1]
    assert fitted is not None
    (finding,) = play(Path("vendor.fmu"), fitted, "regulator.fmu", Path("vector"), 1e-6)
    assert (finding.level, "the mapping needs motor.speed for rate" in finding.text) == ("error", True)


# ---------------------------------------------------------------- hints


def test_a_hint_to_be_pasted_rests_on_a_similar_name_and_an_input_is_told_once():
    ours = reference("allocator", Path.cwd())
    theirs = dict(ours.model.variables)
    del theirs["tau_cmd_B"], theirs["wheel_torque_cmd"]
    newton_metre = unit("N.m")
    theirs["torque_request"] = real("torque_request", "input", shape=(3,), unit=newton_metre)
    theirs["lyapunov"] = real("lyapunov", "output", unit=unit("J"))
    theirs["tau_drag"] = real("tau_drag", "input", shape=(3,), unit=newton_metre)
    found = [str(f) for f in fit(ours, mocks.model("theirs", *theirs.values())).errors]
    assert len(found) == 2
    assert "torque_request" in found[0]
    assert "'tau_cmd_B: THEIRS'" in found[0]
    assert "by name or unit it may be lyapunov" in found[1]
    assert "'wheel_torque_cmd: THEIRS'" in found[1]
    theirs["tau_cmd_B"] = ours.model.variables["tau_cmd_B"]
    told = "\n".join(str(f) for f in fit(ours, mocks.model("theirs", *theirs.values())).errors)
    assert "'inputs: {torque_request: BLOCK.OUTPUT}' there; plant.tau_gg_B, " in told
    assert "'inputs: {tau_drag: plant.tau_drag_B}' there" in told


@pytest.mark.parametrize("matrix", [[[1, 0, 0], [0, 1, 0], [1, 1, 0]], [[1, 0, 0], [0, 1, 0], [0, 0, -1]]])
def test_a_matrix_of_a_vector_in_a_frame_is_regular_and_a_left_handed_one_is_told(matrix):
    ours = reference("allocator", Path.cwd())
    ports = {"ports": {"tau_cmd_B": {"theirs": "tau_cmd_B", "matrix": matrix}}}
    found = fit(ours, ours.model, Mapping.model_validate(ports)).findings
    told = [(f.level, f.text) for f in found if f.level in ("error", "warning")]
    expected = (
        ("warning", "input tau_cmd_B: the matrix is left-handed: its determinant is -1")
        if matrix[2][2]
        else ("error", "input tau_cmd_B: the matrix is singular, so a component of the vector is lost")
    )
    assert told == [expected]


# ---------------------------------------------------------------- what no mapping can give


@pytest.mark.parametrize(
    ("causality", "here", "there"), [("parameter", "kg.m2", "N.m.s"), ("parameter", "1", "s"), ("input", "1", "s")]
)
def test_no_rate_of_change_is_told_of_parameters_or_of_what_has_no_unit(causality, here, there):
    one, other = (mocks.model("x", real(n, causality, unit=unit(u))) for n, u in (("aa", here), ("zz", there)))
    told = [f.text for f in fit(Interface("ours", one, {}), other).findings]
    assert not any("rate of change" in text for text in told), told


def test_a_speed_in_the_place_of_a_torque_is_told_to_be_beyond_a_mapping():
    """A wheel that is commanded by its speed: the speed is the torque's integral over the inertia."""
    ours = reference("allocator", Path.cwd())
    theirs = dict(ours.model.variables)
    del theirs["wheel_torque_cmd"]
    theirs["speed_cmd"] = real("speed_cmd", "output", unit=unit("rpm"))
    kind = mocks.model("theirs", *theirs.values())
    (silent,) = fit(ours, kind).errors
    assert "speed_cmd, in rpm, cannot stand for it: one is the rate of change of the other" in silent.text
    (mapped,) = fit(ours, kind, Mapping.model_validate({"ports": {"wheel_torque_cmd": "speed_cmd"}})).errors
    assert "so no mapping serves" in mapped.remedy


@pytest.mark.parametrize(
    ("one", "other", "rate"),
    [
        ("N.m", "rad/s", True),
        ("N.m", "N.m.s", True),
        ("rad/s", "rad", True),
        ("m/s2", "m/s", True),
        ("N", "m/s", True),
        ("N.m.s", "rad/s", False),
        ("N.m", "mN.m", False),
        ("A", "N.m", False),
        ("T", "A.m2", False),
    ],
)
def test_a_rate_of_change_is_known_by_its_unit(one, other, rate):
    assert is_rate(unit(one), unit(other)) is rate
    assert is_rate(unit(other), unit(one)) is rate
