"""Distributions as functions of the unit cube, against SciPy's and closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation as ScipyRotation
from scipy.stats import qmc

from orchestration.campaign.drawing import samplers
from orchestration.campaign.drawing.entries import sampler
from orchestration.campaign.file.distributions import Varied
from orchestration.quantities import QuantityError

U = [1e-9, 0.1, 0.5, 0.734, 1.0 - 1e-9]
POINTS = qmc.Sobol(3, rng=np.random.default_rng(1)).random_base2(12)


def made(**entry):
    return sampler(Varied.model_validate(entry))[0]


@pytest.mark.parametrize(
    ("entry", "distribution"),
    [
        ({"uniform": [-2, 3]}, stats.uniform(-2, 5)),
        ({"normal": {"mean": 1, "deviation": 0.5}}, stats.norm(1, 0.5)),
        ({"normal": {"mean": 1, "deviation": 0.5, "low": 0.2, "high": 1.1}}, stats.truncnorm(-1.6, 0.2, 1, 0.5)),
        ({"normal": {"mean": 0, "deviation": 1, "low": 6}}, stats.truncnorm(6, np.inf)),
        ({"normal": {"mean": 0, "deviation": 1, "high": -6}}, stats.truncnorm(-np.inf, -6)),
        ({"lognormal": {"median": 2, "sigma": 0.3}}, stats.lognorm(0.3, scale=2)),
    ],
)
def test_a_value_has_the_quantile_that_it_is_drawn_at(entry, distribution):
    one = made(**entry)
    for u in U:
        assert one.value([u]) == pytest.approx(distribution.ppf(u), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(("low", "high"), [(50.0, 51.0), (37.0, 38.5), (40.0, math.inf), (2000.0, 2001.0)])
def test_far_in_either_tail_a_truncated_normal_value_is_scipys_and_both_tails_are_mirrored(low, high):
    upper = made(normal={"mean": 0, "deviation": 1, "low": low, **({"high": high} if high < math.inf else {})})
    lower = made(normal={"mean": 0, "deviation": 1, "high": -low, **({"low": -high} if high < math.inf else {})})
    for u in U:
        distance = stats.truncnorm.ppf(u, low, high) - low
        assert upper.value([u]) - low == pytest.approx(distance, rel=1e-4, abs=1e-9)
        assert lower.value([1.0 - u]) + low == pytest.approx(-distance, rel=1e-4, abs=1e-9)


def test_a_truncated_normal_value_has_a_tail_where_probabilities_have_no_number_left():
    # Far out the distance to the end is exponential, with the mean deviation^2 / end.
    one = made(normal={"mean": 0, "deviation": 1, "low": 1e4})
    assert [(one.value([u]) - 1e4) * 1e4 for u in (0.25, 0.5, 0.9)] == pytest.approx(
        -np.log1p([-0.25, -0.5, -0.9]), rel=1e-3
    )
    assert made(normal={"mean": 0, "deviation": 1, "low": 1e200}).value([0.5]) == 1e200


@pytest.mark.parametrize(
    ("normal", "unit", "mean", "deviation"),
    [
        ({"mean": "293.15 K", "deviation": "2 degC"}, "K", 293.15, 2.0),
        ({"mean": "20 degC", "deviation": "2 K"}, "degC", 20.0, 2.0),
        ({"mean": ["20 degC", "300 K"], "deviation": ["9 K", "1 degC"]}, "degC", [20.0, 26.85], [9.0, 1.0]),
        ({"mean": "20 degC", "deviation": "1 K", "low": "292 K", "high": "295 K"}, "degC", 20.0, 1.0),
        ({"mean": "1 m", "deviation": "5 cm"}, "m", 1.0, 0.05),
    ],
)
def test_a_deviation_is_a_difference_which_the_offset_of_a_unit_does_not_change(normal, unit, mean, deviation):
    one, found = sampler(Varied.model_validate({"normal": normal}))
    assert isinstance(one, samplers.Normal)
    assert str(found) == unit
    np.testing.assert_allclose(one.mean, mean)
    np.testing.assert_allclose(one.deviation, deviation)
    if "low" in normal:
        np.testing.assert_allclose([one.low, one.high], [18.85, 21.85])


@pytest.mark.parametrize("length", ["2 degC", {"uniform": ["1 degC", "2 degC"]}])
def test_the_length_of_a_vector_has_no_unit_with_an_offset(length):
    with pytest.raises(QuantityError, match="sphere: expected a unit without an offset, found degC"):
        made(sphere=length)


def test_a_normal_value_at_zero_is_finite():
    assert math.isfinite(made(normal={"mean": 0, "deviation": 1}).value([0.0]))


def test_correlated_values_have_their_covariance():
    covariance = [[4.0, 1.0, 0.0], [1.0, 2.0, -0.5], [0.0, -0.5, 1.0]]
    one = made(normal={"mean": [1.0, 2.0, 3.0], "covariance": covariance})
    values = np.array([one.value(point) for point in POINTS])
    assert values.mean(axis=0) == pytest.approx([1.0, 2.0, 3.0], abs=0.01)
    assert np.cov(values.T) == pytest.approx(np.array(covariance), abs=0.05)


def test_a_singular_covariance_keeps_the_sum_that_it_fixes():
    one = made(normal={"mean": [0.0, 0.0], "covariance": [[1.0, -1.0], [-1.0, 1.0]]})
    for point in POINTS[:20]:
        assert sum(one.value(point[:2])) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("covariance", [[[1.0, 2.0], [2.0, 1.0]], [[1.0, 0.5], [0.4, 1.0]], [[1.0]]])
def test_what_is_no_covariance_is_refused(covariance):
    with pytest.raises(QuantityError, match="covariance"):
        made(normal={"mean": [0.0, 0.0], "covariance": covariance})


@pytest.mark.parametrize("size", [1e-4, 1.0, 1e4])
def test_an_eigenvalue_below_zero_is_rounding_beside_the_largest_only(size):
    root = samplers.root_of(size * np.diag([1.0, -1e-13]))
    assert root @ root.T == pytest.approx(size * np.diag([1.0, 0.0]), abs=1e-12 * size)
    with pytest.raises(ValueError, match="negative eigenvalue"):
        samplers.root_of(size * np.diag([1.0, -1e-11]))


@pytest.mark.parametrize(
    ("entry", "finite"),
    [
        ({"uniform": [1.0, 2.0]}, True),
        ({"normal": {"mean": 0.0, "deviation": 1.0}}, False),
        ({"normal": {"mean": [0.0, 0.0], "covariance": [[1.0, 0.0], [0.0, 1.0]]}}, False),
        ({"lognormal": {"median": 1.0, "sigma": 0.5}}, False),
        ({"choice": [1, 2]}, True),
    ],
)
def test_a_distribution_without_end_says_so(entry, finite):
    one = made(**entry)
    assert set(one.bounded) == {finite}
    near, nearer = (np.abs(one.value([1.0 - 10.0**-digits] * one.count)).max() for digits in (6, 12))
    assert (nearer < 1.001 * near) == finite


def test_rotations_are_uniform_over_all_attitudes():
    q = np.array([samplers.Rotation().value(point) for point in POINTS])
    assert np.linalg.norm(q, axis=1) == pytest.approx(np.ones(len(q)), abs=1e-12)
    assert (q[:, 0] >= 0.0).all()
    # The angle of a uniform rotation has the distribution (x - sin x)/pi, whatever the attitude from which it is
    # counted.
    away = ScipyRotation.from_rotvec([0.3, -2.0, 0.7])
    for turned in (ScipyRotation.from_quat(q, scalar_first=True), ScipyRotation.from_quat(q, scalar_first=True) * away):
        angles = turned.magnitude()
        assert stats.kstest(angles, lambda x: (x - np.sin(x)) / np.pi).statistic < 0.02


def test_directions_are_uniform_over_the_sphere():
    vectors = np.array([samplers.Sphere(2.0).value(point[:2]) for point in POINTS])
    assert np.linalg.norm(vectors, axis=1) == pytest.approx(2.0 * np.ones(len(vectors)))
    assert vectors.T @ vectors / len(vectors) == pytest.approx(np.eye(3) * 4.0 / 3.0, abs=0.01)
    for axis in ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.0, 0.8]):  # Archimedes: each projection is uniform
        assert stats.kstest(vectors @ axis, stats.uniform(-2, 4).cdf).statistic < 0.02


def test_a_length_that_varies_takes_a_third_coordinate():
    one = made(sphere={"uniform": ["1 deg/s", "3 deg/s"]})
    assert one.count == 3
    assert np.linalg.norm(one.value([0.2, 0.7, 0.25])) == pytest.approx(1.5)


def test_choices_come_as_often_as_their_weights_say():
    one = made(choice=["a", "b", "c"], weights=[1, 0, 3])
    values = [one.value([u]) for u in np.linspace(0.0, 1.0, 1000, endpoint=False)]
    assert [values.count(name) for name in "abc"] == [250, 0, 750]


def test_whole_numbers_reach_both_ends_alike():
    values = [made(integers=[-1, 2]).value([u]) for u in np.linspace(0.0, 1.0, 1000, endpoint=False)]
    assert [values.count(i) for i in (-1, 0, 1, 2)] == [250] * 4


def test_the_ends_may_have_units_of_one_kind():
    entry = Varied.model_validate({"uniform": ["0 deg", "3.141592653589793 rad"]})
    one, unit = sampler(entry)
    assert (one.value([0.5]), str(unit)) == (pytest.approx(90.0), "deg")
    with pytest.raises(QuantityError, match="does not fit"):
        made(uniform=["0 deg", "1 m"])
    with pytest.raises(QuantityError, match="a unit at each number"):
        made(uniform=["1 deg", 2])


def test_a_grid_has_so_many_points_and_both_ends_among_them():
    one = made(grid={"from": 1, "to": 4, "points": 4})
    assert [one.value([u]) for u in (0.1, 0.3, 0.6, 0.9)] == [1.0, 2.0, 3.0, 4.0]


@pytest.mark.parametrize(("length", "found"), [(0, [0.0, 0.0, 0.0]), ("0 m", [0.0, 0.0, 0.0])])
def test_a_vector_may_have_no_length(length, found):
    assert made(sphere=length).value([0.3, 0.6]) == found
