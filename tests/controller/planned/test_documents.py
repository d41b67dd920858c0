"""The pages docs/how/planned*.md state sizes and constants; they are those of the code, and its files name sections of
them."""

import math
import re
from decimal import Decimal

import pytest

from . import core

PAGES = {path.name: path.read_text("utf-8") for path in sorted((core.ROOT / "docs" / "how").glob("planned*.md"))}
TEXT = "\n".join(PAGES.values())
SOURCES = {path: path.read_text("utf-8") for path in sorted(core.NATIVE.rglob("*.[ch]"))}


def test_the_sizes_are_those_of_the_structures():
    (stated,) = re.findall(r"(\d+) KB of state and (\d+) KB of workspace", TEXT)
    assert [int(x) for x in stated] == [math.ceil(size / 1024) for size in core.sizes()]


STATED = re.findall(r"`([A-Z_]+)` = (\d[\d.e-]*)", TEXT)


@pytest.mark.parametrize(("name", "value"), STATED)
def test_a_constant_has_the_value_that_the_pages_state(name, value):
    (found,) = re.findall(rf"\b{name} = ([-\d.e]+)[,;]", "\n".join(SOURCES.values()))
    digits = len(Decimal(value.rstrip(".")).as_tuple().digits)
    assert float(f"{float(found):.{digits}g}") == float(value), f"docs/how states {name} = {value}"


def test_the_values_are_read():
    assert len(STATED) >= 15


@pytest.mark.parametrize("path", [path for path in SOURCES if path.suffix == ".c"], ids=lambda path: path.stem)
def test_each_c_file_names_the_section_that_derives_it_and_its_tests(path):
    head = SOURCES[path].partition("#include")[0].replace("\n *", "")
    page, section = re.findall(r"docs/how/(planned[\w-]*\.md), ([\w ]+)", head)[0]
    section = section.strip()
    assert re.search(rf"^#+ {section}$", PAGES[page], flags=re.MULTILINE), f"{page} has no section {section}"
    tests = re.findall(r"test_\w+\.py", head)
    assert tests
    assert all((core.ROOT / "tests" / "controller" / "planned" / name).exists() for name in tests)
