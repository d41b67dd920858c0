"""What a run shows, in the figures that the paper's claims are about."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from ..paper import ATTITUDE_TOLERANCE, RATE_TOLERANCE, Array
from ..settling import settling_time


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
    hold_longest: Array
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


def of_run(time: Array, s: Mapping[str, Array], dipole_max: float) -> dict[str, float]:
    """`Seen` of one run, by its fields' names, from its signals (rows are samples) and the rods' limit, A m2."""
    outside = (s["attitude_error"] >= ATTITUDE_TOLERANCE) | (_norm(s["rate_error_B"]) >= RATE_TOLERANCE)
    sign = np.sign(s["b_wheel"])
    known = np.flatnonzero(sign)
    crossed = known[1:][sign[known[1:]] != sign[known[:-1]]]
    at_limit = settling_time(time, ~s["wheel_momentum_saturated"].astype(bool))
    return {
        "settled": settling_time(time, outside),
        "attitude_error": float(s["attitude_error"][-1]),
        "torque": float(_norm(s["tau_cmd_B"]).max()),
        "dipole": float(np.abs(s["dipole"]).max()),
        "wheel_momentum": float(np.abs(s["h_w"]).max()),
        "b_wheel": float(np.abs(s["b_wheel"]).min()),
        "crossings": float(len(crossed)),
        "crossed": float(time[crossed[0]]) if len(crossed) else math.nan,
        "wheel_at_limit_since": at_limit,
        "saturated": float(s["dipole_saturated"].any()),
        **_holds(time, s, dipole_max),
    }


def _holds(time: Array, s: Mapping[str, Array], dipole_max: float) -> dict[str, float]:
    """The figures of the hold of all commands."""
    now = s["holding"].astype(bool)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], now.astype(np.int8)))))
    begins, ends = edges[::2], edges[1::2]
    latched = bool(now[-1])
    lasts = time[np.append(ends, len(time) - 1) if latched else ends] - time[begins]
    size = _norm(s["dipole_cmd"])
    none = not len(begins)
    first = slice(begins[0], ends[0] if len(ends) else None) if not none else slice(0)
    return {
        "held": math.nan if none else float(time[begins[0]]),
        "hold_ends": float(time[ends[-1]]) if len(ends) and not latched else math.nan,
        "hold_longest": 0.0 if none else float(lasts.max()),
        "holds": float(len(begins)),
        "held_command": math.inf if none else float(size[first].min()),
        "held_at_zero": float(not none and size[begins[0]] == 0.0 and s["wheel_torque_cmd"][begins[0]] == 0.0),
        "hold_by_rod": 0.0 if none else float(np.abs(s["unheld_dipole_cmd"][now]).max() / dipole_max),
        "latched": float(latched),
    }


def together(runs: Sequence[Mapping[str, float]]) -> Seen:
    """Many runs as one `Seen`."""
    return Seen(**{f.name: np.array([run[f.name] for run in runs]) for f in fields(Seen)})


def _norm(vectors: Array) -> Array:
    return np.asarray(np.linalg.norm(vectors, axis=1))
