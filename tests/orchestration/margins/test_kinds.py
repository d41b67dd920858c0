"""The same loop of small FMUs, native, foreign and of Python, and loops that have no margins."""

import json

import numpy as np
import pytest

from tests.commands import orchestrate
from tests.orchestration import fmus, vendor

from .loops import STEP, static, toy

GAIN = 0.8
LAWS = {
    "saturated": ("np.clip(-100.0 - w, -1e-3, 1e-3)", "open here, saturated"),
    "limit cycle": ("-np.sign(w)", "limit cycle|switches|not linear"),
    "noise": ("-g * w + np.random.default_rng().normal(0.0, 0.1)", "noise"),
    "quantized": ("-g * 0.05 * np.round(w / 0.05)", "quantized|limit cycle|switches"),
}


def pair(folder, regulator):
    fmus.write_pair(folder)
    vendor.write(folder, runnable=True)
    (folder / "loop.yaml").write_text(
        f"""\
name: loop
step: {STEP}
isolation: none
duration: 1
blocks:
  motor: {{fmu: motor.fmu}}
  regulator: {{{regulator}, start: {{gain: -{GAIN}, enabled: true}}}}
connections: [motor.speed -> regulator.speed, regulator.voltage -> motor.voltage]
""",
        "utf-8",
    )
    return folder / "loop.yaml"


LOOPS = {
    "native": (lambda folder: pair(folder, "fmu: regulator.fmu"), "motor.voltage"),
    "foreign": (
        lambda folder: pair(folder, "fmu: vendor.fmu, interface: regulator.fmu, map: mapping.yaml"),
        "motor.voltage",
    ),
    "python": (lambda folder: toy(folder, static("-g * w"), GAIN), "plant.wheel_torque_cmd"),
}


def found(loop, port, *options):
    result = orchestrate("margins", loop, "--at", port, "--json", "--out", loop.parent / "out", *options)
    assert result.stdout, result.output
    return result.exit_code, json.loads(result.stdout)


@pytest.mark.parametrize("kind", LOOPS)
def test_native_foreign_and_python_blocks_have_the_margins_of_the_closed_form(tmp_path, kind):
    """L = g h/(z - 1)."""
    write, port = LOOPS[kind]
    status, said = found(write(tmp_path), port)
    assert (status, said["refused"]) == (0, None)
    m, crossover = said["channels"][port], 2 / STEP * np.arcsin(GAIN * STEP / 2)
    assert 20 * np.log10(m["gain_up"]["value"] / (2 / (GAIN * STEP))) == pytest.approx(0.0, abs=0.2)
    assert np.degrees(m["phase"]["value"] - (np.pi - crossover * STEP) / 2) == pytest.approx(0.0, abs=1.0)


def test_a_loop_is_measured_from_its_first_step_on(tmp_path):
    status, said = found(toy(tmp_path, static("-g * w")), "plant.wheel_torque_cmd", "--when", "0 s")
    assert (status, said["refused"], said["when"]) == (0, None, STEP)
    m = said["channels"]["plant.wheel_torque_cmd"]
    assert 20 * np.log10(m["gain_up"]["value"] / (2 / (GAIN * STEP))) == pytest.approx(0.0, abs=0.2)


@pytest.mark.parametrize("law", LAWS)
def test_a_loop_without_margins_gives_the_reason_and_no_number(tmp_path, law):
    expression, reason = LAWS[law]
    status, said = found(toy(tmp_path, static(expression)), "plant.wheel_torque_cmd", "--window", "25 s")
    assert (status, said["channels"], said["together"]) == (1, {}, None)
    assert any(part in said["refused"] for part in reason.split("|")), said["refused"]


def test_a_block_that_refuses_large_pulses_is_given_smaller_ones(tmp_path):
    """The rate is 0.92^k without a pulse, and the law refuses one that differs by more than 1e-5."""
    text = static("-g * w").replace(
        "    w, g", "    if abs(inputs.omega_B[0] - 0.92 ** round(t / 0.1)) > 1e-5: raise ValueError\n    w, g"
    )
    status, said = found(toy(tmp_path, text), "plant.wheel_torque_cmd", "--change", "gain=1..0.5")
    assert (status, said["refused"]) == (0, None), said
    m = said["channels"]["plant.wheel_torque_cmd"]
    assert m["amplitude"] <= 1e-4
    assert 20 * np.log10(m["gain_up"]["value"] / (2 / (GAIN * STEP))) == pytest.approx(0.0, abs=0.2)


def test_the_noise_that_loses_the_hold_is_found(tmp_path):
    """The noise w(t) = g sin(t) on the torque moves the rate by g at most, and the hold is below 2 rad/s."""
    law = static("-w - g * np.sin(t)")
    loop = toy(tmp_path, law, 0.01)
    with loop.open("a", encoding="utf-8") as file:
        file.write("expect: [{name: slow, signal: 'plant.omega_B[1]', after: 10 s, always: {within: 2 rad/s}}]\n")
    loop.write_text(loop.read_text("utf-8").replace("duration: 1", "duration: 30"), "utf-8")
    options = ("--when", "0 s", "--change", "controller.gain=1..1000", "--lost", "expectations")
    status, said = found(loop, "plant.wheel_torque_cmd", *options)
    assert status == 0, said
    (change,) = said["searched"]
    # The rate is g/|i + 1| where it has settled, but for the sampling.
    assert 0.01 * change["holds"] <= 2 * np.sqrt(2) * 1.1
    assert 0.01 * change["lost"] >= 2 * np.sqrt(2) * 0.9
