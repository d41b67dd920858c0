"""What packages note on a scenario stands among the notes of `run` and `validate`."""

import pytest

from orchestration.cli.noted import noted
from orchestration.session.read import load

from ...commands import orchestrate

MINIMAL = "scenarios/minimal.yaml"


@pytest.mark.parametrize("command", ["validate", "run"])
def test_a_command_notes_what_is_not_plausible_and_goes_on(command, tmp_path):
    more = ["--duration", "1 s", "--out", str(tmp_path / "out")] if command == "run" else []
    done = orchestrate(command, MINIMAL, "--set", "plant.center_of_mass_B=[0.3, 0, 0]", *more)
    assert "note: not plausible: center_of_mass_B is 300 mm off the middle along x" in done.output
    assert done.exit_code in (0, 1)


def test_a_satellite_without_a_finding_has_no_note():
    assert noted(load(MINIMAL)) == []
