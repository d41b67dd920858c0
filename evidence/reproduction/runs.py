"""Runs of the two manoeuvres through the native FMUs, and what each shows: campaigns of one run or of many."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from fmus.interface import load as load_interface
from orchestration.campaign.case import Case
from orchestration.campaign.replay import replay
from orchestration.session.read import read

from .. import crew
from ..paper import DURATION, FOLDER, READINGS, SCENARIOS, STEP, Array
from .seen import METRICS, Seen, seen

RESULTS = FOLDER / "reproduction"
_FREE = "unheld"
"""A second allocator outside the loop that never holds: its commands are the demand during a hold."""
_LIMITS = {"dipole_max": 1e9, "wheel_torque_max": 1e9, "hold_fraction": 1.0}
_SIGNALS = {
    "plant": "h_w dipole dipole_saturated wheel_momentum_saturated",
    "controller": "tau_cmd_B lyapunov gain_l",
    "judge": "attitude_error rate_error_B",
    "allocator": "dipole_cmd wheel_torque_cmd holding demand_fraction tau_residual_B b_wheel",
    _FREE: "dipole_cmd",
}


@dataclass(frozen=True)
class Run:
    """One run: what it shows, and the signals for figures."""

    seen: Seen
    hold: str
    """What became of the hold, in words."""
    time: Array
    signals: dict[str, Array]


@cache
def _scenario(which: str) -> dict[str, Any]:
    """A manoeuvre's scenario with the allocator that never holds, without what is only said of it."""
    source = read(SCENARIOS[which]).without([("expect",), ("figures",)])
    wires = [c.replace("-> allocator.", f"-> {_FREE}.") for c in source.data["connections"] if "-> allocator." in c]
    signals = [f"{block}.{name}" for block, names in _SIGNALS.items() for name in names.split()]
    data: dict[str, Any] = source.data
    return {
        **data,
        "blocks": {**data["blocks"], _FREE: {"fmu": "allocator", "start": _LIMITS}},
        "connections": [*data["connections"], *wires],
        "record": {"signals": signals},
    }


def campaign(
    name: str, which: str, changes: Sequence[Mapping[str, Any]], step: float = STEP, duration: float = DURATION
) -> Case:
    """A manoeuvre with each of the changes: start values by `block.parameter`, all of the same parameters.

    Either numbers differ, which are drawn together as one vector `case`, or one text does.
    """
    given = {key: [change[key] for change in changes] for key in changes[0]}
    same = {key: values[0] for key, values in given.items() if all(value == values[0] for value in values)}
    vary: dict[str, Any] = {key: {"grid": v} for key, v in given.items() if key not in same and isinstance(v[0], str)}
    moved = {key: values for key, values in given.items() if key not in same and key not in vary}
    place = count(1)

    def numbers(value: Any) -> str:
        return f"[{', '.join(map(numbers, value))}]" if isinstance(value, list) else f"case[{next(place)}]"

    draw: dict[str, Any] = {}
    if moved:
        rows = [np.concatenate([np.ravel(values[i]) for values in moved.values()]) for i in range(len(changes))]
        draw["case"] = {"grid": [row.tolist() for row in rows]}
        vary |= {key: {"expression": numbers(values[0])} for key, values in moved.items()}
    data = {
        "name": f"{which[0]}{which[2]}_{name}",
        "scenario": {**_scenario(which), "step": step, "duration": duration},
        "set": same,
        "draw": draw,
        "vary": vary,
        "sampling": "grid" if vary else "random",
        "runs": len(changes),
        "metrics": METRICS,
    }
    return crew.case(data, Path(__file__).parent)


def _rods(start: Mapping[str, Any]) -> float:
    """The rods' limit that the allocator knows, A m2; the scenarios leave it at the interface's start."""
    return float(start.get("allocator.dipole_max", load_interface("allocator").variables["dipole_max"].start))


def run(which: str, letter: str = "a", changes: Mapping[str, Any] | None = None, duration: float = DURATION) -> Run:
    """Flies a manoeuvre in one of READINGS, with further start values by `block.parameter`."""
    start = {**READINGS[letter].changes, **(changes or {})}
    wanted = campaign("run", which, [start], duration=duration)
    flown = replay(wanted, 0, crew.folder_of(wanted, RESULTS))  # a folder of its own: others may fly at the same time
    result = flown.result
    signals = {
        ("unheld_" if block == _FREE else "") + name: result[f"{block}.{name}"]
        for block, names in _SIGNALS.items()
        for name in names.split()
    }
    figures = seen(lambda name: np.array([flown.metrics[name]], float), _rods(start))
    return Run(figures, result.holds[0].text, result.time, signals)


def sweep(
    hands: crew.Crew,
    name: str,
    which: str,
    changes: Sequence[Mapping[str, Any]],
    step: float = STEP,
    duration: float = DURATION,
    results: Path = RESULTS,
) -> Seen:
    """Flies a manoeuvre with each of the changes, at integrator order 2; (n,) of n changes."""
    given = [{"plant.integrator_order": 2, **change} for change in changes]
    return seen(hands.fly(campaign(name, which, given, step, duration), results).numbers, _rods(given[0]))
