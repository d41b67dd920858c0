"""A file of the product that names its tests names files that there are."""

from __future__ import annotations

import re

import pytest

from .test_sizes import PACKAGES, ROOT, SUFFIXES

TESTS = {"/" + path.relative_to(ROOT).as_posix() for path in (ROOT / "tests").rglob("*.py")}
NAMED = {
    path.relative_to(ROOT).as_posix(): found
    for package in (*PACKAGES, "design")
    for path in sorted((ROOT / package).rglob("*"))
    if path.suffix in SUFFIXES and "build" not in path.parts
    if (found := re.findall(r"[\w/]*\btest_\w+\.py", path.read_text("utf-8")))
}


@pytest.mark.parametrize("path", NAMED)
def test_the_tests_that_a_file_names_are_there(path: str) -> None:
    """By their path, or by the end of it."""
    assert [name for name in NAMED[path] if not any(test.endswith(f"/{name}") for test in TESTS)] == []
