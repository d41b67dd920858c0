"""Options that take the place of a scenario's entries: --set, --step, --duration, --flavour."""

from __future__ import annotations

from collections.abc import Iterable

from ..errors import InputError
from ..scenario.source import Source
from ..scenario.text import parse


def overridden(source: Source, sets: Iterable[str] = (), **values: str | None) -> Source:
    """The scenario with `block.parameter=value` of each --set, and the given values of `step` and the like.

    Raises InputError.
    """
    for text in sets:
        name, equals, value = text.partition("=")
        if not equals or not name.strip() or not value.strip():
            raise InputError(f"--set {text}: expected block.parameter=value")
        source = source.with_start(name.strip(), parse(value, f"--set {text}").data, option="--set ")
    for key, given in values.items():
        if given is not None:
            source = source.with_value(key, given, f"--{key}")
    return source
