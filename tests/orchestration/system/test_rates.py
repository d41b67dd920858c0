"""A block that cannot vary its step: how often it is stepped, and at which times."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from orchestration import run
from orchestration.instances.substeps import Substeps
from tests.commands import orchestrate

from .. import fmus, mocks
from ..swapped import STEP, swapped
from ..wrong_inputs import SCENARIO


@pytest.mark.parametrize(
    ("own", "base", "note", "steps"),
    [
        ("0.1", "0.1 s", "", 20),
        ("0.2", "0.1 s", "it is stepped once in 2 base steps ('every: 2')", 10),
        ("0.025", "0.1 s", "4 of them in each step of 0.1 s", 80),
    ],
)
def test_a_block_that_cannot_vary_its_step_is_stepped_at_its_own(tmp_path, monkeypatch, own, base, note, steps):
    text = SCENARIO.replace("record: {interval: 0.1 s}", "record: {signals: [motor.speed, regulator.count]}")
    counter = (
        '<ScalarVariable name="count" valueReference="1" causality="output" '
        'variability="discrete"><Integer/></ScalarVariable>'
    )
    path = swapped(
        tmp_path,
        monkeypatch,
        (STEP, f'<DefaultExperiment stepSize="{own}"/>{STEP}'),
        ("</ModelVariables>", f"{counter}</ModelVariables>"),
        ("</Outputs>", '<Unknown index="9" dependencies=""/></Outputs>'),
        scenario=text,
    )
    result = orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml", "--out", "out")
    assert result.exit_code == 0, result.output
    assert note in result.stderr
    table = np.genfromtxt("out/signals.csv", delimiter=",", names=True)
    assert table["regulatorcount"][-1] == steps


def test_a_step_that_does_not_divide_is_refused(tmp_path, monkeypatch):
    path = swapped(tmp_path, monkeypatch, (STEP, f'<DefaultExperiment stepSize="0.15"/>{STEP}'))
    result = orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")
    assert result.exit_code == 2
    assert (
        "cannot vary its step of 0.15 s, which is no multiple of the step, 0.1 s; remedy: a base step that "
        "divides it, such as 'step: 0.075 s'" in result.stderr
    )


@pytest.mark.parametrize(
    ("own", "message"),
    [
        ("1e-300", "cannot vary its step of 1e-300 s, more than 10000 of them in each step of 0.1 s; remedy: "),
        ("0", "its stepSize is 0, expected a finite number above 0"),
        ("-0.1", "its stepSize is -0.1, expected"),
        ("INF", "its stepSize is INF, expected"),
        ("1e-999999999", "its stepSize is 1e-999999999, expected"),
    ],
)
def test_a_step_without_end_is_refused(tmp_path, monkeypatch, own, message):
    path = swapped(tmp_path, monkeypatch, (STEP, f'<DefaultExperiment stepSize="{own}"/>{STEP}'))
    result = orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")
    assert (result.exit_code, message in result.stderr) == (2, True), result.stderr


@pytest.mark.parametrize(
    ("own", "note", "steps"), [("0.2", "stepped once in 2 base steps", 10), ("0.025", "4 of them", 80)]
)
def test_a_block_that_is_not_swapped_is_stepped_at_its_own_step_too(tmp_path, monkeypatch, own, note, steps):
    fmus.write_pair(tmp_path)
    xml = fmus.description("motor").replace(STEP, f'<DefaultExperiment stepSize="{own}"/>{STEP}')
    fmus.write(tmp_path / "motor.fmu", xml, fmus.library())
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loop.yaml").write_text(SCENARIO)
    result = run("loop.yaml")
    assert result["motor.steps"][-1] == steps
    assert [text for text in result.warnings if note in text and text.startswith("motor: its FMU cannot vary")]


def test_the_instants_of_substeps_are_multiples_of_the_own_step_and_no_sums():
    """A step of 0.3 s has three of 0.1 s: 0.3 / 3 is not 0.1 as a double, and 0.6 + 0.1 is not 0.7."""
    block = mocks.ramp("ramp")
    stepped = Substeps(3, Fraction("0.1")).before(block)
    stepped.wire([], [], [0, 0, 0, 0], np.zeros(0))
    for count in range(4):
        stepped.do_step(count * 3 / 10, 0.3)
    assert [call[1:] for call in block.calls if call[0] == "do_step"] == [(n / 10, 0.1) for n in range(12)]


@pytest.mark.parametrize(("steps", "apart"), [(7, 2), (8, 2), (7, 3), (6, 3), (5, 1), (9, 2)])
def test_samples_are_those_of_the_interval_and_of_the_end(loop, steps, apart):
    text = SCENARIO.replace("interval: 0.1 s", f"interval: {0.1 * apart:g} s")
    loop.write_text(f"{text}isolation: none\n")
    result = run(loop, duration=0.1 * steps)
    wanted = sorted({*range(0, steps + 1, apart), steps})
    assert result.time == pytest.approx([0.1 * k for k in wanted])
    assert result["motor.speed"] == pytest.approx([2.0 * 0.9**k for k in wanted])
