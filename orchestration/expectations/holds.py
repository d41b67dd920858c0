"""Holds of a run: while a boolean signal is true, other signals keep their values.

A scenario names such a signal in its section `holds`. A hold has one of four outcomes: never held; held at zero from
the start; a running value held and released; latched, which is a hold that lasts to the end of the run.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..errors import Problems
from ..fmu.model import Floats, Model
from ..scenario.expectations import HoldEntry
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from ..system import signals
from ..system.wiring import Node

NEVER = "never held"
AT_ZERO = "held at zero from the start"
RELEASED = "held and released"
LATCHED = "latched"


@dataclass(frozen=True)
class Hold:
    """The course of one hold. Times in s."""

    name: str
    signal: str
    outcome: str
    """One of `NEVER`, `AT_ZERO`, `RELEASED`, `LATCHED`."""
    spans: list[tuple[float, float | None]]
    """From when to when it was held; None: to the end of the run."""
    from_zero: bool
    """Whether the first hold begins with the run and keeps zeros."""
    limits: dict[str, float] = field(default_factory=dict)
    """Of a latched hold: the limits that stand at the end of the run, and since when, s."""

    @property
    def latched(self) -> bool:
        """Returns whether the run ended in it."""
        return self.outcome == LATCHED

    @property
    def text(self) -> str:
        """Returns the outcome as a sentence."""
        if not self.spans:
            return NEVER
        start, end = self.spans[-1]
        if end is not None:
            return self._released
        before = f" after {_releases(len(self.spans) - 1)}" if len(self.spans) > 1 else ""
        what = "at zero from the start" if self.from_zero and len(self.spans) == 1 else f"since t = {start:.6g} s"
        at = "".join(f", {limit} since {since:.6g} s" for limit, since in self.limits.items())
        return f"{LATCHED}: held {what} to the end of the run{before}{at}"

    @property
    def _released(self) -> str:
        first, last = self.spans[0][0], self.spans[-1][1]
        what = AT_ZERO if self.from_zero else f"running values held from {first:.6g} s"
        if len(self.spans) == 1:
            return f"{what} to {last:.6g} s, then released"
        longest = max(end - start for start, end in self.spans if end is not None)
        often = f"{len(self.spans)} times in all, the longest for {longest:.6g} s"
        return f"{what}; {often}, released for the last time at {last:.6g} s"


def _releases(n: int) -> str:
    return "one release" if n == 1 else f"{n} releases"


@dataclass(frozen=True)
class HoldCheck:
    """A hold of the scenario whose signals the blocks have."""

    entry: HoldEntry
    flag: Node
    kept: list[Node]
    limits: dict[str, Node]

    @property
    def needed(self) -> list[Node]:
        return [self.flag, *self.kept, *self.limits.values()]


def prepare(scenario: Scenario, models: Mapping[str, Model]) -> list[HoldCheck]:
    """Checks the scenario's holds against the blocks. Raises InputError with every error."""
    held: list[HoldCheck] = []
    with Problems() as problems:
        for number, entry in enumerate(scenario.holds):
            with problems.gathered():
                held.append(_check(scenario, ("holds", number), entry, models))
    return held


def _check(scenario: Scenario, key: Key, entry: HoldEntry, models: Mapping[str, Model]) -> HoldCheck:
    flag = signals.flag(scenario, (*key, "signal"), entry.signal, models)
    places = [((*key, "keeps", i), name) for i, name in enumerate(entry.keeps)]
    kept = [node for place, name in places for node in signals.find(scenario, place, name, models)[1]]
    limits = {
        limit: signals.flag(scenario, (*key, "limits", limit), name, models) for limit, name in entry.limits.items()
    }
    return HoldCheck(entry, flag, kept, limits)


class HoldObserver:
    """Takes in a hold's signals piece by piece, and has its outcome in the end."""

    def __init__(self, check: HoldCheck) -> None:
        self.check = check
        self._spans: list[tuple[float, float | None]] = []
        self._seen = self._held = self._from_zero = False
        self._since: dict[str, float] = {}
        """The limits that stand, and since when."""

    def see(self, time: Floats, columns: Mapping[Node, Floats]) -> None:
        """Takes in the samples that follow those before; a flag is true where it is not zero."""
        if not len(time):
            return
        held = columns[self.check.flag] != 0.0
        if not self._seen:
            self._seen = True
            self._from_zero = bool(held[0]) and not any(columns[node][0] for node in self.check.kept)
        for i in np.flatnonzero(held != np.concatenate(([self._held], held[:-1]))):
            if held[i]:
                self._spans.append((float(time[i]), None))
            else:
                self._spans[-1] = self._spans[-1][0], float(time[i])
        self._held = bool(held[-1])
        for limit, node in self.check.limits.items():
            off = np.flatnonzero(columns[node] == 0.0)
            if len(off):
                self._since.pop(limit, None)
            if columns[node][-1] != 0.0:
                self._since.setdefault(limit, float(time[off[-1] + 1 if len(off) else 0]))

    @property
    def hold(self) -> Hold:
        """Returns the hold as it stands up to now."""
        outcome = AT_ZERO if self._from_zero else RELEASED
        if not self._spans or self._held:
            outcome = LATCHED if self._held else NEVER
        standing = dict(self._since) if self._held else {}
        entry = self.check.entry
        return Hold(entry.name, entry.signal, outcome, list(self._spans), self._from_zero, standing)
