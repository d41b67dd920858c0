"""Lists the ports of a loop that something is connected to: variables, or the part that one connection group feeds.

Tests: tests/orchestration/acceptance/test_polarity.py.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...fmu.model import Element, Floats, Model, Variable
from ...quantities import ONE, Unit
from ...system.wiring import Link, Node, Wiring

ROTATION_TOLERANCE = 1e-3
"""How far R^T R may be from the identity for a matrix that is taken to be a rotation: noise of sensors is less."""


@dataclass(frozen=True)
class Port:
    """Elements of one variable that come from one variable, or that go out to others."""

    block: str
    variable: str
    causality: str
    """Of an input one block reads it wrongly; of an output all receivers are given it wrongly."""
    positions: tuple[int, ...]
    kind: str
    """scalar, vector, rotation, quaternion, elements, flag or other."""
    unit: Unit
    size: int
    """Elements of the whole variable."""

    @property
    def name(self) -> str:
        return f"{self.block}.{self.label}"

    @property
    def label(self) -> str:
        if len(self.positions) == self.size:
            return self.variable
        first, last = self.positions[0] + 1, self.positions[-1] + 1
        return f"{self.variable}[{first}]" if first == last else f"{self.variable}[{first}..{last}]"

    @property
    def elements(self) -> tuple[Element, ...]:
        return tuple(Element(self.variable, position) for position in self.positions)

    @property
    def nodes(self) -> tuple[Node, ...]:
        return tuple(Node(self.block, element) for element in self.elements)


def ports(
    models: Mapping[str, Model], wiring: Wiring, signals: Mapping[Node, Floats], blocks: Iterable[str] | None = None
) -> list[Port]:
    """Returns inputs, group by group, and outputs that are connected. `signals` (samples,) tell what is a rotation."""
    groups: dict[tuple[str, str, str, str], list[tuple[Node, Node]]] = {}
    outputs: dict[tuple[str, str], dict[Node, None]] = {}
    for link in wiring.links:
        for source, target in zip(link.source, link.target, strict=True):
            key = (target.block, target.element.variable, source.block, source.element.variable)
            groups.setdefault(key, []).append((source, target))
            outputs.setdefault((source.block, source.element.variable), {})[source] = None
    made = []
    for (block, name, *_), pairs in groups.items():
        pairs.sort(key=lambda pair: pair[1].element.position)
        positions = [target.element.position for _, target in pairs]
        given = [signals[source] for source, _ in pairs]
        made.append(_port(block, models[block].variables[name], "input", positions, given))
    for (block, name), nodes in outputs.items():
        positions = sorted(node.element.position for node in nodes)
        given = [signals[Node(block, Element(name, position))] for position in positions]
        made.append(_port(block, models[block].variables[name], "output", positions, given))
    order = list(models)
    made.sort(key=lambda port: (order.index(port.block), port.causality))
    wanted = set(order if blocks is None else blocks)
    return [port for port in made if port.block in wanted]


def _port(block: str, variable: Variable, causality: str, positions: list[int], given: Sequence[Floats]) -> Port:
    unit = variable.at(positions).unit or ONE
    kind = kind_of(variable, positions, np.array(given).T)
    return Port(block, variable.name, causality, tuple(positions), kind, unit, variable.size)


def kind_of(variable: Variable, positions: Sequence[int], values: Floats) -> str:
    """Returns the kind of a group of elements, by its shape and by its values (samples, elements) in a run."""
    if variable.type == "boolean":
        return "flag"
    if variable.type != "real":
        return "other"
    if len(positions) == 9 and variable.shape == (3, 3) and _is_rotation(values.reshape(-1, 3, 3)):
        return "rotation"
    if len(positions) == 4 and np.allclose((values * values).sum(axis=1), 1.0, atol=ROTATION_TOLERANCE):
        return "quaternion"
    return {1: "scalar", 3: "vector"}.get(len(positions), "elements")


def _is_rotation(values: Floats) -> bool:
    close = np.abs(np.einsum("nji,njk->nik", values, values) - np.eye(3)).max() < ROTATION_TOLERANCE
    return bool(close and np.linalg.det(values).min() > 0.0)


def miswired(wiring: Wiring, port: Port, matrix: Floats, offset: float = 0.0) -> Wiring:
    """Returns the wiring with a port's elements as a matrix with one entry a row says: given' = M given + c.

    At an input that of the connection, at an output those of all connections from it. Both are in their own unit.
    """
    place = {node: i for i, node in enumerate(port.nodes)}
    fed = {t: (s, link) for link in wiring.links for s, t in zip(link.source, link.target, strict=True)}
    links: list[Link] = []
    for link in wiring.links:
        ends = link.target if port.causality == "input" else link.source
        if not any(node in place for node in ends):
            links.append(link)
            continue
        for source, target, end in zip(link.source, link.target, ends, strict=True):
            factor, shift = link.factor, link.offset
            if end in place:
                row = matrix[place[end]]
                column = int(np.flatnonzero(row)[0])
                sign, other = float(row[column]), port.nodes[column]
                if port.causality == "input":  # after the conversion to the receiver's unit
                    source, own = fed[other]
                    factor, shift = sign * own.factor, sign * own.offset + offset
                else:
                    source, factor, shift = other, sign * link.factor, link.factor * offset + link.offset
            links.append(Link(link.text, (source,), (target,), factor, shift, link.delayed))
    return Wiring(links, wiring.warnings)
