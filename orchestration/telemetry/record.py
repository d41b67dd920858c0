"""A file as a scenario's `telemetry` describes it: times from the start of the run, and the ports' values, in blocks.

A million rows take some 10 s and the memory of one block. Tests: tests/orchestration/telemetry."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from math import prod
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, Place, Problem
from ..quantities import SECOND, QuantityError, parse_unit
from ..scenario.telemetry import Telemetry
from .rows import Block, Header, blocks, header_of
from .times import DEFAULT_EPOCHS, TimeError, calendar_seconds, instant, instants, utc_text
from .values import are_numbers, check, values

Floats = NDArray[np.float64]


@dataclass
class Seen:
    """Properties of the rows of a record."""

    rows: int = 0
    first: float = np.nan
    """TAI s of t = 0."""
    begin: float = np.nan
    last: float = np.nan
    """s from t = 0, of the first and the last row."""
    repeated: list[int] = field(default_factory=list)
    """Lines of rows that repeat an instant."""
    disordered: list[int] = field(default_factory=list)
    missing: dict[str, int] = field(default_factory=dict)
    """By port: samples with a value that is missing."""
    step: float = 0.0
    """The median of the time between rows, s."""
    gap: tuple[float, int] = (0.0, 0)
    """The longest time between two rows, and the line behind it."""

    def notes(self) -> list[str]:
        """Returns what a user should know of them."""
        found = []
        for lines, what in ((self.repeated, "repeat an instant"), (self.disordered, "are older than one before")):
            if lines:
                found.append(f"{len(lines)} rows {what}, the first in line {lines[0]}")
        found += [f"{count} samples of {name} are missing" for name, count in self.missing.items() if count]
        if self.gap[0] > 3.0 * self.step > 0.0:
            found.append(f"the longest gap has {self.gap[0]:.6g} s, before line {self.gap[1]}")
        return found


class Record:
    """The rows of a file as a telemetry entry takes them. Raises InputError, placed in the file by line and column."""

    def __init__(self, entry: Telemetry, path: Path, shown: str) -> None:
        self.entry, self.path, self.shown, self.seen = entry, path, shown, Seen()
        self.header: Header = header_of(path, shown)
        check(self.header, entry.columns)
        self.header.place(entry.time.column)
        self._factor, self._epoch = self._time_unit()

    def _time_unit(self) -> tuple[float, float]:
        time = self.entry.time
        unit, stated = parse_unit(time.unit), self.header.units.get(time.column, "")
        if not unit.fits(SECOND):
            raise InputError(f"time: the unit {time.unit!r} does not fit 's'")
        if stated.upper() in DEFAULT_EPOCHS:
            self._refuse_time(stated, f"is not the scale {time.scale!r}", stated.upper() != time.scale)
        elif stated:
            with suppress(QuantityError):  # some text, as of a format
                unit = parse_unit(stated)
            self._refuse_time(stated, "does not fit 's'", not unit.fits(SECOND))
        if time.scale == "elapsed" and time.epoch is not None:
            raise InputError("time: epoch: expected none with the scale 'elapsed', whose times count from 0")
        if time.scale == "elapsed":
            return unit.factor, 0.0
        try:
            return unit.factor, sum(calendar_seconds(time.epoch or DEFAULT_EPOCHS[time.scale], time.scale))
        except TimeError as error:
            raise InputError(f"time: epoch: {error}") from None

    def _refuse_time(self, stated: str, what: str, wrong: bool) -> None:
        if wrong:
            place = Place(self.shown, self.header.line, self.entry.time.column)
            raise InputError(Problem(f"{stated!r} of this column {what}", place=place))

    def _start(self, times: Floats) -> float:
        start, scale = self.entry.start, self.entry.time.scale
        if scale == "elapsed" or isinstance(start, float):
            if isinstance(start, str) or (start is not None and scale != "elapsed"):
                raise InputError("start: expected a number with the scale 'elapsed', else a date and time in UTC")
            return float(start or 0.0)
        if start is None:
            return float(times[0])
        try:
            return instant(start, "UTC")
        except TimeError as error:
            raise InputError(f"start: {error}") from None

    def size(self, name: str) -> int:
        """Returns how many elements a port has."""
        return prod(self.entry.columns[name].shape)

    def stream(self) -> Iterator[Floats]:
        """Returns blocks (n, 1 + values): time from t = 0, s, then the values, NaN where missing; times increase."""
        self.seen = Seen(missing=dict.fromkeys(self.entry.columns, 0))
        steps: list[float] = []
        parts = self._parts()
        if self.entry.disordered == "sorted":
            self._earliest()
            parts = _sorted(parts)
        held = np.empty((0, 0))
        for lines, table in parts:
            if len(held):
                lines, table = np.concatenate(([0], lines)), np.concatenate((held, table))
            lines, table = self._in_order(lines, table)
            held = table[-1:]
            between = np.diff(table[:, 0])
            if len(between) and between.max() > self.seen.gap[0]:
                self.seen.gap = float(between.max()), int(lines[int(between.argmax()) + 1])
            steps.append(float(np.median(between)) if len(between) else 0.0)
            yield self._counted(table[:-1])
        if len(held):
            yield self._counted(held)
        self.seen.step = float(np.median(steps)) if steps else 0.0
        if not self.seen.rows:
            some = f" with {', '.join(f'{k} {v!r}' for k, v in self.entry.where.items())}" if self.entry.where else ""
            raise InputError(Problem(f"there are no rows{some}", place=Place(self.shown, self.header.line)))
        if (older := len(self.seen.disordered)) > self.seen.rows:
            text = f"{older} rows are older than one before them, more than the {self.seen.rows} that are not"
            remedy = "'disordered: sorted', or a file without the row whose time is ahead"
            raise InputError(Problem(text, remedy=remedy, place=Place(self.shown, self.seen.disordered[0])))
        if self.seen.last < 0.0:
            text = f"start: expected at or before the last row, found {-self.seen.last:.6g} s after it"
            raise InputError(Problem(text, place=Place(self.shown, self.header.line)))

    def _counted(self, table: Floats) -> Floats:
        at = 1
        for name in self.entry.columns:
            size = self.size(name)
            self.seen.missing[name] += int(np.isnan(table[:, at : at + size]).any(axis=1).sum())
            at += size
        self.seen.rows += len(table)
        if len(table):
            self.seen.begin = float(table[0, 0]) if np.isnan(self.seen.begin) else self.seen.begin
            self.seen.last = float(table[-1, 0])
        return table

    def _earliest(self) -> None:
        """The first instant of rows in any order, where nothing states t = 0."""
        if self.entry.start is None and self.entry.time.scale != "elapsed":
            names = [self.entry.time.column, *self.entry.where]
            self.seen.first = min((float(times.min()) for _, times in self._timed(names)), default=np.nan)

    def _timed(self, names: list[str]) -> Iterator[tuple[Block, Floats]]:
        """The rows that are asked for, with their instants; the first of `names` is the time, behind it are those of
        `where`."""
        entry, scale = self.entry, self.entry.time.scale
        for block in blocks(self.path, self.header, names):
            chosen = np.ones(len(block.lines), bool)
            for i, text in enumerate(entry.where.values(), start=1):
                chosen &= np.array(block.columns[i]) == text
            if not chosen.any():
                continue
            if not chosen.all():
                kept = np.flatnonzero(chosen).tolist()
                block = Block(block.lines[chosen], [[c[k] for k in kept] for c in block.columns], block.file)
            if scale == "elapsed" and not are_numbers(block.columns[0]):
                bad = next(i for i, cell in enumerate(block.columns[0]) if not are_numbers([cell]))
                raise block.error(bad, entry.time.column, f"expected a number, found {block.columns[0][bad]!r}")
            times, bad_time, why = instants(block.columns[0], self._factor, self._epoch, scale)
            if bad_time is not None:
                raise block.error(bad_time, entry.time.column, why)
            yield block, times

    def _parts(self) -> Iterator[tuple[NDArray[np.int64], Floats]]:
        entry = self.entry
        names = [entry.time.column, *entry.where, *(c for port in entry.columns.values() for c in port.cells)]
        for block, times in self._timed(names):
            if np.isnan(self.seen.first):
                self.seen.first = self._start(times)
            times = times - self.seen.first
            yield (
                block.lines,
                np.column_stack([times, *values(block, 1 + len(entry.where), self.header, entry.columns, times)]),
            )

    def _in_order(self, lines: NDArray[np.int64], table: Floats) -> tuple[NDArray[np.int64], Floats]:
        time = table[:, 0]
        if (np.diff(time) > 0.0).all():
            return lines, table
        latest = np.maximum.accumulate(time)
        older = time < latest
        self._refuse(lines[older], "disordered", "is older than the row before it")
        self.seen.disordered += lines[older].tolist()
        lines, table = lines[~older], table[~older]
        same = np.diff(table[:, 0]) == 0.0
        again = lines[1:][same]
        self._refuse(again, "repeated", "has the time of the row before it")
        self.seen.repeated += again.tolist()
        keep = np.append(~same, True) if self.entry.repeated == "last" else np.insert(~same, 0, True)
        return lines[keep], table[keep]

    def _refuse(self, lines: NDArray[np.int64], key: str, what: str) -> None:
        if len(lines) and getattr(self.entry, key) == "refused":
            place = Place(self.shown, int(lines[0]), self.entry.time.column)
            raise InputError(Problem(f"this row {what}", remedy=f"another value of '{key}'", place=place))

    @property
    def utc(self) -> str:
        """The UTC of t = 0; nothing where times are elapsed ones."""
        return "" if self.entry.time.scale == "elapsed" else utc_text(self.seen.first)


def _sorted(parts: Iterator[tuple[NDArray[np.int64], Floats]]) -> Iterator[tuple[NDArray[np.int64], Floats]]:
    found = list(parts)
    if not found:
        return
    lines, tables = zip(*found, strict=True)
    table = np.concatenate(tables)
    order = np.argsort(table[:, 0], kind="stable")
    yield np.concatenate(lines)[order], table[order]
