"""Metrics in Python."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from orchestration.campaign.case import read_campaign
from orchestration.errors import InputError
from tests.commands import orchestrate

from ..toy import SHRINKS, changed, fly, rows


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
    Path("mine.py").write_text("class E(BaseException): pass\nraise E('7')\n")
    with pytest.raises(InputError, match=r"toy.yaml:8: .*the module 'mine' cannot be loaded: E: 7, in .*mine.py"):
        read_campaign(toy)
    Path("mine.py").write_text("import sys\nsys.exit(7)\n")
    with pytest.raises(
        InputError, match=r"toy.yaml:8: .*the module 'mine' cannot be loaded: SystemExit: 7, in .*mine.py"
    ):
        read_campaign(toy)


def test_validate_looks_at_the_text_of_a_module_and_runs_none_of_it(toy):
    Path("mine.py").write_text("open('ran', 'w')\ndef fall(time, signals):\n    return 1.0\n")
    changed(toy, ("metrics:", "metrics:\n  - {name: fall, python: 'mine:fall', signals: [motor.speed]}"))
    assert orchestrate("validate", toy).exit_code == 0
    changed(toy, ("mine:fall", "mine:fal"))
    told = orchestrate("validate", toy)
    assert "mine.py has no function 'fal'; did you mean 'fall'?" in told.stderr
    changed(toy, ("mine:fal", "mime:fall"))
    assert "there is no file" in orchestrate("validate", toy).stderr
    changed(toy, ("mime:fall", "mine:fall"))
    assert not Path("ran").exists()
    read_campaign(toy)
    assert Path("ran").exists()


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
