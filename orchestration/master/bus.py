"""The bus: one array that holds all values that pass between blocks and all that are recorded.

Each block writes its outputs into its own stretch of it, and its inputs are gathered from all over it.
At its end stand the values of the step before, for connections that pass them with a delay.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from ..fmu.model import TYPES, Element, Floats
from ..instances.block import Block
from ..system.wiring import Node, Wiring
from .circuit import Circuit


@dataclass
class Inputs:
    """Sources of a block's inputs: `values = bus[sources] * factors + offsets`."""

    sources: NDArray[np.intp]
    factors: Floats | None
    """None, and so for offsets, where no unit changes."""
    offsets: Floats | None
    values: Floats
    """The array that the block hands over at its next Set."""
    elements: list[Element]

    def gatherer(self, bus: Floats) -> Callable[[], object]:
        """A function that takes the inputs from the bus."""
        if not len(self.sources):
            return lambda: None
        take, sources, values, factors, offsets = bus.take, self.sources, self.values, self.factors, self.offsets
        first, n = sources[0], len(sources)
        if factors is None and np.array_equal(sources, np.arange(first, first + n)):
            return partial(values.data.__setitem__, slice(None), bus[first : first + n].data)

        gather = partial(take, sources, 0, values, "clip")  # the places are in range; other modes copy once more
        if factors is None or offsets is None:
            return gather

        def gather_and_convert() -> None:
            gather()
            np.multiply(values, factors, out=values)
            np.add(values, offsets, out=values)

        return gather_and_convert


@dataclass
class Seat:
    """A block with its place on the bus."""

    block: Block
    outputs: list[Element]
    view: Floats
    """Its outputs on the bus."""
    inputs: Inputs
    gather: Callable[[], object]
    """Takes its inputs from the bus."""


@dataclass
class Delay:
    """Values of the step before: `bus[first:first + len(sources)] = bus[sources]` at the start of each step."""

    sources: NDArray[np.intp]
    first: int

    def keeper(self, bus: Floats) -> Callable[[], None]:
        """A function that keeps the values."""
        sources, held = self.sources, bus[self.first :]

        def keep() -> None:
            bus.take(sources, 0, held, "clip")

        return keep


@dataclass
class Bus:
    values: Floats
    seats: list[Seat]
    """In the order in which they are stepped."""
    columns: NDArray[np.intp]
    """Where the recorded elements lie."""
    observed: NDArray[np.intp]
    """Where those lie that are looked at after every base step."""
    delay: Delay | None
    """None where no connection is delayed."""


@dataclass
class _Layout:
    blocks: Mapping[str, Block]
    wiring: Wiring
    columns: Sequence[Node]
    """What is recorded."""
    live: set[Node]
    """What is fetched after every step: what other blocks need, or is observed."""
    place: dict[Node, int] = field(default_factory=dict)
    held: dict[Node, int] = field(default_factory=dict)

    @cached_property
    def recorded(self) -> dict[str, dict[Element, bool]]:
        """All that is fetched of each block, and whether it is live."""
        found: dict[str, dict[Element, bool]] = {name: {} for name in self.blocks}
        for node in self.columns:
            found[node.block][node.element] = False
        for node in self.live:
            found[node.block][node.element] = True
        return found

    def rank(self, name: str, element: Element) -> tuple[int, int, Element]:
        """By type, then in the order of value references.

        So one call exchanges a stretch of an FMU's variables, and what a block takes from another mostly lies side by
        side.
        """
        variable = self.blocks[name].model.variables[element.variable]
        reference = variable.references[0 if variable.is_array else element.position]
        return TYPES.index(variable.type), reference, element

    def outputs(self, name: str) -> list[Element]:
        """All that is fetched of a block: within a type what others need first."""
        live = self.recorded[name]

        def order(element: Element) -> tuple[int, bool, int, Element]:
            kind, reference, same = self.rank(name, element)
            return kind, not live[element], reference, same

        return sorted(live, key=order)

    def inputs(self, name: str) -> list[tuple[Element, int, float, float]]:
        """Each connected input of a block: its source on the bus, factor and offset."""
        fed = [
            (target.element, (self.held if link.delayed else self.place)[source], link.factor, link.offset)
            for link in self.wiring.links
            if link.target[0].block == name
            for source, target in zip(link.source, link.target, strict=True)
        ]
        return sorted(fed, key=lambda entry: self.rank(name, entry[0]))


def lay_out(
    blocks: Mapping[str, Block], circuit: Circuit, columns: Sequence[Node], observed: Sequence[Node] = ()
) -> Bus:
    """Gives every value its place and wires the blocks to it. `observed` are fetched after every step."""
    wiring = circuit.wiring
    layout = _Layout(blocks, wiring, columns, {node for link in wiring.links for node in link.source} | set(observed))
    outputs = {name: layout.outputs(name) for name in blocks}
    for name, elements in outputs.items():
        for element in elements:
            layout.place[Node(name, element)] = len(layout.place)
    delayed = list(dict.fromkeys(node for link in wiring.links if link.delayed for node in link.source))
    first_held = len(layout.place)
    layout.held.update((node, first_held + i) for i, node in enumerate(delayed))
    values = np.zeros(first_held + len(delayed))
    seats = [_seat(layout, name, outputs[name], values) for name in circuit.order.blocks]
    delay = Delay(np.array([layout.place[node] for node in delayed], np.intp), first_held) if delayed else None
    recorded, seen = (np.array([layout.place[node] for node in nodes], np.intp) for nodes in (columns, observed))
    return Bus(values, seats, recorded, seen, delay)


def _seat(layout: _Layout, name: str, outputs: list[Element], values: Floats) -> Seat:
    first = layout.place[Node(name, outputs[0])] if outputs else 0
    view = values[first : first + len(outputs)]
    inputs = layout.inputs(name)
    needed = Counter(TYPES[layout.rank(name, element)[0]] for element, live in layout.recorded[name].items() if live)
    live = [needed[kind] for kind in TYPES]
    buffer = layout.blocks[name].wire([element for element, *_ in inputs], outputs, live, view)
    factors = np.array([factor for _, _, factor, _ in inputs])
    offsets = np.array([offset for _, _, _, offset in inputs])
    converts = bool((factors != 1.0).any() or offsets.any())
    gathered = Inputs(
        np.array([place for _, place, _, _ in inputs], np.intp),
        factors if converts else None,
        offsets if converts else None,
        buffer,
        [element for element, *_ in inputs],
    )
    return Seat(layout.blocks[name], outputs, view, gathered, gathered.gatherer(values))
