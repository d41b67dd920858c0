"""A block that cannot vary its step and takes several of its own in each step of the master."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from ..fmu.model import Element, Floats
from .block import Block
from .front import Front


@dataclass(frozen=True)
class Substeps:
    """`count` steps of `length` s make one of the master's."""

    count: int
    length: Fraction

    def before(self, block: Block) -> Block:
        """The block, so stepped."""
        return _Substepped(block, self)


class _Substepped(Front):
    """Its instants are whole multiples of its own step, rounded once, never a sum."""

    def __init__(self, inner: Block, substeps: Substeps) -> None:
        super().__init__(inner)
        self.substeps = substeps

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        given = super().wire(inputs, outputs, live, into)
        self.do_step = self._do_steps
        return given

    def _do_steps(self, time: float, step: float) -> None:
        numerator, denominator = self.substeps.length.as_integer_ratio()
        first, own = round(time * denominator / numerator), numerator / denominator
        for n in range(first, first + self.substeps.count):
            self.inner.do_step(n * numerator / denominator, own)
