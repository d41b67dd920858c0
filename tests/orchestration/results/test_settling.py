"""The time to settle for good, and the error after it, against closed forms."""

import math

import numpy as np
import pytest

import orchestration
from orchestration.errors import InputError
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


SCENARIO = "scenarios/paper_no_singularity.yaml"


def test_a_run_says_since_when_its_bounds_are_kept_and_how_large_errors_are_from_then_on():
    """The run's own samples, of each step, are the witness."""
    source = orchestration.load(SCENARIO).source
    limit = {"name": "error", "signal": "judge.attitude_error", "always": {"below": "60 deg"}}
    never = {"name": "rate", "signal": "judge.rate_error_B", "always": {"within": 1e-9}}
    kept = {"name": "kept", "signal": "judge.attitude_error", "always": {"below": "181 deg"}}
    source = source.with_entry(("expect",), [limit, never, kept, {**limit, "name": "again"}]).with_entry(
        ("record",), {"interval": "0.1 s"}
    )
    result = orchestration.run(orchestration.load(source.with_entry(("duration",), "100 s")))
    error, rate = result.settled
    degrees = np.degrees(result["judge.attitude_error"])
    expected = settling(result.time, degrees, 60.0)
    assert error.time == pytest.approx(expected.time)
    assert (error.rms, error.largest) == (pytest.approx(expected.rms), pytest.approx(expected.largest))
    assert 1.0 < error.time < 100.0
    assert (error.signal, error.expected, error.unit) == ("judge.attitude_error", "always < 60 deg", "deg")
    assert rate.texts == ("not at the end", "", "")
    own = result.settling("judge.attitude_error", "60 deg")
    assert (own.time, own.largest) == (pytest.approx(expected.time), pytest.approx(math.radians(expected.largest)))
    with pytest.raises(InputError, match="below 60 s: the unit"):
        result.settling("judge.attitude_error", "60 s")
