"""The box QP of a stage against SciPy and the conditions of optimality."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from . import core


def problems(rng, n, spread):
    """H = A^T A + d I with condition numbers up to 10^(2 spread), boxes of which some have no width, any start."""
    A = rng.normal(size=(n, 4, 4)) * 10.0 ** rng.uniform(-spread, 0.0, size=(n, 1, 4))
    H = A.transpose(0, 2, 1) @ A + 1e-3 * 10.0**-spread * np.eye(4)
    g = rng.normal(size=(n, 4)) * 10.0 ** rng.uniform(-2.0, 1.0, size=(n, 1))
    low = -rng.uniform(0.0, 2.0, size=(n, 4))
    high = rng.uniform(0.0, 2.0, size=(n, 4))
    low[rng.random((n, 4)) < 0.1] = 0.0
    high[rng.random((n, 4)) < 0.1] = 0.0
    return H, g, low, high, rng.uniform(-3.0, 3.0, size=(n, 4))


def value(H, g, u):
    return 0.5 * np.einsum("ni,nij,nj->n", u, H, u) + np.einsum("ni,ni->n", g, u)


@pytest.mark.parametrize("spread", [0.0, 1.0, 3.0])
def test_solutions_meet_the_conditions_of_optimality(spread, rng):
    H, g, low, high, start = problems(rng, 4000, spread)
    u, free = core.box_qp(H, g, low, high, start, passes=60)
    assert (u >= low).all()
    assert (u <= high).all()
    slope = np.einsum("nij,nj->ni", H, u) + g
    scale = np.abs(g).max(axis=1, keepdims=True) + np.abs(H).max(axis=(1, 2))[:, None]
    inside = (u > low) & (u < high)
    wrong = np.where(inside, np.abs(slope), np.where(u <= low, -slope, slope)) / scale
    wrong[(low == high)] = 0.0
    assert wrong.max() < 1e-12
    assert (free | ~inside).all()  # what is inside the box is free
    pushed = (np.abs(slope) > 1e-6 * scale) & (low < high)
    assert not (free & pushed).any()  # what its bound holds is not


@pytest.mark.parametrize("spread", [0.0, 2.0])
def test_solutions_are_scipys(spread, rng):
    H, g, low, high, start = problems(rng, 300, spread)
    high = np.maximum(high, low + 1e-6)  # SciPy wants boxes with a width
    u, _ = core.box_qp(H, g, low, high, start, passes=60)
    for i in range(len(H)):
        L = np.linalg.cholesky(H[i]).T
        theirs = lsq_linear(L, -np.linalg.solve(L.T, g[i]), (low[i], high[i]), method="bvls", tol=1e-14).x
        best = value(H[i : i + 1], g[i : i + 1], theirs[None])[0]
        assert value(H[i : i + 1], g[i : i + 1], u[i : i + 1])[0] <= best + 1e-9 * (1.0 + abs(best))


def test_a_few_passes_do(rng):
    """From zero, as the planner calls it: twelve passes are exact, six nearly always."""
    H, g, low, high, _ = problems(rng, 4000, 1.0)
    exact, six, twelve = (core.box_qp(H, g, low, high, np.zeros_like(g), passes=n)[0] for n in (60, 6, 12))
    for u, share in ((six, 0.99), (twelve, 0.999)):
        gap = (value(H, g, u) - value(H, g, exact)) / (1e-12 - value(H, g, exact))
        assert gap.min() > -1e-9
        assert (gap < 1e-9).mean() >= share


def test_more_passes_never_cost_more(rng):
    H, g, low, high, start = problems(rng, 2000, 3.0)
    costs = [value(H, g, core.box_qp(H, g, low, high, start, passes=k)[0]) for k in range(8)]
    moved = np.clip(start, low, high)
    assert costs[0] == pytest.approx(value(H, g, moved))
    for before, after in pairwise(costs):
        assert (after <= before + 1e-12 * np.abs(before)).all()
    assert (costs[-1] < costs[0]).mean() > 0.9
