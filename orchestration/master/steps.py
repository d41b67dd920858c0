"""One base step of the loop in Python, in both exchanges.

Sequential exchange: the blocks are stepped one after the other, and each sees what those before it have just given. Parallel
exchange: all inputs are set from the values at the step's start, then all blocks are stepped. A step of a block is one
gathering from the bus, one Set, one doStep and one Get; Get is never called between Set and doStep. At the end of a base step
all that was given is looked at, and what is not finite ends the run; the loop in C looks after each block.

A block with `every: N` is stepped when N base steps have passed, over all of them, with the inputs of that moment.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import BlockError
from ..instances.calls import stride
from ..system.clock import Clock
from .bus import Bus, Seat
from .pacing import Pacer
from .recording import check_finite


@dataclass(frozen=True)
class Steps:
    """What makes base steps: blocks that are initialized and wired."""

    bus: Bus
    clock: Clock
    every: Mapping[str, int]
    pacer: Pacer | None

    def _timed(self, seat: Seat, call: Callable[..., Any]) -> Callable[..., Any]:
        """The call, whose time a paced run counts."""
        return call if self.pacer is None else self.pacer.timed(seat.block.name, call)

    def sequential(self) -> Callable[[int], None]:
        """One base step, up to the given count: block after block."""
        interval, numerator, denominator = self.clock.interval, self.clock.numerator, self.clock.denominator
        bus = self.bus
        isfinite, values, dot = math.isfinite, bus.values, bus.values.dot
        usual, recorded = [], []
        for seat in bus.seats:
            every = self._every(seat)
            fetch_all = self._timed(seat, stride(seat.block.set_inputs, seat.block.do_step, seat.block.get_all))
            # An FMU in this process has one function for all three calls.
            live = getattr(seat.block, "stride", None)
            live = live or stride(seat.block.set_inputs, seat.block.do_step, seat.block.get_live)
            fetch_live = self._timed(seat, live)
            step = every * numerator / denominator
            usual.append((seat, every, step, seat.gather, fetch_live if every == 1 else fetch_all))
            recorded.append((seat, every, step, seat.gather, fetch_all))

        def advance(count: int) -> None:
            last = (count - 1) * numerator / denominator
            for seat, every, step, gather, make in usual if count % interval else recorded:
                begun = last
                if every > 1:
                    if count % every:
                        continue
                    begun = (count - every) * numerator / denominator
                try:
                    gather()
                    make(begun, step)
                except BlockError as error:
                    self._check(count, seat)  # it may have refused what is not finite
                    error.time = self.clock.time(count - every)
                    raise
            if not isfinite(dot(values)):
                self._check(count)

        return advance

    def parallel(self) -> Callable[[int], None]:
        """One base step, up to the given count: all inputs from the step's start, then all blocks."""
        bus = self.bus
        seats = [_Calls(seat, self._every(seat), self._timed) for seat in bus.seats]
        interval, time, values = self.clock.interval, self.clock.time, bus.values

        def advance(count: int) -> None:
            active = [calls for calls in seats if count % calls.every == 0]
            begun = count - 1
            try:
                for calls in active:
                    calls.gather()
                    calls.set_inputs()
                for calls in active:
                    begun = count - calls.every
                    calls.do_step(time(begun), time(calls.every))
                for calls in active:
                    if count % interval == 0 or calls.every > 1:
                        calls.get_all()
                    else:
                        calls.get_live()
            except BlockError as error:
                error.time = time(begun) if error.time is None else error.time
                raise
            if not math.isfinite(values.dot(values)):
                self._check(count)

        return advance

    def _check(self, count: int, end: Seat | None = None) -> None:
        """Raises BlockError where an output is not finite; of the blocks before `end`."""
        for seat in self.bus.seats:
            if seat is end:
                return
            check_finite(seat, self.clock.time(count))

    def _every(self, seat: Seat) -> int:
        return self.every.get(seat.block.name, 1)


class _Calls:
    """The calls of a block in a parallel step."""

    def __init__(self, seat: Seat, every: int, timed: Callable[[Seat, Callable[..., Any]], Callable[..., Any]]) -> None:
        block = seat.block
        self.every, self.gather = every, seat.gather
        self.set_inputs, self.do_step = timed(seat, block.set_inputs), timed(seat, block.do_step)
        self.get_all, self.get_live = timed(seat, block.get_all), timed(seat, block.get_live)
