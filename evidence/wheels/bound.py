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


def of_plant(shared: Mapping[str, Any], start: Mapping[str, Any]) -> plant.Parameters:
    """The parameters of start values of a plant_wheels, those of `shared` beside them."""
    given: dict[tuple[str, int], Any] = {}
    for name, value in {**shared, **start}.items():
        v = load("plant_wheels").variables.get(name)
        if isinstance(value, Mapping):
            value = np.diag(value["diagonal"])
        elif v is not None and v.type == "enumeration":
            value = v.items.index(value) + 1
        given |= {(name, i): one for i, one in enumerate(np.ravel(value).tolist())}
    found: plant.Parameters = parameters("plant_wheels", given, plant)
    return found


def least_time(p: plant.Parameters) -> float | None:
    """To 5 deg and RATE, s; None beyond HORIZON."""
    law = parameters("controller", {}, controller)
    return MomentumBalance(p, law, None, Tolerance(math.radians(5.0), RATE), HORIZON).least_time(1.0).least


def plants(flights: Flights, runs: int) -> list[plant.Parameters]:
    """Returns the plants of the first runs of a campaign."""
    data: Data = scenario(flights, CONDITIONS[flights.condition])
    shared = {**data["shared"], "rod_gain": data["blocks"]["plant"]["start"]["rod_gain"], "drag": True}
    found = []
    for values in flights.drawn(runs):
        start = {name.removeprefix("plant."): value for name, value in values.items() if name.startswith("plant.")}
        found.append(of_plant(shared, start))
    return found


def of_draws(flights: Flights, runs: int) -> list[float | None]:
    """Least times of the first runs of a campaign."""
    return [least_time(p) for p in plants(flights, runs)]
