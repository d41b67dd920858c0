"""The usual law of a set of wheels, which docs/evidence/wheels.md has beside the planned one.

Tests: tests/evidence/wheels/test_wheels.py.
"""

from __future__ import annotations

from ..flight.schemes import Data, fit


def by_usual_law(data: Data) -> Data:
    """The same with `controller_wheels`, which commands rods and wheels itself; in place."""
    del data["blocks"]["allocator"]
    data["connections"] = [c for c in data["connections"] if "allocator." not in c and "controller." not in c]
    data["connections"] += [
        *(f"sensors.{name}_measured -> controller.{name}" for name in ("R_NB", "omega_B", "r_N", "v_N", "b_B")),
        "plant.h_w -> controller.h_w",
        *(f"controller.{name} -> plant.{name}" for name in ("dipole_cmd", "wheel_torque_cmd")),
    ]
    return fit(data, "controller", "controller_wheels")
