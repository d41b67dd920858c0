"""Plant, planned controller and allocator of a set of wheels in a loop, sample by sample."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from tests.blocks import PYRAMID
from tests.native.driver import Instance, running
from tests.plant.motion import FULL_INERTIA

H = 0.5
"""Sample, s."""
THREE = np.vstack((np.eye(3), [1.0, 0.0, 0.0]))
FOUR: dict[str, Any] = {"J_B": FULL_INERTIA, "wheels": 4, "wheel_axis": PYRAMID}
SETS: dict[int, dict[str, Any]] = {3: {**FOUR, "wheels": 3, "wheel_axis": THREE}, 4: FOUR}
TORQUE, MOMENTUM = 3e-3, 0.03
STILL: dict[str, Any] = {"gravity_gradient": False, "drag": False, "initial_attitude": "q_NB0", "omega_B0": [0.0] * 3}
MEASURED = ("R_NB", "omega_B", "r_N", "v_N", "b_B", "h_w")


def reach(axes: np.ndarray, limits: np.ndarray, along: np.ndarray, base: Any = 0.0) -> float:
    """The largest factor with which `along` beside `base` is a sum of wheels within their limits, by SciPy's linear
    programming."""
    n = len(axes)
    found = linprog(
        [*[0.0] * n, -1.0],
        A_eq=np.column_stack((axes.T, -along)),
        b_eq=np.zeros(3) + base,
        bounds=[*[(-limit, limit) for limit in limits], (None, None)],
    )
    assert found.success
    return -found.fun


def fly(
    duration: float,
    each: Callable[[int, dict[str, Any], dict[str, Any], Instance], None],
    body: dict[str, Any],
    plant: dict[str, Any],
    law: dict[str, Any],
    target: Callable[[int], Any] | None = None,
    failed: Callable[[int], Any] | None = None,
    rods: bool = False,
    told: Callable[[int, Any], Any] | None = None,
) -> None:
    """Calls `each` at every sample with its number, the plant's outputs, those of the controller, and the plant.

    `target`: the attitude at rest that is wanted at a sample, in the place of the parameters'; `failed`: the wheels
    that are said to have failed, in the place of what the allocator finds; `rods`: commands and gains of the rods are
    connected; `told`: what the telemetry makes of the wheels' momenta.
    """
    with (
        running("plant_wheels", **body, **plant) as it,
        Instance("controller_planned_wheels") as controller,
        Instance("allocator_bounded_wheels") as allocator,
    ):
        for name, value in {**body, **law}.items():
            controller.set(name, value)
        for name in ("wheels", "wheel_axis"):
            allocator.set(name, body[name])
        for i in range(int(duration / H)):
            seen = {name: it.get(name) for name in MEASURED}
            seen["h_w"] = seen["h_w"] if told is None else told(i, seen["h_w"])
            if failed is not None:
                controller.set("wheel_failed", failed(i))
            elif i > 0:
                controller.set("wheel_failed", allocator.get("wheel_failed"))
            for name, value in seen.items():
                controller.set(name, value)
            if rods:
                controller.set("dipole_applied", it.get("dipole_cmd"))
            if target is not None:
                for name, value in (("R_ref", target(i)), ("Omega_ref", np.zeros(3)), ("dOmega_ref", np.zeros(3))):
                    controller.set(name, value)
            controller.initialize() if i == 0 else controller.step((i - 1) * H, H)
            y = controller.outputs()
            for name in ("tau_cmd_B", "dipole_ff", "wheel_torque_ff"):
                allocator.set(name, y[name])
            for name in ("omega_B", "b_B", "h_w"):
                allocator.set(name, seen[name])
            if rods:
                allocator.set("rod_gains", y["rod_gains_estimate"])
            allocator.initialize() if i == 0 else allocator.step((i - 1) * H, H)
            each(i, seen, y, it)
            for name in ("wheel_torque_cmd", "dipole_cmd"):
                it.set(name, allocator.get(name))
            it.step(i * H, H)


def least_time(angle: float, axis: np.ndarray, body: dict[str, Any]) -> float:
    """Of a turn from rest to rest about the axis within the wheels' torques and momenta, s; angle in rad."""
    axes, along = body["wheel_axis"][: body["wheels"]], FULL_INERTIA @ axis
    a = reach(axes, np.full(len(axes), TORQUE), along)
    rate = reach(axes, np.full(len(axes), MOMENTUM), along)
    return 2.0 * np.sqrt(angle / a) if angle < rate**2 / a else angle / rate + rate / a


def slewed(wheels: int, degrees: float, axis: np.ndarray) -> tuple[float, float]:
    """Least time of the slew, and the time from which on the error stays below 0.1 deg, s."""
    body, angle, settled = SETS[wheels], np.radians(degrees), 0.0
    least = least_time(angle, axis, body)

    def each(i: int, seen: Any, y: dict[str, Any], it: Instance) -> None:
        nonlocal settled
        if Rotation.from_matrix(seen["R_NB"]).magnitude() > np.radians(0.1):
            settled = (i + 1) * H

    q = np.roll(Rotation.from_rotvec(angle * axis).as_quat(), 1)
    fly(2.0 * least + 60.0, each, body, {**STILL, "q_NB0": q}, {"reference": "inertial"})
    return least, settled
