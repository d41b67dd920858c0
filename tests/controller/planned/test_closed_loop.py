"""The loop of plant, planned controller and allocator as FMUs; judged by the plant's truth."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import orchestration

from .core import ROOT

START = {"omega_B0": [0.03, -0.045, 0.035], "node_longitude": "200 deg", "drag": False}
ALWAYS = """
plant.R_NB -> controller.R_NB
plant.omega_B -> controller.omega_B
plant.r_N -> controller.r_N
plant.v_N -> controller.v_N
controller.tau_cmd_B -> allocator.tau_cmd_B
plant.b_B -> allocator.b_B
plant.omega_B -> allocator.omega_B
plant.h_w -> allocator.h_w
allocator.dipole_cmd -> plant.dipole_cmd
allocator.wheel_torque_cmd -> plant.wheel_torque_cmd
"""
MEASURED = """
plant.h_w -> controller.h_w
plant.b_B -> controller.b_B
allocator.dipole_cmd[1] -> controller.u_applied[1]
allocator.dipole_cmd[2] -> controller.u_applied[2]
allocator.dipole_cmd[3] -> controller.u_applied[3]
allocator.wheel_torque_cmd -> controller.u_applied[4]
"""
FORWARD = """
controller.dipole_ff -> allocator.dipole_ff
controller.wheel_torque_ff -> allocator.wheel_torque_ff
"""


def fly(connections, allocator="allocator_bounded", duration=1500.0, faults=(), shared=None):
    """A tumble of 3.7 deg/s in SI units and within the true limits."""
    return orchestration.run(
        {
            "name": "tumble",
            "shared": shared or {},
            "step": "0.1 s",
            "duration": duration,
            "blocks": {
                "plant": {"fmu": "plant", "start": START},
                "controller": {"fmu": "controller_planned", "every": 5},
                "allocator": {"fmu": allocator, "every": 5},
            },
            "connections": [line for line in connections.splitlines() if line],
            "record": {"interval": 1.0},
            "faults": list(faults),
        }
    )


def errors(result):
    """Angle, rad, and rate, rad/s, from LVLH, of the plant's own motion."""
    r, v = result["plant.r_N"], result["plant.v_N"]
    h = np.cross(r, v)
    z, y = (-x / np.linalg.norm(x, axis=1)[:, None] for x in (r, h))
    target = np.stack((np.cross(y, z), y, z), axis=2)
    Q = target.transpose(0, 2, 1) @ result["plant.R_NB"]
    orbital = np.zeros_like(r)
    orbital[:, 1] = -np.linalg.norm(h, axis=1) / (r**2).sum(axis=1)
    omega = result["plant.omega_B"] - np.einsum("nji,nj->ni", Q, orbital)
    return Rotation.from_matrix(Q).magnitude(), np.linalg.norm(omega, axis=1)


def keeps_its_limits(result):
    assert np.abs(result["plant.dipole"]).max() <= 25.0 * (1 + 1e-12)
    assert np.abs(result["plant.h_w"]).max() <= 0.03 * (1 + 1e-12)
    assert np.abs(result["controller.dipole_ff"]).max() <= 25.0 * (1 + 1e-12)
    assert np.abs(result["controller.wheel_torque_ff"]).max() <= 3e-3 * (1 + 1e-12)


def settled(result, after):
    angle, rate = errors(result)
    late = result.time >= after
    return angle[late].max() < math.radians(1.0) and rate[late].max() < 1e-3


@pytest.mark.parametrize(
    "connections",
    [
        pytest.param(ALWAYS + MEASURED + FORWARD, id="all ports"),
        pytest.param(ALWAYS + MEASURED, id="without feed-forward"),
        pytest.param(ALWAYS + FORWARD, id="without h_w, b_B and u_applied"),
        pytest.param(ALWAYS, id="with the ports of the paper's controller alone"),
    ],
)
def test_a_tumble_settles_within_the_limits(connections):
    result = fly(connections)
    keeps_its_limits(result)
    angle, rate = errors(result)
    assert rate[0] > 0.04
    assert settled(result, 1200.0)
    # What it tells of itself is what the plant knows.
    assert result["controller.attitude_error"][-1] == pytest.approx(angle[-1], abs=2e-4)
    assert result["controller.h_w_estimate"][-1] == pytest.approx(result["plant.h_w"][-1], abs=1e-3)
    phases = result["controller.phase"]
    assert phases[0] == 1
    assert phases[-1] == 3
    assert (np.diff(phases.astype(int)) >= 0).all()


def test_a_body_with_a_very_small_moment_settles():
    """Of a hundredth of the mean one, with another wheel: the rods turn it about that axis much sooner than about the
    others."""
    slender = {"J_B": {"diagonal": [0.02, 3.0, 3.0]}, "wheel_axis": [0.0, 1.0, 0.0]}
    actuators = {"dipole_max": 2.0, "wheel_torque_max": 1e-3, "wheel_momentum_max": 0.02}
    result = fly(ALWAYS + MEASURED + FORWARD, duration=6000.0, shared=slender | actuators)
    angle, _ = errors(result)
    assert angle.max() > 3.0
    assert angle[result.time > 5000.0].max() < math.radians(5.0)


def test_the_papers_allocator_runs_with_the_planned_controller_but_holds_through_the_steering():
    """It leaves out the rods' direction along the field and holds its command above a share of the limits."""
    result = fly(ALWAYS + MEASURED, "allocator", 600.0)
    keeps_its_limits(result)
    assert np.isfinite(result.samples).all()
    steering = result["controller.phase"] == 1
    assert steering.any()
    assert result["allocator.holding"][steering].mean() > 0.5


def test_the_papers_controller_flies_with_the_bounded_allocator():
    """The paper's manoeuvre V.B, in its own reading, by the other allocator."""
    scenario = orchestration.load(ROOT / "scenarios" / "paper_no_singularity.yaml").source.data
    kept = {name: scenario[name] for name in ("name", "shared", "step", "duration", "blocks", "connections")}
    kept["blocks"]["allocator"] = {"fmu": "allocator_bounded"}
    result = orchestration.run(kept)
    angle, rate = errors(result)
    assert angle[0] > 1.5
    late = result.time > 250.0
    assert angle[late].max() < math.radians(2.0)
    assert rate[late].max() < 1e-3
