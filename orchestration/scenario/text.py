"""YAML text as plain data with the line of everything in it, and plain data as such text."""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar

import yaml

from ..errors import InputError, Place, Problem, file_hint, reason
from .source import Key, Source

_NODES_MAX, _DEPTH_MAX = 100_000, 50
SIZE_MAX = 16 * 10**6
"""Bytes of a file of YAML."""


def read(path: Path) -> Source:
    """The data of a YAML file with their lines. Raises InputError."""
    try:
        regular = path.is_file() or path.is_dir() or not path.exists()
        size = path.stat().st_size if path.is_file() else 0
    except (OSError, ValueError):
        regular, size = True, 0  # reading it tells why it is no path
    if not regular:
        raise InputError(f"{path} is no regular file; expected a file of YAML")
    if size > SIZE_MAX:
        raise InputError(f"{path} holds {size / 1e6:.3g} MB; expected a file of YAML, of at most {SIZE_MAX / 1e6:g} MB")
    try:
        text = path.read_text("utf-8")
    except FileNotFoundError:
        names = path.parent.glob("*.ssp" if path.suffix == ".ssp" else "*.y*ml") if path.parent.is_dir() else ()
        near = file_hint(path.name, sorted(p.name for p in names if not p.name.startswith(".")))
        raise InputError(f"{path}: there is no such file{near}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: expected text in UTF-8") from None
    except OSError as error:
        raise InputError(f"{path}: {reason(error)}") from None
    except ValueError as error:
        raise InputError(f"{str(path)!r} is no path: {error}") from None
    source = parse(text, str(path))
    source.folder = path.resolve().parent
    return source


def parse(text: str, file: str | None = None) -> Source:
    """The data of YAML text with their lines. Raises InputError."""
    source = _parsed(text, file).copy()
    source.folder = Path.cwd()
    return source


@lru_cache(32)
def _parsed(text: str, file: str | None) -> Source:
    source = Source(None, file)
    try:
        node = _composed(text, source)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = mark.line + 1 if mark and "\n" in text.rstrip("\n") else None
        what = " ".join(filter(None, (error.context, error.problem)))
        if error.context_mark and mark and error.context_mark.line != mark.line:
            what = f"{error.context} from line {error.context_mark.line + 1} on, {error.problem}"
        what = _HELD.sub("", what)
        remedy = "quote a text that holds a colon with a space behind it" if error.problem == _COLON else ""
        behind = text[: error.problem_mark.index].rstrip(" ") if error.problem_mark else ""
        if behind.endswith("]") and error.problem.endswith("'<scalar>'"):
            what, remedy = "text behind a list", "a unit stands at each number, as in [1 mm, 2 mm]"
        raise InputError(Problem(f"no valid YAML: {what}", remedy=remedy, place=Place(file or "text", line))) from None
    except RecursionError:
        raise InputError(_too_much(source)) from None
    except yaml.YAMLError as error:
        raise InputError(f"{file or 'text'}: no valid YAML: {' '.join(str(error).split())}") from None
    if node is None:
        raise InputError(f"{file or 'text'}: is empty")
    _Reader(source).read(node, ())
    source.data = source.data[0]
    return source


_HELD = re.compile(r" '(?!<|\\.')[^']{2,}'")
"""What PyYAML quotes of the file, which may be confidential where it is no scenario; names of tokens begin with `<`."""
_COLON = "mapping values are not allowed here"
"""What PyYAML calls a second colon in a line."""


class _Plain(yaml.SafeLoader):
    """Only what stands below is told by how it is spelt; numbers are found by `_scalar`."""

    yaml_implicit_resolvers: ClassVar[dict[str, Any]] = {}


class _Fast(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """The same in C, twenty times as fast. What it refuses is read again by the other, whose errors say more."""

    yaml_implicit_resolvers = _Plain.yaml_implicit_resolvers


for _tag, _spelling in (
    ("null", r"(~|null|Null|NULL|)$"),
    ("bool", r"(true|True|TRUE|false|False|FALSE)$"),
    ("float", r"([-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN))$"),
):
    _Plain.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(_spelling), None)
    _Fast.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(_spelling), None)


def _composed(text: str, source: Source) -> Any:
    """The document's nodes.

    Raises yaml.YAMLError, RecursionError, and InputError where it is too deep to be composed in C.
    """
    depth = 0
    try:
        for count, event in enumerate(yaml.parse(text, _Fast)):
            depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
            if depth > _DEPTH_MAX or count > 2 * _NODES_MAX:  # a list or dictionary has an event at either end
                raise InputError(_too_much(source))
        return yaml.compose(text, _Fast)
    except (yaml.YAMLError, UnicodeEncodeError):
        return yaml.compose(text, _Plain)


def _too_much(source: Source) -> str:
    return f"{source.file or 'text'}: has too many entries, or contains itself"


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
        if self.count > _NODES_MAX or len(key) > _DEPTH_MAX:
            raise InputError(_too_much(self.source))
        self.source.lines.setdefault(key, node.start_mark.line + 1)
        if node.id == "sequence":
            return [self._value(item, (*key, i)) for i, item in enumerate(node.value)]
        if node.id == "mapping":
            return self._mapping(node, key)
        _refuse_surrogates(node.value, self.source.place(key))
        try:
            return _scalar(node)
        except ValueError:
            problem = self.source.error(key, expected="a number", found=_shortened(node.value))
            raise InputError(problem) from None

    def _mapping(self, node: Any, key: Key) -> dict[str, Any]:
        data: dict[str, Any] = {}
        for name_node, value_node in node.value:
            line = name_node.start_mark.line + 1
            place = Place(self.source.file or "text", line)
            if name_node.id != "scalar":
                raise InputError(Problem(expected="a name before the colon", place=place))
            name = str(name_node.value)
            _refuse_surrogates(name, place)
            if name == "<<" and not name_node.style:
                remedy = "write the entries out"
                raise InputError(Problem("merging by '<<' is not supported", remedy=remedy, place=place))
            if name in data:
                first = self.source.lines[(*key, name)]
                what = repr(name) if _WORD.match(name) else "a key"  # a file that is no scenario may be confidential
                raise InputError(Problem(f"{what} is given twice; first in line {first}", place=place))
            self.source.lines[(*key, name)] = line
            data[name] = self._value(value_node, (*key, name))
        return data


_WORD = re.compile(r"[A-Za-z_][\w.]{0,39}$")
_SURROGATE = re.compile("[\ud800-\udfff]")


def _refuse_surrogates(text: str, place: Place) -> None:
    if _SURROGATE.search(text):
        found = f"half a character (a surrogate) in {text!r}"
        raise InputError(Problem(expected="text", found=found, place=place))


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
    if not node.style and _INTEGER.match(text):
        if len(text) > _DIGITS_MAX:
            raise ValueError
        return int(text)
    if not node.style and _FLOAT.match(text):
        return float(text)
    if tag == "float":  # .inf and .nan
        return float(text.replace(".", ""))
    return text


class _Writer(yaml.SafeDumper):
    """Quotes text that `_scalar` would take for a number."""


_Writer.add_implicit_resolver("tag:yaml.org,2002:float", _FLOAT, None)


def written(data: Any, flow: bool = False) -> str:
    """Returns plain data as YAML that reads back as the same data; with `flow` on one line, without its end."""
    text: str = yaml.dump(
        data, Dumper=_Writer, sort_keys=False, allow_unicode=True, width=10**6, default_flow_style=flow
    )
    return text.removesuffix("...\n").rstrip("\n") if flow else text
