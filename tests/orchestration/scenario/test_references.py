"""What texts of a scenario name, and what of them is refused."""

from __future__ import annotations

import pytest

from orchestration.errors import InputError
from orchestration.scenario.references import Assignment
from orchestration.scenario.view import Prism


def test_an_assignment_has_a_port_and_a_value_of_yaml():
    one = Assignment("plant.friction = [0.1 N.m, 2]")
    assert (str(one.target), one.value) == ("plant.friction", ["0.1 N.m", 2])


@pytest.mark.parametrize("text", ["plant.friction", "plant.friction =", "= 0.1", "=", " = "])
def test_an_assignment_lacks_neither_its_port_nor_its_value(text):
    with pytest.raises(InputError, match=r"expected block\.parameter = value, found "):
        Assignment(text)


def test_a_body_without_lengths_is_a_cube():
    body = Prism.model_validate({})
    assert (body.length, body.width, body.sides) == (1.0, 1.0, 4)
