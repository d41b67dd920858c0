"""The flights of telemetry that fails in docs/evidence/wheels.md: what is drawn, and what is counted."""

import math
from collections import Counter

import pytest

from evidence.wheels import page
from evidence.wheels.telemetry import BEGINS, FAILED, SATELLITES, SETS, TELEMETRY, Failure, flights, fly, scenario


def test_each_kind_of_telemetry_each_begin_and_each_satellite_is_flown_with_three_and_with_four_wheels():
    wanted = flights(24)
    for wheels in SETS:
        kinds = Counter((kind, begin) for _, n, kind, begin, _ in wanted if n == wheels and kind in TELEMETRY)
        assert set(kinds) == {(kind, begin) for kind in TELEMETRY for begin in BEGINS}
        assert {satellite for satellite, n, *_ in wanted if n == wheels} == set(SATELLITES)
    assert Counter(kind for _, _, kind, _, _ in wanted if kind in FAILED) == dict.fromkeys(FAILED, 6)
    assert len({number for *_, number in wanted}) == len(wanted)


def test_noise_is_of_the_telemetry_of_one_wheel_and_its_truth_is_that_of_the_others():
    data, wheel, at = scenario("3U", 3, "noisy", "hold", 7)
    from_noisy = [line for line in data["connections"] if line.startswith("noisy.")]
    assert from_noisy
    assert all(line.endswith(f"h_w[{wheel}]") for line in from_noisy)
    assert "plant.h_w -> noisy.h_w" in data["connections"]
    assert data["faults"] == [{"at": at, "set": "noisy.wheel_momentum_noise = 0.0002"}]


@pytest.mark.parametrize("kind", ["frozen", "dead"])
def test_a_slew_with_four_wheels_holds_and_only_a_wheel_that_fails_is_named(kind):
    found = fly(("12U", 4, kind, "slew", 3))
    assert found.held
    assert math.isfinite(found.named) == (kind == "dead")
    assert found.others == 0


def test_the_page_counts_flights_and_names():
    lines = [Failure(3, "3U", "frozen", "hold", i, 5000.0, 20.0 * i, math.nan, 0) for i in range(2)]
    lines.append(Failure(4, "3U", "dead", "hold", 3, 5000.0, 1.0, 12.0, 1))
    assert list(page._telemetry(lines)) == [
        ["telemetry frozen", "3", "1 of 2", "0 of 2", "–", "20°", "20°", "0"],
        ["a wheel dead", "4", "1 of 1", "1 of 1", "12 s", "1°", "1°", "1"],
    ]
    assert page._told(lines[:2]) == "1 of 2 flights hold, the sound wheel is named in 0"
