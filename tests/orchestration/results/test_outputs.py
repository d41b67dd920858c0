"""Outputs that are closed or full break nothing, and what is lost is told."""

from __future__ import annotations

import json
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

from orchestration.results import figures, report
from tests.commands import orchestrate

from .test_endings import ENVIRONMENT, POSIX

pytestmark = pytest.mark.isolate


def shell(command):
    return subprocess.run(["bash", "-c", command], env=ENVIRONMENT, capture_output=True, text=True)


@POSIX
def test_a_closed_pipe_does_not_change_the_verdict(loop):
    run_ = f"{sys.executable} -m orchestration"
    done = shell(
        f"set -o pipefail; {run_} loop.yaml | true; {run_} loop.yaml --set motor.speed0=4 | true; echo "
        f"${{PIPESTATUS[0]}}"
    )
    assert (done.stdout, done.stderr) == ("1\n", "")
    done = shell(f"{run_} loop.yaml | true; echo ${{PIPESTATUS[0]}}; {run_} --help | true; echo ${{PIPESTATUS[0]}}")
    assert (done.stdout.split()[0], done.stderr) == ("0", "")
    assert done.stdout.split()[1] in ("0", "141"), "a matter of luck, but never 1"
    assert Path("results/loop/manifest.json").exists()


@POSIX
def test_a_closed_output_is_no_error_and_no_file_takes_its_place(loop):
    for closed in (">&-", "2>&-", "<&- >&- 2>&-"):
        done = shell(f"{sys.executable} -m orchestration loop.yaml {closed}")
        assert done.returncode == 0, done.stderr
    assert json.loads(Path("results/loop/manifest.json").read_text())["outcome"] == "completed"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="Linux")
@pytest.mark.parametrize(
    "arguments",
    [
        "loop.yaml",
        "schema",
        "--help",
        "info motor.fmu",
        "scenarios",
        "fmus",
        "validate loop.yaml",
        "check motor.fmu --as motor.fmu",
        "compare loop.yaml --swap regulator=regulator.fmu",
    ],
)
def test_a_full_output_is_told_and_is_no_internal_error(loop, arguments):
    done = shell(f"{sys.executable} -m orchestration {arguments} >/dev/full")
    assert done.returncode == 4
    assert "the disk is full" in done.stderr
    assert "internal error" not in done.stderr
    assert "Traceback" not in done.stderr


def test_a_page_that_is_missing_is_told_also_by_a_quiet_run(loop, monkeypatch):
    def full(result, path):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(report, "write", full)
    told = orchestrate(loop.name, "--quiet")
    assert (told.exit_code, told.stdout) == (0, "")
    assert told.stderr == f"note: {Path('results/loop/report.html')} cannot be written: the disk is full\n"


@pytest.mark.parametrize(
    ("scale", "speed"),
    [("log", "2"), ("log", "1.7e308"), ("linear", "1.7e308"), ("linear", "-1e200")],
)
def test_values_that_cannot_be_drawn_give_a_figure_and_no_warning_of_python(loop, scale, speed, monkeypatch):
    panel = f"{{signals: [regulator.voltage], measure: element, scale: {scale}, lines: [-1 V]}}"
    loop.write_text(
        loop.read_text() + f"figures:\n  - {{name: drawn, panels: [{panel}, {{signals: [motor.speed]}}]}}\n"
    )
    notes = []
    drawn = figures.draw_panel
    monkeypatch.setattr(
        figures, "draw_panel", lambda axes, *rest: (drawn(axes, *rest), notes.append(axes.get_xlabel()))
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        told = orchestrate(loop.name, "--figures", "--set", f"motor.speed0={speed}")
    assert told.exit_code == (1 if speed == "1.7e308" else 0), told.output
    assert Path("results/loop/figures/drawn.png").stat().st_size > 10000
    wanted = (
        "time, s\nno value is positive and at most 1e+30 in size" if scale == "log" else "time, s\nno value is at most"
    )
    assert notes[0].startswith(wanted)
