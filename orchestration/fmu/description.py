"""The model of an FMU, from what FMPy read of its modelDescription.xml."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import replace
from os.path import commonprefix
from typing import Any

from ..errors import InputError
from ..quantities import Exponents, Unit
from .model import Element, Model, Variable, shared
from .types import NATIVES, Native

VARIABLES_MAX = 100_000
"""Scalars that a modelDescription.xml declares."""


def describe(description: Any, optional: Collection[str] = (), quantities: Mapping[str, str] | None = None) -> Model:
    """The model of an FMU, from what FMPy read of its modelDescription.xml, and what our annotations say.

    Those are the names of its optional inputs, and the quantities of parameters by their names.
    """
    units = {unit.name: _unit(unit) for unit in description.unitDefinitions}
    displays = {
        (unit.name, display.name): _display_unit(units[unit.name], display)
        for unit in description.unitDefinitions
        for display in unit.displayUnits
    }
    _refuse_too_many(description)
    left_out = {v.name: why for v in description.modelVariables if (why := _left_out(v))}
    known = [v for v in description.modelVariables if v.name not in left_out and v.alias is None]
    groups = _groups([v for v in known if v.causality != "independent"])
    natives = NATIVES[description.fmiMajorVersion]
    variables: dict[str, Variable] = {}
    elements: dict[str, list[Element]] = {}
    for name, (shape, first, scalars) in groups.items():
        variables[name] = _variable(name, shape, first, scalars, natives[scalars[0].type], units, displays)
        if all(scalar.causality == "input" and scalar.name in optional for scalar in scalars):
            variables[name] = replace(variables[name], optional=True)
        if len(stated := {(quantities or {}).get(scalar.name) for scalar in scalars}) == 1:
            variables[name] = replace(variables[name], quantity=stated.pop() or None)
        if scalars[0].shape:
            elements[name] = variables[name].elements
        else:
            elements.update((scalar.name, [Element(name, i)]) for i, scalar in enumerate(scalars))
    return Model(
        name=description.modelName,
        variables=variables,
        feedthrough=_feedthrough(description, elements),
        initial=_initial(description, elements),
        guid=description.guid,
        tool=description.generationTool or "",
        fmi=description.fmiVersion,
        aliases={v.name: v.alias.name for v in description.modelVariables if v.alias is not None},
        left_out=left_out,
    )


def _refuse_too_many(description: Any) -> None:
    for v in description.modelVariables:
        if any(length < 1 for length in v.shape):
            raise InputError(f"modelDescription.xml: {v.name} has the dimensions {list(v.shape)}; expected 1 or more")
    count = sum(math.prod(v.shape) for v in description.modelVariables)
    if count > VARIABLES_MAX:
        raise InputError(
            f"modelDescription.xml declares {count} elements of variables; expected at most {VARIABLES_MAX}"
        )


def _left_out(variable: Any) -> str:
    """Returns why a variable is not exchanged; empty where it is."""
    if variable.causality == "structuralParameter":
        return "a structural parameter, which keeps its start value"
    if variable.type == "Binary" or (variable.type == "String" and variable.shape):
        return f"{'a Binary' if variable.type == 'Binary' else 'an array of text'}, which is not exchanged"
    return ""


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
    """Scalars by the name of the whole, where its elements are all there and alike; else each by its own name.

    An array of FMI 3.0 is a whole of one variable.
    """
    by_name: dict[str, dict[tuple[int, ...], Any]] = {}
    arrays: dict[str, Any] = {}
    for scalar in scalars:
        match = _INDEXED.fullmatch(scalar.name) if not scalar.shape else None
        name, index = (match[1], tuple(map(int, match[2].split(",")))) if match else (scalar.name, ())
        members = by_name.setdefault(name, {})
        if scalar.shape:
            arrays[name] = scalar
        else:
            members[index] = scalar
    groups: dict[str, _Group] = {}
    for name, members in by_name.items():
        if name in arrays:
            groups[name] = arrays[name].shape, (), [arrays[name]]
        elif (whole := _whole(members)) is not None:
            groups[name] = whole
            continue
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


def _variable(
    name: str, shape: Any, first: Any, scalars: list[Any], native: Native, units: Any, displays: Any
) -> Variable:
    scalar = scalars[0]
    declared = scalar.declaredType

    def attribute(key: str, scalar: Any) -> Any:
        value, declared = getattr(scalar, key), scalar.declaredType
        return value if value is not None or declared is None else getattr(declared, key)

    named = [(attribute("unit", v), attribute("displayUnit", v)) for v in scalars]
    unit, apart = shared([units.get(name, Unit(name, None)) if name else None for name, _ in named])
    ordered, repeat = native.type in ("real", "integer"), math.prod(shape) // len(scalars)
    return Variable(
        name=name,
        causality=scalar.causality,
        type=native.type,
        shape=shape,
        references=tuple(v.valueReference for v in scalars),
        native=native,
        variability=scalar.variability,
        unit=unit,
        units=apart,
        display_unit=displays.get(named[0]) if len(set(named)) == 1 else None,
        minima=tuple(float(attribute("min", v) or "-inf") for v in scalars) * repeat if ordered else (),
        maxima=tuple(float(attribute("max", v) or "inf") for v in scalars) * repeat if ordered else (),
        nominal=min(_nominal(attribute("nominal", v)) for v in scalars) if native.type == "real" else 1.0,
        items=tuple((item.name, int(item.value)) for item in declared.items) if declared is not None else (),
        description=_common([v.description or "" for v in scalars]),
        first_index=first,
    )


def _common(descriptions: list[str]) -> str:
    """Returns what the descriptions of all elements begin with, or the first where that is next to nothing."""
    common = commonprefix(descriptions)  # character by character is meant  # noqa: RUF071
    common = common.rstrip(" [(,;:")
    return common if len(common) > 3 else descriptions[0]


def _nominal(declared: Any) -> float:
    """Returns what a description declares as nominal; 1 where it declares none that is a size."""
    size = abs(float(declared or 1.0))
    return size if 0.0 < size < math.inf else 1.0


def _dependencies(unknowns: list[Any], elements: dict[str, list[Element]]) -> dict[Element, frozenset[Element] | None]:
    dependencies: dict[Element, frozenset[Element] | None] = {}
    for unknown in unknowns:
        known, inputs = unknown.dependencies, None
        if known is not None:
            inputs = frozenset(e for v in known if v.causality == "input" for e in elements.get(v.name, ()))
        dependencies.update(dict.fromkeys(elements.get(unknown.variable.name, ()), inputs))
    return dependencies


def _feedthrough(description: Any, elements: dict[str, list[Element]]) -> dict[Element, frozenset[Element] | None]:
    """Returns what its outputs depend on directly, as it declares; on nothing where it has no input, whatever it
    declares.
    """
    if any(variable.causality == "input" for variable in description.modelVariables):
        return _dependencies(description.outputs, elements)
    outputs = [v.name for v in description.modelVariables if v.causality == "output"]
    return {element: frozenset() for name in outputs for element in elements.get(name, ())}


def _initial(description: Any, elements: dict[str, list[Element]]) -> dict[Element, frozenset[Element] | None]:
    dependencies = _dependencies(description.initialUnknowns, elements)
    direct = _feedthrough(description, elements)
    for variable in description.modelVariables:
        for element in elements.get(variable.name, ()) if variable.causality == "output" else ():
            exact = frozenset[Element]() if variable.initial == "exact" else direct.get(element)
            dependencies.setdefault(element, exact)
    return dependencies
