"""Real time as a scenario states it: how fast a run is, and what becomes of a late step."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, WithJsonSchema

from ..errors import as_written
from .source import Source
from .types import Model, Period

OFF = "off"
"""Instead of a factor: a run as fast as it goes, whatever the scenario says."""


def _factor(value: Any) -> float:
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not 0.0 < number < math.inf:
        found = f"{value:g}" if isinstance(value, float) else as_written(value)
        raise ValueError(f"expected a number above zero, found {found}")
    return number


class Realtime(Model):
    """A run paced by wall time: each base step ends when it is due on a monotonic clock."""

    factor: Annotated[
        float, BeforeValidator(_factor), WithJsonSchema({"type": "number", "exclusiveMinimum": 0, "default": 1.0})
    ] = 1.0
    """Simulated seconds in a second of wall time: 1 is real time, 2 twice as fast."""
    late: Literal["continue", "stop"] = "continue"
    """Whether the run goes on after a late step, or ends there with exit status 3."""
    tolerance: Period = 2e-3
    """A step is late that ends more than this after it is due, in wall time."""

    @property
    def text(self) -> str:
        """It in a line."""
        late = "ends the run" if self.late == "stop" else "is counted"
        return f"factor {self.factor:g}; a step that ends more than {self.tolerance:g} s late {late}"


def with_pace(source: Source, values: Mapping[str, Any], options: Mapping[str, str]) -> Source:
    """A copy in which these values of `realtime` take the place of the scenario's; `options` say where each stands.

    A factor of "off" takes `realtime` out.
    """
    if values.get("factor") == OFF:
        return source.with_entry(("realtime",), None)
    stated = source.data.get("realtime") if isinstance(source.data, dict) else None
    if not isinstance(source.data, dict) or not (stated is None or isinstance(stated, dict)):
        return source  # which is refused as it stands
    if stated is None:
        source = source.with_entry(("realtime",), {})
    for name, value in values.items():
        source = source.with_entry(("realtime", name), value, options[name])
    return source
