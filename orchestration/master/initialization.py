"""Initialization: start values, and outputs to inputs in the order in which they depend on each other."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ..fmu.model import Element
from ..instances.block import Block
from ..system.starts import Start
from ..system.wiring import Node
from .circuit import Circuit
from .injection import at_start
from .recording import not_finite


def initialize(
    blocks: Mapping[str, Block],
    starts: Mapping[str, Sequence[Start]],
    circuit: Circuit,
) -> None:
    """Sets starts, then takes outputs to inputs in the order in which they depend on each other."""
    for name, block in blocks.items():
        block.set((start.element, start.value) for start in starts.get(name, ()))
    for block in blocks.values():
        block.enter(circuit.clock.time(circuit.clock.steps))
    feeds: dict[Node, list[tuple[Node, float, float]]] = {}
    for link in circuit.wiring.links:
        if not link.delayed:
            for source, target in zip(link.source, link.target, strict=True):
                feeds.setdefault(source, []).append((target, link.factor, link.offset))
    for level in circuit.order.levels:
        incoming: dict[str, list[tuple[Element, float]]] = {}
        for name, block in blocks.items():
            nodes = [node for node in level if node.block == name]
            values = block.get([node.element for node in nodes]) if nodes else []
            for node, value in zip(nodes, values, strict=True):
                if not math.isfinite(value):
                    raise not_finite(block, node.element, value)
                for target, factor, offset in feeds.get(node, ()):
                    given = at_start(circuit.faults, target, factor * value + offset)
                    incoming.setdefault(target.block, []).append((target.element, given))
        for name, pairs in incoming.items():
            blocks[name].set(pairs)
