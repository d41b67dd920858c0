"""Parameters that are times of so many steps of their block: the period of a sampled law, and the time that a command
acts."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmus.interface import InterfaceError, parse
from orchestration import InputError, load
from orchestration.fmu.model import Element, Model
from orchestration.session.open import open_scenario
from orchestration.system import periods

FLIGHT = Path(__file__).parents[3] / "scenarios" / "flight_vb.yaml"
"""Controller and allocator are stepped once in five base steps."""


def notes(**changes: object) -> list[str]:
    values = {name.replace("__", "."): value for name, value in changes.items() if name != "step"}
    source = load(FLIGHT, values).source.with_value("step", changes["step"], "--step")
    return [note for note in open_scenario(load(source)).plan.notes if "is less than the step" in note]


@pytest.mark.parametrize(
    ("step", "period", "block", "remedy"),
    [
        ("0.04 s", "0.5 s", "0.2 s (5 base steps of 0.04 s)", "0.4 s or 0.6 s"),
        ("0.2 s", "0.5 s", "1 s (5 base steps of 0.2 s)", "1 s or 2 s"),
        ("0.1 s", "1.2 s", "0.5 s (5 base steps of 0.1 s)", "1 s or 1.5 s"),
    ],
)
def test_a_period_of_control_that_its_steps_do_not_divide_is_refused_by_name_and_value(step, period, block, remedy):
    """Samples would come at 0.6, 1, 1.6 s ... in the first of these, and each second, twice the period, in the
    second."""
    with pytest.raises(InputError) as error:
        notes(step=step, controller__control_period=period)
    message = (
        f"expected a multiple of the step of controller, {block}, found {period}; remedy: {remedy}, or another step"
    )
    assert str(error.value).endswith(message)
    assert f"controller.control_period={period}: expected" in str(error.value)


@pytest.mark.parametrize(("step", "period"), [("0.04 s", "0.6 s"), ("0.02 s", "0.3 s"), ("0.1 s", "0.5000000000001 s")])
def test_a_period_that_is_a_multiple_but_for_rounding_is_taken(step, period):
    assert notes(step=step, controller__control_period=period) == []


def test_the_line_of_a_wrong_step_is_named_where_the_period_has_its_default():
    with pytest.raises(InputError, match=r"flight_vb\.yaml:\d+: blocks\.controller\.start\.control_period: expected"):
        notes(step="0.04 s")


def test_an_fmu_with_the_name_of_a_block_of_ours_and_without_its_period_is_taken():
    scenario = load(FLIGHT)
    other = Model("controller_planned", {})
    assert periods.notes(scenario, {"controller": other}, {"controller": []}) == []


def test_a_command_that_acts_for_longer_than_the_allocator_takes_into_account_is_warned_of():
    assert notes(step="0.2 s", controller__control_period="1 s", allocator__command_period="1 s") == []
    (note,) = notes(step="0.2 s", controller__control_period="1 s")
    assert note == (
        "allocator.command_period = 0.5 s is less than the step of allocator, 1 s (5 base steps of 0.2 s); "
        "remedy: 1 s or more, or a smaller step"
    )


@pytest.mark.parametrize("entry", ['unit = "s"\nsteps = "half"', 'unit = "m"\nsteps = "whole"'])
def test_an_interface_counts_times_in_whole_steps_or_in_one_at_least(entry):
    text = (
        '[block]\nname = "a"\ndescription = ""\n[experiment]\nstop = 1\nstep = '
        '0.1\n[variables.period]\ncausality = "parameter"\n'
    )
    with pytest.raises(
        InterfaceError, match=r"variables\.period: steps: expected 'whole' or 'at least one' at a scalar"
    ):
        parse(f'{text}variability = "fixed"\ndescription = ""\nstart = 1.0\n{entry}\n')


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_an_fmu_whose_period_starts_at_no_finite_time_is_refused_with_its_block(value):
    scenario = load(FLIGHT)
    model = Model("controller_planned", {}, starts={Element("sample_period", 0): value})
    message = rf"flight_vb\.yaml:\d+: blocks\.controller: its FMU's start value of sample_period is {value}; expected a"
    with pytest.raises(InputError, match=message):
        periods.notes(scenario, {"controller": model}, {"controller": []})
