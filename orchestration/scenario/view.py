"""What a scenario says of its three-dimensional view: which signals are the motion, and what is drawn on the body."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from .references import Reference
from .types import Model


def _direction(row: list[float]) -> list[float]:
    if not any(row):
        raise ValueError("expected a vector that is not zero")
    return row


Direction = Annotated[list[float], Field(min_length=3, max_length=3), AfterValidator(_direction)]
Extent = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
Axes = Reference | list[Direction]
"""Directions in body axes, one a row: numbers, or a parameter that holds them."""


GHOSTS = ("desired", "planned", "estimated")
"""The attitudes that are drawn as ghosts."""


class Arrow(Model):
    """A vector that can be shown and hidden."""

    name: str = Field(strict=True, min_length=1)
    signal: Reference
    """Three components, or one for each row of `along`."""
    frame: Literal["body", "inertial"] = "body"
    """The axes of its components."""
    along: Axes | None = None
    """The body direction of each element: the arrow is their sum."""
    shown: bool = False
    """Whether it is shown at first."""


class Prism(Model):
    """The body: a regular prism. Lengths are in the units of the port, or numbers of any one unit."""

    length: Reference | Extent = 1.0
    width: Reference | Extent = 1.0
    """Across its flats."""
    axis: Reference | Literal["x", "y", "z"] = "x"
    """The body axis along it."""
    sides: Annotated[int, Field(strict=True, ge=3, le=64)] = 4


class ViewEntry(Model):
    """A three-dimensional view of a body's motion, and of its orbit where there is a position."""

    attitude: Reference
    """A matrix that maps body components to inertial ones, or a unit quaternion that does, scalar first."""
    desired: Reference | Literal["lvlh"] | None = None
    """The desired attitude, drawn as a ghost: such a signal, or the axes of the local vertical and the orbit."""
    planned: Reference | None = None
    """An attitude that a controller plans, as a second ghost, hidden at first."""
    estimated: Reference | None = None
    """An estimate of the attitude, as a third ghost."""
    position: Reference | None = None
    """Inertial position, m: gives the orbit, the Earth and the LVLH axes."""
    epoch: Reference | None = None
    """A parameter with the UTC at t = 0: turns the Earth."""
    sun: Reference | None = None
    """Inertial direction of the Sun: gives day and night."""
    phase: Reference | None = None
    """An integer or enumeration whose values are marked on the time slider."""
    phases: list[str] = []
    """Names of the values of `phase` from 1 on; default: those of an enumeration, or the numbers."""
    body: Prism = Field(default_factory=Prism)
    axes: dict[Annotated[str, Field(min_length=1)], Axes] = {}
    """Axes drawn on the body by their names."""
    vectors: list[Arrow] = []
