"""The commands `orchestrate momentum-bound` and `orchestrate sizing`: what they answer and what they refuse."""

import re
import tomllib
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner

from design.loop import read
from orchestration import run
from orchestration.cli import main as orchestrate

GROUP = "orchestrate.commands"
SCENARIO = "scenarios/paper_no_singularity.yaml"
SIZED = "scenarios/sized_no_singularity.yaml"
SATELLITE = "scenarios/satellites/paper_50kg.yaml"
SI = ["--set", "plant.J_B=[[2.13,0,0],[0,3.04,0],[0,0,3.09]]"]


@pytest.fixture(autouse=True)
def registered(monkeypatch):
    """The commands that pyproject.toml adds, whenever this copy was installed."""
    named = tomllib.loads(Path("pyproject.toml").read_text("utf-8"))["project"]["entry-points"][GROUP]
    points = {name: EntryPoint(name, place, GROUP) for name, place in named.items()}
    monkeypatch.setattr(orchestrate, "outside", lambda: points)


def bound(*arguments):
    return CliRunner().invoke(orchestrate.main, ["momentum-bound", *arguments])


def size(*arguments):
    return CliRunner().invoke(orchestrate.main, ["sizing", *arguments], env={"COLUMNS": "200"})


def test_the_commands_are_listed_and_a_mistyped_one_is_told_with_the_nearest_name():
    listed = CliRunner().invoke(orchestrate.main, ["-h"], env={"COLUMNS": "200"}).stdout
    assert re.search("momentum-bound +Compute a proven lower bound", listed)
    assert re.search("sizing +Compute gains", listed)
    assert "did you mean 'sizing'?" in CliRunner().invoke(orchestrate.main, ["sizin"]).stderr


def test_what_breaks_the_balance_is_called_impossible_with_what_is_short():
    found = bound(SCENARIO, *SI, "--time", "193 s", "--dipole-max", "15 A.m2")
    assert found.exit_code == 1
    assert "within 193 s: impossible, 0.08" in found.stdout


def test_what_does_not_is_not_excluded():
    found = bound(SCENARIO, *SI, "--time", "1 h")
    assert found.exit_code == 0
    assert "within 3600 s: not excluded" in found.stdout


def test_the_gains_of_vb_are_those_that_the_sized_scenario_flies_and_meet_every_claim_of_the_paper():
    found = size(SCENARIO, "--time", "193 s")
    assert found.exit_code == 1  # not for every start of the set in every field
    with open(SIZED, encoding="utf-8") as file:
        assert yaml.safe_load(found.stdout)["blocks"] == yaml.safe_load(file)["blocks"]
    assert "-0.464 mN m" in found.stderr
    assert run(SIZED).passed


def test_the_written_file_is_one_that_a_scenario_extends(tmp_path):
    written = tmp_path / "gains.yaml"
    found = size(
        SATELLITE, "--time=600 s", "--attitude-error=20 deg", "--rate=0.1 deg/s", "--schedule=error", f"--out={written}"
    )
    assert found.exit_code == 0
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(f"name: mine\nextends: [{Path(SCENARIO).resolve().as_posix()}, gains.yaml]\n")
    start = yaml.safe_load(written.read_text())["blocks"]["controller"]["start"]
    law = read(scenario).loop.controller
    assert law.K0.tolist() == start["K0"]
    assert (law.gain_schedule, law.kappa0) == ("error", start["kappa0"])


@pytest.mark.parametrize(
    ("ask", "arguments", "message"),
    [
        (bound, [SCENARIO, "--time", "0"], "--time 0: expected above zero, found 0 s"),
        (bound, [SCENARIO, "--time", "-1 min"], "--time -1 min: expected above zero, found -60 s"),
        (bound, [SCENARIO, "--time", "5 kg"], "--time 5 kg: the unit 'kg' does not fit 's'"),
        (bound, [SCENARIO, "--time", "soon"], "--time soon: expected a number with a unit"),
        (bound, [SCENARIO, "--horizon", "0"], "--horizon 0: expected above zero"),
        (bound, [SCENARIO, "--dipole-max", "0"], "--dipole-max 0: expected above zero, found 0 A.m2"),
        (bound, [SCENARIO, "--dipole-max", "nan"], "--dipole-max nan: expected a finite number"),
        (bound, [SCENARIO, "--set", "plant.dipole_max=0"], "--set plant.dipole_max=0: expected a limit above zero"),
        (bound, [SCENARIO, "--set", "plant.field_model=igrf99"], "expected one of igrf14, wmm2010"),
        (bound, [SCENARIO, "--set", "plant.epoch=2031-01-01T00:00:00Z"], "which field_model 'igrf14' covers"),
        (bound, [SCENARIO, "--set", "plant.inclinatoin=1"], "did you mean 'inclination'?"),
        (
            bound,
            ["scenarios/paper_no_singularty.yaml"],
            "there is no such file; did you mean 'paper_no_singularity.yaml'?",
        ),
        (
            bound,
            ["scenarios/minimal.yaml"],
            "minimal.yaml:13: blocks: expected a block with 'fmu: controller', found none",
        ),
        (size, [SATELLITE, "--time", "60 s"], "within the tolerances from the start"),
        (size, [SCENARIO, "--time", "0"], "--time 0: expected above zero, found 0 s"),
        (size, [SCENARIO, "--time", "193 s", "--rate", "2 kg"], "--rate 2 kg: the unit 'kg' does not fit 'rad/s'"),
        (
            size,
            [SCENARIO, "--time", "193 s", "--damping", "1.5"],
            "damping: expected a number between 0 and 1, found 1.5",
        ),
        (
            size,
            [SCENARIO, "--time", "193 s", "--attitude-error", "190 deg"],
            "attitude_error: expected a number from 0 to",
        ),
        (size, [SCENARIO, "--time", "193 s", "--set", "controller.reference=rate"], "expected 'lvlh' or 'inertial'"),
    ],
)
def test_wrong_input_is_told_with_its_place_and_without_a_traceback(ask, arguments, message):
    found = ask(*arguments)
    assert found.exit_code == 2
    assert message in found.stderr
    assert "Traceback" not in found.output


def test_without_scipy_the_bound_says_what_it_needs(monkeypatch):
    monkeypatch.setattr("design.momentum.find_spec", lambda name: None)
    done = bound(SCENARIO)
    assert (done.exit_code, done.stderr) == (2, "momentum-bound needs the package scipy: pip install scipy\n")
