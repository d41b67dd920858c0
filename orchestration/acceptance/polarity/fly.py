"""A loop flown with one port wired wrongly, until an expectation or a consistency check shows it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from ...errors import BlockError, InputError
from ...expectations.checks import Check
from ...expectations.consistency import ConsistencyObserver, Relation, prepare, reads
from ...expectations.outcomes import ExpectationObserver
from ...fmu.model import Floats
from ...master.circuit import Circuit
from ...master.master import Options
from ...master.recording import Recording
from ...scenario.load import load
from ...scenario.source import Source
from ...session.open import open_scenario
from ...session.plan import Plan
from ...session.session import Blocks, Session
from ...system import order
from ...system.observer import Observer
from ...system.wiring import Node, Wiring
from .misread import Misread
from .ports import Port, miswired
from .wrongs import Wrong

Columns = Mapping[Node, Floats]
_SOON = 16
"""Base steps until the checks are looked at for the first time; then after twice as many each time."""


@dataclass(frozen=True)
class Found:
    """Sign of a wrong wiring: an expectation, a consistency check, or a block that refuses it."""

    how: str
    """expectation, consistency or refused."""
    by: str
    time: float
    """Of the first sample that shows it, s."""


class _Enough(Exception):
    """The wrong wiring is shown, so the rest of the run can tell nothing more."""


class _Detector:
    """An observer that ends the run by `_Enough` at the first samples by which an expectation or a check fails."""

    def __init__(
        self,
        expected: Sequence[ExpectationObserver],
        consistent: Sequence[ConsistencyObserver],
        given: Callable[[Columns], Columns],
    ) -> None:
        """`given` returns the signals as others see them."""
        self._expected, self._consistent, self._given = expected, consistent, given
        self.count = 0
        self.found: list[Found] = []

    def see(self, time: Floats, columns: Columns) -> None:
        columns = self._given(columns)
        for observer in self._consistent:
            observer.see(time, columns)
            if observer.broken is not None:
                self.found.append(Found("consistency", observer.broken.name, observer.broken.time))
        for one in self._expected:
            one.see(time, columns)
            outcome = one.outcome(early=True)
            if not outcome.passed and not outcome.open:
                first = _first(one.check, time, columns)
                at = first if first is not None else outcome.time or float(time[-1])
                self.found.append(Found("expectation", outcome.name, at))
        self.count += len(time)
        if self.found:
            raise _Enough


class Loop:
    """A scenario opened once and flown again and again. Raises InputError where the scenario is wrong."""

    def __init__(self, source: Source) -> None:
        self.opened = open_scenario(load(source))
        self.session = Session(self.opened)
        self.plan: Plan = self.opened.plan
        self.notes = list(self.plan.notes)
        self.relations = self._relations()
        looks: list[Check | Relation] = [*self.plan.checks, *self.relations]
        self.watched = list(dict.fromkeys(node for look in looks for node in look.needed))
        self.failure: BlockError | None = None
        """What ended the run as wired, once it is flown."""
        self.margins: dict[str, float] = {}
        """How often larger the difference of each consistency check could be in the run as wired, once it is flown."""

    def _relations(self) -> list[Relation]:
        """Returns the consistency checks; those that read what a swapped block lacks are left out with a note."""
        scenario, models = self.plan.scenario, self.plan.models
        lacking: dict[str, str] = {}
        for check, entry in scenario.consistency.items():
            for name, fit in self.opened.prepared.fits.items():
                gone = {v for v in (*fit.ignored, *fit.missing, *fit.without) if v not in models[name].variables}
                if any(r.block == name and r.variable in gone for r in reads(entry)):
                    lacking[check] = f"the consistency check '{check}' is left out: {name} lacks what it reads"
        self.notes += lacking.values()
        if lacking:
            source = scenario.source.without([("consistency", check) for check in lacking])
            scenario = load(source)
        return prepare(scenario, models)

    def fly(self, port: Port | None = None, wrong: Wrong | None = None) -> tuple[Found | None, float]:
        """Returns what shows the wrong wiring first, and how long the loop flew, s; None where nothing does.

        Without a port the loop flies as it is wired.
        """
        expected = [ExpectationObserver(check) for check in self.plan.checks]
        consistent = [ConsistencyObserver(relation) for relation in self.relations]
        detector = _Detector(expected, consistent, lambda columns: self._as_given(port, wrong, columns))
        found = detector.found
        failure: BlockError | None = None
        with suppress(_Enough):
            failure = self._run(port, wrong, observers=[detector]).failure
        if failure is not None:
            found.append(Found("refused", f"{failure.block}: {failure.problem}", failure.time or 0.0))
        if port is None:
            self.failure = failure
            self.margins = {observer.relation.name: observer.closest for observer in consistent}
        flown = self.plan.clock.time(max(detector.count - 1, 0))
        if not found:
            ended = [observer.outcome() for observer in expected]
            found += [Found("expectation", o.name, flown) for o in ended if not o.passed]
        return min(found, key=lambda f: f.time, default=None), flown

    def record(self, nodes: list[Node], port: Port | None = None, wrong: Wrong | None = None) -> tuple[Floats, Columns]:
        """Times (n,) and values (n,) of these elements, over the whole run or up to a failure."""
        flown = self._run(port, wrong, nodes)
        return flown.time, self._as_given(port, wrong, dict(zip(nodes, flown.values.T, strict=True)))

    def _run(
        self, port: Port | None, wrong: Wrong | None, columns: Sequence[Node] = (), observers: Sequence[Observer] = ()
    ) -> Recording:
        def misread(blocks: Blocks) -> Blocks:
            if port is None or wrong is None or wrong.turn is None:
                return blocks
            fed = readers(port, self.plan.wiring)
            return blocks | {name: Misread(blocks[name], variable, wrong.turn) for name, variable in fed}

        return self.session.fly(
            self.plan.starts,
            observers,
            self.watched if observers else (),
            columns=columns,
            circuit=self._circuit(port, wrong),
            around=misread,
            options=Options(soon=_SOON),
        ).whole()

    def _circuit(self, port: Port | None, wrong: Wrong | None) -> Circuit:
        plan = self.plan
        if port is None or wrong is None or wrong.matrix is None:
            return plan.circuit
        wiring = miswired(plan.wiring, port, wrong.matrix, wrong.offset)
        try:
            levels = order.sort(plan.scenario, plan.models, wiring, self.opened.prepared.feedthrough).levels
        except InputError:  # other elements close a loop in initialization; twice the usual order hands all on
            levels = plan.order.levels * 2
        return replace(plan.circuit, wiring=wiring, order=replace(plan.order, levels=levels))

    def _as_given(self, port: Port | None, wrong: Wrong | None, columns: Columns) -> Columns:
        """Returns what others see of an output that is given wrongly.

        An input that is read wrongly is right on the wire.
        """
        if port is None or wrong is None or port.causality != "output" or not all(n in columns for n in port.nodes):
            return columns
        values = wrong.apply(np.stack([columns[node] for node in port.nodes], axis=1))
        return {**columns, **{node: values[:, i] for i, node in enumerate(port.nodes)}}


def readers(port: Port, wiring: Wiring) -> list[tuple[str, str]]:
    """Returns the inputs that a port is, or feeds, by block and variable."""
    if port.causality == "input":
        return [(port.block, port.variable)]
    fed = {
        (target.block, target.element.variable): None
        for link in wiring.links
        for source, target in zip(link.source, link.target, strict=True)
        if source in port.nodes
    }
    return list(fed)


def _first(check: Check, time: Floats, columns: Mapping[Node, Floats]) -> float | None:
    """Returns the time of the first of these samples by which an expectation fails; None where that is not decided by
    one.
    """
    if check.expectation.always is None:
        return None
    low, high = 0, len(time)
    while high - low > 1:  # the first half that holds a failing sample, again and again
        middle = (low + high) // 2
        observer = ExpectationObserver(check)
        observer.see(time[low:middle], {node: columns[node][low:middle] for node in check.needed})
        outcome = observer.outcome(early=True)
        low, high = (low, middle) if not outcome.passed and not outcome.open else (middle, high)
    return float(time[low])
