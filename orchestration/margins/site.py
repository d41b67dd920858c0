"""The place of a loop at which signals are injected: a port, its elements, and every receiver of them.

Tests: tests/orchestration/margins/test_site.py.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import InputError, Place, Problem
from ..fmu.model import Element, NameUnknown, unit_of
from ..master.circuit import Circuit
from ..scenario.references import Reference
from ..session.plan import Plan
from ..system.wiring import Node


@dataclass(frozen=True)
class Receiver:
    """An input that is given the signal: what it takes is `factor` times the signal, and an offset."""

    target: Node
    factor: float
    behind: int
    """How many base steps before the end of its step the value belongs to."""


@dataclass(frozen=True)
class Channel:
    """One element of the port. Its signal is sampled where its first receiver takes it."""

    label: str
    unit: str
    nominal: float
    receivers: tuple[Receiver, ...]
    port: str


@dataclass(frozen=True)
class Site:
    """The channels, and the base steps from sample to sample, which all of them have in common."""

    channels: tuple[Channel, ...]
    hold: int

    @property
    def labels(self) -> list[str]:
        """The names of the channels."""
        return [channel.label for channel in self.channels]


def site(plan: Plan, ports: Sequence[str], option: str = "--at") -> Site:
    """Returns the place that these ports, or elements of them, name. Raises InputError.

    At an input the signal is changed for this receiver alone, at an output for all of them.
    """
    channels: list[Channel] = []
    steps = {1}
    for text in ports:
        place = Place(f"{option} {text}")
        try:
            channels += _channels(plan, Reference(text, "block.port"), steps)
        except NameUnknown as error:
            raise InputError(Problem(str(error), place=place)) from None
        except InputError as error:
            raise InputError(*(problem.at(place) for problem in error.problems)) from None
    if not channels:
        raise InputError(Problem(expected=f"{option} block.port", found="none"))
    if len({channel.label for channel in channels}) < len(channels):
        raise InputError(Problem("a channel is named twice", place=Place(f"{option} {' '.join(ports)}")))
    return Site(tuple(channels), math.lcm(*steps))


def _channels(plan: Plan, reference: Reference, steps: set[int]) -> list[Channel]:
    block = reference.block
    if block not in plan.models:
        raise NameUnknown(f"there is no block {block!r}; the blocks are {', '.join(plan.models)}")
    variable, positions = plan.models[block].find(block, reference.variable, reference.indices, ("input", "output"))
    if variable.type != "real":
        raise NameUnknown(f"{reference} is {variable.type}; expected a real signal")
    found = []
    for position in positions:
        node = Node(block, Element(variable.name, position))
        receivers = _receivers(plan.circuit, node, steps)
        if not receivers:
            raise NameUnknown(f"{block}.{variable.label(position)} is not connected, so no loop passes there")
        label = f"{block}.{variable.label(position)}"
        found.append(Channel(label, str(unit_of(variable)), variable.nominal, tuple(receivers), str(reference)))
    return found


def _receivers(circuit: Circuit, node: Node, steps: set[int]) -> list[Receiver]:
    places = {name: place for place, name in enumerate(circuit.order.blocks)}
    receivers = []
    for link in circuit.wiring.links:
        for source, target in zip(link.source, link.target, strict=True):
            if node not in (source, target):
                continue
            steps |= {circuit.rate(source.block), circuit.rate(target.block)}
            late = link.delayed or circuit.parallel or places[source.block] >= places[target.block]
            receivers.append(Receiver(target, link.factor if node == source else 1.0, int(late)))
    return receivers
