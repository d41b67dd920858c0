"""A file of the product has at most 250 lines, or says in its first lines why it has more (CONTRIBUTING.md, Style)."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = (
    "allocator",
    "controller",
    "design",
    "docs",
    "estimator",
    "examples",
    "fmus",
    "orchestration",
    "plant",
    "release",
    "evidence",
    "supervisor",
)
LINES_MAX, HEAD = 250, 20
SUFFIXES = (".py", ".c", ".h", ".js")
LONG = {
    path.relative_to(ROOT).as_posix(): lines
    for package in PACKAGES
    for path in sorted((ROOT / package).rglob("*"))
    if path.suffix in SUFFIXES and "build" not in path.parts
    for lines in [path.read_text("utf-8").splitlines()]
    if len(lines) > LINES_MAX and "do not edit" not in "".join(lines[:4])
}


@pytest.mark.parametrize("name", LONG)
def test_a_long_file_says_why(name: str) -> None:
    assert any("Longer than 250 lines: " in line for line in LONG[name][:HEAD]), (
        f"{name} has {len(LONG[name])} lines; expected at most {LINES_MAX}, or 'Longer than 250 lines: WHY' "
        f"in the first {HEAD}"
    )


def test_only_a_long_file_says_so() -> None:
    said = {
        path.relative_to(ROOT).as_posix()
        for package in PACKAGES
        for suffix in SUFFIXES
        for path in (ROOT / package).rglob(f"*{suffix}")
        if "Longer than 250 lines: " in path.read_text("utf-8")
    }
    assert said <= set(LONG)


def test_a_file_of_tests_has_at_most_400_lines() -> None:
    files = (ROOT / "tests").rglob("test_*.py")
    assert [path.name for path in files if len(path.read_text("utf-8").splitlines()) > 400] == []
