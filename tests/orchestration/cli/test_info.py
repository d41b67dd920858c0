"""`orchestrate info`: what a block or an FMU is, for a reader and for a program."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from fmus.interface import BLOCKS, SOURCE, load
from orchestration.quantities import parse_unit
from tests.commands import orchestrate

from .. import fmus

pytestmark = pytest.mark.isolate

EVIL = "\x1b[2Jgone [bold]x[/bold]"


@pytest.mark.parametrize("block", BLOCKS)
def test_a_block_is_told_as_its_interface_says_it(block):
    data = json.loads(orchestrate("info", block, "--json").stdout)
    told = {v["name"]: v for v in data["variables"]}
    interface = load(block)
    assert set(told) == {*interface.variables, *interface.helpers}
    for name, variable in interface.variables.items():
        entry = told[name]
        assert entry["causality"] == variable.causality
        assert entry["shape"] == list(variable.shape)
        assert entry["frame"] == variable.frame
        assert entry["description"] == variable.description
        assert (entry["min"], entry["max"]) == (variable.min, variable.max)
        if variable.type == "real" and variable.unit and "," not in variable.unit:
            assert parse_unit(entry["unit"]).factor == parse_unit(variable.unit).factor
        if variable.causality != "output":
            assert entry["start"] == (None if variable.optional else variable.start)


def test_a_block_s_equations_and_what_they_cite_are_shown():
    told = " ".join(orchestrate("info", "plant").stdout.split())
    for equation, meaning in load("plant").equations:
        assert " ".join(equation.split()) in told
        assert " ".join(meaning.split()) in told
    assert load("plant").limits[0] in told
    assert SOURCE in told
    assert SOURCE not in " ".join(orchestrate("info", "supervisor").stdout.split())
    assert "Equations" not in orchestrate("info", "plant", "epoch").stdout


def test_a_narrow_terminal_gets_narrow_tables(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    told = orchestrate("info", "plant").stdout
    assert max(map(len, told.splitlines())) <= 80
    assert "rod_gain[3]" in told


def test_a_name_or_a_pattern_shows_these_variables_only():
    told = orchestrate("info", "plant", "rod_*", "epoch").stdout
    assert "rod_period" in told
    assert "epoch" in told
    assert "wheel_inertia" not in told
    wrong = orchestrate("info", "plant", "rod_perod")
    assert (wrong.exit_code, wrong.stderr) == (2, "there is no variable 'rod_perod'; did you mean 'rod_period'?\n")


def test_what_is_no_block_is_told_from_what_it_may_be():
    assert "there is no block 'plnt'; did you mean 'plant'?" in orchestrate("info", "plnt").stderr
    assert "orchestrate validate says what a scenario is" in orchestrate("info", "loop.yaml").stderr
    assert "there is no FMU" in orchestrate("info", "vendor.fmu").stderr


def test_an_fmu_that_cannot_run_here_is_told_all_the_same(tmp_path, monkeypatch):
    text = fmus.description("motor").replace(
        'modelName="motor"', f'modelName="motor" description="{EVIL}"'.replace("\x1b", "&#x9b;")
    )
    fmus.write(tmp_path / "motor.fmu", text)
    monkeypatch.chdir(tmp_path)
    told = orchestrate("info", "motor.fmu")
    assert told.exit_code == 0, told.output
    assert "motor: FMI 2.0 FMU for co-simulation" in told.stdout
    assert "\\x9b[2Jgone [bold]x[/bold]" in told.stdout, "what an FMU says is shown, never obeyed"
    assert "speed" in told.stdout
    data = json.loads(orchestrate("info", str(Path("motor.fmu")), "--json").stdout)
    speed = next(v for v in data["variables"] if v["name"] == "speed")
    assert (speed["causality"], speed["unit"], speed["shape"]) == ("output", "rad/s", [])
