"""What stands in arguments.yaml, tried where it is nearest to failing."""

from __future__ import annotations

import calendar
import math
from fractions import Fraction

import numpy as np

LEAST = 2.0**-1074


def length(v):
    return math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])


def test_no_component_over_the_length_is_above_1_25_even_where_squares_are_the_smallest_numbers():
    rng = np.random.default_rng(1)
    scales = [2.0**-537, 2.0**-536.5, 2.0**-530, 1e-150, 1.0, 1e45]
    worst = 0.0
    for scale in scales:
        for v in rng.uniform(-2.0, 2.0, (3000, 3)) * rng.choice([0.0, 1e-3, 1.0], (3000, 3)) * scale:
            size = length([float(c) for c in v])
            assert size == 0.0 or size >= 2.0**-537
            if size > 0.0:
                worst = max(worst, *(abs(float(c) * (1.0 / size)) for c in v))
    assert 1.2 < worst <= 1.25


def test_the_worst_square_among_the_smallest_numbers_is_rounded_by_half():
    x = math.sqrt(1.5) * 2.0**-537 * (1 - 1e-9)
    assert x * x == LEAST
    assert float(Fraction(x) ** 2 / Fraction(LEAST)) < 1.5


def days_before(year):
    """As epoch_days_before of epoch.h has it."""
    return 365 * (year - 1) + (year - 1) // 4 - (year - 1) // 100 + (year - 1) // 400


def test_a_year_of_any_date_has_365_days_or_366_as_the_calendar_has_it():
    for year in range(1, 10000):
        assert days_before(year + 1) - days_before(year) == 365 + calendar.isleap(year)
