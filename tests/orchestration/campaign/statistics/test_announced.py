"""The number of runs that was announced first decides the bounds: nobody can choose a verdict by choosing the end."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from orchestration.campaign import engine, sums
from orchestration.campaign.case import read_campaign
from orchestration.campaign.engine import verdicts_of_first
from orchestration.campaign.statistics.bounds import elsewhere, fixed, sequence
from orchestration.campaign.statistics.verdicts import Announced, Requirement

from ..toy import changed, fly

REQUIRED = Requirement("it holds", 0.9, 0.95)


def campaign(flags):
    """A case and a dataset of runs that are known without being flown."""
    data = SimpleNamespace(met={REQUIRED.name: flags}, failed=np.zeros(len(flags), bool), reason=None)
    return SimpleNamespace(job=SimpleNamespace(requirements=[REQUIRED])), data


@pytest.mark.thorough
@pytest.mark.parametrize(("true", "wrong"), [(0.8999, "met"), (0.9, "not met")])
@pytest.mark.parametrize("announced", [150, 300])
def test_whoever_sees_all_runs_and_chooses_the_end_gets_no_more_wrong_verdicts_than_the_confidence_allows(
    true, wrong, announced
):
    """Two hundred campaigns of a known probability, whose end is where the share is furthest on the wrong side."""
    rng = np.random.default_rng(announced)
    sign = 1.0 if wrong == "met" else -1.0
    counts = np.arange(1, 4 * announced + 1)
    said = 0
    for _ in range(200):
        flags = rng.random(len(counts)) < true
        above = sign * (np.cumsum(flags) - counts * REQUIRED.probability) / np.sqrt(counts)
        wished = {int(n) for n in counts[np.argsort(-above)[:12]]} | {announced, len(counts)}
        case, data = campaign(flags)
        plan = Announced(announced, False)
        said += any(verdicts_of_first(case, data, n, plan)[0].status == wrong for n in wished)
    assert said <= 15


def test_the_announced_end_and_all_others_together_are_wrong_at_most_as_often_as_asked():
    """At the announced end Clopper and Pearson's bounds are wrong somewhat less often; the rest is for all other
    ends."""
    rng = np.random.default_rng(1)
    low = fixed(282, 300, 0.95).low
    assert low > 0.9 > elsewhere(282, 300, 0.9, 0.95, 300).low
    for announced in (20, 100, 1000):
        n = int(rng.integers(200, 400))
        bounds, free = elsewhere(int(0.95 * n), n, 0.9, 0.95, announced), sequence(int(0.95 * n), n, 0.95)
        assert bounds.low <= free.low < free.high < bounds.high


def stopped(path: Path, after: int) -> engine.Finished:
    def tell(at):
        if at.flown >= after:
            raise KeyboardInterrupt

    return engine.fly(read_campaign(path), Path("out"), workers=0, tell=tell)


def test_an_end_that_was_not_announced_is_said_and_the_announced_one_is_as_it_was(toy):
    changed(toy, ("probability: 0.3", "probability: 0.5"))
    first = stopped(toy, 20)
    other = fly(toy, runs=first.flown + 5).verdicts[0]
    assert other.text.endswith("; stopped early: 60 runs were announced")
    assert sums.read(Path("out"))["announced"] == {"runs": 60, "early": False}
    last = fly(toy).verdicts[0]
    assert (last.low, last.high) == (fixed(last.met, 60, 0.95).low, fixed(last.met, 60, 0.95).high)
    more = fly(toy, runs=70).verdicts[0]
    assert more.low < fixed(more.met, 70, 0.95).low


def test_a_campaign_that_was_announced_as_one_that_ends_early_has_no_bounds_of_a_fixed_number(toy):
    changed(toy, ("runs: 60", "runs: 60\nstop: decided"), ("probability: 0.3", "probability: 0.65"))
    fly(toy)
    changed(toy, ("stop: decided\n", ""))
    again = fly(toy).verdicts[0]
    assert again.low == sequence(again.met, 60, 0.95).low < fixed(again.met, 60, 0.95).low
