"""The model of an FMU, from what FMPy read of its modelDescription.xml."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

from ..errors import InputError
from ..quantities import Exponents, Unit
from .model import Element, Model, Variable, shared


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
    groups = _groups([v for v in description.modelVariables if v.causality != "independent"])
    variables: dict[str, Variable] = {}
    elements: dict[str, Element] = {}
    for name, (shape, first, scalars) in groups.items():
        variables[name] = _variable(name, shape, first, scalars, units, displays)
        if all(scalar.causality == "input" and scalar.name in optional for scalar in scalars):
            variables[name] = replace(variables[name], optional=True)
        if len(stated := {(quantities or {}).get(scalar.name) for scalar in scalars}) == 1:
            variables[name] = replace(variables[name], quantity=stated.pop() or None)
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
    by_name: dict[str, dict[tuple[int, ...], Any]] = {}
    for scalar in scalars:
        match = _INDEXED.fullmatch(scalar.name)
        name, index = (match[1], tuple(map(int, match[2].split(",")))) if match else (scalar.name, ())
        by_name.setdefault(name, {})[index] = scalar
    groups: dict[str, _Group] = {}
    for name, members in by_name.items():
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
    dependencies: dict[Element, frozenset[Element] | None] = {}
    for unknown in unknowns:
        if unknown.variable.name in elements:
            known = unknown.dependencies
            inputs = known and (v for v in known if v.causality == "input")
            dependencies[elements[unknown.variable.name]] = (
                None if known is None else frozenset(elements[v.name] for v in inputs or ())
            )
    return dependencies


def _initial(description: Any, elements: dict[str, Element]) -> dict[Element, frozenset[Element] | None]:
    dependencies = _dependencies(description.initialUnknowns, elements)
    direct = _dependencies(description.outputs, elements)
    for scalar in description.modelVariables:
        if scalar.causality == "output" and elements[scalar.name] not in dependencies:
            exact = scalar.initial == "exact"
            dependencies[elements[scalar.name]] = frozenset() if exact else direct.get(elements[scalar.name])
    return dependencies


def starts_of(description: Any, model: Model) -> dict[Element, Any]:
    """The start values of an FMU's inputs and parameters, items of enumerations as numbers. Raises InputError."""
    by_label = {
        variable.label(position): (variable, Element(variable.name, position))
        for variable in model.variables.values()
        for position in range(variable.size)
    }
    starts: dict[Element, Any] = {}
    for scalar in description.modelVariables:
        entry = by_label.get("][".join(part.strip() for part in scalar.name.split(",")))
        if entry is None or scalar.start is None or scalar.causality not in ("input", "parameter"):
            continue
        variable, element = entry
        starts[element] = _start(variable, scalar)
    return starts


def _start(variable: Variable, scalar: Any) -> float | int | bool | str:
    text = str(scalar.start)
    if variable.type == "string":
        return text
    if variable.type == "boolean":
        if text.strip().lower() not in ("true", "1", "false", "0"):
            raise _wrong_start(scalar, "true or false")
        return text.strip().lower() in ("true", "1")
    try:
        return float(text) if variable.type == "real" else int(float(text))
    except (ValueError, OverflowError):
        raise _wrong_start(scalar, "a number") from None


def _wrong_start(scalar: Any, expected: str) -> InputError:
    return InputError(f"modelDescription.xml: {scalar.name} has the start value {scalar.start!r}; expected {expected}")
