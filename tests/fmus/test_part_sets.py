"""One interface file describes a block for one wheel and the block for a set of them."""

from __future__ import annotations

import pytest

from fmus.interface import InterfaceError, load, parse
from fmus.native.generate import ports_header, table

TOY = """
[block]
name = "toy"
description = "Toy"
[sets.wheel]
block = "toy_wheels"
count = 3
description = "Toy with wheels"
[experiment]
stop = 1.0
step = 0.1
[variables.command]
causality = "input"
each = "wheel"
description = "Command"
start = 0.5
[variables.given]
causality = "output"
each = "wheel"
description = "Given"
depends_on = ["command"]
initially_depends_on = ["command", "axis", "wheels"]
[variables.total]
causality = "output"
description = "Total"
depends_on = ["command"]
initially_depends_on = ["@all"]
[variables.axis]
causality = "parameter"
each = "wheel"
variability = "fixed"
shape = [3]
description = "Axis"
start = [1.0, 0.0, 0.0]
[variables.wheels]
causality = "parameter"
only = "wheel"
type = "integer"
variability = "fixed"
description = "How many"
start = 1
[groups]
all = ["command", "wheels"]
"""
OF_SET = TOY.replace("[block]\n", '[block]\nset = "wheel"\n', 1)


def test_for_one_wheel_the_variables_have_no_index_and_those_of_the_set_are_not_there() -> None:
    toy = parse(TOY)
    assert toy.name == toy.code == "toy"
    assert list(toy.elements)[:6] == ["command", "given", "total", "axis[1]", "axis[2]", "axis[3]"]
    assert "wheels" not in toy.variables
    assert toy.variables["given"].initially_depends_on == ("command", "axis")
    assert toy.variables["total"].initially_depends_on == ("command",)


def test_for_a_set_each_wheel_has_its_elements_starts_and_dependencies() -> None:
    toy = parse(OF_SET)
    assert (toy.name, toy.code, toy.sets) == ("toy_wheels", "toy", {"wheel": 3})
    assert toy.variables["axis"].shape == (3, 3)
    assert toy.variables["axis"].start == [[1.0, 0.0, 0.0]] * 3
    assert [e.name for e in toy.variables["given"].elements] == ["given[1]", "given[2]", "given[3]"]
    assert [e.name for e in toy.feedthrough(toy.variables["given"], 1)] == ["command[2]"]
    assert len(toy.feedthrough(toy.variables["total"], 0)) == 3


def test_the_c_has_arrays_for_one_wheel_too_and_the_table_names_their_only_element_without_index() -> None:
    for text, count in ((TOY, 1), (OF_SET, 3)):
        header = ports_header(parse(text))["toy_ports.h"]
        assert f"#define TOY_WHEELS {count}" in header
        assert "double command[TOY_WHEELS];" in header
        assert "double axis[TOY_WHEELS][3];" in header
    assert 'ROW("command", u.command[0],' in table(parse(TOY))
    assert 'ROW("axis[2]", p.axis[0][1],' in table(parse(TOY))
    assert 'ROW("axis[2,3]", p.axis[1][2],' in table(parse(OF_SET))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TOY.replace('each = "wheel"', 'each = "rod"', 1), "variables.command: each: expected one of wheel, found"),
        (OF_SET.replace('set = "wheel"', 'set = "rod"'), "block: set: expected one of wheel, found 'rod'"),
        (TOY.replace('"@all"', '"@none"'), "variables.total: there is no group '@none'"),
    ],
)
def test_a_set_that_is_not_described_is_refused_by_name(text: str, message: str) -> None:
    with pytest.raises(InterfaceError, match=message):
        parse(text)


def test_the_terminals_of_a_set_do_not_fit_those_of_one_wheel() -> None:
    one, four = load("plant").terminals, load("plant_wheels").terminals
    assert set(four) - set(one) == {"actuator_commands_of_wheels", "wheel_momentum_of_wheels"}
    assert set(four) - set(one) <= set(load("controller_wheels").terminals)


def test_the_plant_for_a_set_has_all_that_the_one_for_one_wheel_has() -> None:
    one, four = load("plant"), load("plant_wheels")
    assert four.code == "plant"
    assert set(four.variables) - set(one.variables) == {"wheels", "wheel_gain", "wheel_breakaway_friction"} | {
        "wheel_static_imbalance",
        "wheel_dynamic_imbalance",
        "wheel_position_B",
    }
    changed = [n for n, v in one.variables.items() if v.shape != four.variables[n].shape]
    assert all(four.variables[n].shape == (4, *one.variables[n].shape) for n in changed)
    assert len(changed) == 13
