"""The figures that a scenario asks for."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from .references import Reference
from .types import Model, Quantity, Time


class Panel(Model):
    """One plot of a figure."""

    signals: list[Reference] = Field(min_length=1)
    """Signals of one unit, recorded or not; every element of a vector is a curve."""
    measure: Literal["element", "norm"] = "element"
    """Each element for itself, or the Euclidean norm of the vector."""
    unit: Annotated[str, Field(strict=True)] | None = None
    """Unit of the axis; default: the FMU's display unit."""
    label: str = ""
    """Text at the axis; default: the signal's name."""
    names: list[str] = []
    """Names of the curves in the legend; default: those of the signals."""
    lines: list[Quantity] = []
    """Values that are drawn across, such as limits."""
    lines_are: str = "limits"
    """What `lines` are, for the legend."""
    scale: Literal["linear", "log"] = "linear"
    """The scale of the axis; a logarithmic one leaves out what is not positive."""


class FigureEntry(Model):
    """A figure: panels side by side over time."""

    name: Annotated[str, Field(strict=True, pattern=r"^\w[\w.-]*$")]
    """Name of the file, without its ending."""
    title: str = ""
    panels: list[Panel] = Field(min_length=1)
    shade: Reference | None = None
    """A boolean signal; the times at which it is true are shaded."""
    mark: Reference | None = None
    """A scalar signal whose changes of sign are marked."""
    window: Annotated[list[Time], Field(min_length=2, max_length=2)] | None = None
    """From when to when; default: the whole run."""
