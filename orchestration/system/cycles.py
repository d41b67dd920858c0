"""What a scenario's `cycle` counts, such as orbits: its period follows the start values of the block that knows it."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from fmus.variables import Cycle

from ..errors import InputError
from ..expressions import OPERATIONS, Grammar
from ..fmu.model import Model
from ..scenario.load import load
from ..scenario.references import Name
from ..scenario.scenario import Scenario
from ..scenario.source import StartName
from .starts import in_words, resolve, taken

_SAME = 2e-4
"""A period of the file within this share of that of the start values stays: it is that period, rounded."""


class _Formula(Grammar[Any]):
    example = "arithmetic on parameters"
    functions: Mapping[str, tuple[int | None, Callable[..., Any]]] = {
        "sqrt": (1, math.sqrt),
        "norm": (1, lambda vector: math.hypot(*vector)),
    }

    def __init__(self, values: Mapping[str, Any]) -> None:
        self._values = {"pi": math.pi, **values}

    def number(self, value: float) -> Any:
        return value

    def negative(self, part: Any) -> Any:
        return -part

    def operation(self, kind: type[ast.operator], left: Any, right: Any) -> Any:
        return OPERATIONS[kind](left, right)

    def call(self, function: Callable[..., Any], parts: list[Any]) -> Any:
        return function(*parts)

    def named(self, node: ast.expr, part: Callable[[ast.expr], Any]) -> Any:
        return self._values[ast.unparse(node)]


def followed(scenario: Scenario, models: Mapping[str, Model]) -> tuple[Scenario, list[str]]:
    """Returns the scenario with the period that the start values give its cycle, and a note where that is another.

    Where no block knows what is counted, or two disagree, the scenario stays.
    """
    periods = {block: _period(scenario, block, models[block], cycle) for block, cycle in _known(scenario, models)}
    found = [(block, period) for block, period in periods.items() if period is not None]
    if scenario.cycle is None or not found or any(not _same(period, found[0][1]) for _, period in found):
        return scenario, []
    (block, period), name = found[0], scenario.cycle.name
    if _same(period, scenario.cycle.period):
        return scenario, []
    text = f"{name} of {block} last {period:.8g} s with its start values, not {scenario.cycle.period:.8g} s"
    note = scenario.note(("cycle", "period"), f"{text}; times counted in {name} follow")
    return load(scenario.source.with_entry(("cycle", "period"), float(f"{period:.8g}"))), [note]


def varied(scenario: Scenario, models: Mapping[str, Model], names: Iterable[StartName]) -> list[str]:
    """Returns a note for each of these start values, which vary from run to run, that changes how long the cycle
    lasts."""
    notes = []
    for block, cycle in _known(scenario, models):
        for start in names:
            name = taken(models[block], Name(start.variable)) if start.shared else Name(start.variable)
            if name is None or start.block not in ("shared", block):
                continue
            helper = models[block].helpers.get(name.variable)
            if (helper.gives if helper else name.variable) in cycle.uses and scenario.cycle is not None:
                counted = f"{scenario.cycle.name}, of {scenario.cycle.period:.8g} s"
                notes.append(f"{start} changes how long {block} takes; times are counted in the scenario's {counted}")
    return notes


def _known(scenario: Scenario, models: Mapping[str, Model]) -> list[tuple[str, Cycle]]:
    """Returns the blocks that know what the scenario counts."""
    name = scenario.cycle.name.removesuffix("s") if scenario.cycle else None
    counted = [(block, n, cycle) for block, model in models.items() for n, cycle in model.cycles.items()]
    return [(block, cycle) for block, n, cycle in counted if n.removesuffix("s") == name]


def _period(scenario: Scenario, block: str, model: Model, cycle: Cycle) -> float | None:
    """Returns how long one lasts, s; None where the block lacks a parameter of it, or a start value is wrong."""
    try:
        starts = {start.element: start.value for start in resolve(scenario, {block: model}, {})[block]}
        given = {**model.starts, **starts}
        values = {name: in_words(model.variables[name], given) for name in cycle.uses}
        period = _Formula(values).read(cycle.periods[values[cycle.by]])
    except (InputError, KeyError, ArithmeticError, ValueError):
        return None
    return float(period) if isinstance(period, float) and 0.0 < period < math.inf else None


def _same(a: float, b: float) -> bool:
    return abs(a - b) <= _SAME * b
