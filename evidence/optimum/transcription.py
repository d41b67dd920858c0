"""Least time by multiple shooting: the commands are constant in each interval, and IPOPT closes the gaps between
intervals.

Of x' = f(x, u, t) from x(0) the least T is sought for which x is within a set at T and stays in it for a given while:
the set must be one where the motion can be held, not one that is passed through. So [0, T] is divided into N equal
intervals and the while after it into M. The variables are x at all nodes, u in all intervals, and T.
Tests: tests/evidence/optimum/test_least_time.py.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from ..motion import IPOPT
from ..paper import Array

EFFORT = 1e-3
"""Weight of the mean square of u beside T: where the least time leaves a command open, the smallest is taken."""
FEASIBLE = 1e-5
"""Largest gap, and largest excess over a limit."""


@dataclass(frozen=True)
class Task:
    """The problem of least time. All numbers are of the order of one."""

    step: ca.Function
    """x (n,), u (m,) within [-1, 1], time t and length h to x at t + h."""
    within: ca.Function
    """x to numbers that are at most one in the set."""
    rest: ca.Function
    """x to numbers that are at most one at the very end, so that the motion can be held for longer than the while."""
    limit: Array
    """(n,): |x| stays within."""
    hold: float
    """The while."""
    longest: float
    """Of T."""


@dataclass(frozen=True)
class Guess:
    """T, x (n, N + M + 1) at the nodes and u (m, N + M) in the intervals; M of the intervals are in the while."""

    time: float
    x: Array
    u: Array
    held: int


@dataclass(frozen=True)
class Solution(Guess):
    """Result of IPOPT; whether or not it is a minimum, a feasible one is a motion that takes T."""

    violation: float
    """Largest gap between intervals, or excess over a limit."""

    @property
    def feasible(self) -> bool:
        return self.violation < FEASIBLE


def solve(task: Task, guess: Guess) -> Solution:
    """A local minimum near the guess, from its first x."""
    nodes, (m, intervals), M = guess.x.shape[1], guess.u.shape, guess.held
    N = intervals - M
    X, U, T = ca.MX.sym("X", len(guess.x), nodes), ca.MX.sym("U", m, intervals), ca.MX.sym("T")
    lengths = ca.horzcat(*[T / N] * N, *[task.hold / M] * M)
    times = ca.horzcat(*[T * (i / N) for i in range(N)], *[T + task.hold * (i / M) for i in range(M)])
    gaps = X[:, 1:] - task.step.map(intervals)(X[:, :-1], U, times, lengths)
    inside = ca.vertcat(ca.vec(task.within.map(M + 1)(X[:, N:])), task.rest(X[:, -1]))
    problem = {
        "x": ca.vertcat(ca.vec(X), ca.vec(U), T),
        "f": T + EFFORT * ca.sumsqr(U) / intervals,
        "g": ca.vertcat(ca.vec(gaps), inside),
    }
    limits = np.repeat(task.limit[:, None], nodes, axis=1)
    low, high = -limits, limits.copy()
    low[:, 0] = high[:, 0] = guess.x[:, 0]
    ones, free = np.ones(U.numel()), gaps.numel()
    found = ca.nlpsol("least_time", "ipopt", problem, IPOPT)
    end = found(
        x0=np.concatenate((guess.x.T.ravel(), guess.u.T.ravel(), [guess.time])),
        lbx=np.concatenate((low.T.ravel(), -ones, [1e-3])),
        ubx=np.concatenate((high.T.ravel(), ones, [task.longest])),
        lbg=np.concatenate((np.zeros(free), np.full(inside.numel(), -np.inf))),
        ubg=np.concatenate((np.zeros(free), np.ones(inside.numel()))),
    )
    v, n = np.asarray(end["x"]).ravel(), X.numel()
    x, u = v[:n].reshape(nodes, -1).T, v[n:-1].reshape(intervals, m).T
    g = np.asarray(end["g"]).ravel()
    return Solution(float(v[-1]), x, u, M, float(max(np.abs(g[:free]).max(), (g[free:] - 1.0).max())))
