"""`orchestrate margins` on a motor and its regulator, real FMUs of FMI 2.0: an integrator with a sampled gain."""

import csv
import json

import numpy as np
import pytest

from tests.commands import orchestrate
from tests.orchestration import fmus

GAIN, STEP = 0.8, 0.1


@pytest.fixture
def loop(tmp_path):
    fmus.write_pair(tmp_path)
    (tmp_path / "loop.yaml").write_text(
        f"""\
name: loop
step: {STEP}
duration: 1
isolation: none
blocks:
  motor: {{fmu: motor.fmu}}
  regulator: {{fmu: regulator.fmu, start: {{gain: -{GAIN}, enabled: true}}}}
connections: [motor.speed -> regulator.speed, regulator.voltage -> motor.voltage]
""",
        "utf-8",
    )
    return tmp_path / "loop.yaml"


def test_the_margins_of_a_loop_of_small_fmus_are_those_of_the_closed_form(loop):
    """L = g h/(z - 1): |L| = g h/(2 sin(w h/2)), and its phase is -(pi + w h)/2."""
    out = loop.parent / "out"
    result = orchestrate("margins", loop, "--at", "motor.voltage", "--when", "0.5 s", "--out", out)
    assert result.exit_code == 0, result.output
    assert "motor.voltage" in result.output
    found = json.loads((out / "margins.json").read_text())["channels"]["motor.voltage"]
    crossover = 2 / STEP * np.arcsin(GAIN * STEP / 2)
    assert found["gain_up"]["value"] == pytest.approx(2 / (GAIN * STEP), rel=0.01)
    assert found["gain_down"]["value"] == 0.0
    assert found["phase"]["omega"] == pytest.approx(crossover, rel=0.01)
    assert found["phase"]["value"] == pytest.approx((np.pi - crossover * STEP) / 2, abs=np.radians(0.3))
    with (out / "response.csv").open() as file:
        rows = np.array([[float(v) for v in row.values()] for row in csv.DictReader(file)])
    z = np.exp(1j * rows[:, 0] * STEP)
    np.testing.assert_allclose(rows[:, 1], 20 * np.log10(np.abs(GAIN * STEP / (z - 1))), atol=0.1)
    np.testing.assert_allclose(rows[:, 3] + 1j * rows[:, 4], 1 / (1 + GAIN * STEP / (z - 1)), atol=0.01)
    assert (out / "margins.png").stat().st_size > 10_000


def test_a_loop_without_margins_has_status_1_and_the_reason(loop):
    unstable = orchestrate(
        "margins", loop, "--at", "motor.voltage", "--set", "regulator.gain=0.8", "--window", "60 s", "--json"
    )
    assert unstable.exit_code == 1
    assert "unstable" in json.loads(unstable.stdout)["refused"]
    wrong = orchestrate(
        "margins", loop, "--at", "motor.voltage", "--set", "regulator.gain=0.8", "--change", "motor.x=1..2"
    )
    assert (wrong.exit_code, "--change motor.x: motor has no parameter 'x'" in wrong.output) == (2, True), wrong.output


def test_wrong_options_are_refused_with_their_place(loop):
    for options, message in (
        (("--at", "motor.volts"), "--at motor.volts: motor has no input or output 'volts'; did you mean 'voltage'?"),
        (("--at", "motor.hot"), "--at motor.hot: motor.hot is boolean; expected a real signal"),
        (("--at", "regulator.samples"), "is not connected, so no loop passes there"),
        (("--at", "motor.voltage", "--when", "-1 s"), "--when -1 s: expected a time of 0 s to 1e9 s, found -1 s"),
        (("--at", "motor.voltage", "--when", "5 kg"), "--when 5 kg: "),
        (("--at", "motor.voltage", "--window", "0 s"), "--window: expected at least 16 samples, 1.6 s, found 0 s"),
        (("--at", "motor.voltage", "--periods", "3"), "--periods has an effect with --orbit only"),
        (("--at", "motor.voltage", "--model", "motor"), "--at has no effect with --model"),
        (("--at", "motor.voltage", "--orbit", "4 s", "--lost", "expectations"), "--lost has no effect with --orbit"),
        (("--at", "motor.voltage", "--state", "motor.hot"), "--state motor.hot: "),
    ):
        result = orchestrate("margins", loop, *options)
        assert result.exit_code == 2
        assert message in result.output


@pytest.mark.thorough
def test_multipliers_of_the_loop_are_those_of_its_pole(loop):
    options = ("--at", "motor.voltage", "--when", "1 s", "--orbit", "4 s", "--state", "motor.speed")
    result = orchestrate(
        "margins", loop, *options, "--sensitivity", "regulator.gain", "--change", "gain=1..40", "--json"
    )
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    (change,) = found["searched"]  # the pole is at -1 with a gain of 2/(g h)
    assert change["holds"] <= 1.01 * 2 / (GAIN * STEP) <= 1.02 * change["lost"]
    pole = 1 - GAIN * STEP
    assert found["logs"] == [[pytest.approx(40 * np.log(pole), rel=1e-6), 0.0]]
    assert found["rest"] < 1e-6
    # d(40 log(1 - g h))/d log g
    assert found["sensitivity"]["regulator.gain"] == pytest.approx(-40 * GAIN * STEP / pole, rel=0.01)
    assert "of motor.speed" in orchestrate("margins", loop, *options).output
    refused = orchestrate("margins", loop, *options[:6])
    assert (refused.exit_code, "expected --state" in refused.output) == (2, True)


def test_the_least_change_that_loses_the_loop_stands_beside_its_margin(loop):
    out = loop.parent / "out"
    result = orchestrate("margins", loop, "--at", "motor.voltage", "--change", "gain=1..40", "--out", out)
    assert result.exit_code == 0, result.output
    (found,) = json.loads((out / "margins.json").read_text())["searched"]
    assert found["holds"] <= 1.01 * 2 / (GAIN * STEP) <= 1.01 * found["lost"] * 1.01
    assert "margin of all channels alike 25" in result.output
