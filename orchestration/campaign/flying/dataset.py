"""The rows of a campaign on the disk: one Parquet dataset, `runs/part-000000.parquet` and so on, each part whole or not there at all."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from ...errors import InputError, ResultsError, reason
from ...interrupt import held
from .job import OK, Job, RunRows

_TYPES: dict[str, Any] = {"int64": pa.int64(), "string": pa.string(), "double": pa.float64(), "bool": pa.bool_()}
_ROWS_MAX = 50_000
"""So many rows are held at most before they are written."""
_EVERY, _SHARE = 2.0, 0.02
"""Rows are written after so many seconds, or after this share of the time that the campaign has taken, whatever is longer."""
_PART = ".part-"


class Dataset:
    """The rows that are there, and those that wait to be written."""

    def __init__(self, folder: Path, job: Job, runs: int) -> None:
        """Reads what an earlier start left. Raises InputError where that cannot be read, or holds more than `runs`."""
        self.folder = folder / "runs"
        self.schema = pa.schema([(name, _TYPES[kind]) for name, kind in job.columns])
        self.done: NDArray[np.bool_] = np.zeros(runs, bool)
        """Which runs have been flown, written or not."""
        self.failed: NDArray[np.bool_] = np.zeros(runs, bool)
        self.met: dict[str, NDArray[np.bool_]] = {one.name: np.zeros(runs, bool) for one in job.requirements}
        """Which runs meet each requirement."""
        self.reason: str | None = None
        """Why the first run failed that did."""
        self._names = [name for name, _ in job.columns]
        self._rows: RunRows = []
        self._part = 0
        self._begun = self._written = monotonic()
        self._restore(runs)

    def _restore(self, runs: int) -> None:
        if not self.folder.is_dir():
            return
        for left in self.folder.glob(f"{_PART}*"):
            left.unlink(missing_ok=True)
        wanted = ["index", "status", "reason", *(f"met: {name}" for name in self.met)]
        largest = -1
        for path in sorted(self.folder.glob("part-*.parquet")):
            try:
                with pq.ParquetFile(path) as file:
                    schema = file.schema_arrow
                    table = file.read(wanted) if schema.equals(self.schema) else None
            except (OSError, pa.ArrowException, ValueError) as error:
                raise InputError(
                    f"{path} cannot be read: {reason(error)}; remedy: remove it, and its runs are flown again"
                ) from None
            if table is None:
                raise InputError(f"{path} has other columns than this campaign; remedy: another folder (--out)")
            index = table.column("index").to_numpy()
            largest = max(largest, int(index.max(initial=-1)))
            if largest >= runs:
                continue  # the others may hold a larger one
            self._note(index, [table.column(name).to_pylist() for name in wanted[1:]])
            self._part = int(path.stem.removeprefix("part-")) + 1
        if largest >= runs:
            remedy = f"--runs {largest + 1} or more, or another folder (--out)"
            raise InputError(
                f"{self.folder.parent} holds {largest + 1} runs, more than the {runs} that are wanted; remedy: {remedy}"
            )

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
        self._rows += rows
        now = monotonic()
        if len(self._rows) >= _ROWS_MAX or now - self._written > max(_EVERY, _SHARE * (now - self._begun)):
            self.flush()

    def flush(self) -> None:
        """Writes what waits. Raises ResultsError; the parts before stand."""
        if not self._rows:
            return
        rows = sorted(self._rows, key=lambda row: row[0])  # type: ignore[arg-type, return-value]
        table = pa.Table.from_arrays(
            [pa.array([row[i] for row in rows], field.type) for i, field in enumerate(self.schema)], schema=self.schema
        )
        path, part = self.folder / f"part-{self._part:06d}.parquet", self.folder / f"{_PART}{self._part:06d}"
        try:
            with held():
                self.folder.mkdir(parents=True, exist_ok=True)
                pq.write_table(table, part)
                descriptor = os.open(part, os.O_RDWR)
                try:
                    os.fsync(descriptor)
                finally:
                    os.close(descriptor)
                os.replace(part, path)
                self._rows, self._part = [], self._part + 1
        except (OSError, pa.ArrowException) as error:
            part.unlink(missing_ok=True)
            remedy = "the runs that are written stand, and the same command goes on from there"
            raise ResultsError(f"the runs cannot be written: {path}: {reason(error)}; {remedy}") from None
        self._written = monotonic()
