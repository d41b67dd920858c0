"""A block that reads the quaternion of an attitude matrix with its scalar in the wrong place; no matrix product says this."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from ...fmu.model import Element, Floats, Model
from ...instances.block import Block
from .wrongs import turned


class Misread:
    """See `block.Block`. One of its inputs, a rotation matrix, reaches it as `turned` makes it."""

    def __init__(self, inner: Block, variable: str, turn: tuple[str, bool]) -> None:
        self.inner, self._variable, self._turn = inner, variable, turn
        self.name, self.model = inner.name, inner.model
        self._known: dict[Element, float] = {}

    name: str
    model: Model
    set_inputs: Callable[[], None]
    do_step: Callable[[float, float], None]
    get_live: Callable[[], None]
    get_all: Callable[[], None]

    @property
    def log(self) -> Sequence[str]:
        return self.inner.log

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

    def get(self, elements: Sequence[Element]) -> list[float]:
        return self.inner.get(elements)

    def enter(self, stop: float) -> None:
        self.inner.enter(stop)

    def leave(self) -> None:
        self.inner.leave()

    def close(self) -> None:
        self.inner.close()

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        inner, turn = self.inner, self._turn
        given = inner.wire(inputs, outputs, live, into)
        hand_over = inner.set_inputs
        places = [inputs.index(element) for element in self.model.variables[self._variable].elements]

        def set_inputs() -> None:
            given[places] = turned(given[places].tolist(), *turn)
            hand_over()

        self.set_inputs, self.do_step = set_inputs, inner.do_step
        self.get_live, self.get_all = inner.get_live, inner.get_all
        return given
