"""What a review is made of: sections with tables, figures and notes, as data that pages, CSV and comparisons take."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from orchestration import InputError
from orchestration.errors import writing
from orchestration.results.whole import content, put

REVIEW = "review.json"
APART = " ‖ "
"""Between the values of two designs in a cell."""


@dataclass
class Table:
    name: str
    columns: list[str]
    rows: list[list[str]]
    note: str = ""

    @property
    def file(self) -> str:
        """The name of its CSV file."""
        return re.sub(r"\W+", "_", self.name.lower()).strip("_") + ".csv"


@dataclass
class Curves:
    """A figure: curves over one axis."""

    name: str
    x: list[float]
    x_label: str
    y_label: str
    y: dict[str, list[float]]
    lines: list[float] = field(default_factory=list)
    log: bool = False


@dataclass
class Section:
    heading: str
    tables: list[Table] = field(default_factory=list)
    figures: list[Curves] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    drawing: str = ""
    """SVG."""
    motion: dict[str, Any] | None = None
    """What a three-dimensional view shows, with its arrays in it."""


@dataclass
class Review:
    name: str
    description: str
    facts: dict[str, str]
    sections: list[Section]
    verdicts: list[str] = field(default_factory=list)
    """Of the requirements."""

    def save(self, folder: Path) -> None:
        """Writes review.json and a CSV file for each table. Raises ResultsError."""
        with writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
            put(folder / REVIEW, json.dumps(asdict(self), indent=1) + "\n")
            for section in self.sections:
                for table in section.tables:
                    save_table(table, folder / table.file)


def save_table(table: Table, path: Path) -> None:
    """Writes a table as CSV."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(table.columns)
        writer.writerows(table.rows)


def load(folder: Path) -> Review:
    """Returns the review of a folder. Raises InputError."""
    try:
        found = TypeAdapter(Review).validate_json(content(folder / REVIEW), strict=True)
        for section in found.sections:
            _fits(section)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        first = error.errors()[0] if isinstance(error, ValidationError) else None
        said = f"{'.'.join(map(str, first['loc']))}: {first['msg']}" if first else str(error)
        raise InputError(f"{folder / REVIEW}: expected what a review wrote, found {said}") from None
    return found


def _fits(section: Section) -> None:
    """Raises ValueError where a row or a curve is not as long as what stands beside it, or a view has no name."""
    lengths = [(table.name, len(table.columns), map(len, table.rows)) for table in section.tables]
    lengths += [(one.name, len(one.x), map(len, one.y.values())) for one in section.figures]
    for name, expected, each in lengths:
        wrong = next((length for length in each if length != expected), None)
        if wrong is not None:
            raise ValueError(f"{name}: {wrong} values in the place of {expected}")
    if section.motion is not None and not isinstance(section.motion.get("name"), str):
        raise ValueError(f"{section.heading}: motion without its name")


def number(value: float, figures: int = 3) -> str:
    """Returns a number to some figures; a dash where it is none."""
    if value != value or abs(value) == float("inf"):
        return "–"
    text = f"{value:.{figures}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < 1e6 else text
