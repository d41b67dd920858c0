"""What Pydantic finds wrong with a scenario, as sentences that name file, line, expectation and remedy."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from ..errors import InputError, Place, Problem, as_written, in_kind, nearest, suggestion
from .descriptions import descriptions
from .source import Key, Source

T = TypeVar("T", bound=BaseModel)


def checked(model: type[T], source: Source, context: Any = None) -> T:
    """Returns what the source holds, as this model. Raises InputError with a message for each thing that is wrong.

    `context` is the data of the scenario in whose cycles times are counted, by default those of the source.
    """
    if not isinstance(source.data, dict):
        raise InputError(source.error((), expected=_keys(model), found=in_kind(source.data)))
    hidden = _foreign(model, source)
    try:
        return model.model_validate(source.data, context=source.data if context is None else context)
    except ValidationError as error:
        details = sorted(error.errors(include_url=False), key=lambda detail: detail["type"] == "missing")
        meant = {(*_key(d)[:-1], _match(model, d)) for d in details if d["type"] == "extra_forbidden"}
        # A misspelt key is not missing as well.
        details = [d for d in details if (d["type"] != "missing" or _key(d) not in meant) and _key(d) not in hidden]
        problems = [
            each for key, group in _grouped(source.data, details) for each in _together(model, source, key, group)
        ]
        raise InputError(*dict.fromkeys(problems)) from None


def _keys(model: type[BaseModel]) -> str:
    return "keys such as " + " and ".join(f"'{name}'" for name in _FIRST.get(model.__name__, ("name", "blocks")))


def _foreign(model: type[BaseModel], source: Source) -> set[Key]:
    """Returns the keys of files of which none is known, but for those that are nearly known: what such a file holds may
    be confidential, and is not told.

    Raises InputError where a file has no others.
    """
    known = model.model_fields
    files: dict[str | None, list[Any]] = {}
    for key in [key for key in source.data if (key,) in source.lines]:
        files.setdefault(source.files.get((key,), source.file), []).append(key)
    files.pop(None, None)
    strange = {file: keys for file, keys in files.items() if not known.keys() & set(keys)}
    hidden = {file: {(key,) for key in keys if nearest(key, known) is None} for file, keys in strange.items()}
    if foreign := [file for file, keys in strange.items() if len(hidden[file]) == len(keys)]:
        raise InputError(*(Problem(expected=_keys(model), found="none", place=Place(file)) for file in foreign))
    return {key for keys in hidden.values() for key in keys}


def _grouped(data: Any, details: list[Any]) -> list[tuple[Key | None, list[Any]]]:
    """Each error alone, with None; those of the kinds of value that one place may have together, with its key."""
    groups: list[tuple[Key | None, list[Any]]] = []
    for detail in details:
        key = _of_union(data, detail)
        if key is not None and groups and groups[-1][0] == key:
            groups[-1][1].append(detail)
        else:
            groups.append((key, [detail]))
    return groups


def _of_union(data: Any, detail: Any) -> Key | None:
    """Returns where Pydantic's location goes on with the name of a kind of value, which is no key of the data: the key
    up to there.
    """
    location = detail["loc"]
    for i, part in enumerate(location):
        if (isinstance(data, dict) and part in data) or (
            isinstance(data, list) and isinstance(part, int) and part < len(data)
        ):
            data = data[part]
        elif part != "[key]":
            return None if detail["type"] == "missing" and i == len(location) - 1 else _key(detail)[:i]
    return None


def _together(model: type[BaseModel], source: Source, key: Key | None, group: list[Any]) -> list[Problem]:
    """Returns the errors of a group.

    Of a place that may have several kinds of value, those of the kind that it nearly has, or one of all kinds.
    """
    if key is None:
        return [_problem(model, source, detail) for detail in group]
    # Location: the place, the kind, then the way to what is wrong inside a value of this kind.
    inside = [{**d, "loc": (*key, *d["loc"][len(key) + 1 :])} for d in group if len(d["loc"]) > len(key) + 1]
    if inside:
        return [_problem(model, source, detail) for detail in inside]
    beyond = [detail for detail in group if detail["type"] in _LIMITS]  # it is of the right kind
    each = [_wrong(detail) for detail in beyond or group]
    if not all(wrong.expected and wrong.found for wrong in each):
        return [wrong.at(source.place(key)) for wrong in each]
    expected = " or ".join(wrong.expected for wrong in each)
    return [source.error(key, expected=expected, found=as_written(group[0]["input"]))]


_FIRST = {"Mapping": ("ports", "ignore"), "Campaign": ("scenario", "metrics")}

_EXPECTED = {
    "string_type": "text",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "float_parsing": "a number",
    "finite_number": "a finite number",
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


def _problem(model: type[BaseModel], source: Source, detail: Any) -> Problem:
    key, kind = _key(detail), detail["type"]
    if kind == "extra_forbidden":
        known = ", ".join(_model_at(model, key[:-1]).model_fields)
        ending = suggestion(_match(model, detail)) or f"; expected one of {known}"
        # It stands in the line of the key, under the name of the part that holds it.
        own, part = source.place(key), source.place(key[:-1])
        place = replace(own, name=part.name) if own.line else part
        return Problem(f"unknown key {key[-1]!r}{ending}", place=place)
    if kind == "missing":
        about = descriptions(_model_at(model, key[:-1])).get(str(key[-1]), "")
        return source.error(key[:-1], f"{key[-1]!r} is missing" + (f": {_begin(about)}" if about else ""))
    return _wrong(detail).at(source.place(key))


_LIMITS = {
    "greater_than_equal": ("ge", "{} or more"),
    "greater_than": ("gt", "more than {}"),
    "less_than_equal": ("le", "{} or less"),
    "less_than": ("lt", "less than {}"),
}


def _wrong(detail: Any) -> Problem:
    """Returns what was expected and what was found, without a place."""
    kind, value, context = detail["type"], detail["input"], detail.get("ctx", {})
    if kind == "value_error":
        error = context["error"]
        return error.problems[0] if isinstance(error, InputError) else Problem(str(error))
    if kind in _EXPECTED:
        return Problem(expected=_EXPECTED[kind], found=as_written(value))
    if kind == "literal_error":
        found = f"{as_written(value)}{_item(value, context['expected'])}"
        return Problem(expected=context["expected"], found=found)
    if kind in _LIMITS:
        name, words = _LIMITS[kind]
        return Problem(expected=words.format(f"{context[name]:g}"), found=str(value))
    if kind == "string_too_short" or (kind == "too_short" and context["min_length"] == 1):
        return Problem("must not be empty")
    if kind == "string_too_long":
        return Problem(expected=f"at most {context['max_length']} characters", found=f"{as_written(value)}")
    if kind in ("too_short", "too_long"):
        least, most = context.get("min_length"), context.get("max_length")
        count = f"at least {least}" if most is None else f"at most {most}"
        return Problem(expected=f"{count} elements", found=str(len(value)))
    if kind == "string_pattern_mismatch":
        dashes = " . -" if ".-]" in context["pattern"] else ""
        dashes += ", and spaces within" if " .-]" in context["pattern"] else ""
        return Problem(expected=f"a name of letters, digits and _{dashes}", found=as_written(value))
    return Problem(f"{detail['msg'][0].lower()}{detail['msg'][1:]}, found {as_written(value)}")


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
