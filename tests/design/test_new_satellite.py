"""`orchestrate new satellite`: what it asks for, what it writes, and that what it writes flies."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

import orchestration
from design import new_satellite, template
from design.sheet import box, followed, wheel_axes
from orchestration.live.system import checked
from orchestration.session.read import read
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
    momentum = 1.05 * np.diag([0.0419, 0.0419, 0.0067]) @ result["plant.omega_B"][0]  # the true inertia is 5% larger
    assert result["plant.R_NB"][0].T @ result["plant.H_N"][0] == pytest.approx(momentum, rel=1e-3)
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
    told = "--set altitude, --set orbit_radius: expected one of them, since each follows from the other\n"
    assert (both.exit_code, both.stderr) == (2, told)


def test_the_drag_body_lies_along_the_axis_that_is_given(tmp_path):
    made(tmp_path / "cube")
    assert "body_axis: z\n" in (tmp_path / "cube" / "satellite.yaml").read_text()


def test_without_its_values_it_says_which_it_needs(tmp_path):
    result = orchestrate("new", "satellite", str(tmp_path))
    assert result.exit_code == 2
    needed = [name for name, entry in new_satellite.templates().values.items() if "example" in entry]
    assert needed
    for name in needed:
        assert f'  --set "{name}=' in result.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("satellite", "--set", "inertai=1"), "--set inertai: satellite has no such value; did you mean 'inertia'?"),
        (("allocator", "--set", "mass=1"), "No such option '--set'"),
        (("satellite", "--lang", "c"), "No such option '--lang'"),
        (("satellite", "--set", "wheels=two"), "expected these values"),
        (("satellite", "--set", "sensors=x.yaml"), "expected these values"),
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
        ({"dipole_max": "0.3 N.m"}, "--set dipole_max: the unit 'N.m' does not fit"),
        ({"wheel_axis": [0, 0, 0]}, "--set wheel_axis: expected a direction, found [0, 0, 0]"),
        ({"dipole_max": ["0.3 A.m2", 0.1, 0.1]}, "remedy: rod_limits is the share of dipole_max that each rod gives"),
        ({"inertia": [1, 2]}, "--set inertia: shared.J_B: expected 3 rows of 3 values, found a list of 2"),
        ({"inertia": [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]}, "J_B: plant refuses it: expected"),
        ({"wheel_axis": [1, 1, 0]}, "wheel_axis: plant refuses it: expected"),
        ({"name": "../cube"}, "name: "),
        (
            {"epoch": "11.02.2027 09:30"},
            "--set epoch: shared.epoch: expected UTC in ISO 8601, such as 2009-08-10T12:00:00Z, found",
        ),
        ({"body_axis": "up"}, "--set body_axis: expected one of x, y, z, found up"),
        ({"orbit_radius": "68r78 km"}, "--set orbit_radius: unknown unit 'r78 km'"),
        ({"orbit_radius": "-5 km"}, "--set orbit_radius: expected 6528137 m to 8348137 m, found -5 km (-5000 m)"),
        ({"step": "30 ms"}, "--set step: record.interval: expected a multiple of the base step, 0.03 s"),
        ({"duration": "0.5 orbits"}, "--set duration: expect[1].after: 8515.212 s lies after the end of the run"),
        ({"wheels": "two"}, "--set wheels: expected none, one, three axes, pyramid 35 deg or a list of axes"),
        ({"wheels": "[[1, 0, 0], [0, 1, 0], [1, 1, 0]]"}, "--set wheels: expected three or four axes of three numbers"),
        ({"wheels": "[[1, 0, 0], [0, 1, 0]]"}, "--set wheels: expected three or four axes of three numbers that span"),
        (
            {"wheels": "pyramid 95 deg"},
            "--set wheels: expected an angle of 0 to 90 deg, such as pyramid 35 deg, found pyramid 95 deg",
        ),
        ({"sensors": "x.yaml"}, "--set sensors: expected cubesat, star tracker, perfect or the path of a file, found"),
        (
            {"step": "0.04 s"},
            "--set control_period: blocks.controller.start.control_period: expected a multiple of the step",
        ),
        ({"step": "0.3 s", "control_period": "1.5 s"}, "--set step: record.interval: expected a multiple"),
    ],
)
def test_a_value_that_no_block_takes_is_told_at_once_and_nothing_is_written(tmp_path, changes, message):
    result = made(tmp_path / "cube", **changes)
    assert result.exit_code in (2, 3)
    assert message in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_each_file_uses_values_that_are_declared_and_all_are_used():
    found = new_satellite.templates()
    text = "".join(path.read_text() for path in found.folder.glob("*.yaml") if path.name != template.VALUES)
    followed = {"mass", "body_depth", "orbit_radius", "altitude", "wheels", "sensors"}
    assert {name for name in found.values if f"@{name}@" in text} == set(found.values) - followed


@pytest.mark.thorough
def test_a_mass_in_the_place_of_inertia_is_that_of_a_homogeneous_box(tmp_path):
    """Closed form: of 4 kg, 10 by 10 by 34 cm, m (a2 + b2)/12."""
    assert made(tmp_path / "cube", inertia=None, mass="4 kg").exit_code == 0
    J = orchestration.load(tmp_path / "cube" / "tumble.yaml").shared["J_B"]
    assert J["diagonal"] == pytest.approx([0.0418667, 0.0418667, 0.0066667], rel=1e-4)
    assert orchestration.load(tmp_path / "cube" / "tumble.yaml").data.mass == 4.0
    assert box(12.0, 1.0, 2.0, "y") == pytest.approx([5.0, 2.0, 5.0])
    assert box(12.0, 1.0, 2.0, "y", 3.0) == pytest.approx([13.0, 10.0, 5.0])  # 1 along x, 2 along y, 3 along z
    assert made(tmp_path / "six", inertia=None, mass="4 kg", body_depth="5 cm").exit_code == 0
    J = orchestration.load(tmp_path / "six" / "tumble.yaml").shared["J_B"]
    assert J["diagonal"] == pytest.approx(
        [4 * (0.05**2 + 0.34**2) / 12, 4 * (0.1**2 + 0.34**2) / 12, 4 * 0.0125 / 12], rel=1e-4
    )


def test_names_of_choices_are_taken_in_any_case_and_what_counts_for_nothing_is_said(tmp_path):
    """A body of 5 cm has its centre of mass half as far from the middle; one value for its width is told as such."""
    small = {"body_width": "5 cm", "body_depth": "9 cm"}
    result = made(tmp_path / "cube", body_axis="Z", wheels="None", sensors="CUBESAT", **small)
    assert result.exit_code == 0, result.stderr
    text = (tmp_path / "cube" / "satellite.yaml").read_text()
    assert "center_of_mass_B: [10 mm, 10 mm, 5 mm]" in text
    assert "body_width: 5 cm       # assumed on all sides, though it is 9 cm deep" in text
    assert "with wheels=none wheel_torque_max, wheel_momentum_max, wheel_axis count for nothing" in result.stderr


@pytest.mark.parametrize(
    "inertia",
    [[0.042, 0.042, 0.007], ["420 kg.cm2", "0.042 kg.m2", 0.007], {"diagonal": ["0.042 kg.m2", 0.042, 0.007]}],
)
def test_moments_are_a_diagonal_with_or_without_units_and_the_assumed_error_follows(inertia):
    given = GIVEN | {"inertia": inertia}
    values, notes = followed(new_satellite.templates(), given)
    assert values["inertia"]["diagonal"] == (inertia if isinstance(inertia, list) else inertia["diagonal"])
    assert np.array(values["J_error_B"]) == pytest.approx(np.diag([0.0021, 0.0021, 0.00035]))
    assert "a twentieth" in notes["J_error_B"]


def test_values_stand_as_they_were_given_and_notes_say_what_follows(tmp_path):
    made(tmp_path / "cube", orbit_radius=None, altitude="500 km")
    text = (tmp_path / "cube" / "satellite.yaml").read_text()
    assert "  altitude: 500 km  # a circular orbit of 5676.978 s\n" in " ".join(text.split(" ")).replace("      ", "  ")
    assert "dipole_max: 0.3 A.m2" in text
    assert "13.2 uN.m in a field of 44 uT, which turn the body by a radian in 47.8 s" in text
    assert "full in 6.67 s" in text
    assert "the rods take it away in 152 s" in text
    assert "assumed, a hundredth of the rods': up to 229 nN.m; measure it" in text


@pytest.mark.parametrize(
    ("wheels", "sensors"),
    [
        ("none", "perfect"),
        ("three axes", "cubesat"),
        ("pyramid 35 deg", "star tracker"),
        ("[[2, 0, 0], [0, 1, 0], [0, 0.6, 0.8]]", "perfect"),
    ],
)
def test_sets_of_wheels_and_sensors_fly_their_first_sample(tmp_path, wheels, sensors):
    """The command flies it itself, and writes nothing where a block refuses it."""
    absent = {"wheel_torque_max": None, "wheel_momentum_max": None} if wheels == "none" else {}
    result = made(tmp_path / "cube", wheels=wheels, sensors=sensors, wheel_axis=None, **absent)
    assert result.exit_code == 0, result.stderr
    scenario = orchestration.load(tmp_path / "cube" / "tumble.yaml")
    assert ("PERFECT" in scenario.description) == (sensors == "perfect")
    assert scenario.blocks["plant"].fmu == ("plant" if wheels == "none" else "plant_wheels")
    assert any(entry.signal == "plant.h_w" for entry in scenario.expect) == (wheels != "none")
    if wheels.startswith("["):
        files = [yaml.safe_load((tmp_path / "cube" / f"{n}.yaml").read_text("utf-8")) for n in ("tumble", "satellite")]
        assert files[0]["shared"]["wheels"] == 3
        np.testing.assert_allclose(
            files[1]["shared"]["wheel_axis"][:3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.6, 0.8]]
        )


def test_the_axes_of_a_pyramid_have_the_angle_and_give_equal_torque_about_the_edges():
    axes = np.array(wheel_axes("pyramid 30 deg"))
    assert axes[:, 2] == pytest.approx(np.full(4, 0.5))
    assert axes.T @ axes == pytest.approx(np.diag([1.5, 1.5, 1.0]))
    assert np.array(wheel_axes("pyramid")).T @ np.array(wheel_axes("pyramid")) == pytest.approx(np.eye(3) * 4 / 3)


def test_a_file_of_own_sensors_is_flown(tmp_path):
    (tmp_path / "own.yaml").write_text("blocks: {sensors: {start: {attitude_noise: 0.3 deg}}}\n")
    assert made(tmp_path / "cube", sensors=str(tmp_path / "own.yaml")).exit_code == 0
    scenario = orchestration.load(tmp_path / "cube" / "tumble.yaml")
    assert scenario.blocks["sensors"].start["attitude_noise"] == "0.3 deg"


def test_help_lists_the_values_with_their_defaults():
    result = orchestrate("new", "satellite", "-h")
    assert result.exit_code == 0, result.stderr
    text = " ".join(result.stdout.split())
    assert "residual_dipole_B" in text
    assert "[cubesat]" in text


def test_asked_in_the_terminal_it_takes_answers_and_leaves_what_is_not_needed(tmp_path):
    answers = ["none", "", "4 kg", "10 cm", "34 cm", "z", "0.3 A.m2", "perfect", "500 km", "97.4 deg"]
    result = orchestrate("new", "satellite", str(tmp_path / "cube"), "--interactive", input="\n".join(answers) + "\n")
    assert result.exit_code == 0, result.stderr
    text = (tmp_path / "cube" / "satellite.yaml").read_text()
    assert f"review it:     orchestrate review {tmp_path / 'cube' / 'tumble.yaml'}" in result.stdout
    assert "of a homogeneous body of 4 kg" in text
    assert "wheel_momentum_max: 1e-9 N.m.s" in text


def test_asked_in_the_terminal_it_asks_again_for_what_it_cannot_take(tmp_path):
    answers = [
        "seven",
        "One",
        "0.3 mN.m",
        "",
        "",
        "4",
        "4 kg",
        "",
        "10 cm",
        "34 cm",
        "z",
        "0.3 A.m2",
        "",
        "0.3 mN.m",
        "2 mN.m.s",
    ]
    answers += ["[0, 1, 0]", "sextant", "CubeSat", "500", "", "500 km", "97.4 deg"]
    result = orchestrate("new", "satellite", str(tmp_path / "cube"), "--interactive", input="\n".join(answers) + "\n")
    assert result.exit_code == 0, result.stderr
    assert "expected 150 km to 1970 km, found 500 (500 m)" in result.stderr
    assert "expected three moments or three rows of three, found 0.3 mN.m" in result.stderr
    text = (tmp_path / "cube" / "satellite.yaml").read_text()
    assert "altitude: 500 km" in text
    assert "wheel_axis: [0, 1, 0]" in text


def test_what_is_not_plausible_is_named_and_written_all_the_same(tmp_path):
    result = made(tmp_path / "cube", inertia={"diagonal": [42, 42, 7]}, control_period="0.5 s")
    assert (tmp_path / "cube" / "satellite.yaml").exists()
    assert "in g.m2 it would fit" in result.stderr


def test_a_goal_beyond_all_errors_is_refused_and_numbers_without_a_unit_are_named(tmp_path):
    result = made(tmp_path / "cube", goal=5)
    assert (result.exit_code, result.stderr) == (
        2,
        "--set goal: expected 0.0001 deg to 180 deg, found 5 (5 rad); remedy: a unit, as in 180 deg\n",
    )
    said = made(tmp_path / "cube", goal=0.1, omega_B0=[0.02, "1 deg/s", 0], inertia=None, mass=4).stderr
    assert "numbers without a unit were taken in SI units:" in said
    assert all(one in " ".join(said.split()) for one in ("goal 0.1 rad", "mass 4 kg", "[0.02, 1 deg/s, 0] rad/s"))


@pytest.mark.parametrize("wheels", ["one", "three axes"])
def test_its_live_page_has_sliders_and_faults_and_its_figures_show_the_start(tmp_path, wheels):
    assert made(tmp_path / "mine", wheels=wheels).exit_code == 0
    scenario = orchestration.load(tmp_path / "mine" / "tumble.yaml")
    checked(scenario)
    assert len(scenario.live.sliders) == 4
    assert [fault.name for fault in scenario.live.faults][:2] == ["rod 1 dead", "wheel stuck"]
    assert scenario.figures[0].window is not None


def test_what_is_not_plausible_is_named_of_a_satellite_that_is_refused_too(tmp_path):
    """Rods that are a thousand times too strong need a shorter control period than there is."""
    given = [f"--set={value}" for value in ("inertia={diagonal: [0.042, 0.042, 0.007]}", "dipole_max=300 A.m2")]
    given += [f"--set={value}" for value in ("wheels=none", "altitude=500 km", "inclination=97.4 deg")]
    given += [f"--set={value}" for value in ("body_width=10 cm", "body_length=34 cm", "body_axis=z")]
    result = orchestrate("new", "satellite", tmp_path / "strong", *given)
    assert result.exit_code == 2
    assert "dipole_max is too large for J_B" in result.stderr
    assert not (tmp_path / "strong").exists()


def test_a_wheel_that_stays_full_in_the_hold_is_told(tmp_path):
    """What no wheel brings beyond its limit is no expectation."""
    given = [f"--set={value}" for value in ("mass=4 kg", "dipole_max=0.3 A.m2", "altitude=500 km", "body_axis=z")]
    given += [f"--set={value}" for value in ("inclination=97.4 deg", "body_width=10 cm", "body_length=34 cm")]
    given += ["--set=wheel_torque_max=0.3 mN.m", "--set=wheel_momentum_max=2 mN.m.s"]
    assert orchestrate("new", "satellite", tmp_path / "own", *given).exit_code == 0
    source = read(tmp_path / "own" / "tumble.yaml")
    (expected,) = (entry for entry in source.data["expect"] if entry["signal"] == "plant.h_w")
    assert (expected["after"], expected["always"]) == ("1.5 orbits", {"within": "0.0018 N.m.s"})
    full = source.with_start("plant.h_w0", "2 mN.m.s").with_value("duration", "2 s", "test")
    full = full.with_entry(("expect",), [{**expected, "after": "1 s"}])
    assert not orchestration.run(orchestration.load(full)).passed
