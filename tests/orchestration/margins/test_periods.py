"""Answers to pulses over whole periods, beside multipliers that are known."""

import json
from dataclasses import replace

import numpy as np
import pytest

from orchestration.margins.floquet import Orbit, Repeated, coordinates
from orchestration.margins.inject import Altered
from orchestration.margins.periods import follow
from tests.commands import orchestrate

from .loops import law, linear, rig, static, toy

HIDDEN = np.array([[0.9, 0.3, 0.0, 0.0], [0.0, 0.8, 0.5, 0.0], [0.1, 0.0, 0.7, 0.3], [0.0, 0.0, 0.0, 0.97]])
DRIVE, SEEN = np.array([[0.0], [0.0], [1.0], [0.02]]), np.eye(4)[:2]
FEEDBACK = np.array([[0.1, 0.0]])


def hidden(feedback=lambda y: -FEEDBACK @ y, kick: float = 1.0):
    """Two of four states are seen; the slowest is not, and moves the others little."""
    return rig(lambda: [linear(HIDDEN, DRIVE, SEEN, kick), law(feedback, 2)])


def exact(gain: float = 1.0) -> np.ndarray:
    values = np.abs(np.linalg.eigvals(HIDDEN - gain * DRIVE @ FEEDBACK @ SEEN))
    return np.sort(values)[::-1]


def followed(loop, period=20, periods=3, **more):
    return follow(loop, coordinates(loop.session.opened.plan, ["plant.y"]), period, periods, 2, **more)


def test_a_slow_hidden_state_shows_in_the_multipliers_of_whole_periods():
    found = followed(hidden(), pulses=6)
    assert found.refused == ""
    assert found.windows[-1].rest < 1e-6
    np.testing.assert_allclose(np.abs(found.windows[0].multipliers[:2]), exact()[:2] ** 20, rtol=1e-4)


def test_the_ratio_of_periods_goes_to_the_largest_multiplier_of_the_altered_loop():
    found = followed(hidden(), period=40, periods=7, altered=Altered(gain=1.5))
    assert found.windows[-1].ratio == pytest.approx(exact(1.5)[0] ** 40, rel=0.01)
    assert found.windows[-1].least <= found.windows[-1].ratio <= found.windows[-1].most


def test_a_loop_that_does_not_repeat_has_no_multipliers_but_the_ratio():
    """Its gain is another at each sample: no map takes the answers of a period to those of the next."""

    def make():
        gains = iter(np.random.default_rng(5).uniform(-4.0, 8.0, 1000))
        return [linear(HIDDEN, DRIVE, SEEN), law(lambda y: -next(gains) * FEEDBACK @ y, 2)]

    found = followed(rig(make))
    assert found.refused == ""
    assert found.windows[-1].rest > 0.1
    assert "no multipliers" in found.lines()[-1]


def test_a_corner_where_the_loop_rests_is_told_with_pulses_of_all_sizes():
    found = followed(hidden(lambda y: -3.0 * FEEDBACK @ np.maximum(y, 0.0), kick=0.0), period=10)
    assert "the loop is not linear here: with pulses of 1e-05 to 0.01" in found.refused
    assert found.lines() == [found.refused]
    assert min(error for _, error in found.tried) > 0.05


def test_the_size_of_the_pulses_is_that_with_the_least_error():
    """With y + y^2 the error of a pulse is that of its size, until rounding."""
    found = followed(hidden(lambda y: -FEEDBACK @ (y + y**2)), period=10)
    sizes, errors = zip(*found.tried, strict=True)
    assert found.size == sizes[int(np.argmin(errors))]
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.3)


def test_multipliers_that_change_with_one_more_instant_are_no_result():
    found = Orbit(["x"], 1.0, np.full((4, 1, 1), 0.9), rest=0.01, flights=9, spread=np.log(2.0))
    assert (found.known, replace(found, spread=0.01).known) == (False, True)
    assert "changes by a factor of 2 with one more instant" in found.verdict
    loop = hidden()
    seen = coordinates(loop.session.opened.plan, ["plant.y"])
    whole = Repeated.of(loop, seen, 40, np.array([1e-3]), segment=2)
    assert (whole.depth, whole.nominal.known) == (2, True)
    assert whole.nominal.spread < 0.05


def test_the_command_follows_periods_and_seeks_the_gain_that_loses_the_loop(tmp_path):
    loop = toy(tmp_path, static("-g * w"))
    options = ("--at", "plant.wheel_torque_cmd", "--when", "1 s", "--orbit", "4 s", "--piece", "0.2 s")
    options = (*options, "--state", "plant.omega_B", "--periods", "3")
    result = orchestrate("margins", loop, *options, "--change", "gain=1..40", "--json")
    assert result.exit_code == 0, result.output
    said = json.loads(result.stdout)
    pole = 1 - 0.8 * 0.1
    assert [one["ratio"] for one in said["windows"]] == [pytest.approx(pole**40, rel=1e-5)] * 2
    (change,) = said["searched"]
    assert change["holds"] <= 1.02 * 2 / 0.08 <= 1.04 * change["lost"]
    assert "|multipliers|: 0.0356" in orchestrate("margins", loop, *options).output


def test_the_sensitivity_of_periods_is_that_of_the_pole(tmp_path):
    """d(40 log(1 - g h))/d log g"""
    loop = toy(tmp_path, static("-g * w"))
    options = ("--at", "plant.wheel_torque_cmd", "--when", "1 s", "--orbit", "4 s", "--piece", "0.2 s")
    options = (*options, "--state", "plant.omega_B", "--periods", "2", "--sensitivity", "controller.gain")
    result = orchestrate("margins", loop, *options, "--json")
    assert result.exit_code == 0, result.output
    said = json.loads(result.stdout)
    assert said["sensitivity"]["controller.gain"] == pytest.approx(-40 * 0.08 / (1 - 0.08), rel=1e-3)
    assert said["sensitivity_error"]["controller.gain"] < 0.1
    wrong = orchestrate("margins", loop, *options[:-1], "controller.gian")
    assert (wrong.exit_code, "--sensitivity controller.gian" in wrong.output) == (2, True)
