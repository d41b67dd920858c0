"""`orchestrate validate`: all checks and no run."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from orchestration.instances.slave import Slave
from tests.commands import orchestrate

pytestmark = pytest.mark.isolate


@pytest.fixture
def unrun(loop, monkeypatch):
    """The loop, whose FMUs refuse to be loaded."""

    def loaded(*arguments, **options):
        raise AssertionError("an FMU is loaded")

    monkeypatch.setattr(Slave, "__init__", loaded)
    return loop


def test_it_says_what_would_run_and_runs_nothing(unrun):
    told = orchestrate("validate", unrun.name)
    assert (told.exit_code, told.stderr) == (0, "")
    assert "loop: valid scenario; nothing was run" in told.stdout
    words = [line.split() for line in told.stdout.splitlines()]
    assert ["motor", "motor.fmu", "0.1", "s", "this", "process", "2"] in words
    assert ["steps", "20", "of", "0.1", "s:", "2", "s,", "sequential"] in words
    assert not Path("results").exists()


def test_what_it_says_is_what_a_run_does(loop):
    told = orchestrate("validate", loop.name, "--duration", "1.05 s").stdout
    orchestrate(loop.name, "--duration", "1.05 s", "-q")
    manifest = json.loads(Path("results/loop/manifest.json").read_text())
    signals = len(Path("results/loop/signals.csv").read_text().splitlines()[0].split(",")) - 1
    assert f"{manifest['steps']} of 0.1 s: 1.1 s" in told
    assert f"{signals} signals every 0.1 s: {manifest['samples']} samples" in told


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            ("--set", "motor.inertai=1"),
            "--set motor.inertai=1: motor has no parameter 'inertai'; did you mean 'inertia'?",
        ),
        (("--step", "0.3 rpm"), "--step 0.3 rpm: "),
        (("--format", "xls"), "xls"),
        (("--swap", "motor=none.fmu"), "there is no FMU none.fmu"),
    ],
)
def test_what_a_run_refuses_it_refuses(unrun, options, message):
    checked, run = orchestrate("validate", unrun.name, *options), orchestrate(unrun.name, *options)
    assert (checked.exit_code, run.exit_code) == (2, 2)
    assert checked.stderr == run.stderr
    assert message in checked.stderr


def test_quiet_says_nothing_of_what_is_valid(unrun):
    told = orchestrate("validate", unrun.name, "-q")
    assert (told.exit_code, told.output) == (0, "")


@pytest.fixture
def campaign(unrun):
    """A campaign on the loop, as a file."""
    path = Path("spread.yaml")
    path.write_text(
        f"name: spread\nscenario: {unrun.name}\nruns: 7\nseed: 3\n"
        "vary: {motor.inertia: {uniform: [1, 2]}}\nmetrics: [{name: last, signal: motor.speed, statistic: final}]\n"
    )
    return path


def test_a_campaign_is_checked_and_not_flown(campaign):
    told = orchestrate("validate", campaign.name)
    assert (told.exit_code, told.stderr) == (0, "")
    lines = [" ".join(line.split()) for line in told.stdout.splitlines()]
    assert lines[0] == "spread: valid campaign; nothing was run"
    assert {"runs 7, random, seed 3", "varied motor.inertia: uniform from 1 to 2"} < set(lines)
    assert not Path("results").exists()


def test_what_is_wrong_in_a_campaign_is_located(campaign):
    campaign.write_text(campaign.read_text().replace("motor.inertia", "motor.inertai"))
    told = orchestrate("validate", campaign.name)
    assert told.exit_code == 2
    assert "spread.yaml:5: vary.motor: motor has no parameter 'inertai'" in told.stderr


def test_options_of_a_run_are_refused_with_a_campaign(campaign):
    told = orchestrate("validate", campaign.name, "--step", "0.1 s")
    assert told.exit_code == 2
    assert "--step: spread.yaml is a campaign" in told.stderr


def test_a_run_of_a_campaign_is_refused_in_one_sentence(campaign):
    told = orchestrate("run", campaign.name)
    assert told.exit_code == 2
    assert told.stderr.count("spread.yaml") == 1
    assert "is a campaign, which varies the scenario under 'scenario'; remedy: orchestrate campaign" in told.stderr


def test_what_is_wrong_with_the_controls_of_a_live_page_is_noted_with_its_place(unrun):
    path = unrun.with_name("page.yaml")
    controls = (
        "live: {sliders: [{start: motor.inertai, least: 0.1, most: 1}],"
        " faults: [{name: late, set: regulator.gain = 1, at: 60 s}]}\n"
    )
    path.write_text(unrun.read_text("utf-8") + controls, "utf-8")
    told = orchestrate("validate", path.name)
    assert told.exit_code == 0
    line = len(path.read_text("utf-8").splitlines())
    noted = " ".join(told.stderr.split())
    assert (
        f"note: page.yaml:{line}: live.sliders[1]: motor.inertai: motor has no parameter or input 'inertai';"
        " did you mean 'inertia'? (orchestrate live refuses this)" in noted
    )
    assert f"note: page.yaml:{line}: live.faults[1]: 60 s lies after the end of the run" in noted
    assert orchestrate("live", path.name, "--out", "page.html").exit_code == 2
