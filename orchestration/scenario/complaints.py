"""What Pydantic finds wrong with a scenario, as sentences that name file, line, expectation and remedy."""

from __future__ import annotations

from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from ..errors import InputError, as_written, nearest, suggestion
from .descriptions import descriptions
from .source import Key, Source

T = TypeVar("T", bound=BaseModel)


def checked(model: type[T], source: Source, context: Any = None) -> T:
    """What the source holds, as this model. Raises InputError with a message for each thing that is wrong.

    `context` is the data of the scenario in whose cycles times are counted, by default those of the source.
    """
    if not isinstance(source.data, dict):
        keys = " and ".join(f"'{name}'" for name in _FIRST.get(model.__name__, ("name", "blocks")))
        raise InputError(source.error((), f"expected keys such as {keys}, found {as_written(source.data)}"))
    try:
        return model.model_validate(source.data, context=source.data if context is None else context)
    except ValidationError as error:
        details = sorted(error.errors(include_url=False), key=lambda detail: detail["type"] == "missing")
        meant = {(*_key(d)[:-1], _match(model, d)) for d in details if d["type"] == "extra_forbidden"}
        # A misspelt key is not missing as well.
        messages = [_message(model, source, d) for d in details if d["type"] != "missing" or _key(d) not in meant]
        raise InputError(*dict.fromkeys(messages)) from None


_FIRST = {"Mapping": ("ports", "ignore"), "Campaign": ("scenario", "metrics")}

_EXPECTED = {
    "string_type": "text",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "list_type": "a list",
    "dict_type": "names with values",
    "model_type": "names with values",
    "model_attributes_type": "names with values",
}


def _key(detail: Any) -> Key:
    return tuple(part for part in detail["loc"] if part != "[key]")


def _match(model: type[BaseModel], detail: Any) -> str | None:
    """The key that an unknown one is nearly."""
    key = _key(detail)
    return nearest(str(key[-1]), _model_at(model, key[:-1]).model_fields)


def _message(model: type[BaseModel], source: Source, detail: Any) -> str:
    key = _key(detail)
    kind, value, context = detail["type"], detail["input"], detail.get("ctx", {})
    if kind == "extra_forbidden":
        known = ", ".join(_model_at(model, key[:-1]).model_fields)
        ending = suggestion(_match(model, detail)) or f"; expected one of {known}"
        return _at(source, key, key[:-1], f"unknown key {key[-1]!r}{ending}")
    if kind == "missing":
        about = descriptions(_model_at(model, key[:-1])).get(str(key[-1]), "")
        return source.error(key[:-1], f"{key[-1]!r} is missing: {_begin(about)}")
    if kind == "value_error":
        text = str(context["error"])
    elif kind in _EXPECTED:
        text = f"expected {_EXPECTED[kind]}, found {as_written(value)}"
    elif kind == "literal_error":
        text = f"expected {context['expected']}, found {as_written(value)}{_item(value, context['expected'])}"
    elif kind == "greater_than_equal":
        text = f"expected {context['ge']} or more, found {value}"
    elif kind in ("too_short", "string_too_short"):
        text = "must not be empty"
    elif kind == "string_pattern_mismatch":
        dashes = " . -" if ".-]" in context["pattern"] else ""
        dashes += ", and spaces within" if " .-]" in context["pattern"] else ""
        text = f"expected a name of letters, digits and _{dashes}, found {as_written(value)}"
    else:
        text = f"{detail['msg'][0].lower()}{detail['msg'][1:]}, found {as_written(value)}"
    return source.error(key, text)


def _at(source: Source, key: Key, shown: Key, text: str) -> str:
    """The message at the line of `key`, under the name of `shown`, the part that holds it."""
    line = source.lines.get(key)
    if not line:
        return source.error(shown, text)
    file = source.files.get(key, source.file)
    return Source(None, file, lines={shown: line}, options=source.options).error(shown, text)


def _model_at(model: type[BaseModel], key: Key) -> type[BaseModel]:
    for part in key:
        field = model.model_fields.get(part) if isinstance(part, str) else None
        if field is None:
            continue  # a name in a dictionary or a place in a list
        model = next(filter(_is_model, _leaves(field.annotation)), model)
    return model


def _leaves(annotation: Any) -> list[Any]:
    arguments = get_args(annotation)
    return [leaf for argument in arguments for leaf in _leaves(argument)] if arguments else [annotation]


def _is_model(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def _item(value: Any, expected: str) -> str:
    names = expected.replace("'", "").replace(" or ", ", ").split(", ")
    return suggestion(nearest(str(value), names))


def _begin(text: str) -> str:
    """The first sentence of a description, to stand within another one."""
    first = " ".join(text.split()).split(". ")[0].rstrip(".;")
    return first[:1].lower() + first[1:]
