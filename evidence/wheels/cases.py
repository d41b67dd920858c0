"""The satellites of docs/evidence/wheels.md and their flights as campaigns: nothing is tuned for them.

Tests: tests/evidence/wheels/test_wheels.py.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from orchestration.campaign.case import Case

from .. import crew
from ..flight.cases import DRAWN, drawn
from ..flight.schemes import NO_ERRORS, Data, base, change, fit, without
from ..paper import ROOT
from ..satellites.classes import ACROSS, CLASSES, FIELD, SHARES, Satellite
from .usual import by_usual_law

ELEVATION = math.radians(35.0)
"""Of the pyramid's wheels above the body's x-y plane."""
THREE = np.eye(3)
PYRAMID = np.array(
    [
        [math.cos(ELEVATION) * math.cos(a), math.cos(ELEVATION) * math.sin(a), math.sin(ELEVATION)]
        for a in np.radians([45.0, 135.0, 225.0, 315.0])
    ]
)
WHEELS = {"3U": THREE, "12U": PYRAMID, "50 kg": PYRAMID}
"""The wheels' axes (n, 3) of each satellite, the rest of which is that of docs/evidence/satellites.md."""
DURATION, ORBIT = 18000.0, 6000.0
"""s: three orbits or more, at 400 to 800 km; the hold is that of the last."""
RATE, SEED = 1e-3, 49
"""rad/s, below which a settled satellite stays; seed of the draws."""


@dataclass(frozen=True)
class Flights:
    """Flights of a satellite."""

    satellite: str
    condition: str

    @property
    def it(self) -> Satellite:
        return CLASSES[self.satellite]

    @property
    def name(self) -> str:
        return f"{self.satellite}, {self.condition}"

    @property
    def wheels(self) -> int:
        return len(WHEELS[self.satellite])

    def case(self, runs: int) -> Case:
        """The campaign, checked. Raises InputError."""
        how = CONDITIONS[self.condition]
        data = scenario(self, how)
        draw = {
            **DRAWN,
            "radius": {"uniform": ["6771 km", "7171 km"]},
            "tilt": {"uniform": ["0 deg", "98 deg"]},
            **{f"{name}{i}": {"uniform": [-1.0, 1.0]} for name in ("drive", "drag") for i in range(4)},
            "wheel": {"integers": [0, self.wheels - 1]},
        }
        campaign = {
            "name": re.sub(r"\W+", "_", f"{self.satellite} {self.condition}"),
            "scenario": {**data, "duration": DURATION},
            "draw": draw,
            "vary": {name: {"expression": text} for name, text in vary(self, how).items()},
            "sampling": "random",
            "runs": min(runs, how.most),
            "seed": SEED,
            "metrics": metrics(0 if how.usual else 4),
        }
        return crew.case(campaign, ROOT / "evidence" / "wheels")

    def drawn(self, runs: int) -> list[Data]:
        """Start values of each run by `block.parameter`."""
        return drawn(self.case(runs), min(runs, CONDITIONS[self.condition].most))


@dataclass(frozen=True)
class Condition:
    """Errors in the flights of a kind."""

    text: str
    errors: bool = False
    estimated: bool = False
    usual: bool = False
    """`controller_wheels` with its start values, in the places of controller and allocator."""
    vary: Data = field(default_factory=dict, hash=False)
    lost: int = 0
    """Wheels that fail: the drawn one, and those after it."""
    most: int = 1000
    """Flights at most."""


def _of_drawn(bad: float, good: float = 0.0) -> str:
    """A value for each wheel, another one for that which is drawn."""
    return f"[{', '.join(f'{good} + {bad - good} * max(0, 1 - abs(wheel - {i}))' for i in range(4))}]"


def _dead(*after: int) -> str:
    """Gains of the wheels, of which the drawn one and those so many places after it are dead."""

    def gain(i: int, n: int) -> str:
        lost = [f"max(0, 1 - abs(wheel - {(i - k) % n}))" for k in after]
        return " * ".join(f"(1 - {one})" for one in lost)

    return f"[{', '.join(gain(i, 4) for i in range(4))}]"


CONDITIONS = {
    "nominal": Condition("perfect sensors and actuators"),
    "errors": Condition("all errors", errors=True),
    "estimated": Condition("all errors, attitude estimated with the star tracker", errors=True, estimated=True),
    "usual law": Condition("perfect, quaternion feedback and cross product", usual=True),
    "usual law, errors": Condition("all errors, quaternion feedback and cross product", errors=True, usual=True),
    "one dead": Condition("a wheel dead", vary={"plant.wheel_gain": _dead(0)}, lost=1, most=50),
    "one weak": Condition("a wheel that gives 0.3", vary={"plant.wheel_gain": _of_drawn(0.3, 1.0)}, lost=1, most=20),
    "one reversed": Condition("a wheel reversed", vary={"plant.wheel_gain": _of_drawn(-1.0, 1.0)}, lost=1, most=20),
    "one stuck": Condition(
        "a wheel stuck at half its momentum",
        vary={"plant.wheel_gain": _dead(0), "plant.h_w0": f"HALF * {_of_drawn(1.0)}"},
        lost=1,
        most=20,
    ),
    "one drags": Condition(
        "a wheel with friction of 0.3 of its torque",
        vary={"plant.wheel_coulomb_friction": f"DRAG * {_of_drawn(1.0)}"},
        lost=1,
        most=20,
    ),
    "two dead": Condition("two wheels dead", vary={"plant.wheel_gain": _dead(0, 1)}, lost=2, most=20),
    "all dead": Condition("all wheels dead", vary={"plant.wheel_gain": "[0, 0, 0, 0]"}, lost=3, most=20),
}
"""Errors are those of docs/evidence/satellites.md; gains of the wheels' drives 5% off, friction of 0 to 2% of the
torque. Dead, weak or reversed wheels are so from the start."""


def of_four(values: Any) -> list[Any]:
    """A value for each of the four wheels that the blocks have."""
    return np.broadcast_to(values, 4).tolist()


def with_set(data: Data, satellite: str) -> Data:
    """A scenario of one wheel with a satellite and its set of wheels in place; in place."""
    it, axes = CLASSES[satellite], WHEELS[satellite]
    for key in ("consistency", "live", "cycle", "delays"):
        data.pop(key, None)
    without(data, "estimator.dipole", "estimator.wheel_torque", "estimator.h_w", "sensors.h_w", "allocator.h_w")
    without(data, "controller.h_w", "controller.u_applied", "allocator.rod_gains")
    fit(data, "plant", "plant_wheels", 1)
    fit(data, "controller", "controller_planned_wheels")
    fit(data, "allocator", "allocator_bounded_wheels")
    data["connections"] += ["plant.h_w -> controller.h_w", "plant.h_w -> allocator.h_w"]
    data["connections"] += [f"allocator.{flag} -> controller.{flag}" for flag in ("wheel_failed", "h_w_failed")]
    data["connections"] += ["allocator.dipole_cmd -> controller.dipole_applied"]
    data["connections"] += ["controller.rod_gains_estimate -> allocator.rod_gains"]
    data["blocks"]["plant"]["start"].pop("h_w0", None)
    data["shared"] |= {
        "J_B": {"diagonal": list(it.moments)},
        "dipole_max": it.dipole_max,
        "wheels": len(axes),
        "wheel_torque_max": of_four(it.wheel_torque_max),
        "wheel_momentum_max": of_four(it.wheel_momentum_max),
        "wheel_inertia": of_four(5e-4 * it.wheel_momentum_max),
        "wheel_axis": np.vstack((axes, np.eye(3)))[:4].tolist(),
        "rod_axes": it.rod_axes,
    }
    return change(data, {"plant.body_width": it.size[0], "plant.body_length": it.size[1], "plant.body_axis": it.axis})


def scenario(flights: Flights, how: Condition) -> Data:
    """The scenario of the campaign: that of flight_tumble or flight_star_tracker with a set of wheels."""
    data = with_set(base("star_tracker" if how.estimated else "tumble"), flights.satellite)
    change(data, {"sensors.h_w": 0.0})  # they measure one wheel only
    if how.estimated:
        data["blocks"]["estimator"]["differs"] = ["wheel_axis"]
        change(data, {"estimator.wheel_axis": [1.0, 0.0, 0.0]})  # of a filter without gyro: not used
        mean = 0.8 * flights.it.dipole_max
        change(data, {"controller.dipole_max": mean, "allocator.dipole_max": mean})
    elif not how.errors:
        change(data, {k: v for k, v in NO_ERRORS.items() if not k.startswith("controller.")})
    return by_usual_law(data) if how.usual else data


def vary(flights: Flights, how: Condition) -> Data:
    """Start values as expressions of what is drawn."""
    it = flights.it
    found = {
        "plant.Q0": "attitude",
        "plant.omega_B0": "omega",
        "plant.node_longitude": "node",
        "plant.orbit_radius": "radius",
        "plant.inclination": "tilt",
        "plant.disturbance_torque_B": f"{SHARES[how.errors] * it.dipole_max * FIELD} * push",
        "sensors.seed": "noise",
    }
    if how.errors:
        of_mass = [sum(it.moments) / 2.0 - moment for moment in it.moments]
        found["plant.J_error_B"] = f"diag({ACROSS} @ ({of_mass} * sqrt(2) * off * [side1, side2, side3]))"
        found["plant.wheel_gain"] = f"[{', '.join(f'1 + 0.05 * drive{i}' for i in range(4))}]"
        drag = ", ".join(f"1 + drag{i}" for i in range(4))
        found["plant.wheel_coulomb_friction"] = f"{0.01 * it.wheel_torque_max} * [{drag}]"
    sizes = {"HALF": 0.5 * it.wheel_momentum_max, "DRAG": 0.3 * it.wheel_torque_max}
    for name, text in how.vary.items():
        for size, value in sizes.items():
            text = text.replace(size, str(value))
        found[name] = text
    return found


def metrics(watched: int) -> list[Data]:
    """Returns what each flight is measured by, of the plant's truth, and when each of so many wheels is reported."""
    angle = {"signal": "judge.attitude_error"}
    rate = {"signal": "judge.rate_error_B", "measure": "norm"}
    last = {"after": DURATION - ORBIT}
    found: dict[str, Data] = {
        "angle_5": {**angle, "settles": {"below": "5 deg"}},
        "angle_1": {**angle, "settles": {"below": "1 deg"}},
        "rate": {**rate, "settles": {"below": f"{RATE} rad/s"}},
        "hold_rms": {**angle, "statistic": "rms", **last},
        "hold_max": {**angle, "statistic": "maximum", **last},
        "initial_rate": {**rate, "statistic": "maximum", "before": 0.0},
        "wheel_max": {"signal": "plant.h_w", "statistic": "peak", **last},
        "dipole": {"signal": "plant.dipole", "measure": "norm", "statistic": "rms", **last},
        **{f"found_{i}": _reported(i + 1) for i in range(watched)},
    }
    return [{"name": name, **metric} for name, metric in found.items()]


def _reported(wheel: int) -> Data:
    return {"signal": f"allocator.wheel_failed[{wheel}]", "reaches": {"equals": True}}


def all_flights() -> list[Flights]:
    """All that is flown, in this order; with two and all wheels dead only the set of three."""
    return [
        Flights(satellite, condition)
        for condition in CONDITIONS
        for satellite, axes in WHEELS.items()
        if condition not in ("two dead", "all dead") or len(axes) == 3
    ]
