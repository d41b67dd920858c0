"""The flights of docs/evidence/wheels.md: satellites that exist, draws as they are stated, and the bound of their
times."""

import math

import numpy as np
import pytest

from evidence import files
from evidence.paper import ROOT
from evidence.satellites.classes import CLASSES
from evidence.wheels import long, page
from evidence.wheels.bound import of_draws
from evidence.wheels.cases import CONDITIONS, WHEELS, Flights
from evidence.wheels.kept import FILE, REMEDY, Flown, found_in, load_least
from evidence.wheels.long import DAY, HOLD, Long
from evidence.wheels.long import fly as fly_long
from evidence.wheels.long import load as load_long
from evidence.wheels.slews import Slew, drawn, least_time, slew
from evidence.wheels.slews import load as load_slews
from evidence.wheels.telemetry import load as load_telemetry


@pytest.mark.parametrize("satellite", WHEELS)
@pytest.mark.parametrize("condition", CONDITIONS)
def test_each_campaign_is_accepted_and_flies_the_same_tumbles_under_each_condition(satellite, condition):
    drawn, nominal = (Flights(satellite, which).drawn(3) for which in (condition, "nominal"))
    for one, other in zip(drawn, nominal, strict=True):
        assert np.array_equal(one["plant.Q0"], other["plant.Q0"])
        assert np.degrees(np.linalg.norm(one["plant.omega_B0"])) <= 6.0 + 1e-9


def test_the_wheels_are_unit_axes_of_full_rank():
    for axes in WHEELS.values():
        assert np.linalg.norm(axes, axis=1) == pytest.approx(1.0)
        assert np.linalg.matrix_rank(axes) == 3


def test_a_tumble_that_the_wheels_hold_has_no_least_time_and_one_that_they_do_not_hold_has():
    flights = Flights("50 kg", "nominal")
    rates = [np.linalg.norm(values["plant.omega_B0"]) for values in flights.drawn(8)]
    times = of_draws(flights, 8)
    assert times[int(np.argmin(rates))] == 0.0
    assert 20.0 < times[int(np.argmax(rates))] < 1500.0


def flown(satellite: str, condition: str, run: int, settled: float, **more: float) -> Flown:
    values = {"inclination": 50.0, "rate": 3.0, "hold_rms": 0.004, "hold_max": 0.01, "wheel_share": 0.3} | more
    rest = {"least_time": math.nan, "found": math.nan, "others": 0, "least_angle": math.nan}
    return Flown(satellite, condition, run, settled_5=settled, settled_1=settled, **rest | values)


def test_a_flight_that_does_not_settle_counts_and_its_row_has_no_such_times():
    lines = [flown("50 kg", "nominal", 0, 100.0, least_time=80.0), flown("50 kg", "nominal", 1, 300.0)]
    lines += [flown("50 kg", "estimated", 0, math.inf), flown("50 kg", "estimated", 1, 500.0, hold_rms=0.03)]
    lines += [flown("3U", "one dead", 0, 900.0, found=20.0), flown("12U", "one dead", 0, math.inf, found=math.inf)]
    lines += [flown("3U", "all dead", 0, math.inf, hold_rms=6.0, hold_max=9.0, least_angle=5.0)]
    slews = [Slew("12U", 90, i, 20.0, settled) for i, settled in enumerate((21.0, 25.0, 25.5))]
    text = page.text(lines, slews, [Long(DAY, "3U", 0.004, 0.01, 0.5)], least=load_least())
    assert "**Healthy, 3 of 4 tumbles settle**" in text
    assert "below 0.02° rms in 0 of 1, worst 0.03°" in text
    assert "With one wheel of four dead 0 of 1 settle, with one of three 1 of 1; with one that" in text
    assert "at the median 1.2, at most 1.2, of 1" in text
    assert "The third is not met." in text
    assert "| a wheel dead | 1 of 1, 900 s, 0.004° | 0 of 1, –, – | – |" in text
    assert "all wheels that failed in 1 of 2 flights, after 20 s at the median and 20 s at worst; 0 sound" in text
    assert (
        "rods alone hold a 3U to 6° rms at the median, 9° at most; the least that any use of them reaches is 5°" in text
    )
    lost = [flown("3U", "one stuck", i, math.inf, hold_max=angle) for i, angle in enumerate((6.0, 170.0))]
    assert "half its momentum**: 2 of 3 do not settle, 1 of them beyond 90°" in page.text(
        [*lost, flown("3U", "one stuck", 2, 400.0)], [], []
    )
    assert "2 of 3 slews end within" in text
    assert "| 12U | – | – | 1.20 | – | 1.23 |" in text
    assert next(row for row in text.splitlines() if row.startswith("| 50 kg | estimated")).count("–") == 2


def test_the_page_is_that_of_the_kept_flights_and_short():
    docs = ROOT / "docs" / "evidence"
    text = (docs / "wheels.md").read_text("utf-8")
    assert text == page.text(
        files.load(Flown, docs / FILE, REMEDY), load_slews(), load_long(), load_telemetry(), load_least()
    )
    assert sum(len(line.split()) for line in text.splitlines() if not line.startswith("|")) <= 1100


def test_a_failed_wheel_is_found_when_the_last_of_those_that_fail_is_and_sound_ones_are_counted():
    times = [10.0, math.nan, 30.0, math.nan]
    assert found_in(times, 2, 1, 3) == (30.0, 1)
    assert found_in(times, 2, 2, 3) == (30.0, 0)  # and the first after it
    assert found_in(times, 0, 2, 4) == (math.inf, 1)
    assert math.isnan(found_in([math.nan] * 4, 0, 0, 4)[0])


def test_the_least_time_of_a_turn_is_that_of_a_closed_form_for_three_orthogonal_wheels():
    """About the first axis of the 3U one wheel alone acts."""
    it, angle = CLASSES["3U"], math.radians(180.0)
    a, w = (limit / it.moments[0] for limit in (it.wheel_torque_max, it.wheel_momentum_max))
    assert least_time("3U", np.array([1.0, 0.0, 0.0]), angle) == pytest.approx(angle / w + w / a)
    assert least_time("3U", np.array([1.0, 0.0, 0.0]), 0.01) == pytest.approx(2.0 * math.sqrt(0.01 / a))


@pytest.mark.parametrize("satellite", WHEELS)
def test_a_slew_of_each_satellite_ends_within_the_requirement(satellite):
    axis, push = drawn(90, 3)
    assert np.linalg.norm(axis) == pytest.approx(1.0)
    assert np.linalg.norm(push) == pytest.approx(1.0)
    assert 0.8 < slew((satellite, 90, 3)).ratio < 1.2


@pytest.mark.parametrize("flight", [DAY, HOLD])
def test_a_long_flight_is_judged_late_and_its_wheels_are_not_full(flight, monkeypatch):
    monkeypatch.setitem(long.DURATION, flight, 4500.0)
    flown = fly_long((flight, "3U"))
    assert 0.0 < flown.rms <= flown.largest < 0.5
    assert 0.0 < flown.wheel_share < 1.0
