"""Values that a user writes for a variable."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmus.units import Unit
from orchestration.quantities import QuantityError, parse_unit
from orchestration.system.values import scalar
from tests.commands import orchestrate

from ..mocks import real

PAPER = Path(__file__).parents[3] / "scenarios" / "paper_no_singularity.yaml"


@pytest.mark.parametrize(
    ("value", "remedy"),
    [
        (51.6, "; a bare number is in rad, remedy: '51.6 deg'"),
        ("51.6", "; a bare number is in rad, remedy: '51.6 deg'"),
        (516, ""),
        ("516 deg", ""),
    ],
)
def test_a_bare_number_that_is_right_in_the_unit_shown_gets_a_remedy(value, remedy):
    angle = real("i", "parameter", unit=parse_unit("rad"), display_unit=parse_unit("deg"), maxima=(3.2,))
    with pytest.raises(QuantityError) as info:
        scalar(angle, 0, value)
    assert str(info.value).endswith(("rad", "(516 deg)")[value == "516 deg"] + remedy)


def test_a_height_given_as_a_radius_gets_the_input_that_takes_heights():
    told = orchestrate("validate", PAPER, "--set", "plant.orbit_radius=500 km").stderr
    assert told.endswith("found 500000 m (500 km); did you mean 'altitude: 500 km'?\n")


@pytest.mark.parametrize(("output", "start"), [("omega_B", "; did you mean 'omega_B0'?"), ("b_B", "")])
def test_an_output_gets_the_parameter_that_it_starts_at_and_none_that_is_spelt_alike(output, start):
    told = orchestrate("validate", PAPER, "--set", f"plant.{output}=1").stderr
    assert told.endswith(f"plant.{output} is an output; only parameters and inputs take start values{start}\n")


@pytest.mark.parametrize(
    ("value", "found"),
    [
        ("20 kW", "20 kW"),
        ("20.0kW ", "20 kW"),
        ("20", "20 kW"),
        (20, "20 kW"),
        ("2e4 W", "20 kW (2e4 W)"),
    ],
)
def test_a_value_beyond_the_limits_is_said_as_written_only_where_that_differs(value, found):
    gain = real("gain", "parameter", unit=parse_unit("kW"), maxima=(10.0,))
    with pytest.raises(QuantityError) as info:
        scalar(gain, 0, value)
    assert str(info.value) == f"expected at most 10 kW, found {found}"


@pytest.mark.parametrize(("value", "found"), [("3 widget", 3.0), (" 3e1widget ", 30.0), ("3", 3.0), (3, 3.0)])
def test_a_unit_that_the_fmu_names_without_defining_it_is_only_itself(value, found):
    count = real("n", "parameter", unit=Unit("widget", None, 1.0, 0.0))
    assert scalar(count, 0, value) == found
    with pytest.raises(QuantityError):
        scalar(count, 0, "3 m")
