"""Errors as data: their text is made of place, expected, found and remedy."""

from __future__ import annotations

import pickle

import pytest

from orchestration.errors import InputError, Place, Problem, Problems
from orchestration.scenario.source import Source

PLACE = Place("loop.yaml", 14, "blocks.motor.every")


@pytest.mark.parametrize(
    ("problem", "text"),
    [
        (Problem("must not be empty", place=PLACE), "loop.yaml:14: blocks.motor.every: must not be empty"),
        (Problem(expected="1 or more", found="0"), "expected 1 or more, found 0"),
        (Problem("no such step", expected="1 s", remedy="every: 2"), "no such step; expected 1 s; remedy: every: 2"),
        (Problem("not valid:\n  a port", remedy="mend it"), "not valid:\n  a port\n  remedy: mend it"),
        (Problem("wrong", place=Place("--set a.b=1")), "--set a.b=1: wrong"),
        (Problem("wrong", place=Place(name="connections[1]")), "connections[1]: wrong"),
        (Problem("wrong", place=Place()), "scenario: wrong"),
    ],
)
def test_the_text_of_an_error_names_its_place_what_is_expected_and_the_remedy(problem, text):
    assert str(problem) == str(InputError(problem)) == text


def test_an_error_that_is_placed_again_keeps_its_first_place_in_its_text_and_its_remedy_at_the_end():
    inner = Problem(expected="a number", remedy="write one", place=Place("part.yaml", 3), kind="damaged")
    outer = inner.at(PLACE)
    assert (outer.place, outer.remedy, outer.kind) == (PLACE, "write one", "damaged")
    assert str(outer) == f"{PLACE}: part.yaml:3: expected a number; remedy: write one"


def test_an_error_in_a_line_of_a_named_file_stays_there_and_one_of_the_whole_file_is_placed_where_it_is_named():
    source = Source({}, "over.yaml", lines={("extends",): 2})
    with pytest.raises(InputError) as caught, source.naming(("extends",)):
        raise InputError(Problem("no valid YAML", place=Place("part.yaml", 7)), "part.yaml: is empty")
    assert caught.value.messages == ("part.yaml:7: no valid YAML", "over.yaml:2: extends: part.yaml: is empty")


def _gather(*texts: str) -> None:
    with Problems() as problems:
        for text in texts:
            with problems.gathered():
                raise InputError(text)


def test_gathered_errors_are_raised_together_and_none_where_there_are_none():
    _gather()
    with pytest.raises(InputError) as caught:
        _gather("first", "second")
    assert caught.value.messages == ("first", "second")


def test_an_error_keeps_its_fields_in_another_process():
    error = pickle.loads(pickle.dumps(InputError(Problem("wrong", place=PLACE), "text")))
    assert error.problems == (Problem("wrong", place=PLACE), Problem("text"))
