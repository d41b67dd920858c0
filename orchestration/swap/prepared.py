"""A scenario whose swapped blocks have been held against their interfaces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..fmu.model import Element, Model
from ..instances.block import Block
from ..scenario.expectations import Expectation
from ..scenario.references import Connection
from ..scenario.scenario import Scenario
from ..system.order import Hook
from ..system.starts import Start
from .adapter import Adapter
from .findings import Fit
from .named_values import handed_on


@dataclass
class Prepared:
    """A scenario with its swapped blocks understood."""

    scenario: Scenario
    """Without what refers to ignored outputs."""
    models: dict[str, Model]
    """What the master sees of each block."""
    fits: dict[str, Fit] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    not_evaluated: list[tuple[Expectation, str]] = field(default_factory=list)
    """Expectations taken out of the scenario, each with the reason."""
    connections: list[tuple[Connection, str]] = field(default_factory=list)
    """What the mappings connect to inputs that only theirs have, and where that stands."""
    feedthrough: Hook | None = None

    def adapted(self, block: Block) -> Block:
        """The block behind our interface; itself where there is nothing to adapt."""
        fit = self.fits.get(block.name)
        return block if fit is None or fit.identical else Adapter(block, fit)

    def handed_on(self, starts: Mapping[str, Sequence[Start]]) -> dict[str, dict[Element, Any]]:
        """Returns what the adapted blocks are given for a scenario's start values, by their own elements."""
        adapted = {name: fit for name, fit in self.fits.items() if not fit.identical}
        return {name: handed_on(fit, [(s.element, s.value) for s in starts[name]]) for name, fit in adapted.items()}
