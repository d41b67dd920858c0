"""The calls of the step loop on an FMU in this process: its functions by their pointers, on buffers made once."""

from __future__ import annotations

import ctypes as c
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import BlockError
from ..fmu.model import Floats

WARNING = 1
"""fmi2Warning: what is above it has failed."""
_NO_RESTORE = c.c_int.from_param(1)
"""noSetFMUStatePriorToCurrentPoint: the master never goes back."""

Call = Callable[[], None]
Stride = Callable[[float, float], None]
"""Of time and step."""
Failed = Callable[[str, int], BlockError]
"""The error of a call that gave a status."""


@dataclass(frozen=True)
class Exchange:
    """One fmi2Get<Type> or fmi2Set<Type>, with all that it needs; the loop in C takes it as it is."""

    name: str
    function: Any
    references: NDArray[np.uint32]
    values: Floats
    """Its stretch of the bus or of the block's inputs."""
    buffer: NDArray[Any]
    """What FMI reads or writes: `values` themselves for Reals, else a copy as C has them."""
    live: int
    """How many of the values, the first, others need in every step."""

    def arguments(self, count: int) -> tuple[Any, Any, Any]:
        """The arguments for the first `count` values, behind the component; made once, for the calls of every step."""
        pointer = c.c_void_p.from_param
        return (
            pointer(self.references.ctypes.data),
            c.c_size_t.from_param(count),
            pointer(self.buffer.ctypes.data),
        )

    def call(self, component: Any, count: int, failed: Failed) -> Call:
        """The call for the first `count` values."""
        name, function = self.name, self.function
        references, n, data = self.arguments(count)
        values, buffer = self.values[:count], self.buffer[:count]

        def real() -> None:
            status = function(component, references, n, data)
            if status > WARNING:
                raise failed(name, status)

        def whole_set() -> None:
            buffer[:] = values
            real()

        def whole_get() -> None:
            real()
            values[:] = buffer

        if self.buffer is self.values:
            return real
        return whole_set if name.startswith("fmi2Set") else whole_get


def sequence(wanted: Sequence[Call]) -> Call:
    """The calls one after the other."""
    if len(wanted) == 1:
        return wanted[0]

    def run() -> None:
        for call in wanted:
            call()

    return run


def stride(set_inputs: Call, do_step: Stride, get: Call) -> Stride:
    """A whole step of three calls."""

    def three(time: float, step: float) -> None:
        set_inputs()
        do_step(time, step)
        get()

    return three


def stepper(function: Any, component: Any, failed: Failed) -> Stride:
    """fmi2DoStep."""
    at, length, last = c.c_double(), c.c_double.from_param(0.0), 0.0

    def do_step(time: float, step: float) -> None:
        nonlocal length, last
        if step != last:
            length, last = c.c_double.from_param(step), step
        at.value = time
        status = function(component, at, length, _NO_RESTORE)
        if status > WARNING:
            raise failed("fmi2DoStep", status)

    return do_step


def strider(
    setters: Sequence[Exchange], getters: Sequence[Exchange], advance: Any, component: Any, failed: Failed
) -> Stride | None:
    """A whole step in one function, where it sets and gets Reals only, as mostly; None where it does not."""
    getters = [e for e in getters if e.live]
    if len(setters) != 1 or len(getters) != 1 or any(e.buffer is not e.values for e in (*setters, *getters)):
        return None
    setter, getter = setters[0], getters[0]
    set_real, get_real = setter.function, getter.function
    inputs, n, given = setter.arguments(len(setter.values))
    outputs, m, taken = getter.arguments(getter.live)
    at, length, last = c.c_double(), c.c_double.from_param(0.0), 0.0

    def one(time: float, step: float) -> None:
        nonlocal length, last
        if step != last:
            length, last = c.c_double.from_param(step), step
        status = set_real(component, inputs, n, given)
        if status > WARNING:
            raise failed(setter.name, status)
        at.value = time
        status = advance(component, at, length, _NO_RESTORE)
        if status > WARNING:
            raise failed("fmi2DoStep", status)
        status = get_real(component, outputs, m, taken)
        if status > WARNING:
            raise failed(getter.name, status)

    return one
