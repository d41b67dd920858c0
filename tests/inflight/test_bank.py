"""The bank finds the attitude from any start and gyro scale, and reports what fits as well."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.bank import Noise, exp, right_jacobian
from evidence.flight_data.synthetic import FACES, angle, spinning
from inflight.attitude import attitudes, both_ways, steadied
from inflight.gyro import spin

NOISE = Noise(field=5e-7)


@pytest.fixture(scope="module")
def flown():
    """A spin with a wrong scale and bias, and its attitudes."""
    flight, R, B, omega = spinning(5, 1000, scale=0.012, bias=(0.02, 0.0, -0.01))
    return flight, R, B, omega, attitudes(flight, flight.m, B, NOISE)


def test_field_and_gyro_find_the_attitude_through_a_wrong_scale_and_bias(flown):
    flight, R, _, omega, found = flown
    assert found.unique.any(), found.verdict()
    assert np.degrees(angle(R, found.R)[-300:]).max() < 5.0
    seen = spin(flight, found)
    axis = omega / np.linalg.norm(omega)
    true = (flight.omega.mean(axis=0) - omega) @ axis
    assert abs(seen.along - true) < 1e-3  # rad/s, of 0.013
    assert seen.along_sigma < 5e-4


def test_rates_by_parabolas_bring_the_attitude_of_a_free_spin_nearer_to_the_truth(flown):
    flight, R, B, omega, found = flown
    steady = steadied(flight)
    true = omega * (1.0 + 0.012) + np.array((0.02, 0.0, -0.01))
    assert (steady.omega - true)[20:-20].std() < 0.35 * (flight.omega - true).std()
    seen = attitudes(steady, flight.m, B, replace(NOISE, angle=5e-4))
    off, raw = (np.sqrt(np.mean(angle(R, each.R)[-300:] ** 2)) for each in (seen, found))
    assert seen.unique[-1]
    assert off < 0.7 * raw


def test_a_rate_that_is_a_parabola_stays_as_it_is_also_beside_a_gap(flown):
    flight = flown[0].part(np.abs(flown[0].t - 500.0) > 20.0)
    rate = np.vander(flight.t / 1000.0, 3) @ np.array([[0.1, -0.2, 0.3], [0.0, 0.5, 0.1], [0.2, -0.9, 0.1]])
    np.testing.assert_allclose(steadied(replace(flight, omega=rate)).omega, rate, atol=1e-10)


def test_filters_back_from_the_last_row_tell_the_first_attitudes_and_one_that_they_do_not_agree_with(flown):
    flight, R, B, omega, found = flown
    assert not found.unique[0]
    merged, apart = both_ways(flight, flight.m, B, NOISE, found)
    assert merged.unique.all()
    off = np.degrees(angle(R, merged.R))
    assert off[:100].max() < 5.0
    assert off.max() < 10.0  # where they begin to be unique
    np.testing.assert_allclose(merged.omega.mean(axis=0), omega, atol=5e-3)  # of 0.35 to 1.05; the bias is 0.02
    assert np.degrees(apart) < 5.0
    turned = replace(found, R=found.R @ exp(np.array([[0.0, 0.5, 0.0]]))[0])
    assert both_ways(flight, flight.m, B, NOISE, turned)[1] == pytest.approx(0.5, abs=0.15)


@pytest.mark.parametrize(("seed", "unique"), [(4, False), (8, True)])
def test_after_a_gap_in_which_the_attitude_is_lost_what_is_called_unique_is_right(seed, unique):
    """Filters that go on through such a gap settle 100 and 140 deg off, alone and without a doubt."""
    flight, R, B, _ = spinning(seed, 3500, scale=0.01, bias=(0.02, 0.0, -0.01))
    left = np.abs(flight.t - 1700.0) > 1200.0
    found = attitudes(flight.part(left), flight.m[left], B[left], Noise())
    after = found.unique & (flight.t[left] > 2900.0)
    assert after.any() == unique
    assert not (np.degrees(angle(R[left], found.R)[after]) > 10.0).any()


def test_an_attitude_that_is_called_unique_is_right_and_one_that_is_wrong_is_reported():
    wrong = 0
    for seed in range(4):
        flight, R, B, _ = spinning(seed, 300, scale=0.01 * (-1) ** seed)
        found = attitudes(flight, flight.m, B, NOISE)
        off = np.degrees(angle(R, found.R)[-1])
        assert off < 10.0 or not found.unique[-1]
        wrong += off > 10.0
    assert wrong  # five minutes do not tell a spin from its mirror image every time


def test_currents_end_the_ambiguity():
    flight, R, B, _ = spinning(1, 200, scale=0.01)
    by_field = attitudes(flight, flight.m, B, NOISE)
    with_light = attitudes(flight, flight.m, B, NOISE, FACES)
    assert np.degrees(by_field.ambiguity[-1]) > 20.0
    assert np.degrees(with_light.ambiguity[-1]) < 10.0
    assert np.degrees(angle(R, with_light.R)[-1]) < 5.0


@pytest.mark.parametrize("size", [0.0, 1e-7, 0.7, np.pi - 1e-9])
def test_the_right_jacobian_is_the_derivative_of_the_exponential(size):
    v = size * np.array([[0.6, -0.48, 0.64]])
    d = 1e-6 * np.array([[0.3, 0.5, -0.7]])
    wanted = exp(v + d)[0]
    got = exp(v)[0] @ exp((right_jacobian(v)[0] @ d[0])[None])[0]
    np.testing.assert_allclose(got, wanted, atol=1e-11)
