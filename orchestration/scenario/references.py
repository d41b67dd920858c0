"""Names in a scenario, parsed when it is read. Each is the text that the user wrote, and knows its parts."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Annotated, Any, Self

from pydantic import AfterValidator, Field, GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

from ..errors import InputError, Problem
from .text import parse

_KEPT_MAX = 1000
_NAME = re.compile(r"(\S+?)((?:\[\s*\d+\s*(?:,\s*\d+\s*)*\])*)")
_REFERENCE = re.compile(r"([A-Za-z_]\w*)\.(\S.*)", re.DOTALL)


class _Text(str):
    """Text that Pydantic checks by calling the class, which raises ValueError where the text is no such thing."""

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        # Names that do not change are made once for the same text: the next run reads the same.
        make = cls if cls is Assignment else lru_cache(_KEPT_MAX)(cls)
        return core_schema.no_info_after_validator_function(make, core_schema.str_schema(strict=True))


class Name(_Text):
    """A variable, or an element of it: `R_NB[2,3]`, also `R_NB[2][3]`, counted as the FMU counts. Any text is one."""

    variable: str
    indices: tuple[int, ...]

    def __new__(cls, text: str) -> Self:
        name = super().__new__(cls, text)
        match = _NAME.fullmatch(text.strip())
        name.variable = match[1] if match else text.strip()
        name.indices = tuple(map(int, re.findall(r"\d+", match[2]))) if match else ()
        return name


class Reference(_Text):
    """A variable of a block, or an element of it: `plant.R_NB[2,3]`."""

    block: str
    variable: str
    indices: tuple[int, ...]

    def __new__(cls, text: str, example: str = "block.variable") -> Self:
        match = _REFERENCE.fullmatch(text.strip())
        if match is None or not _NAME.fullmatch(match[2]):
            raise InputError(Problem(expected=example, found=repr(text.strip())))
        reference = super().__new__(cls, text.strip())
        name = Name(match[2])
        reference.block, reference.variable, reference.indices = match[1], name.variable, name.indices
        return reference

    @property
    def whole(self) -> str:
        """The variable without its index: `plant.R_NB`."""
        return f"{self.block}.{self.variable}"


class Connection(_Text):
    """An output and the input that it feeds: `plant.omega_B -> controller.omega_B`."""

    source: Reference
    target: Reference

    def __new__(cls, text: str) -> Self:
        ends = text.split("->")
        if len(ends) != 2:
            raise ValueError(f"{text.strip()}: expected 'block.output -> block.input'")
        connection = super().__new__(cls, text.strip())
        try:
            connection.source = Reference(ends[0], "block.output")
            connection.target = Reference(ends[1], "block.input")
        except ValueError as error:
            raise ValueError(f"{text.strip()}: {error}") from None
        return connection


class Assignment(_Text):
    """A value for a variable: `plant.friction = 0.1`. The value is YAML."""

    target: Reference
    value: Any

    def __new__(cls, text: str) -> Self:
        name, equals, value = text.partition("=")
        if not equals or not name.strip() or not value.strip():
            raise InputError(Problem(expected="block.parameter = value", found=repr(text)))
        assignment = super().__new__(cls, text)
        assignment.target, assignment.value = Reference(name), parse(value).data
        return assignment


Selection = Annotated[str, Field(strict=True), AfterValidator(lambda text: text if "*" in text else Reference(text))]
"""A reference, or a pattern such as `plant.*`."""
