"""The campaigns see what they are for: a crash, a hang and an internal error."""

from __future__ import annotations

import faulthandler
import os
import time
from pathlib import Path
from random import Random

import click
import pytest

from orchestration.cli.main import main

from .torture import _campaign, calls
from .torture._campaign import campaign


def _crash(random: Random, folder: Path) -> list[str]:
    faulthandler.disable()  # pytest's, which would print a traceback among the passed tests
    os.kill(os.getpid(), 11)
    return []


def _hang(random: Random, folder: Path) -> list[str]:
    time.sleep(60.0)
    return []


def _internal(random: Random, folder: Path) -> list[str]:
    return ["schema"]


@pytest.mark.isolate
@pytest.mark.skipif(os.name != "posix", reason="the replaced command reaches the process by fork")
@pytest.mark.parametrize(("make", "end"), [(_crash, "crash, -11: 3"), (_hang, "hang: 3"), (_internal, "status 70: 3")])
def test_a_campaign_counts_what_must_not_happen_and_fails(make, end, monkeypatch, capsys) -> None:
    def fail() -> None:
        raise KeyError("not foreseen")

    monkeypatch.setattr(_campaign, "SECONDS", 1.0)
    monkeypatch.setattr(main, "get_command", lambda ctx, name: click.Command("schema", callback=fail))
    assert campaign(make, lambda folder: None, 3, 1) == 1
    assert end in capsys.readouterr().out


@pytest.mark.skipif(os.name != "posix", reason="the program is a shell script")
@pytest.mark.parametrize(
    ("words", "end"), [("kill -SEGV $$", "status -11"), ("exec sleep 60", "hang"), ("exit 1", "status 1")]
)
def test_random_calls_count_each_process_that_crashes_hangs_or_finds_an_error(
    words, end, tmp_path, monkeypatch, capsys
) -> None:
    monkeypatch.setattr(calls, "SECONDS", 0.5)
    program = tmp_path / "fuzz"
    program.write_text(
        f"#!/bin/sh\nif [ $1 = 7000001 ]; then {words}; fi\necho 3 refusals, 2 steps\n", encoding="utf-8"
    )
    program.chmod(0o755)
    assert calls.trial("law", program, 2 * calls.CALLS + 1, 7) == 1
    output = capsys.readouterr().out
    assert f"law: fuzz 7000001 {calls.CALLS}: {end}" in output
    assert "40001 calls with seed 7: 6 refusals, 4 steps; crashes, hangs and errors: 1" in output
