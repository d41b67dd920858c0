"""Courses of a tumble's motion: the flown one, others that the optimiser starts from, and those that it ends with.
Tests: tests/evidence/optimum/test_least_time.py."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from ..motion import SECONDS
from ..paper import Array
from .problem import HELD, HOLD, ONE_WHEEL, Grid
from .transcription import Guess, Solution


@dataclass(frozen=True)
class Course:
    """A motion over [0, T + HOLD]; times (k,), s, the first 0."""

    times: Array
    attitudes: Rotation
    """k of them, relative to LVLH."""
    Omega: Array
    """(k, 3), rad/s."""
    l_w: Array
    """(k, n), N m s, of n wheels."""
    u: Array
    """(k, 3 + n): from each time on, as shares of the limits."""

    @property
    def end(self) -> float:
        """T, s."""
        return float(self.times[-1]) - HOLD

    def guess(self, grid: Grid = ONE_WHEEL) -> Guess:
        """At the optimiser's nodes."""
        N = max(grid.fewest, math.ceil(self.end / grid.longest))
        t = np.concatenate((self.end / N * np.arange(N), self.end + HOLD / HELD * np.arange(HELD + 1)))
        t[-1] = self.times[-1]
        q = Slerp(self.times, self.attitudes)(t).as_quat()[:, [3, 0, 1, 2]]
        signs = np.where((q[1:] * q[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
        q[1:] *= np.cumprod(signs)[:, None]
        rates = [np.interp(t, self.times, column) for column in (*self.Omega.T, *self.l_w.T)]
        x = np.column_stack((q, SECONDS * np.transpose(rates)))
        at = np.searchsorted(self.times, t[:-1] + 1e-6, side="right") - 1
        return Guess(self.end / SECONDS, x.T, np.clip(self.u[at], -0.98, 0.98).T, HELD)

    def turned(self, axis: Array, turn: Array) -> Course:
        """The same with one full turn more about a body axis (3,) until T; turn: Omega_d (3,), rad/s."""
        s = np.clip(self.times / max(self.end, 1.0), 0.0, 1.0)
        return self._along(self.attitudes * Rotation.from_rotvec((2.0 * math.pi * _smooth(s))[:, None] * axis), turn)

    def straight(self, turn: Array, turns: int = 0) -> Course:
        """From its start about one axis to LVLH: the short way, or with 1 the other way round; turn: Omega_d (3,),
        rad/s."""
        rotation = self.attitudes[0].as_rotvec()
        angle = float(np.linalg.norm(rotation)) + 1e-12
        s = np.clip(self.times / max(self.end, 1.0), 0.0, 1.0)
        way = (angle - 2.0 * math.pi * turns) * (1.0 - _smooth(s))
        return self._along(Rotation.from_rotvec(way[:, None] * (rotation / angle)), turn)

    def _along(self, attitudes: Rotation, turn: Array) -> Course:
        """Other attitudes with the rates that belong to them; the first rate stays."""
        steps = np.diff(self.times)[:, None]
        between = (attitudes[:-1].inv() * attitudes[1:]).as_rotvec() / steps + attitudes[:-1].inv().apply(turn)
        Omega = np.concatenate((self.Omega[:1], 0.5 * (between[1:] + between[:-1]), between[-1:]))
        return Course(self.times, attitudes, Omega, self.l_w, 0.5 * self.u)

    def within(self, longest: float) -> Course:
        """The same motion in less time, where T is longer than so many s; the first rate stays."""
        faster = self.end / longest
        if faster <= 1.0:
            return self
        times = np.where(self.times < self.end, self.times / faster, self.times - self.end + longest)
        share = np.where(self.times < self.end, faster, 1.0)[:, None]
        Omega = np.concatenate((self.Omega[:1], (share * self.Omega)[1:]))
        return Course(times, self.attitudes, Omega, self.l_w, self.u)

    def then(self, begin: float, rest: Course) -> Course:
        """The same until one of its times, s, and then another course."""
        first = int(np.searchsorted(self.times, begin))
        return Course(
            np.concatenate((self.times[:first], self.times[first] + rest.times)),
            Rotation.concatenate([self.attitudes[:first], rest.attitudes]),
            np.concatenate((self.Omega[:first], rest.Omega)),
            np.concatenate((self.l_w[:first], rest.l_w)),
            np.concatenate((self.u[:first], rest.u)),
        )

    def late(self, begin: float) -> Course:
        """Returns what is left of it from one of its times, s."""
        first = int(np.searchsorted(self.times, begin))
        t, rest = self.times[first:] - self.times[first], slice(first, None)
        return Course(t, self.attitudes[rest], self.Omega[rest], self.l_w[rest], self.u[rest])


def of(solution: Solution) -> Course:
    """The course of a solution."""
    T, M = SECONDS * solution.time, solution.held
    N = solution.u.shape[1] - M
    times = np.concatenate((T / N * np.arange(N), T + HOLD / M * np.arange(M + 1)))
    q, u = solution.x[:4].T, solution.u.T
    return Course(
        times,
        Rotation.from_quat(q[:, [1, 2, 3, 0]]),
        solution.x[4:7].T / SECONDS,
        solution.x[7:].T / SECONDS,
        np.concatenate((u, u[-1:])),
    )


def _smooth(s: Array) -> Array:
    """From 0 to 1 with no rate at the ends."""
    return np.asarray(s * s * (3.0 - 2.0 * s))
