"""Runs in real time from the command line; test_pacing.py has what a pacer does."""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from orchestration import run
from tests.commands import orchestrate

pytestmark = pytest.mark.isolate


def manifest(folder: str = "results/loop") -> dict:
    return json.loads((Path(folder) / "manifest.json").read_text("utf-8"))


def state(loop: Path, realtime: str) -> None:
    loop.write_text(loop.read_text() + f"realtime: {realtime}\n")


def test_a_run_in_real_time_says_how_it_kept_its_deadlines(loop):
    told = orchestrate(loop.name, "--realtime=40", "--late", "continue")
    assert told.exit_code == 0
    assert "real time: factor 40; lateness p50" in told.stdout
    assert "the step loop in Python makes the base steps" in told.stderr
    kept = manifest()
    assert kept["realtime"]["steps"] == kept["steps"] == 20
    assert kept["scenario"]["realtime"] == {"factor": 40.0, "late": "continue", "tolerance": 0.002}
    assert kept["options"] == ["--late continue", "--realtime 40"]
    page = Path("results/loop/report.html").read_text("utf-8")
    assert "<h2>Real time</h2>" in page
    assert "Lateness of the base steps" in page


def test_the_command_line_wins_over_the_scenario_entry_by_entry(loop):
    state(loop, "{factor: 1, late: continue, tolerance: 1 s}")
    orchestrate("--realtime=50", loop.name, "--late", "stop", "-q")
    assert manifest()["scenario"]["realtime"] == {"factor": 50.0, "late": "stop", "tolerance": 1.0}


def test_off_runs_a_scenario_of_real_time_as_fast_as_it_goes(loop):
    state(loop, "{factor: 1e-3}")  # would take half an hour
    assert orchestrate(loop.name, "--realtime", "off").exit_code == 0
    assert "realtime" not in manifest()


def test_a_scenario_of_real_time_is_paced_in_python_too_and_its_bits_are_the_same(loop):
    free = run(loop)
    state(loop, "{factor: 100}")
    paced = run(loop)
    assert paced.pace is not None
    assert paced.pace.factor == 100.0
    assert run(loop, realtime=200).pace.factor == 200.0
    assert free.pace is None
    assert paced.samples.tobytes() == free.samples.tobytes()


def test_a_late_step_ends_the_command_with_status_3_and_its_results_are_kept(loop):
    """No computer makes a base step of 0.1 s in 1 ns."""
    told = orchestrate(loop.name, "--realtime=1e8", "--late", "stop", "--late-tolerance", "1e-9")
    assert told.exit_code == 3
    assert "loop: failed after 0.1 s" in told.stdout
    assert "step at 0.1 s: took " in told.stderr
    kept = manifest()
    assert (kept["outcome"], kept["realtime"]["late_steps"], kept["realtime"]["overruns"]) == ("failed", 1, 1)
    assert kept["realtime"]["listed"][0]["block"] in ("motor", "regulator")
    assert len(Path("results/loop/signals.csv").read_text().splitlines()) == 3


def test_validate_says_that_a_run_would_be_in_real_time(loop):
    told = orchestrate("validate", loop.name, "--realtime", "2", "--late", "stop").stdout
    assert "factor 2; a step that ends more than 0.002 s late ends the run" in told


@pytest.mark.skipif(sys.platform == "win32", reason="a pseudo terminal is of POSIX systems")
def test_on_a_terminal_keys_pause_and_step_and_ctrl_c_keeps_the_results(loop):
    import fcntl  # here, since Windows does not have them
    import termios

    ours, theirs = os.openpty()
    before = termios.tcgetattr(theirs)
    command = [sys.executable, "-m", "orchestration", loop.name, "--realtime", "0.2"]

    def in_front() -> None:
        fcntl.ioctl(0, termios.TIOCSCTTY, 0)

    process = subprocess.Popen(
        command, stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True,
        preexec_fn=in_front, env={**os.environ, "TERM": "xterm", "COLUMNS": "120"},
    )  # fmt: skip
    shown = b""

    def read_until(ended: Callable[[], bool]) -> None:
        nonlocal shown
        while not ended() and process.poll() is None:
            if select.select([ours], [], [], 0.05)[0]:
                shown += os.read(ours, 65536)

    for awaited, keys in ((b"the space bar pauses", b"ss"), (b"paused; space goes on", b"\x03")):
        read_until(lambda awaited=awaited: awaited in shown)
        assert awaited in shown
        os.write(ours, keys)
    read_until(lambda: False)
    assert process.returncode == 130, shown
    kept = manifest()
    assert kept["outcome"] == "interrupted"
    assert kept["realtime"]["single_steps"] == 1
    assert kept["samples"] == kept["steps"] + 1 >= 2
    assert termios.tcgetattr(theirs) == before
    os.close(ours)
    os.close(theirs)
