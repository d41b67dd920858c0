"""The folder of a campaign belongs to it: what differs is refused by name."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from orchestration.campaign import engine, sums
from orchestration.campaign.case import read_campaign
from orchestration.campaign.record import manifest
from orchestration.campaign.statistics.verdicts import Announced
from orchestration.errors import InputError

from .toy import changed, fly


def test_a_manifest_of_an_earlier_version_in_the_folder_is_refused_by_name(toy):
    fly(toy, runs=5)
    path = Path("out/campaign.json")
    record = json.loads(path.read_text("utf-8"))
    del record["sha256"]
    path.write_text(json.dumps(record), "utf-8")
    with pytest.raises(
        InputError, match=r"campaign.json is no manifest of a campaign, or one without SHA-256 of an earl"
    ):
        fly(toy, runs=5)


@pytest.mark.parametrize(("sampling", "runs"), [("grid", (4, 6)), ("sobol", (4, 8)), ("latin hypercube", (4, 5))])
def test_another_number_of_runs_is_said_where_it_moves_the_points(toy, sampling, runs):
    changed(toy, ("runs: 60", f"sampling: {sampling}"), ("{uniform: [1 rad/s, 2 rad/s]}", "{grid: [1 rad/s, 2 rad/s]}"))
    fly(toy, runs=runs[0])
    told = (
        f"differs in the number of runs ({runs[0]} there, {runs[1]} here), on which the points of {sampling} depend; "
    )
    with pytest.raises(InputError, match=re.escape(told)):
        fly(toy, runs=runs[1])


def test_another_campaign_in_the_folder_is_refused_by_name(toy):
    fly(toy, runs=5)
    with pytest.raises(InputError, match=r"out holds the campaign 'toy', which differs in seed; remedy"):
        fly(toy, runs=5, seed=1)
    changed(toy, ("2 rad/s]", "3 rad/s]"))
    with pytest.raises(InputError, match="differs in what varies"):
        fly(toy, runs=5)
    changed(toy, ("3 rad/s]", "2 rad/s]"))
    with pytest.raises(InputError, match=r"out holds 5 runs, more than the 3"):
        fly(toy, runs=3)


def test_what_decides_no_row_of_the_scenario_may_change_and_what_does_may_not(toy, loop):
    fly(toy, runs=3)
    before = read_campaign(toy, {"runs": 3}).fingerprint
    more = """\
live: {sliders: [{start: motor.speed0, least: 1, most: 2}]}
realtime: {factor: 2}
holds: [{name: gain, signal: regulator.enabled, keeps: [motor.speed]}]
consistency: {still: {left: motor.speed, right: motor.speed, within: 1 rad/s}}
figures: [{name: speed, panels: [{signals: [motor.speed]}]}]
"""
    text = loop.read_text("utf-8")
    loop.write_text(text + more, "utf-8")
    assert read_campaign(toy, {"runs": 3}).fingerprint == before
    assert fly(toy, runs=3).state == "completed"
    loop.write_text(text + "exchange: parallel\n", "utf-8")
    with pytest.raises(InputError, match="differs in scenario"):
        fly(toy, runs=3)


def test_how_sure_a_requirement_has_to_be_decides_no_row_and_its_bound_does(toy):
    before = read_campaign(toy).parts
    changed(toy, ("probability: 0.3", "probability: 0.4, confidence: 0.9"))
    assert read_campaign(toy).parts == before
    changed(toy, ("below: 0.2 rad/s", "below: 0.3 rad/s"))
    assert {name for name, part in read_campaign(toy).parts.items() if part != before[name]} == {"requirements"}


def test_time_and_begin_of_an_earlier_start_count_too(toy):
    fly(toy, runs=5)
    record = {**sums.read(Path("out")), "wall_time": 1000.0, "started": "2020-01-01T00:00:00+00:00"}
    record.pop("sha256")
    sums.write(Path("out"), record)
    for runs in (10, 15):
        fly(toy, runs=runs)
    record = sums.read(Path("out"))
    assert record["started"] == "2020-01-01T00:00:00+00:00"
    assert 1000.0 < record["wall_time"] < 1100.0
    assert record["finished"] > record["started"]


def test_an_interrupted_campaign_counts_no_run_behind_the_first_that_is_missing(toy):
    """The first part is gone: of its runs few are flown again, and those of the second are not counted with them."""
    for runs in (5, 10):
        fly(toy, runs=runs)
    sorted(Path("out/runs").iterdir())[0].unlink()

    def tell(at):
        raise KeyboardInterrupt

    stopped = engine.fly(read_campaign(toy, {"runs": 10}), Path("out"), workers=0, tell=tell)
    assert 5 < stopped.flown < 10
    assert f" of {stopped.flown - 5} runs " in stopped.verdicts[0].text


def test_the_manifest_says_by_what_a_requirement_is_met_and_when_the_campaign_was_over(toy):
    fly(toy, runs=3)
    left = json.loads((toy.parent / "out/campaign.json").read_text("utf-8"))
    assert [(one["name"], one["metric"]) for one in left["requirements"]] == [("at rest", "final")]
    assert left["started"] <= left["finished"]
    assert 0.0 < left["wall_time"] < 60.0
    case, data = read_campaign(toy, {"runs": 3}), SimpleNamespace(files={}, withdrawn=[])
    data.done = data.failed = np.zeros(3, bool)
    first = manifest(case, "running", data, [], 5.0, {}, Announced(3, False))
    assert (first["finished"], first["wall_time"]) == (None, 0.0)
    again = manifest(case, "running", data, [], 5.0, {"wall_time": 7.0, "started": "then"}, Announced(3, False))
    assert (again["finished"], again["wall_time"], again["started"]) == (None, 7.0, "then")
    over = manifest(case, "completed", data, [], 5.0, {"wall_time": 7.0}, Announced(3, False))
    assert over["wall_time"] == 12.0
    assert over["finished"] is not None
