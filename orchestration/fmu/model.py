"""What a block offers: its variables as vectors and matrices, and which output depends on which input.

`describe` makes this of an FMU's modelDescription.xml; tests make it by hand.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, hint
from ..quantities import ONE, Exponents, Unit

Floats = NDArray[np.float64]
TYPES = ("real", "integer", "enumeration", "boolean")
"""The types that are exchanged and recorded, in the order in which a block's `wire` is given them."""
Type = Literal["real", "integer", "boolean", "string", "enumeration"]


class Element(NamedTuple):
    """One scalar: the element at `position` (from 0, row by row) of a variable."""

    variable: str
    position: int


@dataclass(frozen=True)
class Variable:
    """A scalar, vector or matrix; the FMU's scalars `x[1]`, `x[2]` ... are the elements of `x`."""

    name: str
    causality: str
    type: Type = "real"
    shape: tuple[int, ...] = ()
    references: tuple[int, ...] = (0,)
    """FMI's value reference of each element."""
    variability: str = "continuous"
    unit: Unit | None = None
    """Of all elements; where theirs differ, a list of their names, which fits its like only."""
    units: tuple[Unit | None, ...] = ()
    """Of each element, where they differ; else empty."""
    display_unit: Unit | None = None
    minima: tuple[float, ...] = ()
    maxima: tuple[float, ...] = ()
    """Limits of each element, infinite where there are none; empty for none at all."""
    items: tuple[tuple[str, int], ...] = ()
    """Names and values of an enumeration."""
    description: str = ""
    first_index: tuple[int, ...] = ()
    """What FMI calls the first element: 1 or 0 in each dimension; 1 where nothing is said."""
    optional: bool = False
    """An input that may stay unconnected at its own start value, as its FMU says."""

    @property
    def size(self) -> int:
        return math.prod(self.shape)

    @property
    def elements(self) -> list[Element]:
        return [Element(self.name, position) for position in range(self.size)]

    def at(self, positions: Sequence[int]) -> Variable:
        """The same with the unit of the elements at these positions."""
        if not self.units:
            return self
        unit, units = shared([self.units[position] for position in positions])
        return replace(self, unit=unit, units=units)

    def label(self, position: int) -> str:
        """The element's name, free of commas: `R_NB[1][2]`."""
        index = []
        for length in reversed(self.shape):
            position, i = divmod(position, length)
            index.append(i)
        first = self.first_index or (1,) * len(self.shape)
        return self.name + "".join(f"[{i + one}]" for i, one in zip(reversed(index), first, strict=True))

    @property
    def kind(self) -> str:
        """Type and shape in words: "a real [3, 3]"."""
        article = "an" if self.type[0] in "ie" else "a"
        return f"{article} {self.type} {list(self.shape) if self.shape else 'scalar'}"


def shared(units: Sequence[Unit | None]) -> tuple[Unit | None, tuple[Unit | None, ...]]:
    """`unit` and `units` of a variable whose elements have these."""
    if len(set(units)) == 1:
        return units[0], ()
    return Unit(", ".join("no unit" if unit is None else str(unit) for unit in units), None), tuple(units)


class NameUnknown(ValueError):
    """The block has no such variable or element."""


@dataclass(frozen=True)
class Model:
    """A kind of block."""

    name: str
    variables: dict[str, Variable]
    feedthrough: dict[Element, frozenset[Element] | None] = field(default_factory=dict)
    """The inputs on which an output depends directly; None where the FMU does not say."""
    initial: dict[Element, frozenset[Element] | None] = field(default_factory=dict)
    """The same in initialization."""
    guid: str = ""
    tool: str = ""

    def of(self, *causalities: str) -> list[Variable]:
        return [v for v in self.variables.values() if v.causality in causalities]

    @cached_property
    def inputs(self) -> list[Element]:
        return [element for variable in self.of("input") for element in variable.elements]

    def find(
        self, block: str, name: str, index: tuple[int, ...] = (), of: Iterable[str] = ()
    ) -> tuple[Variable, list[int]]:
        """The variable and the positions that a reference means. Raises NameUnknown, which names the nearest."""
        exact = name + "".join(f"[{i}]" for i in index)
        if index and exact in self.variables:
            return self.variables[exact], [0]
        if name not in self.variables:
            wanted = tuple(of)
            kind = " or ".join(wanted) or "variable"
            names = [v.name for v in self.variables.values() if not wanted or v.causality in wanted]
            raise NameUnknown(f"{block} has no {kind} {name!r}{hint(name, names)}")
        variable = self.variables[name]
        if not index:
            return variable, list(range(variable.size))
        first = variable.first_index or (1,) * len(variable.shape)
        if len(index) != len(variable.shape):
            raise NameUnknown(f"{block}.{name} is {variable.kind}; an element of it has {len(variable.shape)} indices")
        position = 0
        for i, one, length in zip(index, first, variable.shape, strict=True):
            if not one <= i < one + length:
                raise NameUnknown(
                    f"{block}.{name} is {variable.kind}; index {i} is outside {one} to {one + length - 1}"
                )
            position = position * length + i - one
        return variable, [position]


def describe(description: Any, optional: Collection[str] = ()) -> Model:
    """The model of an FMU, from what FMPy read of its modelDescription.xml, and the names of its optional inputs."""
    units = {unit.name: _unit(unit) for unit in description.unitDefinitions}
    displays = {
        (unit.name, display.name): _display_unit(units[unit.name], display)
        for unit in description.unitDefinitions
        for display in unit.displayUnits
    }
    groups = _groups([v for v in description.modelVariables if v.causality != "independent"])
    variables: dict[str, Variable] = {}
    elements: dict[str, Element] = {}
    for name, (shape, first, scalars) in groups.items():
        variables[name] = _variable(name, shape, first, scalars, units, displays)
        if all(scalar.causality == "input" and scalar.name in optional for scalar in scalars):
            variables[name] = replace(variables[name], optional=True)
        elements.update((scalar.name, Element(name, i)) for i, scalar in enumerate(scalars))
    return Model(
        name=description.modelName,
        variables=variables,
        feedthrough=_dependencies(description.outputs, elements),
        initial=_initial(description, elements),
        guid=description.guid,
        tool=description.generationTool or "",
    )


def _unit(unit: Any) -> Unit:
    base = unit.baseUnit
    if base is None:
        return Unit(unit.name, None)
    exponents: Exponents = (base.kg, base.m, base.s, base.A, base.K, base.mol, base.cd, base.rad)
    _refuse_unsound(f"the unit {unit.name!r}", base, base.factor, base.offset)
    return Unit(unit.name, exponents, base.factor, base.offset)


def _refuse_unsound(what: str, declared: Any, factor: float, offset: float) -> None:
    """Refuses what cannot be converted: a factor that is not above 0, or numbers that are not finite."""
    if not (0.0 < factor < math.inf and math.isfinite(offset)):
        raise InputError(
            f"modelDescription.xml: {what} has the factor {declared.factor} and the offset {declared.offset}; "
            "expected a finite factor above 0 and a finite offset"
        )


def _display_unit(unit: Unit, display: Any) -> Unit:
    # FMI: value in the display unit = factor * value in the unit + offset
    factor = unit.factor / display.factor if display.factor else math.nan
    offset = unit.offset - display.offset * factor
    _refuse_unsound(f"the display unit {display.name!r} of {unit}", display, factor, offset)
    return Unit(display.name, unit.exponents, factor, offset)


_INDEXED = re.compile(r"(.+)\[(\d+(?:,\s*\d+)*)\]")
_Group = tuple[tuple[int, ...], tuple[int, ...], list[Any]]


def _groups(scalars: list[Any]) -> dict[str, _Group]:
    """Scalars by the name of the whole, where its elements are all there and alike; else each by its own name."""
    found: dict[str, dict[tuple[int, ...], Any]] = {}
    for scalar in scalars:
        match = _INDEXED.fullmatch(scalar.name)
        name, index = (match[1], tuple(map(int, match[2].split(",")))) if match else (scalar.name, ())
        found.setdefault(name, {})[index] = scalar
    groups: dict[str, _Group] = {}
    for name, members in found.items():
        whole = _whole(members)
        if whole is not None:
            groups[name] = whole
        else:
            groups.update((scalar.name, ((), (), [scalar])) for scalar in members.values())
    return groups


def _whole(members: dict[tuple[int, ...], Any]) -> _Group | None:
    if len({len(index) for index in members}) != 1 or len({_nature(v) for v in members.values()}) != 1:
        return None
    first = tuple(map(min, zip(*members, strict=True)))
    last = tuple(map(max, zip(*members, strict=True)))
    shape = tuple(b - a + 1 for a, b in zip(first, last, strict=True))
    if math.prod(shape) != len(members) or not set(first) <= {0, 1}:
        return None
    return shape, first, [members[index] for index in sorted(members)]


def _nature(scalar: Any) -> tuple[Any, ...]:
    return (
        scalar.causality,
        scalar.type,
        scalar.variability,
        scalar.type == "Enumeration" and scalar.declaredType and scalar.declaredType.name,
    )


def _variable(name: str, shape: Any, first: Any, scalars: list[Any], units: Any, displays: Any) -> Variable:
    scalar = scalars[0]
    declared = scalar.declaredType

    def attribute(key: str, scalar: Any) -> Any:
        value, declared = getattr(scalar, key), scalar.declaredType
        return value if value is not None or declared is None else getattr(declared, key)

    named = [(attribute("unit", v), attribute("displayUnit", v)) for v in scalars]
    unit, apart = shared([units.get(name, Unit(name, None)) if name else None for name, _ in named])
    ordered = scalar.type in ("Real", "Integer")
    return Variable(
        name=name,
        causality=scalar.causality,
        type=scalar.type.lower(),
        shape=shape,
        references=tuple(v.valueReference for v in scalars),
        variability=scalar.variability,
        unit=unit,
        units=apart,
        display_unit=displays.get(named[0]) if len(set(named)) == 1 else None,
        minima=tuple(float(attribute("min", v) or "-inf") for v in scalars) if ordered else (),
        maxima=tuple(float(attribute("max", v) or "inf") for v in scalars) if ordered else (),
        items=tuple((item.name, int(item.value)) for item in declared.items) if declared is not None else (),
        description=scalar.description or "",
        first_index=first,
    )


def _dependencies(unknowns: list[Any], elements: dict[str, Element]) -> dict[Element, frozenset[Element] | None]:
    found: dict[Element, frozenset[Element] | None] = {}
    for unknown in unknowns:
        if unknown.variable.name in elements:
            known = unknown.dependencies
            inputs = known and (v for v in known if v.causality == "input")
            found[elements[unknown.variable.name]] = (
                None if known is None else frozenset(elements[v.name] for v in inputs or ())
            )
    return found


def _initial(description: Any, elements: dict[str, Element]) -> dict[Element, frozenset[Element] | None]:
    found = _dependencies(description.initialUnknowns, elements)
    direct = _dependencies(description.outputs, elements)
    for scalar in description.modelVariables:
        if scalar.causality == "output" and elements[scalar.name] not in found:
            exact = scalar.initial == "exact"
            found[elements[scalar.name]] = frozenset() if exact else direct.get(elements[scalar.name])
    return found


def unit_of(variable: Variable) -> Unit:
    """Its unit, or the unit one."""
    return variable.unit or ONE
