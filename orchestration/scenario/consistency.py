"""Consistency checks of a scenario: two expressions of its signals that should be equal at every instant."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from .references import Reference
from .types import Model, Quantity, Time


def _text(value: Any) -> Any:
    """A bare number as text."""
    return str(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else value


_Side = Annotated[str, Field(strict=True, min_length=1), BeforeValidator(_text, json_schema_input_type=float | str)]


class Consistency(Model):
    """Two expressions of signals that are equal, to a tolerance, wherever all blocks read every port as it is meant.

    `orchestrate polarity` evaluates them; a run does not.
    """

    left: _Side
    """An expression such as `rate(plant.h_w)`: signals, numbers, lists, `+ - * / @ **` and the functions of
    docs/use/polarity.md."""
    right: _Side
    """Another of the same shape and unit, or a number."""
    within: Quantity
    """How far each element may be apart: a number in SI units, or text with a unit."""
    share: float = Field(0.0, ge=0.0, le=1.0)
    """What is allowed beside `within`, as a share of the larger side's norm."""
    after: Time | None = None
    """Only samples from this time on."""
    before: Time | None = None
    """Only samples up to this time."""
    when: Reference | None = None
    """Only samples at which this boolean signal is true."""
