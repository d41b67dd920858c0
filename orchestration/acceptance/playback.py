"""One block alone, its inputs played back from a record: what it gives where another block stood."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import BlockError
from ..fmu.model import TYPES, Element, Floats, Model
from ..runner.run import instantiate, locate, plan
from ..scenario.load import load
from ..scenario.source import Source
from ..swap import prepare as swap


@dataclass
class Played:
    """What a block gave at each instant at which it was stepped."""

    model: Model
    rows: Any
    """The rows of the record that these are."""
    outputs: dict[str, Floats]
    """(rows, elements) by the output's name."""
    notes: list[str]
    failure: BlockError | None = None


def play(name: str, entry: Mapping[str, Any], folder: str, time: Floats, inputs: Mapping[str, Floats]) -> Played:
    """Runs the block of a scenario's entry on recorded inputs, (instants, *shape) by name, in our units.

    The inputs of each instant are handed over before the step that ends there, those of the first in
    initialization, as in a run. Raises InputError where the block does not fit.
    """
    from ..fmu.archive import open_fmu

    step = float(f"{(time[-1] - time[0]) / (len(time) - 1):.12g}")
    start = {**entry.get("start", {}), **{key: values[0].tolist() for key, values in inputs.items()}}
    data = {
        "name": "playback",
        "step": step,
        "duration": step * (len(time) - 1),
        "blocks": {name: {**entry, "start": start}},
        "record": {"signals": []},
    }
    source = Source(data)
    source.folder = source.folder / folder
    scenario = load(source)
    one = scenario.blocks[name]
    fmu = open_fmu(locate(one.fmu, source.folder, one.flavour or scenario.flavour))
    prepared = swap.prepare(scenario, {name: fmu})
    # An input of ours that theirs does without is still an input; one that only theirs has has its start value.
    ready = plan(prepared.scenario, prepared.models, prepared.feedthrough)
    every = prepared.scenario.blocks[name].every
    model = ready.models[name]
    fed = [Element(v.name, p) for v in model.of("input") if v.name in inputs for p in range(v.size)]
    given = [Element(v.name, p) for v in model.of("output") if v.type in TYPES for p in range(v.size)]
    fed, given = (sorted(group, key=lambda e: TYPES.index(model.variables[e.variable].type)) for group in (fed, given))
    flat = {key: values.reshape(len(time), -1) for key, values in inputs.items()}
    table = np.column_stack([flat[e.variable][:, e.position] for e in fed]) if fed else np.zeros((len(time), 0))
    rows = np.arange(0, len(time), every)
    values = np.full((len(rows), len(given)), np.nan)
    into = np.zeros(len(given))
    failure = None
    with ExitStack() as stack:
        block = prepared.adapted(instantiate(ready, {name: fmu}, stack, False)[name])
        now: float | None = None
        try:
            block.set((start.element, start.value) for start in ready.starts[name])
            block.enter(float(time[-1]))
            live = [sum(model.variables[e.variable].type == kind for e in given) for kind in TYPES]
            buffer = block.wire(fed, given, live, into)
            block.leave()
            block.get_all()
            values[0] = into
            for n, row in enumerate(rows[1:], start=1):
                now = float(time[row - every])
                buffer[:] = table[row]
                block.set_inputs()
                block.do_step(now, every * step)
                block.get_all()
                values[n] = into
        except BlockError as error:
            error.time = error.time if error.time is not None else now
            failure = error
    outputs: dict[str, Floats] = {}
    for variable in model.of("output"):
        columns = [i for i, e in enumerate(given) if e.variable == variable.name]
        if columns:
            outputs[variable.name] = values[:, columns]
    return Played(model, rows, outputs, ready.notes, failure)


def _shaped(values: Floats) -> Any:
    return values.tolist()
