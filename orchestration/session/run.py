"""From a scenario to a result: opens the FMUs, checks everything, runs, and holds the run against the expectations."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import nullcontext
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ..errors import InputError
from ..expectations.checks import Check
from ..expectations.flags import FlagObserver
from ..expectations.holds import HoldCheck, HoldObserver
from ..expectations.outcomes import ExpectationObserver, highlights, not_evaluated, settlings
from ..fmu.model import Model
from ..interrupt import Stopped
from ..master.master import Options, Progress
from ..master.pacing import Pacer
from ..results.place import refuse_foreign, reserved
from ..results.result import Result, target
from ..scenario.realtime import with_pace
from ..scenario.scenario import Scenario
from ..system import signals
from ..system.observer import Observer
from ..system.wiring import Node
from .manifest import manifest
from .read import load
from .realtime import PYTHON_LOOP, pacer
from .refusal import refusal
from .session import Blocks, Session
from .warm import WARM

Observers = tuple[Sequence[Node], Sequence[Observer]]


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

    `overrides` are start values by name, `{"plant.x0": "98 deg"}`. `duration` and `step` (s, or text with a unit) take
    the place of the scenario's. `out` is a folder to write the results to; without it nothing is written. `compiled`
    False asks for the step loop in Python, which is otherwise used only where the one in C cannot be; both give the
    same bits. `realtime` paces the run by wall time: so many simulated seconds take a second; by default what the
    scenario says. Raises InputError where the scenario is wrong, and BlockError where a block fails; what was computed
    up to then is its `result`; ResultsError where the results cannot be written. Ctrl-C ends the run, and the result
    is marked as interrupted.
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
    observers: Observers = ((), ()),
    pacer: Pacer | None = None,
    records: Mapping[str, Path] = MappingProxyType({}),
) -> Result:
    """Runs a scenario on its FMUs. A failing FMU ends the run, and the result says so.

    `check` is shown what will be recorded before the run, and may refuse it by an InputError. `observers` are those
    who are shown signals of the run, behind the nodes that they need. Without a pacer the run is as fast as it goes,
    whatever the scenario says of real time. `records` are folders for the FMI calls of blocks, with what plays them.
    """
    with WARM.session(scenario, verbose, records) as session:
        opened = session.opened
        if check is not None:
            check(opened.plan.columns, opened.plan.models)
        result = evaluated(session, Options(compiled, progress, pacer), observers)
    result.described = partial(manifest, opened.described, tuple(opened.plan.notes), datetime.now(UTC))
    return result


def whole(scenario: Scenario, observers: Observers = ((), ())) -> Result:
    """Runs a scenario as `execute` does, for a caller to whom a part of a run is of no use.

    A failing FMU ends the run, and the result says so; a signal that ends it raises Stopped.
    """
    result = execute(scenario, observers=observers)
    if result.interrupted:
        raise Stopped(result.interrupted)
    return result


def evaluated(
    session: Session,
    options: Options = Options(),  # noqa: B008  (it is frozen)
    observers: Observers = ((), ()),
    around: Callable[[Blocks], Blocks] | None = None,
) -> Result:
    """Flies a session as its scenario says, and evaluates the expectations. `around` is that of `Session.fly`."""
    ready = session.opened.plan
    expected = [ExpectationObserver(check) for check in ready.checks]
    held = [HoldObserver(hold) for hold in ready.holds]
    flagged = signals.flags(ready.models)
    raised = FlagObserver(flagged, ready.models)
    looks: list[Check | HoldCheck] = [*ready.checks, *ready.holds]
    nodes = list(dict.fromkeys([*(node for look in looks for node in look.needed), *flagged, *observers[0]]))
    recording = session.fly(
        ready.starts,
        [*expected, raised, *held, *observers[1]],
        nodes,
        columns=ready.columns,
        around=around,
        options=options,
    )
    if recording.failure and (refused := refusal(ready.scenario, ready.models, recording.failure)):
        raise InputError(refused)
    complete = recording.failure is None and not recording.interrupted
    return Result(
        scenario=ready.scenario,
        models=ready.models,
        time=recording.time,
        samples=recording.values,
        columns=recording.columns,
        outcomes=[observer.outcome(not complete) for observer in expected],
        not_evaluated=[not_evaluated(*entry) for entry in ready.not_evaluated],
        holds=[observer.hold for observer in held if len(recording.time)],
        booleans=raised.flags,
        highlights=highlights(expected),
        settled=settlings(expected),
        warnings=[
            *ready.notes,
            *session.notes,
            *([PYTHON_LOOP] if options.pacer is not None and options.compiled else []),
        ],
        steps=recording.steps,
        reached=ready.clock.time(recording.steps),
        wall=recording.wall,
        failure=recording.failure or recording.closing,
        interrupted=recording.interrupted,
        pace=options.pacer.pace if options.pacer is not None else None,
    )
