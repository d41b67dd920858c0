"""Faults in words: the times at which they act, and units."""

import json
from pathlib import Path

import numpy as np

import orchestration
from tests.commands import orchestrate

BLOCKS = {
    "plant": {"fmu": "plant", "start": {"dipole_cmd": [0, 0, 0], "wheel_torque_cmd": 0}},
    "judge": {"fmu": "plant_judge"},
}
WIRES = [f"plant.{name} -> judge.{name}" for name in ("R_NB", "omega_B", "r_N", "v_N")]


def test_faults_have_the_times_in_force_and_the_units_of_their_numbers():
    result = orchestration.run(
        {
            "name": "faulty",
            "step": 0.5,
            "duration": 10,
            "blocks": BLOCKS,
            "connections": WIRES,
            "timeline": [{"at": 1.2, "set": {"plant.wheel_torque_cmd": "1 mN.m"}}],
            "faults": [
                {"at": 2.1, "until": 4.6, "set": "plant.disturbance_torque_B = [2e-3, 0, 0]"},
                {"at": 5, "set": "plant.dipole_cmd = [1 A.m2, 0 A.m2, 0 A.m2]"},
                {"at": 6, "bias": "plant.omega_B", "by": [0.1, 0, 0]},
                {"at": 7, "cut": "judge.omega_B"},
            ],
        }
    )
    assert result.manifest["faults"] == [
        "plant.disturbance_torque_B = [2e-3, 0, 0] N.m, from 2.5 s to 5 s",
        "plant.dipole_cmd = [1 A.m2, 0 A.m2, 0 A.m2], from 5 s on",
        "plant.omega_B biased by [0.1, 0, 0] rad/s, from 6 s on",
        "judge.omega_B cut, from 7 s on",
    ]
    assert result.manifest["timeline"] == ["at 1.5 s: plant.wheel_torque_cmd = 1 mN.m"]


def test_the_summary_and_the_manifest_tell_the_faults(loop):
    text = (
        loop.read_text()
        + "faults:\n  - {at: 1 s, until: 1.5 s, cut: motor.speed}\n  - {at: 0.5 s, set: regulator.gain = -2}\n"
    )
    loop.write_text(text)
    shown = orchestrate(loop)
    assert "fault: motor.speed cut, from 1 s to 1.5 s\nfault: regulator.gain = -2, from 0.5 s on\n" in shown.output
    manifest = json.loads(Path("results/loop/manifest.json").read_text())
    assert manifest["faults"] == ["motor.speed cut, from 1 s to 1.5 s", "regulator.gain = -2, from 0.5 s on"]
    again = orchestration.run(manifest["scenario"])
    np.testing.assert_array_equal(again["motor.speed"], orchestration.run(loop)["motor.speed"])
    shorter = orchestrate(loop, "--duration", "0.8")
    assert shorter.exit_code == 0
    assert "note: does not happen, since the run ends before: motor.speed cut, from 1 s to 1.5 s" in shorter.stderr
    assert json.loads(Path("results/loop/manifest.json").read_text())["faults"] == manifest["faults"][1:]
    assert "fault: motor" not in shorter.output.replace(shorter.stderr, "")
    at_end = orchestrate(loop, "--duration", "0.5")
    assert at_end.exit_code == 0
    assert "note: does not happen, since the run ends before: regulator.gain = -2, from 0.5 s on" in at_end.stderr
