"""The master: initialization and the step loop, on any blocks.

Sequential exchange: in each base step the blocks are stepped one after the other, and each sees what
those before it have just given. Parallel exchange: all inputs are set from the values at the step's
start, then all blocks are stepped. A step of a block is one gathering from the bus, one Set, one doStep
and one Get; Get is never called between Set and doStep. At the end of a base step all that was given
is looked at, and what is not finite ends the run.

A block with `every: N` is stepped when N base steps have passed, over all of them, with the inputs of
that moment.

Longer than 250 lines: initialization, both exchanges and the end of a run share the master's state.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np

from ..errors import BlockError, InputError
from ..fmu.model import Element
from ..instances.block import Block
from ..instances.calls import stride
from ..interrupt import Abandoned, interruptible
from ..system.clock import Clock
from ..system.faults import Faults
from ..system.order import Order
from ..system.starts import Start
from ..system.wiring import Node, Wiring
from .bus import Bus, Seat, lay_out
from .compiled import compiled_loop
from .injection import Changes, at_start, with_faults
from .pacing import Pacer
from .recording import REPORT_EVERY, Progress, Recording, Watch, check_finite, not_finite


@dataclass
class Master:
    """Runs blocks that are instantiated and not yet initialized."""

    blocks: Mapping[str, Block]
    wiring: Wiring
    order: Order
    clock: Clock
    columns: Sequence[Node]
    """The elements to be recorded."""
    every: Mapping[str, int] = field(default_factory=dict)
    parallel: bool = False
    compiled: bool = False
    """Whether the loop in C is used where the blocks and this machine allow it."""
    faults: Faults = field(default_factory=Faults)
    watch: Watch | None = None
    """What looks at some of the columns after every base step; None for nothing."""
    pacer: Pacer | None = None
    """What holds the loop in Python to wall time; None for a run as fast as it goes."""
    bus: Bus | None = None
    """Laid out by the first run; further ones of the same blocks, once they are reset, use it again."""

    def run(self, starts: Mapping[str, Sequence[Start]], progress: Progress | None = None) -> Recording:
        """Initializes and runs. A failing block or Ctrl-C ends the run, and the recording says so."""
        recording = self._recording()
        rows = 0
        try:
            self._initialize(starts)
            if self.bus is None:
                self.bus = lay_out(
                    self.blocks, self.wiring, self.order, self.columns, self.watch.columns if self.watch else ()
                )
            else:
                self.bus.values.fill(0.0)
            bus = self.bus
            self._leave(bus)
            bus.values.take(bus.columns, 0, recording.values[0], "clip")
            if self.watch:
                bus.values.take(bus.watched, 0, self.watch.row(0), "clip")
            rows = 1
            loop = None
            if self.compiled and self.pacer is None:
                disturbances = self.faults.disturbances
                loop = compiled_loop(bus, self.clock, self.every, self.parallel, self.watch, recording, disturbances)
            if loop is not None:
                loop.run(recording, progress, Changes(self.faults, bus, self.every, self.clock))
            else:
                self._loop(bus, recording, progress)
            self._record_end(bus, recording)
        except Abandoned:
            pass  # the recording says that it was interrupted
        except BlockError as error:
            recording.failure = error
        if rows:
            rows += recording.steps // self.clock.interval + recording.extra
            if self.watch:
                self.watch.flush(recording.steps)
        recording.time, recording.values = recording.time[:rows], recording.values[:rows]
        return recording

    def _recording(self) -> Recording:
        shape = self.clock.samples, len(self.columns)
        try:
            return Recording(self.clock.sample_times(), np.empty(shape), list(self.columns))
        except (MemoryError, ValueError):
            size = shape[0] * shape[1] * 8 / 1e9
            message = f"the recording would take {size:.3g} GB; remedy: a longer record.interval, or fewer signals"
            raise InputError(message) from None

    def _record_end(self, bus: Bus, recording: Recording) -> None:
        """Records where the run has ended, if that is between two samples."""
        count = recording.steps
        if count % self.clock.interval == 0:
            return
        time = self.clock.time(count)
        for seat in bus.seats:
            try:
                seat.block.get_all()
            except BlockError as error:
                error.time = time
                raise
            check_finite(seat, time)
        row = count // self.clock.interval + 1
        recording.time = np.append(recording.time[:row], time)
        bus.values.take(bus.columns, 0, recording.values[row], "clip")
        recording.extra = True

    # ------------------------------------------------------------ initialization

    def _initialize(self, starts: Mapping[str, Sequence[Start]]) -> None:
        """Sets starts, then takes outputs to inputs in the order in which they depend on each other."""
        for name, block in self.blocks.items():
            block.set((start.element, start.value) for start in starts.get(name, ()))
        stop = self.clock.time(self.clock.steps)
        for block in self.blocks.values():
            block.enter(stop)
        feeds: dict[Node, list[tuple[Node, float, float]]] = {}
        for link in self.wiring.links:
            if not link.delayed:
                for source, target in zip(link.source, link.target, strict=True):
                    feeds.setdefault(source, []).append((target, link.factor, link.offset))
        for level in self.order.levels:
            incoming: dict[str, list[tuple[Element, float]]] = {}
            for name, block in self.blocks.items():
                nodes = [node for node in level if node.block == name]
                values = block.get([node.element for node in nodes]) if nodes else []
                for node, value in zip(nodes, values, strict=True):
                    if not math.isfinite(value):
                        raise not_finite(block, node.element, value)
                    for target, factor, offset in feeds.get(node, ()):
                        given = at_start(self.faults, target, factor * value + offset)
                        incoming.setdefault(target.block, []).append((target.element, given))
            for name, pairs in incoming.items():
                self.blocks[name].set(pairs)

    def _leave(self, bus: Bus) -> None:
        """Leaves initialization mode and fetches the outputs at 0."""
        for seat in bus.seats:
            seat.block.leave()
        with np.errstate(over="ignore"):
            for seat in bus.seats:
                seat.block.get_all()
                check_finite(seat)

    # ------------------------------------------------------------ the loop

    def _loop(self, bus: Bus, recording: Recording, progress: Progress | None) -> None:
        """The loop in Python; compiled.py has the same in C."""
        advance = self._advance(bus)
        take, columns, rows = bus.values.take, bus.columns, recording.values
        watch, watched, pacer = self.watch, bus.watched, self.pacer
        delay = bus.delay.keeper(bus.values) if bus.delay else None
        steps, interval = self.clock.steps, self.clock.interval
        count = 0

        def report(count: int) -> None:
            if progress is not None:
                progress(self.clock.time(count))

        begun = perf_counter()
        due = begun + REPORT_EVERY
        with interruptible() as interrupted, np.errstate(over="ignore"):
            try:
                if pacer is not None:
                    pacer.begin(self.clock, interrupted, report)
                for following in range(1, steps + 1):
                    if interrupted:
                        break
                    if delay is not None:
                        delay()
                    advance(following)
                    count = following
                    if count % interval == 0:
                        take(columns, 0, rows[count // interval], "clip")
                    if watch is not None:
                        take(watched, 0, watch.row(count), "clip")
                    if pacer is not None:
                        pacer.hold(count)
                    if progress is not None and perf_counter() > due:
                        report(count)
                        due = perf_counter() + REPORT_EVERY
            finally:
                recording.steps, recording.wall = count, perf_counter() - begun
                recording.interrupted = interrupted[0] if interrupted else 0

    def _advance(self, bus: Bus) -> Callable[[int], None]:
        """What makes one base step, up to the given count."""

        def sound() -> Callable[[int], None]:
            return self._parallel_step(bus) if self.parallel else self._sequential_step(bus)

        if not self.faults:
            return sound()
        return with_faults(self.faults, bus, self.every, self.parallel, self.clock, sound)

    def _timed(self, seat: Seat, call: Callable[..., Any]) -> Callable[..., Any]:
        """The call, whose time a paced run counts."""
        return call if self.pacer is None else self.pacer.timed(seat.block.name, call)

    def _sequential_step(self, bus: Bus) -> Callable[[int], None]:
        """One base step, up to the given count: block after block."""
        interval, numerator, denominator = self.clock.interval, self.clock.numerator, self.clock.denominator
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
                    self._check(bus, count, seat)  # it may have refused what is not finite
                    error.time = self.clock.time(count - every)
                    raise
            if not isfinite(dot(values)):
                self._check(bus, count)

        return advance

    def _parallel_step(self, bus: Bus) -> Callable[[int], None]:
        """One base step, up to the given count: all inputs from the step's start, then all blocks."""
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
                self._check(bus, count)

        return advance

    def _check(self, bus: Bus, count: int, end: Seat | None = None) -> None:
        """Raises BlockError where an output is not finite; of the blocks before `end`."""
        for seat in bus.seats:
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
