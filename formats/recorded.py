"""The signals of a run, from its folder or from a `Result`: arrays by name, units, parameters."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchestration.errors import InputError, Place, Problem, hint, reason
from orchestration.results.data import RunData
from orchestration.results.place import check
from orchestration.results.whole import parsed

_ELEMENT = re.compile(r"(.*?)((?:\[\d+\])+)$")


@dataclass(frozen=True)
class Recorded:
    """Record of a run, by `block.variable` as in `Result`."""

    name: str
    """Of the scenario."""
    time: NDArray[np.float64]
    """(n,) s, rising."""
    signals: dict[str, NDArray[np.float64]]
    """(n,), (n, 3), (n, 3, 3), by name."""
    units: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """The parameters of each block."""
    finished: str = ""
    """UTC at which the run ended, ISO 8601."""

    def signal(self, name: str, option: str) -> NDArray[np.float64]:
        """Returns a signal. Raises InputError, which names the option, where it was not recorded or is not finite."""
        if name not in self.signals:
            raise InputError(
                Problem(
                    f"{name} was not recorded{hint(name, self.signals)}",
                    remedy="record it (record.signals), or name another signal",
                    place=Place(option),
                )
            )
        values = self.signals[name]
        if (wrong := ~np.isfinite(values.reshape(len(values), -1)).all(axis=1)).any():
            found = f"a value that is none at {self.time[wrong.argmax()]:.10g} s"
            raise InputError(Problem(expected="finite numbers", found=found, place=Place(option, name=name)))
        return values


def recorded(result: RunData | Path) -> Recorded:
    """Returns the signals of a result, or of the folder of one. Raises InputError where there is none."""
    if isinstance(result, Path):
        return _of_folder(result)
    signals = {name: np.asarray(values, float) for name, values in result.items()}
    return _made(result.time, signals, result.manifest)


def _of_folder(folder: Path) -> Recorded:
    check(folder)
    try:
        manifest = parsed(folder / "manifest.json")
        own = [manifest.get(key, {}) for key in ("units", "parameters")] if isinstance(manifest, dict) else [None]
        if not all(isinstance(entry, dict) for entry in own):
            raise ValueError("a manifest.json that is none")
        label, values = _table(folder)
    except (OSError, ValueError) as error:
        why = reason(error) if isinstance(error, OSError) else str(error)
        expected = "the folder of a run, with manifest.json and signals.csv or signals.parquet"
        remedy = "orchestrate run SCENARIO --out FOLDER, with --format csv or parquet"
        raise InputError(Problem(expected=expected, found=why, remedy=remedy, place=Place(str(folder)))) from None
    if label[:1] != ["time"] or values.ndim != 2 or values.shape[1] != len(label):
        expected = "a column time, then a column a signal"
        raise InputError(Problem(expected=expected, found=", ".join(label[:3]), place=Place(str(folder / "signals"))))
    columns: dict[str, dict[tuple[int, ...], int]] = {}
    for column, name in enumerate(label[1:], start=1):
        match = _ELEMENT.match(name)
        indices = tuple(int(i) for i in re.findall(r"\d+", match[2])) if match else ()
        columns.setdefault(match[1] if match else name, {})[indices] = column
    signals = {}
    for name, places in columns.items():
        shape = tuple(1 + max(i) - min(i) for i in zip(*places, strict=True))
        if len(places) == np.prod(shape, dtype=int):
            signals[name] = values[:, [places[key] for key in sorted(places)]].reshape(len(values), *shape)
    return _made(values[:, 0], signals, manifest)


def _table(folder: Path) -> tuple[list[str], NDArray[np.float64]]:
    """Returns the header and the rows of the signals."""
    for name in ("signals.parquet", "signals.csv"):
        if (folder / name).exists() and not (folder / name).is_file():
            raise ValueError(f"{name} is no regular file")
    path = folder / "signals.parquet"
    if path.exists():
        import pyarrow.parquet  # optional, and slow to import  # noqa: PLC0415

        table = pyarrow.parquet.read_table(path)
        return table.column_names, np.column_stack([column.to_numpy() for column in table.columns])
    with (folder / "signals.csv").open(encoding="utf-8") as file:
        header = file.readline().rstrip("\n").split(",")
        if not (rows := file.read().split()):
            raise ValueError("no rows in signals.csv")
        return header, np.loadtxt(rows, delimiter=",", ndmin=2)


def _made(time: NDArray[np.float64], signals: dict[str, NDArray[np.float64]], manifest: Mapping[str, Any]) -> Recorded:
    scenario, finished = manifest.get("scenario"), manifest.get("finished")
    return Recorded(
        name=str(scenario.get("name")) if isinstance(scenario, dict) else "run",
        time=time,
        signals=signals,
        units=manifest.get("units", {}),
        parameters=manifest.get("parameters", {}),
        finished=str(finished) if finished else "",
    )
