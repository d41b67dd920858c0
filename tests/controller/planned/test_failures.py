"""Rods, wheel and sensors that fail: that they are found, and what is used in their place."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from . import core
from .block import J
from .test_closed_loop import ALWAYS, FORWARD, MEASURED, errors, fly
from .test_identification import SAMPLES, Tumbles, estimated, flown
from .truth import DAYS, orbit

GAINS = np.array([[0.0, 1.0, 1.0], [1.0, 0.2, 1.0], [1.0, 1.0, -1.0], [1.05, -0.5, 0.95], [0.0, 1.0, 0.0]])
FAILED = [1, 2, 3, 2]
"""Of the first four; of the last 1 or 3."""
TO_INERTIAL = {"R_ref": np.eye(3), "Omega_ref": np.zeros(3), "dOmega_ref": np.zeros(3)}


def failing():
    truth = Tumbles(3, len(GAINS))
    truth.gains = GAINS.copy()
    return truth


def test_dead_weak_and_reversed_rods_are_found_within_80_s_of_a_tumble():
    found = flown(failing())[1]
    assert estimated(found, "rod_gains_estimate") == pytest.approx(GAINS, abs=0.1)
    assert [int(y["failed_rod"]) for y in found[:4]] == FAILED
    assert found[4]["failed_rod"] in (1, 3)
    assert all(y["rod_failed"] for y in found)


def fast(truth):
    """The same at 9.2 deg/s, which is 8/T."""
    truth.Omega *= 2.0
    return truth


def test_failed_rods_are_found_in_a_fast_tumble():
    """A reversed rod may spin the satellite up, so a search that waits for a slower rate would never come."""
    found = flown(fast(failing()))[1]
    assert [int(y["failed_rod"]) for y in found[:4]] == FAILED


@pytest.mark.parametrize("at", [lambda truth: truth, fast], ids=["at 4.6 deg/s", "at 9.2 deg/s"])
def test_rods_that_are_sound_are_not_suspected(at):
    """Gains of 0.75 to 1.25 and an inertia that is 8% off: nothing of a failure, and the same estimates as without a
    search."""
    with_search, without = (flown(at(Tumbles(4, 3)), find_failures=search)[1] for search in (True, False))
    for sound, same in zip(with_search, without, strict=True):
        assert not any(sound[name] for name in ("rod_failed", "wheel_failed", "attitude_frozen", "field_failed"))
        assert np.array_equal(sound["rod_gains_estimate"], same["rod_gains_estimate"])
        assert np.array_equal(sound["J_estimate_B"], same["J_estimate_B"])


def test_gains_that_are_known_before_the_flight_are_no_failure_and_a_dead_rod_stays_dead():
    for gains in GAINS:
        truth = Tumbles(3, 1)
        truth.gains = gains[None].copy()
        y = flown(truth, rod_gains0=gains)[1][0]
        assert not y["rod_failed"]
        assert y["rod_gains_estimate"] == pytest.approx(gains, abs=0.05)
        assert (np.array(y["rod_gains_estimate"]) == 0.0).tolist() == (gains == 0.0).tolist()


def test_failures_are_not_looked_for_where_that_is_not_wanted():
    found = flown(failing(), find_failures=False)[1]
    assert not any(y["rod_failed"] for y in found)
    assert (np.abs(estimated(found, "rod_gains_estimate") - 1.0) <= 0.4 + 1e-12).all()


def frozen(name, since):
    """The measurement stays as it is at the sample `since`."""
    held = {}

    def spoil(i, sample):
        held.setdefault(name, sample[name]) if i >= since else None
        return sample | held

    return spoil


def test_a_frozen_attitude_is_found_and_the_rate_turns_on_the_last_one():
    """After 30 s at 4.6 deg/s, 2.4 rad from what is measured."""
    truth = Tumbles(5, 2)
    record, found = flown(truth, frozen("R_NB", 100))
    for k, y in enumerate(found):
        assert y["attitude_frozen"]
        target = np.column_stack(lvlh(*orbit(truth.t)))
        expected = Rotation.from_matrix(target.T @ truth.R[k]).magnitude()
        assert y["attitude_error"] == pytest.approx(expected, abs=0.02)
        assert Rotation.from_matrix(record[-1]["R_NB"][k].T @ truth.R[k]).magnitude() > 0.5
    assert not any(y["attitude_frozen"] for y in flown(Tumbles(5, 1))[1])


def lvlh(r, v):
    """Its axes in N: Z to the Earth, Y against the orbit's normal."""
    z = -r / np.linalg.norm(r)
    y = -np.cross(r, v) / np.linalg.norm(np.cross(r, v))
    return np.cross(y, z), y, z


@pytest.mark.parametrize(
    "spoil",
    [frozen("b_B", 60), lambda i, sample: sample | {"b_B": sample["b_B"] + (i > 60) * np.array([6e-6, -4e-6, 8e-6])}],
    ids=["frozen", "with a bias of 11 uT"],
)
def test_a_field_that_is_frozen_or_biased_is_found_and_the_model_used(spoil):
    truth = Tumbles(6, 2)
    y = flown(truth, spoil)[1][0]
    assert y["field_failed"]
    true = core.field_at("igrf14", DAYS, 10, orbit(truth.t)[0], truth.t) @ truth.R[0]
    assert np.linalg.norm(y["b_used_B"] - true) < 3e-7
    assert y["rod_gains_estimate"] == pytest.approx(truth.gains[0], abs=0.15)


def test_a_field_that_repeats_is_replaced_by_the_model_at_once_and_no_rod_is_blamed_for_it():
    """From the start, for 9.5 s, by when it is not yet called frozen; the tumble has turned by 44 deg."""
    record, found = flown(truth := Tumbles(6, 4), frozen("b_B", 1), samples=20)
    for k, y in enumerate(found):
        assert not y["field_failed"]
        true = core.field_at("igrf14", DAYS, 10, orbit(truth.t)[0], truth.t) @ truth.R[k]
        assert np.linalg.norm(y["b_used_B"] - true) < 3e-7
        assert np.linalg.norm(record[-1]["b_B"][k] - true) > 5e-6
    assert not any(y["rod_failed"] for y in flown(Tumbles(6, 4), frozen("b_B", 1))[1])


@pytest.mark.parametrize(("given", "failed"), [(0.0, True), (0.3, True), (0.8, False), (1.0, False)])
def test_a_wheel_that_gives_less_than_half_of_its_torque_has_failed(given, failed):
    truth = Tumbles(7, 1)
    start = truth.h_w.copy()

    def spoil(i, sample):
        return sample | {"h_w": start + given * (sample["h_w"] - start)}

    assert bool(flown(truth, spoil)[1][0]["wheel_failed"]) == failed


def without_attitude(since, until, spoil=lambda i, sample: sample):
    """The same, with a matrix of zeros in the place of the attitude for these samples."""
    return lambda i, sample: spoil(i, sample) | ({"R_NB": np.zeros((1, 3, 3))} if since <= i < until else {})


@pytest.mark.parametrize("back", [0, 1], ids=["while it is lost", "when it is back"])
def test_what_is_known_of_satellite_and_rods_outlasts_an_attitude_that_is_lost(back):
    truths = [Tumbles(3, 1), Tumbles(3, 1)]
    for truth in truths:
        truth.gains = GAINS[:1].copy()
    known = flown(truths[0], samples=SAMPLES - 20, **TO_INERTIAL)[1][0]
    y = flown(truths[1], without_attitude(SAMPLES - 20, SAMPLES - back), **TO_INERTIAL)[1][0]
    assert y["no_attitude"] == (not back)
    assert y["failed_rod"] == FAILED[0]
    for name in ("rod_gains_estimate", "J_estimate_B", "rate_bias_estimate_B"):
        assert np.array_equal(y[name], known[name])
    assert not np.allclose(y["J_estimate_B"], J, rtol=1e-3)


@pytest.mark.parametrize("back", [0, 1], ids=["while it is lost", "when it is back"])
def test_a_stuck_wheel_is_asked_for_a_fiftieth_to_and_fro_after_an_attitude_that_is_lost(back):
    truth = Tumbles(7, 1)
    stuck = truth.h_w.copy()

    def spoil(i, sample):
        return sample | {"h_w": stuck, "u_applied": np.column_stack((sample["u_applied"][:, :3], [3e-3]))}

    y = flown(truth, without_attitude(SAMPLES - 20, SAMPLES - back, spoil), **TO_INERTIAL)[1][0]
    assert y["no_attitude"] == (not back)
    assert y["wheel_failed"]
    assert abs(y["wheel_torque_ff"]) == pytest.approx(0.02 * 3e-3 * back)


def test_a_rod_that_dies_in_flight_is_found_and_the_satellite_settles_without_it():
    """Native FMUs, the allocator told the gains: rod 2 gives nothing from 60 s on. The plant's truth judges."""
    told = ALWAYS.replace("plant.b_B -> allocator.b_B", "controller.b_used_B -> allocator.b_B")
    told += MEASURED + FORWARD + "controller.rod_gains_estimate -> allocator.rod_gains"
    result = fly(told, faults=[{"at": "60 s", "set": "plant.rod_gain[2] = 0"}])
    at = result.time[np.argmax(result["controller.failed_rod"] == 2)]
    assert 60.0 < at < 160.0
    assert result["controller.rod_gains_estimate"][-1] == pytest.approx([1.0, 0.0, 1.0], abs=0.05)
    angle, rate = errors(result)
    assert angle[-200:].max() < np.radians(1.0)
    assert rate[-200:].max() < 1e-3
