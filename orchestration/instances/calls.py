"""The calls of the step loop on an FMU in this process: its functions by their pointers, on buffers made once."""

from __future__ import annotations

import ctypes as c
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import BlockError
from ..fmu.model import Element, Floats
from ..fmu.types import Native

WARNING = 1
"""fmi2Warning: what is above it has failed."""
BEYOND = -8
"""In place of a status: a value that the type of its variable cannot hold."""
ANSWERS = ("asks for event mode", "asks to end the simulation", "has returned early")
"""What DoStep of FMI 3.0 may say besides its status; in place of a status, minus the sum of 1, 2 and 4 for them."""
_FEW = 6
"""So many values are copied one by one sooner than by NumPy."""
_NO_RESTORE = 1
"""noSetFMUStatePriorToCurrentPoint: the master never goes back."""

Call = Callable[[], None]
Gather = Callable[[], object]
"""Takes the inputs of a block from wherever they come."""
Stride = Callable[[float, float], None]
"""Of time and step."""
Failed = Callable[[str, int], BlockError]
"""The error of a call that gave a status, or of what stands in place of one."""


class Part(NamedTuple):
    """Part of an exchange that is made, counted from its first."""

    references: int
    values: int
    """In FMI's buffer, whose arrays are whole."""
    elements: int


@dataclass(frozen=True)
class Exchange:
    """One Get or Set of one type of FMI, with all that it needs; the loop in C takes it as it is."""

    name: str
    function: Any
    native: Native
    sets: bool
    references: NDArray[np.uint32]
    elements: Sequence[Element]
    values: Floats
    """All inputs of the block, or its stretch of the bus."""
    places: NDArray[np.int64]
    """Where among them its elements are,"""
    slots: NDArray[np.int64]
    """and where in the buffer."""
    buffer: NDArray[Any]
    """What FMI reads or writes: the stretch of the values themselves where all lie side by side, else a copy as C has
    them."""
    direct: bool
    """Whether it is that stretch."""
    live: Part
    """What others need in every step."""
    all: Part

    def bound(self, component: Any, part: Part) -> Callable[[], int]:
        """The function with its arguments for this part; made once, for the calls of every step."""
        pointer, size = c.c_void_p.from_param, c.c_size_t.from_param
        arguments = [pointer(self.references.ctypes.data), size(part.references), pointer(self.buffer.ctypes.data)]
        counted = [] if self.name.startswith("fmi2") else [size(part.values)]
        return partial(self.function, component, *arguments, *counted)

    def call(self, component: Any, part: Part, failed: Failed) -> Call:
        """The call for this part."""
        name, invoke, values, buffer = self.name, self.bound(component, part), self.values, self.buffer
        places, slots = _span(self.places[: part.elements]), _span(self.slots[: part.elements])
        low, beyond = self.native.bounds

        def direct() -> None:
            status = invoke()
            if status > WARNING:
                raise failed(name, status)

        def give() -> None:
            given = values[places]
            if not (low <= given.min() and given.max() < beyond):
                raise failed(name, BEYOND)
            buffer[slots] = given
            direct()

        def take() -> None:
            direct()
            values[places] = buffer[slots]

        if self.direct:
            return direct
        return give if self.sets else take

    def copies(self, part: Part) -> list[tuple[int, int]]:
        """Returns place and slot of each value of this part."""
        return list(zip(self.places.tolist(), self.slots.tolist(), strict=True))[: part.elements]


def _span(places: NDArray[np.int64]) -> Any:
    """The places as a slice where they follow each other, which NumPy takes sooner."""
    return slice(int(places[0]), int(places[0]) + len(places)) if follow(places) else places


def follow(places: NDArray[np.int64]) -> bool:
    """Returns whether each place is the one after that before it."""
    return len(places) > 0 and bool((places[1:] - places[:-1] == 1).all())


def sequence(wanted: Sequence[Call]) -> Call:
    """The calls one after the other."""
    if len(wanted) == 1:
        return wanted[0]

    def run() -> None:
        for call in wanted:
            call()

    return run


def stride(gather: Gather, set_inputs: Call, do_step: Stride, get: Call, step: float) -> Callable[[float], None]:
    """Returns the function of time that makes a whole step of this length by the four calls."""

    def make(time: float) -> None:
        gather()
        set_inputs()
        do_step(time, step)
        get()

    return make


class Stepper:
    """DoStep with its arguments, and where FMI 3.0 leaves its answers."""

    def __init__(self, name: str, function: Any, component: Any, answers: bool) -> None:
        self.name, self.answers = name, answers
        self.time, self.step, self.asked = c.c_double(), c.c_double(), c.c_uint32(0)
        self._last = c.c_double()
        more: list[Any] = [c.c_int.from_param(_NO_RESTORE)]
        if answers:
            asked = [c.byref(self.asked, i) for i in range(3)]
            more = [c.c_bool.from_param(_NO_RESTORE), *asked, c.byref(self._last)]
        self.invoke = partial(function, component, self.time, self.step, *more)

    def status(self, status: int) -> int:
        """The status of a call, or its answers in place of one."""
        if status > WARNING or not self.asked.value:
            return status
        return -sum(1 << i for i in range(3) if self.asked.value >> 8 * i & 0xFF)

    def call(self, failed: Failed) -> Stride:
        """The call."""
        at, length, asked, invoke, last = self.time, self.step, self.asked, self.invoke, 0.0

        def do_step(time: float, step: float) -> None:
            nonlocal last
            if step != last:
                length.value = last = step
            at.value = time
            status = invoke()
            if status > WARNING or asked.value:
                raise failed(self.name, self.status(status))

        return do_step


def strider(
    gather: Gather,
    setters: Sequence[Exchange],
    getters: Sequence[Exchange],
    stepper: Stepper,
    component: Any,
    failed: Failed,
    step: float,
    live: bool,
) -> Callable[[float], None] | None:
    """Returns `stride` in one function, which saves a third of its time.

    It sets doubles only, gets doubles first and few other values, as mostly; None where that is not so.
    """
    gets = [(e, part) for e in getters if (part := e.live if live else e.all).references]
    few = all(part.elements <= _FEW for _, part in gets[1:])
    if len(setters) != 1 or not setters[0].direct or not gets or not gets[0][0].direct or not few:
        return None
    setter, (getter, first) = setters[0], gets[0]
    put, advance, fetch = setter.bound(component, setter.all), stepper.invoke, getter.bound(component, first)
    others = [(e.name, e.bound(component, part), e.buffer.data, e.copies(part)) for e, part in gets[1:]]
    into, at, asked, answers = getter.values.data, stepper.time, stepper.asked, stepper.answers
    stepper.step.value = step

    def make(time: float) -> None:
        gather()
        if (status := put()) > WARNING:
            raise failed(setter.name, status)
        at.value = time
        if (status := advance()) > WARNING or (answers and asked.value):
            raise failed(stepper.name, stepper.status(status))
        if (status := fetch()) > WARNING:
            raise failed(getter.name, status)
        for name, fetch_more, given, copies in others:
            if (status := fetch_more()) > WARNING:
                raise failed(name, status)
            for place, slot in copies:
                into[place] = given[slot]

    return make
