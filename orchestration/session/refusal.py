"""A block that refuses its start values when it leaves initialization: wrong input, whose place can be named.

FMI has no call by which a block says which value it refuses; but it logs why, and what it logs names it.
"""

from __future__ import annotations

import re
from collections.abc import Container, Mapping

from ..errors import BlockError, Problem
from ..fmu.model import Model
from ..scenario.scenario import Scenario

_MARK = re.compile(r"\[(?:error|fatal|discard)\] (\S.*)")
"""A line of a message; those of a traceback that show code are indented."""


def refusal(scenario: Scenario, models: Mapping[str, Model], failure: BlockError) -> Problem | None:
    """Returns the error for a failure in initialization where the block's log names a start value; else None."""
    if failure.time is not None or failure.status is None:
        return None
    block = failure.block
    given = scenario.given(block)
    lines = [match[1] for line in failure.log if (match := _MARK.match(line))]
    for line in lines:
        if match := _named(line, given):
            key, said = given[match[1]], _reason(line, match)
            return scenario.error(key, said if key[0] == "blocks" else f"{block} refuses it: {said}")
    parameters = [variable.name for variable in models[block].of("parameter")]
    for line in lines:
        if (match := _named(line, parameters)) and _begins(line, match):
            return scenario.error(("blocks", block), line[match.start() :])
    return None


def _named(line: str, names: Container[str]) -> re.Match[str] | None:
    """The first of the names in the line."""
    words = re.finditer(r"(?<![\w.])([A-Za-z_]\w*)(?!\w)", line)
    return next((word for word in words if word[1] in names), None)


def _begins(line: str, match: re.Match[str]) -> bool:
    """Returns whether the sentence begins with the match; before it may stand calls and kinds of errors."""
    return re.fullmatch(r"(?:[\w ]+: )*", line[: match.start()]) is not None


def _reason(line: str, match: re.Match[str]) -> str:
    return line[match.start() :].removeprefix(f"{match[1]}: ") if _begins(line, match) else line
