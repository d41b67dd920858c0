"""Takes a block's run apart and judges it by itself: a plant, a controller, an estimator; others are not judged so.

Tests: tests/orchestration/acceptance/test_itself.py.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fmus.field import EarthField

from ...fmu.model import Model
from ...results.data import RunData
from ...scenario.source import Source
from ..compare import Comparison
from ..polarity.fly import Loop
from ..robustness import Trial
from .balance import balance
from .estimate import estimate
from .field import field
from .motion import motion
from .response import READ, responses
from .signals import Signals, signals, told

_PLANT = {"dipole_cmd"}, {"R_NB", "omega_B", "r_N", "v_N", "b_B"}
_CONTROLLER = {"R_NB", "omega_B"}, {"tau_cmd_B"}
_ESTIMATOR = {"b_B_measured"}, {"R_NB", "omega_B"}
"""Inputs and outputs by which each is known."""
_FEWEST = 60


def judge(ours: Source, theirs: Source, comparison: Comparison) -> list[Trial]:
    """Returns what a block of a scenario keeps by itself; nothing of a block that is neither plant, controller nor
    estimator. Raises BlockError and InputError."""
    block = comparison.block
    loop = Loop(ours)
    model = loop.plan.models[block]
    if _is(model, *_PLANT):
        return list(plant(_played(loop, comparison)))
    if _is(model, *_ESTIMATOR):
        truth = _plant_of(loop)
        true = _thinned(loop, comparison.theirs, block, truth) if truth else Signals(comparison.theirs.time, {})
        return list(estimate(_thinned(loop, comparison.theirs, block), true))
    if _is(model, *_CONTROLLER):
        return list(_responses(loop, Loop(theirs), comparison))
    return []


def plant(of: Signals) -> Iterator[Trial]:
    """Yields what a plant keeps."""
    if len(of.time) < _FEWEST:
        return
    made = list(motion(of))
    yield from made
    turning = all(one.status != "failed" for one in made[:2])
    falling = all(one.status != "failed" for one in made[2:4])
    known = field(of, turning, falling)
    yield known
    model = None
    if known.status == "failed" and falling:
        model = _model(of)
    yield from balance(of, turning, falling, model)


def _model(of: Signals) -> np.ndarray | None:
    try:
        earth = EarthField(str(of.told.get("epoch", "")))
    except ValueError:
        return None
    rows = np.unique(np.linspace(0, len(of.time) - 1, max(24, int(of.time[-1] / 30))).astype(int))
    known = earth.at(of.time[rows], of.values["r_N"][rows])
    return np.stack([np.interp(of.time, of.time[rows], known[:, i]) for i in range(3)], axis=1)


def _played(loop: Loop, comparison: Comparison) -> Signals:
    """Returns what a block was given and gave on the inputs of ours: no other block fails by what it gives."""
    block, played = comparison.block, comparison.played
    known = _thinned(loop, comparison.ours, block)
    model = loop.plan.models[block]
    outputs = {n: v for n, v in played.outputs.items() if n in model.variables and len(v)}
    count = min((len(values) for values in outputs.values()), default=0)
    values = {v.name: known.values[v.name] for v in model.of("input") if v.name in known.values}
    values |= {n: v.astype(float).reshape(len(v), *model.variables[n].shape) for n, v in outputs.items()}
    return Signals(known.time[:count], {n: v[:count] for n, v in values.items()}, known.told)


def _thinned(loop: Loop, run: RunData, block: str, of: str | None = None) -> Signals:
    """Returns the signals of a block, or of another one, at the steps of the block."""
    whole = signals(run, of or block)
    every = loop.plan.scenario.blocks[block].every
    starts = {start.element: start.value for start in loop.plan.starts[of or block]}
    return Signals(
        whole.time[::every],
        {name: values[::every] for name, values in whole.values.items() if len(values) == len(whole.time)},
        told(loop.plan.models[of or block], starts),
    )


def _plant_of(loop: Loop) -> str | None:
    return next((name for name, model in loop.plan.models.items() if _is(model, *_PLANT)), None)


def _is(model: Model, inputs: set[str], outputs: set[str]) -> bool:
    return {v.name for v in model.of("input")} >= inputs and {v.name for v in model.of("output")} >= outputs


def _responses(ours: Loop, theirs: Loop, comparison: Comparison) -> Iterator[Trial]:
    block, run = comparison.block, comparison.ours
    given = _thinned(ours, run, block)
    true = _plant_of(ours)
    known = _thinned(ours, run, block, true) if true else given
    values = {name: known.values.get(name, given.values.get(name)) for name in READ}
    J = given.told.get("J_B", known.told.get("J_B"))
    of = Signals(
        given.time,
        {name: value for name, value in values.items() if value is not None},
        {} if J is None else {"J_B": J},
    )
    inputs = {
        name: given.values[name].reshape(len(given.time), -1)
        for name in _connected(ours, block)
        if name in given.values
    }
    yield from responses(ours, theirs, block, of, inputs)


def _connected(loop: Loop, block: str) -> list[str]:
    variables = loop.plan.models[block].variables
    fed: dict[str, int] = {}
    for link in loop.plan.wiring.links:
        for target in link.target:
            if target.block == block:
                fed[target.element.variable] = fed.get(target.element.variable, 0) + 1
    return [name for name, count in fed.items() if count == variables[name].size]
