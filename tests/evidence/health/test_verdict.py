"""What becomes of a flight: on courses whose answer is plain."""

import numpy as np
import pytest

from evidence.health.verdict import BOUND, ERROR, RATE, RETURN, held, held_hold, rate, rate_tumble

TIME = np.arange(0.0, 8000.0, 10.0)


def course(error=1.0, bound=5.0, rates=0.1):
    """Constants or arrays, deg and deg/s."""
    full = np.ones_like(TIME)
    signals = {ERROR: np.radians(error * full), BOUND: np.radians(bound * full)}
    return signals | {RATE: np.radians(np.outer(rates * full, [0.6, 0.0, 0.8]))}


def between(a, b, inside, outside):
    return np.where((a <= TIME) & (b > TIME), inside, outside)


def test_an_error_counts_from_the_beginning_on():
    early = course(error=between(0.0, 500.0, 170.0, 2.0))
    assert held(500.0, TIME, early) == pytest.approx(2.0)
    assert held(490.0, TIME, early) == pytest.approx(170.0)
    assert held_hold(TIME, course(error=between(0.0, 6600.0, 170.0, 3.0))) == pytest.approx(3.0)


def test_without_an_attitude_no_error_counts_and_its_return_takes_half_an_hour_at_most():
    blind = between(1000.0, 2000.0, 80.0, 10.0)
    late = course(error=between(1000.0, 2000.0 + RETURN - 20.0, 90.0, 4.0), bound=blind)
    assert held(0.0, TIME, late) == pytest.approx(4.0)
    too_late = course(error=between(1000.0, 2000.0 + RETURN + 20.0, 90.0, 4.0), bound=blind)
    assert held(0.0, TIME, too_late) == pytest.approx(90.0)
    before = course(error=between(900.0, 2000.0, 40.0, 4.0), bound=blind)
    assert held(0.0, TIME, before) == pytest.approx(40.0)


def test_a_rate_counts_only_without_an_attitude():
    blind = between(3000.0, 4000.0, 31.0, 29.0)
    assert rate(0.0, TIME, course(rates=between(3000.0, 3100.0, 2.0, 0.3), bound=blind)) == pytest.approx(2.0)
    assert rate(0.0, TIME, course(rates=between(2000.0, 3000.0, 2.0, 0.3), bound=blind)) == pytest.approx(0.3)
    assert rate_tumble(TIME, course(rates=between(0.0, 1900.0, 5.0, 0.2), bound=90.0)) == pytest.approx(0.2)
    assert rate(0.0, TIME, course(rates=5.0)) == 0.0
