"""Stands for a block that reads the quaternion of an attitude with its scalar in the wrong place.

Tests: tests/orchestration/acceptance/test_polarity.py.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from ...fmu.model import Element, Floats
from ...instances.block import Block
from ...instances.front import Front
from .wrongs import turned


class Misread(Front):
    """One of its inputs, a rotation matrix, reaches it as `turned` makes it."""

    def __init__(self, inner: Block, variable: str, turn: tuple[str, bool]) -> None:
        super().__init__(inner)
        self._variable, self._turn = variable, turn
        self._known: dict[Element, float] = {}

    def set(self, values: Iterable[tuple[Element, Any]]) -> None:
        """Hands on what it is set to; the matrix once it is whole."""
        others = []
        for element, value in values:
            if element.variable == self._variable:
                self._known[element] = float(value)
            else:
                others.append((element, value))
        elements = self.model.variables[self._variable].elements
        if len(self._known) == len(elements):
            read = turned([self._known[element] for element in elements], *self._turn)
            others += zip(elements, read, strict=True)
        if others:
            self.inner.set(others)

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        given, turn = super().wire(inputs, outputs, live, into), self._turn
        hand_over = self.set_inputs
        places = [inputs.index(element) for element in self.model.variables[self._variable].elements]

        def set_inputs() -> None:
            given[places] = turned(given[places].tolist(), *turn)
            hand_over()

        self.set_inputs = set_inputs
        return given
