"""Where a block decides by a threshold, both flavours take the same side just below and just above it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.blocks import inputs, module, parameters

from .agreement import assert_same
from .driver import Instance, Refused

R = Rotation.from_rotvec([0.4, -0.7, 0.2]).as_matrix()
TURN = Rotation.from_rotvec([0.3, 0.5, -0.2]).as_matrix()
FIELD = np.array([2e-5, -1e-5, 3e-5])
TAU = np.array([2e-4, -3e-4, 1e-4])


def stretched(error: float) -> np.ndarray:
    """A matrix of which R^T R - I has this largest element."""
    return R @ np.diag([1.0, np.sqrt(1.0 + error), 1.0])


def flat_rods(share: float) -> dict[str, Any]:
    """det A^T A of [22] is share times 1e-12: rods next to a plane through the field, which still count as
    independent."""
    lift = np.sqrt(share * 1e-12 / (2.0 * np.sin(0.5) ** 2))
    rods = np.array([[np.sin(0.5), 0.0, np.cos(0.5)], [-np.sin(0.5), 0.0, np.cos(0.5)], [0.0, lift, 1.0]])
    return {
        "rod_axes": rods / np.linalg.norm(rods, axis=1)[:, None] @ TURN.T,
        "b_B": TURN @ [0.0, 0.0, 3e-5],
        "tau_cmd_B": 1e-20 * TURN @ [1.0, 0.0, 0.0],
    }


def rods_volume(share: float) -> dict[str, Any]:
    axes = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.8, share * 1e-6]])
    return {"rod_axes": axes}


def held(share: float) -> dict[str, Any]:
    """hold_fraction is the demand's fraction times share."""
    u, p = inputs("allocator", tau_cmd_B=TAU, b_B=FIELD), parameters("allocator", hold_fraction=1.0)
    block = module("allocator")
    fraction = block.outputs(block.start(p, u), u, p).demand_fraction
    assert 0.01 < fraction < 1.0
    return {"tau_cmd_B": TAU, "b_B": FIELD, "hold_fraction": fraction / share}


ORBIT: dict[str, Callable[[float], dict[str, Any]]] = {
    "position": lambda s: {"r_N": [s, 0.0, 0.0], "v_N": [0.0, 7e3, 0.0]},
    "plane of the orbit": lambda s: {"r_N": [7e6, 0.0, 0.0], "v_N": [1e3, s * 1e-6, 0.0]},
    "attitude": lambda s: {"R_NB": stretched(s * 1e-4)},
    "reference": lambda s: {"R_d0": stretched(s * 1e-3)},
}
RODS: dict[str, Callable[[float], dict[str, Any]]] = {
    "length of a rod's axis": lambda s: {"rod_axes": np.diag([1.0, 1.0, 1.0 + s * 1e-6]) @ TURN},
    "length of a rod's axis, short": lambda s: {"rod_axes": np.diag([1.0, 1.0, 1.0 - s * 1e-6]) @ TURN},
    "volume of the rods' axes": rods_volume,
    "demand over limit": lambda s: {"tau_cmd_B": [s * 1e6 * 3e-3, 0.0, 0.0], "b_B": [3e-5, 0.0, 0.0]},
}
REFUSED: dict[str, dict[str, Callable[[float], dict[str, Any]]]] = {
    "controller": {
        **ORBIT,
        "position, for gravity": lambda s: {"r_N": [s, 0.0, 0.0], "reference": "inertial", "compensate_gravity": True},
        "order of the gains, first": lambda s: {"K0": [0.5 * s, 0.5, 0.7]},
        "order of the gains, last": lambda s: {"K0": [0.4, 0.7 * s, 0.7]},
        "symmetry of a gain": lambda s: {"L0": np.eye(3) + s * 1e-9 * np.eye(3, k=1)},
        "definiteness of a gain": lambda s: {"L0": [[1.0, 0.0, 0.0], [0.0, 1.0, s], [0.0, s, 1.0]]},
        "inertia of a body": lambda s: {"J_B": np.diag([1.0, 1.0, 2.0 * (1.0 + s * 1e-9)])},
    },
    "plant_judge": {**ORBIT, "given reference": lambda s: {"R_d": stretched(s * 1e-4), "Omega_d": [0.0, 0.0, 0.0]}},
    "allocator": {name: RODS[name] for name in RODS if name != "demand over limit"},
    "allocator_bounded": {
        **{name: RODS[name] for name in RODS if name != "demand over limit"},
        "weight of the rods": lambda s: {"rod_weight": s * 1e-8},
    },
    "plant_sensors": {"sample period": lambda s: {"sensor_period": s * 1e-6}},
}
"""By block: what is refused on one side; the threshold is at s = 1."""
SEEN: dict[str, dict[str, tuple[str, Callable[[float], dict[str, Any]]]]] = {
    "allocator": {
        "field": ("holding", lambda s: {"b_B": s * 1e-12 * np.array([0.6, 0.0, 0.8]), "tau_cmd_B": [0.0, 0.0, 0.0]}),
        "field along the wheel": ("holding", lambda s: {"b_B": [s * 3e-14, 3e-5, 0.0], "tau_cmd_B": [0.0, 1e-14, 0.0]}),
        "plane of the rods": ("holding", flat_rods),
        "hold": ("holding", held),
        "wheel momentum": (
            "tau_residual_B",
            lambda s: {"h_w": s * 0.03, "tau_cmd_B": [-1e-4, 0.0, 0.0], "b_B": [3e-5, 0.0, 0.0]},
        ),
        "demand over limit": ("demand_fraction", RODS["demand over limit"]),
    },
    "allocator_bounded": {
        "field": ("dipole_cmd", lambda s: {"b_B": s * 1e-12 * np.array([0.6, 0.0, 0.8]), "dipole_ff": [1.0, 2.0, 3.0]}),
        "demand over limit": ("demand_fraction", RODS["demand over limit"]),
        "wheel momentum": (
            "wheel_torque_cmd",
            lambda s: {"h_w": s * 0.03, "tau_cmd_B": [-1e-4, 0.0, 0.0], "b_B": [3e-5, 0.0, 0.0]},
        ),
    },
}
"""By block: an output that is another on the other side."""
NEAR = {"plane of the rods": 1e-2, "hold": 1e-9, "order of the gains, first": 1e-12, "order of the gains, last": 1e-12}
"""How near to its threshold a case is sampled, where not 1e-3: det A^T A has 4 digits left there."""


def _outcome(block: str, changes: dict[str, Any]) -> dict[str, Any] | None:
    """The outputs of both flavours, which must agree; None where both refuse."""
    python = module(block)
    names = {f.name for f in fields(python.Parameters)}
    p = parameters(block, **{k: v for k, v in changes.items() if k in names})
    u = inputs(block, **{k: v for k, v in changes.items() if k not in names})
    try:
        python.check(p)
        x = python.start(p, u)
        x, expected = python.step(x, u, p, 0.1)
    except ValueError:
        expected = None
    with Instance(block) as it:
        try:
            it.set_all(p)
            it.set_all(u)
            it.initialize()
            it.step(0.0, 0.1)
        except Refused:
            assert expected is None, "the native flavour refuses what the Python flavour takes"
            return None
        assert expected is not None, "the Python flavour refuses what the native flavour takes"
        found = it.outputs()
    assert_same(found, expected, block)
    return found


def _sides(block: str, name: str, changes: Callable[[float], dict[str, Any]]) -> tuple[Any, Any]:
    near = NEAR.get(name, 1e-3)
    return _outcome(block, changes(1.0 - near)), _outcome(block, changes(1.0 + near))


@pytest.mark.parametrize(("block", "name"), [(block, name) for block in REFUSED for name in REFUSED[block]])
def test_both_flavours_refuse_from_the_same_threshold_on(block: str, name: str) -> None:
    below, above = _sides(block, name, REFUSED[block][name])
    assert (below is None) != (above is None)


@pytest.mark.parametrize(("block", "name"), [(block, name) for block in SEEN for name in SEEN[block]])
def test_both_flavours_decide_otherwise_from_the_same_threshold_on(block: str, name: str) -> None:
    output, changes = SEEN[block][name]
    below, above = (np.asarray(y[output], float) for y in _sides(block, name, changes))
    assert np.abs(below - above).max() > 0.5e-3 * np.abs(below).max(), "the threshold lies between the two"
