"""The step loop in C: loop.c, compiled once for this machine, on the arrays of the loop in Python.

It takes over where every block is an FMU in this process; both loops give the same bits.
"""

from __future__ import annotations

import ctypes as c
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ..fmu.types import CODES
from ..instances.calls import Exchange
from ..instances.compilation import FMI_HEADERS, compiled
from ..instances.guest import CALLS, TRACE, Guest
from ..instances.slave import Slave
from ..system.clock import EXACT
from ..system.disturbances import KINDS
from .bus import Bus
from .circuit import Circuit
from .layout import CDisturbance, CExchange, CGuest, CLoop, CPart, CSeat, Pointer
from .recording import Observation, Recording, check_finite

_SOURCE = Path(__file__).with_name("loop.c")
_SET, _STEP, _GET = range(3)


def compiled_loop(bus: Bus, circuit: Circuit, observation: Observation, recording: Recording) -> CompiledLoop | None:
    """Returns the loop in C; None where a block is no FMU in this process, or loop.c cannot be compiled here."""
    slaves = [seat.block for seat in bus.seats if isinstance(seat.block, Slave)]
    clock = circuit.clock
    exact = clock.steps * clock.numerator < EXACT and clock.denominator < EXACT
    if len(slaves) != len(bus.seats) or not exact or (library := _library()) is None:
        return None
    return CompiledLoop(library, bus, slaves, circuit, observation, recording)


class CompiledLoop:
    """A loop in C over blocks that are initialized and wired."""

    def __init__(
        self,
        library: c.CDLL,
        bus: Bus,
        slaves: Sequence[Slave],
        circuit: Circuit,
        observation: Observation,
        recording: Recording,
    ) -> None:
        self.bus, self.observation = bus, observation
        self._clock, self._slaves, self._run = circuit.clock, slaves, library.run_loop
        self._kept: list[Any] = []  # what C has pointers to
        self._guests: list[tuple[Guest, CGuest]] = []
        clock = circuit.clock
        seats = (CSeat * len(slaves))()
        for into, seat, slave in zip(seats, bus.seats, slaves, strict=True):
            every = circuit.rate(slave.name)
            into.component = slave.component
            into.do_step, into.version = c.cast(slave.step_function, Pointer), int(slave.model.fmi[0])
            into.every, into.step = every, every * clock.numerator / clock.denominator
            into.sources, into.input_count = self._whole(seat.inputs.sources), len(seat.inputs.sources)
            into.factors, into.offsets = self._floats(seat.inputs.factors), self._floats(seat.inputs.offsets)
            into.inputs = self._floats(seat.inputs.values)
            into.setters, into.setter_count = self._exchanges(slave.setters), len(slave.setters)
            into.getters, into.getter_count = self._exchanges(slave.getters), len(slave.getters)
            into.outputs, into.output_count = self._floats(seat.view), len(seat.view)
            if isinstance(slave, Guest):
                into.guest = c.pointer(self._guest(slave))
        loop = self._loop = CLoop(seats, len(seats), circuit.parallel, self._floats(bus.values))
        if bus.delay is not None:
            loop.delayed, loop.delayed_count = self._whole(bus.delay.sources), len(bus.delay.sources)
            loop.held = self._floats(bus.values[bus.delay.first :])
        loop.columns, loop.column_count = self._whole(bus.columns), len(bus.columns)
        loop.rows, loop.interval = self._floats(recording.values), clock.interval
        loop.observed, loop.observed_count = self._whole(bus.observed), len(bus.observed)
        loop.observed_rows = self._floats(observation.rows)
        loop.numerator, loop.denominator = clock.numerator, clock.denominator
        self._kept.append(seats)
        self._disturb(circuit)

    def _guest(self, slave: Guest) -> CGuest:
        """Returns the place of an FMU of others in the trace."""
        guest = CGuest.from_buffer(TRACE.page, TRACE.place(slave.name, slave.model.prefix, self._clock.step))
        if (around := slave.around).watches:
            guest.get_round, guest.set_round = c.cast(around.get_round, Pointer), c.cast(around.set_round, Pointer)
            guest.mode = around.mode
        self._guests.append((slave, guest))
        return guest

    def _note(self) -> None:
        """Notes the guests that have left another rounding mode."""
        for slave, guest in self._guests:
            for call, turned in zip(CALLS, guest.turned, strict=True):
                if turned:
                    slave.around.note(slave.name, f"{slave.model.prefix}{call}", "the rounding mode")

    def _disturb(self, circuit: Circuit) -> None:
        """Takes up the faults of signals."""
        seats, loop, disturbances = self.bus.seats, self._loop, circuit.faults.disturbances
        places = {seat.block.name: place for place, seat in enumerate(seats)}
        array = (CDisturbance * len(disturbances))()
        for into, fault in zip(array, disturbances, strict=True):
            first, last = fault.span
            into.first, into.last = first, int(min(last, self._clock.steps + 1))
            into.behind, into.value = fault.behind(bool(loop.parallel), places), fault.value
            into.seat = places[fault.target.block]
            into.place = seats[into.seat].inputs.elements.index(fault.target.element)
            into.kind, into.acts = KINDS.index(fault.kind), True
        loop.disturbances, loop.disturbance_count = array, len(array)
        self._kept.append(array)

    def _exchanges(self, exchanges: Sequence[Exchange]) -> Any:
        array = (CExchange * len(exchanges))()
        for into, exchange in zip(array, exchanges, strict=True):
            into.function = c.cast(exchange.function, Pointer)
            into.references = exchange.references.ctypes.data
            into.values, into.buffer = exchange.values.ctypes.data, exchange.buffer.ctypes.data
            into.places = None if exchange.direct else exchange.places.ctypes.data
            into.slots, into.type = exchange.slots.ctypes.data, CODES.index(exchange.native.code)
            into.low, into.beyond = exchange.native.bounds
            into.live, into.all = CPart(*exchange.live), CPart(*exchange.all)
        self._kept += [array, exchanges]
        return array

    def _floats(self, array: Any) -> int | None:
        self._kept.append(array)
        return None if array is None else array.ctypes.data

    def _whole(self, array: Any) -> int:
        whole = array.astype(np.int64)
        self._kept.append(whole)
        return whole.ctypes.data

    @property
    def count(self) -> int:
        """Returns how many base steps are done."""
        return int(self._loop.count)

    def advance(self, until: int, interrupted: Sequence[int]) -> None:
        """Makes the base steps up to `until`, whatever interrupts it meanwhile. Raises BlockError."""
        self._loop.observed_first = self.observation.first
        failed = self._run(c.byref(self._loop), until)
        if self._guests:
            self._note()
        if failed:
            self._fail()

    def _fail(self) -> None:
        """Raises the BlockError that the loop in Python raises at the same place."""
        loop = self._loop
        slave, seat = self._slaves[loop.seat], self.bus.seats[loop.seat]
        if loop.call in (_SET, _STEP, _GET):
            exchanges = slave.setters if loop.call == _SET else slave.getters
            name = f"{slave.model.prefix}DoStep" if loop.call == _STEP else exchanges[loop.part].name
            error = slave.failed(name, loop.status)
            error.time = self._clock.time(loop.begun)
            raise error
        check_finite(seat, self._clock.time(loop.count + 1))


@cache
def _library() -> c.CDLL | None:
    """loop.c as a library of this machine; None without a compiler."""
    try:
        library = c.CDLL(str(compiled("loop", _SOURCE, [_SOURCE.with_suffix(".h"), FMI_HEADERS / "fmi2.h"])))
    except (RuntimeError, OSError):  # no compiler, or no folder to write to: the loop in Python will do
        return None
    library.run_loop.argtypes = (c.POINTER(CLoop), c.c_int64)
    return library
