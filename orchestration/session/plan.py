"""A scenario held against the models of its blocks: everything is checked before anything runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from ..errors import Problems
from ..expectations import checks, holds
from ..expectations.checks import Check
from ..expectations.holds import HoldCheck
from ..fmu.model import Model
from ..master.circuit import Circuit
from ..scenario.expectations import Expectation
from ..scenario.scenario import Scenario
from ..system import agreement, order, panels, periods, signals, starts, timeline, view, wiring
from ..system.clock import Clock, check_size, clock
from ..system.disturbances import acting
from ..system.faults import Faults, resolve
from ..system.order import Hook, Order
from ..system.phases import phases
from ..system.starts import Start
from ..system.wiring import Node, Wiring


@dataclass
class Plan:
    """A scenario that has been checked against its blocks and can run."""

    scenario: Scenario
    models: Mapping[str, Model]
    clock: Clock
    wiring: Wiring
    starts: dict[str, list[Start]]
    order: Order
    checks: list[Check]
    holds: list[HoldCheck]
    columns: list[Node]
    notes: list[str]
    """Warnings and remarks, for the user to see."""
    faults: Faults = field(default_factory=Faults)
    not_evaluated: list[tuple[Expectation, str]] = field(default_factory=list)
    """Expectations that a swap took out of the scenario, each with the reason."""

    @cached_property
    def circuit(self) -> Circuit:
        """Returns how the blocks are connected and stepped."""
        every = {name: entry.every for name, entry in self.scenario.blocks.items()}
        parallel = self.scenario.exchange == "parallel"
        return Circuit(self.wiring, self.order, self.clock, every, parallel, self.faults)


def plan(scenario: Scenario, models: Mapping[str, Model], feedthrough: Hook | None = None) -> Plan:
    """Checks a scenario against what its blocks offer.

    Raises InputError; the errors of several checks come together.
    """
    (times, remarks), values, (wired, sequence, faults), recorded, (checked, more), drawn, seen, held = _together(
        lambda: clock(scenario),
        lambda: starts.resolve(scenario, models),
        lambda: _wired(scenario, models, feedthrough),
        lambda: signals.recorded(scenario, models),
        lambda: checks.prepare(scenario, models),
        lambda: panels.check(scenario, models),
        lambda: view.check(scenario, models),
        lambda: holds.prepare(scenario, models),
    )
    needed = [node for look in (*checked, *held) for node in look.needed]
    needed += [phase.signal for phase in phases(scenario, models).values() if phase.signal is not None]
    columns = list(dict.fromkeys([*recorded, *needed, *drawn, *seen, *signals.flags(models)]))
    check_size(scenario, times, len(columns))
    notes = [
        *remarks,
        *agreement.notes(scenario, models, values),
        *periods.notes(scenario, models, values),
        *wired.warnings,
        *sequence.warnings,
        *more,
        *faults.notes,
    ]
    return Plan(scenario, models, times, wired, values, sequence, checked, held, columns, notes, faults)


def _wired(scenario: Scenario, models: Mapping[str, Model], feedthrough: Hook | None) -> tuple[Wiring, Order, Faults]:
    wired = wiring.connect(scenario, models)
    sequence, faults, (settings, remarks) = _together(
        lambda: order.sort(scenario, models, wired, feedthrough),
        lambda: resolve(scenario, models, wired),
        lambda: timeline.settings(scenario, models, wired),
    )
    faults.disturbances = acting(scenario, sequence.blocks, faults.disturbances, faults.notes)
    faults.settings += settings
    faults.notes += remarks
    return wired, sequence, faults


def _together(*checks: Callable[[], Any]) -> list[Any]:
    """Returns what the checks return. Raises InputError with the errors of all of them."""
    returned: list[Any] = []
    with Problems() as problems:
        for check in checks:
            with problems.gathered():
                returned.append(check())
    return returned
