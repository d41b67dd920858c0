"""What a review is made of: sections with tables, figures and notes, as data that pages, CSV and comparisons take."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from orchestration import InputError
from orchestration.errors import writing
from orchestration.results.whole import parsed

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
            (folder / REVIEW).write_text(json.dumps(asdict(self), indent=1) + "\n", "utf-8")
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
        data: dict[str, Any] = parsed(folder / REVIEW)
        sections = [
            Section(
                entry["heading"],
                [Table(**table) for table in entry["tables"]],
                [Curves(**curves) for curves in entry["figures"]],
                entry["notes"],
                entry["drawing"],
                entry.get("motion"),
            )
            for entry in data["sections"]
        ]
        return Review(data["name"], data["description"], data["facts"], sections, data["verdicts"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{folder / REVIEW}: expected what a review wrote, found {error}") from None


def number(value: float, figures: int = 3) -> str:
    """Returns a number to some figures; a dash where it is none."""
    if value != value or abs(value) == float("inf"):
        return "–"
    text = f"{value:.{figures}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < 1e6 else text
