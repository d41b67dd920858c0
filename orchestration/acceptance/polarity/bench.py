"""Gives one block alone chosen inputs step by step, again and again.

Tests: tests/orchestration/acceptance/test_polarity.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from time import monotonic, perf_counter, thread_time
from typing import Any

import numpy as np

from ...errors import BlockError
from ...fmu.model import TYPES, Element, Floats
from ...instances.block import Block
from ...instances.guest import TRACE
from ...instances.slave import Slave
from ...system.wiring import Node
from ...temporary import temporary
from .fly import Loop


def clock() -> float:
    """Returns the time by which a search ends, s: what this thread computes, and a tenth of what passes, so that a
    busy machine finds what an idle one does."""
    return 0.9 * thread_time() + 0.1 * monotonic()


def flown_inputs(loop: Loop, block: str, signals: Mapping[Node, Floats]) -> dict[str, Floats]:
    """Returns what flows in a run to each input that is connected as a whole, (samples, elements) by name."""
    variables = loop.plan.models[block].variables
    given: dict[str, dict[int, Floats]] = {}
    for link in loop.plan.wiring.links:
        for source, target in zip(link.source, link.target, strict=True):
            if target.block == block:
                columns = given.setdefault(target.element.variable, {})
                columns[target.element.position] = signals[source] * link.factor + link.offset
    whole = {name: columns for name, columns in given.items() if len(columns) == variables[name].size}
    return {name: np.stack([columns[i] for i in range(len(columns))], axis=1) for name, columns in whole.items()}


class Bench:
    """A block of an opened scenario, in this process. One instance serves for all plays, where a reset clears it."""

    def __init__(self, loop: Loop, block: str, stack: ExitStack) -> None:
        self.opened, self.block = loop.opened, block
        self.model = loop.plan.models[block]
        self.starts = [(start.element, start.value) for start in loop.plan.starts[block]]
        self.step = loop.plan.clock.step * loop.plan.scenario.blocks[block].every
        self._fmu = loop.opened.fmus[block]
        self._folder = stack.enter_context(temporary())
        self._fmu.extract(self._folder)
        self.keeps_instance = True
        reals = [v for v in self.model.of("output") if v.type == "real"]
        self._names, self._ends = [v.name for v in reals], np.cumsum([v.size for v in reals])[:-1]
        self._outputs = [e for v in reals for e in v.elements]
        self._into = np.zeros(len(self._outputs))
        sources = [node for link in loop.plan.wiring.links for node in link.source if node.block == block]
        self._handed_on = list(dict.fromkeys(node.element for node in sources))
        self._slave: Slave | None = None
        self.seconds: list[float] | None = None
        """Where the time of each step is left: Set, DoStep and Get."""
        stack.callback(self._close)

    def values(self) -> dict[Element, Any]:
        """Returns the start values that it has, of the FMU and of the scenario."""
        return {**self.model.starts, **dict(self.starts)}

    def play(
        self, inputs: Mapping[str, Floats], parameters: Mapping[Element, float] | None = None
    ) -> dict[str, Floats] | None:
        """Returns its real outputs (instants, elements) by name on inputs (instants, elements).

        `parameters` have other values for this play. Returns None where it refuses them, or gives what is not finite.
        """
        try:
            outputs = self.played(inputs, parameters)
        except BlockError:
            self._close()
            return None
        return outputs if all(np.isfinite(values).all() for values in outputs.values()) else None

    def played(
        self, inputs: Mapping[str, Floats], parameters: Mapping[Element, float] | None = None
    ) -> dict[str, Floats]:
        """Returns the same, finite or not. Raises BlockError where it refuses."""
        self._cleared(inputs)
        table = self._table(inputs)
        rows = self._begun(table, parameters) + self._stepped_on(table, 1)
        if not self.keeps_instance:
            self._close()
        return self._by_name(rows)

    def restored(self, inputs: Mapping[str, Floats]) -> tuple[dict[str, Floats], dict[str, Floats]]:
        """Returns the outputs of the second half of the inputs, before and after the state of the middle is restored.

        Raises BlockError.
        """
        slave = self._cleared(inputs)
        table, half = self._table(inputs), len(next(iter(inputs.values()))) // 2
        self._begun(table)
        self._stepped_on(table[:half], 1)
        with TRACE.during(self.block, f"{self.model.prefix}GetFMU{slave.version.state}"):
            state = slave.save()
        first = self._stepped_on(table, half)
        with TRACE.during(self.block, f"{self.model.prefix}SetFMU{slave.version.state}"):
            slave.restore(state)
        second = self._stepped_on(table, half)
        return self._by_name(first), self._by_name(second)

    def begun(self, inputs: Mapping[str, Floats], stop: float) -> dict[str, Floats]:
        """Starts a play of which each input (elements,) follows from the outputs before; returns the first outputs.

        Raises BlockError.
        """
        self._cleared(inputs)
        table = self._table({name: np.atleast_2d(values) for name, values in inputs.items()})
        self._count = 0
        return self._row(self._begun(table, stop=stop)[0])

    def advanced(self, inputs: Mapping[str, Floats]) -> dict[str, Floats]:
        """Makes one step with these inputs, and returns the outputs at its end. Raises BlockError."""
        table = self._table({name: np.atleast_2d(values) for name, values in inputs.items()})
        self._count += 1
        return self._row(self._stepped_on(np.concatenate((table, table)), 1, self._count - 1)[0])

    def _row(self, values: Floats) -> dict[str, Floats]:
        return dict(zip(self._names, np.split(values, self._ends), strict=True))

    def _by_name(self, rows: list[Floats]) -> dict[str, Floats]:
        return dict(zip(self._names, np.split(np.array(rows), self._ends, axis=1), strict=True))

    def _table(self, inputs: Mapping[str, Floats]) -> Floats:
        return np.concatenate([inputs[n] for n in self._fed], axis=1)[:, self._order]

    def _cleared(self, inputs: Mapping[str, Floats]) -> Slave:
        """Returns the instance, set back to its start; a new one where there is none, or where it cannot be reset."""
        try:
            if self._slave is not None:
                with TRACE.during(self.block, f"{self.model.prefix}Reset"):
                    self._slave.reset()
        except BlockError:
            self.keeps_instance = False
            self._close()
        return self._slave or self._open(inputs)

    def _open(self, inputs: Mapping[str, Floats]) -> Slave:
        variables = self.model.variables
        self._fed = list(inputs)
        elements = [Element(name, i) for name in self._fed for i in range(variables[name].size)]
        kinds = [TYPES.index(variables[e.variable].type) for e in elements]
        self._order = np.argsort(kinds, kind="stable")
        self._elements = [elements[i] for i in self._order]
        with TRACE.during(self.block, "loading and instantiating it"):
            self._slave = Slave(self.block, self._fmu, self._folder)
        self._stepped: Block = self.opened.adapted(self._slave)
        self._given: Floats | None = None
        self._place = TRACE.place(self.block, self.model.prefix, self.step)
        return self._slave

    def _begun(
        self, table: Floats, parameters: Mapping[Element, float] | None = None, stop: float | None = None
    ) -> list[Floats]:
        """Initializes it, and returns its outputs at the start."""
        with TRACE.during(self.block, "its initialization"):
            return self._initialized(table, parameters, stop)

    def _initialized(
        self, table: Floats, parameters: Mapping[Element, float] | None, stop: float | None
    ) -> list[Floats]:
        block = self._stepped
        block.set([*self.starts, *(parameters or {}).items()])
        block.enter(self.step * len(table) if stop is None else stop)
        block.set(zip(self._elements, table[0].tolist(), strict=True))
        block.get(self._handed_on)  # as a master does; others need not exist yet
        if self._given is None:
            self._given = block.wire(self._elements, self._outputs, [len(self._outputs), 0, 0, 0], self._into)
        block.leave()
        block.get_all()
        return [self._into.copy()]

    def _stepped_on(self, table: Floats, first: int, count: int | None = None) -> list[Floats]:
        """Makes the steps to the rows from this one on, and returns the outputs at each; `count` were made before."""
        block, into, given, rows = self._stepped, self._into, self._given, []
        assert given is not None
        try:
            for done, values in enumerate(table[first:], first - 1 if count is None else count):
                given[:] = values
                begun = perf_counter()
                TRACE.step(self._place, done, "Set")
                block.set_inputs()
                TRACE.step(self._place, done, "DoStep")
                block.do_step(done * self.step, self.step)
                TRACE.step(self._place, done, "Get")
                block.get_all()
                if self.seconds is not None:
                    self.seconds.append(perf_counter() - begun)
                rows.append(into.copy())
        finally:
            TRACE.step(self._place, 0, None)
        return rows

    def _close(self) -> None:
        if self._slave is not None:
            prefix = self.model.prefix
            with TRACE.during(self.block, f"{prefix}Terminate or {prefix}FreeInstance"):
                self._slave.close()
        self._slave = None
