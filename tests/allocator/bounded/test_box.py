"""Least squares in a box: the conditions of optimality, SciPy's two solvers, and boxes solved by hand."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from allocator.bounded.box import least_squares

RNG = np.random.default_rng(81)


def case():
    """Well or badly conditioned, the unbounded minimum inside the box or far outside."""
    A = RNG.normal(size=(7, 4)) * 10.0 ** RNG.uniform(-2, 2, 4)
    if RNG.random() < 0.3:
        A[:, 0] = A[:, 1] + 1e-2 * np.linalg.norm(A[:, 1]) * RNG.normal(size=7)
    y = A @ RNG.normal(size=4) * 10.0 ** RNG.uniform(-1, 2) + RNG.normal(size=7)
    low = -RNG.uniform(0.0, 1.0, 4) * (RNG.random(4) < 0.9)
    return A, y, low, low + RNG.uniform(0.01, 2.0, 4)


CASES = [case() for _ in range(3000)]


def test_the_minimum_meets_the_conditions_of_optimality():
    """Inside: no gradient. At a bound: none that leads back inside. Nowhere outside. That is all of it for a convex
    cost."""
    at_bounds = set()
    for A, y, low, high in CASES:
        x, _ = least_squares(A, y, low, high)
        assert ((low <= x) & (x <= high)).all()
        gradient = A.T @ (A @ x - y)
        size = 1e-9 * np.linalg.norm(A, axis=0) * np.linalg.norm(y)
        at_low, at_high = x == low, x == high
        assert (np.abs(gradient) <= size)[~at_low & ~at_high].all()
        assert (gradient >= -size)[at_low].all()
        assert (gradient <= size)[at_high].all()
        at_bounds.add((at_low.sum(), at_high.sum()))
    assert {(0, 0), (4, 0), (0, 4), (2, 2), (1, 0), (0, 3)} <= at_bounds


@pytest.mark.parametrize("method", ["bvls", "trf"])
@pytest.mark.thorough
def test_scipy_finds_nothing_better_and_the_same_point_where_it_is_as_good(method):
    """SciPy's solvers stop early now and then; a lower cost than ours would be an error of ours."""
    same = 0
    for A, y, low, high in CASES[:1000]:
        x, _ = least_squares(A, y, low, high)
        z = lsq_linear(A, y, (low, high), method=method, tol=1e-15).x
        ours, theirs = (np.sum((A @ v - y) ** 2) for v in (x, z))
        assert ours <= theirs * (1.0 + 1e-12)
        if theirs <= ours * (1.0 + 1e-14):
            np.testing.assert_allclose(x, z, rtol=0, atol=1e-5)
            same += 1
    assert same > 850


def test_without_bounds_in_the_way_it_is_numpys_least_squares():
    for A, y, _, _ in CASES[:200]:
        free = np.linalg.lstsq(A, y, rcond=None)[0]
        x, unbounded = least_squares(A, y, free - 1.0, free + 1.0)
        np.testing.assert_allclose(x, free, rtol=0, atol=1e-8 * np.linalg.norm(free))
        np.testing.assert_array_equal(x, unbounded)


def test_independent_unknowns_are_clipped_each_for_itself():
    y = np.array([3.0, -3.0, 0.2, -0.4])
    low, high = np.array([-1.0, -2.0, -1.0, -0.1]), np.array([0.5, 2.0, 1.0, 1.0])
    x, unbounded = least_squares(np.eye(4), y, low, high)
    np.testing.assert_array_equal(x, [0.5, -2.0, 0.2, -0.1])
    np.testing.assert_allclose(unbounded, y, rtol=1e-15)


def test_a_bound_moves_the_other_unknowns():
    # minimise (x + y - 3)^2 + (x - y)^2/100: free, x = y = 1.5;
    # with x <= 1, (1 + y - 3) + (y - 1)/100 = 0, y = 2.01/1.01.
    A, y = np.array([[1.0, 1.0], [0.1, -0.1]]), np.array([3.0, 0.0])
    x, unbounded = least_squares(A, y, np.array([-9.0, -9.0]), np.array([1.0, 9.0]))
    np.testing.assert_allclose(unbounded, [1.5, 1.5], rtol=1e-12)
    np.testing.assert_allclose(x, [1.0, 2.01 / 1.01], rtol=1e-12)


def test_a_minimum_on_the_very_bound_is_that_bound():
    A, x = np.array([[2.0, 1.0], [0.0, 1.0], [1.0, 0.0]]), np.array([1.0, -0.5])
    for high in (1.0, 1.0 + 1e-15, 1.0 - 1e-15):
        found, _ = least_squares(A, A @ x, np.array([-1.0, -1.0]), np.array([high, 1.0]))
        np.testing.assert_allclose(found, x, rtol=0, atol=1e-14)


def test_rounding_takes_no_minimum_out_of_the_box(rng):
    """Minima that lie on bounds, as nearly as floating point tells."""
    for _ in range(1000):
        A, low = rng.normal(size=(5, 3)), -rng.uniform(0.1, 2.0, 3)
        high = low + rng.uniform(0.1, 3.0, 3)
        minimum = np.choose(rng.integers(0, 3, 3), (low, high, 0.5 * (low + high)))
        x, _ = least_squares(A, A @ minimum, low, high)
        assert ((low <= x) & (x <= high)).all()
        np.testing.assert_allclose(x, minimum, rtol=0, atol=1e-9)
