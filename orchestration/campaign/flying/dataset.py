"""The rows of a campaign on the disk: one Parquet dataset, `runs/part-000000.parquet` and so on.

Each part is whole or not there at all, and is listed in the manifest with its SHA-256.
Tests: tests/orchestration/campaign/test_sums.py, tests/orchestration/campaign/test_engine.py.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from ...errors import InputError, ResultsError, reason
from ...interrupt import held
from ..sums import RUNS, digest, parts
from .job import OK, Cell, Job, RunRows

_TYPES: dict[str, Any] = {"int64": pa.int64(), "string": pa.string(), "double": pa.float64(), "bool": pa.bool_()}
_ROWS_MAX = 50_000
"""So many rows are held at most before they are written."""
_EVERY, _SHARE = 2.0, 0.02
"""Rows are written after so many seconds, or after this share of the time that the campaign has taken, whatever is
longer.
"""
_PART = ".part-"
_REMEDY = "remedy: remove it, and its runs are flown again"


class Dataset:
    """The rows that are there, and those that wait to be written."""

    def __init__(
        self,
        folder: Path,
        job: Job,
        runs: int,
        earlier: Mapping[str, Any] | None = None,
        listed: Callable[[], None] | None = None,
    ) -> None:
        """Reads the parts that an earlier start left; `earlier` is its manifest. `listed` writes a manifest
        with `files`; without it the rows are only read.

        Raises InputError where a part cannot be read or is none of the campaign, or where there are more than `runs`.
        """
        self._campaign, self.folder, self._listed = folder, folder / RUNS, listed
        self.schema = pa.schema([(name, _TYPES[kind]) for name, kind in job.columns])
        self.done: NDArray[np.bool_] = np.zeros(runs, bool)
        """Which runs have been flown, written or not."""
        self.failed: NDArray[np.bool_] = np.zeros(runs, bool)
        self.met: dict[str, NDArray[np.bool_]] = {one.name: np.zeros(runs, bool) for one in job.requirements}
        """Which runs meet each requirement."""
        self.reason: str | None = None
        """Why the first run failed that did."""
        self.files: dict[str, str] = dict((earlier or {}).get("files", {}))
        """The parts with their SHA-256."""
        self.withdrawn: list[str] = list((earlier or {}).get("withdrawn", []))
        """Parts that others took the places of, which may still be there."""
        self._names = [name for name, _ in job.columns]
        self._rows: dict[int, list[Cell]] = {}
        self._place: NDArray[np.int32] = np.full(runs, -1, np.int32)
        """The number of the part in which each run is; -1 for none."""
        self._part = 1 + max((_number(name) for name in (*self.files, *self.withdrawn)), default=-1)
        self._begun = self._written = monotonic()
        self._restore(runs)

    def _restore(self, runs: int) -> None:
        if self._listed is not None:
            for left in (*self.folder.glob(f"{_PART}*"), *(self.folder / name for name in self.withdrawn)):
                with suppress(OSError):
                    left.unlink()
            self.withdrawn = []
        there = parts(self._campaign, self.files, self.withdrawn, whole=False)
        self.files = {path.name: self.files[path.name] for path in there}
        wanted = ["index", "status", "reason", *(f"met: {name}" for name in self.met)]
        largest = -1
        for path in there:
            table = self._read(path, wanted)
            index = table.column("index").to_numpy()
            if table.column("index").null_count or index.min(initial=0) < 0:
                raise InputError(f"{path} has a row without the index of its run; {_REMEDY}")
            largest = max(largest, int(index.max(initial=-1)))
            if largest >= runs:
                continue  # the others may hold a larger one
            if self.done[index].any() or len(np.unique(index)) < len(index):
                raise InputError(f"{path} holds a run that is there already; {_REMEDY}")
            self._note(index, [table.column(name).to_pylist() for name in wanted[1:]])
            self._place[index] = _number(path.name)
        if largest >= runs:
            remedy = f"--runs {largest + 1} or more, or another folder (--out)"
            raise InputError(
                f"{self._campaign} holds {largest + 1} runs, more than the {runs} that are wanted; remedy: {remedy}"
            )

    def _read(self, path: Path, columns: Sequence[str] | None = None) -> Any:
        """Returns the table of a part. Raises InputError."""
        try:
            with pq.ParquetFile(path) as file:
                table = file.read(columns) if file.schema_arrow.equals(self.schema) else None
        except (OSError, pa.ArrowException, ValueError) as error:
            raise InputError(f"{path} cannot be read: {reason(error)}; {_REMEDY}") from None
        if table is None:
            raise InputError(f"{path} has other columns than this campaign; remedy: another folder (--out)")
        return table

    def _note(self, index: Any, columns: Sequence[Sequence[Any]]) -> None:
        """Notes rows, given by their indices and the columns status, reason and met."""
        status, reasons, *met = columns
        self.done[index] = True
        failed = np.array([one != OK for one in status], bool)
        self.failed[index] = failed
        if self.reason is None and failed.any():
            self.reason = reasons[int(failed.argmax())]
        for name, flags in zip(self.met, met, strict=True):
            self.met[name][index] = [bool(flag) for flag in flags]

    def add(self, rows: RunRows) -> None:
        """Takes in rows, and writes a part now and then. Raises ResultsError."""
        if not rows:
            return
        places = [self._names.index(name) for name in ("status", "reason", *(f"met: {name}" for name in self.met))]
        self._note([row[0] for row in rows], [[row[place] for row in rows] for place in places])
        self._rows |= {_index(row): row for row in rows}
        now = monotonic()
        if len(self._rows) >= _ROWS_MAX or now - self._written > max(_EVERY, _SHARE * (now - self._begun)):
            self.flush()

    def row(self, index: int) -> list[Cell]:
        """Returns the row of a run that is there. Raises InputError."""
        if index in self._rows:
            return self._rows[index]
        path = self.folder / _name(int(self._place[index]))
        (row,) = pq.read_table(path, filters=[("index", "=", index)], schema=self.schema).to_pylist()
        return [row[name] for name in self._names]

    def withdraw(self, indices: Iterable[int]) -> None:
        """Takes rows back, written or not, so that their runs can be flown again. Raises InputError, ResultsError.

        A part that holds some is written again without them under another name, and removed once that is there.
        """
        gone = np.array(sorted(indices), np.int64)
        self.done[gone] = self.failed[gone] = False
        for flags in self.met.values():
            flags[gone] = False
        for index in gone:
            self._rows.pop(int(index), None)
        for number in np.unique(self._place[gone]):
            if number < 0:
                continue
            name = _name(int(number))
            table = self._read(self.folder / name)
            left = table.filter(~np.isin(table.column("index").to_numpy(), gone))
            self._place[self._place == number] = -1
            self.withdrawn.append(name)
            del self.files[name]
            if len(left):
                self._place[left.column("index").to_numpy()] = self._part
                self._write(left)
            elif self._listed is not None:
                self._listed()
            (self.folder / name).unlink(missing_ok=True)

    def flush(self) -> None:
        """Writes what waits. Raises ResultsError; the parts before stand."""
        if not self._rows:
            return
        rows = [self._rows[index] for index in sorted(self._rows)]
        columns = [pa.array([row[i] for row in rows], field.type) for i, field in enumerate(self.schema)]
        part = self._part
        with held():
            self._write(pa.Table.from_arrays(columns, schema=self.schema))
            self._place[list(self._rows)] = part
            self._rows = {}
        self._written = monotonic()

    def _write(self, table: Any) -> None:
        """Writes the next part: its content, then the manifest that lists it, then its name. Raises ResultsError."""
        name = _name(self._part)
        path, part = self.folder / name, self.folder / f"{_PART}{self._part:06d}"
        try:
            with held():
                self.folder.mkdir(parents=True, exist_ok=True)
                part.unlink(missing_ok=True)  # of a killed start, or a link
                pq.write_table(table, part)
                descriptor = os.open(part, os.O_RDWR)
                try:
                    os.fsync(descriptor)
                finally:
                    os.close(descriptor)
                self.files[name] = digest(part)
                if self._listed is not None:
                    self._listed()
                os.replace(part, path)
                self._part += 1
        except (OSError, pa.ArrowException, ResultsError) as error:
            self.files.pop(name, None)
            with suppress(OSError):
                part.unlink(missing_ok=True)
            if isinstance(error, ResultsError):
                raise
            remedy = "the runs that are written stand, and the same command goes on from there"
            raise ResultsError(f"the runs cannot be written: {path}: {reason(error)}; {remedy}") from None


def _name(number: int) -> str:
    return f"part-{number:06d}.parquet"


def _number(name: str) -> int:
    return int(name.removeprefix("part-").removesuffix(".parquet"))


def _index(row: Sequence[Cell]) -> int:
    return int(row[0] or 0)
