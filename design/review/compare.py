"""Two designs side by side: their reviews, or two folders of results, with what differs marked.

A cell that differs has both values, ` ‖ ` between them. Tests: tests/design/review/test_compare.py.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from orchestration import InputError
from orchestration.results import place
from orchestration.results.view import beside
from orchestration.results.whole import parsed

from . import content
from .content import APART, Curves, Review, Section, Table


def compared(a: Review, b: Review, names: tuple[str, str]) -> Review:
    """Returns the review of two, with both values where they differ."""
    sections = []
    theirs = {section.heading: section for section in b.sections}
    for section in a.sections:
        other = theirs.pop(section.heading, Section(section.heading))
        sections.append(_section(section, other, names))
    sections += [_section(Section(section.heading), section, names) for section in theirs.values()]
    facts = {name: _cell(a.facts.get(name, "–"), b.facts.get(name, "–")) for name in {**a.facts, **b.facts}}
    count = sum(APART in cell for section in sections for table in section.tables for row in table.rows for cell in row)
    about = f"A: {names[0]}. B: {names[1]}. {count} values differ; a cell with both has A{APART}B."
    return Review(f"{names[0]} and {names[1]}", about, facts, sections)


def _section(a: Section, b: Section, names: tuple[str, str]) -> Section:
    tables = _paired(a.tables, b.tables, lambda x, y: _table(x, y))
    figures = _paired(a.figures, b.figures, _figures)
    notes = [note for note in a.notes if note in b.notes]
    for name, own, other in ((names[0], a.notes, b.notes), (names[1], b.notes, a.notes)):
        notes += [f"{name}: {note}" for note in own if note not in other]
    drawing = "".join(one for one in (a.drawing, b.drawing if b.drawing != a.drawing else "") if one)
    motion = beside(a.motion, b.motion, [f"{side}: {name}" for side, name in zip("AB", names, strict=True)])
    return Section(
        a.heading,
        [t for group in tables for t in group],
        [f for group in figures for f in group],
        notes,
        drawing,
        motion,
    )


def _paired(a: list[Any], b: list[Any], pair: Callable[[Any, Any], list[Any]]) -> list[list[Any]]:
    """Returns what two entries of one name give together, and those of one side alone."""
    theirs = {one.name: one for one in b}
    found = [pair(one, theirs.pop(one.name)) if one.name in theirs else [_alone(one, "A")] for one in a]
    return [*found, *([_alone(one, "B")] for one in theirs.values())]


def _alone(one: Any, side: str) -> Any:
    if isinstance(one, Table):
        return Table(f"{one.name} ({side} alone)", one.columns, one.rows, one.note)
    return Curves(f"{one.name} ({side} alone)", one.x, one.x_label, one.y_label, one.y, one.lines, one.log)


def _table(a: Table, b: Table) -> list[Table]:
    if a.columns != b.columns:
        return [_alone(a, "A"), _alone(b, "B")]
    keys = _keys(a, b)
    theirs = {tuple(row[:keys]): row for row in b.rows}
    nothing = ["–"] * (len(a.columns) - keys)
    rows = []
    for row in a.rows:
        key = tuple(row[:keys])
        other = theirs.pop(key, [*key, *nothing])
        rows.append([*key, *map(_cell, row[keys:], other[keys:])])
    rows += [[*key, *map(_cell, nothing, row[keys:])] for key, row in theirs.items()]
    return [Table(a.name, a.columns, rows, a.note)]


def _keys(a: Table, b: Table) -> int:
    """Returns how many first cells tell the rows of each table apart."""
    for count in range(1, len(a.columns) + 1):
        if all(len({tuple(row[:count]) for row in t.rows}) == len(t.rows) for t in (a, b)):
            return count
    return len(a.columns)


def _cell(a: str, b: str) -> str:
    return a if a == b else f"{a}{APART}{b}"


def _figures(a: Curves, b: Curves) -> list[Curves]:
    if len(a.x) != len(b.x):
        return [_alone(a, "A"), _alone(b, "B")]
    near = all(abs(p - q) <= 0.02 * max(abs(a.x[-1]), 1e-12) for p, q in zip(a.x, b.x, strict=True))
    if not near:
        return [_alone(a, "A"), _alone(b, "B")]
    y = {f"{name}, {side}": values for side, one in (("A", a), ("B", b)) for name, values in one.y.items()}
    return [Curves(a.name, a.x, a.x_label, a.y_label, y, a.lines, a.log)]


def of_folder(folder: Path) -> Review:
    """Returns the review of a folder of results: of a review, or of a run. Raises InputError for another."""
    if (folder / content.REVIEW).is_file():
        return content.load(folder)
    if (folder / "manifest.json").is_file() and (folder / "expectations.json").is_file():
        return _of_run(folder)
    raise InputError(
        f"{folder}: expected the folder of a review or of a run; neither review.json nor manifest.json is there"
    )


def _of_run(folder: Path) -> Review:
    place.check(folder)
    try:
        return _made(folder, parsed(folder / "manifest.json"), parsed(folder / "expectations.json"))
    except (OSError, ValueError, KeyError, TypeError, AttributeError, IndexError, StopIteration) as error:
        files = "manifest.json, expectations.json or signals.csv"
        raise InputError(f"{folder}: {files} is damaged: {type(error).__name__}: {error}") from None


def _made(folder: Path, manifest: Any, outcome: Any) -> Review:
    inputs = [
        [f"{block}.{name}", json.dumps(value)]
        for block, values in manifest["parameters"].items()
        for name, value in values.items()
    ]
    rows = [
        [one["name"], one["status"], *(content.number(one[key], 4) if one.get(key) is not None else "–" for key in
                                       ("found", "margin")), str(one.get("unit") or "")]
        for one in outcome["expectations"]
    ]  # fmt: skip
    figures = _curves(folder, list(dict.fromkeys(one["signal"] for one in outcome["expectations"])))
    sections = [
        Section("Start values", [Table("Start values", ["parameter", "value, SI units"], inputs)]),
        Section(
            "Expectations", [Table("Expectations", ["expectation", "status", "found", "margin", "unit"], rows)], figures
        ),
    ]
    facts = {"simulated": f"{manifest['simulated_time']:g} s", "outcome": str(manifest["outcome"])}
    return Review(str(manifest["scenario"]["name"]), str(manifest["scenario"].get("description", "")), facts, sections)


def _curves(folder: Path, signals: list[str]) -> list[Curves]:
    """Returns the signals of the expectations, of a folder with signals.csv."""
    path = folder / "signals.csv"
    if not path.exists():
        return []
    if not path.is_file():
        raise ValueError("signals.csv is no regular file")
    with path.open(newline="", encoding="utf-8") as file:
        reader = csv.reader(file)
        header = next(reader)
        places = [(name, header.index(name)) for name in signals if name in header]
        rows = [[float(row[0]), *(float(row[i]) for _, i in places)] for row in reader]
    rows = rows[:: max(len(rows) // 2000, 1)]
    return [
        Curves(name, [row[0] for row in rows], "time, s", name, {name: [row[i] for row in rows]})
        for i, (name, _) in enumerate(places, start=1)
    ]
