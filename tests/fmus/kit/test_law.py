"""A law in Python packed by the kit: the block gives what the law gives, remembers, and can be saved."""

from __future__ import annotations

import importlib
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from fmus import kit
from fmus.block import importing_from
from fmus.interface import load
from fmus.python.memory import Layout, check_state
from tests.blocks import inputs, parameters
from tests.commands import orchestrate

COUNTING = """
class Counting:
    def __init__(self):
        self.calls = 0
    def step(self, u, p, t, h):
        self.calls += 1
        return {"tau_cmd_B": [float(self.calls), t, h], "attitude_error": 0.5}
"""
PLAIN = "def step(u, p, t, h):\n    return {'tau_cmd_B': -p.J_B @ u.omega_B}\n"


def packed(folder, law):
    kit.write(load("controller"), folder, "python", law.encode())
    with importing_from(folder, "controller"):
        return importlib.import_module("controller")


def test_a_function_gives_its_outputs_and_zeros_for_the_rest(tmp_path):
    block = packed(tmp_path, PLAIN)
    p, u = parameters("controller"), inputs("controller", omega_B=[0.1, -0.2, 0.3])
    out = block.outputs(block.start(p, u), u, p)
    assert out.tau_cmd_B == pytest.approx(-p.J_B @ [0.1, -0.2, 0.3])
    assert (out.attitude_error, out.no_attitude) == (0.0, False)
    values = Layout(load("controller"), block).store(out, Layout(load("controller"), block).starts)
    assert len(values) > 10


def test_what_a_law_leaves_out_is_in_the_fmu_what_it_is_where_the_file_flies(tmp_path):
    (tmp_path / "law.py").write_text(PLAIN)
    result = orchestrate("new", "controller_planned", tmp_path / "made", "--from", tmp_path / "law.py")
    assert result.exit_code == 0, result.stderr
    with importing_from(tmp_path / "made", "controller_planned"):
        block = importlib.import_module("controller_planned")
    p, u = SimpleNamespace(J_B=np.eye(3)), SimpleNamespace(omega_B=np.ones(3), h_w=0.0025)
    out = block.outputs(block.start(p, u), u, p)
    assert out.h_w_estimate == 0.0025
    assert (out.rod_gains_estimate.tolist(), out.wheel_torque_ff) == ([1e9] * 3, 1e9)
    assert (out.plan_cost, out.rod_failed) == (0.0, False)


def test_a_class_remembers_once_a_step_and_its_state_can_be_saved(tmp_path):
    block = packed(tmp_path, COUNTING)
    p, u = parameters("controller"), inputs("controller")
    sys.modules["controller.law"] = block.block._law  # as the FMU imports it, for pickle
    try:
        x = block.start(p, u)
        for _ in range(3):
            assert block.outputs(x, u, p).tau_cmd_B.tolist() == [1.0, 0.0, 0.0]  # commits nothing
        for k in range(1, 4):
            x, out = block.step(x, u, p, 0.5)
            check_state(x)
            assert out.tau_cmd_B.tolist() == [1.0 + k, 0.5 * k, 0.5]
            np.testing.assert_array_equal(block.outputs(x, u, p).tau_cmd_B, out.tau_cmd_B)
    finally:
        del sys.modules["controller.law"]


def test_the_command_writes_the_project_with_the_law(tmp_path):
    law = tmp_path / "my_law.py"
    law.write_text(PLAIN)
    refused = orchestrate("new", "controller", tmp_path / "x", "--from", law, "--link")
    assert "--from: expected neither --link nor --lang c beside it" in refused.stderr
    assert "there is no such file" in orchestrate("new", "controller", tmp_path / "x", "--from", "none.py").stderr
    assert orchestrate("new", "controller", tmp_path / "made", "--from", law).exit_code == 0
    assert (tmp_path / "made" / "controller" / "law.py").read_text() == PLAIN
