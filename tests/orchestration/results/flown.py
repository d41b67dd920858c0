"""A body that turns on a circular orbit, to be shown in three dimensions."""

from __future__ import annotations

from typing import Any

import numpy as np

from orchestration.quantities import parse_unit
from orchestration.results.result import Result

from ..mocks import Mock, model, real
from ..mocks import run as run_mocks

RADIUS, RATE = 7e6, 1.078e-3
"""m, rad/s"""


def flown(steps: int = 200, rate: float = 0.5, **more: Any) -> Result:
    """100 s in which the body turns at a rate, deg/s, about the axis N z away from a desired attitude at
    rest."""

    def evaluate(block: Mock) -> None:
        t = block.state
        a = np.radians(rate * t)
        r = RADIUS * np.array([np.cos(RATE * t), 0.0, np.sin(RATE * t)])
        values = {
            "q": [np.cos(a / 2), 0.0, 0.0, np.sin(a / 2)],
            "R_d": np.eye(3).ravel(),
            "r": r,
            "sun": [1.0, 0.0, 0.0],
            "field": [np.cos(a), 1.0, np.sin(a)],
            "spin": [1.0 + t],
            "phase": [1 if t < 60 else 2],
        }
        for name, numbers in values.items():
            for element, value in zip(block.model.variables[name].elements, numbers, strict=True):
                block.values[element] = float(value)

    def advance(block: Mock, time: float, step: float) -> None:
        block.state = time + step

    signals = (
        real("q", "output", shape=(4,)),
        real("R_d", "output", shape=(3, 3)),
        real("r", "output", shape=(3,), unit=parse_unit("m")),
        real("sun", "output", shape=(3,)),
        real("field", "output", shape=(3,), unit=parse_unit("T")),
        real("spin", "output", unit=parse_unit("N.m.s")),
        real("phase", "output", type="integer"),
        real("u", "input", variability="tunable"),
        real("k", "parameter", variability="fixed"),
    )
    scenario: dict[str, Any] = {
        "step": 0.5,
        "duration": 0.5 * steps,
        "faults": [{"at": 70, "until": 80, "set": "a.u = 1"}],
        "figures": [{"name": "field", "panels": [{"signals": ["a.field"]}]}],
        "view": {
            "attitude": "a.q",
            "desired": "a.R_d",
            "position": "a.r",
            "sun": "a.sun",
            "phase": "a.phase",
            "phases": ["turning", "resting"],
            "axes": {"wheel": [[0, 0, 2]]},
            "vectors": [
                {"name": "field", "signal": "a.field", "shown": True},
                {"name": "momentum", "signal": "a.spin", "along": [[0, 0, 2]], "frame": "inertial"},
            ],
        },
        **more,
    }
    return run_mocks([Mock("a", model("a", *signals), evaluate, advance, 0.0)], scenario, start={"a": {"u": 0}})
