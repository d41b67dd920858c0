"""What a review flies, against the interfaces of the blocks: each scenario is checked against its FMUs."""

import math

import numpy as np
import pytest

from design.review import facts as of
from design.review import manoeuvres, pointing, station, studies, tumbles
from design.review.flights import _text
from design.review.options import Options
from orchestration.session.open import open_scenario
from orchestration.session.read import load, read

OPTIONS = Options(runs=3, members=5)


def _opened(facts, flight, folder):
    (folder / "flight.yaml").write_text(_text(facts.file, flight, folder), "utf-8")
    return open_scenario(load(read(folder / "flight.yaml")))


def test_the_contributors_of_a_cubesat_are_those_that_its_files_state(facts, four_wheels):
    named = studies.contributors(facts)
    assert "star tracker" not in named
    assert {"gyro", "magnetometer", "field of view of sun sensors", "residual dipole", "sunlight"} <= set(named)
    assert "constant torque" not in named
    assert "star tracker" in studies.contributors(of.facts(four_wheels, None))


def test_errors_keep_their_size_in_each_draw(facts, tmp_path):
    case = tumbles.prepared(facts, OPTIONS, tmp_path)
    for i in range(3):
        drawn = tumbles.draw(case, i)
        assert np.linalg.norm(drawn["plant.residual_dipole_B"]) == pytest.approx(3e-3 * np.sqrt(3.0))
        assert np.linalg.norm(drawn["plant.omega_B0"]) == pytest.approx(np.radians(np.sqrt(17.0)))
        assert abs(drawn["plant.J_error_B"][0][0]) == pytest.approx(0.002093)


@pytest.mark.parametrize("wheels", ["one", "four"])
def test_each_flight_of_a_review_fits_its_blocks(wheels, facts, four_wheels, tmp_path):
    found = facts if wheels == "one" else of.facts(four_wheels, None)
    holds = pointing.flights(found, OPTIONS, tumbles.prepared(found, OPTIONS, tmp_path))
    tracks, why = station.station(found)
    assert len(tracks) == 1
    assert not why
    failing = manoeuvres.failing(found)
    for flight in (holds[0], holds[-1], manoeuvres.slews(found)[0], *tracks, failing[-1]):
        _opened(found, flight, tmp_path)
    assert len(failing) == 1 + len(studies.failures(found))


def test_a_case_takes_away_what_its_name_says(facts, tmp_path):
    flights = {
        flight.name: flight for flight in pointing.flights(facts, OPTIONS, tumbles.prepared(facts, OPTIONS, tmp_path))
    }
    assert len(flights) == 5 + 1 + 2 * len(studies.contributors(facts))
    alone = flights["hold-gyro_alone-0"].changes["blocks"]
    assert alone["plant"]["start"]["residual_dipole_B"] == [0, 0, 0]
    assert np.linalg.norm(alone["sensors"]["start"]["rate_bias_B"]) > 0.0
    assert alone["sensors"]["start"]["field_bias_B"] == [0, 0, 0]
    left = flights["hold-without_gyro-0"].changes["blocks"]
    assert left["sensors"]["start"]["rate_bias_B"] == [0, 0, 0]
    assert np.linalg.norm(left["sensors"]["start"]["field_bias_B"]) > 0.0


def test_a_held_attitude_is_at_rest_relative_to_the_orbit(facts, tmp_path):
    start = studies.turned(facts, manoeuvres._turn(2, 0.5))["plant"]
    n = 2.0 * np.pi / facts.period
    assert np.asarray(start["Q0"]) @ start["omega_B0"] == pytest.approx([0.0, -n, 0.0], abs=1e-15)


def test_the_station_stands_beside_the_ground_track_when_the_satellite_passes(facts):
    """By hand: the station turns with the Earth, and stands 5 deg of arc off the satellite's zenith line."""
    values = station.station(facts)[0][0].changes["blocks"]["supervisor"]["start"]
    north, east = (math.radians(float(values[f"target_{name}"].split()[0])) for name in ("latitude", "longitude"))
    t, p = station.PASS * facts.period, facts.satellite.p
    turned = east + p.gmst0 + 7.292115e-5 * t
    there = [math.cos(north) * math.cos(turned), math.cos(north) * math.sin(turned), math.sin(north)]
    r, _ = p.orbit.position_velocity(t)
    assert math.degrees(math.acos(there @ r / np.linalg.norm(r))) == pytest.approx(5.0, abs=0.25)


def test_the_least_time_of_a_slew_is_that_of_its_torque_and_momentum(facts, four_wheels):
    """Four wheels 35 deg above the plane of x and y: 4 sin 35 deg of one about z, 4 cos 35 deg/sqrt 2 about x."""
    found = of.facts(four_wheels, None)
    J = np.diag(found.satellite.p.J_B)
    for axis, share in ((0, 4 * math.cos(math.radians(35)) / math.sqrt(2)), (2, 4 * math.sin(math.radians(35)))):
        a, rate = share * 0.3e-3 / J[axis], share * 2e-3 / J[axis]
        assert manoeuvres.least_time(found, axis, 0.01) == pytest.approx(2 * math.sqrt(0.01 / a), rel=1e-6)
        assert manoeuvres.least_time(found, axis, 6.0) == pytest.approx(6.0 / rate + rate / a, rel=1e-6)
    along, across = (manoeuvres.least_time(facts, axis, 1.0) for axis in (0, 1))
    assert along < 0.5 * across, "the wheel lies along x, and only rods turn the body about y"
