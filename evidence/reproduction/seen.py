"""What runs show, in the figures that the paper's claims are about: metrics of campaigns.
Tests: tests/evidence/reproduction/test_runs.py."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..paper import ATTITUDE_TOLERANCE, RATE_TOLERANCE, Array
from .metrics import COMMAND, HOLDING, UNHELD


@dataclass(frozen=True)
class Seen:
    """Each (n,), of n runs. Times in s; NaN where a thing never happened."""

    settled: Array
    """From when on the errors stay within tolerance; NaN where they do not at the end."""
    attitude_error: Array
    """At the end, rad."""
    torque: Array
    """Largest |tau| demanded, N m."""
    dipole: Array
    """Largest |dipole| of a rod, A m2."""
    wheel_momentum: Array
    """Largest |l_w|, N m s."""
    b_wheel: Array
    """Least |b1|."""
    crossings: Array
    """How often b1 changes its sign."""
    crossed: Array
    """When it first does."""
    held: Array
    """When the first hold begins."""
    hold_ends: Array
    """When the last hold ends; NaN where it does not."""
    holds: Array
    """How many there are."""
    held_command: Array
    """Least norm of the dipoles that are held in the first hold, A m2; infinite without a hold."""
    held_at_zero: Array
    """Whether the first hold keeps a command of zero."""
    hold_by_rod: Array
    """Largest demand of a rod over its limit in holds."""
    latched: Array
    """Whether the run ends in a hold."""
    wheel_at_limit_since: Array
    """Since when the wheel has been at its momentum limit to the end of the run."""
    saturated: Array
    """Whether a rod was commanded beyond its limit."""


_METRICS: dict[str, dict[str, Any]] = {
    "angle": {"signal": "judge.attitude_error", "settles": {"below": ATTITUDE_TOLERANCE}},
    "rate": {"signal": "judge.rate_error_B", "measure": "norm", "settles": {"below": RATE_TOLERANCE}},
    "attitude_error": {"signal": "judge.attitude_error", "statistic": "final"},
    "torque": {"signal": "controller.tau_cmd_B", "measure": "norm", "statistic": "maximum"},
    "dipole": {"signal": "plant.dipole", "statistic": "peak"},
    "wheel_momentum": {"signal": "plant.h_w", "statistic": "peak"},
    "latched": {"signal": HOLDING, "statistic": "final"},
    "wheel_at_limit_since": {"signal": "plant.wheel_momentum_saturated", "settles": {"equals": True}},
    "saturated": {"signal": "plant.dipole_saturated", "statistic": "maximum"},
}
_FUNCTIONS = {
    "allocator.b_wheel": ("b_wheel", "crossings", "crossed"),
    HOLDING: ("held", "hold_ends", "holds"),
    f"{HOLDING} {COMMAND}": ("held_command",),
    f"{HOLDING} {COMMAND} allocator.wheel_torque_cmd": ("held_at_zero",),
    f"{HOLDING} {UNHELD}": ("held_demand",),
}
"""Those of metrics.py, by the signals that they are given."""
METRICS = [{"name": name, **metric} for name, metric in _METRICS.items()] + [
    {"name": name, "python": f"metrics:{name}", "signals": signals.split()}
    for signals, names in _FUNCTIONS.items()
    for name in names
]
_NEVER = ("settled", "crossed", "held", "hold_ends", "wheel_at_limit_since")
"""Times, infinite as metrics where a thing never happened."""


def seen(numbers: Callable[[str], Array], dipole_max: float) -> Seen:
    """`Seen` of runs, from their metrics (n,) by name and the rods' limit, A m2."""
    names = [name for name in Seen.__dataclass_fields__ if name not in ("settled", "hold_by_rod")]
    found = {name: numbers(name) for name in names}
    found["settled"] = np.maximum(numbers("angle"), numbers("rate"))
    found["hold_by_rod"] = numbers("held_demand") / dipole_max
    return Seen(**found | {name: np.where(np.isinf(found[name]), math.nan, found[name]) for name in _NEVER})
