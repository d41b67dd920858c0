"""Sobol' indices, Morris' effects and rank correlation, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from orchestration.campaign.file.analysis import Sensitivity
from orchestration.campaign.statistics.sensitivity import ranks, run
from orchestration.errors import InputError

from ..analytic import ISHIGAMI, Analytic, ishigami, separate


def test_sobol_indices_of_ishigamis_function_are_those_of_its_variance():
    found = run(Sensitivity(points=2048), Analytic(ishigami, separate(3)), 1)
    assert found["runs"] == 2048 * 5
    indices = found["metrics"]["y"]
    for kind, exact in ISHIGAMI.items():
        assert indices[kind] == pytest.approx(exact, abs=0.04)
        assert (np.abs(np.subtract(indices[kind], exact)) <= np.array(indices[f"{kind}_error"]) + 1e-3).all()


def test_coordinates_of_an_entry_move_together():
    product = Analytic(
        lambda u: (u[:, 0] - 0.5) * (u[:, 1] - 0.5) + 0.1 * u[:, 2], [("turn", 0, 2), ("k", 2, 1), ("n", 3, 0)]
    )
    found = run(Sensitivity(points=1024), product, 1)
    assert found["entries"] == ["turn", "k"]
    assert found["runs"] == 1024 * 4
    # Variances 1/144 and 1/1200: by itself neither coordinate of the turn would have a first-order index.
    assert found["metrics"]["y"]["first"] == pytest.approx([0.893, 0.107], abs=0.05)


def test_the_coordinates_of_an_only_entry_are_compared_and_a_single_one_is_refused():
    assert run(Sensitivity(points=64), Analytic(lambda u: u[:, 0], [("turn", 0, 2)]), 1)["entries"] == [
        "turn (1)",
        "turn (2)",
    ]
    with pytest.raises(InputError, match="expected two varied entries at least"):
        run(Sensitivity(points=64), Analytic(lambda u: u[:, 0], [("k", 0, 1)]), 1)


def test_morris_effects_of_a_linear_function_are_its_slopes():
    found = run(Sensitivity(method="morris", points=10), Analytic(lambda u: u @ [3.0, -1.0, 0.0], separate(3)), 1)
    assert found["runs"] == 40
    assert found["metrics"]["y"]["effect"] == pytest.approx([3.0, 1.0, 0.0], abs=1e-9)
    assert found["metrics"]["y"]["spread"] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)


def test_morris_keeps_clear_of_tails_without_end():
    runs = Analytic(lambda u: u[:, 0], separate(2), bounded=False)
    run(Sensitivity(method="morris", points=10), runs, 1)
    assert np.concatenate(runs.asked).min() == pytest.approx(0.00135)
    assert np.concatenate(runs.asked).max() == pytest.approx(1.0 - 0.00135)


@pytest.mark.parametrize("method", ["sobol", "morris"])
def test_base_points_with_a_failed_run_are_left_out(method):
    runs = Analytic(lambda u: u[:, 0] + u[:, 1], separate(3), fails=lambda u: np.all(u > 0.9, axis=1))
    found = run(Sensitivity(method=method, points=256), runs, 1)
    indices = found["metrics"]["y"]
    lost = 256 - indices["used"]
    assert 0 < lost < 25.6
    what = "base points" if method == "sobol" else "trajectories"
    assert indices["note"] == f"{lost} of 256 {what} are left out: they have a run without a value"
    assert found["failed"] == found["reasons"]["it broke"] > 0
    key, right = ("total", [0.5, 0.5, 0.0]) if method == "sobol" else ("effect", [1.0, 1.0, 0.0])
    assert indices[key] == pytest.approx(right, abs=0.15)


def test_where_a_tenth_is_lost_the_indices_are_those_of_the_loss():
    many = run(Sensitivity(points=256), Analytic(ishigami, separate(3), fails=lambda u: u[:, 2] > 0.8), 1)["metrics"][
        "y"
    ]
    assert many["of"] == "loss"
    assert many["note"].endswith("base points have a run without a value: these are indices of that")
    assert many["total"] == pytest.approx([0.0, 0.0, 1.0], abs=0.1)


def test_no_indices_are_given_where_nothing_varies():
    still = run(Sensitivity(points=64), Analytic(lambda u: np.full(len(u), 7.0), separate(2)), 1)["metrics"]["y"]
    assert still == {"used": 64, "of": "nothing", "note": "it is the same in all runs"}


def test_rank_correlation_is_that_of_a_normal_pair_and_the_partial_one_sees_through_a_third():
    rng = np.random.default_rng(1)
    cause, noise = rng.normal(size=(2, 4000))
    follower = 0.8 * cause + 0.6 * noise  # moves with the cause, does nothing itself
    metric = np.exp(cause + 0.5 * rng.normal(size=4000))
    metric[:3] = np.inf, np.nan, -5.0
    first, second, constant = ranks([cause, follower, np.ones(4000)], metric)
    pearson = 1 / np.sqrt(1.25)
    spearman = 6 / np.pi * np.arcsin(pearson / 2)  # of a normal pair
    assert first["low"] < spearman < first["high"]
    assert first["rho"] == pytest.approx(spearman, abs=0.02)
    assert second["rho"] > 0.6
    assert abs(second["partial"]) < 0.05
    assert first["partial"] > 0.7
    assert constant is None


def test_the_bounds_of_a_rank_correlation_hold_it_as_often_as_they_say():
    """Spearman's of a normal pair is 6/pi asin(r/2); 95% of 2000 draws lie within 2.5 of their deviations, 1.2%."""
    rng = np.random.default_rng(5)
    spearman, held = 6 / np.pi * np.arcsin(0.6 / 2), 0
    for _ in range(2000):
        cause, noise = rng.normal(size=(2, 40))
        (found,) = ranks([cause], 0.6 * cause + 0.8 * noise)
        held += found["low"] < spearman < found["high"]
    assert held / 2000 == pytest.approx(0.95, abs=0.015)


def test_rank_correlation_of_few_runs_or_of_a_constant_metric_is_none():
    assert ranks([np.arange(4.0)], np.arange(4.0)) == [None]
    assert ranks([np.arange(5.0)], np.arange(5.0))[0]["rho"] == pytest.approx(1.0)
    assert ranks([np.arange(9.0)], np.ones(9)) == [None]
    assert ranks([np.arange(9.0)], np.arange(9.0))[0]["rho"] == pytest.approx(1.0)


def test_wrong_sections_are_refused_with_the_remedy():
    with pytest.raises(ValidationError, match="expected a power of two, such as 64 or 128; found 100"):
        Sensitivity(points=100)
    assert Sensitivity(points=64).runs(3) == 320
    assert Sensitivity(method="morris", points=10).runs(3) == 40
