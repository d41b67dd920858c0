"""A scenario's consistency checks, held against its blocks before the run and against samples during it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from ..errors import InputError, Problems
from ..expressions import ExpressionError
from ..fmu.model import Floats, Model, Variable
from ..quantities import ONE, QuantityError, parse, real
from ..scenario.consistency import Consistency
from ..scenario.references import Reference
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from ..system import signals
from ..system.clock import slack
from ..system.wiring import Node
from .expressions import parse as parse_expression
from .expressions import references
from .functions import MEMORY, Expression, Samples, written


@dataclass(frozen=True)
class Relation:
    """A consistency check that fits the blocks."""

    name: str
    entry: Consistency
    left: Expression
    right: Expression
    within: float
    """In base units."""
    when: Node | None
    every: int
    """It is looked at once in so many base steps, at which all its blocks have been stepped."""

    @property
    def needed(self) -> list[Node]:
        return list(dict.fromkeys([*self.left.nodes, *self.right.nodes, *([self.when] if self.when else [])]))


def prepare(scenario: Scenario, models: Mapping[str, Model]) -> list[Relation]:
    """Checks the consistency checks against the blocks. Raises InputError with every error."""
    relations: list[Relation] = []
    with Problems() as problems:
        for name, entry in scenario.consistency.items():
            with problems.gathered():
                relations.append(_relation(scenario, name, entry, models))
    return relations


def reads(entry: Consistency) -> list[Reference]:
    """Returns the signals that a check reads, as far as its sides are expressions."""
    found = [entry.when] if entry.when is not None else []
    with suppress(ExpressionError):
        for side in (entry.left, entry.right):
            found += references(side)
    return found


def _relation(scenario: Scenario, name: str, entry: Consistency, models: Mapping[str, Model]) -> Relation:
    key: Key = ("consistency", name)

    def expression(side: str) -> Expression:
        def find(reference: Reference) -> tuple[Variable, list[Node]]:
            return signals.find(scenario, (*key, side), reference, models)

        with scenario.naming((*key, side)):
            return parse_expression(getattr(entry, side), find)

    left, right = expression("left"), expression("right")
    if left.shape != right.shape and right.nodes:
        message = (
            f"the shapes differ: left is {list(left.shape) or 'a scalar'}, right {list(right.shape) or 'a scalar'}"
        )
        raise InputError(scenario.error(key, message))
    if None not in (left.unit, right.unit) and left.unit != right.unit:
        message = f"the units differ: left is in {written(left.unit)}, right in {written(right.unit)}"
        raise InputError(scenario.error(key, message))
    when = None if entry.when is None else signals.flag(scenario, (*key, "when"), entry.when, models)
    with scenario.naming((*key, "within")):
        within = _within(entry, left.unit or right.unit)
    blocks = {node.block for node in (*left.nodes, *right.nodes)}
    if not blocks:
        raise InputError(scenario.error(key, "expected a signal on one side"))
    every = math.lcm(*(scenario.blocks[block].every for block in blocks))
    return Relation(name, entry, left, right, within, when, every)


def _within(entry: Consistency, unit: tuple[int, ...] | None) -> float:
    number, own = parse(entry.within) if isinstance(entry.within, str) else (real(entry.within), None)
    if own is not None and unit is not None and (own.exponents or ONE.exponents or ())[:-1] != unit:
        raise QuantityError(f"the unit {str(own)!r} does not fit that of the two sides, {written(unit)}")
    if not (math.isfinite(number) and number >= 0.0):
        raise QuantityError(f"expected zero or more, found {entry.within}")
    return number * (own.factor if own else 1.0)


@dataclass(frozen=True)
class Broken:
    """A consistency check that does not hold: when, by how much, and what was allowed, in base units."""

    name: str
    time: float
    apart: float
    allowed: float


class ConsistencyObserver:
    """Takes in samples piece by piece, until one breaks the check."""

    def __init__(self, relation: Relation) -> None:
        self.relation = relation
        self.broken: Broken | None = None
        self.closest = math.inf
        """The least of what is allowed over what the sides are apart: how often larger the difference could have been.
        """
        self._kept: tuple[Floats, dict[Node, Floats]] | None = None
        self._count = 0
        """Base steps that it has been shown."""

    def see(self, time: Floats, columns: Mapping[Node, Floats]) -> None:
        """Takes in the samples that follow those before, of every base step."""
        relation = self.relation
        first = -self._count % relation.every
        self._count += len(time)
        if self.broken is not None or first >= len(time):
            return
        new = {node: columns[node][first :: relation.every] for node in relation.needed}
        times = time[first :: relation.every]
        if self._kept is not None:
            old_time, old = self._kept
            new = {node: np.concatenate((old[node], values)) for node, values in new.items()}
            known, times = len(old_time), np.concatenate((old_time, times))
        else:
            known = 0
        # Copies, since the samples that follow are handed over in the same array.
        self._kept = times[-MEMORY:].copy(), {node: values[-MEMORY:].copy() for node, values in new.items()}
        with np.errstate(all="ignore"):
            left, right = (_flat(side.value(Samples(times, new))) for side in (relation.left, relation.right))
            apart = np.abs(left - right).max(axis=1)
            size = np.maximum(np.sqrt((left * left).sum(axis=1)), np.sqrt((right * right).sum(axis=1)))
        allowed = relation.within + relation.entry.share * size
        chosen = np.arange(len(times)) >= known
        chosen &= ~np.isnan(apart)  # there is no instant before the first
        entry = relation.entry
        if entry.after is not None:
            chosen &= times >= entry.after - slack(entry.after)
        if entry.before is not None:
            chosen &= times <= entry.before + slack(entry.before)
        if relation.when is not None:
            chosen &= new[relation.when] != 0.0
        if not chosen.any():
            return
        with np.errstate(all="ignore"):
            self.closest = min(self.closest, float((allowed[chosen] / np.maximum(apart[chosen], 1e-300)).min()))
        wrong = np.flatnonzero(chosen & (apart > allowed))
        if len(wrong):
            i = wrong[0]
            self.broken = Broken(relation.name, float(times[i]), float(apart[i]), float(allowed[i]))


def _flat(values: Floats) -> Floats:
    return values.reshape(len(values), -1)
