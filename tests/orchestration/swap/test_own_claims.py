"""Expectations rest on the plant's truth: a controller that does nothing and reports no error meets none of the claims
of settling."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from fmus import kit
from fmus.build import Block, build
from fmus.interface import load, parse
from orchestration.session.read import load as load_scenario
from tests.commands import orchestrate

pytestmark = [pytest.mark.compile, pytest.mark.isolate, pytest.mark.fly]

SCENARIOS = Path(__file__).parents[3] / "scenarios"
PAPER = SCENARIOS / "paper_no_singularity.yaml"
TEXT = re.sub(r"(?=\b(satellites|consistency)/)", f"{SCENARIOS.as_posix()}/", PAPER.read_text("utf-8"))
"""The scenario as it may stand in any folder."""
SETTLED = ["attitude error settled within 1/30 orbit", "rate error settled within 1/30 orbit"]


def idle(folder: Path, *without: str) -> Path:
    """A controller that gives zero in every output, without these outputs: the kit's, before a team fills it in."""
    source = load("controller").source
    for name in without:
        source = re.sub(rf"\[variables\.{name}\]\n(?:.+\n)+", "", source)
    interface = parse(source)
    kit.write(interface, folder, "python")
    return build([Block(interface, folder / "controller")], "python", folder)["controller"]


@pytest.fixture(scope="module")
def doing_nothing(tmp_path_factory) -> Path:
    return idle(tmp_path_factory.mktemp("idle"))


@pytest.fixture(scope="module")
def without_errors(tmp_path_factory) -> Path:
    return idle(tmp_path_factory.mktemp("silent"), "attitude_error", "rate_error_B")


@pytest.fixture
def judging_itself(tmp_path) -> Path:
    """The paper's scenario with its claims read from the controller's own outputs."""
    path = tmp_path / "own.yaml"
    path.write_text(TEXT.replace("judge.attitude_error", "controller.attitude_error"), "utf-8")
    return path


def test_a_controller_that_does_nothing_and_reports_no_error_fails_the_claims_of_settling(doing_nothing, tmp_path):
    result = orchestrate(PAPER, "--swap", f"controller={doing_nothing}", "--out", tmp_path / "out")
    assert result.exit_code == 1, result.output
    outcomes = json.loads((tmp_path / "out" / "expectations.json").read_text("utf-8"))["expectations"]
    failed = [outcome["name"] for outcome in outcomes if not outcome["passed"]]
    assert failed[:2] == SETTLED
    assert "proves nothing" not in result.stderr


def test_it_would_meet_the_claim_that_reads_its_own_output_and_a_warning_says_so(
    doing_nothing, judging_itself, tmp_path
):
    result = orchestrate(judging_itself, "--swap", f"controller={doing_nothing}", "--out", tmp_path / "out")
    outcomes = json.loads((tmp_path / "out" / "expectations.json").read_text("utf-8"))["expectations"]
    passed = {outcome["name"]: outcome["passed"] for outcome in outcomes}
    assert [passed[name] for name in SETTLED] == [True, False]
    assert (
        f"expectation '{SETTLED[0]}' reads controller.attitude_error, an output of the swapped block itself, "
        "which proves nothing; remedy: read the plant's truth, for example by plant_judge"
    ) in result.stderr


def test_compare_and_check_warn_of_a_claim_that_reads_the_swapped_blocks_own_output(
    doing_nothing, judging_itself, tmp_path
):
    text = f"expectation '{SETTLED[0]}' reads controller.attitude_error, an output of the swapped block itself"
    swap = ("--swap", f"controller={doing_nothing}", "--duration", "5 s", "--out", tmp_path / "out")
    compared = orchestrate("compare", judging_itself, *swap)
    assert text in compared.stderr
    assert any(text in note for note in json.loads((tmp_path / "out" / "comparison.json").read_text("utf-8"))["notes"])
    check = ("check", doing_nothing, "--as", "controller", "--scenario")
    checked = orchestrate(*check, judging_itself, "--json")
    claims = [f for f in json.loads(checked.stdout)["findings"] if f["topic"] == "claims"]
    assert [(f["level"], text in f["text"]) for f in claims] == [("warning", True)]
    assert claims[0]["remedy"] == "read the plant's truth, for example by plant_judge"
    assert checked.exit_code == 0, "a warning"
    assert "proves nothing" not in orchestrate(*check, PAPER).stdout


def test_check_refuses_a_scenario_without_the_block(doing_nothing):
    result = orchestrate("check", doing_nothing, "--as", "controller", "--scenario", SCENARIOS / "minimal.yaml")
    assert result.exit_code == 2
    assert "minimal.yaml has no block with the interface 'controller'; its blocks are plant" in result.stderr


def test_no_scenario_of_ours_has_a_claim_that_reads_what_a_controller_says_of_its_own_errors():
    read = {
        path.stem: [f"{e.signal}" for e in load_scenario(path).expect if e.signal.block == "controller"]
        for path in SCENARIOS.glob("*.yaml")
    }
    assert set(map(tuple, read.values())) == {()}


def test_a_controller_without_errors_flies_the_papers_scenario_and_is_judged(without_errors, tmp_path):
    result = orchestrate(PAPER, "--swap", f"controller={without_errors}", "--out", tmp_path / "out")
    assert result.exit_code == 1, result.output
    assert f"failed  {SETTLED[0]}" in result.stdout
    assert "its FMU lacks the outputs attitude_error, rate_error_B, not recorded then" in result.stderr


@pytest.mark.parametrize("ignored", [True, False])
def test_a_figure_that_loses_all_its_panels_is_left_out_with_a_note(without_errors, tmp_path, ignored):
    """A figure of two panels of one signal each, as the paper's scenario had it; and one that keeps a panel and a
    curve."""
    text = TEXT.split("\nexpect:")[0].replace("duration: 386.1 s", "duration: 1 s")
    path = tmp_path / "figures.yaml"
    path.write_text(
        text
        + """
figures:
  - name: gone
    shade: allocator.holding
    panels:
      - {signals: [controller.attitude_error]}
      - {signals: [controller.rate_error_B], measure: norm}
  - name: kept
    panels:
      - {signals: [controller.attitude_error, judge.attitude_error], names: [own, true angle]}
      - {signals: [controller.rate_error_B]}
""",
        "utf-8",
    )
    options = ["--swap", f"controller={without_errors}", "--out", tmp_path / "out"]
    if ignored:
        (tmp_path / "mapping.yaml").write_text("ignore: [attitude_error, rate_error_B]\n", "utf-8")
        options += ["--map", tmp_path / "mapping.yaml"]
    result = orchestrate(path, *options)
    assert result.exit_code == 0, result.output
    assert (
        "left out, since controller.attitude_error, controller.rate_error_B are not there: "
        "a curve of the figure 'kept'; the figure 'gone'; a panel of the figure 'kept'"
    ) in result.stderr
    left = json.loads((tmp_path / "out" / "manifest.json").read_text("utf-8"))["scenario"]["figures"]
    assert [figure["name"] for figure in left] == ["kept"]
    assert [(p["signals"], p["names"]) for p in left[0]["panels"]] == [(["judge.attitude_error"], ["true angle"])]


def test_where_all_signals_to_be_recorded_are_gone_all_outputs_are_recorded(without_errors, tmp_path):
    text = TEXT.split("\nexpect:")[0].replace("duration: 386.1 s", "duration: 1 s")
    path = tmp_path / "recorded.yaml"
    path.write_text(f"{text}\nrecord: {{signals: [controller.attitude_error]}}\n", "utf-8")
    (tmp_path / "mapping.yaml").write_text("ignore: [attitude_error, rate_error_B]\n", "utf-8")
    options = ("--map", tmp_path / "mapping.yaml", "--out", tmp_path / "out")
    result = orchestrate(path, "--swap", f"controller={without_errors}", *options)
    assert result.exit_code == 0, result.output
    assert "all signals to be recorded, so all outputs are" in result.stderr
    assert "judge.attitude_error" in (tmp_path / "out" / "signals.csv").read_text("utf-8").splitlines()[0]
