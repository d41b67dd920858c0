"""Dates and sidereal time."""

from __future__ import annotations

import math
import re
from datetime import UTC, datetime, timedelta

import pytest

from plant import time_scales
from tests import dates
from tests.authorities import orbits


@pytest.mark.parametrize("source", orbits.SIDEREAL)
def test_sidereal_time_is_as_published(source):
    date, degrees = orbits.SIDEREAL[source]
    assert math.degrees(time_scales.gmst(date)) == pytest.approx(degrees, abs=1e-6)


def test_the_earths_rate_is_that_of_sidereal_time():
    start = datetime(2009, 8, 10, tzinfo=UTC)
    turned = time_scales.gmst(start + timedelta(hours=7)) - time_scales.gmst(start)
    assert math.remainder(turned - time_scales.EARTH_RATE * 7 * 3600.0, 2 * math.pi) == pytest.approx(0.0, abs=1e-10)


def test_sidereal_time_lies_within_a_turn_before_and_after_j2000():
    for year in (1900, 1957, 1999, 2000, 2029):
        assert 0.0 <= time_scales.gmst(datetime(year, 7, 3, 5, tzinfo=UTC)) < 2 * math.pi


def test_a_decimal_year_counts_the_leap_day():
    assert time_scales.decimal_year(datetime(2012, 7, 2, tzinfo=UTC)) == pytest.approx(2012.5, abs=1e-9)
    assert time_scales.decimal_year(datetime(2009, 7, 2, 12, tzinfo=UTC)) == pytest.approx(2009.5, abs=1e-9)
    assert time_scales.decimal_year(datetime(2010, 1, 1, tzinfo=UTC)) == 2010.0
    assert time_scales.decimal_year(datetime(9999, 12, 31, tzinfo=UTC)) == pytest.approx(9999.9973, abs=1e-4)


@pytest.mark.parametrize("text", dates.READ)
def test_utc_in_iso_8601_is_read(text):
    assert time_scales.parse_epoch(text) == dates.READ[text]


@pytest.mark.parametrize("text", dates.REFUSED)
def test_anything_else_is_refused_with_what_is_expected(text):
    with pytest.raises(
        ValueError, match=re.escape("epoch: expected UTC in ISO 8601") + ".*" + re.escape(f"found {text!r}")
    ):
        time_scales.parse_epoch(text)
