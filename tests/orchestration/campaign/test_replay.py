"""A single run of a campaign again."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from orchestration.campaign.case import read_campaign
from orchestration.campaign.replay import replay
from orchestration.cli.main import main
from orchestration.session.run import run

from .toy import changed, command, fly, rows


@pytest.mark.parametrize("index", [0, 17])
def test_a_replayed_run_gives_its_rows_bits(toy, index):
    fly(toy)
    result = command(toy, "--out", "out", "--replay", index)
    assert result.exit_code in (0, 1)
    scenario = Path(f"out/replay-{index}/scenario.yaml")
    row = rows()[index]
    assert run(scenario)["motor.speed"][-1] == row["final"]
    assert CliRunner().invoke(main, ["run", str(scenario), "--out", "again"]).exit_code == 0
    again = replay(read_campaign(toy), index, Path("again"))
    assert again.metrics == {"final": row["final"], "slow": row["slow"]}
    assert again.met == {"at rest": row["met: at rest"]}


def test_a_run_of_another_campaign_than_the_folders_is_not_replayed(toy):
    fly(toy, runs=3)
    result = command(toy, "--out", "out", "--seed", 9, "--replay", 1)
    assert (result.exit_code, "out holds the campaign 'toy', which differs in seed; remedy" in result.stderr) == (
        2,
        True,
    )
    result = command(toy, "--out", "out", "--set", "regulator.gain=2", "--replay", 1)
    assert (result.exit_code, "differs in start values" in result.stderr) == (2, True)


def test_a_run_beyond_the_files_number_is_replayed_where_the_folder_has_it(toy):
    fly(toy, runs=62)
    assert command(toy, "--out", "out", "--replay", 61).exit_code in (0, 1)
    result = command(toy, "--out", "out", "--replay", 62)
    assert (result.exit_code, result.stderr) == (2, "--replay 62: the campaign has the runs 0 to 61; remedy: --runs\n")


def test_a_replayed_run_whose_folder_cannot_be_written_is_told_by_its_status(toy, monkeypatch):
    Path("out/replay-0/scenario.yaml").mkdir(parents=True)
    result = command(toy, "--out", "out", "--replay", 0)
    assert (result.exit_code, "scenario.yaml cannot be written: it is a folder" in result.stderr) == (4, True)
    monkeypatch.setattr("orchestration.cli.campaign.replay", lambda *a: pytest.fail("it was flown"))
    result = command(toy, "--out", "toy.yaml", "--replay", 0)
    assert (result.exit_code, "toy.yaml is a file" in result.stderr) == (2, True)


@pytest.mark.parametrize("index", ["best", "-1", "9" * 5000])
def test_what_is_no_index_of_a_run_is_not_replayed(toy, index):
    result = command(toy, "--out", "out", "--replay", index)
    assert result.exit_code == 2
    assert result.stderr == f"--replay {index[:20]}: expected the index of a run, 0 to 59, or 'worst'\n"


def test_a_replayed_run_is_shown_with_units_and_with_why_it_does_not_meet_its_requirement(toy):
    changed(
        toy,
        ("settles: {below: 0.5}", "settles: {below: 0.01}"),
        ("metric: final, below: 0.2 rad/s", "metric: slow, below: 3 s"),
    )
    shown = command(toy, "--workers", 0, "--out", "out", "--replay", 1).stdout
    assert re.search(r"motor.speed0  1\.\d+ rad/s\n", shown)
    assert re.search(r"slow +never\n", shown)
    assert re.search(r"not met +at rest: slow < 3 s; slow is never\n", shown)
    assert "inf" not in shown
