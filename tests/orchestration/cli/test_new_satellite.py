"""`orchestrate new satellite`: what it asks for, what it writes, and that what it writes flies."""

import json
from pathlib import Path

import numpy as np
import pytest

import orchestration
from orchestration.scenario import template
from tests.commands import orchestrate

pytestmark = pytest.mark.isolate

GIVEN = {
    "inertia": {"diagonal": [0.0419, 0.0419, 0.0067]},
    "dipole_max": "0.3 A.m2",
    "wheel_torque_max": "0.3 mN.m",
    "wheel_momentum_max": "2 mN.m.s",
    "wheel_axis": [0, 1, 0],
    "orbit_radius": "6878 km",
    "inclination": "97.4 deg",
    "body_width": "10 cm",
    "body_length": "34 cm",
    "body_axis": "z",
}


def made(folder, **changes):
    """Of GIVEN with changes, without a value that is None."""
    values = {name: value for name, value in {**GIVEN, **changes}.items() if value is not None}
    sets = [part for name, value in values.items() for part in ("--set", f"{name}={json.dumps(value)}")]
    return orchestrate("new", "satellite", str(folder), *sets)


def test_the_files_it_writes_fly_that_satellite(tmp_path):
    assert made(tmp_path / "cube").exit_code == 0
    scenario = orchestration.load(tmp_path / "cube" / "tumble.yaml")
    data = {key: value for key, value in scenario.source.data.items() if key not in ("expect", "figures")}
    result = orchestration.run({**data, "duration": 2.0})
    momentum = np.diag([0.0419, 0.0419, 0.0067]) @ result["plant.omega_B"][0]
    assert result["plant.R_NB"][0].T @ result["plant.H_N"][0] == pytest.approx(momentum, rel=1e-9)
    assert np.linalg.norm(result["plant.r_N"][0]) == pytest.approx(6878e3)
    assert np.abs(result["plant.dipole"]).max() == pytest.approx(0.3)


@pytest.mark.parametrize(("folder", "name"), [("cube", "cube"), ("2026", "2026"), ("-my cube", "my_cube")])
def test_a_satellite_is_called_as_its_folder(tmp_path, folder, name):
    made(tmp_path / folder)
    assert orchestration.load(tmp_path / folder / "tumble.yaml").name == name


@pytest.mark.parametrize(("radius", "period"), [("6878 km", 5676.8), (7578e3, 6565.1)])
def test_the_period_is_that_of_the_orbit(tmp_path, radius, period):
    """Of Kepler's third law, by hand with mu = 398600.4418 km3/s2."""
    made(tmp_path / "cube", orbit_radius=radius)
    assert orchestration.load(tmp_path / "cube" / "tumble.yaml").cycle.period == pytest.approx(period, abs=0.1)


def test_the_orbit_is_stated_by_its_height_or_by_its_radius(tmp_path):
    assert made(tmp_path / "cube", orbit_radius=None, altitude="500 km").exit_code == 0
    scenario = orchestration.load(tmp_path / "cube" / "tumble.yaml")
    assert scenario.cycle.period == pytest.approx(5677.0, abs=0.1)  # Kepler's third law at 6878.137 km
    asked = made(tmp_path / "other", orbit_radius=None).stderr
    assert '--set "altitude=500 km"' in asked
    assert "orbit_radius" not in asked
    both = made(tmp_path / "other", altitude="500 km")
    told = "--set altitude, --set orbit_radius: expected one of them, since orbit_radius follows from altitude\n"
    assert (both.exit_code, both.stderr) == (2, told)


def test_the_drag_body_lies_along_the_axis_that_is_given(tmp_path):
    made(tmp_path / "cube")
    assert "body_axis: z\n" in (tmp_path / "cube" / "satellite.yaml").read_text()


def test_without_its_values_it_says_which_it_needs(tmp_path):
    result = orchestrate("new", "satellite", str(tmp_path))
    assert result.exit_code == 2
    needed = [name for name, entry in template.read("satellite").values.items() if "example" in entry]
    assert needed
    for name in needed:
        assert f'  --set "{name}=' in result.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("satellite", "--set", "inertai=1"), "--set inertai: satellite has no such value; did you mean 'inertia'?"),
        (("allocator", "--set", "mass=1"), "--set: 'allocator' has no values to set; only satellite has"),
        (("satellite", "--lang", "c"), "--lang: a satellite is data alone and has no project"),
        (("satellite", "--link"), "--link: a satellite is data alone and has no project"),
        (("satellite", "--scenario", "x.yaml"), "--scenario: a satellite is data alone and has no project"),
        (("satelite",), "there is no block 'satelite'; did you mean 'satellite'?"),
    ],
)
def test_what_it_does_not_know_is_refused(arguments, message):
    result = orchestrate("new", *arguments)
    assert (result.exit_code, result.stdout) == (2, "")
    assert message in result.stderr


def test_files_that_are_there_are_kept(tmp_path):
    made(tmp_path)
    before = (tmp_path / "satellite.yaml").read_text()
    result = made(tmp_path, dipole_max="1 A.m2")
    assert result.exit_code == 2
    assert f"{Path(tmp_path, 'satellite.yaml')} is there already" in result.stderr
    assert (tmp_path / "satellite.yaml").read_text() == before


@pytest.mark.parametrize(
    ("altitude", "message"),
    [
        ("500", "--set altitude: expected 150 km to 1970 km, found 500 (500 m)"),
        ("-100 km", "--set altitude: expected 150 km to 1970 km, found -100 km (-100000 m)"),
        ("500 kg", "--set altitude: the unit 'kg' "),
        ("500 deg", "--set altitude: the unit 'deg' "),
    ],
)
def test_a_height_that_is_no_height_is_refused_by_its_name(tmp_path, altitude, message):
    result = made(tmp_path / "cube", orbit_radius=None, altitude=altitude)
    assert (result.exit_code, result.stdout) == (2, "")
    assert message in result.stderr


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"dipole_max": "0.3 N.m"}, "--set dipole_max: shared.dipole_max: the unit"),
        ({"inertia": [1, 2, 3]}, "--set inertia: shared.J_B: expected 3 rows of 3 values, found a list of 3"),
        ({"inertia": [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]}, "J_B: plant refuses it: expected"),
        ({"wheel_axis": [1, 1, 0]}, "wheel_axis: plant refuses it: expected"),
        ({"name": "../cube"}, "name: "),
        ({"body_axis": "up"}, "--set body_axis: shared.body_axis: expected one of"),
        ({"orbit_radius": "68r78 km"}, "--set orbit_radius: unknown unit 'r78 km'"),
        ({"orbit_radius": "-5 km"}, "--set orbit_radius=-5 km: the value of period cannot be computed from it"),
        (
            {"step": "0.04 s"},
            "--set control_period: blocks.controller.start.control_period: expected a multiple of the step",
        ),
        ({"step": "0.3 s", "control_period": "1.5 s"}, "tumble.yaml:70: record.interval: expected a multiple"),
    ],
)
def test_a_value_that_no_block_takes_is_told_at_once_and_nothing_is_written(tmp_path, changes, message):
    result = made(tmp_path / "cube", **changes)
    assert result.exit_code in (2, 3)
    assert message in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_each_file_uses_values_that_are_declared_and_all_are_used():
    found = template.read("satellite")
    text = "".join(path.read_text() for path in found.folder.glob("*.yaml") if path.name != template.VALUES)
    expressions = " ".join(entry.get("expression", "") for entry in found.values.values())
    assert {name for name in found.values if f"@{name}@" in text or name in expressions} == set(found.values)
