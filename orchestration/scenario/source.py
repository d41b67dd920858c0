"""A scenario's data, which remember where each part of them stands, so that errors can name it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple, Unpack

from ..errors import Fields, InputError, Place, Problem, hint, naming
from ..quantities import QuantityError

Key = tuple[str | int, ...]

PLACES = ("lines", "options", "origins", "files")
"""What a Source keeps by key, beside its data."""


class StartName(NamedTuple):
    """The name of a start value: `block.parameter`, or `shared.parameter` or `parameter` for a shared one."""

    block: str
    variable: str

    @classmethod
    def of(cls, text: str) -> StartName:
        """Returns what a text names, as `--set` and campaigns have it."""
        block, dot, variable = text.partition(".")
        return cls(block, variable) if dot else cls("shared", text)

    def __str__(self) -> str:
        return self.variable if self.shared else f"{self.block}.{self.variable}"

    @property
    def shared(self) -> bool:
        """Returns whether every block that has such a parameter takes it."""
        return self.block == "shared"

    @property
    def key(self) -> Key:
        """Its key in a scenario."""
        return ("shared", self.variable) if self.shared else ("blocks", self.block, "start", self.variable)


@dataclass
class Source:
    """Data, and where each part of it stands: a line of `file`, or an option of the command line."""

    data: Any
    file: str | None = None
    folder: Path = field(default_factory=Path.cwd)
    """Relative paths start here."""
    lines: dict[Key, int] = field(default_factory=dict)
    options: dict[Key, str] = field(default_factory=dict)
    origins: dict[Key, str] = field(default_factory=dict)
    """Where stands what was put in from another file."""
    files: dict[Key, str] = field(default_factory=dict)
    """The file of what stands in none of its own, but in one that it extends."""
    under: dict[str, frozenset[str]] = field(default_factory=dict)
    """By file: the files that lie under it, since it extends them or what it extends does."""
    notes: tuple[str, ...] = ()
    """What a run should tell of data that were put in the place of others."""

    def lies_under(self, key: Key, other: Key) -> bool:
        """Returns whether what stands at a key could be known where the other was written: in its file, or in one under
        it.
        """
        if other in self.options or (file := self.files.get(other, self.file)) == self.file:
            return True
        return key not in self.options and self.files.get(key, self.file) in {file, *self.under.get(file or "", ())}

    def place(self, key: Key) -> Place:
        """Returns the place of the innermost part of a key that is known: a line of a file, or an option."""
        for end in range(len(key), -1, -1):
            if other := self.options.get(key[:end]) or self.origins.get(key[:end]):
                return Place(other)
        name = "".join(f"[{part + 1}]" if isinstance(part, int) else f".{part}" for part in key).lstrip(".")
        known = next((key[:end] for end in range(len(key), -1, -1) if key[:end] in self.lines), ())
        return Place(self.files.get(known, self.file), self.lines.get(known), name)

    def where(self, key: Key) -> str:
        """Returns `file.yaml:14: blocks.plant.start`, or `--set plant.x=1`."""
        return str(self.place(key))

    def error(self, key: Key, text: str = "", **fields: Unpack[Fields]) -> Problem:
        """Returns an error at the place of a key."""
        return Problem(text, place=self.place(key), **fields)

    def note(self, key: Key, text: str) -> str:
        """Returns a note on what stands at a key."""
        return f"{self.where(key)}: {text}"

    @contextmanager
    def naming(self, key: Key) -> Iterator[None]:
        """Places at a key the errors of what stands or is named there; those in a line of another file stay there."""
        try:
            with naming(self.place(key)):
                yield
        except QuantityError as error:
            raise InputError(self.error(key, str(error))) from None

    def copy(self) -> Source:
        """The same data and places anew, to be changed."""
        places: dict[str, Any] = {name: dict(getattr(self, name)) for name in PLACES}
        return replace(self, data=copied(self.data), **places)

    def with_start(self, name: str, value: Any, option: str = "") -> Source:
        """A copy in which `value` takes the place of the start value of `block.parameter`, or of a shared one.

        A shared value is called `shared.parameter`, or by the name of the parameter alone.
        """
        copy = self.copy()
        data = copy.data if isinstance(copy.data, dict) else {}
        place = f"{option}{name}={value}"
        start = StartName.of(name)
        if not start.block or not start.variable:
            raise InputError(f"{place}: expected block.parameter=value, or parameter=value for a shared one")
        *_, group, variable = start.key
        holder, blocks = data, data.get("blocks")
        if not start.shared:
            if not isinstance(blocks, dict) or not isinstance(blocks.get(start.block), dict):
                raise InputError(f"{place}: there is no block {start.block!r}{hint(start.block, blocks or ())}")
            holder = blocks[start.block]
        if not isinstance(holder.get(group), dict):
            holder[group] = {}
        holder[group].pop(variable, None)  # the last one counts, also over elements
        holder[group][variable] = value
        copy.options[start.key] = place
        return copy

    def with_set(self, name: str, value: Any) -> Source:
        """A copy of a campaign's data, a dictionary, in which `value` stands under `set`.

        Where that is no mapping it stays, to be refused.
        """
        copy = self.copy()
        if copy.data.get("set") is None:
            copy.data["set"] = {}
        if isinstance(copy.data["set"], dict):
            copy.data["set"][name] = value
            copy.options["set", name] = f"--set {name}={value}"
        return copy

    def with_value(self, key: str, value: Any, option: str) -> Source:
        """A copy in which `value` takes the place of a top-level entry."""
        copy = self.copy()
        if isinstance(copy.data, dict):
            copy.data[key] = value
        copy.options[key,] = f"{option} {value}"
        return copy

    def with_entry(self, key: Key, value: Any, option: str = "") -> Source:
        """A copy in which `value` stands at a place within dictionaries; None takes the entry out."""
        copy = self.copy()
        holder = copy.data
        for part in key[:-1]:
            holder = holder[part]
        holder.pop(key[-1], None)
        if value is not None:
            holder[key[-1]] = value
        if option:
            copy.options[key] = option
        return copy

    def with_item(self, key: str, value: Any, origin: str) -> Source:
        """A copy in which `value`, which stands at `origin`, is the last of a list at the top."""
        copy = self.copy()
        items = copy.data.setdefault(key, [])
        copy.origins[key, len(items)] = origin
        items.append(value)
        return copy

    def without(self, keys: Iterable[Key]) -> Source:
        """A copy without these entries; those that follow in a list keep the lines on which they stand."""
        copy = self.copy()
        for key in sorted(set(keys), key=lambda key: [(isinstance(part, int), part) for part in key], reverse=True):
            holder = copy.data
            try:
                for part in key[:-1]:
                    holder = holder[part]
                del holder[key[-1]]
            except (KeyError, IndexError):
                continue  # went with what held it
            for places in (getattr(copy, name) for name in PLACES):
                _moved(places, key)
        return copy


def copied(data: Any) -> Any:
    """Lists and dictionaries anew, with what they hold; `deepcopy` takes ten times as long."""
    if isinstance(data, dict):
        return {key: copied(value) for key, value in data.items()}
    return [copied(value) for value in data] if isinstance(data, list) else data


def _moved(places: dict[Key, Any], key: Key) -> None:
    """Drops what stands under a key, and moves up what follows it in a list."""
    n, last = len(key), key[-1]
    for place in sorted(places, key=str):
        if place[:n] == key:
            del places[place]
    if isinstance(last, int):
        later = [p for p in places if len(p) >= n and p[: n - 1] == key[:-1] and isinstance(p[n - 1], int)]
        after = [p for p in later if int(p[n - 1]) > last]
        moved = {(*p[: n - 1], int(p[n - 1]) - 1, *p[n:]): places.pop(p) for p in after}
        places.update(moved)
