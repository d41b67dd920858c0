"""Which functions of the flight code lie in a program that was proved, and in which.

Shows FC-1.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from fmus.block import Block
from fmus.link import NATIVE
from fmus.native import COMMON

from ..tools import without_comments
from .analysis import Result
from .subjects import ELEMENTARY, Subject

_DEFINITION = re.compile(r"^(?:static |inline |const )*[A-Za-z_]\w*[ *]+(\w+)\([^;{}]*?\)\n\{", re.MULTILINE)


FLIGHT = (
    "allocator",
    "allocator_bounded",
    "allocator_bounded_wheels",
    "controller",
    "controller_planned",
    "controller_planned_wheels",
    "controller_wheels",
    "estimator",
    "estimator_wheels",
    "supervisor",
)
"""Blocks that fly."""
NAMED = 20
"""So many functions that no program enters are named, of more the number is told."""


def defined(path: Path) -> set[str]:
    """The functions that a file of C defines; one that stands in both branches of an #if once."""
    return set(_DEFINITION.findall(without_comments(path)))


def reached(result: Result) -> Counter[str]:
    """Returns how many functions of each name the program enters: those of files that have one name get numbers in
    Frama-C.
    """
    return Counter(re.sub(r"_\d+$", "", name) for name in result.functions)


def parts(blocks: Sequence[str]) -> list[tuple[str, list[Path]]]:
    """The flight code in parts, each with its files: a block's own, then what blocks share."""
    rows = [(name, sorted((Block.named(name).folder / "native").rglob("*.[ch]"))) for name in blocks]
    shared = [("shared headers", sorted(COMMON.glob("*.h"))), ("elementary functions", [ELEMENTARY])]
    return [*rows, *shared, ("the link's frames", [NATIVE / "frame.c"])]


def rows(blocks: Sequence[str], results: Iterable[tuple[Subject, Result]]) -> list[tuple[str, ...]]:
    """Returns for each part its functions that its own program enters, those of others, and the names of the rest."""
    programs = [(subject, reached(result)) for subject, result in results]
    table: list[tuple[str, ...]] = []
    for part, files in parts(blocks):
        functions: Counter[str] = Counter()
        for path in files:
            functions.update(defined(path))
        own: set[str] = set()
        others: dict[str, str] = {}
        for name, count in functions.items():
            for subject, names in programs:
                # A number at its end may belong to a name.
                if names[re.sub(r"_\d+$", "", name)] < count or not _reads(subject, files):
                    continue
                if subject.name == part:
                    own.add(name)
                else:
                    others.setdefault(name, subject.name)
        by = sorted({others[name] for name in functions if name not in own and name in others})
        rest = sorted(name for name in functions if name not in own and name not in others)
        elsewhere = sum(name not in own and name in others for name in functions)
        table.append(
            (
                f"`{part}`" if part in blocks else part,
                str(len(own)),
                f"{elsewhere}: " + ", ".join(f"`{n}`" for n in by) if by else "0",
                (str(len(rest)) if len(rest) > NAMED else ", ".join(f"`{n}`" for n in rest)) or "none",
            )
        )
    return table


def _reads(subject: Subject, files: Sequence[Path]) -> bool:
    """Returns whether the program of a subject has one of the files, or headers that it may include."""
    if any(path.parent == COMMON for path in files) or files == [ELEMENTARY]:
        return subject.span is not None or files != [ELEMENTARY] or ELEMENTARY in subject.sources
    folders = [*subject.folders(), *(path.parent for path in subject.sources)]
    return any(path.is_relative_to(folder) for folder in folders for path in files)
