"""Moment of sunlight on plates, against closed forms; the native flavour against the other one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

import plant
from plant.drag import AXES, Plates, octagonal_cylinder
from plant.solar_pressure import PRESSURE, SolarPressure, at_distance
from tests.blocks import inputs, parameters
from tests.native.driver import Instance

WIDTH, LENGTH, CENTRE = 0.65, 0.8, np.array([0.02, -0.03, 0.05])


def directions(n=20, seed=4):
    drawn = np.random.default_rng(seed).normal(size=(n, 3))
    return drawn / np.linalg.norm(drawn, axis=1)[:, None]


def test_the_pressure_of_sunlight_at_the_earth_is_that_of_the_textbooks():
    assert at_distance(149597870700.0) == pytest.approx(4.54e-6, rel=1e-3)
    assert at_distance(2 * 149597870700.0) == pytest.approx(PRESSURE / 4)


def test_a_black_body_feels_the_force_on_its_shadow_at_its_middle():
    """The divergence theorem: about its geometric centre a symmetric body that absorbs all feels no moment."""
    for axis in AXES:
        plates = octagonal_cylinder(WIDTH, LENGTH, axis)
        light = SolarPressure(plates, CENTRE, 0.0, 0.0)
        for s in directions():
            force = -PRESSURE * (plates.areas @ np.maximum(plates.normals @ s, 0.0)) * s
            np.testing.assert_allclose(light.moment(s, PRESSURE), np.cross(-CENTRE, force), rtol=1e-9, atol=1e-20)


@pytest.mark.parametrize(("specular", "diffuse", "factor"), [(0, 0, 1), (1, 0, 2), (0, 1, 5 / 3), (0.3, 0.3, 1.5)])
def test_a_plate_that_faces_the_sun_feels_one_to_two_times_the_pressure_by_how_it_reflects(specular, diffuse, factor):
    """A mirror turns the light's momentum back; a matt surface, by Lambert's law, gives 2/3 of it along its normal."""
    cosine_law = quad(lambda a: 2 * math.cos(a) ** 2 * math.sin(a), 0, math.pi / 2)[0]
    assert factor == pytest.approx(1 + specular + cosine_law * diffuse)
    plate = Plates(np.array([[1.0, 0.0, 0.0]]), np.array([0.4]), np.array([[0.3, 0.2, -0.1]]))
    light = SolarPressure(plate, np.zeros(3), specular, diffuse)
    expected = np.cross([0.3, 0.2, -0.1], [-PRESSURE * 0.4 * factor, 0.0, 0.0])
    np.testing.assert_allclose(light.moment(np.array([1.0, 0.0, 0.0]), PRESSURE), expected, rtol=1e-12)
    assert not light.moment(np.array([-1.0, 0.0, 0.0]), PRESSURE).any()


def test_a_mirror_at_an_angle_is_pushed_along_its_normal():
    plate = Plates(np.array([[1.0, 0.0, 0.0]]), np.array([0.4]), np.array([[0.0, 0.2, 0.0]]))
    s = np.array([math.cos(0.7), math.sin(0.7), 0.0])
    expected = np.cross([0.0, 0.2, 0.0], [-2 * PRESSURE * 0.4 * math.cos(0.7) ** 2, 0.0, 0.0])
    np.testing.assert_allclose(SolarPressure(plate, np.zeros(3), 1.0, 0.0).moment(s, PRESSURE), expected, rtol=1e-12)


LIT = {
    "solar_pressure": True,
    "step_max": 100.0,
    "drag": False,
    "gravity_gradient": False,
    "body_axis": "y",
    "solar_specular": 0.5,
}


@pytest.mark.parametrize("axis", AXES)
def test_momentum_in_flight_changes_by_the_impulse_of_sunlight_and_not_in_the_shadow(axis):
    start = {**LIT, "body_axis": axis, "omega_B0": [0.0, 0.0, 0.0], "center_of_mass_B": CENTRE}
    p, u = parameters("plant", **start), inputs("plant")
    plant.check(p)
    with Instance("plant") as native:
        for name, value in start.items():
            native.set(name, value)
        native.initialize()
        x, out, seen = plant.start(p, u), None, set()
        for k in range(60):
            before, R = plant.outputs(x, u, p), x.R
            x, out = plant.step(x, u, p, 100.0)
            native.step(100.0 * k, 100.0)
            if before.sunlight != out.sunlight:
                continue
            seen.add(out.sunlight)
            there = np.array(p.sun.at(x.t - 50.0)) - 0.5 * (before.r_N + out.r_N)
            distance = np.linalg.norm(there)
            tau_B = p.light.moment(R.T @ (there / distance), out.sunlight * at_distance(distance))
            np.testing.assert_allclose(out.H_N - before.H_N, 100.0 * (R @ tau_B), rtol=0.02, atol=1e-13)
        assert seen == {0.0, 1.0}
        np.testing.assert_allclose(native.get("H_N"), out.H_N, rtol=1e-7, atol=1e-16)
    assert np.linalg.norm(out.H_N) > 1e-4 * PRESSURE


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"solar_specular": 1.5}, "solar_specular: expected 0 to 1"),
        ({"solar_specular": 0.6, "solar_diffuse": 0.6}, "solar_specular + solar_diffuse: expected at most 1"),
        ({"center_of_mass_B": [0.0, 0.5, 0.0]}, "center_of_mass_B: expected inside the body"),
        ({"body_width": 0.0}, "body_width: expected 0.001 to 100 m"),
    ],
)
def test_an_impossible_surface_is_refused_by_name(changes, name):
    with pytest.raises(ValueError, match=name.replace("+", r"\+")):
        plant.check(parameters("plant", **{**LIT, **changes}))
