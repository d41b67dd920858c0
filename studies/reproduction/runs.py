"""Runs of the two manoeuvres through the native FMUs, and what each shows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from fmus.interface import load as load_interface
from orchestration.runner.read import read as read_source
from orchestration.scenario.source import Source

from .. import native
from ..paper import DURATION, READINGS, SCENARIOS, STEP, Array
from .seen import Seen, of_run, together

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
def _scenario(which: str) -> Source:
    """A manoeuvre's scenario with the allocator that never holds, without what is only said of it."""
    source = read_source(SCENARIOS[which]).without([("expect",), ("figures",)])
    wires = [c.replace("-> allocator.", f"-> {_FREE}.") for c in source.data["connections"] if "-> allocator." in c]
    source = source.with_entry(("blocks", _FREE), {"fmu": "allocator", "start": _LIMITS})
    source = source.with_entry(("connections",), [*source.data["connections"], *wires])
    signals = [f"{block}.{name}" for block, names in _SIGNALS.items() for name in names.split()]
    return source.with_entry(("record",), {"signals": signals})


@cache
def _fmus() -> Mapping[str, Any]:
    return native.pin()


def _fly(which: str, changes: Mapping[str, Any], step: float, duration: float) -> tuple[Any, dict[str, Array]]:
    """A run's Result and its signals without their blocks' names."""
    result = native.run(_scenario(which), _fmus(), {**changes, "step": step, "duration": duration})
    signals = {
        ("unheld_" if block == _FREE else "") + name: result[f"{block}.{name}"]
        for block, names in _SIGNALS.items()
        for name in names.split()
    }
    return result, signals


def _rods(start: Mapping[str, Any]) -> float:
    """The rods' limit that the allocator knows, A m2; the scenarios leave it at the interface's start."""
    return float(start.get("allocator.dipole_max", load_interface("allocator").variables["dipole_max"].start))


def run(which: str, letter: str = "a", changes: Mapping[str, Any] | None = None, duration: float = DURATION) -> Run:
    """Flies a manoeuvre in one of READINGS, with further start values by `block.parameter`."""
    start = {**READINGS[letter].changes, **(changes or {})}
    result, signals = _fly(which, start, STEP, duration)
    return Run(together([of_run(result.time, signals, _rods(start))]), result.holds[0].text, result.time, signals)


def sweep(which: str, changes: Iterable[Mapping[str, Any]], step: float = STEP, duration: float = DURATION) -> Seen:
    """Flies a manoeuvre with each of the changes, at integrator order 2; (n,) of n changes."""
    runs = []
    for change in changes:
        start = {"plant.integrator_order": 2, **change}
        result, signals = _fly(which, start, step, duration)
        runs.append(of_run(result.time, signals, _rods(start)))
    return together(runs)
