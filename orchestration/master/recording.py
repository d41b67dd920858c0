"""What a run has recorded, and what both loops, in Python and in C, do alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import BlockError
from ..fmu.model import Element, Floats
from ..instances.block import Block
from ..system.clock import Clock
from ..system.wiring import Node
from .bus import Seat

Progress = Callable[[float], None]
"""Called now and then with the simulated time."""

REPORT_EVERY = 0.05
"""Seconds of wall time from one report of the progress to the next, at least."""
_ROWS = 4096
"""How many base steps a watch keeps at a time."""


@dataclass
class Recording:
    """What was recorded, up to the end or to whatever ended the run."""

    time: Floats
    values: Floats
    """A row for each sample, a column for each recorded element."""
    columns: list[Node]
    steps: int = 0
    extra: bool = False
    """Whether the last sample is the run's end, between two whole intervals."""
    wall: float = 0.0
    """Seconds that the loop took."""
    failure: BlockError | None = None
    interrupted: int = 0
    """The number of the signal that ended it, such as that of Ctrl-C; 0 for none."""


class Watch:
    """Hands on the values of some elements after every base step, where only some of the steps are recorded."""

    def __init__(
        self, columns: Sequence[Node], clock: Clock, see: Callable[[Floats, Floats], None], soon: int = _ROWS
    ) -> None:
        """`see` is given times (n,) and values (n, columns), piece by piece: first after `soon` base steps, then after
        twice as many each time. What it raises ends the run.
        """
        self.columns, self._clock, self._see, self._soon = list(columns), clock, see, soon
        self.rows = np.empty((min(_ROWS, clock.steps + 1), len(self.columns)))
        self.first = 0
        """The base step of the first row."""

    @property
    def last(self) -> int:
        """The base step of the last row."""
        return self.first + min(self._soon, len(self.rows)) - 1

    def row(self, count: int) -> Floats:
        """Where the values after base step `count` belong; it follows those before it."""
        if count > self.last:
            self.flush(count - 1)
        return self.rows[count - self.first]

    def flush(self, count: int) -> None:
        """Hands on what there is up to base step `count`."""
        n = count + 1 - self.first
        if n > 0:
            self._see(self._clock.times(self.first, n), self.rows[:n])
            self.first += n
            self._soon *= 2


def check_finite(seat: Seat, time: float | None = None) -> None:
    """Raises BlockError where an output is not finite. (A finite one whose square overflows comes here, too.)"""
    for element, value in zip(seat.outputs, seat.view, strict=True):
        if not math.isfinite(value):
            raise not_finite(seat.block, element, value, time)


def not_finite(block: Block, element: Element, value: float, time: float | None = None) -> BlockError:
    """The error of an output that is not finite."""
    name = block.model.variables[element.variable].label(element.position)
    return BlockError(block.name, f"output {name}", f"is {value}, expected a finite number", time, block.log)
