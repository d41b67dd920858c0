"""How often each loop of the flight code goes round at most.

A loop whose counter goes up to a constant says so itself. The others stand in loops.yaml, each with its bound and why.

Shows FC-2.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from fmus.places import PACKAGES
from orchestration import InputError

from ..tools import without_comments
from .coverage import parts
from .rounds import CHANGES, FILE, bounds, closing, has_or

_CONSTANT = r"-?[A-Z_0-9]+(?: [-+*] [A-Z_0-9]+)*"
_HEAD = re.compile(rf"for \((?:int|int32_t|size_t|uint32_t) (\w+) = {_CONSTANT}; (.*); (.*)\)")


@dataclass(frozen=True)
class Loop:
    """A loop of a file: its head, its body."""

    head: str
    body: str

    @property
    def counted(self) -> bool:
        """Returns whether it counts to a constant, and its body leaves the counter alone."""
        found = _HEAD.fullmatch(self.head)
        if found is None:
            return False
        i, condition, step = found.groups()
        ends = re.compile(rf"{i} <=? (?:{_CONSTANT}|COUNT\(\w+\)|sizeof (\w+) / sizeof \1\[0\])")
        steps = [part for part in step.split(", ") if re.fullmatch(rf"\+\+{i}|{i} \+= \d", part)]
        changed = CHANGES.format(name=i)
        others = f"{self.body} {condition} {' '.join(part for part in step.split(', ') if part not in steps)}"
        to_constant = not has_or(condition) and any(map(ends.fullmatch, condition.split(" && ")))
        return to_constant and len(steps) == 1 and not re.search(changed, others)


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


def rows(blocks: Sequence[str], proved: Collection[str] = ()) -> list[tuple[str, ...]]:
    """Of each part of the flight code that has loops which do not count to a constant: how many do, how many have a
    bound that is `proved` (as `file: head`), how many a reason, and the most rounds of one of the last two.

    Raises InputError where a loop has no bound, or a bound no loop.
    """
    known, met, table = bounds(), set[tuple[str, str]](), list[tuple[str, ...]]()
    for part, files in parts(blocks):
        counted, by_proof, others = 0, 0, []
        for path in files:
            name = path.relative_to(PACKAGES).as_posix()
            for loop in loops_of(path):
                if loop.counted:
                    counted += 1
                elif (place := (name, loop.head)) in known:
                    met.add(place)
                    others.append(known[place])
                    by_proof += f"{name}: {loop.head}" in proved
                else:
                    raise InputError(f"{name}: {loop.head}: no constant bounds it, and {FILE.name} has none")
        title = f"`{part}`" if part in blocks else part
        if others:
            shares = (counted, by_proof, len(others) - by_proof, max(others))
            table.append((title, *map(str, shares)))
    if idle := set(known) - met:
        raise InputError(f"{FILE.name}: no loop is {': '.join(sorted(idle)[0])}; remedy: remove it")
    return table
