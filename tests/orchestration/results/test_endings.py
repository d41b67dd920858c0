"""How a run ends: its folder is whole or empty, and signals are obeyed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from orchestration import InputError
from orchestration.errors import BlockError
from tests.commands import orchestrate

from .. import broken, fmus
from ..cli.test_cli import ROOT
from ..mocks import law
from ..mocks import run as run_mocks

pytestmark = pytest.mark.isolate

POSIX = pytest.mark.skipif(os.name == "nt", reason="signals and devices differ")
COMMAND = [sys.executable, "-m", "orchestration"]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}


def contents(folder):
    return sorted(path.name for path in Path(folder).iterdir())


# ---------------------------------------------------------------- the folder


def test_a_failure_in_initialization_replaces_what_an_earlier_run_left(loop):
    orchestrate(loop.name, "--quiet")
    result = orchestrate(loop.name, "--set", "motor.fault=5")
    assert result.exit_code == 3
    assert {"expectations.json", "manifest.json"} <= set(contents("results/loop"))
    assert "signals.csv" not in contents("results/loop")
    manifest = json.loads(Path("results/loop/manifest.json").read_text())
    assert manifest["outcome"] == "failed"
    assert "the gain is refused" in manifest["failure"]
    assert json.loads(Path("results/loop/expectations.json").read_text())["passed"] is False


def test_figures_without_matplotlib_are_refused_before_the_run(loop, monkeypatch):
    from importlib import util

    found = util.find_spec
    monkeypatch.setattr(util, "find_spec", lambda name, *a: None if name == "matplotlib" else found(name, *a))
    monkeypatch.setattr("orchestration.session.run.execute", lambda *a: pytest.fail("it was run"))
    result = orchestrate(loop.name, "--figures")
    assert result.exit_code == 2
    assert result.stderr.startswith("figures need Matplotlib: pip install")


# ---------------------------------------------------------------- the manifest


def test_the_manifest_holds_every_parameter_in_force_and_what_became_of_flags(loop):
    orchestrate(loop.name, "--quiet", "--set", "motor.mode=brake", "--set", "motor.axis[2]=0.5")
    manifest = json.loads(Path("results/loop/manifest.json").read_text())
    assert manifest["parameters"]["motor"] == {
        "fault": 0,
        "fault_time": 0,
        "inertia": 0.5,
        "axis": [1, 0.5, 0],
        "mode": "brake",
        "poles": 2,
        "cooled": False,
        "label": "",
        "speed0": 2,
    }
    assert manifest["parameters"]["regulator"] == {"fault": 0, "fault_time": 0, "gain": -1}
    assert manifest["flags"] == {"motor.hot": {"ever": False, "first": None}}


def test_flags_that_were_true_are_told(capsys):
    from orchestration.cli.summary import summary

    from ..master.test_every_step import spiky

    result = run_mocks([spiky()], {"step": 0.1, "duration": 2})
    assert result.flags == {"a.on": 0.7}
    summary(result)
    assert "\nflags that were true: a.on from 0.7 s to 0.8 s\n" in capsys.readouterr().out
    assert run_mocks([spiky()], {"step": 0.1, "duration": 0.5}).flags == {"a.on": None}


# ---------------------------------------------------------------- refused start values


def test_a_start_value_that_a_block_refuses_is_wrong_input_with_its_line(loop):
    result = orchestrate(loop.name, "--set", "regulator.fault=5")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr == "loop.yaml:12: blocks.regulator.start.gain: the gain is refused: -1\n"


@pytest.mark.parametrize(
    ("said", "start", "message"),
    [
        ("[error] k: expected less, found 3", {"k": 3}, "blocks.a.start.k: expected less, found 3"),
        ("[error] call: ValueError: k is 3; expected less", {"k": 3}, "blocks.a.start.k: k is 3; expected less"),
        ("[error] a limit of k is passed", {"k": 3}, "blocks.a.start.k: a limit of k is passed"),
        ("[error] k: expected less than m, found 3", {"m": 3}, "blocks.a.start.m: k: expected less than m, found 3"),
        ("[error] k: expected less, found 1", {}, "blocks.a: k: expected less, found 1"),
    ],
)
def test_a_refusal_that_names_a_parameter_is_located(said, start, message):
    with pytest.raises(InputError) as error:
        run_mocks([_refusing(said)], {"step": 1, "duration": 2}, start={"a": {"u": 0, **start}})
    assert str(error.value) == message


@pytest.mark.parametrize("said", ["[error] out of luck", "k: 3", "[error] about k", "[error] kk: 3", "[error] 2k: 3"])
def test_a_failure_that_names_none_stays_one_of_the_block(said):
    result = run_mocks([_refusing(said)], {"step": 1, "duration": 2}, start={"a": {"u": 0}})
    assert isinstance(result.failure, BlockError)


def _refusing(said):
    from orchestration.fmu.model import Variable

    block = law("a")
    for name in ("k", "m"):
        block.model.variables[name] = Variable(name, "parameter")

    def leave():
        raise BlockError("a", "fmi2ExitInitializationMode", "gave status error", log=[said], status=3)

    block.leave = leave
    return block


# ---------------------------------------------------------------- signals


@POSIX
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_signals_end_a_run_between_two_steps_and_keep_what_was_computed(loop, name, tmp_path):
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    number = getattr(signal, name)
    process = subprocess.Popen(
        [*COMMAND, loop.name, "--step", "1 us", "--duration", "1000 s", "--loop", "python", "--quiet"],
        env={**ENVIRONMENT, "TMPDIR": str(temporary)},
        stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(number, signal.default_int_handler if name == "SIGINT" else signal.SIG_DFL),
    )
    until = time.monotonic() + 30
    while not list(temporary.glob("orchestrate-*/regulator/binaries")) and time.monotonic() < until:
        time.sleep(0.05)
    time.sleep(0.5)
    process.send_signal(number)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 128 + number, errors
    assert contents(temporary) == []
    assert json.loads(Path("results/loop/manifest.json").read_text())["outcome"] == "interrupted"
    assert Path("results/loop/signals.csv").exists()


@POSIX
@pytest.mark.parametrize(("name", "signals"), [("SIGINT", 1), ("SIGTERM", 1), ("SIGINT", 2)])
def test_signals_end_a_run_that_waits_for_a_hanging_block(tmp_path, monkeypatch, name, signals):
    monkeypatch.chdir(tmp_path)
    fmus.write(
        Path("vendor.fmu"), broken.XML.format(guid="step-hang").replace('"broken"', '"probe"'), fmus.library("broken")
    )
    Path("run.yaml").write_text(
        "name: run\nstep: 0.1 s\nduration: 2 s\nblocks:\n  vendor: {fmu: vendor.fmu, timeout: 60 s}\n"
        "connections: [vendor.y -> vendor.x]\n"
    )
    number = getattr(signal, name)
    process = subprocess.Popen(
        [*COMMAND, "run.yaml", "--quiet"],
        env={**ENVIRONMENT, "TMPDIR": str(tmp_path)},
        stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(number, signal.default_int_handler if name == "SIGINT" else signal.SIG_DFL),
    )
    until = time.monotonic() + 30
    while not list(tmp_path.glob("orchestrate-*/vendor.home")) and time.monotonic() < until:
        time.sleep(0.05)
    time.sleep(2.0)
    begun = time.monotonic()
    for _ in range(signals):
        process.send_signal(number)
        time.sleep(0.3)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 128 + number, errors
    assert time.monotonic() - begun < (4.5 if signals == 1 else 2.0)
    assert json.loads(Path("results/run/manifest.json").read_text())["outcome"] == "interrupted"
    assert len(Path("results/run/signals.csv").read_text().splitlines()) >= 11
