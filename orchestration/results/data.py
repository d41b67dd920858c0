"""What a run recorded and what came of it, as data: arrays by name."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import BlockError, InputError, hint
from ..expectations.flags import Flag
from ..expectations.holds import Hold
from ..expectations.outcomes import Highlight, NotEvaluated, Outcome, Settled
from ..fmu.model import Element, Floats, Model, Variable
from ..master.deadlines import Pace
from ..quantities import ONE, QuantityError, Unit, parse_unit
from ..scenario.references import Reference
from ..scenario.scenario import Scenario
from ..system import signals
from ..system.wiring import Node


def _nothing(result: RunData) -> dict[str, Any]:
    return {}


@dataclass(repr=False)
class RunData(Mapping[str, NDArray[Any]]):
    """Record of a run, by name as `Result` says; without the ways to keep it, which stand above."""

    scenario: Scenario
    models: Mapping[str, Model]
    time: Floats
    samples: Floats
    """A row for each instant, a column for each of `columns`."""
    columns: list[Node]
    outcomes: list[Outcome] = field(default_factory=list)
    """Of the expectations that were evaluated."""
    not_evaluated: list[NotEvaluated] = field(default_factory=list)
    """Of those that a swapped block gives no signal for."""
    highlights: list[Highlight] = field(default_factory=list)
    settled: list[Settled] = field(default_factory=list)
    """Since when signals keep the bounds of expectations that they broke before."""
    holds: list[Hold] = field(default_factory=list)
    booleans: list[Flag] = field(default_factory=list)
    """The boolean outputs, and when they were true."""
    warnings: list[str] = field(default_factory=list)
    steps: int = 0
    reached: float = 0.0
    """The simulated time at which it ended, s."""
    wall: float = 0.0
    pace: Pace | None = None
    """How a run in real time kept its deadlines; None for one that was as fast as it goes."""
    failure: BlockError | None = None
    interrupted: int = 0
    """The number of the signal that ended it, such as that of Ctrl-C; 0 for none."""
    described: Callable[[RunData], dict[str, Any]] = field(default=_nothing, compare=False)
    """What makes the manifest."""

    @cached_property
    def manifest(self) -> dict[str, Any]:
        """Returns the scenario as resolved, parameters, versions and what came of the run, ready for JSON; made when it
        is asked for.
        """
        return self.described(self)

    def rows(self, name: str) -> Floats:
        """Returns a signal's elements side by side (samples, elements), also where there is no sample."""
        values = self[name]
        return values.reshape(len(values), math.prod(values.shape[1:])).astype(float)

    @property
    def labels(self) -> list[str]:
        """Returns the name of each recorded element, free of commas: `plant.R_NB[1][2]`."""
        return [signals.label(node, self.models) for node in self.columns]

    @property
    def sha256(self) -> str:
        """SHA-256 of the recorded values: row by row, the columns in their order, eight bytes each, least first."""
        return hashlib.sha256(np.ascontiguousarray(self.samples, "<f8").data).hexdigest()

    @property
    def passed(self) -> bool:
        """Returns whether the run came to its end and every expectation that could be evaluated is met."""
        return self.failure is None and not self.interrupted and all(outcome.passed for outcome in self.outcomes)

    @property
    def flags(self) -> dict[str, float | None]:
        """Returns when each boolean output was true first, s; None for never. Every base step counts."""
        return {flag.name: flag.first for flag in self.booleans}

    @property
    def raised(self) -> list[str]:
        """Returns the flags that were true at some time, when first and when last."""
        return [flag.text for flag in self.booleans if flag.first is not None]

    def column(self, node: Node) -> Floats:
        return self.samples[:, self._place[node]]

    def variable(self, name: str) -> Variable:
        """Returns the variable that a name means: its shape and description, and the unit of the elements that are
        meant.
        """
        reference = Reference(name)
        variable, positions = self._find(reference)
        return variable.at(positions)

    def _find(self, reference: Reference) -> tuple[Variable, list[int]]:
        return self.models[reference.block].find(reference.block, reference.variable, reference.indices)

    @property
    def units(self) -> dict[str, str]:
        """Returns the unit of each signal by its name; "" where it has none."""
        return {name: unit_text(self.variable(name).unit) for name in self}

    def unit_of_column(self, node: Node) -> str:
        """Returns the unit of a column; "" where it has none."""
        variable = self.models[node.block].variables[node.element.variable]
        return unit_text(variable.at([node.element.position]).unit)

    @property
    def _place(self) -> dict[Node, int]:
        places = self.__dict__.get("_places")
        if places is None:
            places = self.__dict__["_places"] = {node: i for i, node in enumerate(self.columns)}
        return places

    def places(self, name: str) -> list[int]:
        """Returns the columns of a signal's elements.

        Raises KeyError where they were not recorded, and ValueError for no name.
        """
        reference = Reference(name)
        variable, positions = self._find(reference)
        return [self._place[Node(reference.block, Element(variable.name, p))] for p in positions]

    def __getitem__(self, key: str | tuple[str, str]) -> NDArray[Any]:
        """Returns a signal, of `result["plant.h_w", "mN.m.s"]` in that unit.

        Raises KeyError where it was not recorded, and InputError where the unit does not fit.
        """
        name, unit = (key, None) if isinstance(key, str) else key
        try:
            reference = Reference(name)
            variable, positions = self._find(reference)
            places = self.places(name)
        except (KeyError, ValueError):
            raise KeyError(f"{name!r} was not recorded{hint(name, self)}") from None
        shape = variable.shape if len(positions) == variable.size and not reference.indices else ()
        values = self.samples[:, places].astype(variable.dtype).reshape(len(self.time), *shape)
        return values if unit is None else self._converted(values, name, unit)

    def _converted(self, values: NDArray[Any], name: str, unit: str) -> NDArray[Any]:
        own = self.variable(name).unit
        try:
            wanted = parse_unit(unit)
            if own is None or not own.fits(wanted):
                raise QuantityError(f"expected a unit of {name}, which is in {str(own or ONE)!r}, found {unit!r}")
            factor, offset = own.conversion(wanted)
        except QuantityError as error:
            raise InputError(f"{name}: {error}") from None
        return factor * values + offset

    def __iter__(self) -> Iterator[str]:
        """Returns names of the variables of which every element was recorded, and of single elements of the others."""
        return iter(self._names)

    @property
    def _names(self) -> list[str]:
        names = self.__dict__.get("_known")
        if names is None:
            names = self.__dict__["_known"] = signals.names(self.columns, self.models)
        return names

    def __len__(self) -> int:
        return len(self._names)


def unit_text(unit: Unit | None) -> str:
    """Returns a unit as text; "" where there is none."""
    return "" if unit is None else str(unit)


def json_text(data: object) -> str:
    """Returns what a run's files hold, as JSON to be read."""
    return json.dumps(data, indent=2, ensure_ascii=False, default=_plain)


def _plain(value: object) -> object:
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else str(value)
