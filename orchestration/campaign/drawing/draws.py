"""The values that a campaign varies, held against the blocks: from a point of the unit cube to start values, and to
columns of the dataset.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ... import rotation
from ...errors import Problems
from ...fmu.model import Model, NameUnknown, Variable
from ...quantities import BASES, ONE, Quantity, QuantityError, Unit, parse_unit, shown
from ...scenario.references import Name
from ...scenario.source import Source, StartName
from ...system.starts import taken
from ..file.campaign import Campaign
from ..file.distributions import Varied
from . import samplers
from .entries import describe, examples, numbers_only
from .entries import sampler as of
from .expression import Expression


@dataclass(frozen=True)
class Draw:
    """One value that varies."""

    name: str
    """As the file has it."""
    start: StartName | None
    """What it sets; None for a helper under `draw`."""
    entry: Varied
    text: str
    """The distribution in words."""
    unit: Unit | None
    """Of its numbers; None where they are in that of the port, or have none."""
    sampler: samplers.Sampler | Expression
    first: int
    """Its first coordinate in the unit cube."""
    count: int
    columns: tuple[str, ...]
    numbers: bool
    """Whether its columns hold numbers, and no text."""
    quaternion: bool = False
    """Whether a rotation is set as a quaternion, and not as a matrix."""
    whole: bool = False
    """Whether an expression sets whole numbers; one that gives another is refused as a start value."""
    port: str = ""
    """The unit of the port that takes it, where its numbers have none of their own."""

    @property
    def helper(self) -> bool:
        """Returns whether it sets nothing itself, and expressions take it."""
        return self.start is None

    @property
    def shown(self) -> str:
        """Returns the unit of its columns; empty where they have none."""
        if self.entry.rotation or not self.numbers:
            return ""
        return self.port if self.unit is None else str(self.unit)

    def given(self, value: Any) -> Any:
        """Returns the value as a start value: a number, a Quantity or lists of these, an item's name, or a rotation."""
        if self.entry.rotation:
            return value if self.quaternion else {"quaternion": value}
        if self.whole:
            return _each(value, lambda number: int(number) if number.is_integer() else number)
        unit = self.unit
        return value if unit is None or not self.numbers else _each(value, lambda number: Quantity(number, unit))

    def known(self, value: Any) -> Any:
        """Returns the value in expressions: in base units, rotations as matrices."""
        if self.entry.rotation:
            R = rotation.matrix(value)
            return [R[0:3], R[3:6], R[6:9]]
        unit = self.unit or ONE
        return _each(value, lambda number: number * unit.factor + unit.offset) if self.numbers else value

    def cells(self, value: Any) -> list[Any]:
        """Returns the value in the columns of the dataset."""
        if self.columns and self.numbers:
            return [float(x) for x in np.ravel(value)]
        return [value if isinstance(value, str) else json.dumps(value)] if self.columns else []


class Draws:
    """All that varies, in the order of the file."""

    def __init__(self, draws: Sequence[Draw]) -> None:
        self.draws = list(draws)
        self.dimension = sum(draw.count for draw in draws)

    def at(self, point: Sequence[float]) -> list[Any]:
        """Returns the value of each at a point of the unit cube (dimension,).

        Raises NoValue where an expression has none.
        """
        values: list[Any] = []
        known: dict[str, Any] = {}
        for draw in self.draws:
            if isinstance(draw.sampler, Expression):
                value = draw.sampler.of(draw.name, draw.helper, known)
            else:
                value = draw.sampler.value(point[draw.first : draw.first + draw.count])
            if draw.helper:
                known[draw.name] = draw.known(value)
            values.append(value)
        return values

    def given(self, values: Sequence[Any]) -> dict[StartName, Any]:
        """Returns the start values, which `with_values` takes."""
        pairs = zip(self.draws, values, strict=True)
        return {draw.start: draw.given(value) for draw, value in pairs if draw.start is not None}

    def texts(self, values: Sequence[Any]) -> dict[str, Any]:
        """Returns the start values by name, as a file or `--set` has them."""
        pairs = zip(self.draws, values, strict=True)
        return {draw.name: _written(draw.given(value)) for draw, value in pairs if not draw.helper}

    def cells(self, values: Sequence[Any]) -> list[Any]:
        """Returns the values in the columns of the dataset."""
        return [cell for draw, value in zip(self.draws, values, strict=True) for cell in draw.cells(value)]

    @property
    def columns(self) -> list[tuple[str, bool]]:
        """Returns names of columns, and whether they hold numbers."""
        return [(column, draw.numbers) for draw in self.draws for column in draw.columns]

    @property
    def coordinates(self) -> list[str]:
        """Returns a label for each coordinate."""
        return [
            draw.name if draw.count == 1 else f"{draw.name} ({i + 1} of {draw.count})"
            for draw in self.draws
            for i in range(draw.count)
        ]


def prepare(campaign: Campaign, source: Source, models: Mapping[str, Model]) -> Draws:
    """Holds what varies against the blocks. Raises InputError with every error."""
    draws: list[Draw] = []
    helpers: list[str] = []
    with Problems() as problems:
        for key, entries in (("draw", campaign.draw), ("vary", campaign.vary)):
            for name, entry in entries.items():
                start = None if key == "draw" else StartName.of(name)
                variable = None if start is None else _target(start, models)
                first = draws[-1].first + draws[-1].count if draws else 0
                try:
                    draws.append(_draw(name, start, entry, variable, first, helpers))
                except QuantityError as error:
                    problems.append(source.error((key, name, entry.kind), str(error)))
                if key == "draw":
                    helpers.append(name)
    return Draws(draws)


def _target(start: StartName, models: Mapping[str, Model]) -> Variable | None:
    """Returns the parameter that a name means; None where there is none, of which `resolve` tells."""
    wanted = Name(start.variable)
    of = [(block, model) for block, model in models.items() if start.shared or block == start.block]
    for block, model in of:
        if wanted.variable in model.helpers:
            return model.helpers[wanted.variable].variable
        own = taken(model, wanted) if start.shared else wanted
        if own is None:
            continue
        try:
            variable, positions = model.find(block, own.variable, own.indices, ("parameter", "input"))
        except NameUnknown:
            continue
        return variable if len(positions) == variable.size else variable.at(positions)
    return None


def _draw(
    name: str, start: StartName | None, entry: Varied, variable: Variable | None, first: int, helpers: list[str]
) -> Draw:
    sampler: samplers.Sampler | Expression
    quaternion = False
    if entry.expression is not None:
        sampler, unit = Expression(entry.expression, set(helpers), helpers), _base_unit(variable)
        sample = None
    else:
        sampler, unit = of(entry)
        sample = sampler.value([0.5] * sampler.count)
    numbers = entry.rotation is not None or _numbers(sampler)
    if entry.rotation and variable is not None:
        quaternion = variable.size == 4
        if variable.size not in (4, 9):
            raise QuantityError(f"a rotation is a matrix or a quaternion, {name} is {variable.kind}")
    count = 0 if isinstance(sampler, Expression) else sampler.count
    shape: tuple[int, ...] = ()
    if sample is not None:
        shape = np.shape(sample) if numbers else ()
    elif variable is not None:
        shape = variable.shape
    hidden = start is None and sample is None
    return Draw(
        name,
        start,
        entry,
        describe(entry),
        unit,
        sampler,
        first,
        count,
        columns=() if hidden else _columns(name, entry, shape),
        numbers=numbers,
        quaternion=quaternion,
        whole=sample is None and variable is not None and variable.type == "integer",
        port=shown(variable.unit if variable is not None else None),
    )


def _numbers(sampler: samplers.Sampler | Expression) -> bool:
    """Returns whether all values are numbers of one shape."""
    values = [] if isinstance(sampler, Expression) else examples(sampler)
    return all(numbers_only(value) and np.shape(value) == np.shape(values[0]) for value in values)


def _columns(name: str, entry: Varied, shape: tuple[int, ...]) -> tuple[str, ...]:
    if entry.rotation:
        return tuple(f"{name}.q{i}" for i in range(4))
    return tuple(f"{name}[{','.join(str(i + 1) for i in index)}]" if index else name for index in np.ndindex(*shape))


def _base_unit(variable: Variable | None) -> Unit | None:
    """Returns the base unit of a port whose own is another; None where a bare number will do."""
    unit = variable.unit if variable is not None else None
    if unit is None or unit.exponents is None or (unit.factor == 1.0 and unit.offset == 0.0):
        return None
    powers = zip(BASES, unit.exponents, strict=True)
    return parse_unit(".".join(f"{base}{power}" for base, power in powers if power)) if any(unit.exponents) else None


def _each(value: Any, change: Callable[[Any], Any]) -> Any:
    """Returns a number, or lists of numbers, with each of them changed."""
    return [_each(item, change) for item in value] if isinstance(value, list) else change(value)


def _written(value: Any) -> Any:
    """Returns a start value as a file has it: quantities as text."""
    return _each(value, lambda item: str(item) if isinstance(item, Quantity) else item)
