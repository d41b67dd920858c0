"""The search for the worst case."""

from __future__ import annotations

import numpy as np
import pytest

from orchestration.campaign.file.analysis import Search
from orchestration.campaign.statistics import search

from ..analytic import Analytic, ackley, edge, peaks, separate


@pytest.mark.parametrize("function", [ackley, edge, peaks])
def test_it_finds_a_worse_case_than_as_many_random_runs(function):
    for seed in range(3):
        runs = Analytic(function, separate(6))
        found = search.run(Search(metric="y", runs=300), runs, seed)
        assert sum(map(len, runs.asked)) == found["runs"] == 300
        assert found["value"] > function(np.random.default_rng(seed).random((300, 6))).max()
        assert function(np.array([found["unit_point"]]))[0] == pytest.approx(found["value"])
        assert found["scenario"] == f"name: at {found['unit_point']}\n"


def test_the_smallest_value_may_be_the_worst():
    found = search.run(Search(metric="y", runs=200, worst="smallest"), Analytic(lambda u: -edge(u), separate(3)), 1)
    assert found["value"] < -1.45  # -1.5 at a corner


def test_it_is_the_same_again_and_another_with_another_seed():
    once, again, other = (search.run(Search(metric="y", runs=100), Analytic(ackley, separate(2)), s) for s in (4, 4, 5))
    assert once == again
    assert once["value"] != other["value"]


def test_it_leaves_numpys_own_random_numbers_alone():
    np.random.seed(1)
    before = np.random.get_state()[1].copy()
    search.run(Search(metric="y", runs=50), Analytic(ackley, separate(2)), 1)
    assert (np.random.get_state()[1] == before).all()


def test_a_failed_run_is_counted_and_is_no_case():
    runs = Analytic(lambda u: u[:, 0], separate(2), fails=lambda u: u[:, 0] > 0.9)
    found = search.run(Search(metric="y", runs=200), runs, 3)
    assert 0.85 < found["value"] <= 0.9
    assert found["failed"] == found["reasons"]["it broke"] == runs.reasons["it broke"] > 0
    nothing = search.run(Search(metric="y", runs=40), Analytic(ackley, separate(2), fails=lambda u: u[:, 0] > -1), 3)
    assert (nothing["runs"], nothing["failed"], nothing["value"], nothing["values"]) == (40, 40, None, None)


def test_it_ends_where_nothing_can_be_worse():
    runs = Analytic(lambda u: np.where(u[:, 0] > 0.7, np.inf, u[:, 0]), separate(2))
    found = search.run(Search(metric="y", runs=1000), runs, 3)
    assert (found["value"], found["endless"]) == (None, True)
    assert found["runs"] < 1000
    assert found["values"]["a"][0] > 0.7


def test_a_distribution_without_end_is_searched_within_a_share_of_it():
    runs = Analytic(lambda u: u[:, 0], separate(1), bounded=False)
    found = search.run(Search(metric="y", runs=60, within=0.9), runs, 3)
    assert 0.93 < found["value"] <= 0.95
    assert np.concatenate(runs.asked).min() >= 0.05


def test_no_run_is_left_where_the_last_batch_leaves_one():
    """Two fifths of 28 are spread, 11; after two batches of 8 the last is asked alone."""
    runs = Analytic(ackley, separate(2))
    assert search.run(Search(metric="y", runs=28), runs, 1)["runs"] == sum(map(len, runs.asked)) == 28


def test_a_start_near_a_worse_one_is_left_out():
    """Those of a normal distribution with a deviation of 0.1 of the side lie within four of them."""
    points = np.array([[0.1, 0.1], [0.2, 0.45], [0.1, 0.55], [0.52, 0.5], [0.3, 0.6]])
    assert search._apart(points).tolist() == [[0.1, 0.1], [0.1, 0.55], [0.52, 0.5]]
