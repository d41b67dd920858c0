"""The flights of docs/evidence/wheels.md: satellites that exist, draws as they are stated, and the bound of their
times."""

import numpy as np
import pytest

from evidence.wheels.bound import of_draws
from evidence.wheels.cases import CONDITIONS, WHEELS, Flights


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
