"""Types of the values in a scenario: times, quantities, amounts of memory."""

from __future__ import annotations

import math
import re
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
)

from ..errors import as_written
from ..quantities import ONE, SECOND, QuantityError, parse, parse_unit, value_in
from . import forms


def _seconds(value: Any, info: ValidationInfo) -> float:
    try:
        return value_in(value, SECOND)
    except QuantityError as error:
        if (counted := cycles(value, info.context)) is not None:
            return counted
        raise ValueError(f"{error}; expected seconds, {_EXPECTED}") from None


_EXPECTED = "text such as '10 min', or a count of what 'cycle' names"


def cycles(value: Any, scenario: Any) -> float | None:
    """Seconds of "2 orbits", where the scenario's `cycle` is called so; None where it is not, or is not sound."""
    cycle = scenario.get("cycle") if isinstance(scenario, dict) else None
    match = re.fullmatch(r"\s*(\S+)\s*([^\W\d]\w*)\s*", value) if isinstance(value, str) else None
    if (
        match is None
        or not isinstance(cycle, dict)
        or match[2].removesuffix("s") != str(cycle.get("name")).removesuffix("s")
    ):
        return None
    try:
        return value_in(match[1], ONE) * value_in(cycle.get("period"), SECOND)
    except QuantityError:
        return None


def _in_seconds(value: Any, info: ValidationInfo) -> Any:
    if isinstance(value, list):
        return [_in_seconds(item, info) for item in value]
    counted = cycles(value, info.context)
    return value if counted is None else f"{counted!r} s"


Counted = BeforeValidator(_in_seconds)
"""Before a quantity: makes seconds of what is counted in the scenario's `cycle`, `0.2 orbits`."""


def _positive(value: float) -> float:
    if value <= 0.0:
        raise ValueError(f"expected a time above zero, found {value:g} s")
    return value


def _kilograms(value: Any) -> float:
    try:
        kilograms = value_in(value, parse_unit("kg"))
    except QuantityError as error:
        raise ValueError(f"{error}; expected kg, or text such as '4 kg'") from None
    if not 0.0 < kilograms < math.inf:
        raise ValueError(f"expected a mass above zero, found {value}")
    return kilograms


def quantity(value: Any) -> Any:
    if isinstance(value, str):
        parse(value)
    elif isinstance(value, bool) or not isinstance(value, (int, float)) or value != value:
        raise ValueError(f"expected a number or text with a unit, found {as_written(value)}")
    return value


def unit_name(value: Any) -> Any:
    if isinstance(value, str):
        parse_unit(value)
    return value


NUMBER_OR_TEXT: list[dict[str, Any]] = [{"type": "number"}, {"type": "string"}]
Time = Annotated[float, BeforeValidator(_seconds), WithJsonSchema({"anyOf": NUMBER_OR_TEXT})]
Period = Annotated[Time, AfterValidator(_positive)]
Mass = Annotated[float, BeforeValidator(_kilograms), WithJsonSchema({"anyOf": NUMBER_OR_TEXT})]
Quantity = Annotated[Any, BeforeValidator(quantity), WithJsonSchema({"anyOf": NUMBER_OR_TEXT})]
UnitName = Annotated[str, BeforeValidator(unit_name), Field(strict=True)]
_VALUE = {"anyOf": [*NUMBER_OR_TEXT, {"type": "boolean"}, {"type": "array"}, *forms.SCHEMA]}
Value = Annotated[Any, WithJsonSchema(_VALUE)]


class Model(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    def _only(self, *names: str) -> str:
        """Returns which one of these fields is given. Raises ValueError where none is, or several."""
        given = [name for name in names if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"expected exactly one of {', '.join(names)}; found {' and '.join(given) or 'none'}")
        return given[0]


def _whole_or_extending(schema: dict[str, Any]) -> None:
    schema["anyOf"] = [{"required": schema.pop("required")}, {"required": ["extends"]}]
    for name, entry in schema["properties"].items():
        if entry.get("type") == "array":
            whole = {key: entry.pop(key) for key in ("type", "items")}
            kinds = ("add", "replace") if name == "connections" else ("add",)
            change = {"type": "object", "properties": dict.fromkeys(kinds, whole), "minProperties": 1}
            entry["anyOf"] = [whole, change | {"additionalProperties": False}]


class Extending(Model):
    """A file that may extend others, and may leave to them what it needs."""

    model_config = ConfigDict(json_schema_extra=_whole_or_extending)

    extends: Annotated[str, Field(min_length=1)] | list[Annotated[str, Field(min_length=1)]] = []
    """Files that this one extends, relative to it: each is one of its kind, or a part of one such as a satellite's
    values. Mappings are merged, lists and values replaced, a list `{add: [...]}` adds to the one below, connections
    `{replace: [...]}` replace those to the same inputs, a null takes an entry out. A later file overrides an earlier
    one, this file overrides all of them."""

    @field_validator("extends")
    @classmethod
    def _laid_over(cls, files: Any) -> Any:
        if files:
            raise ValueError("only a file in YAML, or one given as data, extends others")
        return files


Flavour = Literal["native", "python"]
Isolation = Literal["process", "none"]

_BYTES = {"": 1, "B": 1, "kB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12, "KiB": 2**10, "MiB": 2**20, "GiB": 2**30}


def _bytes(value: Any) -> int:
    match = re.fullmatch(r"\s*(\d+\.?\d*)\s*([A-Za-z]*)\s*", str(value))
    if match is None or match[2] not in _BYTES or isinstance(value, bool):
        raise ValueError(f"expected an amount of memory such as '2 GB', found {as_written(value)}")
    size = float(match[1]) * _BYTES[match[2]]
    if size > 1e18:
        raise ValueError(f"expected at most 1e18 bytes, found {size:g}")
    count = round(size)
    if count < 10**6:
        raise ValueError(f"expected at least 1 MB, found {count} bytes")
    return count


Bytes = Annotated[int, BeforeValidator(_bytes), WithJsonSchema({"anyOf": NUMBER_OR_TEXT})]
