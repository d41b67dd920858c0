"""The master: initialization and the step loop, on any blocks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from ..errors import BlockError, InputError
from ..instances.block import Block
from ..interrupt import Abandoned, interruptible
from ..system.clock import Clock
from ..system.faults import Faults
from ..system.order import Order
from ..system.starts import Start
from ..system.wiring import Node, Wiring
from .bus import Bus, lay_out
from .compiled import compiled_loop
from .initialization import initialize
from .injection import Changes, with_faults
from .pacing import Pacer
from .recording import REPORT_EVERY, Progress, Recording, Watch, check_finite
from .steps import Steps


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
            initialize(self.blocks, starts, self.wiring, self.order, self.faults, self.clock.time(self.clock.steps))
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
        steps = Steps(bus, self.clock, self.every, self.pacer)
        sound = steps.parallel if self.parallel else steps.sequential
        if not self.faults:
            return sound()
        return with_faults(self.faults, bus, self.every, self.parallel, self.clock, sound)
