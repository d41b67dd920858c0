"""The least time of a tumble with a set of wheels by the balance of momentum (design/momentum.py), s.
Tests: tests/evidence/wheels/test_wheels.py."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

import controller
import plant
from design.loop import parameters
from design.momentum import MomentumBalance, Tolerance
from fmus.interface import load

from ..flight.schemes import Data
from .cases import CONDITIONS, RATE, Flights, scenario

HORIZON = 6000.0
"""s"""


def least_time(shared: Mapping[str, Any], start: Mapping[str, Any]) -> float | None:
    """From the start values of a plant_wheels, those of `shared` beside them, to 5 deg and RATE; None beyond
    HORIZON."""
    given: dict[tuple[str, int], Any] = {}
    for name, value in {**shared, **start}.items():
        v = load("plant_wheels").variables.get(name)
        if isinstance(value, Mapping):
            value = np.diag(value["diagonal"])
        elif v is not None and v.type == "enumeration":
            value = v.items.index(value) + 1
        given |= {(name, i): one for i, one in enumerate(np.ravel(value).tolist())}
    p = parameters("plant_wheels", given, plant)
    law = parameters("controller", {}, controller)
    return MomentumBalance(p, law, None, Tolerance(math.radians(5.0), RATE), HORIZON).least_time(1.0).least


def of_draws(flights: Flights, runs: int) -> list[float | None]:
    """Of the first runs of a campaign."""
    data: Data = scenario(flights, CONDITIONS[flights.condition])
    found = []
    for values in flights.drawn(runs):
        start = {name.removeprefix("plant."): value for name, value in values.items() if name.startswith("plant.")}
        found.append(least_time({**data["shared"], "drag": True}, start))
    return found
