"""Finds why nothing shows a wrong wiring, and what to add to a scenario so that something does.

Tests: tests/orchestration/acceptance/test_polarity.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...fmu.model import Floats
from ...quantities import suffix
from ...system.signals import label
from ...system.wiring import Node
from .fly import Loop, readers
from .ports import Port
from .wrongs import Wrong

SAME = 1e-9
"""A change of a signal, as a share of its largest value, that is none."""


@dataclass(frozen=True)
class Unobservable:
    """Reason for which nothing shows a wrong wiring, and the remedy."""

    reason: str
    remedy: str
    size: float = 0.0
    """By how much the signal of the remedy changes, in its unit."""


class Nominal:
    """A loop as it is wired, recorded, to hold a wrong wiring against that nothing has shown."""

    def __init__(self, loop: Loop) -> None:
        self.loop = loop
        models = loop.plan.models
        reals = [(block, v) for block, model in models.items() for v in model.of("output") if v.type == "real"]
        self.nodes = [Node(block, element) for block, variable in reals for element in variable.elements]
        self.time, self.values = loop.record(self.nodes)
        self.peaks = _peaks(self.values)

    def why(self, port: Port, wrong: Wrong) -> Unobservable:
        """Returns why nothing shows it."""
        loop, models = self.loop, self.loop.plan.models
        sources = loop.plan.wiring.sources() | {node: node for node in port.nodes}
        given = [self.values.get(sources[node] if port.causality == "input" else node) for node in port.nodes]
        if all(values is not None for values in given):
            signal = np.stack([values for values in given if values is not None], axis=1)
            if np.abs(wrong.apply(signal) - signal).max() <= SAME * max(float(np.abs(signal).max()), 1e-300):
                text = f"{port.name} has the same values read so: {_alike(port, signal)}"
                return Unobservable(text, "a stimulus whose elements are not zero and differ in size")
        _, values = loop.record(self.nodes, port, wrong)
        n = min(len(self.time), *(len(v) for v in values.values())) if values else 0
        changes = {node: self._change(node, values[node], n) for node in self.nodes}
        blocks = {block for block, _ in readers(port, loop.plan.wiring)}
        own = {node: change for node, change in changes.items() if node.block in blocks}
        largest = max(own, key=own.__getitem__, default=None)
        if largest is None or own[largest] <= SAME:
            names = " and ".join(sorted(blocks))
            text = f"no output of {names} changes: "
            text += f"{names} uses no part of {port.label} that this wiring alters in this run"
            return Unobservable(text, f"none, if {names} is not meant to use it; or a stimulus in which it does")
        watched = [node for node in loop.watched if node in changes]
        if all(changes[node] <= SAME for node in watched):
            text = f"{label(largest, models)} changes, but nothing that is looked at does: "
            text += "the loop is the same in exchanged axes"
            return Unobservable(
                text, "unequal values on these axes (inertia, rods), or an expectation of single elements"
            )
        variable = models[largest.block].variables[largest.element.variable]
        size = own[largest] * self.peaks[largest]
        name = f"{largest.block}.{variable.name}"
        return Unobservable(
            f"all expectations and checks hold; of what the reader gives, {name} changes most",
            f"a consistency check of {name} to better than {size:.2g}{suffix(variable.unit)}, or a larger stimulus",
            size,
        )

    def _change(self, node: Node, values: Floats, n: int) -> float:
        largest = float(np.abs(values[:n] - self.values[node][:n]).max()) if n else 0.0
        return largest / self.peaks[node] if self.peaks[node] > 0.0 else float(largest > 0.0)


def _peaks(values: Mapping[Node, Floats]) -> dict[Node, float]:
    """Returns the largest magnitude of the whole variable that an element belongs to."""
    whole: dict[tuple[str, str], float] = {}
    for node, column in values.items():
        key = node.block, node.element.variable
        whole[key] = max(whole.get(key, 0.0), float(np.abs(column).max()))
    return {node: whole[node.block, node.element.variable] for node in values}


def _alike(port: Port, signal: Floats) -> str:
    """Returns why a signal is the same when it is read wrongly."""
    if not signal.any():
        return "it is zero throughout"
    zero = [str(p + 1) for p, column in zip(port.positions, signal.T, strict=True) if not column.any()]
    if zero:
        which = f"elements {', '.join(zero)} are" if len(zero) > 1 else f"element {zero[0]} is"
        return f"{which} zero throughout"
    return "the elements that are exchanged are equal throughout"
