"""A 3U whose wheel is strong beside its rods, as many have, across the orbit, on the sensors of a CubeSat."""

import numpy as np
import pytest

import orchestration
from orchestration.session.read import read
from tests.commands import orchestrate

pytestmark = pytest.mark.fly

SHEET = {
    "mass": "3.5 kg",
    "dipole_max": "0.1 A.m2",
    "wheel_torque_max": "1 mN.m",
    "wheel_momentum_max": "10 mN.m.s",
    "wheel_axis": "[0, 1, 0]",
    "altitude": "500 km",
    "inclination": "97.4 deg",
    "body_width": "10 cm",
    "body_length": "34 cm",
    "body_axis": "z",
}
OMEGA = [0.013181922, -0.013850258, 0.067143771]
Q0 = [
    [0.758298788, -0.321535558, 0.567095964],
    [0.626738153, 0.120187534, -0.769905348],
    [0.179394080, 0.939238969, 0.292656633],
]


def test_a_loaded_wheel_off_its_axis_is_not_brought_to_rest_in_the_body(tmp_path):
    """Of this tumble the plan was lost at 1776 s, with 2.7 mN m s in the wheel, and the body turned at 3.2 deg/s."""
    sets = [part for name, value in SHEET.items() for part in ("--set", f"{name}={value}")]
    assert orchestrate("new", "satellite", str(tmp_path / "strong"), *sets).exit_code == 0
    source = read(tmp_path / "strong" / "tumble.yaml").without([("expect",), ("figures",), ("live",)])
    starts = {"plant.omega_B0": OMEGA, "plant.Q0": Q0, "sensors.seed": 1}
    flown = orchestration.run(source, starts, duration="2000 s")
    late = flown.time > 900.0
    assert set(flown["controller.phase"][late]) == {2}
    assert np.linalg.norm(flown["plant.omega_B"][late], axis=1).max() < np.radians(0.5)
    assert np.abs(flown["plant.h_w"]).max() < 4e-3
