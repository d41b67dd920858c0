"""The table of what lasts, test_states.toml: each state of the flight blocks, the shell and the link in C, and of the
Python objects that fly, with the test that takes it there twice.

A key is `each step` (set anew by every step from inputs and parameters, or the time itself), `start` (set before the
first step, or of the object's own resources), `once` (no test takes it there twice) or a test; its value lists the
states. A state without a row, and a row
without a state or a test, fail here.
"""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TABLE = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
BLOCKS = {
    "allocator/native": "AllocatorState",
    "allocator/bounded/native": "AllocatorBoundedState",
    "controller/native": "ControllerState",
    "controller/planned/native": "ControllerPlannedState",
    "controller/planned/wheels/native": "ControllerPlannedWheelsState",
    "controller/wheels/native": "ControllerWheelsState",
    "estimator/native": "EstimatorState",
    "fmus/link/native": "Link",
    "fmus/native/shell": "Memory",
    "plant/judge/native": "PlantJudgeState",
    "plant/native": "PlantState",
    "plant/sensors/native": "PlantSensorsState",
    "supervisor/native": "SupervisorState",
}
"""By folder: the structure that a block, the shell or the link keeps from step to step."""
VALUES = {"Motion", "Scales", "Covariance", "Sensitivity", "Ports", "Line", "LinkReader"}
"""Structures that are one value, or are tested on their own."""
PACKAGES = ("campaign", "instances", "master", "session")
NO_TESTS = ("each step", "start", "once")


def structures(folder: Path) -> dict[str, dict[str, str]]:
    """Type of each member of each structure in the headers of a folder."""
    found: dict[str, dict[str, str]] = {}
    for header in sorted(folder.rglob("*.h")):
        text = re.sub(r"/\*.*?\*/|^#.*?$", "", header.read_text("utf-8"), flags=re.DOTALL | re.MULTILINE)
        for body, name in re.findall(r"typedef struct \{((?:[^{}]|\{[^{}]*\})*)\} (\w+);", text):
            inner = re.sub(r"struct \{[^{}]*\}", "struct", body)
            members = re.findall(r"(?:const )?(\w+) ([^;]+);", inner)
            found[name] = {
                re.sub(r"\[.*|\*", "", one).strip(): kind for kind, all_ in members for one in all_.split(",")
            }
    return found


def lasting(folder: str) -> Iterator[tuple[str, str]]:
    """Yields structure and member of all that a block keeps; of a structure in it its members."""
    known = structures(ROOT / folder)
    left, seen = [BLOCKS[folder]], set[str]()
    while left:
        name = left.pop()
        seen.add(name)
        for member, kind in known[name].items():
            if kind in known and kind not in VALUES:
                left += [kind] if kind not in seen else []
            else:
                yield name, member


@cache
def attributes(package: str) -> set[tuple[str, str]]:
    """Class and attribute of all that a method other than the constructor sets."""
    found = set()
    for path in sorted((ROOT / "orchestration" / package).rglob("*.py")):
        for one in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(one, ast.ClassDef):
                methods = [m for m in one.body if isinstance(m, ast.FunctionDef) and m.name != "__init__"]
                found |= {
                    (one.name, node.attr)
                    for method in methods
                    for node in ast.walk(method)
                    if isinstance(node, ast.Attribute)
                    and isinstance(node.ctx, ast.Store)
                    and isinstance(node.value, ast.Name)
                    and node.value.id == "self"
                }
    return found


def rows(place: str) -> list[tuple[str, str, str]]:
    """Structure or class, state, and the key under which it stands."""
    return [(name, state, key) for name, of in TABLE[place].items() for key, states in of.items() for state in states]


@pytest.mark.parametrize("place", [*BLOCKS, *PACKAGES])
def test_each_lasting_state_has_one_row(place: str) -> None:
    there = set(lasting(place)) if place in BLOCKS else attributes(place)
    listed = [(name, state) for name, state, _ in rows(place)]
    assert sorted(listed) == sorted(set(there))


def test_the_table_has_no_other_place() -> None:
    assert set(TABLE) == {*BLOCKS, *PACKAGES}


def test_each_test_of_the_table_is_there() -> None:
    for place in TABLE:
        for _, _, key in rows(place):
            if key not in NO_TESTS:
                file, name = key.split("::")
                assert f"def {name}(" in (ROOT / "tests" / file).read_text("utf-8"), key


def test_a_member_of_a_structure_is_found_with_its_type(tmp_path: Path) -> None:
    (tmp_path / "a.h").write_text(
        "typedef struct {\n    double x, y[3]; /* no; member */\n    const char *at;\n"
        "    struct {\n        int i;\n    } told[2];\n} A;\ntypedef struct {\n    A a;\n} B;\n"
    )
    members = {"x": "double", "y": "double", "at": "char", "told": "struct"}
    assert structures(tmp_path) == {"A": members, "B": {"a": "A"}}
