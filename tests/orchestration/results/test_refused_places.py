"""Places and texts that cannot serve are refused by name, before the run."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from orchestration import InputError, run
from orchestration.instances import channel
from tests.commands import orchestrate

from ..mocks import model, real
from .test_endings import POSIX, contents

LONG = "x" * 300


@pytest.fixture
def unrun(loop, monkeypatch):
    monkeypatch.setattr("orchestration.master.master.Master.run", lambda *a: pytest.fail("it was run"))
    return loop


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--out", ""], "--out: expected a path, found an empty text"),
        (["--out", LONG], f"--out: {'x' * 60}...: the name is too long"),
        (["--out", "a\0b"], "--out: 'a\\x00b' is no path: embedded null byte"),
        (["--out", "~nobody123/x"], "--out: ~nobody123/x: the home of this user is unknown"),
        (["--swap", "motor=~nobody123/x.fmu"], "~nobody123/x.fmu: the home of this user is unknown"),
        (["--swap", f"motor={LONG}.fmu"], f"{'x' * 60}...: the name is too long"),
    ],
)
def test_a_path_that_can_be_none_is_refused_by_name(unrun, arguments, message):
    before = contents(".")
    told = orchestrate(unrun.name, *arguments)
    assert told.exit_code == 2
    assert message in told.stderr
    assert contents(".") == before


@pytest.mark.parametrize("fmu", ["~nobody123/x.fmu", f"{LONG}.fmu", '"a\\0b.fmu"'])
def test_an_fmu_of_such_a_path_is_refused_with_its_line(unrun, fmu):
    unrun.write_text(unrun.read_text().replace("motor.fmu", fmu))
    told = orchestrate(unrun.name)
    assert told.exit_code == 2
    assert told.stderr.startswith("loop.yaml:6: blocks.motor.fmu: ")


@POSIX
def test_a_pipe_is_no_scenario_and_is_not_waited_for(unrun):
    os.mkfifo("pipe.yaml")
    told = orchestrate("pipe.yaml")
    assert (told.exit_code, told.stderr) == (2, "pipe.yaml is no regular file; expected a file of YAML\n")


def test_a_folder_in_the_place_of_a_file_is_refused(unrun):
    Path("out/report.html").mkdir(parents=True)
    told = orchestrate(unrun.name, "--out", "out")
    assert told.exit_code == 2
    assert f"{Path('out/report.html')} is a folder; expected a file, or none" in told.stderr


def test_an_empty_folder_name_is_refused_from_python_too(unrun):
    with pytest.raises(InputError, match="the folder of the results has an empty name"):
        run(unrun, out="")


@pytest.mark.parametrize("key", ["title: ", "panels: [{signals: [motor.speed], label: "])
def test_mathematics_that_cannot_be_drawn_is_refused_with_its_line(unrun, key):
    rest = ", panels: [{signals: [motor.speed]}]}" if key == "title: " else "}]}"
    unrun.write_text(unrun.read_text() + f"figures:\n  - {{name: a, {key}'$\\frac$'{rest}\n")
    told = orchestrate(unrun.name, "--figures")
    assert told.exit_code == 2
    assert "loop.yaml:23: figures[1]" in told.stderr
    assert "'$\\frac$' cannot be drawn as mathematics: " in told.stderr
    assert "write \\$ for a dollar" in told.stderr


def test_a_dollar_in_the_name_of_a_signal_is_a_dollar_in_a_figure(tmp_path):
    from ..mocks import Mock
    from ..mocks import run as run_mocks

    block = Mock("a", model("a", real("$\\frac$", "output")), lambda block: None)
    figure = {"name": "f", "panels": [{"signals": ["a.$\\frac$"]}]}
    ran = run_mocks([block], {"step": 0.1, "duration": 1, "figures": [figure]})
    assert ran.draw(tmp_path) == [tmp_path / "f.png"]


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="Linux")
def test_the_memory_shared_with_a_process_has_its_room_on_the_disk(tmp_path):
    path = tmp_path / "x.memory"
    channel.Memory(path, model("a", real("x", "output", shape=(10_000,))))
    assert path.stat().st_blocks * 512 >= path.stat().st_size > 160_000


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="Linux")
def test_a_full_temporary_folder_is_told_before_the_run(unrun, monkeypatch):
    def full(*arguments):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "posix_fallocate", full)
    unrun.write_text(unrun.read_text().replace("isolation: none", "isolation: process"))
    told = orchestrate(unrun.name)
    assert told.exit_code == 2
    assert told.stderr.startswith("motor: the memory shared with its process cannot be made in"), (
        "not the scenario's error"
    )
    assert "the disk is full; remedy: room there, or another folder in TMPDIR" in told.stderr
