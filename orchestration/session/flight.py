"""A flight with other start values, as a campaign makes them: its outcomes, or why it failed.

Tests: tests/orchestration/session/test_flight.py, tests/orchestration/campaign.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ..errors import BlockError, InputError, hint
from ..expectations.outcomes import ExpectationObserver, Outcome
from ..scenario.references import Name
from ..scenario.scenario import Scenario
from ..scenario.source import StartName
from ..system.observer import Observer
from ..system.starts import Start, resolve
from ..system.wiring import Node
from .plan import Plan
from .refusal import refusal
from .session import Session


@dataclass(frozen=True)
class Flown:
    """Outcome of a run."""

    reason: str | None
    """Why it failed; None where it came to its end."""
    outcomes: list[Outcome]
    wall: float
    """Seconds that the step loop took."""


def fly(
    session: Session, values: Mapping[StartName, Any], observers: Sequence[Observer] = (), nodes: Sequence[Node] = ()
) -> Flown:
    """Flies with these start values; a value that is refused makes the run a failed one.

    The observers are shown `nodes`, and what the expectations need. A signal that ends it raises Stopped.
    """
    plan = session.opened.plan
    expected = [ExpectationObserver(check) for check in plan.checks]
    shown = list(dict.fromkeys([*(node for check in plan.checks for node in check.needed), *nodes]))
    try:
        scenario = with_values(plan.scenario, values)
        starts = resolve(scenario, plan.models, _unchanged(plan, values))
        recording = session.fly(starts, [*expected, *observers], shown).whole()
    except InputError as error:
        return Flown("\n".join(error.messages), [], 0.0)
    except BlockError as error:  # of a process that was ended while it started
        return Flown(str(error), [], 0.0)
    reason, failed = None, recording.failure is not None
    if recording.failure is not None:
        reason = str(refusal(scenario, plan.models, recording.failure) or recording.failure)
    return Flown(reason, [observer.outcome(failed) for observer in expected], recording.wall)


def _unchanged(plan: Plan, values: Iterable[StartName]) -> dict[str, list[Start]] | None:
    """Returns the start values of the blocks that none of these values reaches.

    None where a shared value is among them, which may reach all.
    """
    reached = {start.block for start in values}
    if any(start.shared for start in values):
        return None
    return {block: given for block, given in plan.starts.items() if block not in reached}


def with_values(
    scenario: Scenario, values: Mapping[StartName, Any], places: Mapping[StartName, str] | None = None
) -> Scenario:
    """Returns the scenario with other start values: numbers, quantities, or what a scenario may hold.

    As `load` with overrides, but the rest of it, which is known to be sound, is not looked at again. `places` say where
    each stands, for messages. Raises InputError.
    """
    shared, blocks, options = dict(scenario.shared), dict(scenario.blocks), dict(scenario.source.options)
    for start, value in values.items():
        name, block = Name(start.variable), start.block
        options[start.key] = place = (places or {}).get(start) or f"{start}={value}"
        if start.shared:
            starts = shared
        else:
            if block not in blocks:
                raise InputError(f"{place}: there is no block {block!r}{hint(block, blocks)}")
            starts = dict(blocks[block].start)
            blocks[block] = blocks[block].model_copy(update={"start": starts})
        starts.pop(name, None)  # the last one counts, also over elements
        starts[name] = value
    copy = scenario.model_copy(update={"shared": shared, "blocks": blocks})
    copy._source = replace(scenario.source, options=options)
    return copy
