"""Gains for a scenario or a satellite: controller/sizing.py from its values, tried on random starts.

The blocks of a satellite file (`shared` alone) are put in; a wish's errors then come from options.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import yaml

import allocator
import controller
import plant
from controller import so3
from controller.errors import errors
from controller.reference import inertial, lvlh
from controller.sizing import Sizing, Wish, fastest, size
from orchestration import InputError
from orchestration.scenario.source import Source

from .exact import Array, Flown, fly
from .loop import BLOCKS, Loop, Setup, read

DIRECTIONS = 2000
"""Directions of the field in the body that are looked at."""
STARTS, SEED = 60, 1
"""Random starts that are flown."""


def setup_of(source: Source) -> Setup:
    """The loop of a scenario, or of a satellite file with the start values of the blocks. Raises InputError."""
    data = source.data
    if isinstance(data, dict) and "blocks" not in data:
        for key, value in (
            ("name", "satellite"),
            ("step", 0.1),
            ("duration", 1.0),
            ("blocks", {name: {"fmu": name} for name in BLOCKS}),
        ):
            source = source.with_entry((key,), value)
    return read(source)


def initial_errors(loop: Loop) -> tuple[float, float]:
    """|zeta(0)|, rad, and |omega(0)|, rad/s, of the plant's start relative to the controller's reference."""
    p, law = loop.plant, loop.controller
    x = plant.start(p, plant.Inputs(np.zeros(3), 0.0))
    r, v = p.orbit.position_velocity(0.0)
    e = errors(x.R, p.omega_B0, lvlh(r, v) if law.reference == "lvlh" else inertial(law.desired_attitude_0))
    return e.angle, so3.norm(e.omega)


def directions() -> Array:
    """Unit vectors (DIRECTIONS, 3), evenly over the sphere (a Fibonacci spiral); none has b1 = 0."""
    i = np.arange(DIRECTIONS) + 0.5
    b1, around = 1.0 - 2.0 * i / DIRECTIONS, math.pi * (1.0 + math.sqrt(5.0)) * i
    r = np.sqrt(1.0 - b1 * b1)
    return np.stack((b1, r * np.cos(around), r * np.sin(around)), axis=1)


def available(p: allocator.Parameters, b_B: Array) -> Array:
    """Torque (n,), N m, that the paper's allocation gives about every axis before it holds, in each field b_B (n,3), T.

    The wheel is at rest. With P = I - e1 b^T/b1 [20] and rods B M_B [18], a torque tau asks for the dipoles
    pinv(B M_B) P tau [24] and for the wheel torque tau.b/b1.
    """
    b = b_B / np.linalg.norm(b_B, axis=1)[:, None]
    rods = np.cross(p.U, b_B[:, None]).transpose(0, 2, 1)
    oblique = np.eye(3) - np.eye(3)[0][:, None] * (b / b[:, :1])[:, None, :]
    dipole = np.linalg.norm(np.linalg.pinv(rods, rcond=1e-9) @ oblique, axis=2).max(axis=1)
    within = np.minimum(p.dipole_max / dipole, p.wheel_torque_max * np.abs(b[:, 0]))
    return np.asarray(p.hold_fraction * within)


@dataclass(frozen=True)
class Study:
    """Gains of a wish and what becomes of them."""

    sizing: Sizing
    available: Array
    """Torque that the actuators give in each of DIRECTIONS directions of the field, N m, in ascending order."""
    field: float
    """The least strength of the field over the wished time, T."""
    fastest: Sizing | None
    """Where the wish's torque is not kept: the shortest time that keeps it."""
    schedule: str

    def share(self, torque: float) -> float:
        """The part of the field's directions in which the actuators give a torque about every axis."""
        return 1.0 - float(np.searchsorted(self.available, torque)) / len(self.available)

    def start_values(self) -> dict[str, Any]:
        """Start values of `controller`, rounded to four digits."""
        s = self.sizing
        scale: dict[str, Any] = {"phi": "linear", "gain_schedule": "constant", "kappa0": 1.0, "lambda0": 1.0}
        scale |= s.schedule() if self.schedule == "error" else {}
        return {"K0": _rounded(s.K0), "L0": _rounded(s.L0)} | {
            name: _rounded(value) if isinstance(value, float) else value for name, value in scale.items()
        }

    def yaml(self) -> str:
        """The start values as part of a scenario, to paste or to be named by `extends`."""
        return yaml.safe_dump(
            {"blocks": {"controller": {"start": self.start_values()}}}, sort_keys=False, default_flow_style=None
        )

    def fly(self, law: controller.Parameters, starts: int = STARTS) -> Flown:
        """Random starts at the wish's largest errors, axes of error and rate uniform; exact torque, twice the time."""
        w, rng = self.sizing.wish, np.random.default_rng(SEED)
        axes = rng.standard_normal((2, starts, 3))
        axes /= np.linalg.norm(axes, axis=2, keepdims=True)
        Q = np.array([so3.exp(w.attitude_error * axis) for axis in axes[0]])
        given: dict[str, Any] = {
            name: np.array(value) if isinstance(value, list) else value for name, value in self.start_values().items()
        }
        p = replace(law, J_B=w.J_B, **given)
        Omega = w.rate_error * axes[1] - w.orbital_rate * Q[:, 1]
        return fly(p, w.J_B, Q, Omega, 2.0 * w.time, w.time / 250.0, w.orbital_rate)


def _rounded(value: float | Array) -> Any:
    if isinstance(value, float):
        return float(f"{value:.4g}")
    return [_rounded(part) for part in value.tolist()] if value.ndim == 1 else [_rounded(row) for row in value]


def study(
    setup: Setup,
    time: float,
    attitude_error: float | None = None,
    rate_error: float | None = None,
    torque: float | None = None,
    damping: float | None = None,
    schedule: str = "constant",
) -> Study:
    """The sizing for a loop; what is None comes from the scenario, the torque from half of the field's directions.

    Raises InputError.
    """
    loop = setup.loop
    if loop.controller.reference == "rate":
        raise setup.error("controller", "reference", "expected 'lvlh' or 'inertial' for sizing, found 'rate'")
    if attitude_error is None or rate_error is None:
        angle, rate = initial_errors(loop)
        attitude_error = angle if attitude_error is None else attitude_error
        rate_error = rate if rate_error is None else rate_error
    orbit = loop.plant.orbit
    B = min(float(np.linalg.norm(loop.plant.field.at(t))) for t in np.linspace(0.0, time, 50))
    given = np.sort(available(loop.allocator, B * directions()))
    if torque is None:
        torque = float(np.median(given))
    n = 0.0
    if loop.controller.reference == "lvlh":
        r, v = orbit.position_velocity(0.0)
        n = so3.norm(np.cross(r, v)) / float(r @ r)
    wish = Wish(loop.controller.J_B, attitude_error, rate_error, time, orbital_rate=n, torque=torque)
    try:
        sized = size(wish, damping)
    except ValueError as error:
        raise InputError(str(error)) from None
    quicker = None if sized.torque_max <= torque else fastest(wish)
    return Study(sized, given, B, quicker, schedule)


GUARANTEED, RULE, FLOWN, GIVEN = "guaranteed", "rule of thumb", "simulated", "given"


def table(found: Study, flown: Flown) -> Iterator[tuple[str, str, str, str]]:
    """Rows: what, its value, its formula with the paper's number in brackets, and its standing.

    With the schedule [10] nothing of a motion is guaranteed, since V may rise.
    """
    s = found.sizing
    w = s.wish
    held = GUARANTEED if found.schedule == "constant" else RULE
    settled = flown.converged
    late = np.isnan(settled)
    longest = f"{late.sum()} later than {2.0 * w.time:.0f} s" if late.any() else f"{settled.max():.0f} s"
    median = np.median(np.where(late, np.inf, settled))
    peak, deg = float(flown.largest_torque.max()), math.degrees

    def mN(torque: float) -> str:
        return f"{1e3 * torque:.3g} mN m"

    def margin(torque: float) -> str:
        return f"margin {mN(w.torque - torque)}"

    yield "largest errors at t = 0", f"{deg(w.attitude_error):.3g} deg, {deg(w.rate_error):.3g} deg/s", "", GIVEN
    yield (
        "torque of the actuators",
        mN(w.torque),
        "all of its axes; in half of the field's directions if not given",
        RULE,
    )
    yield "damping ratio", f"{s.damping:.2f}", "the least torque bound; first where every start converges", RULE
    yield "K", f"{s.K0[1]:.3g} N m", "k diag(1 - s, 1, 1 + s), k from the wished time [8][9]", RULE
    yield "L", f"{float(np.trace(s.L0)) / 3.0:.3g} N m s (mean)", "2 d J # (tr(K) I - K) [8][9]", RULE
    yield (
        "every start converges",
        "yes" if s.converges else "almost every",
        "V(0) < 2 (k1 + k2) [11]",
        held if s.converges else RULE,
    )
    yield "  V(0), half turn", f"{s.V0:.3g} J, {s.saddle:.3g} J", f"margin {s.saddle - s.V0:.2g} J", held
    yield "rate", f"{deg(s.rate_max):.3g} deg/s", "|omega| <= sqrt(2 V(0)/J_min) [11]", held
    yield (
        "torque at t = 0",
        mN(s.torque_start),
        f"|L||omega| + sqrt(U (2 (k2 + k3) - U)) [8]; {margin(s.torque_start)}",
        GUARANTEED,
    )
    yield "torque at any time", mN(s.torque_max), f"its maximum over V <= V(0) [8][11]; {margin(s.torque_max)}", held
    yield (
        "  directions of the field",
        f"{found.share(s.torque_max):.0%}",
        f"in which rods and wheel give it; field {1e6 * found.field:.3g} uT, wheel at rest [20][24]",
        RULE,
    )
    if found.fastest is not None:
        yield "  least time within the limit", f"{found.fastest.wish.time:.0f} s", "by the bound of torque", RULE
    yield "time to settle", f"{s.time:.0f} s", "ln(A/tolerance)/(d w), slowest axis, linearised [8]", RULE
    yield "decay near the reference", f"{s.decay:.3g} 1/s", "d w, linearised [8]", held
    left = s.compliance if found.schedule == "constant" else s.compliance / s.scale_at_rest
    yield "error left by 1e-6 N m", f"{deg(1e-6 * left):.2g} deg", "1/(k1 + k2), steady, small angles [8]", held
    of = f"{len(settled)} random starts, exact torque"
    yield "  time to settle, longest", longest, f"{of}; median {median:.0f} s", FLOWN
    yield "  torque, largest", mN(peak), f"{of}; {margin(peak)}", FLOWN
