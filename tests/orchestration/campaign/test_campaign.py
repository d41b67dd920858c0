"""Campaigns of a loop of two small FMUs whose answer is known: the speed after 20 steps of 0.1 s is 0.9^20 of that at the start."""

from __future__ import annotations

import errno
import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow.dataset as ds
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner

from orchestration.campaign import engine
from orchestration.campaign.case import read_campaign
from orchestration.campaign.file.campaign import schema
from orchestration.campaign.flying import batches, crew
from orchestration.campaign.metric_function import FlownMetrics
from orchestration.campaign.replay import replay
from orchestration.cli.main import main
from orchestration.errors import InputError, ResultsError
from orchestration.session.read import read
from orchestration.session.run import run

from .. import vendor

ROOT = Path(__file__).parents[3]
SHRINKS = 0.9**20
FILE = """\
name: toy
scenario: loop.yaml
runs: 60
seed: 4
vary:
  motor.speed0: {uniform: [1 rad/s, 2 rad/s]}
metrics:
  - {name: final, signal: motor.speed, statistic: final}
  - {name: slow, signal: motor.speed, settles: {below: 0.5}}
requirements:
  - {name: at rest, metric: final, below: 0.2 rad/s, probability: 0.3}
"""


@pytest.fixture
def toy(loop):
    """The campaign above, beside the loop, in the current folder."""
    path = loop.with_name("toy.yaml")
    path.write_text(FILE, "utf-8")
    return path


def changed(path, *pairs):
    text = path.read_text("utf-8")
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, "utf-8")
    return path


def fly(path, out="out", **overrides):
    return engine.fly(read_campaign(path, overrides), Path(out), workers=0)


def rows(out="out"):
    """All rows, by index, without the time that they took."""
    table = ds.dataset(Path(out) / "runs", format="parquet").to_table().drop_columns(["wall"])
    return table.sort_by("index").to_pylist()


def command(*arguments):
    result = CliRunner().invoke(main, ["campaign", *map(str, arguments)])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


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


@pytest.mark.parametrize("sampling", ["latin hypercube", "sobol"])
def test_a_design_fills_every_layer_once(toy, sampling):
    changed(toy, ("runs: 60", f"runs: 64\nsampling: {sampling}"))
    fly(toy)
    layers = np.floor((np.array([row["motor.speed0"] for row in rows()]) - 1.0) * 64).astype(int)
    assert sorted(layers) == list(range(64))


def test_a_grid_is_crossed_and_the_rest_is_drawn(toy):
    changed(
        toy,
        ("runs: 60", "sampling: grid"),
        ("vary:", "vary:\n  motor.poles: {grid: [2, 4, 6]}\n  motor.mode: {grid: [normal, brake]}"),
    )
    fly(toy)
    found = rows()
    assert [(row["motor.poles"], row["motor.mode"]) for row in found] == [
        (poles, mode) for poles in (2.0, 4.0, 6.0) for mode in ("normal", "brake")
    ]
    assert len({row["motor.speed0"] for row in found}) == 6
    with pytest.raises(InputError, match="the grid has 6 points"):
        read_campaign(toy, {"runs": 7})


def test_one_value_with_an_error_between_two_blocks(toy):
    changed(
        toy,
        ("vary:", "draw:\n  k: {normal: {mean: 1, deviation: 0.1}}\n  e: {choice: [-0.1, 0.1]}\nvary:"),
        ("  motor.speed0", '  regulator.gain: {expression: "-k * (1 + e)"}\n  motor.speed0'),
    )
    fly(toy, runs=12)
    for row in rows():
        gain = row["k"] * (1.0 + row["e"])
        assert row["regulator.gain"] == -gain
        assert row["final"] == pytest.approx(row["motor.speed0"] * (1.0 - 0.1 * gain) ** 20, rel=1e-12)


def test_an_expression_counts_in_base_units(toy):
    changed(
        toy,
        ("vary:", "draw:\n  turn: {uniform: [60 rpm, 120 rpm]}\nvary:"),
        ("{uniform: [1 rad/s, 2 rad/s]}", '{expression: "turn / 10"}'),
    )
    fly(toy, runs=5)
    for row in rows():
        assert row["motor.speed0"] == pytest.approx(row["turn"] * 2.0 * np.pi / 60.0 / 10.0)


def test_an_expression_sets_whole_numbers_where_the_port_takes_them_and_no_others(toy):
    changed(toy, ("vary:", "draw:\n  half: {choice: [1, 2]}\nvary:\n  motor.poles: {expression: 2 * half}"))
    fly(toy, runs=8)
    assert {(row["half"], row["motor.poles"]) for row in rows()} == {(1.0, 2.0), (2.0, 4.0)}
    changed(toy, ("2 * half", "0.4 * half"))
    with pytest.raises(InputError, match="expected a whole number, found 0.8"):
        read_campaign(toy)


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


def test_a_scenario_in_the_place_of_a_campaign_is_told_in_a_sentence(loop):
    result = command(loop)
    assert (result.exit_code, result.stderr) == (
        2,
        f"{loop}:1: is a scenario; expected a campaign, which names one under 'scenario'; remedy: orchestrate run\n",
    )


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
def test_a_killed_client_goes_on_where_it_was(toy):
    fly(toy)
    code = (
        "import os, sys; from pathlib import Path; from orchestration.campaign import engine; from orchestration.campaign.flying import dataset; "
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


def test_a_metric_of_an_output_that_the_mapping_ignores_is_refused_with_the_reason(toy):
    vendor.write(
        toy.parent, ('name="samples[1]"', 'name="first"'), ('name="samples[2]"', 'name="second"'), runnable=True
    )
    swap = "swap: {regulator: vendor.fmu}\nmap: {regulator: mapping.yaml}"
    changed(
        toy,
        ("runs: 60", f"runs: 60\n{swap}"),
        ("signal: motor.speed, statistic", "signal: regulator.samples, statistic"),
    )
    with pytest.raises(InputError, match="regulator.samples is an output that its FMU lacks; remedy: map it"):
        fly(toy, runs=1)
    path = toy.with_name("mapping.yaml")
    path.write_text(path.read_text() + "ignore: [samples]\n")
    told = "regulator.samples is under 'ignore' in the mapping, so there is no such output; remedy: map it"
    with pytest.raises(InputError, match=told):
        fly(toy, runs=1)


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


def test_a_metric_in_python_is_given_every_base_step(toy):
    Path("mine.py").write_text(
        "def fall(time, signals):\n    return signals['motor.speed'][0] / signals['motor.speed'][-1]\n"
    )
    changed(toy, ("metrics:", "metrics:\n  - {name: fall, python: 'mine:fall', signals: [motor.speed]}"))
    fly(toy, runs=3)
    assert [row["fall"] for row in rows()] == pytest.approx([1.0 / SHRINKS] * 3)
    changed(toy, ("mine:fall", "mine:fal"))
    with pytest.raises(InputError, match=r"toy.yaml:8: .*mine.py has no function 'fal'; did you mean 'fall'"):
        read_campaign(toy)


def test_a_metric_in_python_that_ends_the_process_is_a_failed_run_or_an_error_with_its_line(toy):
    Path("mine.py").write_text("import sys\ndef f(time, signals):\n    sys.exit(7)\n")
    changed(toy, ("metrics:", "metrics:\n  - {name: own, python: 'mine:f', signals: [motor.speed]}"))
    assert fly(toy, runs=3).failed == 3
    assert {row["reason"] for row in rows()} == {"own: mine:f raised SystemExit: 7"}
    Path("mine.py").write_text("import sys\nsys.exit(7)\n")
    with pytest.raises(
        InputError, match=r"toy.yaml:8: .*the module 'mine' cannot be loaded: SystemExit: 7, in .*mine.py"
    ):
        read_campaign(toy)


def test_a_module_of_metrics_may_hold_a_dataclass_with_annotations_as_text(toy):
    code = """\
from __future__ import annotations
from dataclasses import dataclass

@dataclass
class Ends:
    first: float
    last: float

def fall(time, signals):
    speed = signals['motor.speed']
    ends = Ends(speed[0], speed[-1])
    return ends.first / ends.last
"""
    Path("mine.py").write_text(code, "utf-8")
    changed(toy, ("metrics:", "metrics:\n  - {name: fall, python: 'mine:fall', signals: [motor.speed]}"))
    fly(toy, runs=2)
    assert [row["fall"] for row in rows()] == pytest.approx([1.0 / SHRINKS] * 2)
    known = set(sys.modules)
    Path("mine.py").write_text(f"{code}gone", "utf-8")
    with pytest.raises(InputError, match="NameError: name 'gone' is not defined"):
        read_campaign(toy)
    assert set(sys.modules) == known
    assert "mine" not in known


def test_runs_are_kept_with_their_signals(toy):
    changed(toy, ("runs: 60", "runs: 20\nkeep: {runs: [3], not_met: 2}"))
    fly(toy)
    missed = [row["index"] for row in rows() if not row["met: at rest"]][:2]
    kept = sorted({3, *missed})
    assert json.loads(Path("out/campaign.json").read_text("utf-8"))["kept"] == kept
    for index in kept:
        signals = Path(f"out/kept/{index}/signals.csv").read_text("utf-8").splitlines()
        assert len(signals) == 22
        assert float(signals[-1].split(",")[1]) == rows()[index]["final"]


def test_a_decided_campaign_stops_early_and_says_so(toy):
    changed(toy, ("runs: 60", "runs: 2000\nstop: decided"), ("below: 0.2 rad/s", "below: 1 rad/s"))
    finished = fly(toy)
    assert finished.state == "stopped early"
    assert finished.flown < 200
    assert [verdict.status for verdict in finished.verdicts] == ["met"]
    assert fly(toy).flown == finished.flown, "started again, nothing is left to be flown"


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


@pytest.mark.parametrize(
    ("pairs", "message"),
    [
        ((("statistic: final", "statistic: last"),), r"toy.yaml:8: metrics\[1\].statistic: expected 'final'"),
        ((("metric: final", "metric: finl"),), r"toy.yaml:11: .*there is no metric 'finl'; did you mean 'final'"),
        ((("below: 0.2 rad/s", "below: 0.2 kg"),), r"toy.yaml:11: .*the unit 'kg' does not fit"),
        ((("signal: motor.speed, statistic", "signal: motor.sped, statistic"),), r"toy.yaml:8: .*no variable 'sped'"),
        ((("uniform: [1 rad/s, 2 rad/s]", "uniform: [2 rad/s, 1 rad/s]"),), r"toy.yaml:6: .*expected \[low, high\]"),
        ((("uniform: [1 rad/s", "unifrm: [1 rad/s"),), r"toy.yaml:6: .*unknown key 'unifrm'; did you mean 'uniform'"),
        ((("uniform: [1 rad/s, 2 rad/s]", "uniform: [1 m, 2 m]"),), r"toy.yaml:6: .*the unit 'm' does not fit"),
        (
            (("scenario: loop.yaml", "scenario: lop.yaml"),),
            r"lop.yaml: there is no such file; did you mean 'loop.yaml'",
        ),
        ((("runs: 60", "runs: 60\nset: {motor.speed0: 2}"),), r"toy.yaml:4: set.motor.speed0: motor.speed0 varies"),
        ((("runs: 60", "runs: 60\nsampling: grid"),), r"a grid needs an entry"),
        ((("runs: 60", "runs: 60\nstop: decided\nsampling: sobol"),), r"toy.yaml:4: stop: only runs drawn at random"),
        ((("runs: 60", "runs: 60\nsearch: {metric: fnal}"),), r"toy.yaml:4: search: .*no metric 'fnal'; did you mean"),
        ((("runs: 60", "runs: 60\nswap: {motor: gone.fmu}"),), r"toy.yaml:4: swap.motor: there is no FMU .*gone.fmu"),
        ((("runs: 60", "runs: 60\nswap: {engine: gone.fmu}"),), r"toy.yaml:4: swap.engine: there is no block"),
        (
            (("{uniform: [1 rad/s, 2 rad/s]}", '{expression: "[1, 2][3]"}'),),
            r"toy.yaml:6: vary.motor.speed0.expression: .*\[1, 2\] has 2 elements, found \[1, 2\]\[3\]",
        ),
        (
            (("{uniform: [1 rad/s, 2 rad/s]}", f"{{expression: '{'(' * 2000}'}}"),),
            r"toy.yaml:6: \S+: the expression is too long: expected at most 1000 characters, found 2000; remedy: [^(]+$",
        ),
        (
            (("{uniform: [1 rad/s, 2 rad/s]}", "{grid: {from: 0, to: 1, points: 2000000}}"),),
            r"toy.yaml:6: vary.motor.speed0.grid: points: input should be less than or equal to 1000000, found 2000000$",
        ),
        (
            (
                ("signal: motor.speed, statistic: final", "python: 'gone:f', signals: [motor.speed]"),
                ("signal: motor.speed, settles: {below: 0.5}", "python: 'gone:g', signals: [motor.speed]"),
            ),
            r"toy.yaml:8: .*the module 'gone' cannot be loaded: there is no file .*gone.py, and no installed .*remedy: [^\n]*$",
        ),
        ((("{uniform: [1 rad/s, 2 rad/s]}", "{expression: gone}"),), r"toy.yaml:6: .*no value 'gone'"),
        (
            (("vary:", "vary:\n  motor.mode: {choice: [braek, normal]}"),),
            r"toy.yaml:6: vary.motor.mode: .*'braek'",
        ),
        (
            (("vary:", "vary:\n  motor.mode: {choice: [normal, braek, brake], weights: [8, 1, 1]}"),),
            r"toy.yaml:6: vary.motor.mode: .*'braek'",
        ),
        (
            (("vary:", "draw:\n  half: {choice: [1, 1, 1.2]}\nvary:\n  motor.poles: {expression: 2 * half}"),),
            r"toy.yaml:8: vary.motor.poles: .*expected a whole number, found 2.4",
        ),
        (
            (("vary:", "vary:\n  motor.inertia: {grid: {from: 1, to: 14, points: 1000000}}"),),
            r"toy.yaml:6: vary.motor.inertia: .*expected at most 10",
        ),
        (
            (("{uniform: [1 rad/s, 2 rad/s]}", "{sphere: {choice: [1, fast, 2]}}"),),
            r"toy.yaml:6: vary.motor.speed0.sphere: sphere: expected one number as its length, found 'fast'",
        ),
        (
            (("runs: 60", "runs: 60\nkeep: {runs: [9223372036854775808]}"),),
            r"toy.yaml:4: keep.runs\[1\]: expected less than 1e",
        ),
        ((("metric: final, below: 0.2 rad/s", "expectation: stops"),), r"toy.yaml:11: .*no expectation 'stops'"),
    ],
)
def test_a_wrong_file_is_told_with_its_line(toy, pairs, message):
    with pytest.raises(InputError, match=message):
        read_campaign(changed(toy, *pairs))


def test_a_run_to_be_kept_beyond_the_last_is_told(toy):
    case = read_campaign(changed(toy, ("runs: 60", "runs: 60\nkeep: {runs: [3, 60]}")))
    assert "keep.runs: 60: not flown, the last run is 59" in case.notes


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


def test_where_a_metric_fails_every_run_the_verdicts_name_it(toy):
    toy.with_name("measure.py").write_text("def f(time, signals):\n    raise ValueError('nothing')\n", "utf-8")
    changed(toy, ("metrics:", "metrics:\n  - {name: own, python: 'measure:f', signals: [motor.speed]}"))
    verdict = fly(toy, runs=2).verdicts[0]
    assert "; every run failed, the first with: own: " in verdict.text


def test_a_scenario_may_stand_in_the_file_with_what_it_changes(toy):
    changed(toy, ("scenario: loop.yaml", "scenario:\n  extends: loop.yaml\n  duration: 1 s"))
    fly(toy, runs=2)
    assert [row["final"] / row["motor.speed0"] for row in rows()] == pytest.approx([0.9**10] * 2)


def test_a_campaign_extends_another_and_replaces_a_distribution_as_a_whole(toy):
    folder = toy.parent / "deep"
    folder.mkdir()
    changed(toy, ("scenario: loop.yaml", "scenario: {extends: loop.yaml, duration: 1 s}"))
    over = folder / "over.yaml"
    over.write_text(
        f"extends: ../{toy.name}\nname: over\nruns: 3\nvary: {{motor.speed0: {{grid: [2, 4, 8]}}}}\nsampling: grid\n"
    )
    fly(over, out="over")
    assert [row["motor.speed0"] for row in rows("over")] == [2.0, 4.0, 8.0]
    assert [row["final"] / row["motor.speed0"] for row in rows("over")] == pytest.approx([0.9**10] * 3)


def test_a_start_value_for_all_runs_comes_from_the_file_or_the_command_line(toy):
    changed(toy, ("runs: 60", "runs: 3\nset: {regulator.gain: -2}"))
    command(toy, "--workers", 0, "--out", "file")
    command(toy, "--workers", 0, "--out", "option", "--set", "regulator.gain=-3")
    for out, factor in (("file", 0.8), ("option", 0.7)):
        assert [r["final"] / r["motor.speed0"] for r in rows(out)] == pytest.approx([factor**20] * 3)


def test_a_start_value_of_the_command_line_goes_beside_an_empty_set_and_leaves_the_callers_data(toy):
    changed(toy, ("runs: 60", "runs: 60\nset:"))
    assert read_campaign(toy, None, {"regulator.gain": -3}).campaign.set == {"regulator.gain": -3}
    source = read(toy)
    read_campaign(source, None, {"regulator.gain": -3})
    assert source.data["set"] is None
    changed(toy, ("set:", "set: [regulator.gain]"))
    with pytest.raises(InputError, match=r"toy.yaml:4: set: "):
        read_campaign(toy, None, {"regulator.gain": -3})


def test_points_of_the_unit_cube_give_their_metrics(toy):
    case = read_campaign(toy)
    with crew.crew(case.job, 0) as (here, _):
        evaluate = FlownMetrics(case, here)
        unit = np.array([[0.0], [0.25], [1.0]])
        assert evaluate(unit)["final"] == pytest.approx(SHRINKS * np.array([1.0, 1.25, 2.0]))
        assert (evaluate.coordinates, evaluate.metrics) == (["motor.speed0"], {"final": "rad/s", "slow": "s"})
        assert evaluate.values(unit[1]) == {"motor.speed0": "1.25 rad/s"}
        Path("point.yaml").write_text(evaluate.scenario(unit[1]), "utf-8")
    assert run("point.yaml")["motor.speed"][0] == 1.25


def test_batches_grow_to_their_time_and_shrink_towards_the_end():
    cut = batches.Batches(np.arange(100_000), None, slots=2)
    sizes, there = [], []
    while (batch := cut.next()) is not None:
        sizes.append(len(batch.indices))
        there += batch.indices.tolist()
        cut.took(sizes[-1], 0.001 * sizes[-1])
    assert there == list(range(100_000))
    assert sizes[0] == 1
    assert max(sizes) == pytest.approx(batches.TARGET / 0.001, rel=0.01)
    assert sizes[-1] == 1


def test_the_published_schema_is_that_of_the_models():
    assert (ROOT / "docs/campaign.schema.json").read_text("utf-8") == schema()
