"""Batches of runs."""

from __future__ import annotations

import numpy as np
import pytest

from orchestration.campaign.flying import batches


def test_batches_grow_to_their_time_and_shrink_towards_the_end():
    cut = batches.Batches(np.arange(100_000), None, slots=2)
    sizes, there = [], []
    while (batch := cut.next()) is not None:
        sizes.append(len(batch.indices))
        there += batch.indices.tolist()
        cut.took(sizes[-1], 0.001 * sizes[-1])
    assert there == list(range(100_000))
    assert sizes[0] == 1
    assert max(sizes) == pytest.approx(batches.TARGET / 0.001, rel=0.01)
    assert sizes[-1] == 1


@pytest.mark.parametrize("slots", [1, 2, 5])
def test_what_is_left_is_enough_for_two_batches_of_each_that_flies(slots):
    cut, left, shares = batches.Batches(np.arange(1000), None, slots), 1000, []
    while (batch := cut.next()) is not None:
        shares.append(len(batch.indices) / left if left > 100 else 0.0)
        left -= len(batch.indices)
        cut.took(len(batch.indices), 1e-9)
    assert max(shares) == pytest.approx(1.0 / (2 * slots), rel=0.05)


def test_what_is_to_be_checked_comes_first_each_run_once_and_is_left_until_then():
    cut = batches.Batches(np.arange(2), lambda indices: indices[:, None] / 10, slots=2)
    for index in (0, 1):
        batch = cut.next()
        assert (batch.indices.tolist(), batch.points.tolist(), batch.check) == ([index], [[index / 10]], False)
    assert cut.over
    cut.check([1, 0])
    cut.check([1])
    cut.again([0])
    flown = []
    while not cut.over:
        batch = cut.next()
        flown.append((*batch.indices.tolist(), *batch.points[0].tolist(), batch.check))
    assert flown == [(1, 0.1, True), (0, 0.0, True), (1, 0.1, True), (0, 0.0, False)]
    assert cut.next() is None
