"""docs/how/planned.md states sizes and constants; they are those of the code."""

import math
import re
from decimal import Decimal

import pytest

from . import core

TEXT = (core.ROOT / "docs" / "how" / "planned.md").read_text("utf-8")
SOURCE = "\n".join(path.read_text("utf-8") for path in sorted(core.NATIVE.rglob("*.[ch]")))


def test_the_sizes_are_those_of_the_structures():
    (stated,) = re.findall(r"(\d+) KB of state and (\d+) KB of workspace", TEXT)
    assert [int(x) for x in stated] == [math.ceil(size / 1024) for size in core.sizes()]


def _rows():
    for names, values in re.findall(r"^\| (`[A-Z_`, ]+`) \| ([-\d.e, ]+) \|", TEXT, flags=re.MULTILINE):
        yield from zip(re.findall(r"`(\w+)`", names), values.split(", "), strict=True)


@pytest.mark.parametrize(("name", "value"), list(_rows()))
def test_a_constant_has_the_value_that_the_page_states(name, value):
    (found,) = re.findall(rf"\b{name} = ([-\d.e]+)[,;]", SOURCE)
    digits = len(Decimal(value).as_tuple().digits)
    assert float(f"{float(found):.{digits}g}") == float(value), f"docs/how/planned.md states {name} = {value}"


def test_the_table_is_read():
    assert len(list(_rows())) >= 15
