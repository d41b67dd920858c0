"""Rows of a CSV or Parquet file in blocks, as text or numbers, each with its line; a file of any length streams."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, Place, Problem, hint, reason

BLOCK = 50_000
"""Rows at a time."""
LISTED = (".csv", ".dat", ".log", ".parquet", ".tsv", ".txt")
"""Files that a message may show the columns of; another one may hold what is nobody's business."""
_UNIT = re.compile(r"(.*\S)\s*[\[(](.+)[\])]\s*", re.DOTALL)


@dataclass(frozen=True)
class Header:
    """The columns of a file by their names; some have a unit behind their name, in brackets."""

    file: str
    line: int
    places: dict[str, int]
    units: dict[str, str]
    width: int
    """How many columns there are."""
    twice: frozenset[str]
    """Names of several columns."""
    delimiter: str = ","
    """Between the cells of a CSV file."""

    @classmethod
    def of(cls, file: str, line: int, cells: Sequence[str], delimiter: str = ",") -> Header:
        places: dict[str, int] = {}
        units: dict[str, str] = {}
        twice: set[str] = set()
        for i, cell in enumerate(cells):
            match = _UNIT.fullmatch(cell)
            name = match[1] if match else cell.strip()
            twice |= {text for text in (cell.strip(), name) if places.setdefault(text, i) != i}
            if match:
                units[name] = units[cell.strip()] = match[2]
        return cls(file, line, places, units, len(cells), frozenset(twice), delimiter)

    def place(self, name: str) -> int:
        """Raises InputError where there is no such column, or more than one."""
        if name not in self.places:
            known = Path(self.file).suffix.lower() in LISTED
            text = f"there is no column {name!r}{hint(name, self.places) if known else ''}"
            remedy = "cells that commas, semicolons or tabs part" if self.width == 1 else ""
            raise InputError(Problem(text, remedy=remedy, place=Place(self.file, self.line)))
        if name in self.twice:
            raise InputError(Problem(f"several columns are called {name!r}", place=Place(self.file, self.line, name)))
        return self.places[name]


@dataclass(frozen=True)
class Block:
    """Some rows: the line of each (the row's number in Parquet), and the cells of the columns that were asked for."""

    lines: NDArray[np.int64]
    columns: Sequence[Sequence[str]]
    """As they stand in the file."""
    file: str

    def error(self, row: int, name: str, text: str) -> InputError:
        return InputError(Problem(text, place=Place(self.file, int(self.lines[row]), name)))


def header_of(path: Path, shown: str) -> Header:
    """Returns the header of a file. Raises InputError."""
    try:
        if path.suffix == ".parquet":
            return Header.of(shown, 0, [str(name) for name in _parquet(path).schema_arrow.names])
        with path.open(newline="", encoding="utf-8-sig") as file:
            for cells in (reader := _reader(file)):
                if cells:
                    other = next((d for d in ";\t" if len(cells) == 1 and d in cells[0]), None)
                    cells = next(csv.reader(cells, delimiter=other)) if other else cells
                    return Header.of(shown, reader.line_num, cells, other or ",")
    except OSError as error:
        raise InputError(f"{shown} cannot be read: {reason(error)}") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise _no_csv(path, shown, error) from None
    raise InputError(f"{shown}: expected a header and rows, found nothing")


def _no_csv(path: Path, shown: str, error: Exception, line: int | None = None) -> InputError:
    """The refusal of a file, at the first line that is no UTF-8, or at that which the reader had come to."""
    text, remedy = f"this is no CSV file: {error}", "quotes that end on their line"
    if isinstance(error, UnicodeDecodeError):
        text, remedy = "expected text in UTF-8, found bytes that are none", "the file saved as CSV in UTF-8"
        with path.open("rb") as file:
            line = next((n for n, found in enumerate(file, start=1) if not _is_utf8(found)), None)
    return InputError(Problem(text, remedy=remedy, place=Place(shown, line)))


def _is_utf8(line: bytes) -> bool:
    try:
        line.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return True


def _reader(file: Iterable[str], delimiter: str = ",") -> Any:
    """Returns a reader of the rows, to which a comment is an empty line: a quote in it begins no cell."""
    return csv.reader(("\n" if line.startswith("#") else line for line in file), delimiter=delimiter)


def blocks(path: Path, header: Header, names: Sequence[str]) -> Iterator[Block]:
    """Returns the rows of these columns. Raises InputError."""
    places = [header.place(name) for name in names]
    return _of_parquet(path, header, places) if path.suffix == ".parquet" else _of_csv(path, header, places)


def _of_csv(path: Path, header: Header, places: list[int]) -> Iterator[Block]:
    pick = itemgetter(*places, places[0])  # one more, so that it is always a tuple
    with path.open(newline="", encoding="utf-8-sig") as file:
        reader = _reader(file, header.delimiter)
        numbered = ((reader.line_num, row) for row in reader if row)
        next(numbered)
        try:
            while some := list(islice(numbered, BLOCK)):
                lines = np.array([line for line, _ in some])
                try:
                    cells = [pick(row) for _, row in some]
                except IndexError:
                    line, row = next((line, row) for line, row in some if len(row) <= max(places))
                    text = f"expected at least {max(places) + 1} cells, found {len(row)}"
                    raise InputError(Problem(text, place=Place(header.file, line))) from None
                if longer := next((pair for pair in some if any(pair[1][header.width :])), None):
                    _refuse_more(header, *longer)
                yield Block(lines, list(zip(*cells, strict=True))[:-1], header.file)
        except (UnicodeDecodeError, csv.Error) as error:
            raise _no_csv(path, header.file, error, reader.line_num) from None


def _refuse_more(header: Header, line: int, row: list[str]) -> None:
    text = f"expected at most {header.width} cells, as in the header, found {len(row)}"
    raise InputError(Problem(text, place=Place(header.file, line)))


def _of_parquet(path: Path, header: Header, places: list[int]) -> Iterator[Block]:
    opened, first = _parquet(path), 1
    columns = [opened.schema_arrow.names[place] for place in places]
    for batch in opened.iter_batches(BLOCK, columns=list(dict.fromkeys(columns))):
        cells = [_cells(batch.column(name)) for name in columns]
        yield Block(np.arange(first, first + batch.num_rows), cells, header.file)
        first += batch.num_rows


def _cells(column: Any) -> list[str]:
    if str(column.type).startswith("timestamp"):
        return ["" if value is None else value.isoformat() for value in column.to_pylist()]
    return ["" if value is None else str(value) for value in column.to_pylist()]


def _parquet(path: Path) -> Any:
    try:
        import pyarrow.parquet as parquet  # an optional package  # noqa: PLC0415
    except ModuleNotFoundError:
        raise InputError(f"{path.name}: reading Parquet needs pyarrow; remedy: pip install pyarrow") from None
    try:
        return parquet.ParquetFile(path)
    except OSError as error:
        raise InputError(f"{path.name} cannot be read: {reason(error)}") from None
    except Exception as error:  # pyarrow's own errors, which have no common base but this
        raise InputError(f"{path.name} is no Parquet file: {error}") from None
