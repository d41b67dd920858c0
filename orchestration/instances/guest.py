"""An FMU of others in this process: what it changes for the others is looked at, and where it is can be told when it
ends all."""

from __future__ import annotations

import json
import mmap
import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cached_property
from typing import Any, TypeVar

from ..fmu.model import Element
from .calls import Gather, Stride
from .slave import Slave
from .surroundings import Surroundings

T = TypeVar("T")


CALLS = "Set", "DoStep", "Get"
"""Of the step loop."""
_STEP = struct.Struct("<qq")
"""The steps that a guest has done, and which of CALLS runs, from 1; 0: none (CGuest of master/layout.py)."""


class Trace:
    """State of the FMUs of this process: memory that outlives the process in the one that waits for it."""

    SIZE, GUESTS, ROOM = 1 << 16, 1 << 14, 64
    """Bytes in all, before the places of guests in the loop in C, and of such a place (CGuest of master/layout.py)."""

    def __init__(self) -> None:
        self.page = mmap.mmap(-1, self.SIZE)
        self._names: list[tuple[str, str, float]] = []
        self._calls = 0

    @property
    def done(self) -> bool:
        """Returns whether the work is done, whatever came of it."""
        return self.page[0] != 0

    def finish(self) -> None:
        self.page[0] = 1

    def at(self, block: str, call: str, time: float | None = None) -> None:
        """A call begins outside of the loop in C."""
        self._put(1, f"{block}: {call}" + ("" if time is None else f" at {time:.10g} s"), 1000)
        self._calls += 1
        self.page[1010] = 1

    @contextmanager
    def during(self, block: str, call: str) -> Iterator[None]:
        """Tells a call outside of the loop in C while it runs."""
        self.at(block, call)
        try:
            yield
        finally:
            self.rest()

    def step(self, place: int, done: int, call: str | None) -> None:
        """A call of CALLS begins in a step, at the place of a guest; None: the last has returned."""
        _STEP.pack_into(self.page, place, done, 0 if call is None else CALLS.index(call) + 1)

    def renew(self) -> None:
        """Takes memory of this process alone."""
        self.page = mmap.mmap(-1, self.SIZE)

    def rest(self) -> None:
        """It has returned."""
        self.page[1010] = 0

    @property
    def running(self) -> tuple[int, str] | None:
        """The call that runs, another one each time, as its number outside of the loop in C and its text."""
        inside = any(self._active(number)[1] for number in range(len(self._names)))
        return (self._calls, self.text) if inside or self.page[1010] else None

    def place(self, block: str, prefix: str, step: float) -> int:
        """Returns where a guest of the loop in C tells the call that runs; `step` is the base step, s."""
        known = [name for name, _, _ in self._names]
        number = known.index(block) if block in known else len(known)
        self._names[number:] = [(block, prefix, step), *self._names[number + 1 :]]
        self._put(1024, json.dumps(self._names), self.GUESTS - 1100)
        return self.GUESTS + self.ROOM * (number % ((self.SIZE - self.GUESTS) // self.ROOM))

    def _put(self, place: int, text: str, most: int) -> None:
        data = text.encode()[:most]
        self.page[place : place + 2] = len(data).to_bytes(2, "little")
        self.page[place + 2 : place + 2 + len(data)] = data

    def _text(self, place: int) -> str:
        size = int.from_bytes(self.page[place : place + 2], "little")
        return self.page[place + 2 : place + 2 + size].decode("utf-8", "replace")

    @property
    def text(self) -> str:
        """The call that runs, or that began last."""
        for number, (block, prefix, step) in enumerate(json.loads(self._text(1024) or "[]")):
            begun, active = self._active(number)
            if active:
                return f"{block}: {prefix}{CALLS[active - 1]} at {begun * step:.10g} s"
        return self._text(1)

    def _active(self, number: int) -> tuple[int, int]:
        return _STEP.unpack_from(self.page, self.GUESTS + self.ROOM * number)


TRACE = Trace()


class Guest(Slave):
    """A slave whose calls are followed by looks at the surroundings."""

    def __init__(self, around: Surroundings, name: str, *arguments: Any) -> None:
        self.around = around
        TRACE.at(name, "loading its library")
        try:
            super().__init__(name, *arguments)
        finally:
            TRACE.rest()
            around.look(name, "instantiating it")

    def _looked(self, call: str, work: Callable[[], T]) -> T:
        TRACE.at(self.name, call)
        try:
            return work()
        finally:
            TRACE.rest()
            self.around.look(self.name, call)

    def _plain(self, call: str, *arguments: Any) -> None:
        plain = super()._plain
        self._looked(call, lambda: plain(call, *arguments))

    def set(self, values: Iterable[tuple[Element, Any]]) -> None:
        change = super().set
        self._looked(f"{self.model.prefix}Set", lambda: change(values))

    def get(self, elements: Sequence[Element]) -> list[float]:
        take = super().get
        return self._looked(f"{self.model.prefix}Get", lambda: take(elements))

    @cached_property
    def do_step(self) -> Stride:
        step_on, call, around = self._stepper.call(self.failed), f"{self.model.prefix}DoStep", self.around

        def do_step(time: float, step: float) -> None:
            TRACE.at(self.name, call, time)
            try:
                step_on(time, step)
            finally:
                TRACE.rest()
                around.look_at_rounding(self.name, call)

        return do_step

    def stride(self, gather: Gather, step: float, live: bool) -> Callable[[float], None]:
        make, call, around = super().stride(gather, step, live), f"{self.model.prefix}DoStep", self.around

        def stride(time: float) -> None:
            TRACE.at(self.name, call, time)
            try:
                make(time)
            finally:
                TRACE.rest()
                around.look_at_rounding(self.name, call)

        return stride

    def close(self) -> None:
        end = super().close
        with suppress(OSError):
            self._looked(f"{self.model.prefix}FreeInstance", end)
