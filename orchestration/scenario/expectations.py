"""What a run is expected to show, and the holds that its summary tells of."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, WithJsonSchema, model_validator

from .references import Reference
from .timeline import Phase
from .types import NUMBER_OR_TEXT, Model, Quantity, Time, quantity


class Bound(Model):
    """Bound against which a signal is held; exactly one of these."""

    below: Quantity | None = None
    """x < bound"""
    above: Quantity | None = None
    """x > bound"""
    within: Annotated[
        Any, WithJsonSchema({"anyOf": [*NUMBER_OR_TEXT, {"type": "array", "minItems": 2, "maxItems": 2}]})
    ] = None
    """|x| <= bound, or low <= x <= high for `[low, high]`"""
    equals: Annotated[Any, WithJsonSchema({"anyOf": [*NUMBER_OR_TEXT, {"type": "boolean"}]})] = None
    """x = bound: a boolean, a whole number or an item of an enumeration"""

    @model_validator(mode="after")
    def _one(self) -> Bound:
        self._only(*type(self).model_fields)
        if isinstance(self.within, list):
            if len(self.within) != 2:
                raise ValueError(f"within: expected one number or [low, high], found {self.within!r}")
            for end in self.within:
                quantity(end)
        elif self.within is not None:
            quantity(self.within)
        return self

    @property
    def kind(self) -> str:
        """The one that is given."""
        return self._only(*type(self).model_fields)


class _Signal(Model):
    name: str = Field(strict=True, min_length=1)
    """A sentence that reads well in the table at the end."""
    signal: Reference
    """The signal that is looked at, recorded or not: `plant.omega_B` or one element, `plant.omega_B[2]`."""


class Span(Model):
    """Samples of a signal that are looked at, and of a vector what."""

    measure: Literal["element", "norm"] = "element"
    """Each element for itself, or the Euclidean norm of the vector."""
    after: Time | None = None
    """Only samples from this time on."""
    before: Time | None = None
    """Only samples up to this time."""
    when: Reference | None = None
    """Only samples at which this boolean signal is true; there must be one."""
    during: Phase | Annotated[list[Phase], Field(min_length=1)] | None = None
    """Only samples in this phase, or in one of these: a phase of the timeline, or of `phases`; there must be one."""


class Expectation(Span, _Signal):
    """Expectation of a run. Exactly one of `always`, `ever` and `zeros`."""

    always: Bound | None = None
    """Every sample meets the bound."""
    ever: Bound | None = None
    """At least one sample meets the bound, in every element."""
    zeros: Annotated[int, Field(strict=True, ge=0)] | None = None
    """How often the signal changes its sign."""

    @model_validator(mode="after")
    def _one(self) -> Expectation:
        self._only("always", "ever", "zeros")
        return self


class HoldEntry(Model):
    """A hold: while a boolean signal is true, other signals keep their values. The summary tells what became of it."""

    name: str = Field(strict=True, min_length=1)
    """What is held: "commands"."""
    signal: Reference
    """The boolean signal that is true while they are held."""
    keeps: list[Reference] = Field(min_length=1)
    """The signals that keep their values."""
    limits: dict[str, Reference] = {}
    """Boolean signals of limits, by a name for each; the summary lists them where the hold does not end."""
