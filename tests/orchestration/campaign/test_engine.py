"""A campaign from its first run to its verdicts, on a loop of two small FMUs whose answer is known."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from orchestration.campaign import engine
from orchestration.campaign.case import read_campaign
from orchestration.errors import ResultsError

from .toy import ROOT, SHRINKS, changed, command, fly, rows


def test_each_run_has_the_closed_forms_metrics(toy):
    finished = fly(toy)
    assert (finished.state, finished.flown, finished.failed) == ("completed", 60, 0)
    found = rows()
    assert [row["index"] for row in found] == list(range(60))
    for row in found:
        speed0 = row["motor.speed0"]
        assert 1.0 <= speed0 <= 2.0
        assert row["final"] == pytest.approx(SHRINKS * speed0, rel=1e-12)
        steps = np.ceil(np.log(0.5 / speed0) / np.log(0.9))
        assert row["slow"] == pytest.approx(0.1 * steps)
        assert row["met: at rest"] == (row["final"] < 0.2)
        assert row["expect: the motor stops"] == (speed0 < np.pi)
    manifest = json.loads(Path("out/campaign.json").read_text("utf-8"))
    assert manifest["state"] == "completed"
    assert manifest["varied"][0]["text"] == "uniform from 1 rad/s to 2 rad/s"
    assert manifest["verdicts"][0]["met"] == sum(row["met: at rest"] for row in found)


def test_a_run_depends_on_seed_and_index_alone(toy):
    fly(toy)
    fly(toy, "more", runs=80)
    fly(toy, "other", seed=5)
    assert rows("more")[:60] == rows()
    assert rows("other")[7] != rows()[7]


def test_a_stopped_campaign_goes_on_where_it_was(toy):
    fly(toy)
    whole = rows()
    flown = []

    def stop(at):
        flown.append(at.flown)
        if at.flown >= 20:
            raise KeyboardInterrupt

    interrupted = engine.fly(read_campaign(toy), Path("two"), workers=0, tell=stop)
    assert (interrupted.state, interrupted.interrupted) == ("interrupted", 2)
    there = rows("two")
    assert 20 <= len(there) < 60
    assert json.loads(Path("two/campaign.json").read_text("utf-8"))["state"] == "interrupted"
    finished = fly(toy, "two")
    assert finished.state == "completed"
    assert rows("two") == whole
    assert sum(pq.read_metadata(part).num_rows for part in Path("two/runs").glob("*.parquet")) == 60, "no run twice"


@pytest.mark.isolate
@pytest.mark.thorough
def test_a_killed_client_goes_on_where_it_was(toy):
    fly(toy)
    code = (
        "import os, sys; from pathlib import Path; from orchestration.campaign import engine; from "
        "orchestration.campaign.flying import dataset; "
        "from orchestration.campaign.case import read_campaign; dataset._EVERY = dataset._SHARE = 0.0; "
        "engine.fly(read_campaign('toy.yaml'), Path('two'), workers=0, "
        "tell=lambda at: at.flown >= 25 and os.kill(os.getpid(), 9))"
    )
    killed = subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": str(ROOT)}, check=False)
    assert killed.returncode == -signal.SIGKILL
    assert json.loads(Path("two/campaign.json").read_text("utf-8"))["state"] == "running"
    assert 20 <= len(rows("two")) < 60
    fly(toy, "two")
    assert rows("two") == rows()


def test_a_full_disk_leaves_what_was_written(toy, monkeypatch):
    write, parts = pq.write_table, []

    def full(table, path, **more):
        parts.append(path)
        if len(parts) > 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        write(table, path, **more)

    with monkeypatch.context() as patch:
        patch.setattr("orchestration.campaign.flying.dataset._EVERY", 0.0)
        patch.setattr("orchestration.campaign.flying.dataset._SHARE", 0.0)
        patch.setattr(pq, "write_table", full)
        with pytest.raises(
            ResultsError, match=r"the runs cannot be written: .*part-000002\.parquet: the disk is full; the runs"
        ):
            fly(toy)
    before = rows()
    assert 2 <= len(before) < 60
    assert fly(toy).state == "completed"
    assert rows()[:1] == before[:1]
    assert len(rows()) == 60


def test_a_run_that_fails_is_a_row_with_its_reason(toy):
    changed(toy, ("vary:", "vary:\n  motor.fault: {choice: [0, 1], weights: [3, 1]}"))
    finished = fly(toy)
    failed = [row for row in rows() if row["status"] == "failed"]
    assert 5 < len(failed) == finished.failed < 30
    for row in rows():
        assert (row["motor.fault"] == 1.0) == (row["status"] == "failed")
    assert failed[0]["reason"].startswith(
        "motor: fmi2DoStep at 0 s: gave status error\n  motor logged: [error] cannot step"
    )
    assert failed[0]["final"] is None
    assert failed[0]["met: at rest"] is None
    assert finished.verdicts[0].met <= 60 - len(failed)


def test_a_value_beyond_its_limits_fails_its_run_alone(toy):
    changed(toy, ("vary:", "vary:\n  motor.inertia: {uniform: [0, 1]}"))
    fly(toy, runs=5)
    assert all(row["status"] == "ok" for row in rows())
    changed(toy, ("motor.inertia: {uniform: [0, 1]}", "motor.inertia: {uniform: [5, 14]}"))
    fly(toy, "two", runs=20)
    for row in rows("two"):
        assert (row["motor.inertia"] > 10.0) == (row["status"] == "failed")
        if row["status"] == "failed":
            assert "motor.inertia=" in row["reason"]
            assert "expected at most 10" in row["reason"]


def test_an_fmu_whose_reset_resets_nothing_is_instantiated_for_each_run(toy):
    changed(toy, ("metrics:", "metrics:\n  - {name: count, signal: motor.steps, statistic: final}"))
    remarks = []
    engine.fly(read_campaign(toy, {"runs": 4}), Path("out"), workers=0, remark=remarks.append)
    assert [row["count"] for row in rows()] == [20.0] * 4
    assert remarks == ["fmi2Reset does not bring back an FMU's first state, so FMUs are instantiated for each run"]


def test_a_decided_campaign_stops_early_and_says_so(toy):
    changed(toy, ("runs: 60", "runs: 2000\nstop: decided"), ("below: 0.2 rad/s", "below: 1 rad/s"))
    finished = fly(toy)
    assert finished.state == "stopped early"
    assert finished.flown < 200
    assert [verdict.status for verdict in finished.verdicts] == ["met"]
    assert fly(toy).flown == finished.flown, "started again, nothing is left to be flown"


def test_a_look_counts_no_run_beyond_it_whatever_has_been_flown(toy, monkeypatch):
    changed(toy, ("runs: 60", "runs: 2000\nstop: decided"), ("below: 0.2 rad/s", "below: 1 rad/s"))
    first = fly(toy, "first")
    flown = engine.Flights.up_to
    monkeypatch.setattr(engine.Flights, "up_to", lambda self, look, tell: flown(self, look + 40, tell))
    ahead = fly(toy, "ahead")
    assert ahead.flown > first.flown
    assert ahead.verdicts == first.verdicts


def test_the_share_of_runs_is_the_probability_in_closed_form(toy):
    """Below 0.2 rad/s ends what starts below 0.2/0.9^20 = 1.645 rad/s, of 1 to 2."""
    finished = fly(toy, runs=400)
    assert finished.verdicts[0].low < 0.2 / SHRINKS - 1.0 < finished.verdicts[0].high
    assert finished.verdicts[0].status == "met"


@pytest.mark.parametrize(
    ("pairs", "status"),
    [
        ((), 0),
        ((("probability: 0.3", "probability: 0.95"),), 1),
        ((("probability: 0.3", "probability: 0.65"),), 1),
        ((("vary:", "vary:\n  motor.fault: {choice: [1]}"),), 3),
        ((("vary:", "vary:\n  motor.sped0: {choice: [1]}"),), 2),
    ],
)
def test_the_exit_status_tells_what_came_of_it(toy, pairs, status):
    runs = 3 if status == 3 else 60
    result = command(changed(toy, *pairs), "--workers", 0, "--out", "out", "--runs", runs)
    assert result.exit_code == status
    if status == 1:
        word = "undecided" if "0.65" in toy.read_text("utf-8") else "not met"
        assert f"{word}  " in result.stdout
    if status == 2:
        assert "toy.yaml:6: vary.motor: motor has no parameter 'sped0'; did you mean 'speed0'?" in result.stderr
    if status == 3:
        assert "every run failed, the first with: motor: fmi2DoStep" in result.stderr


def test_where_a_metric_fails_every_run_the_verdicts_name_it(toy):
    toy.with_name("measure.py").write_text("def f(time, signals):\n    raise ValueError('nothing')\n", "utf-8")
    changed(toy, ("metrics:", "metrics:\n  - {name: own, python: 'measure:f', signals: [motor.speed]}"))
    verdict = fly(toy, runs=2).verdicts[0]
    assert "; every run failed, the first with: own: " in verdict.text
