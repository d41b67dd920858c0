"""The usual law of wheels and rods: quaternion feedback, and a wheel that is to be empty within `emptied_in`.

The allocator gives the torque by wheel and rods; what the wheel gives up is taken by the rods, where the field allows
it (docs/how/allocator.md).
"""

from typing import Any

from design.laws import pd

PARAMETERS = {"emptied_in": 600.0}  # s


def step(inputs: Any, parameters: Any, t: float, h: float) -> dict[str, Any]:
    return pd.step(inputs, parameters, t, h) | {"wheel_torque_ff": -inputs.h_w / parameters.emptied_in}
