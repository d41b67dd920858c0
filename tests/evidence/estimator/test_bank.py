"""The table of what the bank costs: campaigns that differ in `bank` alone, and the interval of a median by ranks."""

import numpy as np
import pytest
from scipy.stats import binom

from evidence.estimator import bank


@pytest.mark.parametrize("name", bank.CAMPAIGNS)
def test_both_campaigns_of_a_row_have_the_same_draws_and_differ_in_the_bank_alone(name):
    one, with_bank = (bank.campaign(name, flag, 6) for flag in (False, True))
    assert one.runs == with_bank.runs == 6
    assert one.campaign.seed == with_bank.campaign.seed
    assert one.campaign.draw == with_bank.campaign.draw
    starts = [c.scenario.blocks["estimator"].start for c in (one, with_bank)]
    assert [start["bank"] for start in starts] == [False, True]
    assert starts[0] | {"bank": True} == starts[1]


def test_the_interval_of_a_median_holds_it_with_95_percent():
    values = np.arange(1.0, 25.0)
    assert bank.interval(values) == "12.5 (7 to 18)"  # ranks 7 and 18 of 24
    assert 1.0 - 2.0 * binom.cdf(6, 24, 0.5) >= 0.95 > 1.0 - 2.0 * binom.cdf(7, 24, 0.5)
