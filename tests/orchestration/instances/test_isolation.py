"""An FMU in a process of its own computes the same, keeps its modules to itself, and ends with its master."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest
from pythonfmu.builder import FmuBuilder

from orchestration import BlockError, run
from orchestration.fmu.archive import open_fmu
from orchestration.instances.channel import STEPPING
from orchestration.instances.isolation import IsolatedBlock
from orchestration.instances.process import Limits, Process
from tests.commands import orchestrate

from .. import broken, fmus
from ..wrong_inputs import SCENARIO

ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize("exchange", ["sequential", "parallel"])
def test_a_run_in_processes_gives_the_same_bits(loop, exchange):
    text = SCENARIO.replace("duration: 2 s", f"duration: 2 s\nexchange: {exchange}")
    results = {}
    for isolation in ("none", "process"):
        loop.write_text(f"{text}isolation: {isolation}\n")
        results[isolation] = run(loop, {"motor.mode": "brake", "motor.cooled": True, "motor.label": "grün"})
    np.testing.assert_array_equal(results["none"].samples, results["process"].samples)
    assert list(results["none"]) == list(results["process"])
    assert results["process"]["motor.steps"].tolist() == list(range(21))


def test_recorded_inputs_and_slower_blocks_are_the_same_in_processes(loop):
    text = SCENARIO.replace(
        "record: {interval: 0.1 s}", "record: {interval: 0.2 s, signals: [motor.*, motor.voltage, motor.axis]}"
    ).replace("fmu: regulator.fmu", "fmu: regulator.fmu\n    every: 5")
    results = []
    for isolation in ("none", "process"):
        loop.write_text(f"{text}isolation: {isolation}\n")
        results.append(run(loop))
    np.testing.assert_array_equal(results[0].samples, results[1].samples)


# ---------------------------------------------------------------- Python FMUs with modules of the same names

_MODEL = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Real
from law import value

class {name}(Fmi2Slave):
    def __init__(self, **arguments):
        super().__init__(**arguments)
        self.y = 0.0
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def do_step(self, time, step):
        self.y = value()
        return True
"""


@pytest.fixture
def namesakes(tmp_path, monkeypatch):
    """Two FMUs made by PythonFMU; each holds a module `law`, whose value is 1 in the first and 2 in the second."""
    for number, name in enumerate(("One", "Two"), 1):
        folder = tmp_path / name
        folder.mkdir()
        (folder / f"model_{name.lower()}.py").write_text(textwrap.dedent(_MODEL.format(name=name)))
        (folder / "law.py").write_text(f"def value():\n    return {number}.0\n")
        FmuBuilder.build_FMU(folder / f"model_{name.lower()}.py", dest=tmp_path, project_files=[folder / "law.py"])
    monkeypatch.chdir(tmp_path)
    blocks = {name: {"fmu": f"{name.title()}.fmu"} for name in ("one", "two")}
    return {"name": "namesakes", "step": 0.1, "duration": 0.3, "blocks": blocks}


def test_python_fmus_with_modules_of_the_same_name_run_their_own_code(namesakes):
    result = run(namesakes)
    assert result["one.y"].tolist() == [0.0, 1.0, 1.0, 1.0]
    assert result["two.y"].tolist() == [0.0, 2.0, 2.0, 2.0]


def test_without_isolation_the_second_one_silently_runs_the_code_of_the_first(namesakes):
    """Why isolation is the default. In a process of its own, since it spoils the one that it runs in."""
    program = f"from orchestration import run; r = run({ {**namesakes, 'isolation': 'none'}!r}); print(r['two.y'])"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", program], env=environment, capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout.strip() == "[0. 1. 1. 1.]", "2 would be right"


# ---------------------------------------------------------------- the process


@pytest.fixture
def vendor(tmp_path):
    """Makes a block on broken.c, which breaks as told; every one is closed at the end."""
    made: list[IsolatedBlock] = []

    def make(guid: str = "none-none", timeout: float = 30.0, verbose: bool = False) -> IsolatedBlock:
        name = f"vendor{len(made)}"
        fmus.write(tmp_path / f"{name}.fmu", broken.XML.format(guid=guid).replace('"broken"', '"probe"'), library())
        fmu = open_fmu(tmp_path / f"{name}.fmu")
        fmu.extract(tmp_path / name)
        made.append(IsolatedBlock(name, fmu, tmp_path / name, Limits(timeout, 10**9), verbose))
        return made[-1]

    def library() -> bytes:
        return fmus.library("broken")

    yield make
    for block in made:
        block.close()


def _wired(block: IsolatedBlock) -> np.ndarray:
    block.started()
    block.enter(10.0)
    into = np.zeros(1)
    block.wire([], block.model.variables["y"].elements, [1, 0, 0, 0], into)
    block.leave()
    block.get_all()
    return into


def test_steps_that_follow_each_other_without_get_are_all_made(vendor):
    block = vendor()
    into = _wired(block)
    for n in range(5):
        block.do_step(0.1 * n, 0.1)
    block.get_live()
    assert into[0] == pytest.approx(0.5)
    assert block.get(block.model.variables["y"].elements) == [0.5]


def test_closing_after_a_step_whose_outputs_were_not_fetched(vendor):
    block = vendor()
    _wired(block)
    block.do_step(0.0, 0.1)
    block.close()
    assert block.failure is None
    block.close()
    with pytest.raises(BlockError, match="its process has ended"):
        block.get([])


def test_blocks_run_at_the_same_time_where_their_steps_are_asked_for_before_their_outputs(vendor):
    """As parallel exchange does."""
    blocks = [vendor("step-hang", timeout=1.0) for _ in range(2)]
    for block in blocks:
        _wired(block)
    for block in blocks:
        block.do_step(1.0, 0.1)
    parts = [block._memory.part for block in blocks]
    until = time.monotonic() + 10.0
    while any(part[0] != STEPPING for part in parts) and time.monotonic() < until:
        time.sleep(0.01)
    assert [part[0] for part in parts] == [STEPPING, STEPPING], "both are within fmi2DoStep"
    for block in blocks:
        with pytest.raises(BlockError, match="did not return within 1 s"):
            block.get_all()


def test_what_it_logs_and_prints_is_shown_as_it_comes_where_asked_for(vendor, capfd):
    block = vendor("step-assert", verbose=True)
    _wired(block)
    block.do_step(1.0, 0.1)
    with pytest.raises(BlockError):
        block.get_all()
    out, err = capfd.readouterr()
    assert err.splitlines() == ["vendor0: stepping from 1", "vendor0: driver.c:17: assertion failed: ready"]
    assert out == ""


def test_a_process_that_ends_between_two_steps_is_told_as_that(vendor):
    block = vendor()
    _wired(block)
    os.kill(block._process._popen.pid, signal.SIGTERM)
    assert block._process.gone(10.0)
    with pytest.raises(BlockError, match=r"^vendor0: between two calls at 1 s: crashed with SIGTERM"):
        _step(block)


def test_a_step_that_closes_the_pipes_and_returns_is_blamed_for_it(vendor):
    block = vendor("step-mute")
    _wired(block)
    with pytest.raises(BlockError, match=r"^vendor0: fmi2DoStep at 1 s: broke off its connection, so its process was"):
        _step(block)


def _step(block: IsolatedBlock) -> None:
    block.do_step(1.0, 0.1)
    block.get_all()


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
@pytest.mark.parametrize("guid", ["none-none", "step-hang"])
def test_the_process_ends_with_a_master_that_is_killed(guid, tmp_path):
    fmus.write(
        tmp_path / "vendor.fmu", broken.XML.format(guid=guid).replace('"broken"', '"probe"'), fmus.library("broken")
    )
    scenario = {
        "name": "x",
        "step": 0.1,
        "duration": 1e6,
        "record": {"interval": 1000},
        "blocks": {"vendor": {"fmu": str(tmp_path / "vendor.fmu"), "start": {"x": 0}}},
    }
    program = f"from orchestration import run; run({scenario!r})"
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(tmp_path)}
    master = subprocess.Popen([sys.executable, "-c", program], env=environment)
    try:
        until = time.monotonic() + 30.0
        while not (workers := _children(master.pid)) and time.monotonic() < until:
            time.sleep(0.05)
        assert workers
        time.sleep(1.0)
    finally:
        os.kill(master.pid, signal.SIGKILL)
        master.wait()
    until = time.monotonic() + 5.0
    while any(map(_lives, workers)) and time.monotonic() < until:
        time.sleep(0.02)
    assert not any(map(_lives, workers))


def _children(process: int) -> list[int]:
    tasks = Path(f"/proc/{process}/task").glob("*/children")
    return [int(child) for task in tasks for child in task.read_text().split()]


def _lives(process: int) -> bool:
    try:
        return ") Z" not in Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return False


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_a_process_that_is_ended_while_it_starts_is_no_wrong_input(loop, monkeypatch):
    begin = Process.__init__

    def killed(self, *arguments):
        begin(self, *arguments)
        os.kill(self._popen.pid, signal.SIGKILL)

    monkeypatch.setattr(Process, "__init__", killed)
    loop.write_text(f"{SCENARIO}isolation: process\n")
    with pytest.raises(BlockError, match="motor: starting its process.*: crashed with SIGKILL"):
        run(loop)
    assert orchestrate(loop, "--quiet").exit_code == 3
