"""Values that a user writes for a variable."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmus.units import Unit
from orchestration import InputError, load
from orchestration.fmu.model import Variable
from orchestration.quantities import QuantityError, parse_unit
from orchestration.session.open import open_scenario
from orchestration.system.values import item, scalar
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


def test_a_bare_number_that_is_the_limit_in_the_unit_shown_gets_a_remedy():
    radius = real("r", "parameter", unit=parse_unit("m"), display_unit=parse_unit("km"), minima=(6378e3,))
    with pytest.raises(QuantityError, match="remedy: '6378 km'$"):
        scalar(radius, 0, 6378)


def test_an_item_of_an_enumeration_is_given_by_its_name_or_number_and_by_nothing_else():
    mode = Variable("mode", "parameter", type="enumeration", references=(0,), items=(("off", 1), ("on", 2)))
    assert [item(mode, value) for value in ("off", 2)] == [1, 2]
    for value in (3, True, 1.0, "3"):
        with pytest.raises(QuantityError, match="expected one of off, on, found"):
            item(mode, value)


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


@pytest.mark.parametrize(
    ("name", "told"), [("exchange", "a file that extends it and has 'exchange'"), ("step", "--step '1'")]
)
def test_a_key_of_the_scenario_among_shared_values_is_told_with_the_remedy(name, told):
    extended = {"extends": str(PAPER), "shared": {name: 1}}
    with pytest.raises(InputError, match=f"{name} is no parameter but a key of the scenario; remedy: {told}"):
        open_scenario(load(extended))


@pytest.mark.parametrize(
    ("part", "told"),
    [
        (
            {"figures": [{"name": "f", "panels": [{"signals": ["plant.omega_B"]}], "window": [2, 2]}]},
            "the second after",
        ),
        ({"view": {"attitude": "plant.R_NB", "body": {"length": "plant.omega_B0"}}}, "expected a number"),
        ({"view": {"attitude": "plant.R_NB", "axes": {"a": "plant.orbit_radius"}}}, "expected directions"),
    ],
)
def test_a_window_has_a_length_and_parameters_of_a_view_have_their_shape(part, told):
    given = {"extends": str(PAPER), **part}
    with pytest.raises(InputError, match=told):
        open_scenario(load(given))
