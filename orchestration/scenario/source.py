"""A YAML file as plain data that remembers the line of everything in it, so that errors can name it."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from ..errors import InputError, hint

Key = tuple[str | int, ...]

_NODES_MAX = 100_000
PLACES = ("lines", "options", "origins", "files")
"""What a Source keeps by key, beside its data."""


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

    def where(self, key: Key) -> str:
        """`file.yaml:14: blocks.plant.start`, or `--set plant.x=1`, of the innermost part that is known."""
        for end in range(len(key), -1, -1):
            if other := self.options.get(key[:end]) or self.origins.get(key[:end]):
                return other
        name = "".join(f"[{part + 1}]" if isinstance(part, int) else f".{part}" for part in key).lstrip(".")
        known = next((key[:end] for end in range(len(key), -1, -1) if key[:end] in self.lines), ())
        file, line = self.files.get(known, self.file), self.lines.get(known)
        place = file if line is None or file is None else f"{file}:{line}"
        return ": ".join(filter(None, (place, name))) or "scenario"

    def error(self, key: Key, message: str) -> str:
        return f"{self.where(key)}: {message}"

    def _copy(self) -> Source:
        places: dict[str, Any] = {name: dict(getattr(self, name)) for name in PLACES}
        return replace(self, data=_copied(self.data), **places)

    def with_start(self, name: str, value: Any, option: str = "") -> Source:
        """A copy in which `value` takes the place of the start value of `block.parameter`, or of a shared one.

        A shared value is called `shared.parameter`, or by the name of the parameter alone.
        """
        copy = self._copy()
        data = copy.data if isinstance(copy.data, dict) else {}
        place = f"{option}{name}={value}"
        block, _, variable = name.partition(".") if "." in name else ("shared", "", name)
        if not block or not variable:
            raise InputError(f"{place}: expected block.parameter=value, or parameter=value for a shared one")
        key: Key = ("shared",) if block == "shared" else ("blocks", block, "start")
        holder, blocks = data, data.get("blocks")
        if block != "shared":
            if not isinstance(blocks, dict) or not isinstance(blocks.get(block), dict):
                raise InputError(f"{place}: there is no block {block!r}{hint(block, blocks or ())}")
            holder = blocks[block]
        if not isinstance(holder.get(key[-1]), dict):
            holder[key[-1]] = {}
        holder[key[-1]].pop(variable, None)  # the last one counts, also over elements
        holder[key[-1]][variable] = value
        copy.options[*key, variable] = place
        return copy

    def with_value(self, key: str, value: Any, option: str) -> Source:
        """A copy in which `value` takes the place of a top-level entry."""
        copy = self._copy()
        if isinstance(copy.data, dict):
            copy.data[key] = value
        copy.options[key,] = f"{option} {value}"
        return copy

    def with_entry(self, key: Key, value: Any, option: str = "") -> Source:
        """A copy in which `value` stands at a place within dictionaries; None takes the entry out."""
        copy = self._copy()
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
        copy = self._copy()
        items = copy.data.setdefault(key, [])
        copy.origins[key, len(items)] = origin
        items.append(value)
        return copy

    def without(self, keys: Iterable[Key]) -> Source:
        """A copy without these entries; those that follow in a list keep the lines on which they stand."""
        copy = self._copy()
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


def _copied(data: Any) -> Any:
    """Lists and dictionaries anew, with what they hold; `deepcopy` takes ten times as long."""
    if isinstance(data, dict):
        return {key: _copied(value) for key, value in data.items()}
    return [_copied(value) for value in data] if isinstance(data, list) else data


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


def read(path: Path) -> Source:
    """The data of a YAML file with their lines. Raises InputError."""
    try:
        regular = path.is_file() or path.is_dir() or not path.exists()
    except (OSError, ValueError):
        regular = True  # reading it tells why it is no path
    if not regular:
        raise InputError(f"{path} is no regular file; expected a file of YAML")
    try:
        text = path.read_text("utf-8")
    except FileNotFoundError:
        near = hint(path.name, (p.name for p in path.parent.glob("*.y*ml"))) if path.parent.is_dir() else ""
        raise InputError(f"{path}: there is no such file{near}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: expected text in UTF-8") from None
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise InputError(f"{str(path)!r} is no path: {error}") from None
    source = parse(text, str(path))
    source.folder = path.resolve().parent
    return source


def parse(text: str, file: str | None = None) -> Source:
    """The data of YAML text with their lines. Raises InputError."""
    source = _parsed(text, file)._copy()
    source.folder = Path.cwd()
    return source


@lru_cache(32)
def _parsed(text: str, file: str | None) -> Source:
    from ruamel.yaml import YAML  # 30 ms, which a scenario given as a dictionary does without
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    source = Source(None, file)
    try:
        node = YAML(typ="safe", pure=True).compose(text)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f":{mark.line + 1}" if mark and "\n" in text.rstrip("\n") else ""
        what = " ".join(filter(None, (error.context, error.problem)))
        if error.context_mark and mark and error.context_mark.line != mark.line:
            what = f"{error.context} from line {error.context_mark.line + 1} on, {error.problem}"
        raise InputError(f"{file or 'text'}{line}: no valid YAML: {what}") from None
    except (YAMLError, RecursionError) as error:
        raise InputError(f"{file or 'text'}: no valid YAML: {' '.join(str(error).split())}") from None
    if node is None:
        raise InputError(f"{file or 'text'}: is empty")
    _Reader(source).read(node, ())
    source.data = source.data[0]
    return source


class _Reader:
    """Makes data of YAML nodes: dictionaries, lists, text, numbers, booleans. Dates stay text."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.count = 0
        self.source.data = []

    def read(self, node: Any, key: Key) -> None:
        self.source.data.append(self._value(node, key))

    def _value(self, node: Any, key: Key) -> Any:
        self.count += 1
        if self.count > _NODES_MAX or len(key) > 50:
            raise InputError(f"{self.source.file or 'text'}: has too many entries, or contains itself")
        self.source.lines.setdefault(key, node.start_mark.line + 1)
        if node.id == "sequence":
            return [self._value(item, (*key, i)) for i, item in enumerate(node.value)]
        if node.id == "mapping":
            return self._mapping(node, key)
        _refuse_surrogates(node.value, self.source.where(key))
        try:
            return _scalar(node)
        except ValueError:
            place = self.source.error(key, "")
            raise InputError(f"{place}expected a number, found {_shortened(node.value)}") from None

    def _mapping(self, node: Any, key: Key) -> dict[str, Any]:
        data: dict[str, Any] = {}
        for name_node, value_node in node.value:
            line = name_node.start_mark.line + 1
            place = f"{self.source.file or 'text'}:{line}"
            if name_node.id != "scalar":
                raise InputError(f"{place}: expected a name before the colon")
            name = str(name_node.value)
            _refuse_surrogates(name, place)
            if name == "<<" and name_node.style is None:
                raise InputError(f"{place}: merging by '<<' is not supported; remedy: write the entries out")
            if name in data:
                first = self.source.lines[(*key, name)]
                raise InputError(f"{place}: {name!r} stands here a second time; first in line {first}")
            self.source.lines[(*key, name)] = line
            data[name] = self._value(value_node, (*key, name))
        return data


def _refuse_surrogates(text: str, place: str) -> None:
    if any("\ud800" <= character <= "\udfff" for character in text):
        raise InputError(f"{place}: expected text, found half a character (a surrogate) in {text!r}")


_DIGITS_MAX = 300
"""More than a double can hold."""
_INTEGER = re.compile(r"[-+]?\d+$")
_FLOAT = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$")


def _shortened(text: str) -> str:
    return repr(text) if len(text) < 40 else f"{text[:20]!r} ... of {len(text)} digits"


def _scalar(node: Any) -> Any:
    text, tag = node.value, str(node.tag).rpartition(":")[2]
    if tag == "null":
        return None
    if tag == "bool":
        return text.lower() in ("true", "yes", "on")
    if node.style is None and _INTEGER.match(text):
        if len(text) > _DIGITS_MAX:
            raise ValueError
        return int(text)
    if node.style is None and _FLOAT.match(text):
        return float(text)
    if tag == "float":  # .inf and .nan
        return float(text.replace(".", ""))
    return text
