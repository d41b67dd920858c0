"""How the blocks of a run are connected and when each is stepped. Tests: tests/orchestration/master/test_master.py."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..system.clock import Clock
from ..system.faults import Faults
from ..system.order import Order
from ..system.wiring import Wiring


@dataclass(frozen=True)
class Circuit:
    """The connections, the order and the clock of a run, and the faults that act in it."""

    wiring: Wiring
    order: Order
    clock: Clock
    every: Mapping[str, int] = field(default_factory=dict)
    """In how many base steps a block is stepped once, by its name; 1 by default."""
    parallel: bool = False
    faults: Faults = field(default_factory=Faults)

    def rate(self, block: str) -> int:
        """Returns in how many base steps the block is stepped once."""
        return self.every.get(block, 1)
