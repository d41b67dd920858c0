"""YAML as text: what is written reads back, what is refused says why, and nothing of it ends the process."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from orchestration.errors import InputError
from orchestration.scenario.source import Source
from orchestration.scenario.text import _composed, _Plain, parse, written

ROOT = Path(__file__).parents[3]
DATA = {
    "texts": [
        "1e3",
        "5",
        ".5",
        "true",
        "null",
        "~",
        "2004-01-01",
        "0x10",
        "1_000",
        "yes",
        "",
        " a ",
        "a: b",
        "°",
        "<<",
    ],
    "numbers": [0.1, 1e-300, 1e22, -7, 0, float("inf")],
    "rest": {"true": True, "none": None, "empty": {}, "nested": [[1], [2, 3]]},
}


def test_what_is_written_reads_back_as_the_same_data():
    assert parse(written(DATA)).data == DATA


def test_both_parsers_give_all_scenarios_the_same_nodes():
    for path in sorted((ROOT / "scenarios").rglob("*.yaml")):
        if path.parent.parent.name == "templates":
            continue  # @NAME@ stands for values
        text = path.read_text("utf-8")
        fast, plain = _composed(text, Source(None)), yaml.compose(text, _Plain)
        assert yaml.serialize(fast) == yaml.serialize(plain), path


@pytest.mark.parametrize("text", ["[" * 100_000, "[" * 100_000 + "]" * 100_000, "a: " + "{b: " * 60 + "}" * 60])
def test_what_is_nested_without_end_is_refused(text):
    with pytest.raises(InputError, match="too many entries|no valid YAML"):
        parse(text)


def test_words_that_only_older_yaml_takes_for_booleans_stay_text():
    assert parse("a: [yes, off, y, True, 1_0.5, 1:30]").data == {"a": ["yes", "off", "y", True, "1_0.5", "1:30"]}
