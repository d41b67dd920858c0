"""Matrices as engineers state them: a diagonal, and a rotation by axis and angle, by Euler angles or by a quaternion.

A rotation turns vectors, x' = R x; as the attitude of axes, its columns are the turned axes.
"""

from __future__ import annotations

from typing import Any

from .. import rotation
from ..errors import as_written, nearest, suggestion
from ..quantities import ONE, QuantityError, parse_unit, value_in

_RADIAN = parse_unit("rad")
_FORMS: dict[str, tuple[str, ...]] = {
    "diagonal": (),
    "axis": ("angle",),
    "euler": ("sequence",),
    "quaternion": (),
}
"""By its first key, what else a form needs."""

_ITEM = {"anyOf": [{"type": "number"}, {"type": "string"}]}
_TEXT = {
    "diagonal": {"type": "array", "items": _ITEM, "minItems": 1},
    "axis": {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3},
    "angle": _ITEM,
    "euler": {"type": "array", "items": _ITEM, "minItems": 3, "maxItems": 3},
    "sequence": {"type": "string", "pattern": "^([xyz]{3}|[XYZ]{3})$"},
    "quaternion": {"type": "array", "items": {"type": "number"}, "minItems": 4, "maxItems": 4},
}
SCHEMA: list[dict[str, Any]] = [
    {
        "type": "object",
        "properties": {key: _TEXT[key] for key in (first, *more)},
        "required": [first, *more],
        "additionalProperties": False,
    }
    for first, more in _FORMS.items()
]
"""Of each form, in JSON Schema."""


def matrix(form: dict[str, Any]) -> list[list[Any]]:
    """The matrix that a form stands for, row by row. Raises QuantityError where it is none."""
    first = next((name for name in _FORMS if name in form), None)
    keys = (first, *_FORMS[first]) if first else tuple(_FORMS)
    if first is None or set(form) != set(keys):
        unknown = next((key for key in form if key not in keys), None)
        expected = f"the key{'s' * (len(keys) > 1)} {' and '.join(keys)}" if first else f"one of {', '.join(keys)}"
        found = " and ".join(map(str, form)) or "none"
        known = (*_FORMS, *(key for more in _FORMS.values() for key in more))
        match = suggestion(nearest(unknown, known)) if unknown and unknown not in known else ""
        raise QuantityError(f"expected {expected}, found {found}{match}")
    if first == "diagonal":
        values = _items(form, "diagonal")
        return [[value if i == j else 0.0 for j in range(len(values))] for i, value in enumerate(values)]
    try:
        if first == "axis":
            R = rotation.about(_numbers(form, "axis", 3), _within("angle", form["angle"]))
        elif first == "euler":
            angles = [_within("euler", angle) for angle in _items(form, "euler", 3)]
            R = rotation.euler(angles, form["sequence"])
        else:
            R = rotation.matrix(_numbers(form, "quaternion", 4))
    except ValueError as error:
        raise QuantityError(str(error)) from None
    return [R[0:3], R[3:6], R[6:9]]


def _items(form: dict[str, Any], key: str, count: int | None = None) -> list[Any]:
    value = form[key]
    if not isinstance(value, (list, tuple)) or not value or (count is not None and len(value) != count):
        found = f"a list of {len(value)}" if isinstance(value, (list, tuple)) else as_written(value)
        raise QuantityError(f"{key}: expected a list of {count or 'the values'}, found {found}")
    return list(value)


def _numbers(form: dict[str, Any], key: str, count: int) -> list[float]:
    return [_within(key, value, ONE) for value in _items(form, key, count)]


def _within(key: str, value: Any, unit: Any = _RADIAN) -> float:
    try:
        return value_in(value, unit)
    except QuantityError as error:
        raise QuantityError(f"{key}: {error}") from None
