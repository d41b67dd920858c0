"""A scenario from its source: data with their lines, checked against the models."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..errors import InputError
from . import complaints
from .extends import extended
from .orbit import resolved
from .scenario import Scenario
from .source import Source


def load(scenario: Mapping[str, Any] | Source, overrides: Mapping[str, Any] | None = None) -> Scenario:
    """A scenario from its source, or from the same data as a dictionary. Raises InputError with all that is wrong.

    `overrides` are start values by `block.parameter`, or shared ones by `parameter`, and `step`, `duration` and
    `flavour`.
    """
    source = scenario if isinstance(scenario, Source) else extended(Source(dict(scenario)))
    for name, value in (overrides or {}).items():
        if name in ("step", "duration", "flavour"):
            source = source.with_value(name, value, name)
        else:
            source = source.with_start(name, value)
    if isinstance(source.data, dict) and "scenario" in source.data and "blocks" not in source.data:
        message = (
            "is a campaign, which varies the scenario under 'scenario'; remedy: orchestrate campaign, or that scenario"
        )
        raise InputError(source.error((), message))
    loaded = complaints.checked(Scenario, source)
    by_orbit = {name: entry for name, entry in loaded.blocks.items() if entry.orbit is not None}
    if by_orbit:
        for name, entry in by_orbit.items():
            source = resolved(source, name, entry, loaded.duration)
        loaded = complaints.checked(Scenario, source)
    loaded._source = source
    return loaded
