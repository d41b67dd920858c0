"""The bounded allocator as a block: its interface, what it refuses, its start and its steps."""

import math
from dataclasses import replace

import numpy as np
import pytest

from allocator import bounded
from fmus.interface import load
from tests.blocks import inputs, parameters

from .problems import BLOCK, P, commands, given, problem


def test_the_first_command_is_that_of_the_inputs_at_the_start_and_steps_remember_nothing(rng):
    u, _ = problem(rng, "any", tuned=False)
    x = bounded.start(P, u)
    first = bounded.outputs(x, u, P)
    other, _ = problem(rng, "any", tuned=False)
    x, _ = bounded.step(x, other, P, 0.5)
    x, y = bounded.step(x, u, P, 0.5)
    np.testing.assert_array_equal(commands(first), commands(y))
    assert x == bounded.State(1.0)


def test_it_takes_the_place_of_the_papers_allocator():
    """The same outputs, and every input of the paper's; what it has beyond them is optional."""
    ours, theirs = load(BLOCK), load("allocator")
    same = [v.name for v in theirs.of("output")]
    assert [v.name for v in ours.of("output")] == same
    for name in (*same, *(v.name for v in theirs.of("input"))):
        a, b = ours.variables[name], theirs.variables[name]
        assert (a.causality, a.type, a.shape, a.unit, a.frame) == (b.causality, b.type, b.shape, b.unit, b.frame)
    assert [v.name for v in ours.of("input") if v.name not in theirs.variables] == [
        "dipole_ff",
        "wheel_torque_ff",
        "rod_gains",
    ]
    assert all(v.optional for v in ours.of("input") if v.name not in theirs.variables)


@pytest.mark.parametrize("name", ["dipole_ff", "wheel_torque_ff", "rod_gains"])
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_optional_inputs_that_are_not_finite_are_refused_by_name(name, bad):
    u = inputs(BLOCK)
    for index in np.ndindex(np.shape(getattr(u, name))):
        value = np.array(getattr(u, name))
        value[index] = bad
        wrong = replace(u, **{name: value if value.shape else float(value)})
        with pytest.raises(ValueError, match=f"^{name}: expected"):
            given(wrong)
        with pytest.raises(ValueError, match=f"^{name}: expected"):
            bounded.start(P, wrong)


WRONG = [
    ({"rod_axes": 1.001 * P.rod_axes}, r"rod_axes: expected rows of unit length to 1e-06, found \|u1\| = 1.001"),
    ({"rod_axes": [[1, 0, 0], [0.6, 0.8, 0], [0, 1, 0]]}, "rod_axes: expected linearly independent axes.*found 0"),
    ({"rod_limits": np.array([1.0, 0.0, 1.0])}, "rod_limits: expected 0.01 to 1, found"),
    ({"rod_limits": np.array([1.0, 1.0, 1.1])}, "rod_limits: expected 0.01 to 1, found"),
    ({"rod_axes": np.full((3, 3), math.nan)}, "rod_axes: expected finite"),
    ({"rod_weight": 9e-9}, "rod_weight: expected a finite number of at least 1e-08, found 9e-09"),
    ({"rod_weight": math.nan}, "rod_weight: expected"),
    ({"wheel_weight": -1e-9}, "wheel_weight: expected a finite number of at least 0"),
    ({"wheel_weight_ff": math.inf}, "wheel_weight_ff: expected"),
    *(
        ({name: bad}, f"{name}: expected a finite number above 0, found")
        for name in ("dipole_max", "wheel_torque_max", "wheel_momentum_max", "command_period", "desaturation_time")
        for bad in (0.0, -1.0, math.inf, math.nan)
    ),
]


@pytest.mark.parametrize(("changes", "message"), WRONG)
def test_wrong_parameters_are_refused_by_name_and_value(changes, message):
    with pytest.raises(ValueError, match=message):
        bounded.check(parameters(BLOCK, **changes))


def test_right_parameters_pass_and_axes_are_normalised_on_use(rng):
    bounded.check(P)
    rounded = replace(P, rod_axes=P.rod_axes * (1.0 + 9e-7), wheel_weight=0.0, wheel_weight_ff=0.0)
    bounded.check(rounded)
    u, _ = problem(rng, "any", tuned=False)
    y, z = given(u, rounded), given(u, replace(rounded, rod_axes=P.rod_axes))
    np.testing.assert_allclose(commands(y), commands(z), rtol=1e-6, atol=1e-12)
