"""Values that expressions make of others, in the places of start values."""

from __future__ import annotations

import numpy as np
import pytest

from orchestration.campaign.case import read_campaign
from orchestration.campaign.drawing.draws import _base_unit, _target
from orchestration.errors import InputError
from orchestration.fmu.model import Variable
from orchestration.quantities import parse_unit
from orchestration.scenario.source import StartName

from ..toy import changed, fly, rows


def test_one_value_with_an_error_between_two_blocks(toy):
    changed(
        toy,
        ("vary:", "draw:\n  k: {normal: {mean: 1, deviation: 0.1}}\n  e: {choice: [-0.1, 0.1]}\nvary:"),
        ("  motor.speed0", '  regulator.gain: {expression: "-k * (1 + e)"}\n  motor.speed0'),
    )
    fly(toy, runs=12)
    for row in rows():
        gain = row["k"] * (1.0 + row["e"])
        assert row["regulator.gain"] == -gain
        assert row["final"] == pytest.approx(row["motor.speed0"] * (1.0 - 0.1 * gain) ** 20, rel=1e-12)


def test_an_expression_counts_in_base_units(toy):
    changed(
        toy,
        ("vary:", "draw:\n  turn: {uniform: [60 rpm, 120 rpm]}\nvary:"),
        ("{uniform: [1 rad/s, 2 rad/s]}", '{expression: "turn / 10"}'),
    )
    fly(toy, runs=5)
    for row in rows():
        assert row["motor.speed0"] == pytest.approx(row["turn"] * 2.0 * np.pi / 60.0 / 10.0)


def test_an_expression_sets_whole_numbers_where_the_port_takes_them_and_no_others(toy):
    changed(toy, ("vary:", "draw:\n  half: {choice: [1, 2]}\nvary:\n  motor.poles: {expression: 2 * half}"))
    fly(toy, runs=8)
    assert {(row["half"], row["motor.poles"]) for row in rows()} == {(1.0, 2.0), (2.0, 4.0)}
    changed(toy, ("2 * half", "0.4 * half"))
    with pytest.raises(InputError, match="expected a whole number, found 0.8"):
        read_campaign(toy)


def test_a_column_is_in_the_unit_that_was_written_or_in_that_of_the_port_that_takes_it(toy):
    changed(
        toy,
        ("vary:", "draw:\n  turn: {uniform: [60 rpm, 120 rpm]}\n  k: {uniform: [1, 2]}\nvary:"),
        ("{uniform: [1 rad/s, 2 rad/s]}", "{expression: turn / 10}\n  motor.inertia: {uniform: [1, 2]}"),
    )
    assert {draw.name: draw.shown for draw in read_campaign(toy).job.draws.draws} == {
        "turn": "rpm",
        "k": "",
        "motor.speed0": "rad/s",
        "motor.inertia": "kg.m2",
    }


def test_what_an_expression_gives_to_a_vector_has_a_column_for_each_element(toy):
    changed(toy, ("vary:", 'draw:\n  k: {uniform: [1, 2]}\nvary:\n  motor.axis: {expression: "[k, 0, 2 * k]"}'))
    (draw,) = (one for one in read_campaign(toy).job.draws.draws if one.name == "motor.axis")
    assert draw.columns == ("motor.axis[1]", "motor.axis[2]", "motor.axis[3]")
    fly(toy, runs=3)
    for row in rows():
        assert [row[column] for column in draw.columns] == [row["k"], 0.0, 2.0 * row["k"]]


@pytest.mark.parametrize(("unit", "factor"), [("deg/s", np.pi / 180.0), ("rpm", np.pi / 30.0), ("mN.m", 1e-3)])
def test_the_base_unit_of_a_port_is_its_own_without_a_factor(unit, factor):
    own = parse_unit(unit)
    base = _base_unit(Variable("x", "parameter", unit=own))
    assert base.conversion(own) == pytest.approx((1.0 / factor, 0.0))
    for plain in (None, Variable("x", "parameter"), Variable("x", "parameter", unit=parse_unit("rad/s"))):
        assert _base_unit(plain) is None


def test_a_shared_value_is_that_of_the_first_block_that_takes_it(toy):
    models = read_campaign(toy).job.opened.plan.models
    assert list(models) == ["motor", "regulator"]
    for name, unit in (("shared.inertia", "kg.m2"), ("shared.gain", None)):
        found = _target(StartName.of(name), models)
        assert found is not None
        assert (found.unit and str(found.unit)) == unit
    assert _target(StartName.of("shared.nobody"), models) is None
