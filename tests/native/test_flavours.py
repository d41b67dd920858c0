"""The C and the Python of each block give the same outputs: 1e-9 relative in every port, on random inputs and options."""

from __future__ import annotations

import importlib
import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fmus.interface import load
from tests.blocks import inputs, parameters

from .driver import Instance, Refused

RELATIVE = 1e-9


def controller_case(rng: np.random.Generator) -> tuple[Any, Any]:
    angle = rng.choice([0.0, 1e-9, rng.uniform(0.0, math.pi), math.pi - 1e-9, math.pi])
    axis = _unit(rng)
    r_N = _unit(rng) * rng.uniform(6.6e6, 4e7)
    u = inputs(
        "controller",
        R_NB=_rotation(rng) @ Rotation.from_rotvec(angle * axis).as_matrix(),
        omega_B=rng.normal(scale=0.1, size=3),
        r_N=r_N,
        v_N=rng.normal(scale=5e3, size=3),
    )
    p = parameters(
        "controller",
        J_B=inertia(rng),
        K0=np.sort(rng.uniform(0.1, 2.0, 3)),
        L0=positive_definite(rng),
        phi=str(rng.choice(["linear", "logarithm", "square_root"])),
        phi_scale=rng.uniform(0.01, 2.0),
        compensate_gravity=bool(rng.integers(2)),
        gain_schedule=str(rng.choice(["error", "constant"])),
        kappa0=rng.uniform(0.01, 1.0),
        lambda0=rng.uniform(0.01, 2.0),
        reference=str(rng.choice(["lvlh", "inertial", "rate"])),
        R_d0=_rotation(rng) + rng.uniform(-1e-4, 1e-4, (3, 3)),
        Omega_d0=rng.normal(scale=0.1, size=3),
    )
    return p, u


def allocator_case(rng: np.random.Generator) -> tuple[Any, Any]:
    u = inputs(
        "allocator",
        tau_cmd_B=rng.normal(scale=rng.choice([0.0, 1e-6, 1e-4, 1e-2]), size=3),
        b_B=rng.normal(scale=rng.choice([1e-13, 3e-5]), size=3) * rng.choice([[1, 1, 1], [0, 1, 1], [0, 0, 1], [1, 0, 0]]),
        omega_B=rng.normal(scale=rng.choice([0.0, 0.05]), size=3),
        h_w=rng.choice([0.0, rng.normal(scale=0.02)]),
    )
    axes = rng.normal(size=(3, 3))
    p = parameters(
        "allocator",
        rod_axes=axes / np.linalg.norm(axes, axis=1)[:, None],
        dipole_max=rng.uniform(1.0, 50.0),
        wheel_torque_max=rng.uniform(1e-3, 1e-2),
        hold_fraction=rng.uniform(0.3, 1.0),
    )
    return p, u


CASES = {"controller": controller_case, "allocator": allocator_case}


@pytest.mark.parametrize("block", CASES)
def test_outputs_in_initialization_and_over_steps_agree(block: str) -> None:
    rng = np.random.default_rng(4)
    python = importlib.import_module(block)
    compared = 0
    for _ in range(100):
        p, u = CASES[block](rng)
        python.check(p)
        with Instance(block) as native:
            native.set_all(p)
            native.set_all(u)
            native.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
            native.call("EnterInitializationMode")
            x = python.start(p, u)
            assert_same(native.outputs(), python.outputs(x, u, p), block)
            native.call("ExitInitializationMode")
            for i in range(5):
                _, u = CASES[block](rng)
                native.set_all(u)
                assert_same(native.outputs(), python.outputs(x, u, p), block)  # Get after Set, before doStep
                native.step(0.1 * i, 0.1)
                x, y = python.step(x, u, p, 0.1)
                assert_same(native.outputs(), y, block)
                compared += 1
    assert compared == 500


@pytest.mark.parametrize("block", CASES)
def test_what_one_flavour_refuses_the_other_refuses(block: str) -> None:
    wrong: dict[str, list[dict[str, Any]]] = {
        "controller": [
            {"K0": [0.6, 0.5, 0.7]},
            {"K0": [0.0, 0.5, 0.7]},
            {"L0": np.diag([1.0, -1.0, 1.0])},
            {"L0": [[1.0, 0.2, 0.0], [0.1, 1.0, 0.0], [0.0, 0.0, 1.0]]},
            {"J_B": np.diag([1.0, 1.0, 2.1])},
            {"J_B": np.diag([1.0, 1.0, -1.0])},
            {"J_B": [[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]]},
            {"R_d0": np.diag([1.0, 1.0, -1.0]), "reference": "inertial"},
            {"R_d0": np.diag([1.0, 1.0, 0.99])},
            {"R_NB": np.diag([1.0, 1.0, -1.0])},
            {"R_NB": np.diag([1.0, 1.0, 1.001])},
            {"v_N": [1.0, 0.0, 0.0]},
            {"r_N": [0.0, 0.0, 0.0], "reference": "inertial"},
        ],
        "allocator": [
            {"rod_axes": np.eye(3) * 1.0 - 1e-4 * np.eye(3)},
            {"rod_axes": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]},
        ],
    }
    python = importlib.import_module(block)
    names = {v.name for v in load(block).of("parameter")}
    for changes in wrong[block]:
        p = parameters(block, **{k: v for k, v in changes.items() if k in names})
        u = inputs(block, **{k: v for k, v in changes.items() if k not in names})
        with pytest.raises(ValueError, match="expect"):
            python.check(p)
            python.outputs(python.start(p, u), u, p)
        with Instance(block) as native:
            native.set_all(p)
            native.set_all(u)
            with pytest.raises(Refused, match=f"^3: .*{next(iter(changes))}.*expected .*found"):
                native.initialize()


def assert_same(native: dict[str, Any], reference: Any, block: str, relative: float = RELATIVE) -> None:
    """Every port of `native` is that of `reference`, to `relative` of the port's size (of the vector's norm)."""
    for name, value in native.items():
        expected = np.asarray(getattr(reference, name), dtype=float)
        difference = np.abs(np.asarray(value, dtype=float) - expected).max()
        size = float(np.linalg.norm(expected))
        assert difference <= relative * size + _FLOOR.get(name, 0.0), f"{block}.{name}: {value} instead of {expected}"


_FLOOR = {
    "attitude_error": 1e-15,  # rounding of Q, where the angle is next to 0
    "lyapunov": 1e-15,  # 1 - Q_ii
    "tau_cmd_B": 1e-16,
    "rate_error_B": 1e-16,
    "tau_residual_B": 1e-16,  # a difference of equals: rounding of the demand and of the wheel's part
    "wheel_torque_cmd": 1e-18,
}
"""Absolute parts, SI, where an output is a difference of nearly equal numbers."""


def _unit(rng: np.random.Generator) -> np.ndarray:
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def _rotation(rng: np.random.Generator) -> np.ndarray:
    return Rotation.random(random_state=rng).as_matrix()


def inertia(rng: np.random.Generator) -> np.ndarray:
    """Full and unequal, of a body: from three masses' second moments."""
    a, b, c = rng.uniform(0.5, 2.0, 3)
    R = _rotation(rng)
    J = R @ np.diag([b + c, c + a, a + b]) @ R.T
    return 0.5 * (J + J.T)


def positive_definite(rng: np.random.Generator) -> np.ndarray:
    R = _rotation(rng)
    L = R @ np.diag(rng.uniform(0.2, 2.0, 3)) @ R.T
    return 0.5 * (L + L.T)
