"""One block alone, its inputs played back from a record: what it gives where another block stood."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import BlockError
from ..fmu.model import TYPES, Element, Floats, Model
from ..master.circuit import Circuit
from ..scenario.load import load
from ..scenario.source import Source
from ..session.open import Opened, open_scenario
from ..session.session import Blocks, Session
from ..system.clock import Clock
from ..system.order import Order
from ..system.wiring import Link, Node, Wiring


@dataclass
class Played:
    """Outputs of a block at each instant at which it was stepped, up to a failure."""

    model: Model
    rows: NDArray[np.intp]
    """The rows of the record that these are."""
    outputs: dict[str, Floats]
    """(rows, elements) by the output's name."""
    notes: list[str]
    failure: BlockError | None = None


class Recorded:
    """A block without an FMU, whose outputs are the rows of a record, one a base step. See `instances.block.Block`."""

    log: Sequence[str] = ()

    def __init__(self, name: str, model: Model, rows: Mapping[Element, Floats]) -> None:
        self.name, self.model, self._rows, self._row = name, model, rows, 0

    def set(self, values: Iterable[tuple[Element, Any]]) -> None:
        """It has no inputs."""

    def get(self, elements: Sequence[Element]) -> list[float]:
        return [float(self._rows[element][self._row]) for element in elements]

    def enter(self, stop: float) -> None:
        """The first row holds from the start."""

    def leave(self) -> None:
        """Nothing changes."""

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        self._table = np.array([self._rows[element] for element in outputs]).reshape(len(outputs), -1).T
        self._into = into
        return np.zeros(0)

    def set_inputs(self) -> None:
        """It has none."""

    def do_step(self, time: float, step: float) -> None:
        self._row += 1

    def get_all(self) -> None:
        self._into[:] = self._table[self._row]

    get_live = get_all

    def close(self) -> None:
        """It holds nothing."""


def play(
    name: str,
    entry: Mapping[str, Any],
    folder: str,
    time: Floats,
    inputs: Mapping[str, Floats],
    shared: Mapping[str, Any] | None = None,
) -> Played:
    """Runs the block of a scenario's entry on recorded inputs, (instants, *shape) by name, in our units.

    The inputs of each instant are handed over before the step that ends there, those of the first in
    initialization, as in a run. `shared` are the values of the scenario that the block takes. Raises InputError where
    the block does not fit.
    """
    step = float(f"{(time[-1] - time[0]) / (len(time) - 1):.12g}")
    start = {**entry.get("start", {}), **{key: values[0].tolist() for key, values in inputs.items()}}
    data = {
        "name": "playback",
        "step": step,
        "duration": step * (len(time) - 1),
        "blocks": {name: {**entry, "start": start}},
        "shared": dict(shared or {}),
        "record": {"signals": []},
    }
    source = Source(data)
    source.folder = source.folder / folder
    opened = open_scenario(load(source))
    rows, played, failure = play_opened(opened, name, inputs, opened.plan.clock)
    return Played(opened.plan.models[name], rows, played, opened.plan.notes, failure)


def play_opened(
    opened: Opened, name: str, inputs: Mapping[str, Floats], clock: Clock
) -> tuple[NDArray[np.intp], dict[str, Floats], BlockError | None]:
    """Runs one block of an opened scenario on inputs, (instants, *shape) by name, an instant a step of the clock.

    Returns the rows at which it was stepped, its outputs (rows, elements) by name, and what ended it early.
    """
    plan = opened.plan
    model, every = plan.models[name], plan.scenario.blocks[name].every
    # An input of ours that theirs does without is still an input; one that only theirs has keeps its start value.
    fed = [v for v in model.of("input") if v.name in inputs]
    rows = {e: inputs[v.name].reshape(len(inputs[v.name]), -1)[:, e.position] for v in fed for e in v.elements}
    outputs = [v for v in model.of("output") if v.type in TYPES]
    record = Model("record", {v.name: replace(v, causality="output") for v in fed})
    recorded = Recorded(f"record of {name}", record, rows)
    sources, targets = (tuple(Node(block, element) for element in rows) for block in (recorded.name, name))
    wiring = Wiring([Link("playback", sources, targets)] if rows else [])
    order = Order([recorded.name, name], [list(sources)]) if rows else Order([name], [[]])
    columns = [Node(name, element) for variable in outputs for element in variable.elements]

    def fed_by_record(blocks: Blocks) -> Blocks:
        return {recorded.name: recorded, **blocks} if rows else blocks

    with Session(opened.only(name)) as session:
        circuit = Circuit(wiring, order, clock, {name: every})
        recording = session.fly(plan.starts, columns=columns, circuit=circuit, around=fed_by_record).whole()
    values = iter(np.split(recording.values[::every], np.cumsum([v.size for v in outputs]), axis=1))
    played = {variable.name: part for variable, part in zip(outputs, values, strict=False)}
    return np.arange(0, len(recording.time), every), played, recording.failure
