"""A block in front of another: it changes some of the calls and passes on the rest."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from ..fmu.model import Element, Floats, Model
from .block import Block


class Front:
    """See `block.Block`.

    Passes everything on to `inner`; the calls of the loop are its own, so that they cost nothing.
    """

    def __init__(self, inner: Block, model: Model | None = None) -> None:
        self.inner, self.name, self.model = inner, inner.name, inner.model if model is None else model

    set_inputs: Callable[[], None]
    do_step: Callable[[float, float], None]
    get_live: Callable[[], None]
    get_all: Callable[[], None]

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

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        given = self.inner.wire(inputs, outputs, live, into)
        self.set_inputs, self.do_step = self.inner.set_inputs, self.inner.do_step
        self.get_live, self.get_all = self.inner.get_live, self.inner.get_all
        return given

    def close(self) -> None:
        self.inner.close()
