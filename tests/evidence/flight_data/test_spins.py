"""Spins through the estimator in C: one filter converges to a false attitude and does not say so, the bank does not."""

import math

import pytest

from evidence.flight_data import spins
from evidence.flight_data.spins import Case

FALSE = 5
"""A spin on which one filter settles wrongly."""


@pytest.mark.fly
def test_one_filter_trusts_a_false_attitude_and_the_bank_reports_that_it_cannot_tell():
    one, by_field = spins.case((FALSE, 0))
    assert one.trusted
    assert one.off > spins.WRONG
    assert one.nis < 4.5  # quiet innovations: nothing else tells
    assert not by_field.trusted or by_field.off < spins.WRONG


@pytest.mark.fly
def test_currents_with_the_earths_light_end_the_ambiguity():
    _, with_light = spins.case((FALSE, 3))
    assert with_light.trusted
    assert with_light.off < math.radians(5.0)


def test_cases_are_counted_by_what_was_said_of_them():
    cases = [Case(0.01, True, 3.0), Case(1.0, False, 3.0), Case(1.0, True, 9.0), Case(math.nan, False, 3.0)]
    assert list(spins.counted(cases).values()) == [1, 1, 1, 1]
    assert spins.worst_quiet(cases) is None
    assert spins.largest_trusted(cases) == math.degrees(1.0)
