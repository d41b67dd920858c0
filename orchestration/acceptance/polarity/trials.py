"""Flies all wrong wirings of a scenario's ports, in several processes.

Tests: tests/orchestration/acceptance/test_polarity.py.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass
from functools import cache

from ...errors import InputError, hint
from ...scenario.source import Source
from .apart import guarded, inside
from .fly import Found, Loop
from .ports import Port, ports
from .reasons import Nominal, Unobservable
from .wrongs import Wrong, wrongs

_PART = 7
"""Wrong wirings that a process takes at a time."""


@dataclass(frozen=True)
class Row:
    """One wrong wiring, and by what it was found."""

    port: Port
    wrong: str
    kind: str
    found: Found | None
    unobservable: Unobservable | None = None


@dataclass(frozen=True)
class Trials:
    """All wrong wirings, and by what they were found."""

    scenario: str
    duration: float
    nominal: Found | None
    """The first that the loop as it is wired does not meet; then nothing else was flown."""
    rows: list[Row]
    skipped: list[Port]
    """Ports without wrong wirings, such as enumerations."""
    notes: list[str]
    margins: dict[str, float]
    """How often larger than in the nominal run the difference of each consistency check could be."""


Progress = Callable[[int, int], None]
"""Called with how many are flown and how many there are."""


def run(
    source: Source,
    blocks: Iterable[str] | None = None,
    chosen: Sequence[str] = (),
    workers: int | None = None,
    progress: Progress | None = None,
) -> Trials:
    """Flies every wrong wiring of the ports of these blocks, or of those named. Raises InputError and BlockError."""
    loop = Loop(source)
    scenario = loop.plan.scenario
    nominal, _ = loop.fly()
    if loop.failure is not None and loop.failure.time is None:
        raise loop.failure
    if nominal is not None:
        return Trials(scenario.name, scenario.duration, nominal, [], [], loop.notes, {})
    found = _chosen(ports_of(loop, blocks), chosen)
    tasks = [(port, wrongs(port)) for port in found]
    parts = [(port, some[i : i + _PART]) for port, some in tasks for i in range(0, len(some), _PART)]
    total = sum(len(some) for _, some in tasks)
    rows: dict[tuple[str, str, str], Row] = {}
    for done in _flown(source, loop, parts, workers or os.cpu_count() or 1):
        rows.update(((row.port.causality, row.port.name, row.wrong), row) for row in done)
        if progress is not None:
            progress(len(rows), total)
    ordered = [rows[port.causality, port.name, wrong.name] for port, some in tasks for wrong in some]
    skipped = [port for port, some in tasks if not some]
    return Trials(scenario.name, scenario.duration, None, ordered, skipped, loop.notes, loop.margins)


def ports_of(loop: Loop, blocks: Iterable[str] | None = None) -> list[Port]:
    """Returns the ports of a loop; which of them are rotations, a run tells."""
    nodes = list(dict.fromkeys(node for link in loop.plan.wiring.links for node in link.source))
    _, signals = loop.record(nodes)
    return ports(loop.plan.models, loop.plan.wiring, signals, blocks)


def _chosen(found: list[Port], names: Sequence[str]) -> list[Port]:
    """Returns the ports of these names, or all without names. Raises InputError where there is none."""
    if not found:
        raise InputError("no port is connected, so none can be wired wrongly")
    for name in names:
        if not any(_named(port, name) for port in found):
            known = dict.fromkeys(f"{port.block}.{port.variable}" for port in found)
            raise InputError(f"--port {name}: no port of this name is connected{hint(name, known)}")
    return [port for port in found if not names or any(_named(port, name) for name in names)]


def _named(port: Port, name: str) -> bool:
    return name in (port.name, f"{port.block}.{port.variable}")


def _flown(source: Source, loop: Loop, parts: list[tuple[Port, list[Wrong]]], workers: int) -> Iterator[list[Row]]:
    if workers == 1 or len(parts) < 2:
        nominal = cache(lambda: Nominal(loop))
        for part in parts:
            yield _fly(loop, nominal, *part)
        return
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # threads of BLAS would only take the processes' cores
    with guarded(source, min(workers, len(parts)), _open, inside(source)) as pool:
        try:
            for future in as_completed([pool.submit(_fly_here, *part) for part in parts]):
                yield future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


_here: list[tuple[Loop, Callable[[], Nominal]]] = []
"""The loop that a process has opened, and its run as wired."""


def _open(source: Source) -> None:
    loop = Loop(source)
    _here[:] = [(loop, cache(lambda: Nominal(loop)))]


def _fly_here(port: Port, some: list[Wrong]) -> list[Row]:
    return _fly(*_here[0], port, some)


def _fly(loop: Loop, nominal: Callable[[], Nominal], port: Port, some: list[Wrong]) -> list[Row]:
    rows = []
    for wrong in some:
        found, _ = loop.fly(port, wrong)
        why = nominal().why(port, wrong) if found is None else None
        rows.append(Row(port, wrong.name, wrong.kind, found, why))
    return rows
