"""A scenario flown again and again with other start values: opened once, its FMUs loaded once and reset from run to run.

What a run gives depends on its start values alone. An FMU that cannot reset itself, or that has failed, is instantiated anew.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Any, Protocol

from ..errors import BlockError, InputError, hint
from ..expectations.outcomes import ExpectationObserver, Outcome
from ..fmu.model import Floats
from ..instances.block import Instance
from ..interrupt import Stopped
from ..master.master import Master
from ..master.recording import Watch
from ..scenario.references import Name
from ..scenario.scenario import Scenario
from ..scenario.source import StartName
from ..system.starts import Start, resolve
from ..system.wiring import Node
from .open import Opened
from .refusal import refusal

_loading = threading.Lock()
"""Held while FMUs are loaded, since that changes the folder in which this process stands."""


class Seer(Protocol):
    """What is shown some signals of a run after every base step."""

    def see(self, time: Floats, columns: Mapping[Node, Floats]) -> None:
        """Takes in the samples that follow those before: times (n,) s, and values (n,) by node."""


@dataclass(frozen=True)
class Flown:
    """What came of a run."""

    reason: str | None
    """Why it failed; None where it came to its end."""
    outcomes: list[Outcome]
    wall: float
    """Seconds that the step loop took."""


class Flight:
    """The opened scenario with its instances."""

    def __init__(self, opened: Opened, nodes: Sequence[Node] = (), anew: bool = False) -> None:
        """`nodes` are shown to the seers besides what the expectations need. `anew`: FMUs are instantiated for each run."""
        self._opened, self._anew = opened, anew
        plan = opened.plan
        self._nodes = list(dict.fromkeys([*(n for check in plan.checks for n in check.needed), *nodes]))
        self._clock = replace(plan.clock, interval=plan.clock.steps)  # only the ends are recorded
        self._stack = ExitStack()
        self._instances: dict[str, Instance] = {}
        self._master: Master | None = None

    def fly(self, values: Mapping[str, Any], seers: Sequence[Seer] = ()) -> Flown:
        """Runs with these start values, by name as `--set` takes them. A value that is refused makes the run a failed one."""
        plan = self._opened.plan
        observers = [ExpectationObserver(check) for check in plan.checks]

        def see(time: Floats, rows: Floats) -> None:
            columns = {node: rows[:, i] for i, node in enumerate(self._nodes)}
            for one in (*observers, *seers):
                one.see(time, columns)

        try:
            scenario = with_values(plan.scenario, values)
            starts = resolve(scenario, plan.models, self._unchanged(values))
            master = self._ready(Watch(self._nodes, self._clock, see))
        except InputError as error:
            return Flown("\n".join(error.messages), [], 0.0)
        recording = master.run(starts)
        if recording.interrupted:
            self.close()
            raise Stopped(recording.interrupted)
        if recording.failure is not None:
            reason = str(refusal(scenario, plan.models, recording.failure) or recording.failure)
            self.close()  # FMI allows little after a failure
            return Flown(reason, [one.outcome(True) for one in observers], recording.wall)
        return Flown(None, [one.outcome() for one in observers], recording.wall)

    def _unchanged(self, values: Mapping[str, Any]) -> dict[str, list[Start]] | None:
        """The start values of the blocks that none of these values reaches; None where a shared value is among them, which may reach all."""
        starts = [StartName.of(text) for text in values]
        if any(start.shared for start in starts):
            return None
        holders = {start.block for start in starts}
        return {block: starts for block, starts in self._opened.plan.starts.items() if block not in holders}

    def _ready(self, watch: Watch) -> Master:
        """The master of instances in their first state. Raises InputError."""
        if self._instances and not self._reset():
            self.close()
        opened, plan = self._opened, self._opened.plan
        if not self._instances:
            with _loading:
                self._instances = opened.instantiate(self._stack)
        if self._master is None:
            blocks = {name: opened.adapted(block) for name, block in self._instances.items()}
            every = {name: entry.every for name, entry in plan.scenario.blocks.items()}
            parallel = plan.scenario.exchange == "parallel"
            columns = self._nodes[:1]
            master = Master(blocks, plan.wiring, plan.order, self._clock, columns, every, parallel, True, plan.faults)
            # What stands before an instance, and a fault in its exchange, has a state of its own.
            if not plan.faults.disturbances and all(blocks[name] is block for name, block in self._instances.items()):
                self._master = master
        else:
            master = self._master
        master.watch = watch
        return master

    def _reset(self) -> bool:
        """Whether all instances stand where they stood at first."""
        if self._anew:
            return False
        try:
            for block in self._instances.values():
                block.reset()
        except BlockError:
            self._anew = True
            return False
        return True

    def close(self) -> None:
        """Ends the instances; the next run makes others."""
        self._instances, self._master = {}, None
        self._stack.close()
        self._stack = ExitStack()


def with_values(scenario: Scenario, values: Mapping[str, Any], places: Mapping[str, str] | None = None) -> Scenario:
    """The scenario with other start values, by name as `--set` takes them. Raises InputError.

    As `load` with overrides, but the rest of it, which is known to be sound, is not looked at again. `places` say where each stands,
    for messages.
    """
    shared, blocks, options = dict(scenario.shared), dict(scenario.blocks), dict(scenario.source.options)
    for text, value in values.items():
        start = StartName.of(text)
        name, block = Name(start.variable), start.block
        options[start.key] = place = (places or {}).get(text) or f"{text}={value}"
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
