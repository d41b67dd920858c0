"""When an output of one flavour is that of the other."""

from __future__ import annotations

from typing import Any

import numpy as np

RELATIVE = 1e-9


def assert_same(native: dict[str, Any], reference: Any, block: str, relative: float = RELATIVE) -> None:
    """Every port of `native` is that of `reference`, to `relative` of the port's size (of the vector's norm)."""
    for name, value in native.items():
        expected = np.asarray(getattr(reference, name), dtype=float)
        difference = np.abs(np.asarray(value, dtype=float) - expected).max()
        size = float(np.linalg.norm(expected))
        assert difference <= relative * size + _FLOOR.get(name, 0.0), f"{block}.{name}: {value} instead of {expected}"


_FLOOR = {
    "ambiguity": 1e-12,  # of filters that have met
    "attitude_error": 1e-15,  # rounding of Q, where the angle is next to 0
    "lyapunov": 1e-15,  # 1 - Q_ii
    "omega_B": 1e-15,  # a difference of measured rate and bias
    "tau_cmd_B": 1e-16,
    "rate_error_B": 1e-16,
    "tau_residual_B": 1e-16,  # a difference of equals: rounding of the demand and of the wheel's part
    "wheel_torque_cmd": 1e-18,
    "wheel_torque": 1e-18,
    "h_w": 1e-17,  # next to standstill
    "wheel_speed": 1e-12,
    "tau_gg_B": 1e-21,  # J r_hat next to r_hat
    "Omega_ref": 1e-16,  # a difference of rates next to each other
    "dOmega_ref": 1e-18,
}
"""Absolute parts, SI, where an output is a difference of nearly equal numbers."""
