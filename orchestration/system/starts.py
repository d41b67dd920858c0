"""Start values of a scenario, checked and brought into the unit of the port."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import InputError, as_written, nearest, suggestion
from ..fmu.model import Element, Model, NameUnknown, Variable, unit_of
from ..quantities import QuantityError, convert, parse, value_in
from ..scenario.references import Name
from ..scenario.scenario import Scenario

Scalar = float | int | bool | str


@dataclass(frozen=True)
class Start:
    """A value to be set before initialization, as FMI stores it: items of enumerations as numbers."""

    element: Element
    value: Scalar


def resolve(scenario: Scenario, models: Mapping[str, Model]) -> dict[str, list[Start]]:
    """The start values of each block. Raises InputError with everything that is wrong."""
    starts: dict[str, list[Start]] = {}
    errors: list[str] = []
    for block, entry in scenario.blocks.items():
        given: dict[Element, Scalar] = {}
        first: dict[Element, str] = {}
        for name, value in entry.start.items():
            key = ("blocks", block, "start", name)
            try:
                values = values_of(block, models[block], name, value)
                if key not in scenario.source.options:  # an option takes the place of what the file says
                    _refuse_twice(scenario, key, first, values)
                given.update(values)
            except (QuantityError, NameUnknown) as error:
                # The place ends with the variable's name only where the variable is known.
                known = name.variable in models[block].variables
                errors.append(_at(scenario, key, key if known else key[:-1], str(error)))
        starts[block] = [Start(element, value) for element, value in given.items()]
    if errors:
        raise InputError(*errors)
    return starts


def _refuse_twice(
    scenario: Scenario, key: tuple[str, ...], first: dict[Element, str], values: Mapping[Element, Scalar]
) -> None:
    if again := next((element for element in values if element in first), None):
        line = scenario.source.lines.get((*key[:-1], first[again]))
        place = f", in line {line}" if line else ""
        raise QuantityError(f"has a start value already, by {first[again]!r}{place}")
    first.update(dict.fromkeys(values, key[-1]))


def _at(scenario: Scenario, key: tuple[str, ...], shown: tuple[str, ...], text: str) -> str:
    place = scenario.source.where(key)
    return f"{place.removesuffix('.' + key[-1]) if shown != key else place}: {text}"


def values_of(block: str, model: Model, name: Name, value: Any) -> dict[Element, Scalar]:
    """The values of a parameter or input, or of an element of it. Raises QuantityError or NameUnknown."""
    try:
        variable, positions = model.find(block, name.variable, name.indices, ("parameter", "input"))
    except NameUnknown as error:
        raise NameUnknown(str(error).replace("parameter or input", "parameter")) from None
    if variable.causality not in ("parameter", "input"):
        match = nearest(variable.name, (v.name for v in model.of("parameter", "input")))
        raise QuantityError(
            f"{block}.{variable.name} is of causality {variable.causality}; parameters and inputs have starts"
            f"{suggestion(match)}"
        )
    shape = variable.shape if len(positions) == variable.size else ()
    scalars = leaves(value, shape, variable)
    return {
        Element(variable.name, p): scalar(variable.at([p]), p, leaf) for p, leaf in zip(positions, scalars, strict=True)
    }


def leaves(value: Any, shape: tuple[int, ...], variable: Variable) -> list[Any]:
    """The elements of a value of this shape, row by row. Raises QuantityError where the shape differs."""
    wanted = f"expected {_shape_in_words(variable.shape if shape else ())}"
    if hasattr(value, "tolist"):
        value = value.tolist()
    items = [value]
    for length in shape:
        if not all(isinstance(item, (list, tuple)) and len(item) == length for item in items):
            raise QuantityError(f"{wanted}, found {_shape_found(value)}")
        items = [leaf for item in items for leaf in item]
    if any(isinstance(leaf, (list, tuple)) for leaf in items):
        raise QuantityError(f"{wanted}, found {_shape_found(value)}")
    return items


def _shape_in_words(shape: tuple[int, ...]) -> str:
    if not shape:
        return "one value"
    return f"a list of {shape[0]} values" if len(shape) == 1 else f"{shape[0]} rows of {shape[1]} values"


def _shape_found(value: Any) -> str:
    if not isinstance(value, (list, tuple)):
        return as_written(value)
    lengths = {len(row) if isinstance(row, (list, tuple)) else 0 for row in value}
    if lengths == {0} or not value:
        return f"a list of {len(value)}"
    return f"{len(value)} rows of {' or '.join(map(str, sorted(lengths)))}"


def scalar(variable: Variable, position: int, value: Any) -> Scalar:
    """The value of one element, in the unit of its port and within its limits. Raises QuantityError."""
    if hasattr(value, "item"):  # a scalar of NumPy's
        value = value.item()
    if variable.type == "string":
        if not isinstance(value, str):
            raise QuantityError(f"expected text, found {as_written(value)}")
        return value
    if variable.type == "boolean":
        if not isinstance(value, bool):
            raise QuantityError(f"expected true or false, found {as_written(value)}")
        return value
    if variable.type == "enumeration":
        return item(variable, value)
    if variable.type == "integer":
        if isinstance(value, bool) or not isinstance(value, int):
            raise QuantityError(f"expected a whole number, found {as_written(value)}")
        if not -(2**31) <= value < 2**31:
            raise QuantityError(f"expected a whole number of 32 bits, found {value}")
        return _limited(variable, position, value, value)
    return _limited(variable, position, _real(variable, value), value)


def item(variable: Variable, value: Any) -> int:
    """The number of an enumeration's item, given by its name."""
    items = dict(variable.items)
    if isinstance(value, bool) or str(value) not in items:
        match = suggestion(nearest(str(value), items))
        raise QuantityError(f"expected one of {', '.join(items)}, found {as_written(value)}{match}")
    return items[str(value)]


def _real(variable: Variable, value: Any) -> float:
    unit = unit_of(variable)
    if isinstance(value, str) and unit.exponents is None:
        # The FMU names its unit without defining it: only the same name, or no unit, will do.
        number, own = (
            parse(value)
            if not value.strip().endswith(unit.name)
            else (*parse(value.strip()[: -len(unit.name)])[:1], None)
        )
        return convert(number, own, unit) if own is not None else number
    try:
        return value_in(value, unit)
    except QuantityError as error:
        if isinstance(value, str) and variable.unit is None and "does not fit" in str(error):
            raise QuantityError(
                f"{variable.name} has no unit, so expected a bare number, found {as_written(value)}"
            ) from None
        raise


def _limited(variable: Variable, position: int, number: float, value: Any) -> float:
    low = variable.minima[position] if variable.minima else float("-inf")
    high = variable.maxima[position] if variable.maxima else float("inf")
    if low <= number <= high:
        return number
    unit = f" {variable.unit}" if variable.unit and str(variable.unit) != "1" else ""
    given = "" if str(value) == f"{number}" or not isinstance(value, str) else f" ({value})"
    element = f"{variable.label(position)}: " if variable.shape else ""
    side = f"at least {low:.10g}" if number < low else f"at most {high:.10g}"
    raise QuantityError(f"{element}expected {side}{unit}, found {number:.10g}{unit}{given}")
