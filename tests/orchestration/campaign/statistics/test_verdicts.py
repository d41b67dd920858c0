"""Shares, quantiles, requirements and early stopping, against tables, closed forms and draws."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom, quantile_test

from orchestration.campaign.statistics.bounds import evidence, fixed, looks, quantile, runs_needed, sequence, share
from orchestration.campaign.statistics.verdicts import Announced, Requirement, hints, probability, verdicts


def test_intervals_of_ten_of_a_hundred_are_those_of_the_tables():
    # statsmodels 0.14, proportion_confint(10, 100, method="beta").
    exact = share(10, 100, 0.95)
    assert (exact.low, exact.high) == pytest.approx((0.04900469, 0.17622260), abs=1e-7)
    assert share(0, 0, 0.95).low == 0.0
    assert share(0, 0, 0.95).high == 1.0


def test_a_known_probability_lies_in_its_interval_at_least_95_of_100_times():
    counts = np.arange(121)
    bounds = [share(int(k), 120, 0.95) for k in counts]
    for p in (0.003, 0.05, 0.5, 0.97):
        covered = np.array([b.low <= p <= b.high for b in bounds])
        assert binom.pmf(counts, 120, p)[covered].sum() >= 0.95  # over all that can be drawn
        drawn = np.random.default_rng(3).random((1000, 120)) < p
        assert covered[drawn.sum(axis=1)].mean() >= 0.94


def test_requirements_are_shown_by_as_many_runs_without_a_miss_as_the_standards_tables_say():
    # ln(1 - C) / ln P: 59 runs for 95/95 (Wilks 1941), 1109 for 3 sigma at 95%, 598 for 99.5% at 95%.
    for p, c, runs in ((0.95, 0.95, 59), (0.9973, 0.95, 1109), (0.995, 0.95, 598)):
        assert runs_needed(p, c, repeated=False) == runs
        assert fixed(runs, runs, c).low >= p > fixed(runs - 1, runs - 1, c).low


def test_the_largest_of_59_values_bounds_the_95_percent_quantile_and_of_58_none_does():
    values = np.random.default_rng(0).normal(size=59)
    assert quantile(values, 0.95, 0.95)[1].high == values.max()
    assert quantile(values[:58], 0.95, 0.95)[1].high == np.inf
    # Two values may lie above where there are 93: Wilks' second order.
    more = np.random.default_rng(0).normal(size=93)
    assert quantile(more, 0.95, 0.95)[1].high == np.sort(more)[-2]


def test_bounds_of_a_quantile_are_scipys_and_those_of_a_sequence_are_wider():
    values = np.random.default_rng(4).normal(size=300)
    for p in (0.1, 0.5, 0.95):
        at, bounds = quantile(values, p, 0.9)
        assert bounds.low == quantile_test(values, p=p, alternative="greater").confidence_interval(0.9).low
        assert bounds.high == quantile_test(values, p=p, alternative="less").confidence_interval(0.9).high
        assert at == np.quantile(values, p, method="inverted_cdf")
        wide = quantile(values, p, 0.9, repeated=True)[1]
        assert wide.low < bounds.low < at < bounds.high < wide.high


def test_bounds_of_a_quantile_hold_for_a_skew_distribution_and_for_values_without_end():
    rng = np.random.default_rng(1)
    missed = np.zeros(2)
    for _ in range(150):
        _, bounds = quantile(rng.exponential(size=200), 0.9, 0.95)
        missed += bounds.low > np.log(10), bounds.high < np.log(10)
    assert (missed / 150 <= 0.05 + 0.03).all()
    assert (missed > 0).all()  # not just wide
    value, bounds = quantile(np.r_[np.arange(90.0), np.full(10, np.inf)], 0.95, 0.95)
    assert (value, bounds.high) == (np.inf, np.inf)
    assert np.isnan(quantile(np.empty(0), 0.5, 0.95)[0])


def test_verdicts_are_met_not_met_and_undecided():
    requirements = [Requirement("a", 0.95, 0.95), Requirement("b", 0.95, 0.95), Requirement("c", 0.95, 0.95)]
    met, failed, open_ = verdicts(requirements, {"a": 59, "b": 50, "c": 58}, 59)
    assert (met.status, failed.status, open_.status) == ("met", "not met", "undecided")
    assert met.text == "59 of 59 runs meet it; probability at least 0.9504 at 95% confidence, required 0.95"
    assert failed.text == "50 of 59 runs meet it; probability at most 0.9181 at 95% confidence, required 0.95"
    assert open_.text == (
        "58 of 59 runs meet it; probability at least 0.9221, at most 0.999131, each at 95% confidence, required 0.95"
    )
    few = verdicts(requirements[:1], {"a": 10}, 10)[0]
    assert few.text.endswith("; 59 runs are needed at least")
    none = verdicts(requirements[:1], {"a": 0}, 0)[0]
    assert (none.status, none.low, none.high) == ("undecided", 0.0, 1.0)
    assert hints(requirements[:1], 58) == [
        "a: 58 runs cannot show a probability of 0.95 at 95% confidence; 59 are needed at least"
    ]
    assert hints(requirements, 59) == []


def test_a_bound_is_rounded_outwards():
    assert probability(0.99708) == "0.99708"
    assert probability(0.997019) == "0.99701"
    assert probability(0.997019, up=True) == "0.99702"
    assert probability(0.012345) == "0.0123"
    assert probability(0.012345, up=True) == "0.0124"
    assert (probability(0.0), probability(1.0)) == ("0", "1")


# ---------------------------------------------------------------- early stopping


def _least(count: int, p: float, c: float, side: int) -> int:
    """The least number of successes that is enough for `met` (0), or the largest for `not met` (1); out of reach:
    none."""
    enough = [k for k in range(count + 1) if evidence(k, count, p)[side] >= -np.log1p(-c)]
    return (min(enough, default=count + 1), max(enough, default=-1))[side]


@pytest.mark.parametrize(("p", "c"), [(0.9, 0.9), (0.98, 0.95), (0.5, 0.8)])
def test_looking_at_each_look_says_the_wrong_word_no_more_often_than_the_confidence_permits(p, c):
    counts = np.array(looks(600))
    lowest = np.array([_least(n, p, c, 0) for n in counts])
    highest = np.array([_least(n, p, c, 1) for n in counts])
    drawn = np.random.default_rng(5).random((4000, 600)) < p  # at the border, where both words are wrong the most often
    successes = drawn.cumsum(axis=1)[:, counts - 1]
    noise = 2 * np.sqrt(c * (1 - c) / 4000)
    wrongly_met, wrongly_not = (successes >= lowest).any(axis=1).mean(), (successes <= highest).any(axis=1).mean()
    assert 0.0 < wrongly_met <= 1 - c + noise
    assert 0.0 < wrongly_not <= 1 - c + noise
    if p == 0.9:  # what is kept is not for nothing: bounds for a fixed number of runs say it too often
        naive = binom.sf(successes - 1, counts, p) <= 1 - c
        assert naive.any(axis=1).mean() > 1 - c + 5 * noise


def test_the_bounds_of_a_sequence_are_where_the_evidence_is_just_enough():
    rng = np.random.default_rng(2)
    for _ in range(60):
        n = int(10 ** rng.uniform(0, 6))
        s, p, c = rng.binomial(n, rng.random() ** 0.1), rng.random() ** 0.2, rng.uniform(0.5, 0.999)
        bounds, enough = sequence(s, n, c), -np.log1p(-c)
        assert (evidence(s, n, p)[0] >= enough) == (bounds.low >= p)
        assert (evidence(s, n, p)[1] >= enough) == (bounds.high <= p)
        assert bounds.low <= fixed(s, n, c).low <= fixed(s, n, c).high <= bounds.high
    assert (sequence(0, 0, 0.95).low, sequence(0, 0, 0.95).high) == (0.0, 1.0)


def test_early_stopping_asks_for_half_as_many_runs_again_at_most():
    assert runs_needed(0.997, 0.95, repeated=True) == 1503
    assert sequence(1503, 1503, 0.95).low >= 0.997 > sequence(1502, 1502, 0.95).low


def test_a_sure_thing_is_decided_at_one_of_the_first_looks():
    requirement = [Requirement("a", 0.9, 0.95)]
    good = next(n for n in looks(10**6) if verdicts(requirement, {"a": n}, n, Announced(n, True))[0].status == "met")
    bad = next(
        n for n in looks(10**6) if verdicts(requirement, {"a": n // 2}, n, Announced(n, True))[0].status == "not met"
    )
    assert good == 45  # 43 would be enough
    assert bad == 30
    assert looks(20) == [20]
    assert looks(10**6)[-1] == 10**6
    assert len(looks(10**6)) < 100
