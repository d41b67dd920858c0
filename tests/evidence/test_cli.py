"""The command `python -m evidence momentum-bound`: its answers and its complaints."""

import pytest
from click.testing import CliRunner

from evidence.__main__ import main

SCENARIO = "scenarios/paper_no_singularity.yaml"
SI = ["--set", "plant.J_B=[[2.13,0,0],[0,3.04,0],[0,0,3.09]]"]


def ask(*arguments):
    return CliRunner().invoke(main, ["momentum-bound", *arguments])


@pytest.mark.parametrize("command", [[], *([name] for name in sorted(main.commands))])
def test_every_command_has_a_short_option_for_its_help(command):
    short, long = (CliRunner().invoke(main, [*command, option]) for option in ("-h", "--help"))
    assert (short.exit_code, short.output) == (0, long.output)


def test_what_breaks_the_balance_is_called_impossible_with_what_is_short():
    found = ask(SCENARIO, *SI, "--time", "193 s", "--dipole-max", "15 A.m2")
    assert found.exit_code == 1
    assert "within 193 s: impossible, 0.08" in found.stdout


def test_what_does_not_is_not_excluded():
    found = ask(SCENARIO, *SI, "--time", "1 h")
    assert found.exit_code == 0
    assert "within 3600 s: not excluded" in found.stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([SCENARIO, "--time", "0"], "--time 0: expected above zero, found 0 s"),
        ([SCENARIO, "--time", "-1 min"], "--time -1 min: expected above zero, found -60 s"),
        ([SCENARIO, "--time", "5 kg"], "--time 5 kg: the unit 'kg' does not fit 's'"),
        ([SCENARIO, "--time", "soon"], "--time soon: expected a number with a unit"),
        ([SCENARIO, "--horizon", "0"], "--horizon 0: expected above zero"),
        ([SCENARIO, "--dipole-max", "0"], "--dipole-max 0: expected above zero, found 0 A.m2"),
        ([SCENARIO, "--dipole-max", "nan"], "--dipole-max nan: expected a finite number"),
        ([SCENARIO, "--set", "plant.dipole_max=0"], "--set plant.dipole_max=0: expected a limit above zero"),
        ([SCENARIO, "--set", "plant.field_model=igrf99"], "expected one of igrf14, wmm2010"),
        ([SCENARIO, "--set", "plant.epoch=2031-01-01T00:00:00Z"], "which field_model 'igrf14' covers"),
        ([SCENARIO, "--set", "plant.inclinatoin=1"], "did you mean 'inclination'?"),
        (["scenarios/paper_no_singularty.yaml"], "there is no such file; did you mean 'paper_no_singularity.yaml'?"),
        (["scenarios/minimal.yaml"], "minimal.yaml:13: blocks: expected a block with 'fmu: controller', found none"),
    ],
)
def test_wrong_input_is_told_with_its_place_and_without_a_traceback(arguments, message):
    found = ask(*arguments)
    assert found.exit_code == 2
    assert message in found.stderr
    assert "Traceback" not in found.output
