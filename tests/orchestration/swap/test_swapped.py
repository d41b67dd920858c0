"""Another team's FMU in a block's place, in a run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from orchestration import load, run
from tests.commands import orchestrate

from .. import vendor
from ..swapped import swapped
from ..wrong_inputs import SCENARIO


def test_a_swapped_block_gives_what_ours_gives(tmp_path, monkeypatch):
    path = swapped(tmp_path, monkeypatch)
    ours = run(path)
    result = orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml", "--out", "out")
    assert result.exit_code == 0, result.output
    table = np.genfromtxt("out/signals.csv", delimiter=",", names=True)
    np.testing.assert_allclose(table["motorspeed"], ours["motor.speed"], rtol=1e-13)
    np.testing.assert_allclose(table["regulatorvoltage"], ours["regulator.voltage"], rtol=1e-13)


def test_the_scenario_may_say_it_itself_and_the_manifest_can_be_run_again(tmp_path, monkeypatch):
    text = SCENARIO.replace(
        "fmu: regulator.fmu", "fmu: vendor.fmu\n    interface: regulator.fmu\n    map: mapping.yaml"
    )
    path = swapped(tmp_path, monkeypatch, scenario=text)
    result = run(path)
    again = run({**result.manifest["scenario"]})
    np.testing.assert_array_equal(again["motor.speed"], result["motor.speed"])
    inline = {"ports": {"speed": "rate", "voltage": "command", "gain": {"theirs": "kp", "scale": vendor.GAIN}}}
    data = load(path).source.data
    data["blocks"]["regulator"]["map"] = inline
    np.testing.assert_array_equal(run(data)["motor.speed"], result["motor.speed"])


def test_the_manifest_tells_the_values_in_force_in_theirs(tmp_path, monkeypatch):
    path = swapped(tmp_path, monkeypatch)
    orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml", "--out", "out")
    told = json.loads(Path("out/manifest.json").read_text())["parameters"]["regulator"]
    assert told == {"fault": 0, "fault_time": 0.0, "kp": pytest.approx(-vendor.GAIN)}


def test_other_names_alone_change_no_bit(tmp_path, monkeypatch):
    path = swapped(tmp_path, monkeypatch, ('name="speed"', 'name="rate"'), own_names=False)
    (tmp_path / "mapping.yaml").write_text("ports: {speed: rate}")
    theirs = load(path).source.with_entry(("blocks", "regulator", "fmu"), "vendor.fmu")
    theirs = theirs.with_entry(("blocks", "regulator", "interface"), "regulator.fmu").with_entry(
        ("blocks", "regulator", "map"), "mapping.yaml"
    )
    a, b = run(path), run(load(theirs))
    for name in a:
        np.testing.assert_array_equal(a[name], b[name])


def test_inputs_are_recorded_as_they_were_handed_in(tmp_path, monkeypatch):
    path = swapped(tmp_path, monkeypatch, scenario=SCENARIO + "\n").parent / "loop.yaml"
    path.write_text(
        SCENARIO.replace(
            "record: {interval: 0.1 s}", "record: {signals: [regulator.speed, motor.speed, regulator.gain]}"
        )
    )
    orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml", "--out", "out")
    table = np.genfromtxt("out/signals.csv", delimiter=",", names=True)
    np.testing.assert_array_equal(table["regulatorspeed"], table["motorspeed"])
    np.testing.assert_allclose(table["regulatorgain"], -1.0, rtol=1e-14)


def test_a_value_for_a_parameter_that_theirs_lacks_is_refused_unless_ignored(tmp_path, monkeypatch):
    path = swapped(tmp_path, monkeypatch)
    mapping = "ports: {speed: rate, voltage: command}\n"
    (tmp_path / "mapping.yaml").write_text(mapping)
    arguments = (path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")
    result = orchestrate(*arguments)
    assert result.exit_code == 2
    assert (
        "loop.yaml:12: blocks.regulator.start.gain: vendor.fmu has no parameter gain, so this value would be lost"
        in result.stderr
    )
    (tmp_path / "mapping.yaml").write_text(mapping + "ignore: [gain]\n")
    result = orchestrate(*arguments)
    assert (result.exit_code, "regulator: does without parameter gain, as the mapping says" in result.stderr) == (
        0,
        True,
    )


def test_what_refers_to_an_output_that_theirs_lacks_is_refused_unless_ignored(tmp_path, monkeypatch):
    extra = (
        "  - {name: sampled, signal: 'regulator.samples[1]', always: {within: 1 V}}\n  - {name: slow, "
        "signal: motor.speed, always: {below: 1 rpm}}\n"
    )
    path = swapped(
        tmp_path,
        monkeypatch,
        ('name="samples[1]"', 'name="first"'),
        ('name="samples[2]"', 'name="second"'),
        scenario=SCENARIO + extra,
    )
    arguments = (path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")
    result = orchestrate(*arguments)
    assert result.exit_code == 2
    assert "loop.yaml:21: expect[2].signal: regulator lacks the output samples, to which this refers" in result.stderr
    (tmp_path / "mapping.yaml").write_text(vendor.MAPPING + "ignore: [samples]\n")
    result = orchestrate(*arguments)
    assert result.exit_code == 1, "the third expectation is still judged"
    assert "left out, since regulator.samples is not there: the expectation 'sampled'" in result.stderr
    assert "failed         slow" in result.stdout
    assert "not evaluated  sampled" in result.stdout
    assert "expectations: 1 met, 1 not met, 1 not evaluated" in result.stdout
    assert "recorded under their own names: first, second" in result.stderr


def test_expectations_that_are_not_evaluated_are_counted_apart_from_those_that_are_met(tmp_path, monkeypatch):
    extra = "  - {name: sampled, signal: 'regulator.samples[1]', always: {within: [0 V, 1 V]}}\n"
    renamed = (('name="samples[1]"', 'name="first"'), ('name="samples[2]"', 'name="second"'))
    path = swapped(tmp_path, monkeypatch, *renamed, scenario=SCENARIO + extra)
    (tmp_path / "mapping.yaml").write_text(vendor.MAPPING + "ignore: [samples]\n")
    options = ("--swap", "regulator=vendor.fmu", "--map", "mapping.yaml", "--out", "out")
    result = orchestrate(path.name, *options)
    assert result.exit_code == 0, result.stderr
    assert "expectations: 1 met, 1 not evaluated" in result.stdout
    told = json.loads(Path("out/expectations.json").read_text())
    assert [(e["name"], e["status"], e["passed"]) for e in told["expectations"][1:]] == [
        ("sampled", "not evaluated", None)
    ]
    assert told["expectations"][1]["expected"] == "always within [0 V, 1 V]"
    page = Path("out/report.html").read_text("utf-8")
    assert "1 expectation met, 1 not evaluated" in page
    assert "the expectation is met" not in page
    assert "regulator.samples is not there" in page
    again = run(json.loads(Path("out/manifest.json").read_text())["scenario"])
    assert [(e.name, e.status) for e in again.not_evaluated] == [("sampled", "not evaluated")], "as in the first run"
    assert [outcome.name for outcome in again.outcomes] == [told["expectations"][0]["name"]]


@pytest.mark.parametrize(
    ("ignored", "fault"),
    [
        ("speed", "bias: regulator.speed, by: 1 rad/s"),
        ("samples", "cut: 'regulator.samples[1]'"),
        ("gain", "set: regulator.gain = 2"),
    ],
)
def test_a_fault_of_what_the_mapping_ignores_is_refused(tmp_path, monkeypatch, ignored, fault):
    text = SCENARIO + f"faults:\n  - {{at: 1 s, {fault}}}\n"
    renamed = (('name="samples[1]"', 'name="first"'), ('name="samples[2]"', 'name="second"'))
    path = swapped(tmp_path, monkeypatch, *renamed, scenario=text)
    kept = "".join(line for line in vendor.MAPPING.splitlines(True) if not line.startswith(f"  {ignored}:"))
    (tmp_path / "mapping.yaml").write_text(f"{kept}ignore: [{ignored}]\n")
    result = orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")
    assert result.exit_code == 2
    assert "is under 'ignore' in the mapping of regulator, so the fault would change nothing" in result.stderr


def test_a_later_fault_keeps_its_line_when_something_before_it_is_left_out(tmp_path, monkeypatch):
    extra = (
        "  - {name: sampled, signal: 'regulator.samples[1]', always: {within: 1 V}}\n  - {name: wrong, "
        "signal: motor.sped, always: {below: 1 rpm}}\n"
    )
    path = swapped(tmp_path, monkeypatch, ('name="samples[1]"', 'name="first"'), scenario=SCENARIO + extra)
    (tmp_path / "mapping.yaml").write_text(vendor.MAPPING + "ignore: [samples]\n")
    result = orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")
    assert "loop.yaml:22: expect[2].signal: motor has no" in result.stderr


def test_where_theirs_declares_no_feedthrough_that_of_the_interface_is_taken(tmp_path, monkeypatch):
    path = swapped(tmp_path, monkeypatch, ('<Unknown index="5" dependencies="3"/>', '<Unknown index="5"/>'))
    result = orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")
    assert result.exit_code == 0
    assert (
        "does not say on which inputs voltage depends directly; what the interface regulator says is taken"
        in result.stderr
    )
    assert "would close a loop" not in result.stderr
