"""What a run has recorded, and what both loops, in Python and in C, do alike."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import BlockError
from ..fmu.model import Element, Floats
from ..instances.block import Block
from ..interrupt import Stopped
from ..system.clock import Clock
from ..system.observer import Observer
from ..system.wiring import Node
from .bus import Seat

ROWS = 4096
"""Base steps of which an observation keeps the values at a time."""


@dataclass
class Recording:
    """Record up to the end, or to whatever ended the run."""

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
    closing: BlockError | None = None
    """What went wrong when its blocks were ended."""

    def whole(self) -> Recording:
        """Returns itself; raises Stopped where a signal ended the run, for whom a part of it is of no use."""
        if self.interrupted:
            raise Stopped(self.interrupted)
        return self


class Observation:
    """Shows observers the values of some elements after every base step."""

    def __init__(self, nodes: Sequence[Node], clock: Clock, observers: Sequence[Observer], soon: int = ROWS) -> None:
        """The observers see them piece by piece: first after `soon` base steps, then after twice as many each time."""
        self._nodes, self._clock, self._observers, self._soon = nodes, clock, observers, soon
        self.rows = np.empty((min(ROWS, clock.steps + 1), len(nodes)))
        self.first = 0
        """The base step of the first row."""

    def room(self, count: int) -> int:
        """Returns the base step of the last row; what there is up to base step `count` is shown first where it is the
        last."""
        if count == self._last:
            self.flush(count)
        return self._last

    @property
    def _last(self) -> int:
        return self.first + min(self._soon, len(self.rows)) - 1

    def flush(self, count: int) -> None:
        """Shows what there is up to base step `count`."""
        n = count + 1 - self.first
        if n > 0:
            time = self._clock.times(self.first, n)
            columns = {node: self.rows[:n, i] for i, node in enumerate(self._nodes)}
            for observer in self._observers:
                observer.see(time, columns)
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
