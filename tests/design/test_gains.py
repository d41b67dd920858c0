"""The command `python -m evidence sizing`: its gains, what it says of them, and the scenario that flies them."""

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

import allocator
from design.gains import available, directions, initial_errors
from design.loop import read
from evidence.__main__ import main
from orchestration import run

SCENARIO = "scenarios/paper_no_singularity.yaml"
SIZED = "scenarios/sized_no_singularity.yaml"
SATELLITE = "scenarios/satellites/paper_50kg.yaml"


def ask(*arguments):
    return CliRunner().invoke(main, ["sizing", *arguments], env={"COLUMNS": "200"})


def test_the_errors_of_a_scenario_are_those_that_its_judge_sees_at_the_start():
    found = run(SCENARIO, {"duration": 0.1})
    angle, rate = initial_errors(read(SCENARIO).loop)
    assert angle == pytest.approx(found["judge.attitude_error"][0], abs=1e-9)
    assert rate == pytest.approx(np.linalg.norm(found["judge.rate_error_B"][0]), abs=1e-9)


def test_the_allocator_gives_the_available_torque_about_every_axis_and_holds_at_more_about_some():
    p = replace(read(SCENARIO).loop.allocator, hold_fraction=0.8)
    rng = np.random.default_rng(4)
    axes = rng.standard_normal((200, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]

    def holds(torque, b_B):
        return any(
            allocator.outputs(allocator.start(p, u), u, p).holding
            for u in (allocator.Inputs(torque * axis, b_B, np.zeros(3), 0.0) for axis in axes)
        )

    for b_B in 3e-5 * directions()[[3, 400, 990, 1500]]:
        torque = float(available(p, b_B[None])[0])
        assert not holds(0.999 * torque, b_B)
        assert holds(1.1 * torque, b_B)


def test_the_directions_are_even_over_the_sphere():
    b = directions()
    assert np.linalg.norm(b, axis=1) == pytest.approx(1.0)
    assert np.abs(b.mean(axis=0)).max() < 1e-3
    assert b.T @ b / len(b) == pytest.approx(np.eye(3) / 3.0, abs=1e-3)
