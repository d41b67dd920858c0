"""Blocks that are wired together and state one quantity: where the values in force differ, the user is warned."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from ..errors import Problems, hint
from ..fmu.model import Model, Variable
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from .starts import Start


def notes(scenario: Scenario, models: Mapping[str, Model], starts: Mapping[str, Sequence[Start]]) -> list[str]:
    """Warnings, one for each quantity. Raises InputError where `differs` names no such parameter."""
    _check(scenario, models)
    found = [
        f"{block}: its FMU has no parameter {name.variable}, so the shared value does not reach it"
        for block, model in models.items()
        for name in scenario.shared
        if name.variable in model.lacks
    ]
    stated: dict[tuple[int, str], dict[str, list[_Stated]]] = {}
    places, meant = _places(scenario), _meant(scenario, models)
    for block, model in models.items():
        values = {**model.starts, **{start.element: start.value for start in starts[block]}}
        for variable in model.of("parameter"):
            name = variable.quantity
            known = all(element in values for element in variable.elements)
            if name is None or not known or {name, variable.name} & meant[block]:
                continue
            one = _Stated(block, variable, [values[element] for element in variable.elements])
            groups = stated.setdefault((places[block], name), {})
            alike = next((g for g in groups.values() if g[0].agrees(one)), None)
            groups.setdefault(one.label if alike is None else alike[0].label, []).append(one)
    return found + [_sentence(name, list(groups.values())) for (_, name), groups in stated.items() if len(groups) > 1]


def _meant(scenario: Scenario, models: Mapping[str, Model]) -> dict[str, set[str]]:
    """Returns by block which names under its `differs` hold.

    Those of a file speak of the values there and under it: they hold no more where one is given above or beside it.
    """
    source = scenario.source
    given: dict[str, list[Key]] = {}
    for block, model in models.items():
        keys = scenario.given(block)
        for variable in model.of("parameter"):
            key = keys.get(variable.name) or keys.get(variable.quantity or "")
            if variable.quantity and key:
                for name in {variable.quantity, variable.name}:
                    given.setdefault(name, []).append(key)
    return {
        block: {
            name
            for number, name in enumerate(entry.differs)
            if all(source.lies_under(key, ("blocks", block, "differs", number)) for key in given.get(name, ()))
        }
        for block, entry in scenario.blocks.items()
    }


def _check(scenario: Scenario, models: Mapping[str, Model]) -> None:
    with Problems() as problems:
        for block, entry in scenario.blocks.items():
            known = {v.name for v in models[block].of("parameter") if v.quantity} | models[block].lacks
            for number, name in enumerate(entry.differs):
                if name not in known | {v.quantity for v in models[block].of("parameter")}:
                    text = f"{block} has no parameter {name!r} that other blocks state, too{hint(name, known)}"
                    problems.append(scenario.error(("blocks", block, "differs", number), text))


def _places(scenario: Scenario) -> dict[str, int]:
    """A number for each block, the same for those that are wired together."""
    places = {block: number for number, block in enumerate(scenario.blocks)}
    for connection in scenario.connections:
        a, b = places[connection.source.block], places[connection.target.block]
        places = {block: min(a, b) if place in (a, b) else place for block, place in places.items()}
    return places


class _Stated:
    """A quantity as a block states it."""

    def __init__(self, block: str, variable: Variable, values: list[Any]) -> None:
        self.label, self.variable, self.values = f"{block}.{variable.name}", variable, values
        self._names = names = {number: item for item, number in variable.items}
        factor, offset = (variable.unit.factor, variable.unit.offset) if variable.unit else (1.0, 0.0)
        self.plain = [v * factor + offset if variable.type == "real" else names.get(v, _instant(v)) for v in values]

    def agrees(self, other: _Stated) -> bool:
        """Returns whether the values are the same to nine figures of the largest; those of another shape are not
        compared.
        """
        if len(self.plain) != len(other.plain) or (self.variable.type == "real") != (other.variable.type == "real"):
            return True
        return not self.differing(other)

    def differing(self, other: _Stated) -> list[int]:
        pairs = list(zip(self.plain, other.plain, strict=True))
        if self.variable.type != "real":
            return [i for i, (a, b) in enumerate(pairs) if a != b]
        size = max((abs(x) for pair in pairs for x in pair if math.isfinite(x)), default=0.0)
        return [i for i, (a, b) in enumerate(pairs) if a != b and not abs(a - b) <= 1e-9 * size]

    def at(self, position: int) -> str:
        """The value of an element in words."""
        value, unit = self.values[position], self.variable.unit
        text = f"{value:.10g}" if isinstance(value, float) else str(self._names.get(value, value))
        return f"{text} {unit}" if unit and str(unit) != "1" else text


def _instant(value: Any) -> Any:
    """An instant in UTC where a text is one, since `...T00:00:00Z` and `...T00:00:00.0+00:00` are the same."""
    if not isinstance(value, str) or "-" not in value:
        return value
    try:
        instant = datetime.fromisoformat(value)
    except ValueError:
        return value
    return instant.replace(tzinfo=UTC) if instant.tzinfo is None else instant.astimezone(UTC)


def _sentence(name: str, groups: list[list[_Stated]]) -> str:
    first, second = groups[0][0], groups[1][0]
    where = first.differing(second)
    i = where[0]
    mark = first.variable.label(i).removeprefix(first.variable.name)
    values = [f"{' = '.join(one.label + mark for one in group)} = {group[0].at(i)}" for group in groups]
    more = f" (and {len(where) - 1} more elements)" if len(where) > 1 else ""
    return (
        f"{' and '.join(values)}{more}: the same quantity with different values; remedy: give {name} once, under "
        "'shared', "
        f"or say 'differs: [{name}]' at a block where this is meant"
    )
