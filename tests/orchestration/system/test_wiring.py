"""Connections of mocks: elements with units of their own, and inputs that may stay unconnected."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fmus.units import Unit
from orchestration import InputError
from orchestration.fmu.model import shared
from orchestration.quantities import parse_unit

from .. import mocks
from ..mocks import Mock, real


def applied(*names: str) -> Any:
    """`unit` and `units` of a vector whose elements have these units."""
    unit, units = shared([parse_unit(name) for name in names])
    return {"shape": (len(names),), "unit": unit, "units": units}


def source(**more: Any) -> Mock:
    kind = mocks.model("source", real("y", "output", **more))

    def evaluate(block: Mock) -> None:
        for n, element in enumerate(block.model.variables["y"].elements, start=1):
            block.values[element] = float(n)

    return Mock("source", kind, evaluate)


def sink(**more: Any) -> Mock:
    return Mock("sink", mocks.model("sink", real("u", "input", **more)), lambda block: None)


def given(blocks: list[Mock], *connections: str, **scenario: Any) -> tuple[list[float], list[str]]:
    """What the sink gets in a step, and the notes."""
    result = mocks.run(blocks, {"step": 1, "duration": 1, "connections": list(connections), **scenario})
    return blocks[-1].vector("u").tolist(), result.warnings


def test_a_vector_is_converted_element_by_element_without_a_word():
    blocks = [source(**applied("mA.m2", "A.m2", "kA.m2", "mN.m")), sink(**applied("A.m2", "A.m2", "A.m2", "N.m"))]
    values, notes = given(blocks, "source.y -> sink.u")
    np.testing.assert_allclose(values, [1e-3, 2.0, 3e3, 4e-3], rtol=1e-15)
    assert notes == []


def test_elements_connect_to_what_has_one_unit():
    blocks = [
        source(shape=(3,), unit=parse_unit("A.m2")),
        source(unit=parse_unit("mN.m")),
        sink(**applied("A.m2", "N.m")),
    ]
    blocks[1].name = "motor"
    values, notes = given(blocks, "source.y[3] -> sink.u[1]", "motor.y -> sink.u[2]")
    np.testing.assert_allclose(values, [3.0, 1e-3], rtol=1e-15)
    assert notes == []


@pytest.mark.parametrize(
    ("units", "connection", "message"),
    [
        (("A.m2", "A.m2"), "source.y -> sink.u", r"source.y\[2\] is in A.m2, sink.u\[2\] in N.m"),
        (("N.m", "A.m2"), "source.y[1] -> sink.u[1]", r"source.y\[1\] is in N.m, sink.u\[1\] in A.m2"),
        (("A.m2", "N.m"), "source.y[1] -> sink.u[2]", r"source.y\[1\] is in A.m2, sink.u\[2\] in N.m"),
    ],
)
def test_an_element_that_does_not_fit_is_named(units, connection, message):
    with pytest.raises(InputError, match=rf"connections\[1\].*the units do not fit: {message}"):
        given([source(**applied(*units)), sink(**applied("A.m2", "N.m"))], connection)


UNKNOWN = Unit("N.m", None, 1.0, 0.0)
"""A unit that an FMU names without defining it."""


@pytest.mark.parametrize(
    ("given_in", "wanted_in", "note"),
    [
        (UNKNOWN, parse_unit("N.m"), None),
        (Unit("widget", None, 1.0, 0.0), parse_unit("N.m"), "source.y in widget feeds sink.u in N.m as it is"),
        (None, parse_unit("mN.m"), "source.y has no unit, so that of sink.u, mN.m, is taken for granted"),
        (parse_unit("mN.m"), None, "sink.u has no unit, so that of source.y, mN.m, is taken for granted"),
    ],
)
def test_a_value_whose_unit_is_not_known_is_taken_as_it_is_with_a_note(given_in, wanted_in, note):
    values, notes = given([source(unit=given_in), sink(unit=wanted_in)], "source.y -> sink.u")
    assert values == [1.0]
    assert [note in each for each in notes] == ([] if note is None else [True])


@pytest.mark.parametrize(
    ("connection", "message"),
    [
        ("source.y -> sink.u", "the shapes differ"),
        ("sink.u -> sink.u", "sink.u is an input; expected an output of sink"),
        ("source.y -> source.y", "source.y is an output; expected an input of source"),
    ],
)
def test_ends_that_do_not_fit_are_named(connection, message):
    with pytest.raises(InputError, match=message):
        given([source(shape=(2,)), sink()], connection)


def test_start_values_and_expectations_are_in_the_unit_of_their_element():
    block = sink(**applied("A.m2", "N.m"))
    scenario = {
        "step": 1,
        "duration": 1,
        "record": {"signals": ["sink.u"]},
        "expect": [{"name": "e", "signal": "sink.u[2]", "always": {"within": ["1.9 mN.m", "2.1 mN.m"]}}],
    }
    result = mocks.run([block], scenario, start={"sink": {"u": ["3 mA.m2", "2 mN.m"]}})
    assert result["sink.u"][0].tolist() == pytest.approx([3e-3, 2e-3], rel=1e-15)
    assert result.passed
    with pytest.raises(InputError, match="does not fit"):
        mocks.run([sink(**applied("A.m2", "N.m"))], {"step": 1, "duration": 1}, start={"sink": {"u": [1, "2 A.m2"]}})


def test_a_fault_is_in_the_unit_of_its_element():
    blocks = [source(**applied("A.m2", "N.m")), sink(**applied("A.m2", "N.m"))]
    values, _ = given(
        blocks, "source.y -> sink.u", faults=[{"at": 0, "bias": "source.y", "by": ["1 A.m2", "500 mN.m"]}]
    )
    assert values == [2.0, 2.5]


def test_an_optional_input_may_stay_unconnected_and_no_other():
    assert given([source(), sink(optional=True)])[0] == [0.0]
    with pytest.raises(
        InputError,
        match="the input u is neither connected nor given a value; remedy: a connection, or a value under 'start'$",
    ):
        given([source(), sink()])


def test_an_optional_input_is_connected_as_a_whole_or_not_at_all():
    with pytest.raises(
        InputError, match=r"the input u\[2\] is neither .*; u is optional: it may also stay unconnected as a whole"
    ):
        given([source(), sink(shape=(2,), optional=True)], "source.y -> sink.u[1]")
