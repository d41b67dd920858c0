"""The classes of docs/evidence/satellites.md: bodies that exist, and tumbles of each that can be flown."""

from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest

from evidence import crew
from evidence.satellites import make
from evidence.satellites.classes import ALL, DURATION, box, settled, tumbles
from evidence.satellites.kept import CONDITIONS
from evidence.satellites.make import PART, parts


@pytest.mark.parametrize("name", ALL)
def test_each_satellite_is_a_body(name):
    moments = sorted(ALL[name].moments)
    assert moments[0] > 0.0
    assert moments[2] <= moments[0] + moments[1]


def test_a_box_has_the_moments_of_its_points():
    rng = np.random.default_rng(1)
    points = rng.uniform(-0.5, 0.5, (400_000, 3)) * [0.1, 0.2, 0.3]
    squares = (points**2).mean(axis=0)
    assert box(2.0, 0.1, 0.2, 0.3) == pytest.approx(2.0 * (squares.sum() - squares), rel=0.01)


@pytest.mark.parametrize("errors", [False, True])
def test_the_tumbles_of_a_class_are_a_campaign(errors):
    assert tumbles("3U", 5, errors).case.runs == 5


def test_settled_is_the_later_of_both_and_not_at_the_end():
    angle = np.array([100.0, 50.0, np.nan, DURATION - 1.0])
    rate = np.array([40.0, 60.0, 10.0, 10.0])
    assert settled(angle, rate).tolist() == [100.0, 60.0, np.inf, np.inf]


@pytest.mark.parametrize("name", ["1U", "50 kg, flat", "50 kg, elongated"])
def test_the_errors_drawn_leave_a_body_and_are_as_large_as_those_of_flight_md(name):
    """A body's moments obey the triangle inequality; in docs/evidence/flight.md each moment is 5 to 10% off, 7.6% in
    the mean square."""
    J = np.array(ALL[name].moments)
    off = np.array([np.diag(run["plant.J_error_B"]) for run in tumbles(name, 200, True).drawn()])
    bodies = np.sort(J + off, axis=1)
    assert (bodies[:, 0] > 0.0).all()
    assert (bodies[:, 2] <= bodies[:, 0] + bodies[:, 1]).all()
    shares = np.sqrt(np.mean((off / J) ** 2, axis=0))
    assert shares.min() > 0.05
    assert shares.max() < 0.125
    assert np.abs(off / J).max() < 0.15


def test_orbits_and_rates_are_drawn_over_all_that_the_page_says():
    runs = tumbles("50 kg, rates to 30 deg/s", 200).drawn()
    heights = np.array([run["plant.orbit_radius"] for run in runs]) / 1e3 - 6371.0
    tilts = np.degrees([run["plant.inclination"] for run in runs])
    rates = np.degrees([np.linalg.norm(run["plant.omega_B0"]) for run in runs])
    for values, low, high in ((heights, 350.0, 1200.0), (tilts, 0.0, 98.0), (rates, 0.0, 30.0)):
        assert low <= values.min() < low + 0.05 * (high - low)
        assert high - 0.05 * (high - low) < values.max() <= high


def test_all_satellites_have_as_many_flights_at_any_time_to_a_part():
    flown = dict.fromkeys([(name, kind) for name in ALL for kind in CONDITIONS], 0)
    for name, kind, most in parts(25):
        flown[name, kind] = most
        assert max(flown.values()) - min(flown.values()) <= PART
    assert set(flown.values()) == {25}


def test_a_part_that_a_satellite_has_flown_already_is_not_flown_again(monkeypatch):
    """A campaign that has more runs than are wanted is refused."""
    wanted = []
    hands = SimpleNamespace(fly=lambda case, _: wanted.append(case.runs))
    monkeypatch.setattr(crew, "crew", lambda _: nullcontext(hands))
    monkeypatch.setattr(crew, "runs_of", lambda *_: range(15))
    monkeypatch.setattr(make, "flown", lambda *_: None)
    monkeypatch.setattr(make, "save", lambda *_: None)
    monkeypatch.setattr(make, "write", lambda: None)
    make.make(22, 1)
    assert set(wanted) == {20, 22}
