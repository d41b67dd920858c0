"""Analyses of a campaign through FMUs: Ishigami's function, whose indices are known, and a manoeuvre of the paper."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from orchestration.campaign import engine
from orchestration.campaign.case import read_campaign
from orchestration.campaign.file.analysis import Search
from orchestration.campaign.flying.crew import crew
from orchestration.campaign.metric_function import of_campaign
from orchestration.campaign.statistics.bounds import elsewhere, fixed
from orchestration.campaign.statistics.search import run as search
from orchestration.cli.main import main
from orchestration.errors import InputError

from .. import fmus
from ..results.swing import Reader
from .analytic import ISHIGAMI

SCENARIOS = Path(__file__).parents[3] / "scenarios"
_VARIABLES = "".join(
    f'<ScalarVariable name="x{i}" valueReference="{9 + i}" causality="parameter" variability="fixed"><Real '
    f'start="0"/></ScalarVariable>'
    for i in (1, 2, 3)
)
_DESCRIPTION = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="ishigami" guid="probe">
  <CoSimulation modelIdentifier="probe"/>
  <ModelVariables><ScalarVariable name="y" valueReference="1" causality="output">
    <Real/></ScalarVariable>{_VARIABLES}</ModelVariables>
  <ModelStructure><Outputs><Unknown index="1"/></Outputs>
  <InitialUnknowns><Unknown index="1"/></InitialUnknowns></ModelStructure>
</fmiModelDescription>
"""
_FUNCTION = "-DDIRECT(x)=sin((x)[10])+7*sin((x)[11])*sin((x)[11])+0.1*pow((x)[12],4)*sin((x)[10])"
_LARGEST = 8.0 + 0.1 * np.pi**4
FILE = """\
name: ishigami
scenario:
  name: once
  step: 1 s
  duration: 1 s
  blocks: {f: {fmu: f.fmu}}
  isolation: none
runs: 64
seed: 2
vary:
  f.x1: {uniform: [-3.141592653589793, 3.141592653589793]}
  f.x2: {uniform: [-3.141592653589793, 3.141592653589793]}
  f.x3: {uniform: [-3.141592653589793, 3.141592653589793]}
metrics:
  - {name: y, signal: f.y, statistic: final}
requirements:
  - {name: no larger than 16, metric: y, below: 16, probability: 0.5}
sensitivity: {points: 256}
search: {metric: y, runs: 120}
"""


@pytest.fixture
def campaign(tmp_path, monkeypatch):
    fmus.write(tmp_path / "f.fmu", _DESCRIPTION, fmus.library("probe", _FUNCTION, "-lm"))
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "ishigami.yaml"
    path.write_text(FILE, "utf-8")
    return path


@pytest.mark.thorough
def test_sobol_indices_and_worst_case_of_ishigamis_function_through_an_fmu(campaign):
    done = CliRunner().invoke(main, ["campaign", str(campaign), "--workers", "0", "--out", "out"])
    assert done.exit_code == 0, done.output
    manifest = json.loads(Path("out/campaign.json").read_text("utf-8"))
    indices = manifest["sensitivity"]["metrics"]["y"]
    assert manifest["sensitivity"]["runs"] == 256 * 5
    for kind, exact in ISHIGAMI.items():
        assert indices[kind] == pytest.approx(exact, abs=0.11)
    worst = manifest["search"]
    x = [worst["values"][f"f.x{i}"] for i in (1, 2, 3)]
    assert worst["value"] == pytest.approx(np.sin(x[0]) + 7 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0]))
    assert 0.97 * _LARGEST < worst["value"] <= _LARGEST
    words = Reader(Path("out/campaign.html").read_text("utf-8")).words
    assert f"120 runs of a search found is {worst['value']:.4g}" in words
    assert "256 base points" in words
    assert re.search(r"y: f.x1 0\.[56]\d*, f.x2 0\.4", done.output)
    assert f"largest y of a search with 120 runs: {worst['value']:.4g}" in done.output


def test_analyses_of_too_little_that_varies_are_refused_before_a_run(campaign):
    lines = [line for line in FILE.splitlines() if "f.x2" not in line and "f.x3" not in line]
    campaign.write_text("\n".join(lines), "utf-8")
    with pytest.raises(
        InputError, match=r"ishigami.yaml:\d+: sensitivity: expected 2 or more numbers that vary, found 1"
    ):
        read_campaign(campaign)


def test_too_few_runs_for_a_requirement_are_told_before_the_first(campaign):
    assert read_campaign(campaign, {"runs": 4}).notes == [
        "no larger than 16: 4 runs cannot show a probability of 0.5 at 95% confidence; 5 are needed at least"
    ]


def test_runs_that_are_added_to_those_announced_are_another_end_and_the_bounds_allow_for_it(campaign):
    campaign.write_text(
        "\n".join(line for line in FILE.splitlines() if line.split(":")[0] not in ("sensitivity", "search")), "utf-8"
    )

    remarks: list[str] = []

    def flown(runs):
        engine.fly(read_campaign(campaign, {"runs": runs}), Path("out"), workers=0, remark=remarks.append)
        manifest = json.loads(Path("out/campaign.json").read_text("utf-8"))
        return manifest["early"], manifest["verdicts"][0]

    for runs, early in ((20, False), (20, False), (30, True), (30, True)):
        looked, verdict = flown(runs)
        assert (looked, verdict["flown"]) == (early, runs)
        assert any("20 runs were announced, and 30 are another end" in text for text in remarks) == early
        there = verdict["met"], runs
        assert verdict["low"] == (elsewhere(*there, 0.5, 0.95, 20) if early else fixed(*there, 0.95)).low


@pytest.mark.thorough
def test_a_search_on_a_manoeuvre_of_the_paper_finds_a_worse_case_than_as_many_random_runs(tmp_path):
    path = tmp_path / "rods.yaml"
    path.write_text(
        f"""\
name: rods
scenario: {{extends: {SCENARIOS / "paper_no_singularity.yaml"}, duration: 30 s, figures: [], expect: []}}
seed: 3
vary:
  plant.Q0: {{rotation: uniform}}
  plant.omega_B0: {{sphere: 0.097 rad/s}}
metrics:
  - {{name: missing_torque, signal: allocator.tau_residual_B, measure: norm, statistic: rms}}
""",
        "utf-8",
    )
    case = read_campaign(path)
    with crew(case.job, 0) as (here, _):
        runs = of_campaign(case, here)
        found = search(Search(metric="missing_torque", runs=200), runs, 3)
        drawn = runs.fly(case.job.design.points(np.arange(200)))["missing_torque"]
    assert found["runs"] == 200
    assert found["value"] > 1.1 * np.nanmax(drawn)
