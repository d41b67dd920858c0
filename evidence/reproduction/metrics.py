"""What the paper's claims need of a run beside plain statistics: figures of the hold of all commands, and of b1.

Metrics of campaigns: each is given the times (n,) s and the signals by name. Infinite where a thing never happened.
Tests: tests/evidence/reproduction/test_runs.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

Signals = Mapping[str, Any]
HOLDING, COMMAND = "allocator.holding", "allocator.dipole_cmd"
UNHELD = "unheld.dipole_cmd"
"""Of a second allocator outside the loop that never holds: the demand during a hold."""


def b_wheel(time: Any, signals: Signals) -> float:
    """Least |b1|."""
    return float(np.abs(signals["allocator.b_wheel"]).min())


def _crossed(time: Any, signals: Signals) -> Any:
    """Returns when b1 changes its sign, s."""
    sign = np.sign(signals["allocator.b_wheel"])
    known = np.flatnonzero(sign)
    return time[known[1:][sign[known[1:]] != sign[known[:-1]]]]


def crossings(time: Any, signals: Signals) -> float:
    """Returns how often b1 changes its sign."""
    return float(len(_crossed(time, signals)))


def crossed(time: Any, signals: Signals) -> float:
    """Returns when b1 first changes its sign, s."""
    return float(min(_crossed(time, signals), default=np.inf))


def _holds(signals: Signals) -> tuple[Any, Any]:
    """The first sample of each hold, and the first after each that ends."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], (signals[HOLDING] != 0.0).astype(np.int8)))))
    return edges[::2], edges[1::2]


def _first(signals: Signals) -> slice:
    """The samples of the first hold."""
    begins, ends = _holds(signals)
    return slice(begins[0], ends[0] if len(ends) else None) if len(begins) else slice(0)


def holds(time: Any, signals: Signals) -> float:
    """Returns how many holds there are."""
    return float(len(_holds(signals)[0]))


def held(time: Any, signals: Signals) -> float:
    """Returns when the first hold begins, s."""
    return float(min(time[_holds(signals)[0]], default=np.inf))


def hold_ends(time: Any, signals: Signals) -> float:
    """Returns when the last hold ends, s."""
    begins, ends = _holds(signals)
    return float(time[ends[-1]]) if len(ends) and len(ends) == len(begins) else np.inf


def held_command(time: Any, signals: Signals) -> float:
    """Least norm of the dipoles that are held in the first hold, A m2."""
    return float(min(np.linalg.norm(signals[COMMAND][_first(signals)], axis=1), default=np.inf))


def held_at_zero(time: Any, signals: Signals) -> float:
    """1 where the first hold begins with a command of zero, else 0."""
    at = _holds(signals)[0][:1]
    commands = np.column_stack((signals[COMMAND], signals["allocator.wheel_torque_cmd"]))[at]
    return float(len(at) == 1 and not commands.any())


def held_demand(time: Any, signals: Signals) -> float:
    """Largest demand of a rod in holds, A m2."""
    return float(np.abs(signals[UNHELD][signals[HOLDING] != 0.0]).max(initial=0.0))
