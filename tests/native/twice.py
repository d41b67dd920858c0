"""A block's two flavours behind one function, for tests of what it remembers: test_history.py and those beside it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from tests.blocks import module

from .driver import Instance

Step = Callable[[Any], dict[str, Any]]
"""Takes the inputs at the end of the next step; returns the outputs there."""


@contextmanager
def python(block: str, p: Any, u: Any, h: float) -> Iterator[Step]:
    code = module(block)
    state = code.start(p, u)

    def step(u: Any) -> dict[str, Any]:
        nonlocal state
        state, y = code.step(state, u, p, h)
        return {name: getattr(y, name) for name in y.__dataclass_fields__}

    yield step


@contextmanager
def native(block: str, p: Any, u: Any, h: float) -> Iterator[Step]:
    with Instance(block) as it:
        it.set_all(p)
        it.set_all(u)
        it.initialize()
        count = 0

        def step(u: Any) -> dict[str, Any]:
            nonlocal count
            it.set_all(u)
            it.step(count * h, h)
            count += 1
            return it.outputs()

        yield step


FLAVOURS = [python, pytest.param(native, marks=pytest.mark.compile)]
