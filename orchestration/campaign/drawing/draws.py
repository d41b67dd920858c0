"""The values that a campaign varies, held against the blocks: from a point of the unit cube to start values, and to
columns of the dataset.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ... import rotation
from ...errors import InputError, Problem
from ...fmu.model import Model, NameUnknown, Variable
from ...quantities import BASES, ONE, QuantityError, Unit, parse_unit
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
    """As `--set` takes it, or that of a helper under `draw`."""
    helper: bool
    entry: Varied
    text: str
    """The distribution in words."""
    unit: str
    """Of its numbers; empty where they are in that of the port, or have none."""
    sampler: samplers.Sampler | Expression
    first: int
    """Its first coordinate in the unit cube."""
    count: int
    columns: tuple[str, ...]
    numbers: bool
    """Whether its columns hold numbers, and no text."""
    si: Unit
    """Its unit with its factor, for expressions."""
    suffix: str = ""
    """The unit that an expression's numbers are given."""
    quaternion: bool = False
    """Whether a rotation is set as a quaternion, and not as a matrix."""
    whole: bool = False
    """Whether an expression sets whole numbers; one that gives another is refused as a start value."""
    port: str = ""
    """The unit of the port that takes it, where its numbers have none of their own."""

    @property
    def shown(self) -> str:
        """The unit of its columns; empty where they have none."""
        return "" if self.entry.rotation or not self.numbers else self.suffix or self.unit or self.port

    def given(self, value: Any) -> Any:
        """The value as `--set` takes it."""
        if self.entry.rotation:
            return value if self.quaternion else {"quaternion": value}
        if self.whole:
            return _whole(value)
        return _with(value, self.suffix or self.unit) if self.numbers else value

    def known(self, value: Any) -> Any:
        """The value in expressions: in base units, rotations as matrices."""
        if self.entry.rotation:
            R = rotation.matrix(value)
            return [R[0:3], R[3:6], R[6:9]]
        return _scaled(value, self.si) if self.numbers else value

    def cells(self, value: Any) -> list[Any]:
        """The value in the columns of the dataset."""
        if self.columns and self.numbers:
            return [float(x) for x in np.ravel(value)]
        return [value if isinstance(value, str) else json.dumps(value)] if self.columns else []


class Draws:
    """All that varies, in the order of the file."""

    def __init__(self, draws: Sequence[Draw]) -> None:
        self.draws = list(draws)
        self.dimension = sum(draw.count for draw in draws)

    def at(self, point: Sequence[float]) -> list[Any]:
        """The value of each at a point of the unit cube (dimension,). Raises NoValue where an expression has none."""
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

    def given(self, values: Sequence[Any]) -> dict[str, Any]:
        """Start values by name, as `--set` takes them."""
        return {draw.name: draw.given(value) for draw, value in zip(self.draws, values, strict=True) if not draw.helper}

    def cells(self, values: Sequence[Any]) -> list[Any]:
        """The values in the columns of the dataset."""
        return [cell for draw, value in zip(self.draws, values, strict=True) for cell in draw.cells(value)]

    @property
    def columns(self) -> list[tuple[str, bool]]:
        """Names of columns, and whether they hold numbers."""
        return [(column, draw.numbers) for draw in self.draws for column in draw.columns]

    @property
    def coordinates(self) -> list[str]:
        """A label for each coordinate."""
        return [
            draw.name if draw.count == 1 else f"{draw.name} ({i + 1} of {draw.count})"
            for draw in self.draws
            for i in range(draw.count)
        ]


def prepare(campaign: Campaign, source: Source, models: Mapping[str, Model]) -> Draws:
    """Holds what varies against the blocks. Raises InputError with every error."""
    draws: list[Draw] = []
    errors: list[Problem] = []
    helpers: list[str] = []
    for key, entries in (("draw", campaign.draw), ("vary", campaign.vary)):
        for name, entry in entries.items():
            try:
                variable = None if key == "draw" else _target(name, models)
                first = draws[-1].first + draws[-1].count if draws else 0
                draws.append(_draw(name, entry, key == "draw", variable, first, helpers))
            except QuantityError as error:
                errors.append(source.error((key, name, entry.kind), str(error)))
            if key == "draw":
                helpers.append(name)
    if errors:
        raise InputError(*errors)
    return Draws(draws)


def _target(name: str, models: Mapping[str, Model]) -> Variable | None:
    """The parameter that a name means; None where there is none, of which `resolve` tells."""
    start = StartName.of(name)
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


def _draw(name: str, entry: Varied, helper: bool, variable: Variable | None, first: int, helpers: list[str]) -> Draw:
    sampler: samplers.Sampler | Expression
    unit, suffix, quaternion = "", "", False
    if entry.expression is not None:
        sampler = Expression(entry.expression, set(helpers), helpers)
        suffix = "" if helper else _base_unit(variable)
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
    columns = _columns(name, entry, shape)
    own = parse_unit(unit) if unit else ONE
    hidden = helper and sample is None
    return Draw(
        name,
        helper,
        entry,
        describe(entry),
        unit,
        sampler,
        first,
        count,
        () if hidden else columns,
        numbers,
        own,
        suffix,
        quaternion,
        sample is None and variable is not None and variable.type == "integer",
        "" if variable is None or variable.unit is None or str(variable.unit) == "1" else str(variable.unit),
    )


def _numbers(sampler: samplers.Sampler | Expression) -> bool:
    """Whether all values are numbers of one shape."""
    values = [] if isinstance(sampler, Expression) else examples(sampler)
    return all(numbers_only(value) and np.shape(value) == np.shape(values[0]) for value in values)


def _columns(name: str, entry: Varied, shape: tuple[int, ...]) -> tuple[str, ...]:
    if entry.rotation:
        return tuple(f"{name}.q{i}" for i in range(4))
    return tuple(f"{name}[{','.join(str(i + 1) for i in index)}]" if index else name for index in np.ndindex(*shape))


def _base_unit(variable: Variable | None) -> str:
    """The base unit of a port whose own is another; empty where a bare number will do."""
    unit = variable.unit if variable is not None else None
    if unit is None or unit.exponents is None or (unit.factor == 1.0 and unit.offset == 0.0):
        return ""
    return ".".join(f"{base}{power}" for base, power in zip(BASES, unit.exponents, strict=True) if power)


def _with(value: Any, unit: str) -> Any:
    """The value with its unit as text; as it is without one."""
    if not unit:
        return value
    return [_with(item, unit) for item in value] if isinstance(value, list) else f"{value!r} {unit}"


def _whole(value: Any) -> Any:
    """Floats that are whole as whole numbers."""
    if isinstance(value, list):
        return [_whole(item) for item in value]
    return int(value) if value.is_integer() else value


def _scaled(value: Any, unit: Unit) -> Any:
    """The value in base units."""
    if isinstance(value, list):
        return [_scaled(item, unit) for item in value]
    return value * unit.factor + unit.offset
