"""The blocks' C as flight software calls it: what no FMI shell refuses before is refused by the block, by name."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fmus.interface import ABSENT_MIN, Variable, load

from .direct import Direct

FLIGHT = ("controller", "controller_planned", "allocator", "allocator_bounded", "estimator", "supervisor")
CHECKED = (*FLIGHT, "plant_sensors", "plant_judge")
WITH_ATTITUDE = ("controller", "controller_planned", "plant_judge")
ZEROS = np.zeros((3, 3))
SKEWED = np.eye(3) + np.eye(3, k=1)


def with_element(variable: Variable, place: int, value: float) -> Any:
    """The start of a variable with one element changed."""
    if not variable.shape:
        return value
    values = np.array(variable.start, float)
    values.ravel()[place] = value
    return values


def elements(block: str, causality: Any, kind: str = "real") -> list[tuple[Variable, int]]:
    return [(v, i) for v in load(block).of(causality) if v.type == kind for i in range(len(v.elements))]


def named(refused: str | None) -> str:
    return (refused or "").partition("[")[0]


@pytest.mark.parametrize("block", CHECKED)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_parameter_that_is_no_finite_number_is_refused_by_its_name(block: str, value: float) -> None:
    direct = Direct(block)
    for v, i in elements(block, "parameter"):
        assert named(direct.check(**{v.name: with_element(v, i, value)})) == v.name


@pytest.mark.parametrize("block", CHECKED)
def test_a_parameter_below_zero_that_must_not_be_is_refused_by_its_name(block: str) -> None:
    direct, tried = Direct(block), 0
    for v, _ in elements(block, "parameter"):
        if not v.shape and v.min is not None and v.min >= 0.0:
            tried += 1
            assert direct.check(**{v.name: -1.0}) == v.name
    assert tried or block == "plant_judge"


@pytest.mark.parametrize("block", CHECKED)
def test_a_number_of_a_choice_or_a_count_beyond_its_range_is_refused_by_its_name(block: str) -> None:
    direct = Direct(block)
    for v in load(block).of("parameter"):
        ends = {"enumeration": (1, len(v.items)), "integer": (v.min, v.max)}.get(v.type, ())
        for end, side in zip(ends, (-1, 1), strict=False):
            if end is not None and abs(end) < 1e9:
                assert direct.check(**{v.name: int(end)}) != v.name or "refused here" in v.description
                assert direct.check(**{v.name: int(end) + side}) == v.name


CALLS = [
    (block, call)
    for block in (*FLIGHT, "allocator_bounded_wheels", "estimator_wheels")
    for call in ("start", "outputs", "step")
]
"""The judge looks at no input before the first outputs."""


@pytest.mark.parametrize(("block", "call"), [*CALLS, ("plant_judge", "outputs"), ("plant_judge", "step")])
def test_an_input_that_is_no_number_is_refused_by_its_name(block: str, call: str) -> None:
    direct = Direct(block)
    for v, i in elements(block, "input"):
        assert direct.start() is None
        value = with_element(v, i, math.nan)
        if block == "plant_judge" and v.optional:
            continue
        assert named(getattr(direct, call)(**{v.name: value})) == v.name


@pytest.mark.parametrize("block", WITH_ATTITUDE)
def test_before_the_first_attitude_there_is_no_torque_and_afterwards_there_is_no_way_back(block: str) -> None:
    direct = Direct(block)
    for optional in ({}, {"h_w": 0.01}) if block == "controller_planned" else ({},):
        assert direct.start(R_NB=ZEROS, **optional) is None
        assert direct.outputs(R_NB=ZEROS, **optional) is None
        assert direct.y.no_attitude
        assert named(direct.outputs(R_NB=ZEROS, omega_B=[math.nan, 0.0, 0.0])) == "omega_B"
        if block != "controller_planned":  # which looks at an attitude at its samples
            assert direct.outputs(R_NB=SKEWED) == "R_NB"
        assert direct.step(R_NB=ZEROS, **optional) is None
        assert direct.y.no_attitude
        assert direct.y.attitude_error == pytest.approx(math.pi)
        assert named(direct.step(R_NB=ZEROS, r_N=[math.nan, 0.0, 0.0])) == "r_N"
        assert direct.step(R_NB=SKEWED) == "R_NB"
        assert direct.step() is None
        assert not direct.y.no_attitude
        assert direct.step(R_NB=ZEROS) == "R_NB"
    assert direct.start(R_NB=ZEROS) is None
    if block == "controller_planned":
        assert direct.outputs() is None


def test_a_law_that_latched_before_its_attitude_was_lost_latches_anew_with_the_first_one() -> None:
    """[10] divides by the error at the start: of a start that is taken back nothing stays."""
    direct, turned = Direct("controller"), Rotation.from_rotvec([1.0, 0.0, 0.0]).as_matrix()
    gains = []
    for first in (np.eye(3), ZEROS):
        assert direct.start(R_NB=first) is None
        assert direct.step(R_NB=ZEROS) is None
        assert direct.y.no_attitude
        assert direct.step(R_NB=turned) is None
        gains.append(direct.y.gain_k)
    assert gains[0] == gains[1]
    assert direct.start() is None
    assert direct.step(R_NB=turned) is None
    assert direct.y.gain_k != gains[0]


def test_without_an_attitude_the_planned_controller_passes_the_wheel_momentum_on_where_it_is_connected() -> None:
    direct = Direct("controller_planned")
    for h_w, estimate in ((0.01, 0.01), (1e9, 0.0)):
        assert direct.start(R_NB=ZEROS, h_w=h_w) is None
        assert direct.outputs(R_NB=ZEROS, h_w=h_w) is None
        assert direct.y.h_w_estimate == estimate


@pytest.mark.parametrize("block", ["controller", "controller_planned", "plant_judge", "allocator_bounded"])
def test_an_input_of_which_one_element_is_not_connected_counts_as_not_connected(block: str) -> None:
    """Those of a reference belong together, so that the others are refused by the name of the one that is missing."""
    direct = Direct(block)
    connected: dict[str, Any] = {
        "attitude_sigma_B": [1e-3, 2e-3, 3e-3], "attitude_bound": 0.1,
        "h_w": 0.01, "b_B": [2e-5, -1e-5, 3e-5], "u_applied": [1.0, 2.0, -3.0, 1e-4],
        "R_d": Rotation.from_rotvec([0.3, 0.2, 0.1]).as_matrix(), "Omega_d": [0.01, 0.02, 0.03],
        "dipole_ff": [3.0, -4.0, 5.0], "wheel_torque_ff": 1e-4, "rod_gains": [0.9, -1.0, 0.5],
        "R_ref": Rotation.from_rotvec([0.3, 0.2, 0.1]).as_matrix(), "Omega_ref": [1e-3, 2e-3, 3e-3],
        "dOmega_ref": [1e-5, 2e-5, 3e-5], "t_ahead": np.linspace(90.0, 1500.0, 16),
        "turn_ahead": np.full((16, 3), 0.2), "Omega_ahead": np.full((16, 3), 1e-3),
    }  # fmt: skip
    optional = [v for v in load(block).of("input") if v.optional and v.type == "real"]
    given = {v.name: connected[v.name] for v in optional}

    def two_steps(values: dict[str, Any]) -> tuple[Any, ...]:
        first = {**values, "omega_B": [0.01, 0.02, -0.01]}
        ends = [direct.start(**first), direct.step(0.5, **first), direct.step(0.5, **first)]
        return (*ends, bytes(direct.y) if ends == [None] * 3 else b"")

    for v in optional:
        absent = two_steps({**given, v.name: np.full(v.shape, ABSENT_MIN) if v.shape else ABSENT_MIN})
        for i in range(len(v.elements)):
            values = np.array(given[v.name], float)
            values.ravel()[i] = -ABSENT_MIN
            assert two_steps({**given, v.name: values if v.shape else float(values)}) == absent
        if (
            v.name != "attitude_bound"
        ):  # it acts after the first hold (tests/controller/planned/test_reference_ports.py)
            assert two_steps(given) != absent


@pytest.mark.parametrize("element", range(3))
def test_a_measured_field_along_one_axis_is_a_field(element: int) -> None:
    direct = Direct("controller_planned")
    field = np.zeros(3)
    field[element] = 3e-5
    assert direct.start(b_B=field, omega_B=[0.06, -0.05, 0.08]) is None
    assert direct.outputs(b_B=field, omega_B=[0.06, -0.05, 0.08]) is None
    measured = list(direct.y.dipole_ff)
    assert direct.start(b_B=[0.0, 0.0, 0.0], omega_B=[0.06, -0.05, 0.08]) is None
    assert direct.outputs(b_B=[0.0, 0.0, 0.0], omega_B=[0.06, -0.05, 0.08]) is None
    assert list(direct.y.dipole_ff) != measured


def test_a_field_that_is_given_in_another_unit_is_refused() -> None:
    direct = Direct("controller_planned")
    assert direct.start(b_B=[0.3, 0.1, 0.2]) == "b_B"


def test_demands_so_large_that_their_dipoles_overflow_are_held() -> None:
    direct = Direct("allocator")
    for tau in ([0.0, 1e305, 0.0], [1e305, 0.0, 0.0]):
        assert direct.start() is None
        assert direct.step(tau_cmd_B=tau, b_B=[2e-12, 0.0, 1e-12]) is None
        assert direct.y.holding
        assert direct.y.demand_fraction == 1e6


@pytest.mark.parametrize(
    "epoch",
    [
        *("2009-08-10Txx:00:00Z", "2009-08-10T00-00:00Z", "2009-08-10T00:x0:00Z", "2009-08-10T00:00:0xZ"),
        *("2009-08-xxT00:00:00Z", "2009-8-10T00:00:00Z", "0000-08-10T00:00:00Z", "2009-00-10T00:00:00Z"),
        *("2009-13-10T00:00:00Z", "2009/08/10T00:00:00Z", "2009-08/10T00:00:00Z", "2009-08-10T00:00:00+0x:00"),
        *("2009-08-10T00:00:00+00-00", "2009-08-10T00:00:00+00:0x", "2009-08-10T00:00:00+00:01"),
        *("2009-08-10T00:00:00+01:00", "2009-08-10T00:00:00+00:00x", ""),
    ],
)
def test_what_is_no_date_in_utc_is_refused(epoch: str) -> None:
    assert Direct("controller_planned").check(epoch=epoch) == "epoch"


@pytest.mark.parametrize("epoch", ["1999-12-31T23:59:59Z", "2030-01-02T00:00:00Z"])
def test_a_date_before_or_after_the_field_model_is_refused(epoch: str) -> None:
    assert Direct("controller_planned").check(epoch=epoch) == "epoch"


def test_a_reference_that_is_no_number_leaves_no_supervisor() -> None:
    """Above its target along the vertical a velocity along the position spans no plane of an orbit."""
    direct = Direct("supervisor")
    target = {"target_latitude": 0.1, "target_longitude": 0.5, "target_height": 0.0}
    towards = {**target, "first_mode": 3, "rate_time": 0.0, "settled_time": 0.0, "angle_time": 0.0}
    assert direct.start(**towards) is None
    assert direct.outputs(**target) is None
    at = np.array([7.0e6, 1.0e5, -2.0e5])
    assert direct.outputs(**target, r_N=at, v_N=1e-3 * at) == "R_ref"
    assert direct.outputs(**target) is None


@pytest.mark.parametrize("h", [-1e12, -0.1, 1000.1, math.inf, math.nan])
def test_an_estimator_refuses_a_step_that_is_negative_too_long_or_no_number(h: float) -> None:
    direct = Direct("estimator")
    assert direct.start() is None
    assert direct.step(h) == "communicationStepSize"
    assert direct.step(0.1) is None
