"""What is said of a block by itself where it is not wrong or there is too little to say, and how its step begins."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orchestration.acceptance.itself import response
from orchestration.acceptance.itself.block import _is
from orchestration.acceptance.itself.estimate import NAMES as ESTIMATES
from orchestration.acceptance.itself.estimate import estimate
from orchestration.acceptance.itself.motion import NAMES as MOTIONS
from orchestration.acceptance.itself.motion import motion
from orchestration.acceptance.itself.response import Response
from orchestration.acceptance.itself.signals import Signals
from orchestration.acceptance.robustness import Trial
from orchestration.fmu.model import Model, Variable

TIME = np.arange(200.0)
LEVER = np.radians(5.0)


def found(trials) -> dict[str, Trial]:
    return {one.name: one for one in trials}


def test_an_attitude_at_rest_says_nothing_of_the_rate_and_the_words_stand_with_that_requirement():
    of = Signals(TIME, {"R_NB": np.broadcast_to(np.eye(3), (200, 3, 3)), "omega_B": np.zeros((200, 3))})
    one = found(estimate(of, Signals(TIME, {})))[ESTIMATES[0]]
    assert (one.status, one.text) == ("", "it hardly turns in this run")


def test_an_attitude_that_is_never_given_is_no_mirror():
    values = {"R_NB": np.zeros((200, 3, 3)), **dict.fromkeys(("omega_B", "r_N", "v_N"), np.full((200, 3), 4e6))}
    one = found(motion(Signals(TIME, values)))[MOTIONS[0]]
    assert one.status == "failed"
    assert "mirror" not in one.text


@pytest.mark.parametrize(
    ("torque", "words"),
    [
        ((1e-3, 0.0, 0.0), "turns the body on, not back: 0.001 N.m about +x"),
        ((0.2e-3, -1e-3, 0.0), "its torque is about -y, for a turn about +x"),
        ((-0.2e-3, 0.0, 1e-3), "its torque is about +z, for a turn about +x"),
        ((-1e-3, 0.0, 0.2e-3), "the error grows to 20 deg, though its first torque turns it back"),
    ],
)
def test_where_a_step_does_not_settle_its_first_torque_tells_why(torque, words):
    angles = np.zeros((3, 3))
    angles[:, 0] = LEVER, 2 * LEVER, 4 * LEVER
    theirs = Response(TIME[:3], angles, 0, np.array(torque))
    one = response._judged("step", Response(TIME[:3], 0 * angles, 0, -theirs.torque), theirs)
    assert one.status == "failed"
    assert words in one.text


def test_a_step_begins_at_its_angle_about_its_axis_and_turns_with_what_is_held():
    """Without a torque a body keeps its rate: the angle to an attitude that turns steadily stays what it was."""
    rate, h = np.array([0.0, 1e-3, 0.0]), 1.0
    held = Rotation.from_rotvec(rate * np.arange(50.0)[:, None]).as_matrix()
    out = {"tau_cmd_B": np.zeros(3)}
    given = []
    bench = SimpleNamespace(
        step=h, block="law", begun=lambda row, stop: given.append(row) or out, advanced=lambda row: out
    )
    made = response._flown(bench, Signals(TIME[:50], {}), {}, held, np.eye(3), 1)
    assert made.angles == pytest.approx(np.broadcast_to([0.0, LEVER, 0.0], made.angles.shape), abs=1e-12)
    assert given[0]["R_NB"].reshape(3, 3) == pytest.approx(Rotation.from_rotvec([0.0, LEVER, 0.0]).as_matrix())
    assert given[0]["omega_B"] == pytest.approx(rate)


def test_a_block_is_of_a_kind_where_it_has_both_its_inputs_and_its_outputs():
    model = Model("m", {v.name: v for v in (Variable("a", "input"), Variable("b", "output"))})
    for inputs, outputs, same in ((("a",), ("b",), True), (("a", "c"), ("b",), False), (("a",), ("c",), False)):
        assert _is(model, set(inputs), set(outputs)) is same
