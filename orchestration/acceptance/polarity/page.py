"""Writes what became of the wrong wirings, and the test card: for the console, as Markdown, CSV and JSON.

Tests: tests/orchestration/acceptance/test_polarity.py.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ...errors import writing
from ...results.whole import put
from ..tables import csv_text
from .card import Card
from .mend import as_yaml
from .mend import summary as of_mended
from .swaps import Looked
from .trials import Row, Trials

HEADER = ("port", "", "wrong", "detected", "first", "last", "mostly by")


def ports(rows: Sequence[Row]) -> list[list[Row]]:
    """Returns the rows of each port."""
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        groups.setdefault((row.port.name, row.port.causality), []).append(row)
    return list(groups.values())


def table(trials: Trials) -> list[tuple[str, ...]]:
    """Returns a line for each port: how many wrong wirings, how many detected, after how long, and by what mostly."""
    lines = []
    for rows in ports(trials.rows):
        port, found = rows[0].port, [row.found for row in rows if row.found is not None]
        times = [f"{f(one.time for one in found):.5g} s" if found else "" for f in (min, max)]
        by = Counter(one.by.partition(":")[0] if one.how == "refused" else one.by for one in found).most_common(1)
        text = by[0][0] if by else ""
        if by and next(one.how for one in found if text in one.by) == "refused":
            text = f"refused by {text}"
        lines.append((port.name, port.causality[:-3], str(len(rows)), str(len(found)), *times, text))
    return lines


def unobservable(trials: Trials) -> list[tuple[str, list[str], str, str]]:
    """Returns port, wrong wirings, why nothing shows them, and what to add, together where the reason is one."""
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in trials.rows:
        if row.unobservable is not None:
            groups.setdefault((f"{row.port.causality} {row.port.name}", row.unobservable.reason), []).append(row)
    listed = []
    for (name, reason), rows in groups.items():
        left = [row.unobservable for row in rows if row.unobservable is not None]
        listed.append((name, [row.wrong for row in rows], reason, min(left, key=lambda u: u.size).remedy))
    return listed


def verdict(trials: Trials) -> str:
    """Returns the counts in a sentence."""
    found = sum(row.found is not None for row in trials.rows)
    left = len(trials.rows) - found
    count = len(ports(trials.rows))
    text = f"{len(trials.rows)} wrong wirings of {count} port{'' if count == 1 else 's'}: {found} detected"
    return text + (f", {left} not observable" if left else "")


def write_mappings(looked: Looked, folder: Path) -> None:
    """Writes the mappings that are proposed or mended. Raises ResultsError."""
    files = {f"{block}.proposed.yaml": text for block, text in looked.proposed.items()}
    _write(folder, files | {f"{m.block}.mapping.yaml": as_yaml(m.mapping) for m in looked.mended if m.behaves})


def write(trials: Trials, card: Card | None, folder: Path, title: str, looked: Looked | None = None) -> list[Path]:
    """Writes polarity.md, .csv and .json, and the card, into a folder. Raises ResultsError."""
    data = json.dumps(summary(trials, looked), indent=2, ensure_ascii=False) + "\n"
    files = {"polarity.md": markdown(trials, title), "polarity.csv": _csv(trials), "polarity.json": data}
    if card is not None:
        files |= {"card.md": card_markdown(card, title), "card.csv": card_csv(card)}
    return _write(folder, files)


def _write(folder: Path, files: Mapping[str, str]) -> list[Path]:
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            put(folder / name, text)
    return [folder / name for name in files]


def markdown(trials: Trials, title: str) -> str:
    """Returns the tables as a page."""
    lines = [f"# Polarity of {title}", "", f"{verdict(trials)}.", ""]
    header = ("port", "direction", "wrong wirings", "detected", "first after", "last after", "mostly by")
    lines += _table(header, table(trials))
    if left := unobservable(trials):
        lines += ["", "## Not observable", ""]
        lines += _table(
            ("port", "wrong wirings", "why nothing shows it", "what to add"),
            [(name, f"{len(wrongs)}: {', '.join(wrongs)}", reason, remedy) for name, wrongs, reason, remedy in left],
        )
    if trials.skipped:
        names = ", ".join(f"{port.causality} {port.name}" for port in trials.skipped)
        lines += ["", f"Without wrong wirings, since they are integers, enumerations or text: {names}."]
    if trials.margins:
        lines += ["", "## Consistency checks as wired", ""]
        lines += _table(
            ("check", "tolerance over the largest difference"),
            [(name, f"{margin:.3g}" if margin < 1e9 else "above 1e9") for name, margin in trials.margins.items()],
        )
    return "\n".join(lines) + "\n"


def card_markdown(card: Card, title: str) -> str:
    """Returns the test card as a page."""
    lines = [f"# Ground test card of {title}", ""]
    lines += [
        "Each block stands alone with the inputs below.",
        "Change one of them, and wait.",
        "The outputs change by what is expected, to a few percent.",
    ]
    for block, base in card.base.items():
        lines += ["", f"## {block}", "", *_table(("input", "before"), list(base.items())), ""]
        steps = [(s.stimulus, f"{s.hold:.3g} s", s.output, s.expected) for s in card.steps if s.block == block]
        lines += _table(("stimulus", "after", "output", "expected change"), steps)
    return "\n".join(lines) + "\n"


def card_csv(card: Card) -> str:
    """Returns the test card as CSV."""
    header = ("block", "port", "stimulus", "after_s", "output", "expected_change")
    return csv_text([header, *((s.block, s.port, s.stimulus, s.hold, s.output, s.expected) for s in card.steps)])


def _csv(trials: Trials) -> str:
    lines = []
    for row in trials.rows:
        found, left = row.found, row.unobservable
        lines.append(
            (
                row.port.name,
                row.port.causality,
                row.wrong,
                row.kind,
                found.how if found else "not observable",
                found.by if found else "",
                found.time if found else "",
                left.reason if left else "",
                left.remedy if left else "",
            )
        )
    header = ("port", "direction", "wrong_wiring", "kind", "shown_by", "name", "after_s", "reason", "remedy")
    return csv_text([header, *lines])


def summary(trials: Trials, looked: Looked | None = None) -> dict[str, Any]:
    """Returns all of it as plain data."""
    as_wired = None if looked is None or looked.wrong is None else asdict(looked.wrong)
    return {
        "scenario": trials.scenario,
        "duration": trials.duration,
        "nominal": None if trials.nominal is None else asdict(trials.nominal),
        "swap_as_wired": as_wired,
        "mended": [of_mended(mended) for mended in looked.mended] if looked else [],
        "found": sum(row.found is not None for row in trials.rows),
        "not_observable": sum(row.found is None for row in trials.rows),
        "wirings": [
            {
                "port": row.port.name,
                "direction": row.port.causality,
                "wrong": row.wrong,
                "kind": row.kind,
                "found": None if row.found is None else asdict(row.found),
                "not_observable": None if row.unobservable is None else asdict(row.unobservable),
            }
            for row in trials.rows
        ],
        "margins": trials.margins,
        "notes": trials.notes,
    }


def _table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    escaped = [[cell.replace("|", "\\|") for cell in row] for row in rows]
    return [f"| {' | '.join(row)} |" for row in [header, ["---"] * len(header), *escaped]]
