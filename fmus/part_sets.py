"""Variables of an interface file for one part, such as a wheel, or for a set of them; parsing.py describes the keys.
Tests: tests/fmus/test_part_sets.py."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from .variables import InterfaceError, Variable

Entry = dict[str, Any]


def for_set(
    entries: Mapping[str, Entry], sets: Mapping[str, Entry], chosen: str | None, groups: Mapping[str, list[str]]
) -> dict[str, Entry]:
    """Returns the entries of `[variables]` as they stand for the set `chosen`, or for one part each without it, with
    groups in their dependencies expanded. Raises InterfaceError."""
    for name, entry in entries.items():
        for key in ("each", "only"):
            if (found := entry.get(key)) is not None and found not in sets:
                raise InterfaceError(f"variables.{name}: {key}: expected one of {', '.join(sets)}, found {found!r}")
    if chosen is not None and chosen not in sets:
        raise InterfaceError(f"block: set: expected one of {', '.join(sets)}, found {chosen!r}")
    absent = {name for name, entry in entries.items() if entry.get("only", chosen) != chosen}
    several = {name for name, entry in entries.items() if chosen and entry.get("each") == chosen}
    made: dict[str, Entry] = {}
    for name in (name for name in entries if name not in absent):
        entry = {key: value for key, value in entries[name].items() if key != "only"}
        try:
            for key in ("depends_on", "initially_depends_on"):
                if key in entry:
                    names = [each for each in _expand(entry[key], groups) if each.partition("[")[0] not in absent]
                    own = [_of_same_part(each, entries, several) for each in names] if name in several else names
                    entry[key] = [each.removesuffix("[:]") for each in own]
        except InterfaceError as error:
            raise InterfaceError(f"variables.{name}: {error}") from None
        made[name] = _several(entry, sets[entry["each"]]["count"]) if name in several else entry
    return made


def terminals_for(
    terminals: Mapping[str, tuple[str, ...]], variables: Mapping[str, Variable], chosen: str | None
) -> dict[str, tuple[str, ...]]:
    """Returns terminals by names that tell those with ports of a set, `wheel_momentum_of_wheels`, from those with a
    port of one part: terminals of one name fit each other."""

    def name_of(name: str, members: tuple[str, ...]) -> str:
        of_set = chosen is not None and any(variables[member].each == chosen for member in members)
        return f"{name}_of_{chosen}s" if of_set else name

    return {name_of(name, members): members for name, members in terminals.items()}


def _several(entry: Entry, count: int) -> Entry:
    """The entry with `count` as its first dimension, every part with the start of the one."""
    several = {**entry, "shape": [count, *entry.get("shape", ())]}
    if "start" in entry:
        several["start"] = [entry["start"]] * count
    return several


def _of_same_part(name: str, entries: Mapping[str, Entry], several: set[str]) -> str:
    """A dependency of a part's scalar on another one of the same part; on the whole of all else."""
    return f"{name}[i]" if name in several and not entries[name].get("shape") else name


def _expand(names: Iterable[str], groups: Mapping[str, list[str]]) -> tuple[str, ...]:
    expanded: dict[str, None] = {}
    for name in names:
        if name.startswith("@") and name[1:] not in groups:
            raise InterfaceError(f"there is no group {name!r}")
        expanded.update(dict.fromkeys(_expand(groups[name[1:]], groups) if name.startswith("@") else [name]))
    return tuple(expanded)
