"""Values that a user writes for a variable, checked and brought into its unit."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np

from ..errors import as_written, nearest, suggestion
from ..fmu.model import Element, Model, Variable, unit_of
from ..quantities import Quantity, QuantityError, Unit, convert, parse, suffix, value_in
from ..scenario.forms import matrix
from ..scenario.references import Name

Scalar = float | int | bool | str


def values_of(block: str, model: Model, name: Name, value: Any) -> dict[Element, Scalar]:
    """The values of a parameter or input, or of an element of it. Raises QuantityError or NameUnknown."""
    variable, positions = model.find(block, name.variable, name.indices, ("parameter", "input"), "parameter")
    if variable.causality not in ("parameter", "input"):
        kind = f"{'an' if variable.causality[0] in 'aeiou' else 'a'} {variable.causality}"
        # What an output starts at, not what is spelt alike: omega_B0 for omega_B, and for b_B no J_B.
        start = next((v.name for v in model.of("parameter", "input") if v.name.startswith(variable.name)), None)
        text = f"{block}.{variable.name} is {kind}; only parameters and inputs take start values"
        raise QuantityError(f"{text}{suggestion(start)}")
    shape = variable.shape if len(positions) == variable.size else ()
    scalars = leaves(value, shape, variable)
    try:
        return {
            Element(variable.name, p): scalar(variable.at([p]), p, leaf)
            for p, leaf in zip(positions, scalars, strict=True)
        }
    except QuantityError as error:
        raise QuantityError(f"{error}{_as_helper(model, variable, value)}") from None


def _as_helper(model: Model, variable: Variable, value: Any) -> str:
    """The helper input that stands for this variable, where a number that the variable refuses is right for it."""
    for name, helper in model.helpers.items():
        if not variable.shape and helper.gives == variable.name:
            with suppress(QuantityError):
                scalar(helper.variable, 0, value)
                return f"; did you mean '{name}: {value}'?"
    return ""


def leaves(value: Any, shape: tuple[int, ...], variable: Variable) -> list[Any]:
    """The elements of a value of this shape, row by row. Raises QuantityError where the shape differs."""
    wanted = f"expected {_shape_in_words(variable.shape if shape else ())}"
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        value = matrix(value)
    items = [value]
    for length in shape:
        if not all(isinstance(item, (list, tuple)) and len(item) == length for item in items):
            raise QuantityError(f"{wanted}, found {_shape_found(value)}")
        items = [leaf for item in items for leaf in item]
    if any(isinstance(leaf, (list, tuple)) for leaf in items):
        raise QuantityError(f"{wanted}, found {_shape_found(value)}")
    return items


def nested(variable: Variable, flat: list[Any]) -> Any:
    """The elements of a variable, given row by row, as lists of its shape; a scalar as itself."""
    for length in reversed(variable.shape):
        flat = [flat[i : i + length] for i in range(0, len(flat), length)]
    return flat[0]


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
        code = variable.native.code if variable.native else "i4"
        if not np.iinfo(code).min <= value <= np.iinfo(code).max:
            sign = " from 0 on" if code[0] == "u" else ""
            raise QuantityError(f"expected a whole number of {8 * int(code[1])} bits{sign}, found {value}")
        return _limited(variable, position, value, value)
    return _limited(variable, position, _real(variable, value), value)


def item(variable: Variable, value: Any) -> int:
    """The number of an enumeration's item, given by its name, or by its number as archives for other tools have it."""
    items = dict(variable.items)
    if type(value) is int and value in items.values():
        return value
    if isinstance(value, bool) or str(value) not in items:
        match = suggestion(nearest(str(value), items))
        raise QuantityError(f"expected one of {', '.join(items)}, found {as_written(value)}{match}")
    return items[str(value)]


def _real(variable: Variable, value: Any) -> float:
    unit = unit_of(variable)
    if isinstance(value, Quantity) and unit.exponents is None:
        value = str(value)
    if isinstance(value, str) and unit.exponents is None:
        # The FMU names its unit without defining it: only the same name, or no unit, will do.
        number, own = (
            parse(value)
            if not value.strip().endswith(unit.name)
            else (*parse(value.strip()[: -len(unit.name)])[:1], None)
        )
        return convert(number, own, unit) if own is not None else number
    if variable.unit is None and (own := _unit_of(value)) is not None and not own.fits(unit):
        raise QuantityError(f"{variable.name} has no unit, so expected a bare number, found {as_written(value)}")
    return value_in(value, unit)


def _unit_of(value: Any) -> Unit | None:
    """Returns the unit that a value says, if it says one."""
    if isinstance(value, Quantity):
        return value.unit
    return parse(value)[1] if isinstance(value, str) else None


def _limited(variable: Variable, position: int, number: float, value: Any) -> float:
    low = variable.minima[position] if variable.minima else float("-inf")
    high = variable.maxima[position] if variable.maxima else float("inf")
    if low <= number <= high:
        return number
    unit = suffix(variable.unit)
    value = str(value) if isinstance(value, Quantity) else value
    given = f" ({value})" if isinstance(value, str) and not _is(value, number, unit) else ""
    element = f"{variable.label(position)}: " if variable.shape else ""
    side = f"at least {low:.10g}" if number < low else f"at most {high:.10g}"
    bare = _bare(variable, value, low, high)
    raise QuantityError(f"{element}expected {side}{unit}, found {number:.10g}{unit}{given}{bare}")


def _bare(variable: Variable, value: Any, low: float, high: float) -> str:
    """A remedy for a number without a unit that would be within the limits in the unit that pages show."""
    unit, shown = unit_of(variable), variable.display_unit
    with suppress(QuantityError, ValueError):
        if shown is not None and str(shown) != str(unit) and low <= convert(float(value), shown, unit) <= high:
            return f"; a bare number is in {unit}, remedy: '{value} {shown}'"
    return ""


def _is(text: str, number: float, unit: str) -> bool:
    """Returns whether a text gives this number in this unit, or in none."""
    try:
        return float(text.strip().removesuffix(unit.strip())) == number
    except ValueError:
        return False
