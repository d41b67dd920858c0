"""The timeline of a scenario: commands and set-points at given times, and the phases of the run."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, model_validator

from .references import Reference
from .types import Model, Time, Value

Phase = Annotated[str, Field(strict=True, pattern=r"^\w([\w .-]*[\w.-])?$")]
"""Name of a phase, "detumble": letters, digits, `_`, and behind the first also spaces, `.` and `-`."""


class TimelineEntry(Model):
    """Event at a time: values for inputs that are not connected, the beginning of a phase, or both."""

    at: Time
    """When; the blocks' next steps see it."""
    set: dict[Reference, Value] = {}
    """Values by input, `supervisor.command: 6`: an input that is not connected, or a tunable parameter. They hold
    until they are set again."""
    phase: Phase | None = None
    """A phase that begins, and lasts until the next one does."""

    @model_validator(mode="after")
    def _some(self) -> TimelineEntry:
        if not self.set and self.phase is None:
            raise ValueError("expected set, phase or both, found neither")
        if self.at < 0.0:
            raise ValueError(f"at: expected zero or more, found {self.at:g} s")
        return self


class Phases(Model):
    """Phases by the value of a signal: the mode of a block."""

    signal: Reference
    """One boolean, whole number or item of an enumeration, recorded or not."""
    names: dict[Phase, Annotated[Any, Field(json_schema_extra={"type": ["integer", "string", "boolean"]})]] = Field(
        min_length=1
    )
    """The signal's value in each phase, `nadir: 3`."""


def sentence(entry: TimelineEntry) -> str:
    """Returns what happens and when, in words."""
    parts = [f"{name} = {_shown(value)}" for name, value in entry.set.items()]
    if entry.phase is not None:
        parts.insert(0, f"phase '{entry.phase}'")
    return f"at {entry.at:.10g} s: {', '.join(parts)}"


def _shown(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_shown, value))}]"
    return str(value).lower() if isinstance(value, bool) else str(value)


def either(names: str | list[str]) -> str:
    """Names of phases in words."""
    return names if isinstance(names, str) else " or ".join(names)


def windows(timeline: list[TimelineEntry]) -> list[tuple[str, float, float | None]]:
    """Each phase of a timeline with its beginning and its end, s; None for one that lasts."""
    named = sorted(((e.at, e.phase) for e in timeline if e.phase is not None), key=lambda pair: pair[0])
    ends: list[float | None] = [at for at, _ in named[1:]]
    return [(name, at, end) for (at, name), end in zip(named, [*ends, None], strict=False)]
