"""Plausibility: ten planted mistakes are named, and none in the satellites of the project."""

import math
from pathlib import Path

import numpy as np
import pytest

import orchestration
from design.plausible import findings, gyro, satellite
from evidence.satellites.classes import CLASSES, VARIANTS
from orchestration.session.read import read

ALL = {**CLASSES, **VARIANTS}


def scenario(goal=None, **values):
    """Of a 3U, with values in the place of its own."""
    source = read(Path("scenarios/flight_cubesat.yaml"))
    for name, value in values.items():
        source = source.with_start(name, value)
    if "dipole_max" in values:
        source = source.with_start("controller.dipole_max", values["dipole_max"])
    if goal:
        limit = {"name": "goal", "signal": "judge.attitude_error", "always": {"below": goal}}
        source = source.with_entry(("expect",), [limit])
    return orchestration.load(source)


PLANTED = [
    ({"body_length": "34 m"}, "340 times as large along one axis"),
    ({"J_B": {"diagonal": [41.9, 41.9, 6.67]}}, "in g.m2 it would fit"),
    ({"J_B": {"diagonal": [419, 419, 66.7]}}, "in kg.cm2 it would fit"),
    ({"J_B": {"diagonal": [0.0419, 0.0419, 0.1]}}, "1.19 times the sum of the two others"),
    ({"body_axis": "x"}, "body_axis x of a long body"),
    ({"body_length": "34 m"}, "10 to 6000 kg/m3"),
    ({"center_of_mass_B": ["1 cm", "1 cm", "12 cm"]}, "center_of_mass_B is 120 mm off the middle along z"),
    ({"dipole_max": "0.3e-3 A.m2"}, "rods of 0.0003 A.m2 turn this body by a radian in"),
    ({"wheel_torque_max": "0.3 N.m"}, "the wheel is full after 0.00667 s"),
    ({"wheel_momentum_max": "2 N.m.s"}, "the rods are too weak for the wheel"),
    ({"plant.omega_B0": [2, -3, 2]}, "omega_B0 is 236 deg/s"),
    ({"plant.residual_dipole_B": [0.2, -0.1, 0.3]}, "residual dipole"),
    ({"rod_limits": [1, 1, 0.02]}, "rod 3 gives at most 0.006 A.m2, the strongest 0.3 A.m2"),
    ({"rod_axes": [[1, 0, 0], [0.999, 0.0447101778, 0], [0, 0, 1]]}, "is 2.56 deg from the plane of the two others"),
    ({"wheel_inertia": "1e-9 kg.m2"}, "the wheel, full, turns at 1.91e+07 rpm"),
    ({"dipole_max": "3 A.m2"}, "a rod gives 3 A.m2 in a body of 4"),
    ({"wheel_torque_max": "3 mN.m"}, "the wheel is full after 0.667 s"),
    ({"wheel_inertia": "6e-3 kg.m2"}, "has an inertia of 0.006 kg.m2; expected at most 0.0005 kg.m2"),
    ({"sensors.wheel_momentum_noise": "0.02 mN.m.s"}, "the noise of the wheel's momentum"),
    ({"goal": "0.05 deg"}, "an attitude error of 0.05 deg is expected"),
]


@pytest.mark.parametrize(("changes", "named"), PLANTED, ids=[named[:30] for _, named in PLANTED])
def test_a_planted_mistake_is_named(changes, named):
    found = [str(finding) for finding in findings(scenario(**changes))]
    assert any(named in text for text in found), found


def test_no_mistake_is_seen_in_the_scenarios_of_the_project():
    """Those of sets of wheels among them."""
    paths = sorted(Path("scenarios").glob("*.yaml"))
    assert {"flight_three_wheels", "flight_pyramid", "flight_pyramid_planned"} <= {path.stem for path in paths}
    found = {path.stem: [str(f) for f in findings(orchestration.load(path))] for path in paths}
    assert {name: texts for name, texts in found.items() if texts} == {}


def test_ten_mistakes_are_planted_and_a_dozen_satellites_have_none():
    assert len(PLANTED) >= 10
    assert len(ALL) >= 12


@pytest.mark.parametrize(
    ("name", "factors", "named"),
    [
        ("wheel_torque_max", [1e3, 1e3, 1e3, 1e3], "each of wheels 1, 2, 3, 4 is full after 0.01 s"),
        ("wheel_torque_max", [1, 1, 1e-3, 1], "wheel 3 is full after 1e+04 s"),
        ("wheel_momentum_max", [1e3, 1e3, 1e3, 1e3], "the rods are too weak for the wheel"),
        ("wheel_momentum_max", [1e-4, 1e-4, 1e-4, 1e-4], "holds 3e-06 N.m.s"),
    ],
)
def test_a_mistake_in_a_set_of_wheels_is_named(name, factors, named):
    source = read(Path("scenarios/flight_pyramid.yaml"))
    stated = {"wheel_torque_max": 3e-3, "wheel_momentum_max": 30e-3}[name]
    loaded = orchestration.load(source.with_start(name, [factor * stated for factor in factors]))
    assert any(named in str(finding) for finding in findings(loaded))


@pytest.mark.parametrize("name", list(ALL))
def test_no_mistake_is_seen_in_the_satellites_of_the_evidence(name):
    one = ALL[name]
    values = {
        "J_B": {"diagonal": list(one.moments)},
        "dipole_max": one.dipole_max,
        "wheel_torque_max": one.wheel_torque_max,
        "wheel_momentum_max": one.wheel_momentum_max,
        "wheel_inertia": max(5e-4 * one.wheel_momentum_max, 1e-12),
        "wheel_axis": list(np.array(one.wheel_axis) / np.linalg.norm(one.wheel_axis)),
        "rod_axes": one.rod_axes,
        "body_width": one.size[0],
        "body_length": one.size[1],
        "body_axis": one.axis,
    }
    if not one.has_wheel:  # which has to bear its disturbances itself
        values |= {"plant.residual_dipole_B": [0, 0, 0], "plant.disturbance_torque_B": [one.disturbance(False), 0, 0]}
    assert [str(f) for f in findings(scenario(**values))] == []


def test_a_mass_bounds_the_inertia_of_what_fits_into_the_body():
    """All of 4 kg in the edges of 10 by 10 by 34 cm have 4 (0.1^2 + 0.34^2)/4 kg m2 across."""
    light = [str(finding) for finding in findings(scenario(), mass=1.0)]
    assert any("kg.m2 of 1 kg within 0.1 by 0.1 by 0.34 m" in text for text in light)
    assert findings(scenario(), mass=4.0) == []
    heavy = [str(finding) for finding in findings(scenario(), mass=4000.0)]
    assert "1.18e+06 kg/m3" in heavy[0]
    assert "in g it would fit" in heavy[0]


def test_rods_alone_are_held_against_the_disturbances_of_a_goal():
    """J n^2 of a 1U at 500 km by hand: 2.2e-3 kg m2 and 1.107e-3 rad/s make 2.7e-9 N m."""
    small = {"J_B": {"diagonal": [2.3e-3, 2.3e-3, 2e-3]}, "dipole_max": 0.2, "body_length": "11 cm"}
    alone = {**small, "wheel_torque_max": 1e-9, "wheel_momentum_max": 1e-9, "plant.residual_dipole_B": [2e-3, 0, 0]}
    found = [str(finding) for finding in findings(scenario(goal="5 deg", **alone))]
    assert any("there is no wheel" in text and "at most 5.4e-09 N.m" in text for text in found), found
    with_a_wheel = findings(scenario(goal="5 deg", **{**alone, "wheel_torque_max": 1e-4, "wheel_momentum_max": 1e-3}))
    assert not any("there is no wheel" in str(finding) for finding in with_a_wheel)


def test_the_mass_of_the_file_counts_as_one_that_is_given():
    source = read(Path("scenarios/flight_cubesat.yaml"))
    light = orchestration.load(source.with_entry(("data",), {"mass": "1000 g"}))
    assert findings(light) == findings(scenario(), mass=1.0) != []
    assert findings(light, mass=4.0) == []
    with pytest.raises(orchestration.InputError, match=r"data\.mass: .*kg, or text such as '4 kg'"):
        orchestration.load(source.with_entry(("data",), {"mass": "4 m"}))


def test_disturbances_are_those_of_closed_forms():
    s = satellite(scenario(**{"plant.residual_dipole_B": [0.003, 0.0, 0.004]}))
    causes = s.disturbances()
    n = math.sqrt(3.986004418e14 / 6878e3**3)
    J = s.p.J_B
    assert causes["gravity gradient"] == pytest.approx(1.5 * n**2 * (J[0, 0] - J[2, 2]), rel=1e-9)
    assert causes["residual dipole"] == pytest.approx(0.005 * 6e-5 * (6371.2 / 6878) ** 3, rel=1e-9)
    tried = []
    for t in np.linspace(0.0, 5600.0, 29):
        flow, density = s.p.air.flow(t)
        for R in np.eye(3)[[[0, 1, 2], [1, 2, 0], [2, 0, 1]]]:
            tried.append(np.linalg.norm(s.p.surface.moment(R @ flow, density)))
    assert 0.3 * causes["drag"] < max(tried) < causes["drag"]


def test_what_is_found_alike_of_several_wheels_is_said_once():
    source = read(Path("scenarios/flight_pyramid.yaml"))
    wheels = [2.0, 2.0, 2.0, 1.9]  # N m s, which the rods of 0.6 N m s empty in more than half an orbit
    source = source.with_start("wheel_momentum_max", wheels).with_start("plant.dipole_max", 5.0)
    found = [f.what for f in findings(orchestration.load(source)) if "momentum of" in f.what]
    assert [text.split(" away")[0] for text in found] == [
        "the rods take the momentum of each of wheels 1, 2, 3",
        "the rods take the momentum of wheel 4",
    ]


def without_a_gyro(path="scenarios/flight_cubesat.yaml", **values):
    source = read(Path(path))
    for name, value in values.items():
        source = source.with_start(name, value)
    return source.with_entry(("faults",), [{"freeze": "sensors.omega_B_measured", "at": "100 s"}])


def test_without_a_gyro_the_turn_about_the_field_is_open_until_a_polar_orbits_field_has_turned():
    """The field of a dipole turns twice as far as the satellite on a polar orbit: by a radian in 1/(2 n)."""
    s = satellite(orchestration.load(without_a_gyro()))
    n = math.sqrt(3.986004418e14 / s.p.orbit.semi_major_axis**3)
    angle = 0.5 * 1e-7 / (np.trace(s.p.J_B) / 3.0) / (2.0 * n) ** 2
    assert gyro.open_turn(s, 1e-7) == pytest.approx(angle, rel=0.1)
    earth = math.asin(6371.0 / (s.p.orbit.semi_major_axis / 1e3))
    assert gyro.eclipse(s) == pytest.approx(2.0 * earth / n, rel=0.05)  # at noon and midnight through its axis
    found = [f for f in findings(orchestration.load(without_a_gyro())) if "without its gyro" in f.what]
    assert len(found) == 1


@pytest.mark.parametrize("rate_source", ["gyro", "dynamics"])
def test_a_lost_gyro_is_named_where_torques_are_large_or_the_estimator_is_told_so(rate_source):
    """flight_estimated drifted by 2 to 16 deg without its gyro (docs/how/health.md), flight_without_gyro is held."""
    quiet = {"plant.residual_dipole_B": [0, 0, 0], "plant.disturbance_torque_B": [0, 0, 0], "plant.drag": False}
    quiet |= {"plant.solar_pressure": False, "estimator.rate_source": rate_source}

    def named(source):
        return any("without its gyro" in f.what for f in findings(orchestration.load(source)))

    assert named(without_a_gyro(**quiet, **{"estimator.momentum_random_walk": "6e-6 N.m.s"}))
    assert not named(without_a_gyro(**quiet, **{"estimator.momentum_random_walk": "5e-7 N.m.s"}))
    healthy = without_a_gyro(**{"estimator.rate_source": rate_source}).without([("faults",)])
    assert named(healthy) is (rate_source == "dynamics")
    assert not named(without_a_gyro("scenarios/flight_pyramid_estimated.yaml"))
