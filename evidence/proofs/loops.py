"""How often each loop of the flight code goes round at most.

A loop whose counter goes up to a constant says so itself. The others stand in loops.yaml, each with its bound and why.

Shows FC-2.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import yaml

from fmus.places import PACKAGES
from orchestration import InputError

from .coverage import parts, without_comments

FILE = Path(__file__).with_name("loops.yaml")
_CONSTANT = r"-?[A-Z_0-9]+(?: [-+*] [A-Z_0-9]+)*"
_HEAD = re.compile(rf"for \((?:int|int32_t|size_t|uint32_t) (\w+) = {_CONSTANT}; (.*); (.*)\)")


@dataclass(frozen=True)
class Loop:
    """A loop of a file: its head, its body."""

    head: str
    body: str

    @property
    def counted(self) -> bool:
        """Whether it counts to a constant, and its body leaves the counter alone."""
        found = _HEAD.fullmatch(self.head)
        if found is None:
            return False
        i, condition, step = found.groups()
        ends = re.compile(rf"{i} <=? (?:{_CONSTANT}|COUNT\(\w+\)|sizeof (\w+) / sizeof \1\[0\])")
        steps = [part for part in step.split(", ") if re.fullmatch(rf"\+\+{i}|{i} \+= \d", part)]
        changed = rf"(?:\+\+|--){i}\b|\b{i} *(?:\+\+|--|[-+*/%]?=[^=])|&{i}\b"
        others = f"{self.body} {condition} {' '.join(part for part in step.split(', ') if part not in steps)}"
        return any(map(ends.fullmatch, condition.split(" && "))) and len(steps) == 1 and not re.search(changed, others)


def loops_of(path: Path) -> Iterator[Loop]:
    """Those of a file of C."""
    text = re.sub(r'"[^"\n]*"', '""', without_comments(path))
    for found in re.finditer(r"\b(?:for|while) \(", text):
        end = closing(text, found.end() - 1, "()") + 1
        if text[end:].lstrip().startswith("{"):
            begin = text.index("{", end)
            yield Loop(" ".join(text[found.start() : end].split()), text[begin : closing(text, begin, "{}")])
        else:
            raise InputError(f"{path}: {text[found.start() : end]}: expected a body in braces")


def closing(text: str, at: int, pair: str) -> int:
    depth = 0
    for i in range(at, len(text)):
        depth += (text[i] == pair[0]) - (text[i] == pair[1])
        if depth == 0:
            return i
    raise InputError(f"no {pair[1]} closes {text[at : at + 40]!r}")


def bounds() -> dict[tuple[str, str], int]:
    """The most rounds of each loop of loops.yaml, by file and head. Raises InputError where one stands twice."""
    known: dict[tuple[str, str], int] = {}
    for entry in yaml.safe_load(FILE.read_text("utf-8")):
        for head in entry["loops"]:
            if (place := (entry["file"], head)) in known:
                raise InputError(f"{FILE.name}: {entry['file']}: {head} stands twice")
            known[place] = entry["most"]
    return known


def rows(blocks: Sequence[str]) -> list[tuple[str, ...]]:
    """Of each part of the flight code: its loops, those that count to a constant, the others, and the most of these.

    Raises InputError where a loop has no bound, or a bound no loop.
    """
    known, met, table = bounds(), set[tuple[str, str]](), list[tuple[str, ...]]()
    for part, files in parts(blocks)[:-1]:
        counted, others = 0, []
        for path in files:
            name = path.relative_to(PACKAGES).as_posix()
            for loop in loops_of(path):
                if loop.counted:
                    counted += 1
                elif (place := (name, loop.head)) in known:
                    met.add(place)
                    others.append(known[place])
                else:
                    raise InputError(f"{name}: {loop.head}: no constant bounds it, and {FILE.name} has none")
        title = f"`{part}`" if part in blocks else part
        table.append((title, str(counted + len(others)), str(counted), str(len(others)), str(max(others, default="-"))))
    if idle := set(known) - met:
        raise InputError(f"{FILE.name}: no loop is {': '.join(sorted(idle)[0])}; remedy: remove it")
    return table
