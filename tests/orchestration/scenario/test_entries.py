"""Entries of a scenario: the shortest that serve, and what of others is refused, in the words that the user reads."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.sparse.csgraph import connected_components

from orchestration import InputError, load
from orchestration.scenario import expectations, mapping, metrics, orbit, scenario, telemetry, view
from orchestration.scenario.descriptions import descriptions
from orchestration.scenario.source import Source
from orchestration.scenario.text import parse
from orchestration.system.order import components

PERIOD = {"name": "n", "period": "90 min"}
PYTHON = {"name": "m", "python": "a:b", "signals": ["plant.x"]}
ROTATED = {"theirs": "q", "rotation": "mrp"}


@pytest.mark.parametrize(
    ("model", "data"),
    [
        (scenario.Cycle, PERIOD),
        (scenario.BlockEntry, {"python": "l", "differs": ["p"]}),
        (scenario.BlockEntry, {"fmu": "f", "interface": "i"}),
        (scenario.Data, {"mass": 0.5}),
        (expectations.HoldEntry, {"name": "h", "signal": "a.b", "keeps": ["a.c"]}),
        (expectations.Expectation, {"name": "e", "signal": "a.b", "zeros": 0, "during": ["p"]}),
        (orbit.OrbitEntry, {"tle": "t", "start": "s"}),
        (telemetry.Column, {"of": [["a"]]}),
        (telemetry.Column, {"of": ["a"], "matrix": [[1.0]]}),
        (metrics.Metric, PYTHON),
        (mapping.PortMap, ROTATED),
    ],
)
def test_the_least_of_a_name_a_list_and_a_number_serves(model: Any, data: dict[str, Any]) -> None:
    model.model_validate(data)


@pytest.mark.parametrize(
    ("model", "data", "told"),
    [
        (metrics.Metric, PYTHON | {"after": 1.0}, "a Python function goes without after"),
        (metrics.Metric, PYTHON | {"signal": "plant.x"}, "a Python function goes without signal"),
        (view.Prism, {"sides": "4"}, "valid integer"),
        (scenario.Data, {"mass": 0}, "expected a mass above zero, found 0"),
        (scenario.BlockEntry, {"fmu": "f", "memory": "2 XB"}, "expected an amount of memory such as '2 GB'"),
        (scenario.BlockEntry, {"fmu": "f", "memory": True}, "expected an amount of memory such as '2 GB'"),
        (scenario.BlockEntry, {"fmu": "f", "memory": "much"}, "expected an amount of memory such as '2 GB'"),
        (mapping.PortMap, {"theirs": "x", "scale": "0 mm"}, "scale: expected a number other than 0"),
        (mapping.PortMap, {"theirs": "x", "divide": 0}, "divide: expected a number other than 0"),
        (mapping.PortMap, {"theirs": "x", "matrix": 3}, "expected rows of numbers such as"),
        (mapping.PortMap, {"theirs": "x", "matrix": []}, "expected rows of numbers such as"),
        (mapping.PortMap, {"theirs": "x", "matrix": [1, 2]}, "expected rows of numbers such as"),
        (mapping.PortMap, {"theirs": "x", "matrix": [[1], [1, 2]]}, "expected rows of one length"),
    ],
)
def test_an_entry_that_is_wrong_says_what_was_expected(model: Any, data: dict[str, Any], told: str) -> None:
    with pytest.raises(ValidationError, match=told):
        model.model_validate(data)


@pytest.mark.parametrize(("of", "shape"), [("a", ()), (["a", "b"], (2,)), ([["a", "b"]], (1, 2))])
def test_a_column_has_the_shape_of_its_names(of: Any, shape: tuple[int, ...]) -> None:
    assert telemetry.Column.model_validate({"of": of}).shape == shape


def test_a_misspelt_key_of_an_entry_in_a_list_is_not_missing_as_well() -> None:
    expect = [{"name": "e", "signal": "a.b", "zeros": 0}, {"nam": "e", "signal": "a.b", "zeros": 0}]
    with pytest.raises(InputError) as caught:
        load({"name": "n", "step": 1, "duration": 1, "blocks": {"a": {"fmu": "allocator"}}, "expect": expect})
    assert "did you mean 'name'?" in str(caught.value)
    assert "missing" not in str(caught.value)


def test_a_campaign_is_told_from_a_scenario() -> None:
    with pytest.raises(InputError, match="is a campaign, which varies the scenario under 'scenario'"):
        load({"scenario": {"name": "n"}})


def test_what_is_open_over_lines_is_told_with_the_line_on_which_it_begins() -> None:
    with pytest.raises(InputError, match="from line 2 on"):
        parse("a: 1\nb: [1,\n  2\nc: 3\n")


def test_many_entries_are_read() -> None:
    assert len(parse("[" + "1," * 60_000 + "]").data) == 60_000


def test_entries_behind_one_that_is_taken_out_keep_their_lines() -> None:
    source: Source = parse("a:\n  - x: 1\n  - x: 2\n  - x: 3\nb:\n  - 1\n  - 2\n")
    left = source.without([("a", 0)])
    assert left.data == {"a": [{"x": 2}, {"x": 3}], "b": [1, 2]}
    lines = {("a", 0): 3, ("a", 0, "x"): 3, ("a", 1): 4, ("a", 1, "x"): 4, ("b", 0): 6, ("b", 1): 7}
    assert {key: line for key, line in left.lines.items() if len(key) > 1} == lines


def test_the_descriptions_of_a_model_are_also_those_that_it_inherits() -> None:
    found = descriptions(expectations.Expectation)
    assert found.keys() == set(expectations.Expectation.model_fields)
    assert found["after"] == "Only samples from this time on."


@pytest.mark.parametrize("seed", range(20))
def test_components_are_those_of_scipy_each_after_those_on_which_it_depends(seed: int) -> None:
    draw = np.random.default_rng(seed)
    needs = draw.random((12, 12)) < 0.12
    groups: list[list[Any]] = components({n: np.flatnonzero(row).tolist() for n, row in enumerate(needs)})
    label = connected_components(needs, directed=True, connection="strong")[1]
    assert {frozenset(group) for group in groups} == {frozenset(np.flatnonzero(label == k)) for k in set(label)}
    place = {node: n for n, group in enumerate(groups) for node in group}
    assert all(place[other] <= place[node] for node, other in np.argwhere(needs))
