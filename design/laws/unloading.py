"""The usual law of wheels and rods: quaternion feedback, and wheels that are to be empty within a time (bandwidth.py).

The allocator gives the torque by wheel and rods; what the wheel gives up is taken by the rods, where the field allows
it (docs/how/allocator.md).
"""

from typing import Any

from design.laws import bandwidth, pd


def step(inputs: Any, parameters: Any, t: float, h: float) -> dict[str, Any]:
    unload = -inputs.h_w / bandwidth.emptied_in(parameters)
    return pd.step(inputs, parameters, t, h) | {"wheel_torque_ff": unload}
