"""The files of the studies' pages: a line of CSV for each flight or tumble, by the names of its columns.
Tests: tests/evidence/verification/test_cost.py."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

from orchestration import InputError

T = TypeVar("T")
_OF_TEXT: dict[type, Callable[[str], Any]] = {bool: {"True": True, "False": False}.__getitem__}
"""What makes a value of its text; the type itself where it is not here."""


def read(file: Path, columns: Sequence[str], remedy: str) -> list[dict[str, str]]:
    """The lines. Raises InputError with the remedy, a command, for a file without one of the columns."""
    with file.open(encoding="utf-8", newline="") as text:
        lines = csv.DictReader(text)
        if missing := next((name for name in columns if name not in (lines.fieldnames or ())), None):
            raise InputError(f"{file}: expected a column {missing!r}, found none; remedy: {remedy}")
        return list(lines)


def write(file: Path, columns: Sequence[str], lines: Iterable[Mapping[str, Any]]) -> None:
    """Writes the lines."""
    with file.open("w", encoding="utf-8", newline="") as text:
        out = csv.DictWriter(text, columns, lineterminator="\n")
        out.writeheader()
        out.writerows(lines)


def load(kind: type[T], file: Path, remedy: str) -> list[T]:
    """The lines as records of a dataclass, whose fields are the columns. Raises InputError as `read` does."""
    kinds = get_type_hints(kind)
    of_text = {name: _OF_TEXT.get(kinds[name], kinds[name]) for name in _columns(kind)}
    records = []
    for number, line in enumerate(read(file, list(of_text), remedy), 2):
        try:
            records.append(kind(**{name: make(line[name]) for name, make in of_text.items()}))
        except (TypeError, ValueError, KeyError) as error:
            raise InputError(f"{file}:{number}: {error}; remedy: {remedy}") from error
    return records


def load_if_any(kind: type[T], file: Path, remedy: str) -> list[T]:
    """As `load`; none without a file."""
    return load(kind, file, remedy) if file.is_file() else []


def save(kind: type[T], file: Path, records: Iterable[T], digits: int = 5) -> None:
    """Writes records of a dataclass, numbers to so many digits."""
    lines = (asdict(record) for record in records)  # type: ignore[call-overload]
    write(
        file,
        _columns(kind),
        ({k: f"{v:.{digits}g}" if isinstance(v, float) else v for k, v in line.items()} for line in lines),
    )


def _columns(kind: type) -> list[str]:
    return [field.name for field in fields(kind)]
