"""Force and moment of the air on plates, against closed forms."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import plant
from plant.drag import AXES, Drag, Plates, octagonal_cylinder
from plant.orbit import lvlh
from tests.blocks import inputs, parameters

WIDTH, LENGTH, CD, DENSITY = 0.65, 0.8, 2.2, 3.1e-13
CENTRE = np.zeros(3)


def flows(n=40, seed=11):
    directions = np.random.default_rng(seed).normal(size=(n, 3))
    return 7500.0 * directions / np.linalg.norm(directions, axis=1)[:, None]


def force(plates, v_B, density):
    """(3,) N: half density C_d area |v|^2 against the flow, of the area that each plate turns to it."""
    exposed = np.maximum(plates.normals @ v_B, 0.0) @ plates.areas
    return -0.5 * density * CD * exposed * v_B


def vertices(axis):
    """The 16 corners of the octagonal prism."""
    radius = 0.5 * WIDTH / math.cos(math.pi / 8.0)
    corners = [
        (s * LENGTH / 2.0, radius * math.cos(a), radius * math.sin(a))
        for s, a in product((-1.0, 1.0), math.pi / 8.0 + math.pi / 4.0 * np.arange(8))
    ]
    along = AXES.index(axis)
    order = [along, (along + 1) % 3, (along + 2) % 3]
    out = np.zeros((16, 3))
    out[:, order] = corners
    return out


def projected_area(direction, axis):
    """Area of the prism's shadow on a plane normal to the flow, from its corners alone."""
    basis = np.linalg.svd(direction[None])[2][1:]
    return ConvexHull(vertices(axis) @ basis.T).volume


def test_a_plate_feels_half_rho_cd_area_speed_squared_at_its_pressure_centre():
    plate = Plates(np.array([[1.0, 0.0, 0.0]]), np.array([0.4]), np.array([[0.3, 0.2, -0.1]]))
    centre = np.array([0.02, -0.03, 0.05])
    head_on = Drag(plate, centre, CD)
    q = 0.5 * DENSITY * CD * 0.4 * 7500.0**2
    v = np.array([7500.0, 0.0, 0.0])
    np.testing.assert_allclose(force(plate, v, DENSITY), [-q, 0.0, 0.0], rtol=1e-14)
    np.testing.assert_allclose(head_on.moment(v, DENSITY), np.cross([0.28, 0.23, -0.15], [-q, 0.0, 0.0]), rtol=1e-13)


def test_a_plate_at_an_angle_loses_its_cosine_and_one_turned_away_feels_nothing():
    plate = Plates(np.array([[1.0, 0.0, 0.0]]), np.array([0.4]), np.array([[0.3, 0.0, 0.0]]))
    drag = Drag(plate, np.array([0.0, 0.1, 0.0]), CD)
    v = 7500.0 * np.array([0.5, math.sqrt(0.75), 0.0])
    q = 0.5 * DENSITY * CD * 0.4 * 7500.0**2 * 0.5
    expected = np.cross([0.3, -0.1, 0.0], -q * v / 7500.0)
    np.testing.assert_allclose(drag.moment(v, DENSITY), expected, rtol=1e-12)
    assert not drag.moment(-v, DENSITY).any()


@pytest.mark.parametrize("axis", AXES)
def test_force_is_that_of_the_bodys_shadow(axis):
    plates = octagonal_cylinder(WIDTH, LENGTH, axis)
    for v in (*flows(), *(7500.0 * np.eye(3))):
        area = projected_area(v / 7500.0, axis)
        np.testing.assert_allclose(
            force(plates, v, DENSITY), -0.5 * DENSITY * CD * area * 7500.0 * v, rtol=1e-11, atol=1e-18
        )


def test_plates_close_the_body_and_enclose_its_volume():
    for axis in AXES:
        plates = octagonal_cylinder(WIDTH, LENGTH, axis)
        hull = ConvexHull(vertices(axis))
        assert plates.areas.sum() == pytest.approx(hull.area, rel=1e-12)
        np.testing.assert_allclose(plates.areas @ plates.normals, 0.0, atol=1e-15)
        # Divergence theorem: the sum of A r n^T is the volume times the identity.
        np.testing.assert_allclose(
            (plates.areas[:, None] * plates.centres).T @ plates.normals, hull.volume * np.eye(3), atol=1e-14
        )


@pytest.mark.parametrize("axis", AXES)
def test_about_its_geometric_centre_the_body_feels_no_moment_whatever_the_flow(axis):
    """By the divergence theorem and the body's symmetry about its centre."""
    plates = octagonal_cylinder(WIDTH, LENGTH, axis)
    drag = Drag(plates, CENTRE, CD)
    for v in flows():
        arm = np.linalg.norm(drag.moment(v, DENSITY)) / np.linalg.norm(force(plates, v, DENSITY))
        assert arm < 1e-15


@pytest.mark.parametrize("axis", AXES)
def test_moment_is_the_force_at_the_geometric_centre_about_the_centre_of_mass(axis):
    centre = np.array([0.02, -0.03, 0.05])
    plates = octagonal_cylinder(WIDTH, LENGTH, axis)
    drag = Drag(plates, centre, CD)
    for v in flows():
        expected = np.cross(-centre, force(plates, v, DENSITY))
        np.testing.assert_allclose(drag.moment(v, DENSITY), expected, rtol=1e-11, atol=1e-22)


def test_moment_is_linear_in_density_and_quadratic_in_speed():
    drag = Drag(octagonal_cylinder(WIDTH, LENGTH, "x"), np.array([0.02, -0.03, 0.05]), CD)
    v = flows(1)[0]
    np.testing.assert_allclose(drag.moment(3.0 * v, 2.0 * DENSITY), 18.0 * drag.moment(v, DENSITY), rtol=1e-14)


@pytest.mark.parametrize(("ahead", "restores"), [(0.05, True), (-0.05, False)])
def test_a_body_whose_centre_of_mass_leads_is_a_weather_vane(ahead, restores):
    drag = Drag(octagonal_cylinder(WIDTH, LENGTH, "x"), np.array([ahead, 0.0, 0.0]), CD)
    for turn in ([0.0, 0.03, 0.0], [0.0, 0.0, 0.03], [0.0, -0.02, 0.01]):
        v_B = Rotation.from_rotvec(turn).as_matrix().T @ np.array([7500.0, 0.0, 0.0])
        assert (drag.moment(v_B, DENSITY) @ turn < 0.0) == restores


def test_body_axis_moves_the_cylinder_cyclically():
    v, centre = flows(1)[0], np.array([0.02, -0.03, 0.05])
    first = Drag(octagonal_cylinder(WIDTH, LENGTH, "x"), centre, CD).moment(v, DENSITY)
    for k, axis in enumerate(AXES):
        turned = Drag(octagonal_cylinder(WIDTH, LENGTH, axis), np.roll(centre, k), CD)
        np.testing.assert_allclose(turned.moment(np.roll(v, k), DENSITY), np.roll(first, k), rtol=1e-13)


def test_the_air_turns_with_the_earth():
    """|v - omega x r|^2 = v^2 - 2 omega r v cos i + (omega r cos latitude)^2 on a circular orbit."""
    p = parameters("plant", inclination=math.radians(35.0))
    r, v = p.orbit_radius, math.sqrt(p.gravitational_parameter / p.orbit_radius)
    sidereal = 7.292115e-5  # rad/s; GMST, relative to the equinox, is faster by 1e-7 of it
    for t in (0.0, 500.0, 1447.0, 4000.0):
        flow, _ = p.air.flow(t)
        position, velocity = p.orbit.position_velocity(t)
        latitude = math.asin(math.sin(p.inclination) * math.sin(v / r * t))
        squared = v**2 - 2.0 * sidereal * r * v * math.cos(p.inclination) + (sidereal * r * math.cos(latitude)) ** 2
        assert flow @ flow == pytest.approx(squared, rel=5e-8)
        np.testing.assert_allclose(flow, velocity - np.cross([0.0, 0.0, sidereal], position), atol=1e-3)


def test_drag_factor_scales_the_moment_and_not_the_density():
    u = inputs("plant")
    whole, scaled = (parameters("plant", drag_factor=f) for f in (1.0, 0.02))
    a, b = (plant.outputs(plant.start(p, u), u, p) for p in (whole, scaled))
    np.testing.assert_allclose(b.tau_drag_B, 0.02 * a.tau_drag_B, rtol=1e-13)
    assert b.density == a.density > 0.0


def test_without_drag_moment_and_density_are_zero():
    u, p = inputs("plant"), parameters("plant", drag=False, f107=math.nan)
    plant.check(p)
    out = plant.outputs(plant.start(p, u), u, p)
    assert not out.tau_drag_B.any()
    assert out.density == 0.0


def test_the_bodys_inertial_momentum_changes_by_the_impulse_of_the_reported_moment():
    # Order 2: its impulse over a step is the trapezium of the reported moment.
    p = parameters(
        "plant", gravity_gradient=False, drag_factor=1e4, omega_B0=[0.02, -0.03, 0.01], h_w0=0.002, integrator_order=2
    )
    u = inputs("plant")
    x, h = plant.start(p, u), 0.1
    out = plant.outputs(x, u, p)
    first, impulse, before = out.H_N, np.zeros(3), out.R_NB @ out.tau_drag_B
    for _ in range(100):
        x, out = plant.step(x, u, p, h)
        now = out.R_NB @ out.tau_drag_B
        impulse, before = impulse + 0.5 * h * (before + now), now
    assert np.linalg.norm(impulse) > 1e-5
    np.testing.assert_allclose(out.H_N - first, impulse, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize(("order", "measured"), [(2, 2.0), (4, 4.0), (6, 6.2)])
def test_the_integrators_order_is_kept_under_the_drag_of_a_high_solar_maximum(order, measured):
    def attitude(order, h):
        rate = [0.08, -0.1, 0.07]
        p = parameters("plant", f107=230.0, f107_average=230.0, integrator_order=order, step_max=100.0, omega_B0=rate)
        u = inputs("plant", dipole_cmd=[3.0, -4.0, 5.0])
        x = plant.start(p, u)
        for _ in range(round(48.0 / h)):
            x, _ = plant.step(x, u, p, h)
        return x.R

    exact = attitude(6, 0.25)
    coarse, fine = (np.abs(attitude(order, h) - exact).max() for h in (2.0, 1.0))
    assert math.log2(coarse / fine) == pytest.approx(measured, abs=0.15)


@pytest.mark.parametrize(("f107", "lowest", "highest"), [(70.0, 5e-9, 2e-8), (150.0, 5e-8, 2e-7), (230.0, 2e-7, 1e-6)])
def test_the_moment_in_flight_is_far_below_the_papers_1e_5(f107, lowest, highest):
    p = parameters("plant", f107=f107, f107_average=f107)
    sizes = []
    for t in np.arange(0.0, 5791.0, 60.0):
        v_N, density = p.air.flow(t)
        sizes.append(np.linalg.norm(p.surface.moment(lvlh(*p.orbit.position_velocity(t)).T @ v_N, density)))
    assert lowest < max(sizes) < highest


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("drag_factor", -1.0, "0 to"),
        ("drag_coefficient", math.nan, "0 to 10"),
        ("body_width", 0.0, "0.001 to 100 m"),
        ("body_length", math.inf, "0.001 to 100 m"),
        ("center_of_mass_B", [0.0, 0.4, 0.0], "inside the body"),
        ("center_of_mass_B", [math.nan, 0.0, 0.0], "inside the body"),
        ("body_axis", "w", "x, y, z"),
    ],
)
def test_an_impossible_body_is_refused_by_name_and_range(name, value, expected):
    with pytest.raises(ValueError, match=rf"{name}: expected .*{expected}.*, found "):
        plant.check(parameters("plant", **{name: value}))
    plant.check(parameters("plant", drag=False, **{name: value}))
