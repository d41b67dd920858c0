"""The paper's claims of its two manoeuvres, each as a number and a bound."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..paper import DURATION, ORBIT, Array
from .seen import Seen


@dataclass(frozen=True)
class Claim:
    """A claim: `value` in `unit` is to lie below (above) `bound`."""

    text: str
    paper: str
    """What the paper says."""
    value: Callable[[Seen], Array]
    bound: float
    unit: str = ""
    below: bool = True
    implied: bool = False
    """Not said in words, but implied by what is."""
    show: Callable[[float], str] = lambda value: f"{value:.3g}"

    def margin(self, seen: Seen) -> Array:
        """Positive where the claim holds; NaN where there is no value, and then it does not hold."""
        value = self.value(seen)
        return self.bound - value if self.below else value - self.bound

    def holds(self, seen: Seen) -> Array:
        return np.asarray(self.margin(seen) > 0.0)


def _yes(value: float) -> str:
    return "yes" if value else "no"


def _settled(value: float) -> str:
    return f"{value:.1f}" if math.isfinite(value) else "not settled at the end"


def _crossing(seen: Seen) -> Array:
    return np.where(seen.crossings == 1, seen.crossed, np.nan)


VB = (
    Claim(
        "errors reach zero",
        "in less than 1/30 orbit (193 s)",
        lambda s: s.settled,
        ORBIT / 30,
        "s",
        show=_settled,
    ),
    Claim("each torquer's dipole", "below 15 A m²", lambda s: s.dipole, 15.0, "A m²"),
    Claim("wheel momentum", "below 3.5 mN m s", lambda s: 1e3 * s.wheel_momentum, 3.5, "mN m s"),
    Claim(
        "least |b₁|, the field along the wheel",
        "never near zero",
        lambda s: np.where(s.crossings == 0, s.b_wheel, 0.0),
        0.1,
        below=False,
        show=lambda v: f"{v:.3f}" if v else "crosses zero",
    ),
    Claim(
        "inputs are held",
        "no hold",
        lambda s: (s.holds > 0).astype(float),
        0.5,
        implied=True,
        show=_yes,
    ),
)
VC = (
    Claim(
        "errors reach zero",
        "in less than 1/20 orbit (290 s)",
        lambda s: s.settled,
        ORBIT / 20,
        "s",
        show=_settled,
    ),
    Claim("wheel momentum", "below 4 mN m s", lambda s: 1e3 * s.wheel_momentum, 4.0, "mN m s"),
    Claim(
        "b₁ crosses zero once, at",
        "a short while after the start",
        _crossing,
        30.0,
        "s",
        show=lambda v: f"{v:.1f}" if math.isfinite(v) else "never, or more than once",
    ),
    Claim(
        "a torquer's largest demand in the hold",
        "20 A m² (0.8 times): all inputs are held",
        lambda s: s.hold_by_rod,
        0.8 - 1e-12,
        "times its limit",
        below=False,
    ),
    Claim(
        "what is held",
        "the last values of a running command",
        lambda s: np.where(np.isfinite(s.held_command) & (s.held_at_zero == 0), s.held_command, 0.0),
        1.0,
        "A m²",
        below=False,
        implied=True,
    ),
    Claim(
        "the hold is released at",
        "released",
        lambda s: np.where((s.latched == 0) & (s.holds > 0), s.hold_ends, np.nan),
        DURATION,
        "s",
        implied=True,
        show=lambda v: f"{v:.1f}" if math.isfinite(v) else "never",
    ),
    Claim(
        "a torquer saturates",
        "none does",
        lambda s: s.saturated,
        0.5,
        show=_yes,
    ),
)
CLAIMS = {"V.B": VB, "V.C": VC}


def all_hold(which: str, seen: Seen) -> Array:
    return np.logical_and.reduce([claim.holds(seen) for claim in CLAIMS[which]])


OUTCOMES = (
    "every claim met",
    "settles in time, another claim not met",
    "not settled in time, no latch",
    "latched after a running command",
    "latched at zero from the start",
)


def outcome(which: str, seen: Seen) -> Array:
    """Returns which of OUTCOMES each run shows."""
    in_time = CLAIMS[which][0].holds(seen)
    latched = seen.latched == 1
    at_zero = latched & (seen.held_at_zero == 1) & (seen.held == 0.0) & (seen.holds == 1)
    return np.select([all_hold(which, seen), in_time, at_zero, latched], [0, 1, 4, 3], 2)


HOLDS = (
    "never held",
    "a running command held and released",
    "held at zero from the start, released",
    "latched after a running command",
    "latched at zero from the start",
)


def hold_outcome(seen: Seen) -> Array:
    """Returns which of HOLDS each run shows; `holds` of a scenario tells the same of a single run."""
    at_zero = (seen.held_at_zero == 1) & (seen.held == 0.0)
    latched = seen.latched == 1
    return np.select([seen.holds == 0, latched & at_zero & (seen.holds == 1), latched, at_zero], [0, 4, 3, 2], 1)
