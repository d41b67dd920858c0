"""What a run has recorded, and what both loops, in Python and in C, do alike."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from .block import Block, Floats
from .bus import Seat
from .errors import BlockError
from .model import Element
from .wiring import Node

Progress = Callable[[float], None]
"""Called now and then with the simulated time."""

REPORT_EVERY = 0.05
"""Seconds of wall time from one report of the progress to the next, at least."""


@dataclass
class Recording:
    """What was recorded, up to the end or to whatever ended the run."""

    time: Floats
    values: Floats
    """A row for each sample, a column for each recorded element."""
    columns: list[Node]
    steps: int = 0
    wall: float = 0.0
    """Seconds that the loop took."""
    failure: BlockError | None = None
    interrupted: bool = False


def check_finite(seat: Seat, time: float | None = None) -> None:
    """Raises BlockError where an output is not finite. (A finite one whose square overflows comes here, too.)"""
    for element, value in zip(seat.outputs, seat.view, strict=True):
        if not math.isfinite(value):
            raise not_finite(seat.block, element, value, time)


def not_finite(block: Block, element: Element, value: float, time: float | None = None) -> BlockError:
    """The error of an output that is not finite."""
    name = block.model.variables[element.variable].label(element.position)
    return BlockError(block.name, f"output {name}", f"is {value}, expected a finite number", time, block.log)
