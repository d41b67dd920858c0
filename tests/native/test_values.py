"""The FMI shell's values: what each variable starts with, keeps and refuses, when it is set or when initialization
ends."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from fmus.interface import BLOCKS
from tests import dates

from .driver import ERROR, Instance, Refused, running


@pytest.mark.parametrize("block", BLOCKS)
def test_every_variable_starts_with_its_start_value(block: str) -> None:
    with Instance(block) as it:
        for v in it.interface.variables.values():
            if v.start is not None:
                start = v.items.index(v.start) + 1 if v.type == "enumeration" else v.start
                assert np.array_equal(it.get(v.name), start), v.name


@pytest.mark.parametrize("block", BLOCKS)
def test_each_input_and_parameter_keeps_what_was_set_and_disturbs_no_other(block: str) -> None:
    with Instance(block) as it:
        settable = [v for v in it.interface.variables.values() if v.causality != "output"]
        for chosen in settable:
            before = {v.name: it.get(v.name) for v in settable}
            it.set(chosen.name, _other(chosen, before[chosen.name]))
            after = {v.name: it.get(v.name) for v in settable}
            changed = [name for name in before if not np.array_equal(before[name], after[name])]
            assert changed == [chosen.name]
            assert np.array_equal(after[chosen.name], _other(chosen, before[chosen.name]))


def _other(v: Any, value: Any) -> Any:
    if v.type == "string":
        return "2011-12-13T14:15:16Z"
    if v.type == "boolean":
        return 1 - value
    if v.type in ("enumeration", "integer"):
        top = len(v.items) if v.type == "enumeration" else v.max
        return value - 1 if value == top else value + 1
    shift = 1e-3 * (1.0 + np.abs(value)) * (1.0 + np.arange(np.size(value)).reshape(np.shape(value)))
    low, high = (-math.inf if v.min is None else v.min), (math.inf if v.max is None else v.max)
    moved = np.where(value + shift > high, value - shift, value + shift)
    return np.clip(moved, low, high)


def test_starts_of_inputs_are_usable() -> None:
    for block in BLOCKS:
        with running(block) as it:
            for i in range(3):
                it.step(0.1 * i, 0.1)
            assert all(np.isfinite(value).all() for value in it.outputs().values())


@pytest.mark.parametrize(
    ("block", "name", "value", "message"),
    [
        ("allocator", "hold_fraction", 1.5, r"hold_fraction: expected 1e-06 to 1, found 1.5"),
        ("allocator", "hold_fraction", math.nan, r"hold_fraction: expected 1e-06 to 1, found NaN"),
        ("allocator", "dipole_max", 0.0, r"dipole_max: expected a finite number, at least 1e-09, found 0"),
        ("allocator", "dipole_max", math.inf, r"dipole_max: expected a finite number, at least 1e-09, found infinity"),
        ("allocator_bounded", "rod_limits", [1.0, 0.5, 1.001], r"rod_limits\[3\]: expected 0.01 to 1, found 1.001"),
        ("controller_planned", "rod_limits", [1.0, 0.0, 1.0], r"rod_limits\[2\]: expected 0.01 to 1, found 0"),
        ("plant", "rod_limits", [math.nan, 1.0, 1.0], r"rod_limits\[1\]: expected 0.01 to 1, found NaN"),
        ("controller", "omega_B", [0.0, -math.inf, 0.0], r"omega_B\[2\]: expected a finite number, found -infinity"),
        ("controller", "reference", 4, r"reference: expected 1 to 3, found 4"),
        ("controller", "gravitational_parameter", 3.98e5, r"expected 1e\+14 to 1e\+15, found 398000"),
        ("plant", "orbit_radius", 6.4e6, r"orbit_radius: expected 6478137 to 50000000, found 6400000"),
        ("plant", "inclination", -0.125, r"inclination: expected 0 to 3.14159265, found -0.125"),
        ("plant", "epoch", "a" * 128, r"epoch has at most 127 bytes"),
    ],
)
def test_a_value_out_of_range_is_refused_by_name_value_and_range(
    block: str, name: str, value: Any, message: str
) -> None:
    with Instance(block) as it:
        before = it.get(name)
        with pytest.raises(Refused, match=f"^{ERROR}: fmi2Set.*{message}"):
            it.set(name, value)
        assert np.array_equal(it.get(name), before)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"J_B": np.diag([1.0, 1.0, 2.5])}, r"J_B: expected the inertia of a body"),
        ({"J_error_B": np.diag([-3.0, 0.0, 0.0])}, r"J_B \+ J_error_B: expected a positive definite matrix"),
        ({"rod_axes": np.eye(3) * 0.5}, r"rod_axes: expected rows of unit length, to 1e-06, found 0.5"),
        ({"h_w0": 0.031}, r"h_w0: expected within wheel_momentum_max, found 0.031"),
        ({"integrator_order": 3}, r"integrator_order: expected 2, 4 or 6, found 3"),
        (
            {"Q0": np.diag([1.0, 1.0, -1.0])},
            r"Q0: expected a rotation matrix, determinant \+1 \(this is a reflection\)",
        ),
        ({"q_NB0": [0.9, 0.0, 0.0, 0.0], "initial_attitude": "q_NB0"}, r"q_NB0: expected a quaternion of unit length"),
        ({"epoch": "10 August 2009"}, r"epoch: expected UTC in ISO 8601.*found '10 August 2009'"),
        ({"epoch": "50%s"}, r"epoch: .*found '50%%s'"),  # doubled: FMI's message is a format
        ({"epoch": "2009-02-29T00:00:00Z"}, r"epoch: expected UTC"),
        ({"epoch": "2009-08-10T00:00:00+02:00"}, r"epoch: expected UTC"),
        (
            {"field_model": "wmm2025"},
            r"epoch: expected a date that wmm2025 covers, 2025.0 to 2030.0, or field_extrapolate, found 2009.6",
        ),
        (
            {"orbit_start": "position_velocity", "r_N0": [6.475e6, 0.0, 0.0], "v_N0": [0.0, -1092.0, 7770.0]},
            r"r_N0, v_N0: expected a perigee of at least",
        ),
        ({"orbit_radius": 9e6}, r"orbit_radius: expected heights of 150 km to 2000 km"),
        ({"orbit_start": "position_velocity", "v_N0": [1.0, 0.0, 0.0]}, r"v_N0: expected below escape speed"),
        ({"orbit_start": "position_velocity", "v_N0": [0.0, 0.0, 12e3]}, r"v_N0: expected below escape speed"),
        ({"center_of_mass_B": [0.0, 0.33, 0.0]}, r"center_of_mass_B\[2\]: expected inside the body"),
    ],
)
def test_a_plant_that_cannot_be_is_refused_when_initialization_ends(changes: dict[str, Any], message: str) -> None:
    with Instance("plant") as it:
        for name, value in changes.items():
            it.set(name, value)
        it.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
        it.call("EnterInitializationMode")
        with pytest.raises(Refused, match=f"^{ERROR}: fmi2ExitInitializationMode: {message}"):
            it.call("ExitInitializationMode")
        for name in changes:  # what was refused can be mended, and initialization goes on
            v = it.interface.variables[name]
            it.set(name, v.start)
        it.call("ExitInitializationMode")


@pytest.mark.parametrize("block", ["plant", "controller_planned"])
def test_both_blocks_with_an_epoch_read_the_same_dates_and_refuse_the_same_texts(block: str) -> None:
    with Instance(block) as it:
        it.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
        it.call("EnterInitializationMode")
        for text in dates.REFUSED:
            it.set("epoch", text)
            with pytest.raises(Refused, match="epoch: expected UTC in ISO 8601, such as 2009-08-10T12:00:00Z, found '"):
                it.call("ExitInitializationMode")
    for text in dates.READ:
        with Instance(block) as it:
            it.set("epoch", text)
            it.set("field_model", "igrf14")
            it.initialize()
