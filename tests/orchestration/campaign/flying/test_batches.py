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
