"""What the C of a block refuses, its Python refuses too."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fmus.interface import load
from tests.blocks import inputs, module, parameters

from .drawn import CASES
from .driver import Instance, Refused


@pytest.mark.parametrize("block", [case for case in CASES if "," not in case])
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
            {"R_ref": np.diag([1.0, 1.0, -1.0]), "Omega_ref": [0.0, 0.0, 0.0], "dOmega_ref": [0.0, 0.0, 0.0]},
            {"Omega_ref": [1e9, 1e9, 1e9], "R_ref": np.eye(3), "dOmega_ref": [0.0, 0.0, 0.0]},
            {"dOmega_ref": [1e9, 1e9, 1e9], "R_ref": np.eye(3), "Omega_ref": [0.0, 0.0, 0.0]},
            {"R_ref": np.full((3, 3), 1e9), "Omega_ref": [0.0, 0.0, 0.0], "dOmega_ref": [0.0, 0.0, 0.0]},
            {"R_ref": np.full((3, 3), 1e-12), "Omega_ref": [0.0, 0.0, 0.0], "dOmega_ref": [0.0, 0.0, 0.0]},
        ],
        "allocator": [
            {"rod_axes": np.eye(3) * 1.0 - 1e-4 * np.eye(3)},
            {"rod_axes": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]},
        ],
        "allocator_bounded": [
            {"rod_axes": np.eye(3) * 1.0 - 1e-4 * np.eye(3)},
            {"rod_axes": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]},
        ],
        "allocator_bounded_wheels": [
            {"rod_axes": np.eye(3) * 1.0 - 1e-4 * np.eye(3)},
            {"rod_axes": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]},
            {"wheel_weight": 1e-5, "wheels": 2},
            {"wheel_momentum_target": [0.04, 0.0, 0.0, 0.0]},
            {"null_space_momentum": 0.02},
        ],
        "estimator": [
            {"J_B": np.diag([1.0, 1.0, 2.1])},
            {"J_B": np.diag([1.0, 1.0, -1.0])},
            {"J_B": [[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]]},
            {"rod_axes": np.eye(3) * 1.0 - 1e-4 * np.eye(3)},
            {"boresight_B": [0.0, 0.6, 0.9]},
            {"epoch": "1999-12-31T00:00:00Z"},
            {"epoch": "2012-01-01", "field_model": "wmm2015"},
            {"R_NB_measured": np.diag([1.0, 1.0, -1.0])},
            {"R_NB_measured": np.diag([1.0, 1.0, 1.001])},
            {"b_B_measured": [0.3, 0.1, 0.2]},
            {"r_N_measured": [6971.0, 0.0, 0.0]},
        ],
        "plant": [{"rod_period": 5e-4}],
        "plant_wheels": [{"rod_period": 5e-4}],
        "supervisor": [
            {"J_B": np.diag([1.0, 1.0, 2.1])},
            {"rate_lost": 1e-3},
            {"sun_axis_B": [1.0, 1.0, 0.0]},
            {"safe_axis_B": [1.0, 1.0, 0.0]},
            {"b_B": [1e9, 1e9, 1e9], "safe_pointing": "field"},
            {"sun_B": [1e9, 1e9, 1e9], "safe_pointing": "sun"},
            {"target_latitude": 1.6},
            {"target_longitude": -6.3},
            {"target_height": 2e6},
            {"epoch": "1899-12-31T00:00:00Z"},
            {"epoch": "tomorrow"},
            {"command": 5},
            {"R_NB": np.diag([1.0, 1.0, 1.001])},
            {"R_goal": np.diag([1.0, 1.0, -1.0]), "command": 4},
            {"R_goal": np.full((3, 3), 1e9), "command": 4},
            {"target_latitude": 1e9, "command": 6},
            {"sun_N": [1e9, 1e9, 1e9], "command": 7},
            {"sun_N": [0.0, 0.0, 0.0], "command": 7, "rate_time": 0.0},
            {"v_N": [1.0, 0.0, 0.0], "rate_time": 0.0},
        ],
        "plant_sensors": [{"sensor_period": 5e-7}],
        "plant_sensors_wheels": [{"sensor_period": 5e-7}],
        "estimator_wheels": [
            {"wheel_axis": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.6, 0.9], [0.0, 0.0, 1.0]], "wheels": 3},
        ],
        "plant_judge": [
            {"R_d0": np.diag([1.0, 1.0, -1.0])},
            {"R_NB": np.full((3, 3), 1e-12)},
            {"R_NB": np.diag([1.0, 1.0, 1.001])},
            {"R_d": np.diag([1.0, 1.0, -1.0]), "Omega_d": [0.0, 0.0, 0.0]},
            {"v_N": [1.0, 0.0, 0.0]},
        ],
    }
    python = module(block)
    names = {v.name for v in load(block).of("parameter")}
    for changes in wrong[block]:
        p = parameters(block, **{k: v for k, v in changes.items() if k in names})
        u = inputs(block, **{k: v for k, v in changes.items() if k not in names})
        with pytest.raises(ValueError, match="expect"):
            _python_initialized(python, p, u)
        with Instance(block) as native:
            native.set_all(p)
            native.set_all(u)
            with pytest.raises(Refused, match=f"^3: .*{next(iter(changes))}.*expected .*found"):
                native.initialize()


def _python_initialized(python: Any, p: Any, u: Any) -> Any:
    python.check(p)
    return python.outputs(python.start(p, u), u, p)
