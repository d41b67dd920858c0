"""A satellite whose body axes have other names is the same satellite: the wheel's axis is one of its vectors."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import orchestration
from tests.blocks import inputs, module, parameters

from .driver import Instance, Refused

GENERIC = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
TURNS = [np.eye(3)[[1, 2, 0]], np.eye(3)[[2, 0, 1]], np.diag([-1.0, -1.0, 1.0]), GENERIC]
"""A vector's elements in new axes are these times those in the old ones: e1 becomes e3, e2, -e1, and none of them."""
NAMES = ["e3", "e2", "-e1", "generic"]
E1 = np.array([1.0, 0.0, 0.0])
RODS = np.array([[3**-0.5, 3**-0.5, -(3**-0.5)], [3**-0.5, -(3**-0.5), 3**-0.5], [0.0, 0.0, 1.0]])
FULL_J = np.array([[2.13, 0.11, -0.07], [0.11, 3.04, 0.19], [-0.07, 0.19, 3.09]])
every_turn = pytest.mark.parametrize("turn", TURNS, ids=NAMES)


def outputs_of(block, flavour, values, steps=0):
    """Of an instance with these parameters and inputs, after some steps of 0.5 s."""
    if flavour == "native":
        with Instance(block) as it:
            for name, value in values.items():
                it.set(name, value)
            it.initialize()
            for i in range(steps):
                it.step(0.5 * i, 0.5)
            return it.outputs()
    code = module(block)
    known = parameters(block).__dict__
    p = parameters(block, **{k: v for k, v in values.items() if k in known})
    u = inputs(block, **{k: v for k, v in values.items() if k not in known})
    code.check(p)
    x = code.start(p, u)
    y = code.outputs(x, u, p)
    for _ in range(steps):
        x, y = code.step(x, u, p, 0.5)
    return {name: np.asarray(value) for name, value in y.__dict__.items()}


# ---------------------------------------------------------------- allocators


@every_turn
@pytest.mark.parametrize("flavour", ["native", "python"])
@pytest.mark.parametrize("block", ["allocator", "allocator_bounded"])
def test_the_commands_do_not_depend_on_the_names_of_the_axes(block, flavour, turn):
    B, tau, Omega = np.array([1e-5, -2e-5, 3e-5]), np.array([4e-5, 7e-5, -5e-5]), np.array([0.02, -0.01, 0.03])

    def of(t):
        body = {"rod_axes": RODS @ t.T, "wheel_axis": t @ E1, "b_B": t @ B, "tau_cmd_B": t @ tau, "omega_B": t @ Omega}
        return outputs_of(block, flavour, body | {"h_w": 0.004})

    old, new = of(np.eye(3)), of(turn)
    assert np.abs(old["dipole_cmd"]).min() > 0.1
    for name in ("dipole_cmd", "wheel_torque_cmd", "demand_fraction", "b_wheel"):
        assert new[name] == pytest.approx(old[name], rel=1e-9, abs=1e-15), name
    assert new["tau_residual_B"] == pytest.approx(turn @ old["tau_residual_B"], abs=1e-15)
    assert old["b_wheel"] == pytest.approx(B[0] / np.linalg.norm(B))


# ---------------------------------------------------------------- plant


@every_turn
@pytest.mark.parametrize("flavour", ["native", "python"])
def test_the_motion_does_not_depend_on_the_names_of_the_axes(flavour, turn):
    """Tumbling, with the wheel running up against its friction, rods on, a disturbance and gravity gradient."""

    def of(t):
        Q0 = Rotation.from_rotvec([1.0, 0.3, -0.4]).as_matrix()
        body = {
            "J_B": t @ FULL_J @ t.T, "rod_axes": RODS @ t.T, "wheel_axis": t @ E1, "Q0": Q0 @ t.T,
            "omega_B0": t @ [0.05, -0.03, 0.04], "residual_dipole_B": t @ [0.1, 0.2, -0.3],
            "disturbance_torque_B": t @ [1e-5, 2e-5, -3e-5], "drag": False, "h_w0": 0.012,
            "wheel_coulomb_friction": 5e-5, "wheel_viscous_friction": 1e-7,
            "dipole_cmd": [20.0, -11.0, 4.0], "wheel_torque_cmd": 1.5e-3,
        }  # fmt: skip
        return outputs_of("plant", flavour, body, 10 if flavour == "native" else 4)

    old, new = of(np.eye(3)), of(turn)
    assert np.abs(new["R_NB"] - old["R_NB"] @ turn.T).max() < 1e-13
    for name in ("omega_B", "b_B", "tau_mag_B", "tau_gg_B"):
        assert new[name] == pytest.approx(turn @ old[name], rel=1e-11, abs=1e-15), name
    for name in ("H_N", "h_w", "energy", "wheel_torque"):
        assert new[name] == pytest.approx(old[name], rel=1e-11), name


@pytest.mark.parametrize("block", ["plant", "controller_planned", "allocator", "allocator_bounded"])
def test_an_axis_that_is_not_of_unit_length_is_refused_by_name(block):
    with pytest.raises(Refused, match=r"wheel_axis: expected a vector of unit length, to 1e-06, found 1\.41"):
        outputs_of(block, "native", {"wheel_axis": [1.0, 0.0, 1.0]})
    if block != "controller_planned":
        with pytest.raises(ValueError, match=r"wheel_axis.*1\.41421"):
            outputs_of(block, "python", {"wheel_axis": [1.0, 0.0, 1.0]})


# ---------------------------------------------------------------- the loop


@cache
def tumble(which):
    """The attitude (n, 3, 3) of a tumble of 2.5 deg/s and its plans, in the axes of TURNS[which], or the old ones; the
    target is at rest.

    K0 is the same about all axes but for 1e-9, since its order belongs to the axes' names.
    """
    t = np.eye(3) if which is None else TURNS[which]
    start = {"J_B": t @ FULL_J @ t.T, "rod_axes": RODS @ t.T, "wheel_axis": t @ E1}
    motion = {
        "initial_attitude": "q_NB0",
        "q_NB0": Rotation.from_matrix(Rotation.from_rotvec([0.4, 1.2, -0.3]).as_matrix() @ t.T).as_quat()[[3, 0, 1, 2]],
        "omega_B0": t @ [0.02, -0.03, 0.025],
        "drag": False,
    }
    law = {"reference": "inertial", "R_d0": t.T, "K0": 5e-4 * (1.0 + np.array([0.0, 1e-9, 2e-9])), "identify": False}
    law |= {"steering_limit": 0.08}  # so that it is steered first
    vectors = "|".join(f"plant.{name} -> controller.{name}" for name in ("R_NB", "omega_B", "r_N", "v_N"))
    wires = (
        f"{vectors}|plant.h_w -> controller.h_w|plant.b_B -> controller.b_B|controller.tau_cmd_B -> "
        "allocator.tau_cmd_B|"
        "controller.dipole_ff -> allocator.dipole_ff|controller.wheel_torque_ff -> "
        "allocator.wheel_torque_ff|plant.b_B -> allocator.b_B|"
        "plant.omega_B -> allocator.omega_B|plant.h_w -> allocator.h_w|allocator.dipole_cmd -> plant.dipole_cmd|"
        "allocator.wheel_torque_cmd -> plant.wheel_torque_cmd"
    )

    def data(values):
        return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in values.items()}

    result = orchestration.run(
        {
            "name": "renamed",
            "step": 0.1,
            "duration": 600.0,
            "blocks": {
                "plant": {"fmu": "plant", "start": data(start | motion)},
                "controller": {"fmu": "controller_planned", "every": 5, "start": data(start | law)},
                "allocator": {
                    "fmu": "allocator_bounded",
                    "every": 5,
                    "start": data({k: v for k, v in start.items() if k != "J_B"}),
                },
            },
            "connections": wires.split("|"),
            "record": {"interval": 10.0},
        }
    )
    return result["plant.R_NB"] @ t, result["controller.plan_cost"], result["controller.phase"]


@pytest.mark.parametrize("k", range(3), ids=NAMES[:3])
def test_the_loop_flies_the_same_motion_under_other_names(k):
    """Through steering and the first plan to rounding. Later plans amplify it: elements of the filter are corrected in
    the order of the axes' names, so their bits differ. The phases stay the same."""
    (R, cost, phase), (R_new, cost_new, phase_new) = tumble(None), tumble(k)
    assert phase[0] == 1
    assert phase[-1] > 1
    assert phase_new.tolist() == phase.tolist()
    planned = int(np.argmax(phase > 1)) + 1
    assert np.abs(R_new - R)[: planned + 1].max() < 1e-8
    assert cost[planned] > 0.0
    assert cost_new[planned] == pytest.approx(cost[planned], rel=1e-4)
