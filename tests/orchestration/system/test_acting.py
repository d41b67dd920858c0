"""Faults in words: the times at which they act, and units."""

import orchestration

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
