"""The master: initialization and the step loop, on any blocks.

All values that pass between blocks and all that are recorded lie in one array, the bus: each block
writes its outputs into its own stretch, and its inputs are gathered from all over it. So a step of a
block is one gathering, one Set, one doStep and one Get.

Sequential exchange: in each base step the blocks are stepped one after the other, and each sees what
those before it have just given. Parallel exchange: all inputs are set from the values at the step's
start, then all blocks are stepped. Get is never called between Set and doStep.

A block with `every: N` is stepped when N base steps have passed, over all of them, with the inputs of
that moment.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from .block import TYPES, Block, Floats
from .clock import Clock
from .errors import BlockError, InputError
from .interrupt import interruptible
from .model import Element
from .order import Order
from .starts import Start
from .wiring import Node, Wiring

Progress = Callable[[float], None]
"""Called now and then with the simulated time."""

REPORT_EVERY = 0.05
"""Seconds of wall time from one report of the progress to the next, at least."""


@dataclass
class Recording:
    """What was recorded, up to the end or to whatever ended the run."""

    time: Floats
    values: Floats
    """A row for each sample, a column for each recorded element."""
    columns: list[Node]
    steps: int = 0
    wall: float = 0.0
    """Seconds that the loop took."""
    failure: BlockError | None = None
    interrupted: bool = False


@dataclass
class _Seat:
    """A block with its place on the bus."""

    block: Block
    every: int
    step: float
    outputs: list[Element]
    view: Floats
    """Its outputs on the bus."""
    gather: Callable[[], None] = lambda: None


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

    def run(self, starts: Mapping[str, Sequence[Start]], progress: Progress | None = None) -> Recording:
        """Initializes and runs. A failing block or Ctrl-C ends the run, and the recording says so."""
        try:
            values = np.empty((self.clock.samples, len(self.columns)))
        except (MemoryError, ValueError):
            size = self.clock.samples * len(self.columns) * 8 / 1e9
            raise InputError(f"the recording would take {size:.3g} GB; remedy: a longer record.interval, or fewer signals") from None
        recording = Recording(self.clock.sample_times(), values, list(self.columns))
        rows = 0
        try:
            self._initialize(starts)
            self._wire()
            self._record(recording, 0)
            rows = 1
            self._loop(recording, progress)
        except BlockError as error:
            recording.failure = error
        if rows:
            rows += recording.steps // self.clock.interval
        recording.time, recording.values = recording.time[:rows], recording.values[:rows]
        return recording

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
                        raise self._not_finite(block, node.element, value)
                    for target, factor, offset in feeds.get(node, ()):
                        incoming.setdefault(target.block, []).append((target.element, factor * value + offset))
            for name, pairs in incoming.items():
                self.blocks[name].set(pairs)

    # ------------------------------------------------------------ the bus

    def _wire(self) -> None:
        """Lays out the bus, leaves initialization and fetches the outputs at 0."""
        live = {node for link in self.wiring.links for node in link.source}
        outputs = {name: self._outputs(name, live) for name in self.blocks}
        address: dict[Node, int] = {}
        for name, elements in outputs.items():
            for element in elements:
                address[Node(name, element)] = len(address)
        delayed = [node for link in self.wiring.links if link.delayed for node in link.source]
        self._bus = bus = np.zeros(len(address) + len(delayed))
        held = {node: len(address) + i for i, node in enumerate(delayed)}
        self._seats: list[_Seat] = []
        for name in self.order.blocks:
            block, elements = self.blocks[name], outputs[name]
            first = address[Node(name, elements[0])] if elements else 0
            view = bus[first : first + len(elements)]
            every = self.every.get(name, 1)
            seat = _Seat(block, every, every * self.clock.step, elements, view)
            self._seats.append(seat)
            inputs = self._inputs(name, address, held)
            counts = [sum(Node(name, e) in live for e in elements if _type(block, e) == kind) for kind in TYPES]
            buffer = block.wire([element for element, *_ in inputs], elements, counts, view)
            seat.gather = _gather(bus, inputs, buffer)
        for seat in self._seats:
            seat.block.leave()
        for seat in self._seats:
            seat.block.get_all()
            self._check(seat)
        self._columns = np.array([address[node] for node in self.columns], np.intp)
        self._delay = _delay(bus, [address[node] for node in delayed], len(address)) if delayed else None

    def _outputs(self, name: str, live: set[Node]) -> list[Element]:
        """All that is fetched of a block: by type, and within a type what others need first."""
        wanted = {node.element for node in [*live, *self.columns] if node.block == name}
        block = self.blocks[name]
        return sorted(wanted, key=lambda e: (TYPES.index(_type(block, e)), Node(name, e) not in live, e))

    def _inputs(
        self, name: str, address: Mapping[Node, int], held: Mapping[Node, int]
    ) -> list[tuple[Element, int, float, float]]:
        """Each connected input of a block: its source on the bus, factor and offset."""
        found = [
            (target.element, (held if link.delayed else address)[source], link.factor, link.offset)
            for link in self.wiring.links
            for source, target in zip(link.source, link.target, strict=True)
            if target.block == name
        ]
        return sorted(found, key=lambda entry: (TYPES.index(_type(self.blocks[name], entry[0])), entry[0]))

    # ------------------------------------------------------------ the loop

    def _loop(self, recording: Recording, progress: Progress | None) -> None:
        clock, count, delay = self.clock, 0, self._delay
        advance = self._parallel_step() if self.parallel else self._sequential_step()
        steps, interval, columns, bus, values = clock.steps, clock.interval, self._columns, self._bus, recording.values
        numerator, denominator = clock.numerator, clock.denominator
        begun = perf_counter()
        due = begun + REPORT_EVERY
        with interruptible() as interrupted:
            try:
                while count < steps and not interrupted:
                    if delay is not None:
                        delay()
                    advance(count + 1)
                    count += 1
                    if count % interval == 0:
                        bus.take(columns, 0, values[count // interval], "clip")
                    if progress is not None and perf_counter() > due:
                        progress(count * numerator / denominator)
                        due = perf_counter() + REPORT_EVERY
            finally:
                recording.steps, recording.wall = count, perf_counter() - begun
                recording.interrupted = bool(interrupted)

    def _sequential_step(self) -> Callable[[int], None]:
        """One base step, up to the given count: block after block."""
        interval = self.clock.interval
        numerator, denominator = self.clock.numerator, self.clock.denominator
        plan = [
            (s, s.every, s.step, s.gather, s.block.set_inputs, s.block.do_step, s.block.get_live, s.block.get_all, s.view)
            for s in self._seats
        ]
        isfinite = math.isfinite

        def advance(count: int) -> None:
            everything = count % interval == 0
            for seat, every, step, gather, set_inputs, do_step, get_live, get_all, view in plan:
                if every > 1 and count % every:
                    continue
                try:
                    gather()
                    set_inputs()
                    do_step((count - every) * numerator / denominator, step)
                    if everything or every > 1:
                        get_all()
                    else:
                        get_live()
                except BlockError as error:
                    error.time = self.clock.time(count - every)
                    raise
                if not isfinite(view.dot(view)):
                    self._check(seat, count)

        return advance

    def _parallel_step(self) -> Callable[[int], None]:
        """One base step, up to the given count: all inputs from the step's start, then all blocks."""
        seats, interval = self._seats, self.clock.interval

        def advance(count: int) -> None:
            active = [seat for seat in seats if count % seat.every == 0]
            try:
                for seat in active:
                    seat.gather()
                    seat.block.set_inputs()
                for seat in active:
                    seat.block.do_step(self.clock.time(count - seat.every), seat.step)
                for seat in active:
                    if count % interval == 0 or seat.every > 1:
                        seat.block.get_all()
                    else:
                        seat.block.get_live()
            except BlockError as error:
                error.time = self.clock.time(count - 1)
                raise
            for seat in active:
                if not math.isfinite(seat.view.dot(seat.view)):
                    self._check(seat, count)

        return advance

    # ------------------------------------------------------------ checks and records

    def _record(self, recording: Recording, row: int) -> None:
        self._bus.take(self._columns, 0, recording.values[row], "clip")

    def _check(self, seat: _Seat, count: int | None = None) -> None:
        """Raises BlockError where an output is not finite."""
        for element, value in zip(seat.outputs, seat.view, strict=True):
            if not math.isfinite(value):
                raise self._not_finite(seat.block, element, value, None if count is None else self.clock.time(count))

    @staticmethod
    def _not_finite(block: Block, element: Element, value: float, time: float | None = None) -> BlockError:
        name = block.model.variables[element.variable].label(element.position)
        return BlockError(block.name, f"output {name}", f"is {value}, expected a finite number", time, getattr(block, "log", ()))


def _type(block: Block, element: Element) -> str:
    return block.model.variables[element.variable].type


def _gather(bus: Floats, inputs: Sequence[tuple[Element, int, float, float]], into: Floats) -> Callable[[], None]:
    """What takes a block's inputs from the bus into its own array, with the change of unit."""
    if not inputs:
        return lambda: None
    places = np.array([place for _, place, _, _ in inputs], np.intp)
    factors = np.array([factor for _, _, factor, _ in inputs])
    offsets = np.array([offset for _, _, _, offset in inputs])
    take = bus.take

    def gather() -> None:
        take(places, 0, into, "clip")

    def gather_and_convert() -> None:
        take(places, 0, into, "clip")
        np.multiply(into, factors, out=into)
        np.add(into, offsets, out=into)

    return gather if (factors == 1.0).all() and not offsets.any() else gather_and_convert


def _delay(bus: Floats, places: Sequence[int], first: int) -> Callable[[], None]:
    """What keeps the values of the step before for delayed connections, at the bus's end."""
    sources, held = np.array(places, np.intp), bus[first:]

    def delay() -> None:
        bus.take(sources, 0, held, "clip")

    return delay
