"""The flights of docs/evidence/wheels.md: satellites that exist, draws as they are stated, and the bound of their
times."""

import math

import numpy as np
import pytest

from evidence import files
from evidence.paper import ROOT
from evidence.wheels import page
from evidence.wheels.bound import of_draws
from evidence.wheels.cases import CONDITIONS, WHEELS, Flights
from evidence.wheels.kept import FILE, REMEDY, Flown


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
    return Flown(satellite, condition, run, settled_5=settled, settled_1=settled, **{"least_time": math.nan} | values)


def test_a_flight_that_does_not_settle_counts_and_its_row_has_no_such_times():
    lines = [flown("50 kg", "nominal", 0, 100.0, least_time=80.0), flown("50 kg", "nominal", 1, 300.0)]
    lines += [flown("50 kg", "estimated", 0, math.inf), flown("50 kg", "estimated", 1, 500.0, hold_rms=0.03)]
    lines += [flown("3U", "one dead", 0, 900.0), flown("12U", "one dead", 0, math.inf)]
    text = page.text(lines)
    assert "**Healthy, 3 of 4 tumbles settle**" in text
    assert "below 0.02° rms in 0 of 1, worst 0.03°" in text
    assert "With one wheel of four dead 0 of 1 settle, with one of three 1 of 1." in text
    assert "at the median 1.2, at most 1.2, of 1" in text
    assert next(row for row in text.splitlines() if "estimated with" in row and row.startswith("| 50")).count("–") == 2


def test_the_page_is_that_of_the_kept_flights_and_short():
    docs = ROOT / "docs" / "evidence"
    text = (docs / "wheels.md").read_text("utf-8")
    assert text == page.text(files.load(Flown, docs / FILE, REMEDY))
    assert len(text.split()) <= 1500
