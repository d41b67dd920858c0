"""What a run showed, in the figures that the paper's claims are about; of one run or of many at once."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from orchestration import Result

from .loops import Loops, Sample
from .setup import Loop
from .vectors import Array, norm

ATTITUDE_TOLERANCE = math.radians(2.0)
RATE_TOLERANCE = 1e-3
"""Settled: attitude error below 2 deg and rate error below 1e-3 rad/s from then to the end of the run."""


@dataclass(frozen=True)
class Seen:
    """Each (n,), of n runs. Times in s; NaN where a thing never happened."""

    settled: Array
    """From when on the errors stay within tolerance; NaN where they do not at the end."""
    attitude_error: Array
    """At the end, rad."""
    rate_error: Array
    """At the end, rad/s."""
    torque: Array
    """Largest |tau| demanded, N m."""
    dipole: Array
    """Largest |dipole| of a rod, A m2."""
    wheel_momentum: Array
    """Largest |l_w|, N m s."""
    demand: Array
    """Largest demand of an actuator over its limit."""
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
    """Least norm of the dipoles that are held in the first hold, A m2."""
    held_at_zero: Array
    """Whether the first hold keeps a command of zero."""
    hold_by_rod: Array
    """Largest demand of a rod over its limit in holds."""
    latched: Array
    """Whether the run ends in a hold."""
    latched_since: Array
    wheel_at_limit_since: Array
    """Since when the wheel has been at its momentum limit to the end of the run."""
    saturated: Array
    """Whether a rod was commanded beyond its limit."""
    lyapunov_rise: Array
    """Largest rise of V between two samples over V(0)."""

    def pick(self, at: int) -> dict[str, float]:
        """Run `at` alone."""
        return {f.name: float(getattr(self, f.name)[at]) for f in fields(self)}


class Watch:
    """Collects `Seen` sample by sample."""

    def __init__(self, n: int, step: float) -> None:
        self.n, self.step, self.first = n, step, True
        nan, zero = np.full(n, np.nan), np.zeros(n)
        self.out: dict[str, Array] = {f.name: (zero if f.name in _FROM_ZERO else nan).copy() for f in fields(Seen)}
        self.out["b_wheel"] = np.full(n, np.inf)
        self.out["held_command"] = np.full(n, np.inf)
        self._holding = np.zeros(n, bool)
        self._began = zero.copy()
        self._sign = zero.copy()
        self._V0 = self._V = zero
        self._outside = np.ones(n, bool)

    def __call__(self, s: Sample) -> None:
        o = self.out
        rate = norm(s.rate_error_B)
        outside = (s.attitude_error >= ATTITUDE_TOLERANCE) | (rate >= RATE_TOLERANCE)
        o["settled"] = np.where(outside, np.nan, np.where(self._outside, s.t, o["settled"]))
        self._outside = outside
        o["attitude_error"], o["rate_error"] = s.attitude_error, rate
        for name, value in (
            ("torque", norm(s.tau_cmd_B)),
            ("dipole", np.abs(s.dipole).max(axis=0)),
            ("wheel_momentum", np.abs(s.h_w)),
            ("demand", s.demand_fraction),
            ("saturated", s.dipole_saturated.astype(float)),
        ):
            o[name] = np.maximum(o[name], value)
        o["b_wheel"] = np.minimum(o["b_wheel"], np.abs(s.b_wheel))
        sign = np.sign(s.b_wheel)
        crossed = sign * self._sign < 0
        o["crossings"] += crossed
        o["crossed"] = np.where(crossed & np.isnan(o["crossed"]), s.t, o["crossed"])
        self._sign = np.where(sign != 0, sign, self._sign)
        self._hold(s)
        since = o["wheel_at_limit_since"]
        o["wheel_at_limit_since"] = np.where(s.wheel_momentum_saturated, np.where(np.isnan(since), s.t, since), np.nan)
        if self.first:
            self._V0 = np.maximum(s.lyapunov, 1e-300)
        else:
            o["lyapunov_rise"] = np.maximum(o["lyapunov_rise"], (s.lyapunov - self._V) / self._V0)
        self._V, self.first = s.lyapunov, False

    def _hold(self, s: Sample) -> None:
        o, now, before = self.out, s.holding.astype(bool), self._holding
        begins, ends = now & ~before, before & ~now
        size = norm(s.dipole_cmd)
        first = begins & np.isnan(o["held"])
        o["held"] = np.where(first, s.t, o["held"])
        o["held_at_zero"] = np.where(first & (size == 0.0) & (s.wheel_torque_cmd == 0.0), 1.0, o["held_at_zero"])
        o["holds"] += begins
        self._began = np.where(begins, s.t, self._began)
        in_first = now & (o["holds"] == 1)
        o["held_command"] = np.where(in_first, np.minimum(o["held_command"], size), o["held_command"])
        o["hold_by_rod"] = np.where(now, np.maximum(o["hold_by_rod"], s.rod_fraction), o["hold_by_rod"])
        o["hold_longest"] = np.where(now | ends, np.maximum(o["hold_longest"], s.t - self._began), o["hold_longest"])
        o["hold_ends"] = np.where(ends, s.t, np.where(now, np.nan, o["hold_ends"]))
        o["latched"] = now.astype(float)
        o["latched_since"] = np.where(now, self._began, np.nan)
        self._holding = now

    @property
    def seen(self) -> Seen:
        return Seen(**{name: np.asarray(value, float).copy() for name, value in self.out.items()})


_FROM_ZERO = (
    "torque dipole wheel_momentum demand crossings hold_longest holds held_at_zero hold_by_rod latched saturated "
    "lyapunov_rise"
).split()


def fly(cases: list[Loop], step: float, duration: float) -> Seen:
    """Flies all the cases together, at integrator order 2, and tells what was seen of each."""
    loops = Loops([case.change({"plant.integrator_order": 2}) for case in cases])
    watch = Watch(loops.n, step)
    loops.fly(step, duration, watch)
    return watch.seen


def of_result(result: Result, names: dict[str, str], rod_fraction: Array) -> Seen:
    """The same of a run through FMUs. `names` are the blocks' names; `rod_fraction` (samples,) as in `Sample`."""
    p, c, a = names["plant"], names["controller"], names["allocator"]
    get = result.__getitem__
    columns = {
        "attitude_error": get(f"{c}.attitude_error"),
        "rate_error_B": get(f"{c}.rate_error_B"),
        "lyapunov": get(f"{c}.lyapunov"),
        "tau_cmd_B": get(f"{c}.tau_cmd_B"),
        "dipole_cmd": get(f"{a}.dipole_cmd"),
        "wheel_torque_cmd": get(f"{a}.wheel_torque_cmd"),
        "holding": get(f"{a}.holding"),
        "demand_fraction": get(f"{a}.demand_fraction"),
        "rod_fraction": rod_fraction,
        "b_wheel": get(f"{a}.b_wheel"),
        "b_B": get(f"{p}.b_B"),
        "h_w": get(f"{p}.h_w"),
        "dipole": get(f"{p}.dipole"),
        "dipole_saturated": get(f"{p}.dipole_saturated"),
        "wheel_momentum_saturated": get(f"{p}.wheel_momentum_saturated"),
    }
    time = result.time
    watch = Watch(1, float(time[1] - time[0]))
    for i, t in enumerate(time):
        watch(
            Sample(t=float(t), **{k: np.atleast_1d(v[i]) if v.ndim == 1 else v[i][:, None] for k, v in columns.items()})
        )
    return watch.seen
