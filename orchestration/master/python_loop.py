"""The step loop in Python; compiled.py has the same in C, which gives the same bits.

Sequential exchange: the blocks are stepped one after the other, and each sees what those before it have just given.
Parallel exchange: all inputs are set from the values at the step's start, then all blocks are stepped. A step of a
block is one gathering from the bus, one Set, one doStep and one Get; Get is never called between Set and doStep. At
the end of a base step all that was given is looked at, and what is not finite ends the run; the loop in C looks after
each block.

A block with `every: N` is stepped when N base steps have passed, over all of them, with the inputs of that moment.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..errors import BlockError
from ..instances.block import Block
from ..instances.calls import Call, Gather, Stride, stride
from ..instances.slave import Slave
from .bus import Bus, Seat
from .circuit import Circuit
from .injection import gatherer
from .pacing import Pacer
from .recording import Observation, Recording, check_finite


class _Calls(NamedTuple):
    """The calls of a block in a parallel step."""

    every: int
    gather: Gather
    set_inputs: Call
    do_step: Stride
    get_all: Call
    get_live: Call


class PythonLoop:
    """A loop over any blocks that are initialized and wired."""

    def __init__(
        self,
        bus: Bus,
        circuit: Circuit,
        observation: Observation,
        recording: Recording,
        pacer: Pacer | None,
        begun: int = 0,
    ) -> None:
        """`begun`: base steps that are done already."""
        self.bus, self.observation, self.count = bus, observation, begun
        self._circuit, self._recording, self._pacer = circuit, recording, pacer
        places = {seat.block.name: place for place, seat in enumerate(bus.seats)}
        self._gathers = [gatherer(seat, circuit, places, lambda: self.count + 1) for seat in bus.seats]
        self._step = self._parallel() if circuit.parallel else self._sequential()

    def advance(self, until: int, interrupted: Sequence[int]) -> None:
        """Makes the base steps up to `until`, or up to the one in which it is interrupted. Raises BlockError."""
        bus, pacer, interval, step = self.bus, self._pacer, self._circuit.clock.interval, self._step
        keep = bus.delay.keeper(bus.values) if bus.delay else None
        take, columns, recorded = bus.values.take, bus.columns, self._recording.values
        observed, rows, first = bus.observed, self.observation.rows, self.observation.first
        some = bool(len(observed))
        with np.errstate(over="ignore"):
            for count in range(self.count + 1, until + 1):
                if interrupted:
                    return
                if keep is not None:
                    keep()
                step(count)
                self.count = count
                if count % interval == 0:
                    take(columns, 0, recorded[count // interval], "clip")
                if some:
                    take(observed, 0, rows[count - first], "clip")
                if pacer is not None:
                    pacer.hold(count)

    def _timed(self, seat: Seat, call: Callable[..., Any]) -> Callable[..., Any]:
        """Returns the call, whose time a paced run counts."""
        return call if self._pacer is None else self._pacer.timed(seat.block.name, call)

    def _sequential(self) -> Callable[[int], None]:
        """Returns the function that makes one base step, up to the given count: block after block."""
        clock = self._circuit.clock
        interval, numerator, denominator = clock.interval, clock.numerator, clock.denominator
        isfinite, values, dot = math.isfinite, self.bus.values, self.bus.values.dot
        usual, recorded = [], []
        for seat, gather in zip(self.bus.seats, self._gathers, strict=True):
            block, every = seat.block, self._circuit.rate(seat.block.name)
            step = every * numerator / denominator
            all_, live = (self._timed(seat, self._stride(block, gather, step, live)) for live in (False, True))
            usual.append((seat, every, live if every == 1 else all_))
            recorded.append((seat, every, all_))

        def advance(count: int) -> None:
            last = (count - 1) * numerator / denominator
            for seat, every, make in usual if count % interval else recorded:
                begun = last
                if every > 1:
                    if count % every:
                        continue
                    begun = (count - every) * numerator / denominator
                try:
                    make(begun)
                except BlockError as error:
                    self._check(count, seat)  # it may have refused what is not finite
                    error.time = clock.time(count - every)
                    raise
            if not isfinite(dot(values)):
                self._check(count)

        return advance

    def _stride(self, block: Block, gather: Gather, step: float, live: bool) -> Callable[[float], None]:
        """Returns a whole step of a block, up to its fetch of the outputs that others need, or of all."""
        if isinstance(block, Slave):  # which has one function for it
            return block.stride(gather, step, live)
        return stride(gather, block.set_inputs, block.do_step, block.get_live if live else block.get_all, step)

    def _parallel(self) -> Callable[[int], None]:
        """Returns the function that makes one base step: all inputs from the step's start, then all blocks."""
        clock, values = self._circuit.clock, self.bus.values
        seats = []
        for seat, gather in zip(self.bus.seats, self._gathers, strict=True):
            block = seat.block
            calls = (self._timed(seat, c) for c in (block.set_inputs, block.do_step, block.get_all, block.get_live))
            seats.append(_Calls(self._circuit.rate(block.name), gather, *calls))

        def advance(count: int) -> None:
            active = [calls for calls in seats if count % calls.every == 0]
            begun = count - 1
            try:
                for calls in active:
                    calls.gather()
                    calls.set_inputs()
                for calls in active:
                    begun = count - calls.every
                    calls.do_step(clock.time(begun), clock.time(calls.every))
                for calls in active:
                    if count % clock.interval == 0 or calls.every > 1:
                        calls.get_all()
                    else:
                        calls.get_live()
            except BlockError as error:
                error.time = clock.time(begun) if error.time is None else error.time
                raise
            if not math.isfinite(values.dot(values)):
                self._check(count)

        return advance

    def _check(self, count: int, end: Seat | None = None) -> None:
        """Raises BlockError where an output of the blocks before `end` is not finite."""
        for seat in self.bus.seats:
            if seat is end:
                return
            check_finite(seat, self._circuit.clock.time(count))
