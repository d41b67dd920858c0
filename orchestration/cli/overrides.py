"""Options that take the place of a scenario's entries: --set, --step, --duration, --flavour."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..scenario.realtime import OFF, with_pace
from ..scenario.scenario import Scenario
from ..scenario.source import Source
from ..scenario.text import parse
from ..session.read import load, read
from ..swap.option import Swap, swapped
from .console import is_quiet, notes


def settings(sets: Iterable[str]) -> dict[str, Any]:
    """The value of each --set by the name that it is for; of several for one name the last, and the user is told. Raises InputError."""
    values: dict[str, Any] = {}
    given: dict[str, str] = {}
    for text in sets:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not name or not value:
            remedy = "; remedy for an empty text: ''" if equals and name else ""
            raise InputError(f"--set {text}: expected block.parameter=value{remedy}")
        name = name.removeprefix("shared.")
        if (earlier := given.get(name)) is not None and not is_quiet():
            notes([f"--set {earlier} has no effect: --set {text}, which follows, counts"])
        given[name], values[name] = text, parse(value, f"--set {text}").data
    return values


def overridden(source: Source, sets: Iterable[str] = (), **values: str | None) -> Source:
    """The scenario with `block.parameter=value` of each --set, and the given values of `step` and the like.

    Raises InputError.
    """
    for name, value in settings(sets).items():
        source = source.with_start(name, value, option="--set ")
    for key, wanted in values.items():
        if wanted is not None:
            source = source.with_value(key, wanted, f"--{key}")
    return source


def loaded(
    path: Path,
    sets: Iterable[str] = (),
    swaps: Sequence[Swap] = (),
    pace: Mapping[str, Any] | None = None,
    **values: str | None,
) -> Scenario:
    """The scenario of a file as the options change it; `pace` as `paced` takes it. Raises InputError."""
    source = swapped(read(path), swaps)
    return load(paced(overridden(source, sets, **values), **(pace or {})))


def paced(
    source: Source,
    realtime: float | str | None = None,
    late: str | None = None,
    late_tolerance: str | None = None,
) -> Source:
    """The scenario paced as the options say. Raises InputError."""
    options = {
        "factor": ("--realtime", realtime),
        "late": ("--late", late),
        "tolerance": ("--late-tolerance", late_tolerance),
    }
    given = {key: (name, value) for key, (name, value) in options.items() if value is not None}
    stated = isinstance(source.data, dict) and source.data.get("realtime") is not None
    if given and (realtime == OFF or (realtime is None and not stated)):
        for name, value in (entry for key, entry in given.items() if key != "factor"):
            raise InputError(f"{name} {value}: only a run in real time has late steps; remedy: --realtime")
    places = {
        key: f"{name} {value:g}" if key == "factor" and value != OFF else f"{name} {value}"
        for key, (name, value) in given.items()
    }
    return with_pace(source, {key: value for key, (_, value) in given.items()}, places) if given else source
