"""From a scenario to a result: opens the FMUs, checks everything, runs, and holds the run against the expectations."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import nullcontext
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..expectations.checks import Check
from ..expectations.flags import FlagObserver
from ..expectations.holds import HoldCheck, HoldObserver
from ..expectations.outcomes import ExpectationObserver, highlights, not_evaluated
from ..fmu.model import Floats, Model
from ..instances.block import Block
from ..interrupt import Stopped
from ..master.master import Master
from ..master.pacing import Pacer
from ..master.recording import Progress, Watch
from ..results.place import refuse_foreign, reserved
from ..results.result import Result, target
from ..scenario.realtime import with_pace
from ..scenario.scenario import Scenario
from ..system import signals
from ..system.wiring import Node
from .flight import Seer
from .manifest import manifest
from .open import open_scenario
from .plan import Plan
from .read import load
from .realtime import PYTHON_LOOP, pacer
from .refusal import refusal
from .standby import Standby, standby

Seers = tuple[Sequence[Node], Sequence[Seer]]


def run(
    scenario: str | Path | Mapping[str, Any] | Scenario,
    overrides: Mapping[str, Any] | None = None,
    *,
    duration: float | str | None = None,
    step: float | str | None = None,
    out: str | Path | None = None,
    progress: Progress | None = None,
    verbose: bool = False,
    compiled: bool = True,
    realtime: float | None = None,
) -> Result:
    """Runs a scenario: a file, the same as a dictionary, or what `load` returned.

    `overrides` are start values by name, `{"plant.x0": "98 deg"}`. `duration` and `step` (s, or text with a unit) take the
    place of the scenario's.
    `out` is a folder to write the results to; without it nothing is written. `compiled` False asks for the
    step loop in Python, which is otherwise used only where the one in C cannot be; both give the same bits.
    `realtime` paces the run by wall time: so many simulated seconds take a second; by default what the scenario says.
    Raises InputError where the scenario is wrong, and BlockError where a block fails; what was computed up
    to then is its `result`; ResultsError where the results cannot be written. Ctrl-C ends the run, and the result is marked as interrupted.
    """
    times = {key: value for key, value in (("duration", duration), ("step", step)) if value is not None}
    loaded = load(scenario.source if isinstance(scenario, Scenario) else scenario, {**(overrides or {}), **times})
    if realtime is not None:
        loaded = load(with_pace(loaded.source, {"factor": realtime}, {"factor": f"realtime={realtime!r}"}))
    if out is not None:
        refuse_foreign(target(out, loaded))
    with reserved(target(out, loaded)) if out is not None else nullcontext():
        result = execute(loaded, progress, verbose, compiled, pacer=pacer(loaded))
        if out is not None:
            result.save(out)
    if result.failure is not None:
        result.failure.result = result
        raise result.failure
    return result


def execute(
    scenario: Scenario,
    progress: Progress | None = None,
    verbose: bool = False,
    compiled: bool = True,
    check: Callable[[Iterable[Node], Mapping[str, Model]], None] | None = None,
    seers: Seers = ((), ()),
    pacer: Pacer | None = None,
) -> Result:
    """Runs a scenario on its FMUs. A failing FMU ends the run, and the result says so.

    `check` is shown what will be recorded before the run, and may refuse it by an InputError. `seers` are shown signals of the run: which, and who.
    Without a pacer the run is as fast as it goes, whatever the scenario says of real time.
    """
    opened = open_scenario(scenario)
    ready = opened.plan
    if check is not None:
        check(ready.columns, ready.models)
    with standby(opened, tuple(seers[0]), verbose) as made:
        result = run_blocks(ready, made.blocks, progress, compiled, seers, pacer, made)
        made.sound = result.failure is None and not result.interrupted
    for block in made.instances.values():
        result.failure = result.failure or getattr(block, "failure", None)  # what went wrong in closing it
    result.described = partial(manifest, opened.described, tuple(ready.notes), datetime.now(UTC))
    return result


def whole(scenario: Scenario, seers: Seers = ((), ())) -> Result:
    """Runs a scenario as `execute` does, for a caller to whom a part of a run is of no use: a signal that ends it raises Stopped.

    A failing FMU ends the run, and the result says so.
    """
    result = execute(scenario, seers=seers)
    if result.interrupted:
        raise Stopped(result.interrupted)
    return result


def run_blocks(
    ready: Plan,
    blocks: Mapping[str, Block],
    progress: Progress | None = None,
    compiled: bool = False,
    seers: Seers = ((), ()),
    pacer: Pacer | None = None,
    made: Standby | None = None,
) -> Result:
    """Runs a plan on any blocks, and holds what they give against its expectations. `made` keeps the bus from run to run."""
    scenario = ready.scenario
    every = {name: entry.every for name, entry in scenario.blocks.items()}
    parallel = scenario.exchange == "parallel"
    expected = [ExpectationObserver(check) for check in ready.checks]
    held = [HoldObserver(hold) for hold in ready.holds]
    looks: list[Check | HoldCheck] = [*ready.checks, *ready.holds]
    flagged = signals.flags(ready.models)
    raised = FlagObserver(flagged, ready.models)
    watched = list(dict.fromkeys([*(node for look in looks for node in look.needed), *flagged, *seers[0]]))

    seeing: list[Seer] = [*expected, raised, *seers[1], *held]

    def see(time: Floats, values: Floats) -> None:
        columns = {node: values[:, i] for i, node in enumerate(watched)}
        for seer in seeing:
            seer.see(time, columns)

    # Where every base step is recorded, all of it is there in the end, but for what only others are shown.
    between = bool(watched) and (ready.clock.interval > 1 or not set(watched) <= set(ready.columns))
    watch = Watch(watched, ready.clock, see) if between else None
    master = Master(
        blocks,
        ready.wiring,
        ready.order,
        ready.clock,
        ready.columns,
        every,
        parallel,
        compiled,
        ready.faults,
        watch,
        pacer,
        made.bus if made is not None else None,
    )
    recording = master.run(ready.starts, progress)
    if made is not None:
        made.bus = master.bus
    if recording.failure and (refused := refusal(scenario, ready.models, recording.failure)):
        raise InputError(refused)
    if watch is None:
        see(recording.time, recording.values[:, [recording.columns.index(node) for node in watched]])
    complete = recording.failure is None and not recording.interrupted
    return Result(
        scenario=scenario,
        models=ready.models,
        time=recording.time,
        samples=recording.values,
        columns=recording.columns,
        outcomes=[observer.outcome(not complete) for observer in expected],
        not_evaluated=[not_evaluated(*entry) for entry in ready.not_evaluated],
        holds=[observer.hold for observer in held if len(recording.time)],
        booleans=raised.flags,
        highlights=highlights(expected),
        warnings=[*ready.notes, *([PYTHON_LOOP] if pacer is not None and compiled else [])],
        steps=recording.steps,
        reached=ready.clock.time(recording.steps),
        wall=recording.wall,
        failure=recording.failure,
        interrupted=recording.interrupted,
        pace=pacer.pace if pacer is not None else None,
    )
