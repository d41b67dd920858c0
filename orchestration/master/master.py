"""The master: initialization and the step loop, on any blocks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from ..errors import BlockError, InputError
from ..instances.block import Block
from ..interrupt import Abandoned, interruptible
from ..system.observer import Observer
from ..system.starts import Start
from ..system.wiring import Node
from .bus import Bus, lay_out
from .circuit import Circuit
from .compiled import CompiledLoop, compiled_loop
from .initialization import initialize
from .injection import Changes
from .pacing import Pacer
from .python_loop import PythonLoop
from .recording import ROWS, Observation, Recording, check_finite

Progress = Callable[[float], None]
"""Called now and then with the simulated time."""

_REPORT_EVERY = 0.05
"""Seconds of wall time from one report of the progress to the next, at least."""


@dataclass(frozen=True)
class Kept:
    """State from which a flight goes on, in place of initialization."""

    count: int
    """Base steps that are done."""
    restore: Callable[[], None]
    """Brings the instances, which have been reset, into their states of then. Raises BlockError."""


@dataclass(frozen=True)
class Options:
    """Options of the loop of a run; the results are the same."""

    compiled: bool = True
    """Whether the loop in C is used where the blocks and this machine allow it."""
    progress: Progress | None = None
    pacer: Pacer | None = None
    """Holds the loop in Python to wall time; None for a run as fast as it goes."""
    soon: int = ROWS
    """Base steps until the observers are shown the first samples."""
    until: int | None = None
    """Base steps after which it ends, before the end that the FMUs are told."""
    kept: Kept | None = None


class Master:
    """Runs blocks that are instantiated and not yet initialized; again, once they are reset."""

    def __init__(
        self, blocks: Mapping[str, Block], circuit: Circuit, columns: Sequence[Node], observed: Sequence[Node] = ()
    ) -> None:
        """`columns` are the elements that are recorded, `observed` those that observers are shown."""
        self.blocks, self.circuit, self.columns, self.observed = blocks, circuit, list(columns), list(observed)
        self._bus: Bus | None = None

    def run(
        self,
        starts: Mapping[str, Sequence[Start]],
        observers: Sequence[Observer] = (),
        options: Options = Options(),
    ) -> Recording:
        """Initializes and runs. A failing block or Ctrl-C ends the run, and the recording says so."""
        circuit = self.circuit
        recording, observation = self._recording(), Observation(self.observed, circuit.clock, observers, options.soon)
        rows = 0
        try:
            kept = options.kept
            if kept is None:
                initialize(self.blocks, starts, circuit)
            if self._bus is None:
                self._bus = lay_out(self.blocks, circuit, self.columns, self.observed)
            bus = self._bus
            bus.values.fill(0.0)
            if kept is not None:
                kept.restore()
            self._leave(bus, kept is None)
            bus.values.take(bus.columns, 0, recording.values[0], "clip")
            bus.values.take(bus.observed, 0, observation.rows[0], "clip")
            rows = 1
            loop: CompiledLoop | PythonLoop | None = None
            if options.compiled and options.pacer is None and kept is None:
                loop = compiled_loop(bus, circuit, observation, recording)
            begun = observation.first = 0 if kept is None else kept.count
            loop = loop or PythonLoop(bus, circuit, observation, recording, options.pacer, begun)
            _drive(loop, circuit, recording, options)
            self._record_end(bus, recording)
        except Abandoned:
            pass  # the recording says that it was interrupted
        except BlockError as error:
            recording.failure = error
        if rows:
            rows += recording.steps // circuit.clock.interval + recording.extra
            observation.flush(recording.steps)
        recording.time, recording.values = recording.time[:rows], recording.values[:rows]
        return recording

    def _recording(self) -> Recording:
        clock = self.circuit.clock
        shape = clock.samples, len(self.columns)
        try:
            return Recording(clock.sample_times(), np.empty(shape), self.columns)
        except (MemoryError, ValueError):
            size = shape[0] * shape[1] * 8 / 1e9
            message = f"the recording would take {size:.3g} GB; remedy: a longer record.interval, or fewer signals"
            raise InputError(message) from None

    def _leave(self, bus: Bus, leaves: bool) -> None:
        """Leaves initialization mode, if need be, and fetches the outputs of the start."""
        for seat in bus.seats if leaves else ():
            seat.block.leave()
        with np.errstate(over="ignore"):
            for seat in bus.seats:
                seat.block.get_all()
                check_finite(seat)

    def _record_end(self, bus: Bus, recording: Recording) -> None:
        """Records where the run has ended, if that is between two samples."""
        clock, count = self.circuit.clock, recording.steps
        if count % clock.interval == 0:
            return
        time = clock.time(count)
        for seat in bus.seats:
            try:
                seat.block.get_all()
            except BlockError as error:
                error.time = time
                raise
            check_finite(seat, time)
        row = count // clock.interval + 1
        recording.time = np.append(recording.time[:row], time)
        bus.values.take(bus.columns, 0, recording.values[row], "clip")
        recording.extra = True


def _drive(loop: CompiledLoop | PythonLoop, circuit: Circuit, recording: Recording, options: Options) -> None:
    """Runs a loop to the end, to Ctrl-C or to a failure.

    It goes in stretches short enough to report the progress, to show the observers what they wait for, and to make the
    changes of blocks that are due between two steps.
    """
    clock, progress, stretch = circuit.clock, options.progress, 1
    end = clock.steps if options.until is None else options.until
    changes = Changes(circuit, [seat.block for seat in loop.bus.seats])

    def report(count: int) -> None:
        if progress is not None:
            progress(clock.time(count))

    begun = reported = perf_counter()
    with interruptible() as interrupted:
        try:
            if options.pacer is not None:
                options.pacer.begin(clock, interrupted, report)
            while loop.count < end and not interrupted:
                changes.make(loop.count)
                until = min(loop.count + stretch, end, loop.observation.room(loop.count), changes.next)
                loop.advance(int(until), interrupted)
                now = perf_counter()
                if now - reported < _REPORT_EVERY / 2:
                    stretch *= 2
                    continue
                if now - reported > 2 * _REPORT_EVERY:
                    stretch = max(stretch // 2, 1)
                reported = now
                report(loop.count)
        finally:
            recording.steps, recording.wall = loop.count, perf_counter() - begun
            recording.interrupted = interrupted[0] if interrupted else 0
