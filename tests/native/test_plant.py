"""The native plant at the edges of its parameters: starts of the orbit, dates, rods and limits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import plant
from tests.plant.motion import checked, command

from .direct import Direct
from .driver import Instance, Refused

MU = 3.986004418e14
FREE = {"drag": False, "orbit_start": "position_velocity"}


def started(**changes: Any) -> Instance:
    it = Instance("plant")
    for name, value in changes.items():
        it.set(name, value)
    it.initialize()
    return it


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"field_degree": 0}, "field_degree"),
        ({"field_degree": 14}, "field_degree"),
        ({"rod_gain": [1.0, -2.1, 1.0]}, "rod_gain[2]"),
        ({"rod_gain": [1.0, 1.0, 2.1]}, "rod_gain[3]"),
        ({"rod_duty": -0.1}, "rod_duty"),
        ({"rod_duty": 1.1}, "rod_duty"),
        ({"orbit_radius": 6378137.0 + 120e3}, "orbit_radius"),  # below 150 km there is no density
        ({"field_model": "wmm2025", "epoch": "2031-01-01T00:00:00Z"}, "epoch"),
        ({**FREE, "r_N0": [0.0, 0.0, 0.0]}, "r_N0"),
        # Nearly along r: of such an orbit J2 would turn the plane faster than the satellite flies.
        ({**FREE, "r_N0": [7e6, 0.0, 0.0], "v_N0": [5000.0, 0.01, 0.01], "j2_node_drift": True}, "v_N0"),
    ],
)
def test_what_no_plant_can_be_is_refused_by_its_name(changes: dict[str, Any], name: str) -> None:
    assert Direct("plant").check(**changes) == name


def test_r_and_v_of_a_circular_orbit_give_that_orbit() -> None:
    with started() as circle:
        r, v = circle.get("r_N"), circle.get("v_N")
        with started(orbit_start="position_velocity", r_N0=r, v_N0=v) as again:
            for it in (circle, again):
                it.step(0.0, 60.0)
            np.testing.assert_allclose(again.get("r_N"), circle.get("r_N"), rtol=0, atol=1e-4)


@pytest.mark.parametrize("eccentricity", [0.99, 0.998, 0.9999])
def test_a_long_orbit_starts_where_it_is_told_to_before_and_after_its_perigee(eccentricity: float) -> None:
    """Closed form of an ellipse; Newton's method alone diverges before such a perigee."""
    a = 6.6e6 / (1.0 - eccentricity)
    for E in (-2.0, -1.0, -0.75, -0.7, -0.65, -0.5, -0.1, 0.3, 1.0):
        minor = a * math.sqrt(1.0 - eccentricity**2)
        rate = math.sqrt(MU / a**3) / (1.0 - eccentricity * math.cos(E))
        r = np.array([a * (math.cos(E) - eccentricity), minor * math.sin(E), 0.0])
        v = np.array([-a * math.sin(E) * rate, minor * math.cos(E) * rate, 0.0])
        with started(**FREE, r_N0=r, v_N0=v) as it:
            np.testing.assert_allclose(it.get("r_N"), r, rtol=0, atol=1e-7 * np.linalg.norm(r))
            np.testing.assert_allclose(it.get("v_N"), v, rtol=0, atol=1e-7 * np.linalg.norm(v))


@pytest.mark.parametrize("epoch", ["2024-12-31T12:00:00Z", "2025-01-01T00:00:00Z", "2031-05-06T07:08:09Z"])
def test_the_field_before_and_after_the_last_epoch_of_its_model_is_that_of_the_other_flavour(epoch: str) -> None:
    model = {"field_model": "igrf14", "epoch": epoch, "field_extrapolate": True}
    p, u = checked(**model), command()
    with started(**model) as it:
        expected = plant.outputs(plant.start(p, u), u, p).b_B
        np.testing.assert_allclose(it.get("b_B"), expected, rtol=0, atol=1e-15)


def test_rods_that_switch_more_than_a_million_times_in_a_step_are_refused() -> None:
    with started(rod_period=1e-3, rod_duty=0.5, step_max=100.0) as it:
        with pytest.raises(Refused, match="rod_period: expected at least a millionth of the communication step, found"):
            it.step(0.0, 1001.0)
        it.step(0.0, 0.1)


@pytest.mark.parametrize(("h", "turns"), [(0.1, 1), (0.2, 2), (0.2 * (1.0 + 5e-13), 2), (0.2 * (1.0 + 1e-9), 3)])
def test_a_step_has_the_fewest_parts_that_step_max_allows(h: float, turns: int) -> None:
    """Steps of those parts' length, each with a step_max far above it, reach the same attitude."""
    start = {"omega_B0": [0.05, -0.08, 0.03], "step_max": 0.1, "integrator_order": 2}
    with started(**start) as whole, started(**{**start, "step_max": 10.0}) as parts:
        whole.step(0.0, h)
        for i in range(turns):
            parts.step(i * (h / turns), h / turns)
        np.testing.assert_allclose(whole.get("R_NB"), parts.get("R_NB"), rtol=0, atol=1e-15)


@pytest.mark.parametrize("order", [2, 4, 6])
@pytest.mark.parametrize("h_w0", [0.0, 0.03])
@pytest.mark.parametrize("rate", [0.01, 0.3, 0.7])
def test_an_internal_step_turns_a_body_as_the_python_flavour_does_however_many_passes_newtons_method_takes(
    rate: float, h_w0: float, order: int
) -> None:
    start: dict[str, Any] = {"omega_B0": [0.6 * rate, -0.64 * rate, 0.48 * rate], "h_w0": h_w0}
    start |= {"drag": False, "step_max": 1.0, "integrator_order": order}
    p, u = checked(**start), command()
    x, _ = plant.step(plant.start(p, u), u, p, 1.0)
    with started(**start) as it:
        it.step(0.0, 1.0)
        np.testing.assert_allclose(np.reshape(it.get("R_NB"), (3, 3)), x.R, rtol=0, atol=1e-14)


def test_a_body_that_turns_too_far_in_an_internal_step_is_refused_with_the_remedy() -> None:
    refused = pytest.raises(Refused, match="step_max: expected a turn below about 1 rad in an internal step")
    with started(omega_B0=[3.0, -4.0, 5.0], step_max=1.0) as it, refused:
        it.step(0.0, 1.0)


def test_sensors_that_sample_more_than_a_billion_times_in_a_step_are_refused() -> None:
    with Instance("plant_sensors") as it:
        it.set("sensor_period", 1e-6)
        it.initialize()
        with pytest.raises(Refused, match="sensor_period: expected at least 1e-09 of the communication step"):
            it.step(0.0, 1001.0)
        it.step(0.0, 1.0)


@pytest.mark.parametrize(("axis", "area"), [("x", 2.0 * (math.sqrt(2.0) - 1.0) * 0.6**2), ("z", 0.6 * 1.5)])
def test_drag_of_an_octagonal_cylinder_end_on_and_side_on_is_that_of_its_projected_area(axis: str, area: float) -> None:
    """Momentum of the air that strikes a regular octagon, or a rectangle, about a centre of mass off the flow's line;
    over the equator the air turns along the orbit, with the Earth."""
    centre = np.array([0.02, 0.05, -0.03])
    body = {"body_axis": axis, "body_width": 0.6, "body_length": 1.5, "center_of_mass_B": centre}
    with started(inclination=0.0, Q0=np.eye(3), drag_coefficient=2.2, drag_factor=1.0, **body) as it:
        r, v, R = (np.array(it.get(name)) for name in ("r_N", "v_N", "R_NB"))
        flow = R.reshape(3, 3).T @ (v - np.cross([0.0, 0.0, 7.292115e-5], r))
        assert abs(flow[0]) == pytest.approx(np.linalg.norm(flow), rel=1e-9)
        expected = 0.5 * it.get("density") * 2.2 * area * np.linalg.norm(flow) * np.cross(centre, flow)
        np.testing.assert_allclose(it.get("tau_drag_B"), expected, rtol=1e-6, atol=1e-9 * np.abs(expected).max())
