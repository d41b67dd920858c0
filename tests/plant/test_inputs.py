"""What the plant's helper inputs stand for, against closed forms and the plant's own outputs."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orchestration import InputError, run

SCENARIO = {
    "name": "helped",
    "step": 1.0,
    "duration": 1.0,
    "blocks": {"plant": {"fmu": "plant", "start": {"dipole_cmd": [0, 0, 0], "wheel_torque_cmd": 0}}},
}


def flown(shared=None, **start):
    entry = {"fmu": "plant", "start": {**SCENARIO["blocks"]["plant"]["start"], **start}}
    return run({**SCENARIO, "shared": shared or {}, "blocks": {"plant": entry}})


def test_an_altitude_is_counted_from_the_equatorial_radius_of_wgs84():
    assert np.linalg.norm(flown(altitude="600 km")["plant.r_N"][0]) == pytest.approx(6978137.0, abs=1e-6)


@pytest.mark.parametrize(
    "start",
    [
        {},
        {"altitude": "800 km", "Q0": {"euler": ["10 deg", "70 deg", "-20 deg"], "sequence": "ZYX"}},
        {"initial_attitude": "q_NB0", "q_NB0": [0.5, 0.5, -0.5, 0.5]},
        {"orbit_start": "position_velocity", "r_N0": [7e6, 1e6, -2e5], "v_N0": [-300.0, 4000.0, 6600.0]},
    ],
)
def test_at_rest_in_lvlh_the_body_turns_with_the_orbit(start):
    result = flown(omega_LVLH_B0=[0, 0, 0], **start)
    r, v = result["plant.r_N"][0], result["plant.v_N"][0]
    expected = result["plant.R_NB"][0].T @ np.cross(r, v) / (r @ r)
    assert np.abs(result["plant.omega_B"][0] - expected).max() < 1e-15


def test_the_rate_of_a_circular_orbit_is_about_minus_y_of_lvlh():
    rate = flown(omega_LVLH_B0=["1 deg/s", 0, 0], orbit_radius=7e6)["plant.omega_B"][0]
    expected = [math.radians(1.0), -math.sqrt(3.986004418e14 / 7e6**3), 0.0]
    assert rate == pytest.approx(expected, abs=1e-15)


def test_an_attitude_by_axis_and_angle_is_that_of_the_matrix():
    result = flown(initial_attitude="q_NB0", q_NB0=[1, 0, 0, 0])
    turned = flown(Q0={"axis": [1, 2, 3], "angle": "50 deg"})
    lvlh = flown()["plant.R_NB"][0]
    expected = lvlh @ Rotation.from_rotvec(np.array([1, 2, 3]) / math.sqrt(14) * math.radians(50.0)).as_matrix()
    assert np.abs(turned["plant.R_NB"][0] - expected).max() < 1e-14
    assert np.abs(result["plant.R_NB"][0] - np.eye(3)).max() < 1e-15


def test_a_value_of_the_block_goes_before_a_shared_one_of_a_helper_and_the_other_way_round():
    assert flown({"altitude": "600 km"}, orbit_radius=7e6).manifest["parameters"]["plant"]["orbit_radius"] == 7e6
    found = flown({"orbit_radius": 7e6}, altitude="600 km").manifest["parameters"]["plant"]["orbit_radius"]
    assert found == 6978137.0


@pytest.mark.parametrize(
    ("below", "above", "radius"),
    [
        ("altitude: 600 km", "orbit_radius: 7000 km", 7e6),
        ("orbit_radius: 7000 km", "altitude: 600 km", 6978137.0),
    ],
)
def test_a_value_of_a_file_goes_before_one_that_a_helper_gives_in_a_file_that_it_extends(
    tmp_path: Path, below, above, radius
):
    start = "blocks:\n  plant:\n    start:\n      "
    own = "name: a\nstep: 1 s\nduration: 1 s\nblocks:\n  plant:\n    fmu: plant\n    start:\n"
    (tmp_path / "below.yaml").write_text(
        f"{own}      dipole_cmd: [0, 0, 0]\n      wheel_torque_cmd: 0\n      {below}\n"
    )
    (tmp_path / "above.yaml").write_text(f"extends: below.yaml\n{start}{above}\n")
    assert run(tmp_path / "above.yaml").manifest["parameters"]["plant"]["orbit_radius"] == radius


def test_shared_values_feed_the_helpers_of_a_block():
    result = flown({"altitude": "600 km", "omega_LVLH_B0": [0, 0, 0]})
    assert result["plant.omega_B"][0][1] == pytest.approx(-math.sqrt(3.986004418e14 / 6978137.0**3), rel=1e-14)


@pytest.mark.parametrize(
    ("start", "message"),
    [
        (
            "altitude: 600 km\n      orbit_radius: 7000 km",
            "altitude: has a start value already, by 'orbit_radius', in line 9",
        ),
        ("altitude: 6 km", "altitude: expected at least 100000 m, found 6000 m (6 km)"),
        ("altitude: 600 kg", "altitude: the unit 'kg' does not fit 'm'"),
        ("altitude: 600 km\n      orbit_start: position_velocity", "altitude: expected orbit_start circular beside it"),
        ("omega_LVLH_B0: 0", "omega_LVLH_B0: expected a list of 3 values, found 0"),
        ("omega_LVLH_B0[1]: 0", "omega_LVLH_B0 is given as a whole"),
        ("altitud: 600 km", "plant has no parameter 'altitud'; did you mean 'altitude'?"),
        (
            "Q0: {axis: [1, 0, 0], angl: 1}",
            "Q0: expected the keys axis and angle, found axis and angl; did you mean 'angle'?",
        ),
    ],
)
def test_a_wrong_input_is_an_error_with_its_line(tmp_path: Path, start, message):
    path = tmp_path / "helped.yaml"
    path.write_text(
        "name: helped\nstep: 1 s\nduration: 1 s\nblocks:\n  plant:\n    fmu: plant\n    start:\n"
        f"      {start}\n      dipole_cmd: [0, 0, 0]\n      wheel_torque_cmd: 0\n"
    )
    with pytest.raises(InputError) as error:
        run(path)
    assert "helped.yaml:8: blocks.plant.start" in str(error.value)
    assert message in str(error.value)
