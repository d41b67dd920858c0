"""What a reader may change in a scenario's live page: start values by sliders, and faults."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from .faults import Fault
from .types import Model, Quantity, UnitName


class Slider(Model):
    """A start value that a slider changes, from `least` to `most`."""

    start: Annotated[str, Field(strict=True, min_length=1)]
    """`plant.mass` or `plant.x[2]`, as `--set` has it; without a block a shared value."""
    least: Quantity
    """Its lower end, in the unit of the port or with one."""
    most: Quantity
    """Its upper end."""
    measure: Literal["element", "norm", "rotation"] = "element"
    """What is changed: one element; the Euclidean norm of a vector, which keeps its direction; or the angle of a
    rotation matrix about `axis`."""
    axis: Annotated[list[float], Field(min_length=3, max_length=3)] | None = None
    """The axis of a rotation, of any length."""
    unit: UnitName | None = None
    """Unit of the slider; default: the FMU's display unit."""
    label: str = ""
    """What stands at the slider; default: the value's name."""

    @model_validator(mode="after")
    def _turned(self) -> Slider:
        if (self.axis is None) == (self.measure == "rotation"):
            raise ValueError("'axis' says about what 'measure: rotation' turns; expected both or neither")
        if self.axis is not None and not any(self.axis):
            raise ValueError("axis: expected a vector that is not zero")
        return self


class LiveFault(Fault):
    """A fault that only the page injects, where its button is pressed."""

    name: str = Field(strict=True, min_length=1)
    """What stands on the button."""


class Live(Model):
    """The controls of the page that `orchestrate live` makes."""

    sliders: list[Slider] = []
    """Start values that may be changed."""
    faults: list[LiveFault] = []
    """Faults that may be injected, besides those of the scenario, which the page can leave out."""

    @model_validator(mode="after")
    def _apart(self) -> Live:
        names = [fault.name for fault in self.faults]
        if twice := [name for i, name in enumerate(names) if name in names[:i]]:
            raise ValueError(f"faults: two have the name {twice[0]!r}; expected a name of its own for each button")
        return self
