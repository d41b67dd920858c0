"""Changes a scenario as the options of a command say: --set, --swap, --map, --step, --duration, --flavour, --realtime.

Tests: tests/orchestration/cli/test_options.py, test_realtime.py, test_cli.py.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..scenario.realtime import OFF, with_pace
from ..scenario.scenario import Scenario
from ..scenario.source import Source
from ..scenario.text import parse
from ..session.read import load, read
from ..swap.option import Swap, swapped, swaps_of
from .console import is_quiet, notes


def settings(sets: Iterable[str]) -> dict[str, Any]:
    """Returns the value of each --set by the name that it is for. Raises InputError.

    Of several for one name the last counts, and the user is told.
    """
    values: dict[str, Any] = {}
    given: dict[str, str] = {}
    for text in sets:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not name or not value:
            remedy = "; remedy for an empty text: ''" if equals and name else ""
            raise InputError(f"--set {text}: expected block.parameter=value{remedy}")
        name = name.removeprefix("shared.")
        if (earlier := given.get(name)) is not None and not is_quiet():
            notes([f"--set {earlier} has no effect: --set {text}, which follows, counts"])
        given[name], values[name] = text, parse(value, f"--set {text}").data
    return values


def overridden(source: Source, sets: Iterable[str] = (), **values: str | None) -> Source:
    """Returns the scenario with `block.parameter=value` of each --set, and the given values of `step` and the like.

    Raises InputError.
    """
    for name, value in settings(sets).items():
        source = source.with_start(name, value, option="--set ")
    for key, wanted in values.items():
        if wanted is not None:
            source = source.with_value(key, wanted, f"--{key}")
    return source


@dataclass(frozen=True)
class Changes:
    """The options of a command that change the scenario before it is used. All methods raise InputError."""

    sets: Sequence[str] = ()
    swaps: Sequence[str] = ()
    maps: Sequence[str] = ()
    step: str | None = None
    duration: str | None = None
    flavour: str | None = None
    realtime: float | str | None = None
    late: str | None = None
    late_tolerance: str | None = None

    @cached_property
    def given(self) -> list[Swap]:
        """Returns the swaps of --swap and --map."""
        return swaps_of(self.swaps, self.maps)

    @property
    def blocks(self) -> list[str]:
        """Returns the blocks that are swapped."""
        return [swap.block for swap in self.given]

    def diagnosis(self, scenario: Path) -> list[str]:
        """Returns the commands that say why a loop with these swaps does not pass."""
        again = [f"--set {shlex.quote(value)}" for value in self.sets]
        again += [f"--duration {shlex.quote(self.duration)}"] if self.duration is not None else []
        swaps = [f"--swap {shlex.quote(text)}" for text in self.swaps] + [f"--map {shlex.quote(t)}" for t in self.maps]
        name = shlex.quote(str(scenario))
        lines = [f"orchestrate polarity {' '.join([name, *swaps, *again])}"]
        if len(self.swaps) == 1:
            lines.append(f"orchestrate compare {' '.join([name, *swaps, *again])}")
        return lines

    def unswapped(self, path: Path) -> Source:
        """Returns the scenario of a file with all of them but --swap and --map."""
        return self._changed(read(path))

    def scenario(self, path: Path) -> Scenario:
        """Returns the scenario of a file with all of them."""
        return load(self._changed(swapped(read(path), self.given)))

    def _changed(self, source: Source) -> Source:
        source = overridden(source, self.sets, step=self.step, duration=self.duration, flavour=self.flavour)
        options = {
            "factor": ("--realtime", self.realtime),
            "late": ("--late", self.late),
            "tolerance": ("--late-tolerance", self.late_tolerance),
        }
        given = {key: (name, value) for key, (name, value) in options.items() if value is not None}
        stated = isinstance(source.data, dict) and source.data.get("realtime") is not None
        if given and (self.realtime == OFF or (self.realtime is None and not stated)):
            for name, value in (entry for key, entry in given.items() if key != "factor"):
                raise InputError(f"{name} {value}: only a run in real time has late steps; remedy: --realtime")
        places = {
            key: f"{name} {value:g}" if key == "factor" and value != OFF else f"{name} {value}"
            for key, (name, value) in given.items()
        }
        return with_pace(source, {key: value for key, (_, value) in given.items()}, places) if given else source
