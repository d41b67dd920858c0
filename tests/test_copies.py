"""The Python blocks import none of each other, so each keeps the vectors, rotations and dates that it needs: equal to the letter."""

from __future__ import annotations

import ast
from collections import defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FILES = (
    *("allocator/vector.py", "controller/so3.py", "estimator/so3.py", "plant/so3.py", "supervisor/so3.py"),
    *("plant/judge/reference.py", "estimator/onboard.py", "plant/time_scales.py", "supervisor/reference.py"),
)
OTHERS = {"lvlh", "sidereal_angle"}
"""Of the same name and another content: the judge's and the supervisor's LVLH, onboard and reference models of the Earth's turn."""


def functions() -> dict[str, dict[str, str]]:
    """The code of each function that two files or more have, by name and file."""
    found: dict[str, dict[str, str]] = defaultdict(dict)
    for file in FILES:
        text = (ROOT / file).read_text("utf-8")
        for node in ast.parse(text).body:
            if isinstance(node, ast.FunctionDef):
                found[node.name][file] = ast.get_source_segment(text, node) or ""
    return {name: copies for name, copies in found.items() if len(copies) > 1 and name not in OTHERS}


COPIES = functions()


@pytest.mark.parametrize("name", sorted(COPIES))
def test_a_function_that_two_blocks_have_is_the_same_in_both(name):
    (first, code), *others = COPIES[name].items()
    for file, other in others:
        assert other == code, f"{name} in {file} and in {first}"


def test_the_copies_are_those_that_decision_5_counts():
    counted = (ROOT / "docs" / "decisions" / "0005-where-vectors-and-rotations-stand.md").read_text("utf-8")
    for name, copies in COPIES.items():
        assert f"| `{name}` | {len(copies)} |" in counted
