"""Causes of a difference: each is made by arithmetic here, and has to be found with its size, or nothing is said."""

from __future__ import annotations

import numpy as np
import pytest

from orchestration.acceptance.polarity.causes import causes_of
from orchestration.quantities import parse_unit

TIME = 0.1 * np.arange(1200)
OURS = np.stack(
    [
        np.sin(0.31 * TIME) + 0.2 * np.cos(1.7 * TIME),
        np.cos(0.23 * TIME),
        0.5 * np.sin(0.9 * TIME) + 0.3 * np.cos(0.37 * TIME),
    ],
    axis=1,
)


def found(theirs):
    causes, left = causes_of("torque", OURS, theirs, TIME, parse_unit("N.m"))
    return [(c.kind, c.where, c.size) for c in causes], float(np.abs(left).max())


def late(values, k):
    return np.concatenate([np.repeat(values[:1], k, axis=0), values[:-k]])


def filtered(values, constant):
    out = values.copy()
    for i in range(1, len(out)):
        out[i] = out[i - 1] + (1.0 - np.exp(-0.1 / constant)) * (values[i] - out[i - 1])
    return out


def stuck(values, row):
    out = values.copy()
    out[row:, 1] = out[row, 1]
    return out


CASES = {
    "delay": (late(OURS, 3), "torque", 3.0),
    "delay by a fraction": (0.7 * late(OURS, 1) + 0.3 * late(OURS, 2), "torque", 1.3),
    "hold": (OURS[np.arange(1200) // 4 * 4], "torque", 4.0),
    "stuck": (stuck(OURS, 500), "torque[2]", 50.0),
    "limit": (np.clip(OURS, -0.4, 0.4), "torque", 0.4),
    "lag": (filtered(OURS, 0.8), "torque", 0.8),
    "dead": (np.where(np.abs(OURS) < 0.1, 0.0, OURS), "torque", 0.1),
    "quantum": (0.05 * np.round(OURS / 0.05), "torque", 0.05),
    "gain": (OURS * [1.0, 0.8, 1.0], "torque[2]", 0.8),
    "bias": (OURS + np.array([0.0, 0.0, 0.03]), "torque[3]", 0.03),
    "single": (OURS.astype(np.float32).astype(float), "torque", 0.0),
    "noise": (OURS + 0.05 * np.random.default_rng(4).normal(size=OURS.shape), "torque", 0.05),
}


@pytest.mark.parametrize("name", CASES)
def test_a_cause_is_named_with_its_place_and_size_and_leaves_nothing(name):
    theirs, where, size = CASES[name]
    causes, left = found(theirs)
    assert [(kind, place) for kind, place, _ in causes] == [(name.partition(" ")[0], where)]
    assert causes[0][2] == pytest.approx(size, rel=0.05)
    assert left < 1e-6


@pytest.mark.parametrize("first", [0, 1100], ids=["throughout", "at the end"])
def test_an_output_that_stays_at_its_limit_is_not_called_stuck(first):
    ours = OURS.copy()
    ours[first:, 1] = 0.5 + 0.05 * np.sin(TIME[first:])
    causes, _ = causes_of("torque", ours, np.clip(ours, -0.4, 0.4), TIME, parse_unit("N.m"))
    assert {(c.kind, c.where, c.size) for c in causes} == {("limit", "torque", 0.4)}
    wrong, _ = causes_of("torque", OURS, np.where([False, True, False], 0.4, OURS), TIME, parse_unit("N.m"))
    assert not wrong


def test_axes_that_are_turned_a_little_are_told_by_angle():
    angle = np.radians(2.0)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    assert found(OURS @ turn.T)[0] == [("turned", "torque", pytest.approx(2.0))]


@pytest.mark.parametrize(
    "theirs",
    [
        OURS**3,
        OURS + 0.1 * np.sin(TIME)[:, None],
        filtered(OURS, 0.8) ** 3,
        OURS * (1.0 + 0.3 * np.sin(0.05 * TIME))[:, None],
    ],
    ids=["cube", "another signal", "filtered and cubed", "a gain that varies"],
)
def test_nothing_is_said_of_a_difference_that_no_cause_explains(theirs):
    """A slow signal is followed one step ahead by any filter: only its whole course counts."""
    assert found(theirs)[0] == []


def test_noise_may_be_nearly_as_large_as_the_signal():
    noise = np.random.default_rng(5).normal(size=OURS.shape) * [0.0, 0.6, 0.0]
    assert found(OURS + noise)[0] == [("noise", "torque[2]", pytest.approx(0.6, rel=0.05))]


def test_a_wrong_sign_or_unit_is_no_gain():
    assert found(-OURS)[0] == []
    assert found(1000.0 * OURS)[0] == []


def test_elements_that_stick_at_values_of_their_own_are_told_one_by_one():
    time = 0.1 * np.arange(600)
    ours = np.stack([np.sin(time), np.cos(0.7 * time)], axis=1)
    theirs = ours.copy()
    theirs[100:] = ours[99]
    causes, left = causes_of("torque", ours, theirs, time, None)
    assert [(cause.kind, cause.where) for cause in causes] == [("stuck", "torque[1]"), ("stuck", "torque[2]")]
    assert [f"{value:.4g}" in cause.text for cause, value in zip(causes, ours[99], strict=True)] == [True, True]
    assert not left.any()


def test_a_tie_is_told_as_such_and_as_what_another_element_has():
    time = 0.1 * np.arange(600)
    ours = np.stack([2.0 - np.cos(0.05 * time), np.sin(time)], axis=1)
    theirs = np.clip(ours, -1.2, 1.2)  # the first one stays at its limit: it could be stuck, too
    one, _ = causes_of("torque", ours[:, :1], theirs[:, :1], time, None)
    assert {one[0].kind, *(kind for kind, _ in one[0].equally)} == {"stuck", "limit"}
    assert "or equally well" in one[0].text
