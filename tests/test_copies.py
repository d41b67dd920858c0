"""The Python blocks import none of each other, so each keeps the vectors, rotations and dates that it needs: equal to
the letter."""

from __future__ import annotations

import ast
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest

from estimator import tables as gauss_models
from fmus.interface import ABSENT_MIN
from plant.tables import field_models

ROOT = Path(__file__).parents[1]
FILES = (
    *("allocator/vector.py", "controller/so3.py", "estimator/so3.py", "plant/so3.py", "supervisor/so3.py"),
    *("plant/judge/reference.py", "estimator/onboard.py", "plant/time_scales.py", "supervisor/reference.py"),
)
PIECES = {
    ("estimator/tables/__init__.py", "plant/tables/field_models.py"): ("_WMM", "_package_file"),
    ("allocator/block.py", "allocator/bounded/parameters.py"): ("UNIT_TOLERANCE",),
    ("allocator/block.py", "allocator/bounded/allocation.py"): ("INDEPENDENT_MIN",),
    ("controller/block.py", "plant/judge/block.py"): (
        *("REFERENCES", "REFERENCE_TOLERANCE", "Parameters.desired_attitude_0"),
    ),
}
"""Constants, functions and methods that two FMUs have, each of which carries its own folder alone: a nested block
too."""
OTHERS = {"lvlh", "sidereal_angle"}
"""Of the same name and another content: the judge's and the supervisor's LVLH, onboard and reference models of the
Earth's turn."""


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


def piece(file: str, name: str) -> str:
    """The code of a constant, of a function, or of a method as Class.method."""
    text = (ROOT / file).read_text("utf-8")
    body: list[ast.stmt] = ast.parse(text).body
    *owners, last = name.split(".")
    for owner in owners:
        body = next(node.body for node in body if isinstance(node, ast.ClassDef) and node.name == owner)
    for node in body:
        names = [node.name] if isinstance(node, ast.FunctionDef) else []
        if isinstance(node, ast.Assign):
            names = [target.id for target in node.targets if isinstance(target, ast.Name)]
        if last in names:
            return ast.get_source_segment(text, node) or ""
    raise AssertionError(f"{file} has no {name}")


@pytest.mark.parametrize(("files", "name"), [(files, name) for files, names in PIECES.items() for name in names])
def test_a_piece_that_two_fmus_have_is_the_same_in_both(files, name):
    first, second = files
    assert piece(second, name) == piece(first, name), f"{name} in {second} and in {first}"


THRESHOLDS = sorted(
    path.relative_to(ROOT).as_posix()
    for package in ("allocator", "controller", "estimator", "plant", "supervisor")
    for path in (ROOT / package).rglob("*.py")
    if "\nABSENT_MIN = " in path.read_text("utf-8")
)


@pytest.mark.parametrize("file", THRESHOLDS)
def test_a_block_takes_an_input_as_not_connected_where_the_interface_does(file):
    assert float(piece(file, "ABSENT_MIN").removeprefix("ABSENT_MIN = ")) == ABSENT_MIN


def test_all_thresholds_are_looked_at():
    assert len(THRESHOLDS) == 6


@pytest.mark.parametrize("name", sorted(COPIES))
def test_a_function_that_two_blocks_have_is_the_same_in_both(name):
    (first, code), *others = COPIES[name].items()
    for file, other in others:
        assert other == code, f"{name} in {file} and in {first}"


@pytest.mark.parametrize("name", field_models.NAMES)
def test_truth_and_onboard_model_read_the_same_coefficients(name):
    """By two readers, each for its own shape of data; the onboard model begins in 2000."""
    truth, onboard = field_models.from_package(name), gauss_models.gauss_model(name)
    first = truth.epochs.index(onboard.years[0])
    assert tuple(onboard.years) == truth.epochs[first:]
    terms = tuple(np.transpose(gauss_models.TERMS))
    for ours, theirs in ((onboard.g, truth.g), (onboard.h, truth.h)):
        np.testing.assert_array_equal(ours, np.array([values[terms] for values in theirs[first:]]))
    if name != "igrf14":  # whose rate of a prediction is the truth's own
        np.testing.assert_array_equal(onboard.g_rate, truth.g_dot[terms])
        np.testing.assert_array_equal(onboard.h_rate, truth.h_dot[terms])
