"""Arguments for what the tool does not see, each tied to the C that it speaks of: another text there, and it is none.

Shows FC-1.
"""

from __future__ import annotations

import functools
import hashlib
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import yaml

from fmus.places import PACKAGES
from orchestration import InputError

from ..tools import without_comments
from .analysis import Alarm
from .coverage import FLIGHT, defined, parts
from .rounds import closing

FILE = Path(__file__).with_name("arguments.yaml")


@dataclass(frozen=True)
class Argument:
    """Reason for a property that Eva cannot see."""

    file: str
    function: str
    kind: str
    text: str
    argument: str
    rests_on: tuple[str, ...]
    """`file: function` of the C that it speaks of; `callers` are those of its function in all flight code."""
    code: str
    """The digest of that C, contracts and assertions included."""

    def holds(self, alarm: Alarm) -> bool:
        where = (self.file, self.function, self.kind) == (alarm.file, alarm.function, alarm.kind)
        return where and self.text in alarm.text

    def digest(self, root: Path = PACKAGES) -> str:
        """Returns the digest of the C that it speaks of, comments and spaces apart. Raises InputError where a function
        is not there.
        """
        texts: dict[str, str] = {}
        for place in self.rests_on:
            if place == "callers":
                texts |= _callers(root, self.function)
                continue
            file, _, function = place.partition(": ")
            if function not in _functions(root / file):
                raise InputError(f"{FILE.name}: {self.file}: {self.function}: {file} has no function {function!r}")
            texts |= _closure(root, file, function)
        return hashlib.sha256("\n".join(f"{k} {v}" for k, v in sorted(texts.items())).encode()).hexdigest()[:12]


def arguments() -> list[Argument]:
    """Those of arguments.yaml."""
    entries = yaml.safe_load(FILE.read_text("utf-8"))
    return [Argument(**{**entry, "rests_on": tuple(entry["rests_on"])}) for entry in entries]


def stale(given: Iterable[Argument]) -> list[str]:
    """Returns for each argument whose C is another now which it is, and what to do."""
    return [
        f"{FILE.name}: {a.file}: {a.function}: {a.text}: the C that it rests on has changed; "
        f"remedy: read the argument again, then code: {digest!r}"
        for a in given
        if (digest := a.digest()) != a.code
    ]


def unproved(alarms: Iterable[Alarm], given: Sequence[Argument], root: Path = PACKAGES) -> list[Alarm]:
    """Alarms for which no argument is given that speaks of the C in `root`, a copy of the packages."""
    valid = [a for a in given if a.digest(root) == a.code]
    return [alarm for alarm in alarms if not any(a.holds(alarm) for a in valid)]


@functools.cache
def _functions(path: Path) -> dict[str, str]:
    """The text of each function of a file of C, and with the name "" what stands outside of them; of comments those
    for Frama-C."""
    text = without_comments(path, but="@")
    found, outside = {}, text
    for name in defined(path):
        places = [m.start() for m in re.finditer(rf"^[A-Za-z].*?\b{name}\([^;{{}}]*?\)\n\{{", text, re.MULTILINE)]
        whole = [text[at : closing(text, text.index("{\n", at), "{}") + 1] for at in places]
        for part in whole:
            outside = outside.replace(part, "")
        found[name] = " ".join(" ".join(whole).split())
    return {**found, "": " ".join(outside.split())}


@functools.cache
def _shared(root: Path) -> dict[str, str]:
    """The files of the shared headers and elementary functions, by the functions that they define."""
    files = [p for _, of_part in parts(())[:2] for p in of_part]
    names = [path.relative_to(PACKAGES).as_posix() for path in files]
    return {function: name for name in names for function in _functions(root / name) if function}


def _closure(root: Path, file: str, function: str) -> dict[str, str]:
    """The function, what it calls in its file and in the shared ones, and what stands outside of functions there."""
    found: dict[str, str] = {}
    left = [(file, function)]
    while left:
        name, one = left.pop()
        if f"{name}: {one}" in found:
            continue
        of = _functions(root / name)
        found |= {f"{name}: {one}": of[one], f"{name}: ": of[""]}
        for called in set(re.findall(r"\b(\w+)\(", of[one])) - {one}:
            place = name if called in of else _shared(root).get(called)
            left += [(place, called)] if place else []
    return found


def _callers(root: Path, function: str) -> dict[str, str]:
    """The functions of the flight code that call one of this name, each with what stands outside of functions there."""
    call, found = re.compile(rf"\b{function}\("), dict[str, str]()
    for path in (path for _, of_part in parts(FLIGHT) for path in of_part):
        name = path.relative_to(PACKAGES).as_posix()
        of = _functions(root / name)
        for one, text in of.items():
            if one not in ("", function) and call.search(text):
                found |= {f"{name}: {one}": text, f"{name}: ": of[""]}
    return found
