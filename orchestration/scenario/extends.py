"""A scenario or campaign that extends other files: theirs below, its own above; mappings merge, lists and values
replace.

A list of the form `{add: [...]}` adds its entries to the list below; connections of the form `{replace: [...]}`
replace those to the same inputs.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..errors import InputError, as_written, hint, in_kind
from ..paths import located
from .references import Connection
from .source import PLACES, Key, Source, copied
from .text import read as read_text


def read(path: Path) -> Source:
    """Returns the data of a file, laid over the files that it extends. Raises InputError."""
    return extended(read_text(path), (path.resolve(),))


_FILES_MAX = 100
"""Files that are laid together; each is counted as often as it is extended."""


def extended(source: Source, within: tuple[Path, ...] = (), left: Iterator[int] | None = None) -> Source:
    """Returns the source laid over the files that it extends, in their order; `within` are the files that lead to it.

    Of the files that may still be laid under it, each takes one of `left`. Raises InputError.
    """
    left = iter(range(_FILES_MAX)) if left is None else left
    if not isinstance(source.data, dict) or "extends" not in source.data:
        return source
    given = source.data["extends"]
    names = given if isinstance(given, list) else [given]
    if wrong := [name for name in names if not isinstance(name, str) or not name]:
        raise InputError(source.error(("extends",), f"expected the paths of files, found {as_written(wrong[0])}"))
    merged = Source({}, source.file, source.folder, {(): source.lines.get((), 1)} if source.file else {})
    for number, name in enumerate(names):
        key = ("extends", number) if given is names else ("extends",)
        part = _part(source, key, name, within, left)
        _lay(merged, part)
        merged.under |= part.under | {part.file or "": part.under.get(part.file or "", frozenset())}
    merged.under[source.file or ""] = frozenset(merged.under)
    _lay(merged, source)
    _forget(merged, ("extends",), merged.data.pop("extends"))
    merged.options = dict(source.options)
    return merged


def _part(source: Source, key: Key, name: str, within: tuple[Path, ...], left: Iterator[int]) -> Source:
    with source.naming(key):
        path = located(name, Path(source.file).parent if source.file else source.folder)
    if path.resolve() in within:
        through = " -> ".join(p.name for p in (*within[within.index(path.resolve()) :], path))
        raise InputError(source.error(key, f"the files extend each other in a circle: {through}"))
    if next(left, None) is None:
        raise InputError(
            source.error(key, f"more than {_FILES_MAX} files are extended, the most that are laid together")
        )
    with source.naming(key):
        part = read_text(path)
    if not isinstance(part.data, dict):
        raise InputError(part.error((), expected="keys such as 'shared' or 'blocks'", found=in_kind(part.data)))
    part = extended(part, (*within, path.resolve()), left)
    _anchor(part, source.folder)
    return part


def _anchor(part: Source, folder: Path) -> None:
    """Makes the relative paths of a part start at the folder of the file that extends it."""
    if part.folder == folder:
        return
    for holder, key in _paths(part.data):
        try:
            path = part.folder / Path(holder[key]).expanduser()
        except RuntimeError:  # no such user: told where the file is opened
            continue
        try:
            holder[key] = Path(os.path.relpath(path, folder)).as_posix()
        except ValueError:  # on another drive of Windows
            holder[key] = str(path)
        if "/" not in holder[key] and not holder[key].endswith(".fmu"):
            holder[key] = f"./{holder[key]}"


def _paths(data: dict[str, Any]) -> Iterator[tuple[Any, Any]]:
    """Returns where a path stands in a scenario or campaign: what holds it, and its key there."""
    blocks = data.get("blocks")
    for entry in blocks.values() if isinstance(blocks, dict) else ():
        for key in ("fmu", "interface", "map", "python") if isinstance(entry, dict) else ():
            text = entry.get(key)
            if isinstance(text, str) and "://" not in text and (key in ("map", "python") or _is_path(text)):
                yield entry, key
    flown = data.get("scenario")
    if isinstance(flown, str):
        yield data, "scenario"
    elif isinstance(flown, dict):
        yield from _paths(flown)
        if isinstance(flown.get("extends"), str):
            yield flown, "extends"
        elif isinstance(flown.get("extends"), list):
            yield from ((flown["extends"], i) for i, text in enumerate(flown["extends"]) if isinstance(text, str))
    for name in ("swap", "map"):
        if isinstance(data.get(name), dict):
            yield from ((data[name], block) for block, text in data[name].items() if isinstance(text, str))


def _is_path(text: str) -> bool:
    return text.endswith(".fmu") or "/" in text or "\\" in text


def _lay(below: Source, above: Source) -> None:
    """Puts `above` over `below`, in place; a null above takes the entry out."""
    _give_way(below, above)
    _lay_under(below, above, (), below.data, above.data, above.lines)


def _give_way(below: Source, above: Source) -> None:
    """Takes the FMUs out that laws in Python replace, which keep their ports and start values."""
    blocks, laws = (one.data.get("blocks") for one in (below, above))
    for name, law in laws.items() if isinstance(laws, dict) and isinstance(blocks, dict) else ():
        entry = blocks.get(name)
        if isinstance(law, dict) and law.get("python") and "fmu" not in law and isinstance(entry, dict):
            kind = entry.pop("fmu", None)
            for key in ("flavour", "map") if kind else ():
                entry.pop(key, None)
            if isinstance(kind, str) and not _is_path(kind):
                entry.setdefault("interface", kind)


def _lay_under(
    below: Source, above: Source, key: Key, data: dict[str, Any], over: dict[str, Any], lines: Mapping[Key, int]
) -> None:
    """The same of what stands under a key: `data` there below, `over` above, with its lines."""
    parts: dict[Any, dict[Key, int]] = {}
    for place, line in lines.items():
        if len(place) > len(key):
            parts.setdefault(place[len(key)], {})[place] = line
    for name, value in over.items():
        place, part = (*key, name), parts.get(name, {})
        if _is_change(place, value) and isinstance(data.get(name), list):
            _change(data[name], place, value, part, above, below)
            continue
        if isinstance(value, dict) and isinstance(data.get(name), dict) and not _is_value(place):
            _lay_under(below, above, place, data[name], value, part)
        else:
            if name in data:
                _forget(below, place, data[name])
            if value is None and name in data:
                del data[name]
                continue
            data[name] = copied(value)  # in its place: what a campaign draws depends on the order
        below.lines.update(part)
        below.files.update((p, file) for p in part if (file := above.files.get(p, above.file)))


def _is_change(place: Key, value: Any) -> bool:
    kinds = {"add", "replace"} if place[-1] == "connections" else {"add"}
    lists = isinstance(value, dict) and value.keys() <= kinds and all(isinstance(v, list) for v in value.values())
    return lists and bool(value)


def _change(
    entries: list[Any], key: Key, change: dict[str, list[Any]], lines: Mapping[Key, int], above: Source, below: Source
) -> None:
    """Replaces connections in the list under a key, each by the one to the same input, and puts what is added behind
    the list; all with the lines that they have in `above`. Raises InputError where there is nothing to replace."""
    moved: dict[Key, int] = {}
    targets = [_target(entry) for entry in entries]
    for number, entry in enumerate(change.get("replace", ())):
        place = (*key, "replace", number)
        if not (target := _target(entry)):
            raise InputError(above.error(place, f"expected 'block.output -> block.input', found {as_written(entry)}"))
        if target not in targets:
            message = f"{as_written(entry)}: there is no connection to this input to replace{hint(target, targets)}"
            raise InputError(above.error(place, message))
        at = targets.index(target)
        if at in moved.values():
            raise InputError(above.error(place, f"{as_written(entry)}: the connection to this input is replaced twice"))
        moved["replace", number] = at
        _forget(below, (*key, at), entries[at])
        entries[at] = entry
    for number, entry in enumerate(change.get("add", ())):
        moved["add", number] = len(entries)
        entries.append(copied(entry))
    for place, line in lines.items():
        within = len(key) + 2
        if (at := moved.get(place[len(key) : within], -1)) >= 0:
            below.lines[*key, at, *place[within:]] = line
            if file := above.files.get(place, above.file):
                below.files[*key, at, *place[within:]] = file


def _target(connection: Any) -> str:
    """The input that a connection goes to; empty for what is none."""
    try:
        return "".join(Connection(connection).target.split()) if isinstance(connection, str) else ""
    except ValueError:
        return ""


def _forget(source: Source, key: Key, value: Any) -> None:
    """Drops the places of a value that stands at a key, and of what it holds."""
    for places in (getattr(source, name) for name in PLACES):
        held = [p for p in places if p[: len(key)] == key] if isinstance(value, (dict, list)) else [key]
        for place in held:
            places.pop(place, None)


def _is_value(place: Key) -> bool:
    """Returns whether a value or a distribution stands here, which is replaced as a whole also where it is written as
    names with values.
    """
    if place[:1] == ("scenario",):
        place = place[1:]
    return (len(place) == 2 and place[0] in ("shared", "set", "draw", "vary")) or (
        len(place) == 4 and place[0] == "blocks" and place[2] == "start"
    )
