"""The start values that a modelDescription.xml declares, by the elements of the model."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from ..errors import InputError
from .model import Element, Model, Variable


def scalars_of(description: Any, model: Model) -> Iterator[tuple[str, Any, Element]]:
    """FMI's name of each element, as `R_NB[2,3]`, FMPy's variable and the element. Aliases have none of their own."""
    labels = {variable.label(e.position): e for variable in model.variables.values() for e in variable.elements}
    for scalar in description.modelVariables:
        if scalar.shape and scalar.name in model.variables:
            variable = model.variables[scalar.name]
            for element in variable.elements:
                index = variable.label(element.position)[len(scalar.name) :]
                yield scalar.name + index.replace("][", ","), scalar, element
        elif not scalar.shape and (found := labels.get("][".join(part.strip() for part in scalar.name.split(",")))):
            yield scalar.name, scalar, found


def starts_of(description: Any, model: Model) -> dict[Element, Any]:
    """The start values of an FMU's inputs and parameters, items of enumerations as numbers. Raises InputError."""
    starts: dict[Element, Any] = {}
    for name, scalar, element in scalars_of(description, model):
        if scalar.start is not None and scalar.causality in ("input", "parameter"):
            text = str(scalar.start)
            if scalar.shape:  # one value for all elements, or one for each
                texts = text.split()
                if len(texts) not in (1, math.prod(scalar.shape)):
                    raise InputError(
                        f"modelDescription.xml: {scalar.name} has {len(texts)} start values; "
                        f"expected one or {math.prod(scalar.shape)}"
                    )
                text = texts[element.position if len(texts) > 1 else 0]
            starts[element] = _start(model.variables[element.variable], name, text)
    return starts


def _start(variable: Variable, name: str, text: str) -> float | int | bool | str:
    if variable.type == "string":
        return text
    if variable.type == "boolean":
        if text.strip().lower() not in ("true", "1", "false", "0"):
            raise _wrong_start(name, text, "true or false")
        return text.strip().lower() in ("true", "1")
    try:
        return float(text) if variable.type == "real" else _whole_number(text)
    except (ValueError, OverflowError):
        raise _wrong_start(name, text, "a number") from None


def _whole_number(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        return int(float(text))


def _wrong_start(name: str, found: str, expected: str) -> InputError:
    return InputError(f"modelDescription.xml: {name} has the start value {found!r}; expected {expected}")
