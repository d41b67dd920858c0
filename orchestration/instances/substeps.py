"""A block that cannot vary its step and takes several of its own in each step of the master."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ..fmu.model import Element, Floats
from .block import Block


@dataclass(frozen=True)
class Substeps:
    """`count` steps of `length` s make one of the master's."""

    count: int
    length: Fraction

    def before(self, block: Block) -> Block:
        """The block, so stepped."""
        return _Substepped(block, self)


class _Substepped:
    """See `block.Block`. Its instants are whole multiples of its own step, rounded once, never a sum."""

    def __init__(self, inner: Block, substeps: Substeps) -> None:
        self.inner, self.substeps = inner, substeps
        self.name, self.model = inner.name, inner.model

    @property
    def log(self) -> Sequence[str]:
        return self.inner.log

    def set(self, values: Iterable[tuple[Element, Any]]) -> None:
        self.inner.set(values)

    def get(self, elements: Sequence[Element]) -> list[float]:
        return self.inner.get(elements)

    def enter(self, stop: float) -> None:
        self.inner.enter(stop)

    def leave(self) -> None:
        self.inner.leave()

    def close(self) -> None:
        self.inner.close()

    set_inputs: Callable[[], None]
    get_live: Callable[[], None]
    get_all: Callable[[], None]

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        given = self.inner.wire(inputs, outputs, live, into)
        inner = self.inner
        self.set_inputs, self.get_live, self.get_all = inner.set_inputs, inner.get_live, inner.get_all
        return given

    def do_step(self, time: float, step: float) -> None:
        numerator, denominator = self.substeps.length.as_integer_ratio()
        first, own = round(time * denominator / numerator), numerator / denominator
        for n in range(first, first + self.substeps.count):
            self.inner.do_step(n * numerator / denominator, own)
