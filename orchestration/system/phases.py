"""The phases of a run, by their names: windows of time from the timeline, or values of a signal."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, Problems, hint
from ..fmu.model import Floats, Model
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from ..scenario.timeline import windows
from . import signals
from .clock import slack
from .values import scalar
from .wiring import Node


@dataclass(frozen=True)
class Phase:
    """Duration of a phase: from the beginning of a window, included, to its end, excluded; or while the signal has the
    value."""

    spans: tuple[tuple[float, float], ...] = ()
    signal: Node | None = None
    value: float = 0.0

    def chosen(self, time: Floats, columns: Mapping[Node, Floats]) -> NDArray[np.bool_]:
        """Returns which samples (n,) are of the phase."""
        if self.signal is not None:
            return columns[self.signal] == self.value
        early = time + slack(time)
        within = [(early >= begin) & (early < end) for begin, end in self.spans]
        return np.logical_or.reduce(within) if within else np.zeros(len(time), bool)


def phases(scenario: Scenario, models: Mapping[str, Model]) -> dict[str, Phase]:
    """All phases of a scenario. Raises InputError where the signal of `phases` or one of its values does not fit."""
    found: dict[str, Phase] = {}
    for name, begin, end in windows(scenario.timeline):
        before = found[name].spans if name in found else ()
        found[name] = Phase((*before, (begin, math.inf if end is None else end)))
    if scenario.phases is None:
        return found
    key: Key = ("phases", "signal")
    variable, nodes = signals.find(scenario, key, scenario.phases.signal, models)
    if len(nodes) != 1 or variable.type == "real":
        message = f"expected one boolean, whole number or enumeration, but {scenario.phases.signal} is {variable.kind}"
        raise InputError(scenario.error(key, message))
    with Problems() as problems:
        for name, value in scenario.phases.names.items():
            place: Key = ("phases", "names", name)
            if name in found:
                text = "is a phase of the timeline, too"
                problems.append(scenario.error(place, text, expected="another name"))
                continue
            with problems.gathered(), scenario.naming(place):
                phase = Phase(signal=nodes[0], value=float(scalar(variable, nodes[0].element.position, value)))
                if other := next((known for known, there in found.items() if there == phase), None):
                    text = f"has the value of {other!r}, {value}"
                    problems.append(scenario.error(place, text, expected="one name for a value"))
                found[name] = phase
    return found


def during(
    places: signals.Places, key: Key, names: str | Iterable[str] | None, known: Mapping[str, Phase]
) -> tuple[Phase, ...]:
    """The phases that these names mean; none where there are no names. Raises InputError."""
    wanted = [names] if isinstance(names, str) else list(names or ())
    for name in wanted:
        if name not in known:
            remedy = hint(name, known) if known else "; remedy: a 'phase' in the timeline, or 'phases'"
            raise InputError(places.error(key, f"there is no phase {name!r}{remedy}"))
    return tuple(known[name] for name in wanted)
