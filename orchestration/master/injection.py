"""Brings a scenario's faults and its timeline into the step loops: what a block is set to, and what its inputs are
given."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from ..errors import BlockError
from ..fmu.model import Element
from ..instances.block import Block
from ..system.disturbances import Disturbance
from ..system.faults import Faults, Setting
from ..system.wiring import Node
from .bus import Seat
from .circuit import Circuit


def at_start(faults: Faults, target: Node, value: float) -> float:
    """Returns what an input is given at 0 instead of `value`."""
    for fault in faults.disturbances:
        if fault.target == target and fault.span[0] == 0 and not fault.delayed:
            value = _disturbed(fault, value)
    return value


class Changes:
    """The values that blocks are set to between two steps, in the order of their times."""

    def __init__(self, circuit: Circuit, blocks: Iterable[Block]) -> None:
        held = {block.name: _Held(block) for block in blocks}
        settings = circuit.faults.settings
        changes = [change for s in settings for change in _changes(s, held[s.block], circuit.rate(s.block))]
        self._left = sorted(changes, key=lambda change: change.due)
        self._clock = circuit.clock

    def make(self, count: int) -> None:
        """Makes those that are due once `count` base steps are done. Raises BlockError."""
        while self._left and self._left[0].due <= count:
            change = self._left.pop(0)
            try:
                change.make()
            except BlockError as error:
                error.time = self._clock.time(change.due)
                raise

    @property
    def next(self) -> float:
        """Number of base steps that are done when the next one is due."""
        return self._left[0].due if self._left else math.inf


@dataclass(frozen=True)
class _Change:
    due: int
    """It is made once so many base steps are done."""
    make: Callable[[], None]


class _Held:
    """Values to which a block is set: the values of the timeline, and over them those of the faults that act, the
    latest on top.
    """

    def __init__(self, block: Block) -> None:
        self._block = block
        self._below: dict[Element, Any] = {}
        """The value without fault of each element at fault."""
        self._faults: dict[Element, dict[Setting, Any]] = {}
        """The values of the faults that act, in the order in which they began."""

    def give(self, setting: Setting) -> None:
        """A value of the timeline, which waits for the end of a fault that acts."""
        self._below |= {element: value for element, value in setting.values if self._faults.get(element)}
        if free := [pair for pair in setting.values if not self._faults.get(pair[0])]:
            self._block.set(free)

    def begin(self, setting: Setting) -> None:
        if setting.span[1] < math.inf:
            sound = [element for element, _ in setting.values if not self._faults.get(element)]
            self._below |= zip(sound, self._block.get(sound), strict=True)
        for element, value in setting.values:
            self._faults.setdefault(element, {})[setting] = value
        self._block.set(setting.values)

    def end(self, setting: Setting) -> None:
        for element, _ in setting.values:
            del self._faults[element][setting]
        self._block.set([(element, self._now(element)) for element, _ in setting.values])

    def _now(self, element: Element) -> Any:
        acting = self._faults[element]
        return next(reversed(acting.values())) if acting else self._below[element]


def _changes(setting: Setting, held: _Held, every: int) -> Iterable[_Change]:
    """A setting, and the end of a fault; between two steps of the block."""
    begin, end = (math.ceil(count / every) * every if count < math.inf else count for count in setting.span)
    yield _Change(int(begin), partial(held.begin if setting.of_fault else held.give, setting))
    if end < math.inf:
        yield _Change(int(end), partial(held.end, setting))


def gatherer(
    seat: Seat, circuit: Circuit, places: Mapping[str, int], making: Callable[[], int]
) -> Callable[[], object]:
    """Returns the function that takes a block's inputs from the bus, with the faults that act on them.

    `places` are those of the blocks in the order of their steps; `making` returns the base step that is being made.
    """
    gather, values, elements = seat.gather, seat.inputs.values, seat.inputs.elements
    acting = [
        (fault, elements.index(fault.target.element), fault.behind(circuit.parallel, places))
        for fault in circuit.faults.disturbances
        if fault.target.block == seat.block.name
    ]
    frozen: dict[int, float] = {}

    def gather_with_faults() -> None:
        gather()
        for number, (fault, place, behind) in enumerate(acting):
            first, last = fault.span
            if first <= making() - behind < last:
                if fault.kind == "freeze":
                    values[place] = frozen.setdefault(number, float(values[place]))
                else:
                    values[place] = _disturbed(fault, float(values[place]))

    return gather_with_faults if acting else gather


def _disturbed(fault: Disturbance, value: float) -> float:
    return {"cut": fault.value, "bias": value + fault.value}.get(fault.kind, value)
