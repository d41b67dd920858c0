"""A law in Python as a block of the loop: flown beside FMUs, in this process and in its own; its errors."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import orchestration
from orchestration.errors import BlockError, InputError
from orchestration.fmu.model import Element
from orchestration.instances.law import Law
from orchestration.session.read import read
from tests.orchestration.mocks import model, real

ROOT = Path(__file__).parents[3]
SCENARIO = ROOT / "scenarios" / "paper_no_singularity.yaml"
DAMPING = """
def step(inputs, parameters, t, h):
    return {"tau_cmd_B": -0.02 * parameters.J_B @ inputs.omega_B}
"""
COUNTING = """
class Counting:
    def __init__(self):
        self.calls = 0
    def step(self, inputs, parameters, t, h):
        self.calls += 1
        return {"y": self.calls + 0.0 * inputs.u, "of": [t, h]}
"""


def flown(folder: Path, law: str, duration: float = 5.0, **entry: str):
    """The paper's manoeuvre with a law in the controller's place."""
    (folder / "my_law.py").write_text(law)
    data = {"name": "own", "extends": str(SCENARIO), "duration": duration, "expect": None, "figures": None}
    data["blocks"] = {"controller": {"fmu": None, "start": None, "python": "my_law.py", **entry}}
    (folder / "own.yaml").write_text(json.dumps(data))
    return orchestration.run(folder / "own.yaml")


def alone(folder: Path, text: str, needed: frozenset[str] = frozenset()) -> Law:
    kind = model("kind", real("u", "input"), real("y", "output"), real("of", "output", shape=(2,)))
    (folder / "law.py").write_text(text)
    return Law("law", replace(kind, needed=needed), folder / "law.py")


def test_its_outputs_are_those_of_its_inputs_at_the_same_instant(tmp_path):
    result = flown(tmp_path, DAMPING)
    J = np.array([[0.0426, 0, 0], [0, 0.0608, 0], [0, 0, 0.0618]])
    expected = -0.02 * result["plant.omega_B"] @ J
    assert result["controller.tau_cmd_B"] == pytest.approx(expected, rel=1e-12)
    assert np.abs(expected).max() > 1e-5


@pytest.mark.parametrize(("text", "seen"), [("{}", [3.0, 5.0]), ("{'u_estimate': 7.0}", [7.0, 7.0])])
def test_an_estimate_of_an_input_that_it_leaves_out_is_the_input_at_each_step(tmp_path, text, seen):
    kind = model("kind", real("u", "input"), real("u_estimate", "output"), real("y", "output"))
    (tmp_path / "law.py").write_text(f"def step(i, p, t, h):\n    return {text}\n")
    law = Law("law", replace(kind, needed=frozenset({"u_estimate"})), tmp_path / "law.py")
    u, out = Element("u", 0), Element("u_estimate", 0)
    law.set([(u, 3.0)])
    law.leave()
    into = np.zeros(1)
    takes = law.wire([u], [out], [0], into)
    found = list(into)
    takes[0] = 5.0
    law.do_step(0.0, 1.0)
    law.get_all()
    assert [*found, *into] == seen
    law = Law("law", replace(kind, needed=frozenset({"y"})), tmp_path / "law.py")
    with pytest.raises(BlockError, match="expected y, which other blocks take in"):
        law.leave()


def test_what_it_leaves_out_and_optional_inputs_take_in_is_as_if_it_were_not_connected(tmp_path):
    """Zeros would be gains of dead rods, and a wheel's torque that is wanted."""
    left = ("dipole_ff", "wheel_torque_ff", "rod_gains_estimate")
    (tmp_path / "my_law.py").write_text(DAMPING)
    flights = []
    for isolation in ("none", "process", None):
        source = read(ROOT / "scenarios" / "flight_tumble.yaml").with_value("duration", "20 s", "test")
        law = {"python": str(tmp_path / "my_law.py"), "isolation": isolation or "none"}
        (tmp_path / "over.yaml").write_text(json.dumps({"blocks": {"controller": law}}))
        data: dict[str, Any] = {"extends": [str(ROOT / "scenarios" / "flight_tumble.yaml"), "over.yaml"], "name": "own"}
        data |= {"duration": "20 s", "expect": None, "figures": None}
        if isolation is None:
            wires = [w for w in source.data["connections"] if not w.startswith(tuple(f"controller.{n} " for n in left))]
            data["connections"] = wires
        (tmp_path / "own.yaml").write_text(json.dumps(data))
        flights.append(orchestration.run(tmp_path / "own.yaml"))
    for one in flights[:2]:
        assert all((one[f"controller.{name}"] == 1e9).all() for name in left)
        assert (one["plant.omega_B"] == flights[2]["plant.omega_B"]).all()
    assert np.abs(flights[0]["allocator.dipole_cmd"][1:]).max() > 0.1


def test_in_a_process_of_its_own_it_gives_the_same(tmp_path):
    both = [flown(tmp_path, DAMPING, 2.0, isolation=kind)["plant.omega_B"] for kind in ("none", "process")]
    np.testing.assert_array_equal(*both)


def test_a_class_remembers_from_step_to_step_and_starts_anew(tmp_path):
    law = alone(tmp_path, COUNTING)
    into = np.zeros(3)
    for _ in range(2):
        law.enter(1.0)
        assert law.get([Element("y", 0)]) == [1.0]  # in initialization it is asked on a copy
        law.wire([Element("u", 0)], [Element("y", 0), Element("of", 0), Element("of", 1)], [1, 0, 0, 0], into)
        law.leave()
        for k in range(3):
            law.do_step(0.5 * k, 0.5)
            law.get_all()
        assert into.tolist() == [4.0, 1.5, 0.5]
        law.reset()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("def step(inputs, parameters, t, h):\n    return 1 / 0\n", "law.py:2: ZeroDivisionError: division by zero"),
        ("def step(inputs, parameters, t, h):\n    return inputs.omega\n", "no attribute 'omega'; there are u"),
        ("def step(:\n", "law.py:1: invalid syntax"),
        ("def step(*_):\n    raise SystemExit(0)\n", "law.py:2: SystemExit: 0"),
        ("def step(*_):\n    return {'y': 10**400}\n", "step returned what is no outputs: y: expected "),
        (
            "class E(Exception):\n    def __str__(self):\n        1 / 0\n\ndef step(*_):\n    raise E\n",
            "law.py:6: E: an error without text",
        ),
        ("def step(*_):\n    raise GeneratorExit\n", "law.py:2: GeneratorExit: "),
        ("class E(BaseException): pass\ndef step(*_):\n    raise E('mine')\n", "law.py:3: E: mine"),
        (
            "class M(dict):\n    def items(self):\n        raise SystemExit(0)\ndef step(*_):\n    return M(y=1)\n",
            "law.py:3: SystemExit: 0",
        ),
        (
            "class A:\n    def __array__(self, *_, **__):\n        raise SystemExit(0)\n"
            "def step(*_):\n    return {'y': A()}\n",
            "law.py:3: SystemExit: 0",
        ),
        (
            "class A:\n    def __repr__(self):\n        raise SystemExit(0)\ndef step(*_):\n    return {'y': A()}\n",
            "step returned what is no outputs: y: expected a real scalar, found A",
        ),
        ("x = 1\n", "law.py: expected a function step(inputs, parameters, t, h) or one class with it, found neither"),
        ("def step(*_):\n    return 3\n", "expected a mapping such as {'tau_cmd_B': [...]}, found int"),
        ("def step(*_):\n    return {'z': 3}\n", "there is no output 'z'; expected some of y, of"),
        ("def step(*_):\n    return {'of': [1]}\n", "of: expected a real [2], found one of shape [1]"),
        ("def step(*_):\n    return {'of': ['a', 'b']}\n", "of: expected a real [2], found ['a', 'b']"),
        ("def step(*_):\n    return {'of': [1, 2]}\n", "expected y, which other blocks take in, found ['of']"),
        ("def step(inputs, *_):\n    inputs.of[0] = 1\n", "law.py:2: AttributeError: "),
    ],
)
def test_what_is_wrong_in_it_is_told_with_its_file_and_line(tmp_path, text, message):
    with pytest.raises(BlockError) as caught:
        alone(tmp_path, text, frozenset({"y"})).leave()
    assert message in str(caught.value)


def test_an_error_in_flight_has_the_time_and_the_line(tmp_path):
    law = DAMPING.replace("    return", "    if t > 1:\n        raise ValueError('too late')\n    return")
    with pytest.raises(BlockError, match=r"controller: step at 1 s: .*my_law.py:4: ValueError: too late"):
        flown(tmp_path, law)


@pytest.mark.skipif(sys.platform == "win32", reason="the folder is not looked at there")
def test_a_law_that_changes_the_working_folder_is_told_and_it_is_restored(tmp_path):
    here = Path.cwd()
    law = "import os\n" + DAMPING.replace("    return", "    os.chdir('/')\n    return")
    result = flown(tmp_path, law, 2.0, isolation="none")
    assert Path.cwd() == here
    assert "controller: the run changed the working folder; it was restored" in result.warnings


def command(folder: Path, timeout: float = 60.0) -> subprocess.CompletedProcess[str]:
    """The command in a process of its own, on the scenario that `flown` wrote."""
    line = [sys.executable, "-m", "orchestration", "own.yaml", "--out", "out"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "COLUMNS": "400"}
    return subprocess.run(
        line, cwd=folder, env=environment, capture_output=True, text=True, timeout=timeout, check=False
    )


@pytest.mark.parametrize("isolation", ["none", "process"])
@pytest.mark.parametrize(
    ("begins", "raised", "message"),
    [
        ("", "if t > 1: raise KeyboardInterrupt('mine')", "controller: step at 1 s: {}:4: KeyboardInterrupt: mine"),
        ("", "if t > 1: raise E('mine')", "controller: step at 1 s: {}:4: E: mine"),
        (
            "raise KeyboardInterrupt('mine')",
            "",
            "python: my_law.py: controller: reading the law in initialization: {}:2: KeyboardInterrupt: mine",
        ),
    ],
)
def test_whatever_it_raises_is_its_own_error_and_no_interrupt(tmp_path, isolation, begins, raised, message):
    flown(tmp_path, DAMPING, 2.0, isolation=isolation)
    text = f"class E(BaseException): pass\n{begins}\ndef step(inputs, parameters, t, h):\n    {raised or 'pass'}\n"
    (tmp_path / "my_law.py").write_text(text + "    return {'tau_cmd_B': [0, 0, 0]}\n")
    done = command(tmp_path)
    assert done.returncode == (2 if begins else 3)
    assert "Traceback" not in done.stderr
    assert message.format(tmp_path / "my_law.py") in done.stderr
    assert (tmp_path / "out" / "signals.csv").is_file() != bool(begins)


@pytest.mark.skipif(sys.platform != "linux", reason="a run is waited for on Linux alone")
@pytest.mark.parametrize("isolation", ["none", "process"])
def test_copies_of_the_process_that_it_makes_write_nothing(tmp_path, isolation):
    flown(tmp_path, DAMPING, 2.0, isolation=isolation)
    law = "import os\n" + DAMPING.replace("    return", "    if 1 < t < 1.3: os.fork()\n    return")
    (tmp_path / "my_law.py").write_text(law)
    done = command(tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.count("results in out") == 1
    assert len((tmp_path / "out" / "signals.csv").read_text().splitlines()) == 22


@pytest.mark.skipif(sys.platform == "win32", reason="threads are not looked at there")
def test_the_program_does_not_wait_for_threads_that_it_leaves_and_says_so(tmp_path):
    flown(tmp_path, DAMPING, 2.0, isolation="none")
    begin = "import threading, time\nthreading.Thread(target=time.sleep, args=(1000,), name='mine').start()\n"
    (tmp_path / "my_law.py").write_text(begin + DAMPING)
    done = command(tmp_path)
    assert done.returncode == 0
    assert "controller: reading the law left threads that go on (mine); they end with this program" in done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="files are not looked at there")
def test_what_it_takes_from_the_process_while_it_is_read_is_given_back(tmp_path):
    flown(tmp_path, DAMPING, 2.0, isolation="none")
    begin = "import resource, sys\nfile = resource.RLIMIT_FSIZE\n"
    begin += "resource.setrlimit(file, (100, resource.getrlimit(file)[1]))\nsys.stdout = None\n"
    (tmp_path / "my_law.py").write_text(begin + DAMPING)
    done = command(tmp_path)
    assert done.returncode == 0
    assert "controller: reading the law changed the limit of a file's size; it was restored" in done.stderr
    assert "controller: reading the law changed sys.stdout; it was restored" in done.stderr
    assert "results in out" in done.stdout


HOSTILE = {
    "dumps": "import json; json.dumps = lambda *a, **k: 1 / 0",
    "modules": "import sys; sys.modules.clear()",
    "recursion": "import sys; sys.setrecursionlimit(60)",
    "files": "import os; os.closerange(0, 200)",
    "isinstance": "import builtins; builtins.isinstance = lambda *a: False",
    "builtins": "import builtins; vars(builtins).clear()",
    "numpy": "import numpy; numpy.asarray = lambda *a, **k: 1",
    "verdict": "import orchestration.session.run as r; r.Result.passed = True",
    "end": "import os; os._exit(0)",
    "atexit": "import atexit, os; atexit.register(lambda: os._exit(0))",
    "crash": "import ctypes; ctypes.string_at(0)",
    "replace": "import os; os.replace = os.rename = lambda *a: 1 / 0",
}
UNMET = [{"name": "unmet", "signal": "plant.omega_B", "measure": "norm", "always": {"above": "100 rad/s"}}]


@pytest.mark.parametrize("attack", HOSTILE)
def test_a_law_that_spoils_its_process_loses_no_sample_and_chooses_no_verdict(attack, tmp_path):
    """It fails by its name, with all samples before, or what it did has no effect on the run."""
    flown(tmp_path, DAMPING, 2.0)
    data = json.loads((tmp_path / "own.yaml").read_text())
    (tmp_path / "own.yaml").write_text(json.dumps({**data, "expect": UNMET}))
    lines = ["def step(inputs, parameters, t, h):", f"    if t > 1.05:\n        {HOSTILE[attack]}"]
    (tmp_path / "my_law.py").write_text("\n".join([*lines, "    return {'tau_cmd_B': [0, 0, 0]}\n"]))
    done = command(tmp_path)
    rows = len((tmp_path / "out" / "signals.csv").read_text().splitlines()) - 1
    assert done.returncode in (1, 3), done.stderr
    assert ("controller: " in done.stderr) == (done.returncode == 3)
    assert rows >= (11 if done.returncode == 3 else 21)


@pytest.mark.skipif(sys.platform != "linux", reason="a run is waited for on Linux alone")
def test_a_law_that_spoils_the_process_of_the_run_is_named_where_it_asked_for_that(tmp_path):
    flown(tmp_path, DAMPING, 2.0, isolation="none")
    (tmp_path / "my_law.py").write_text(HOSTILE["dumps"] + "\n" + DAMPING)
    done = command(tmp_path)
    assert done.returncode == 3
    assert "controller shares this process and may have changed it; remedy: isolation: process" in done.stderr


@pytest.mark.parametrize("where", ["in initialization", "at 1 s"])
def test_a_law_that_does_not_return_is_named_through_python_and_what_was_computed_is_kept(where, tmp_path):
    late = -1 if "init" in where else 1
    law = f"import time\ndef step(inputs, parameters, t, h):\n    if t > {late}: time.sleep(99)\n"
    with pytest.raises(BlockError, match=f"controller: step {where}: did not return within 1 s"):
        flown(tmp_path, law + "    return {'tau_cmd_B': [0, 0, 0]}\n", 2.0, timeout="1 s")


@pytest.mark.skipif(sys.platform != "linux", reason="a run is waited for on Linux alone")
@pytest.mark.parametrize("late", [False, True], ids=["in initialization", "in a step"])
def test_a_law_that_ends_the_process_does_not_end_the_run_with_status_0(tmp_path, late):
    flown(tmp_path, DAMPING, 2.0, isolation="none")
    (tmp_path / "my_law.py").write_text(
        f"import os\ndef step(inputs, parameters, t, h):\n    if t > {1.0 if late else -1.0}:\n        os._exit(0)\n"
        "    return {'tau_cmd_B': [0, 0, 0]}\n"
    )
    done = command(tmp_path)
    assert done.returncode == 3
    assert f"controller: step{'' if late else ' in initialization'}: ended the run with exit status 0" in done.stderr


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"python": "none.py"}, "blocks.controller.python: there is no file none.py"),
        ({"python": "my_law.txt"}, "expected the path of a .py file, found my_law.txt"),
        ({"interface": "law"}, "the project has no interface 'law'; remedy: 'interface: NAME' beside it, one of plant"),
        ({"fmu": "controller"}, "expected 'python' alone, found 'fmu', too"),
    ],
)
def test_an_entry_that_names_no_law_is_refused_at_its_line(tmp_path, entry, message):
    with pytest.raises(InputError, match=message.replace("'", ".")):
        flown(tmp_path, DAMPING, **entry)
