"""Inputs in another frame are named with their angle; ERFA's precession is the witness of J2000."""

from __future__ import annotations

import math

import erfa
import numpy as np
import pytest

from orchestration.acceptance.polarity.causes import causes_of
from orchestration.acceptance.polarity.frames import EARTH_RATE, of_two, other_frame, readings
from orchestration.acceptance.polarity.ports import Port
from orchestration.fmu.model import Variable
from orchestration.quantities import parse_unit

FRAMES = {"R_NB": "N from B", "omega_B": "B", "r_N": "N", "v_N": "N"}
UNITS = {"R_NB": "1", "omega_B": "rad/s", "r_N": "m", "v_N": "m/s"}
KINDS = {"R_NB": "rotation"}
STEP, COUNT = 0.5, 400


def turn(axis: int, angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    R = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R[[i, j, i, j], [i, j, j, i]] = c, c, -s, s
    return R


class Block:
    """Gives R^T (r x v) / |r|^2 - omega and R^T r / |r|: what a controller of an LVLH attitude makes of its inputs."""

    def play(self, inputs: dict) -> dict:
        R, r, v = inputs["R_NB"].reshape(-1, 3, 3), inputs["r_N"], inputs["v_N"]
        rate = np.cross(r, v) / (r * r).sum(axis=1, keepdims=True)
        in_body = np.einsum("nji,nj->ni", R, rate) - inputs["omega_B"]
        down = np.einsum("nji,nj->ni", R, r) / np.linalg.norm(r, axis=1)[:, None]
        return {"rate": 1e3 * in_body, "down": down}

    class model:
        variables = FRAMES


@pytest.fixture(scope="module")
def flown():
    time = np.arange(COUNT) * STEP
    angle, radius, rate = 1.1e-3 * time, 7e6, 1.1e-3
    tilt = turn(0, 1.2)
    r = radius * np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1) @ tilt.T
    v = radius * rate * np.stack([-np.sin(angle), np.cos(angle), 0 * angle], 1) @ tilt.T
    R = np.array([(turn(2, 0.01 * t) @ turn(1, 0.3 + 0.004 * t)).ravel() for t in time])
    omega = np.stack([0.01 * np.sin(0.05 * time), 0.02 * np.cos(0.03 * time), 0.005 + 0 * time], 1)
    return time, {"R_NB": R, "omega_B": omega, "r_N": r, "v_N": v}


def answers(read, flown):
    return Block().play(flown[1] | read(*flown))


def late(values):
    return np.concatenate([np.repeat(values[:1], 3, 0), values])[: len(values)]


def named(flown, read, changed=None, allowed=lambda every: every):
    """Returns what is named of a block of theirs which reads its inputs so, and whose outputs are changed besides."""
    time, inputs = flown
    variables = {n: Variable(n, "input", shape=(len(v[0]),), frame=FRAMES[n]) for n, v in inputs.items()}
    ports = {
        n: Port("b", n, "input", tuple(range(v.shape[1])), KINDS.get(n, "vector"), parse_unit(UNITS[n]), v.shape[1])
        for n, v in inputs.items()
    }
    theirs = {n: changed(v) if changed else v for n, v in answers(read, flown).items()}
    some = slice(None, None, 20)
    few = {n: v[some] for n, v in inputs.items()}, time[some], {n: v[some] for n, v in theirs.items()}

    def rest(ours):
        made = [causes_of(n, ours[n], v, time, None) for n, v in theirs.items()]
        left = max(np.linalg.norm(one[1]) / np.linalg.norm(v) for one, v in zip(made, theirs.values(), strict=True))
        return tuple(cause for one in made for cause in one[0]), left

    whole = inputs, time, theirs
    sizes = {n: float(np.sqrt((v**2).mean())) for n, v in inputs.items()}
    made = other_frame(
        Block(), allowed(readings(ports, variables, sizes)), few, whole, math.inf, rest if changed else None
    )
    return made if made is None else (*made[0], made[1])


def test_a_position_along_the_axes_of_the_earth_has_its_angle_at_the_start(flown):
    def read(time, inputs):
        turns = np.array([turn(2, 4.0 + EARTH_RATE * t) for t in time])
        return {"r_N": np.einsum("nij,nj->ni", turns, inputs["r_N"])}

    cause, left = named(flown, read)
    assert cause.where == "r_N"
    assert cause.size == pytest.approx(math.degrees(4.0), abs=1e-3)
    assert "turn with the Earth" in cause.text
    assert left < 1e-8


def test_an_orbit_along_the_axes_of_J2000_is_named_with_its_years(flown):
    precession = erfa.bp00(2451545.0, 26.9 * 365.25)[1]

    def read(time, inputs):
        return {n: inputs[n] @ precession.T for n in ("r_N", "v_N")}

    cause, _ = named(flown, read)
    assert cause.where == "r_N and v_N"
    assert "as the equator turns in 26.9 years (J2000 and of date)" in cause.text


@pytest.mark.parametrize(("sign", "words"), [(1.0, "relative to LVLH"), (-1.0, "that of LVLH is added")])
def test_a_rate_relative_to_LVLH_is_named_in_its_direction(flown, sign, words):
    def read(time, inputs):
        R = inputs["R_NB"].reshape(-1, 3, 3)
        r, v = inputs["r_N"], inputs["v_N"]
        orbital = np.cross(r, v) / (r * r).sum(axis=1, keepdims=True)
        return {"omega_B": inputs["omega_B"] + sign * np.einsum("nji,nj->ni", R, orbital)}

    cause, _ = named(flown, read)
    assert cause.where == "omega_B"
    assert words in cause.text
    assert "equally" not in cause.text


@pytest.mark.parametrize(
    ("turned", "where"),
    [
        (lambda time, x: x @ erfa.bp00(2451545.0, 26.9 * 365.25)[1].T, ("r_N", "v_N")),
        (lambda time, x: np.array([turn(2, 4.0 + EARTH_RATE * t) @ y for t, y in zip(time, x, strict=True)]), ("r_N",)),
    ],
    ids=["J2000", "Earth"],
)
def test_a_rate_relative_to_LVLH_is_named_beside_the_frame_of_the_orbit_that_gives_it(flown, turned, where):
    def read(time, inputs):
        orbit = {n: turned(time, inputs[n]) if n in where else inputs[n] for n in ("r_N", "v_N")}
        orbital = np.cross(orbit["r_N"], orbit["v_N"]) / (orbit["r_N"] ** 2).sum(axis=1, keepdims=True)
        rate = inputs["omega_B"] + np.einsum("nji,nj->ni", inputs["R_NB"].reshape(-1, 3, 3), orbital)
        return {n: orbit[n] for n in where} | {"omega_B": rate}

    assert named(flown, read) is None
    orbit, rate, left = named(flown, read, allowed=of_two)
    assert orbit.where == " and ".join(where)
    assert "relative to LVLH" in rate.text
    assert left < 1e-8


def test_a_sensor_that_is_mounted_askew_has_axis_and_angle(flown):
    mounted = turn(2, math.radians(1.5))
    cause, _ = named(flown, lambda time, inputs: {"omega_B": inputs["omega_B"] @ mounted.T})
    assert cause.where == "omega_B"
    assert cause.size == pytest.approx(1.5, abs=1e-4)
    assert "turned by 1.5 deg about (0, 0, 1)" in cause.text


def test_a_frame_and_what_makes_its_output_late_are_named_together(flown):
    def read(time, inputs):
        orbital = np.cross(inputs["r_N"], inputs["v_N"]) / (inputs["r_N"] ** 2).sum(axis=1, keepdims=True)
        return {"omega_B": inputs["omega_B"] + np.einsum("nji,nj->ni", inputs["R_NB"].reshape(-1, 3, 3), orbital)}

    frame, *causes, _ = named(flown, read, late)
    assert "relative to LVLH" in frame.text
    assert {(cause.kind, round(cause.size, 6)) for cause in causes} == {("delay", 3.0)}
    assert named(flown, lambda time, inputs: {"v_N": np.roll(inputs["v_N"], 20, axis=0)}, late) is None


@pytest.mark.parametrize(
    ("read", "kind", "where", "size", "words"),
    [
        (lambda x: {"r_N": x["r_N"] * [1.0, 1.02, 1.0]}, "input gain", "r_N", 0.02, "gains of (1, 1.02, 1)"),
        (lambda x: {"omega_B": x["omega_B"] + [0, 2e-3, 0]}, "input bias", "omega_B", 2e-3, "a bias of (0, 0.002, 0)"),
    ],
    ids=["gain", "bias"],
)
def test_a_gain_or_a_bias_of_an_axis_of_an_input_is_named(flown, read, kind, where, size, words):
    first, left = named(flown, lambda time, inputs: read(inputs))
    assert (first.kind, first.where, first.size) == (kind, where, pytest.approx(size, rel=1e-5))
    assert words in first.text
    assert left < 1e-8


@pytest.mark.parametrize(
    ("changed", "kinds"),
    [
        (lambda values: values + np.array([0.0, 0.02, 0.0]), {"bias"}),
        (lambda values: values * np.array([1.0, 1.3, 1.0]), {"gain"}),
        (lambda values: np.clip(values, *(0.9 * np.abs(values).max() * np.array([-1.0, 1.0]))), {"limit"}),
    ],
    ids=["bias", "gain", "limit"],
)
def test_angles_of_a_frame_are_fitted_beside_a_bias_a_gain_or_a_limit_of_the_outputs(flown, changed, kinds):
    precession = erfa.bp00(2451545.0, 26.9 * 365.25)[1]
    frame, *causes, left = named(
        flown, lambda time, inputs: {n: inputs[n] @ precession.T for n in ("r_N", "v_N")}, changed
    )
    assert "as the equator turns in 26.9 years" in frame.text
    assert {cause.kind for cause in causes} == kinds
    assert left < 1e-8


@pytest.mark.parametrize(
    "read",
    [
        lambda time, inputs: {"omega_B": inputs["omega_B"] + 1e-3 * np.sin(time)[:, None]},
        lambda time, inputs: {"v_N": np.roll(inputs["v_N"], 20, axis=0)},
        lambda time, inputs: {},
    ],
    ids=["a wave", "late", "nothing"],
)
def test_no_frame_is_named_for_what_is_none(flown, read):
    assert named(flown, read) is None
