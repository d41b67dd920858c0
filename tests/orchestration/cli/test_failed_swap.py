"""A run in which a swapped block fails says what to do next, and what is wrong with the block."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from click.testing import CliRunner

from orchestration.acceptance.polarity.apart import within
from orchestration.cli.main import main

from .. import vendor
from ..swapped import swapped


def _slow(seconds: float) -> str:
    time.sleep(seconds)
    return "done"


def _fails() -> str:
    raise ValueError("no")


def test_a_task_is_ended_where_it_takes_too_long_or_fails():
    assert within(20.0, _slow, 0.0) == "done"
    begun = time.monotonic()
    assert within(0.3, _slow, 60.0) is None
    assert time.monotonic() - begun < 20.0
    assert within(20.0, _fails) is None


@pytest.mark.compile
@pytest.mark.isolate
def test_a_failed_swap_is_diagnosed_with_the_commands_and_the_cause(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    swapped(tmp_path, monkeypatch)
    wrong = vendor.MAPPING.replace("voltage: command", "voltage: {theirs: command, scale: -1}")
    Path("wrong.yaml").write_text(wrong, "utf-8")
    words = ["run", "loop.yaml", "--swap", "regulator=vendor.fmu", "--map", "wrong.yaml", "-o", "out"]
    result = CliRunner().invoke(main, words)
    assert result.exit_code == 1, result.output
    assert "orchestrate polarity loop.yaml --swap regulator=vendor.fmu --map wrong.yaml" in result.output
    assert "regulator: on the same inputs its outputs differ by 200 % of ours" in result.output
    quiet = CliRunner().invoke(main, [*words, "-q"])
    assert "on the same inputs" not in quiet.output
