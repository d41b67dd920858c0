"""The interface of a block, read from `fmus/interfaces/<block>.toml`, where it is written once.

modelDescription.xml, the FMU wrappers, the interface pages and the swap check are derived from
what `load` returns. parsing.py describes the file. Tests: tests/fmus/test_rules.py.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from .kept import kept
from .parsing import ABSENT, ABSENT_INTEGER, ABSENT_MIN, SAMPLE_PERIOD, element_name, parse
from .variables import FLAVOURS, Element, Interface, InterfaceError, Variable

__all__ = [
    "ABSENT",
    "ABSENT_INTEGER",
    "ABSENT_MIN",
    "BLOCKS",
    "FLAVOURS",
    "INTERFACES",
    "SAMPLE_PERIOD",
    "SETS",
    "TRUTH",
    "Element",
    "Interface",
    "InterfaceError",
    "Variable",
]
__all__ += ["citations", "cites", "element_name", "load", "optional_text", "package_of", "parse"]

_OF_ONE = (
    *("plant", "controller", "allocator", "allocator_bounded"),
    *("plant_sensors", "plant_judge", "controller_planned", "controller_planned_wheels", "controller_wheels"),
    *("estimator", "supervisor"),
)
SETS = {f"{block}_wheels": (block, "wheel") for block in ("plant", "allocator_bounded", "plant_sensors", "estimator")}
"""Blocks that are another one for a set of parts: that block, whose package and file they share, and the set's name."""
BLOCKS: tuple[str, ...] = (*_OF_ONE, *SETS)
"""All blocks of this project. The block `a_b` is the package `a.b`, beside the block `a` and apart from it."""
LOOP = ("plant", "controller", "allocator")
"""Those that make a closed loop by the names of their ports; the others take the place of one of them or stand between.
"""
TRUTH = {"plant": "the plant's truth, for example by plant_judge"}
"""The blocks that are the truth to the others: what they say of themselves is no opinion. With what to read of them."""
INTERFACES = Path(__file__).parent / "interfaces"
"""The folder of the interfaces and the icons."""

SOURCE = (
    "Numbers in brackets are equations of Sanyal and Lee-Ho, Attitude Tracking Control of a Small Satellite in "
    "Low Earth "
    "Orbit (AIAA 2009-5902)."
)
"""The sentence of a page that shows citations such as [8]."""


def cites(text: str) -> bool:
    """Returns whether a text cites equations by their numbers in brackets; `omega_B[1]` is none."""
    return re.search(r"(?<![\w\]])\[\d+\]", text) is not None


def citations(interface: Interface) -> str:
    """SOURCE for an interface whose texts cite the paper; else nothing."""
    texts = [interface.description, *interface.limits, *(text for pair in interface.equations for text in pair)]
    texts += [v.description for v in (*interface.variables.values(), *interface.helpers.values())]
    return SOURCE if any(map(cites, texts)) else ""


def optional_text(variable: Variable) -> str:
    """Returns the pages' words on an optional input: the value that means that it is not connected."""
    return f"optional; {'-1' if variable.type == 'integer' else '1e9'} means not connected"


@cache
def load(block: str) -> Interface:
    """The interface of a block of this project, such as "plant". Read once in a process."""
    file, parts = SETS.get(block, (block, ""))
    text = (INTERFACES / f"{file}.toml").read_text("utf-8")
    if parts:
        text = text.replace("[block]\n", f'[block]\nset = "{parts}"\n', 1)
    code = [Path(__file__).with_name(name).read_bytes() for name in ("parsing.py", "part_sets.py", "variables.py")]
    return kept(Interface, (block, text, code), lambda: parse(text, f"{file}.toml"))


def package_of(block: str) -> str:
    """The name of a block's package: `allocator.bounded` is that of `allocator_bounded`."""
    return SETS.get(block, (block,))[0].replace("_", ".")
