"""Every bad parameter is refused by its name and value, with what is expected."""

from __future__ import annotations

import dataclasses
import math
import re

import numpy as np
import pytest

import plant
from fmus.interface import load
from plant.checks import AIR_RANGES, AT_LEAST, BODY_RANGES, LIGHT_RANGES, ROD_GAIN_MAX
from tests.blocks import parameters
from tests.plant.motion import checked

REFUSED = {
    "an inertia that is not symmetric": (
        {"J_B": [[2.0, 0.1, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 3.0]]},
        "J_B",
        "0.1",
        "symmetric",
    ),
    "an inertia that is not positive definite": (
        {"J_B": np.diag([2.0, -3.0, 3.0])},
        "J_B",
        "-3.0",
        "positive definite",
    ),
    "no inertia at all": ({"J_B": np.zeros((3, 3))}, "J_B", "0.0", "positive definite"),
    "an inertia that no body has": ({"J_B": np.diag([1.0, 1.0, 2.1])}, "J_B", "2.1", "the inertia of a body"),
    "an error that makes the true inertia impossible": (
        {"J_error_B": np.diag([0.0, 0.0, 3.0])},
        "J_B + J_error_B",
        "6.09",
        "the inertia of a body",
    ),
    "rod axes that are not unit": (
        {"rod_axes": [[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]},
        "rod_axes",
        "1.414",
        "unit length",
    ),
    "an attitude that is no rotation": (
        {"Q0": [[1.0, 0.01, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]},
        "Q0",
        "0.01",
        "rotation",
    ),
    "a reflection": ({"Q0": np.diag([1.0, 1.0, -1.0])}, "Q0", "rotation", "-1.0000"),
    "a quaternion that is not of unit length": (
        {"initial_attitude": "q_NB0", "q_NB0": [1.0, 0.1, 0.0, 0.0]},
        "q_NB0",
        "0.1",
        "unit length",
    ),
    "a quaternion of zeros": ({"initial_attitude": "q_NB0", "q_NB0": [0.0] * 4}, "q_NB0", "found 0", "unit length"),
    "an epoch that is no date": ({"epoch": "yesterday"}, "epoch", "ISO 8601", "'yesterday'"),
    "an epoch that is not UTC": ({"epoch": "2009-08-10T00:00:00+02:00"}, "epoch", "UTC", "+02:00"),
    "an epoch that the field's model does not cover": (
        {"epoch": "1850-01-01T00:00:00Z"},
        "epoch",
        "1850.000",
        "1900.0 to 2030.0",
    ),
    "an orbit below 100 km": ({"orbit_radius": 6471e3}, "orbit_radius", "6471000.0", "at least 6478137.0 m"),
    "an order that there is not": ({"integrator_order": 3}, "integrator_order", "3", "2, 4, 6"),
    "a degree of nothing": ({"field_degree": 0}, "field_degree", "0", "1 to 13"),
    "a degree beyond the model": ({"field_degree": 14}, "field_degree", "14", "1 to 13"),
    "more momentum than the wheel holds": ({"h_w0": -0.031}, "h_w0", "-0.031", "0.03 N.m.s"),
    "a wheel without inertia": ({"wheel_inertia": 0.0}, "wheel_inertia", "0.0", "at least 1e-12 kg.m2"),
    "a negative momentum limit": ({"wheel_momentum_max": -0.03}, "wheel_momentum_max", "-0.03", "at least 0"),
    "a negative motor limit": ({"wheel_torque_max": -1e-3}, "wheel_torque_max", "-0.001", "at least 0"),
    "friction that drives": ({"wheel_viscous_friction": -1e-9}, "wheel_viscous_friction", "-1e-09", "at least 0"),
    "Coulomb friction that drives": (
        {"wheel_coulomb_friction": -1e-9},
        "wheel_coulomb_friction",
        "-1e-09",
        "at least 0",
    ),
    "a negative dipole limit": ({"dipole_max": -25.0}, "dipole_max", "-25.0", "at least 0"),
    "a rod without a dipole": ({"rod_limits": [1.0, 0.0, 1.0]}, "rod_limits", "0.0", "0.01 to 1"),
    "a rod that is larger than the largest": ({"rod_limits": [1.0, 1.0, 1.1]}, "rod_limits", "1.1", "0.01 to 1"),
    "a rod that gives too much of the opposite": ({"rod_gain": [1.0, -2.1, 1.0]}, "rod_gain", "-2.1", "-2 to 2"),
    "a rod that gives too much": ({"rod_gain": [1.0, 1.0, 2.1]}, "rod_gain", "2.1", "-2 to 2"),
    "turns shorter than a millisecond": ({"rod_period": 5e-4}, "rod_period", "0.0005 s", "at least 0.001 s"),
    "turns that run backwards": ({"rod_period": -1.0}, "rod_period", "-1.0 s", "0 (always on)"),
    "a share above the whole": ({"rod_duty": 1.01}, "rod_duty", "1.01", "0 to 1"),
    "an Earth without mass": ({"gravitational_parameter": 0.0}, "gravitational_parameter", "0.0", "at least 1e+14"),
    "a step of nothing": ({"step_max": 0.0}, "step_max", "0.0", "at least 1e-06 s"),
    "an unknown start of the orbit": ({"orbit_start": "tle"}, "orbit_start", "'tle'", "circular, position_velocity"),
    "an unknown start of the attitude": ({"initial_attitude": "euler"}, "initial_attitude", "'euler'", "Q0, q_NB0"),
    "an unknown field model": ({"field_model": "emm2017"}, "field_model", "'emm2017'", "igrf14, wmm2010"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_is_refused_by_name_value_and_expectation(case):
    changes, name, *parts = REFUSED[case]
    said = "".join(f"(?=.*{re.escape(part)})" for part in parts)
    with pytest.raises(ValueError, match=rf"^{re.escape(name)}: {said}expected .*, found "):
        checked(**changes)


NUMBERS = [
    f.name
    for f in dataclasses.fields(plant.Parameters)
    if f.name in load("plant").variables and isinstance(getattr(parameters("plant"), f.name), float | np.ndarray)
]


@pytest.mark.parametrize("bad", [math.nan, math.inf])
@pytest.mark.parametrize("name", NUMBERS)
def test_a_number_that_is_not_finite_is_refused_by_its_name(name, bad):
    value = getattr(parameters("plant"), name)
    if isinstance(value, np.ndarray):
        value = value.copy()
        value.flat[-1] = bad
    else:
        value = bad
    with pytest.raises(ValueError, match=rf"^{name}: expected .*, found .*{bad}"):
        checked(drag=True, **{name: value})


def test_the_interfaces_starts_are_accepted():
    plant.check(parameters("plant"))


@pytest.mark.parametrize(
    "changes",
    [
        {"J_B": np.diag([1.0, 1.0, 2.0])},  # a flat plate: the triangle's equality
        {"Q0": [[1.0, 5e-4, 0.0], [-5e-4, 1.0, 0.0], [0.0, 0.0, 1.0]]},  # four decimals, as the paper prints
        {"h_w0": -0.03},
        {"wheel_momentum_max": 0.0},
        {"dipole_max": 0.0},
        {"rod_gain": [0.0, 2.0, 1.0], "rod_period": 1e-3, "rod_duty": 0.0},
        {"field_model": "wmm2025", "field_degree": 12, "epoch": "2029-12-31T23:59:59Z"},
    ],
)
def test_the_edge_of_what_is_permitted_is_accepted(changes):
    assert checked(**changes)


def test_the_papers_printed_attitude_is_projected_onto_a_rotation():
    printed = np.array([[0.3333, 0.2440, -0.9107], [-0.9107, 0.3333, -0.2440], [0.2440, 0.9107, 0.3333]])
    R = checked(Q0=printed).R_NB0
    assert np.abs(R.T @ R - np.eye(3)).max() < 1e-15
    assert checked(Q0=printed).orbit.position_velocity(0.0)[0] is not None
    assert np.abs(R - checked().R_NB0 @ printed).max() < 2e-4


def test_ranges_are_those_of_the_interface():
    """The FMUs refuse what lies beyond the interface's, the block what lies beyond its own."""
    stated = {v.name: (v.min, v.max) for v in load("plant").of("parameter")}
    for name, least, _ in AT_LEAST:
        assert stated[name][0] == least, name
    for name, low, high, _ in (*AIR_RANGES, *BODY_RANGES, *LIGHT_RANGES):
        assert stated[name] == (low, high), name
    assert stated["rod_gain"] == (-ROD_GAIN_MAX, ROD_GAIN_MAX)
