"""Drawn tumbles of a satellite, as what is searched needs them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import plant

from ..flight.bound import bound, loop, starts
from ..flight.cases import Group
from ..flight.schemes import Data
from .problem import ONE_WHEEL, Grid


@dataclass(frozen=True)
class Tumbles:
    """A scenario and its runs."""

    scenario: Data
    starts: list[Data]
    """Of each run by `block.parameter`."""
    duration: float
    """s"""
    plant_of: Callable[[int], plant.Parameters]
    bound_of: Callable[[int], float | None]
    """The least time by the balance of momentum, s."""
    grid: Grid = ONE_WHEEL
    sample: float = 1.0
    """s between the samples of the flown motion."""
    held: bool = True
    """Whether a motion counts only where the controller holds from its end on."""


def of_group(group: Group) -> Tumbles:
    """The runs of a group of evidence/flight."""
    given = starts(group)
    return Tumbles(
        group.scenario,
        group.drawn(),
        group.duration,
        lambda run: loop(given[run]).plant,
        lambda run: bound(given[run]),
    )
