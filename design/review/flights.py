"""Flights of a review: each a scenario that extends the reviewed one, flown once and kept.

So a review goes on where it was stopped.

A flight has two files in the folder: `NAME.yaml`, which `orchestrate` flies alike, and `NAME.npz` with its record and
the hash of all that decides it. Tests: tests/design/review/test_flights.py.
"""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orchestration import InputError, Scenario
from orchestration.errors import writing
from orchestration.results.arrays import Arrays
from orchestration.results.view import view
from orchestration.results.whole import parsed, put, putting
from orchestration.scenario.text import written
from orchestration.session.open import open_fmus
from orchestration.session.read import load, read
from orchestration.session.run import whole
from plant.so3 import Array

INTERVAL = 2.0
"""s between recorded samples."""


@dataclass(frozen=True)
class Flight:
    name: str
    changes: Mapping[str, Any]
    """The scenario's entries over those of the file."""
    signals: tuple[str, ...]


@dataclass(frozen=True)
class Flown:
    time: Array
    signals: Mapping[str, Array]
    failure: str
    """Why it ended early, or ""."""
    file: Path

    def __getitem__(self, name: str) -> Array:
        return self.signals[name]


def fly(
    file: Path, flights: Iterable[Flight], folder: Path, workers: int, tell: Callable[[int], None] = lambda n: None
) -> dict[str, Flown]:
    """Flies what has not been flown and returns all by name; `tell` is given how many are done.

    `workers` 0 flies in this process. Raises InputError where a flight's scenario is wrong.
    """
    flights = list(flights)
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for flight in flights:
            put(folder / f"{flight.name}.yaml", _text(file, flight, folder))
    paths = [folder / f"{flight.name}.yaml" for flight in flights]
    if workers == 0 or len(paths) < 2:
        for done, path in enumerate(paths, start=1):
            _fly(path)
            tell(done)
    else:
        spawned = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(min(workers, len(paths)), mp_context=spawned) as pool:
            running = [pool.submit(_fly, path) for path in paths]
            try:
                for done, one in enumerate(as_completed(running), start=1):
                    one.result()
                    tell(done)
            except BrokenProcessPool:
                text = f"{file}: a block ended the process of its flight; remedy: isolation: process"
                raise InputError(text) from None
            except BaseException:
                pool.shutdown(cancel_futures=True)
                raise
    return {flight.name: _read(path) for flight, path in zip(flights, paths, strict=True)}


def _text(file: Path, flight: Flight, folder: Path) -> str:
    extends = os.path.relpath(file.resolve(), folder.resolve())
    record = {"interval": INTERVAL, "signals": list(flight.signals)}
    entries = {"expect": [], "figures": [], "record": record, **flight.changes}
    return f"# Written by orchestrate review.\n{written({'name': flight.name, 'extends': extends, **entries})}"


def _fly(path: Path) -> None:
    """Flies a scenario and keeps its record, unless it is there."""
    scenario = load(read(path))
    kept, key = path.with_suffix(".npz"), _key(scenario)
    if kept.exists() and _kept_key(kept) == key:
        return
    result = whole(scenario)
    arrays: dict[str, Any] = {name: np.asarray(result[name]) for name in result}
    failure = "" if result.failure is None else str(result.failure)
    with writing(kept), putting(kept) as new, new.open("wb") as file:
        np.savez(file, **arrays, time=result.time, failure=np.array(failure), key=np.array(key))


def motion(file: Path, duration: str, folder: Path) -> dict[str, Any] | None:
    """Returns what a view shows of the scenario as it stands, with its arrays; flown once and kept. None where it has
    no attitude to be seen."""
    path = folder / "as-it-stands.yaml"
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        put(path, _text(file, Flight(path.stem, {"duration": duration}, ("*",)), folder))
    scenario = load(read(path))
    kept, key = path.with_suffix(".json"), _key(scenario)
    with suppress(OSError, ValueError, KeyError, TypeError):
        data = parsed(kept)
        if data["key"] == key:
            shown: dict[str, Any] | None = data["view"]
            return shown
    result = whole(scenario)
    if result.failure is not None:
        raise result.failure
    shown = view(result, Arrays(inline=True))
    put(kept, json.dumps({"key": key, "view": shown}))
    return shown


def _key(scenario: Scenario) -> str:
    fmus = {name: fmu.sha256 for name, fmu in sorted(open_fmus(scenario).items())}
    return hashlib.sha256(f"{scenario.model_dump_json()} {fmus}".encode()).hexdigest()


def _kept_key(path: Path) -> str:
    """Returns the hash of a record that can be read whole, else ""."""
    try:
        with np.load(path, allow_pickle=False) as data:
            return str({name: data[name] for name in data.files}["key"])
    except Exception:  # NumPy, zipfile and zlib raise what they please of a damaged file, which is flown again
        return ""


def _read(path: Path) -> Flown:
    with np.load(path.with_suffix(".npz"), allow_pickle=False) as data:
        signals = {name: data[name] for name in data.files if name not in ("time", "failure", "key")}
        found = Flown(data["time"], signals, str(data["failure"]), path)
    if not len(found.time):
        raise InputError(f"{path}: {found.failure}")
    return found
