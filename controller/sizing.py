"""Gain sizing (section III.B of the paper): K0, L0 and the gain schedule [10] from what a mission wishes.

The paper asks for gains whose largest torque lies well inside the limits of the actuators, and gives no procedure.
This one is ours; docs/use/sizing.md derives it. With constant gains, Phi(x) = x and exact torque:

- guaranteed: V = 1/2 omega.J omega + U, U = tr(K - K Q), never rises [11], so that every state of the motion has
  1/2 omega.J omega + U <= V0, the largest V of the starts. From it follow the bounds of rate and torque here;
- a rule of thumb: the time to settle, from the damped oscillation of the loop linearised at Q = I.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .gains import attitude_scale, rate_scale
from .so3 import Array

DAMPINGS = np.arange(0.20, 0.91, 0.04)
"""Damping ratios among which `size` chooses."""
A1, A2, C1, C2 = 3.5, 35.0, 2.1, 21.0
"""The paper's constants of [10], rad and rad/s."""


@dataclass(frozen=True)
class Wish:
    """The requirement: every start with errors up to these settles within the wished time."""

    J_B: Array
    """(3,3) kg m2."""
    attitude_error: float
    """Largest |zeta(0)|, rad, at most pi."""
    rate_error: float
    """Largest |omega(0)|, rad/s."""
    time: float
    """Wished time to settle, s."""
    attitude_tolerance: float = math.radians(2.0)
    """Settled: |zeta|, rad, below this"""
    rate_tolerance: float = 1e-3
    """and |omega|, rad/s, below this, from then on."""
    spread: float = 0.1
    """K0 = k diag(1 - spread, 1, 1 + spread); the paper asks for distinct entries and gives none."""
    orbital_rate: float = 0.0
    """Rate of the LVLH reference, rad/s; 0 for a slew to an inertial attitude."""
    torque: float = math.inf
    """Torque that the actuators give, N m."""

    def check(self) -> None:
        """Raises ValueError for what no gains can be sized for."""
        J = self.J_B
        if J.shape != (3, 3) or not np.isfinite(J).all() or np.abs(J - J.T).max() > 1e-9 * np.abs(J).max():
            raise ValueError(f"J_B: expected a symmetric 3 by 3 matrix, found {J.tolist()}")
        if not (least := float(np.linalg.eigvalsh(J)[0])) > 0.0:
            raise ValueError(f"J_B: expected a positive definite matrix, found its least eigenvalue {least:g}")
        for name in ("time", "attitude_tolerance", "rate_tolerance", "torque"):
            value = getattr(self, name)
            if not value > 0.0 or (value == math.inf and name != "torque"):
                raise ValueError(f"{name}: expected a finite number above 0, found {value!r}")
        for name, most in (("attitude_error", math.pi), ("rate_error", math.inf), ("orbital_rate", math.inf)):
            if not 0.0 <= (value := getattr(self, name)) <= most or value == math.inf:
                raise ValueError(f"{name}: expected a number from 0 to {most:g}, found {value!r}")
        if not 0.0 < self.spread < 1.0:
            raise ValueError(f"spread: expected a number between 0 and 1, found {self.spread!r}")
        if self.attitude_error <= self.attitude_tolerance and self.rate_error <= self.rate_tolerance:
            raise ValueError(
                f"attitude_error, rate_error: {self.attitude_error:g} rad and {self.rate_error:g} rad/s are within the "
                "tolerances from the start; expected one of them above its tolerance"
            )


@dataclass(frozen=True)
class Sizing:
    """Gains and what they promise for every start of a wish."""

    wish: Wish
    damping: float
    """Damping ratio of the linearised loop, the same about its three axes."""
    K0: Array
    """(3,) N m, at kappa0 = 1."""
    L0: Array
    """(3,3) N m s, at lambda0 = 1: L = 2 damping J^1/2 (J^-1/2 P J^-1/2)^1/2 J^1/2, P = tr(K) I - K."""
    frequencies: Array
    """(3,) rad/s, undamped, of the linearised loop J zeta'' + L zeta' + P zeta = 0."""
    time: float
    """Rule of thumb: the linearised loop's envelope is within the tolerances from here on, s."""
    V0: float
    """Guaranteed: the largest V of the starts, J."""
    saddle: float
    """Guaranteed: U of the lowest half turn, 2 (k1 + k2), J. Where V0 is below it, every start converges."""
    rate_max: float
    """Guaranteed: |omega| never above sqrt(2 V0/J_min), rad/s."""
    torque_start: float
    """Guaranteed: |tau(0)| of the starts at most this, N m."""
    torque_max: float
    """Guaranteed: |tau(t)| never above this, N m."""
    feedforward: float
    """The largest part of both torques that the reference and gravity have in them, N m."""

    @property
    def converges(self) -> bool:
        """Guaranteed: whether every start converges; where False, almost every one does."""
        return self.saddle > self.V0

    @property
    def decay(self) -> float:
        """Slowest decay rate of the linearised loop, 1/s: exact near Q = I."""
        return self.damping * float(self.frequencies[0])

    @property
    def compliance(self) -> float:
        """Largest steady attitude error per unknown steady moment, rad/(N m): 1/(k1 + k2), for small angles."""
        return 1.0 / float(self.K0[0] + self.K0[1])

    @property
    def scale_at_rest(self) -> float:
        """k of `schedule` at Q = I after a start at the wish's largest attitude error."""
        return A1 / (A1 + self.wish.attitude_error)

    def schedule(self) -> dict[str, Any]:
        """The paper's schedule [10] with k = l = 1 at the wish's largest errors, and its a1, a2, c1 and c2.

        A rule of thumb: V may rise, so that none of the bounds is guaranteed.
        """
        w = self.wish
        return {
            "gain_schedule": "error",
            "kappa0": 1.0 / attitude_scale(1.0, A1, A2, w.attitude_error, w.attitude_error),
            "lambda0": 1.0 / rate_scale(1.0, C1, C2, w.rate_error, w.rate_error),
            "a1": A1,
            "a2": A2,
            "c1": C1,
            "c2": C2,
        }


def attitude_torque(K: Array, U: float) -> float:
    """Largest |sum k_i e_i x Q^T e_i| over all Q with tr(K - K Q) = U: sqrt(U (2 (k2 + k3) - U)), N m.

    Reached by turns about e1 up to U = 2 (k2 + k3). K (3,) N m in rising order, U in J.
    """
    return math.sqrt(max(U * (2.0 * float(K[1] + K[2]) - U), 0.0))


def largest_torque(J: Array, K: Array, L: Array, V0: float) -> float:
    """Largest |L omega| + |sum k_i e_i x Q^T e_i| over all states with V <= V0, N m.

    It is the maximum over U of |L J^-1/2| sqrt(2 (V0 - U)) + sqrt(U (2 (k2 + k3) - U)), a concave function of U.
    J (3,3) kg m2, K (3,) N m in rising order, L (3,3) N m s, V0 in J.
    """
    p1 = float(K[1] + K[2])
    damping = float(np.linalg.norm(L @ np.linalg.inv(_root(J)), 2))
    low, high = 0.0, min(V0, p1)
    for _ in range(100):
        U = 0.5 * (low + high)
        if not low < U < high:
            break
        slope = (p1 - U) / math.sqrt(U * (2.0 * p1 - U)) - damping / math.sqrt(2.0 * (V0 - U))
        low, high = (U, high) if slope > 0.0 else (low, U)
    return damping * math.sqrt(2.0 * (V0 - low)) + attitude_torque(K, low)


def size(wish: Wish, damping: float | None = None) -> Sizing:
    """The gains of a wish, by default with the damping ratio of the least guaranteed torque.

    The least among the ratios under which every start converges; where there are none, among those under which the
    rate alone cannot carry the body over a half turn; else among all. A group whose least torque is above the wish's
    is left for the next, unless none is within it. Raises ValueError for a wish that is none.
    """
    wish.check()
    if damping is not None:
        if not 0.0 < damping < 1.0:
            raise ValueError(f"damping: expected a number between 0 and 1, found {damping!r}")
        return _sized(wish, damping)
    every = [_sized(wish, float(ratio)) for ratio in DAMPINGS]
    spin = 0.5 * float(np.linalg.eigvalsh(wish.J_B)[-1]) * wish.rate_error**2
    groups = [[s for s in every if s.converges], [s for s in every if spin < s.saddle], every]
    best = [min(group, key=lambda s: s.torque_max) for group in groups if group]
    return next((s for s in best if s.torque_max <= wish.torque), best[0])


def fastest(wish: Wish) -> Sizing | None:
    """The sizing of least time within the wish's torque, to 1%; None beyond 100 times its time."""
    if not size(slow := replace(wish, time=100.0 * wish.time)).torque_max <= wish.torque:
        return None
    low, high = 0.01 * wish.time, slow.time
    while high > 1.01 * low:
        middle = math.sqrt(low * high)
        fits = size(replace(wish, time=middle)).torque_max <= wish.torque
        low, high = (low, middle) if fits else (middle, high)
    return size(replace(wish, time=high))


def _sized(wish: Wish, damping: float) -> Sizing:
    J = wish.J_B
    root = _root(J)
    inverse = np.linalg.inv(root)
    unit = np.array((1.0 - wish.spread, 1.0, 1.0 + wish.spread))
    squares, axes = np.linalg.eigh(inverse @ np.diag(unit.sum() - unit) @ inverse)
    low, high = -20.0, 20.0  # exponents of k relative to frequencies of 1/time
    base = 1.0 / (float(squares[0]) * wish.time**2)
    for _ in range(45):
        middle = 0.5 * (low + high)
        slow = _time(wish, damping, np.sqrt(base * math.exp(middle) * squares)) > wish.time
        low, high = (middle, high) if slow else (low, middle)
    k = base * math.exp(high)
    frequencies = np.sqrt(k * squares)
    K = k * unit
    L = 2.0 * damping * root @ axes @ np.diag(frequencies) @ axes.T @ root
    L = 0.5 * (L + L.T)
    moments = np.linalg.eigvalsh(J)
    p1 = float(K[1] + K[2])
    U0 = p1 * (1.0 - math.cos(wish.attitude_error))
    V0 = 0.5 * float(moments[2]) * wish.rate_error**2 + U0
    # |W x J W| <= n^2 (J3 - J1)/2 and |M_g| = |3 n^2 r x J r| <= 3 n^2 (J3 - J1)/2
    feedforward = 2.0 * wish.orbital_rate**2 * float(moments[2] - moments[0])
    start = float(np.linalg.norm(L, 2)) * wish.rate_error + attitude_torque(K, min(U0, p1))
    return Sizing(
        wish=wish,
        damping=damping,
        K0=K,
        L0=L,
        frequencies=frequencies,
        time=_time(wish, damping, frequencies),
        V0=V0,
        saddle=2.0 * float(K[0] + K[1]),
        rate_max=math.sqrt(2.0 * V0 / float(moments[0])),
        torque_start=start + feedforward,
        torque_max=largest_torque(J, K, L, V0) + feedforward,
        feedforward=feedforward,
    )


def _time(wish: Wish, damping: float, frequencies: Array) -> float:
    """Returns when the slowest envelope of the linearised loop is within both tolerances, s.

    The envelope of zeta about an axis is A exp(-damping w t)/sqrt(1 - damping^2), A^2 = |zeta(0)|^2 + (|omega(0)|/w)^2,
    that of omega w times as large.
    """
    A = np.hypot(wish.attitude_error, wish.rate_error / frequencies)
    excess = np.maximum(A / wish.attitude_tolerance, A * frequencies / wish.rate_tolerance)
    return float((np.log(np.maximum(excess, 1.0) / math.sqrt(1.0 - damping**2)) / (damping * frequencies)).max())


def _root(J: Array) -> Array:
    """J^1/2 (3,3), symmetric."""
    moments, axes = np.linalg.eigh(J)
    return np.asarray(axes @ np.diag(np.sqrt(moments)) @ axes.T)
