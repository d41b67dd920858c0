"""Multipliers of loops whose transition over a period is a product of known matrices."""

import numpy as np
import pytest

from orchestration.errors import InputError
from orchestration.fmu.model import Variable
from orchestration.margins.floquet import FRESH, LEAD, Coordinates, Repeated, coordinates, logs, orbit
from orchestration.margins.inject import Altered
from orchestration.margins.search import Change, lost

from .loops import law, linear, rig

PERIOD = 40
TURN = np.array([[0.98, 0.15], [-0.15, 0.98]])


def gains(k: int) -> np.ndarray:
    return np.array([[0.1 + 0.08 * np.sin(2 * np.pi * k / PERIOD), 0.05]])


def periodic():
    plant, count = linear(TURN, np.eye(2)[:, 1:], np.eye(2)), [0]

    def feedback(y):
        count[0] += 1
        return -gains(count[0] - 1) @ y

    return [plant, law(feedback, 2)]


def test_multipliers_of_a_loop_that_is_periodic_in_time_are_those_of_its_product():
    loop = rig(periodic, first=50)
    seen = coordinates(loop.session.opened.plan, ["plant.y"])
    found = orbit(loop, seen, PERIOD, np.array([1e-3]), segment=4)
    assert (found.rest < 1e-9, len(found.transitions)) == (True, 10)
    product = np.eye(2)
    for k in range(50 + 4 * LEAD, 50 + 4 * LEAD + PERIOD):
        product = (TURN - np.eye(2)[:, 1:] @ gains(k)) @ product
    exact = np.linalg.eigvals(product)
    np.testing.assert_allclose(np.sort(np.abs(np.exp(found.logs))), np.sort(np.abs(exact)), rtol=1e-6)
    assert found.verdict == "the observed coordinates are the whole state that matters"


def test_an_orbit_of_many_pieces_begins_anew_and_is_still_that_of_its_product():
    loop = rig(periodic, first=50)
    found = orbit(loop, coordinates(loop.session.opened.plan, ["plant.y"]), 4 * PERIOD, np.array([1e-3]), segment=4)
    assert (found.rest < 1e-9, len(found.transitions)) == (True, 2 * FRESH)
    product = np.eye(2)
    for k in range(50 + 4 * LEAD, 50 + 4 * LEAD + PERIOD):
        product = (TURN - np.eye(2)[:, 1:] @ gains(k)) @ product
    exact = 4 * np.log(np.abs(np.linalg.eigvals(product)))
    np.testing.assert_allclose(np.sort(found.logs.real), np.sort(exact), rtol=1e-6)


@pytest.mark.parametrize("delay", [0, 2])
def test_a_delay_and_a_gain_last_where_flights_begin_anew(delay):
    """The hidden commands on their way show at the next instants."""
    feedback, pieces = np.array([[0.1, 0.3]]), 2 * FRESH
    loop = rig(lambda: [linear(TURN, np.eye(2)[:, 1:], np.eye(2)), law(lambda y: -feedback @ y, 2)])
    seen = coordinates(loop.session.opened.plan, ["plant.y"])
    altered = Altered(gain=1.3, delay=delay)
    found = orbit(loop, seen, 2 * pieces, np.array([1e-3]), segment=2, altered=altered, depth=1 + delay)
    line = np.eye(2 + delay, k=-1)
    line[:2, :2], line[2:, :2] = TURN, 0.0
    line[1, 2:] = 0.0
    if delay:
        line[2, :2], line[1, -1] = -1.3 * feedback, 1.0
    else:
        line[1] -= 1.3 * feedback[0]
    exact = np.abs(np.linalg.eigvals(line)).max()
    assert found.rest < 1e-6
    assert found.logs[0].real == pytest.approx(2 * pieces * np.log(exact), rel=1e-3)


def test_a_state_that_is_not_observed_is_told():
    hidden = np.array([[0.9, 0.3, 0.0], [0.0, 0.8, 0.5], [0.1, 0.0, 0.7]])
    loop = rig(lambda: [linear(hidden, np.eye(3)[:, 2:], np.eye(3)[:2]), law(lambda y: -0.1 * y[:1], 2)])
    found = orbit(loop, coordinates(loop.session.opened.plan, ["plant.y"]), 40, np.array([1e-3]), segment=2)
    assert found.rest > 1e-3
    assert "not observed" in found.verdict or "not explained" in found.verdict


def test_a_hidden_state_is_seen_in_several_instants_and_the_largest_multiplier_is_exact():
    hidden = np.array([[0.9, 0.3, 0.0], [0.0, 0.8, 0.5], [0.1, 0.0, 0.7]])
    drive, feedback = np.eye(3)[:, 2:], np.array([[0.1, 0.0]])
    loop = rig(lambda: [linear(hidden, drive, np.eye(3)[:2]), law(lambda y: -feedback @ y, 2)])
    seen = coordinates(loop.session.opened.plan, ["plant.y"])
    found = Repeated.of(loop, seen, 40, np.array([1e-3]), segment=2)
    assert (found.depth, found.nominal.verdict) == (2, "the observed coordinates are the whole state that matters")
    exact = np.abs(np.linalg.eigvals(hidden - drive @ feedback @ np.eye(3)[:2])).max()
    assert found.nominal.logs[0].real == pytest.approx(40 * np.log(exact), rel=1e-5)
    # A gain that is the same in all channels makes it unstable where an eigenvalue leaves the circle.
    change = lost(loop, Change("gain", 1.0, 30.0), found.decays)
    sizes = [np.abs(np.linalg.eigvals(hidden - k * drive @ feedback @ np.eye(3)[:2])).max() for k in (1, 30)]
    assert sizes[0] < 1 < sizes[1]
    at = [
        np.abs(np.linalg.eigvals(hidden - k * drive @ feedback @ np.eye(3)[:2])).max()
        for k in (change.holds, change.lost)
    ]
    assert at[0] < 1.01
    assert at[1] > 0.99


def test_multipliers_that_no_double_can_hold_have_logarithms():
    rng = np.random.default_rng(3)
    V = rng.normal(size=(4, 4))
    turn = np.array([[np.cos(1.0), -np.sin(1.0)], [np.sin(1.0), np.cos(1.0)]])
    D = np.zeros((4, 4))
    D[0, 0], D[1:3, 1:3], D[3, 3] = 0.99, 0.5 * turn, -0.01
    F = V @ D @ np.linalg.inv(V)
    found = logs(np.tile(F, (500, 1, 1)))
    np.testing.assert_allclose(found.real, 500 * np.log([0.99, 0.5, 0.5, 0.01]), rtol=1e-8)
    assert (
        np.abs(np.exp(1j * found.imag[1]) - np.exp(-500j)) < 1e-6
        or np.abs(np.exp(1j * found.imag[1]) - np.exp(500j)) < 1e-6
    )


def test_the_difference_of_rotations_is_their_rotation_vector(rng):
    seen = Coordinates((("plant", Variable("R", "output", shape=(3, 3))), ("plant", Variable("w", "output"))))
    v = np.array([0.3, -0.2, 0.1])
    K = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    angle = np.linalg.norm(v)
    R, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turned = R @ (np.eye(3) + np.sin(angle) / angle * K + (1 - np.cos(angle)) / angle**2 * K @ K)
    a, b = (np.append(M.ravel(), w) for M, w in ((R, 1.0), (turned, 1.5)))
    np.testing.assert_allclose(seen.difference(a, b), [*v, 0.5], rtol=1e-12)
    assert seen.labels == ["plant.R about x", "plant.R about y", "plant.R about z", "plant.w"]


def test_a_wrong_state_is_refused():
    plan = rig(periodic).session.opened.plan
    for name, message in (
        ("plant.u", "expected a whole real output"),
        ("plant.z", "plant has no output 'z'"),
        ("plane.x", "no block 'plane'; did you mean 'plant'"),
    ):
        with pytest.raises(InputError, match=f"--state {name}: .*{message}"):
            coordinates(plan, [name])
