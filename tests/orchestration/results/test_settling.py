"""The time to settle for good, and the error after it, against closed forms."""

import math

import numpy as np
import pytest

from orchestration.results.settling import settling

T = np.arange(0.0, 100.0, 0.5)


def test_a_decay_settles_at_its_closed_form():
    found = settling(T, 90.0 * np.exp(-T / 10.0), 5.0)
    assert found.time == pytest.approx(10.0 * math.log(18.0), abs=0.5)
    assert found.largest == pytest.approx(5.0, rel=0.05)


def test_what_leaves_the_limit_once_more_settles_after_that():
    error = np.where(T < 20.0, 50.0, 1.0)
    error[100] = -7.0
    found = settling(T, error, 5.0)
    assert (found.time, found.rms, found.largest) == (50.5, 1.0, 1.0)


def test_what_is_at_the_limit_or_unknown_at_the_end_has_not_settled():
    for last in (5.0, math.nan):
        error = np.ones_like(T)
        error[-1] = last
        assert settling(T, error, 5.0).time is None


def test_a_vector_counts_by_its_norm_and_rms_is_that_of_a_sine():
    angle = 2.0 * np.pi * T / 25.0
    both = np.column_stack((3.0 * np.sin(angle), 4.0 * np.sin(angle)))
    found = settling(T, both, 6.0)
    assert (found.time, found.largest) == (0.0, pytest.approx(5.0, rel=1e-2))
    assert found.rms == pytest.approx(5.0 / math.sqrt(2.0), rel=1e-3)
