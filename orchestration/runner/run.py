"""From a scenario to a result: opens the FMUs, checks everything, runs, judges."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import BlockError, InputError, hint
from ..expectations import checks as expectations
from ..expectations import holds
from ..expectations.checks import Check
from ..expectations.holds import Look
from ..fmu.interfaces import is_path
from ..fmu.model import Floats, Model
from ..instances.block import Block
from ..master.master import Master
from ..master.recording import Progress, Watch
from ..results.result import Result
from ..scenario.scenario import Scenario
from ..swap import prepare as swap
from ..system import order, panels, signals, starts, wiring
from ..system.clock import Clock, check_size, clock
from ..system.faults import Faults, resolve
from ..system.order import Hook, Order
from ..system.starts import Start
from ..system.wiring import Node, Wiring
from .manifest import manifest
from .read import load
from .refusal import refusal

if TYPE_CHECKING:
    from ..fmu.archive import Fmu


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
    holds: list[Look]
    columns: list[Node]
    notes: list[str]
    """Warnings and remarks, for the user to see."""
    faults: Faults = field(default_factory=Faults)


def plan(scenario: Scenario, models: Mapping[str, Model], feedthrough: Hook | None = None) -> Plan:
    """Checks a scenario against what its blocks offer. Raises InputError; what several checks find comes together."""
    (times, remarks), values, (wired, sequence, amiss), recorded, (checks, more), drawn, held = _together(
        lambda: clock(scenario),
        lambda: starts.resolve(scenario, models),
        lambda: _wired(scenario, models, feedthrough),
        lambda: signals.recorded(scenario, models),
        lambda: expectations.prepare(scenario, models),
        lambda: panels.check(scenario, models),
        lambda: holds.prepare(scenario, models),
    )
    needed = [node for look in (*checks, *held) for node in look.needed]
    columns = list(dict.fromkeys([*recorded, *needed, *drawn, *signals.flags(models)]))
    check_size(scenario, times, len(columns))
    notes = [*remarks, *wired.warnings, *sequence.warnings, *more, *amiss.notes]
    return Plan(scenario, models, times, wired, values, sequence, checks, held, columns, notes, amiss)


def _wired(scenario: Scenario, models: Mapping[str, Model], feedthrough: Hook | None) -> tuple[Wiring, Order, Faults]:
    wired = wiring.connect(scenario, models)
    sequence, amiss = _together(
        lambda: order.sort(scenario, models, wired, feedthrough), lambda: resolve(scenario, models, wired)
    )
    return wired, sequence, amiss


def _together(*checks: Callable[[], Any]) -> list[Any]:
    """What the checks return. Raises InputError with the faults of all of them."""
    found: list[Any] = []
    faults: list[str] = []
    for check in checks:
        try:
            found.append(check())
        except InputError as error:
            faults += error.messages
    if faults:
        raise InputError(*faults)
    return found


def run(
    scenario: str | Path | Mapping[str, Any] | Scenario,
    overrides: Mapping[str, Any] | None = None,
    *,
    out: str | Path | None = None,
    progress: Progress | None = None,
    verbose: bool = False,
    compiled: bool = True,
) -> Result:
    """Runs a scenario: a file, the same as a dictionary, or what `load` returned.

    `overrides` are start values by name, `{"plant.x0": "98 deg"}`, and `step` and `duration`.
    `out` is a folder to write the results to; without it nothing is written. `compiled` False asks for the
    step loop in Python, which is otherwise used only where the one in C cannot be; both give the same bits.
    Raises InputError where the scenario is wrong, and BlockError where a block fails; what was computed up
    to then is its `result`; ResultsError where the results cannot be written. Ctrl-C ends the run, and the result is marked as interrupted.
    """
    loaded = load(scenario.source if isinstance(scenario, Scenario) else scenario, overrides)
    result = execute(loaded, progress, verbose, compiled)
    if out is not None:
        result.save(out)
    if result.failure is not None:
        result.failure.result = result
        raise result.failure
    return result


def execute(
    scenario: Scenario, progress: Progress | None = None, verbose: bool = False, compiled: bool = True
) -> Result:
    """Runs a scenario on its FMUs. A failing FMU ends the run, and the result says so."""
    from ..fmu.archive import open_fmu

    fmus: dict[str, Fmu] = {}
    faults: list[str] = []
    paths: dict[Path, Fmu] = {}
    for name, entry in scenario.blocks.items():
        key = ("blocks", name, "fmu")
        if entry.flavour and is_path(entry.fmu):
            message = f"only this project's own blocks have a flavour; {entry.fmu} is a file"
            faults.append(scenario.error(("blocks", name, "flavour"), message))
        try:
            path = locate(entry.fmu, scenario.source.folder, entry.flavour or scenario.flavour)
            fmus[name] = paths[path] = paths.get(path) or open_fmu(path)
        except InputError as error:
            faults += [scenario.error(key, message + _remedy(message, scenario, name)) for message in error.messages]
    if faults:
        raise InputError(*faults)
    prepared = swap.prepare(scenario, fmus)
    ready = plan(prepared.scenario, prepared.models, prepared.feedthrough)
    ready.notes[:0] = prepared.notes
    with ExitStack() as stack:
        instances = instantiate(ready, fmus, stack, verbose)
        blocks = {name: prepared.adapted(block) for name, block in instances.items()}
        result = run_blocks(ready, blocks, progress, compiled)
    for block in instances.values():
        result.failure = result.failure or getattr(block, "failure", None)  # what went wrong in closing it
    result.manifest = manifest(ready, fmus, result, prepared.handed_on(ready.starts))
    return result


def instantiate(ready: Plan, fmus: Mapping[str, Fmu], stack: ExitStack, verbose: bool) -> dict[str, Block]:
    from ..fmu.archive import shown
    from ..instances.isolation import IsolatedBlock
    from ..instances.process import Limits
    from ..instances.slave import Slave
    from .limits import limits

    bounds = {name: limits(ready.scenario, name) for name in fmus}
    work = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="orchestrate-", ignore_cleanup_errors=True)))
    blocks: dict[str, Block] = {}

    def make(name: str, fmu: Fmu, bound: Limits | None) -> None:
        fmu.extract(work / name)
        block = (
            IsolatedBlock(name, fmu, work / name, bound, verbose) if bound else Slave(name, fmu, work / name, verbose)
        )
        stack.callback(block.close)
        blocks[name] = block

    def start(name: str) -> None:
        block = blocks[name]
        if isinstance(block, IsolatedBlock):
            block.started()

    tasks: list[tuple[str, Callable[[], None]]] = [
        *((name, partial(make, name, fmu, bounds[name])) for name, fmu in fmus.items()),
        *((name, partial(start, name)) for name in fmus),  # processes come up side by side
    ]
    for name, task in tasks:
        try:
            task()
        except InputError as error:
            message = f"{error}{_remedy(str(error), ready.scenario, name)}"
            raise InputError(ready.scenario.error(("blocks", name, "fmu"), message)) from None
        except BlockError as error:
            message = f"{shown(fmus[name].path)}: {error}"
            raise InputError(ready.scenario.error(("blocks", name, "fmu"), message)) from None
    return blocks


def _remedy(message: str, scenario: Scenario, name: str) -> str:
    """What helps where a block of this project was built, and its file has been spoilt since."""
    entry = scenario.blocks[name]
    if "damaged" not in message or is_path(entry.fmu):
        return ""
    option = "" if (entry.flavour or scenario.flavour) == "native" else " --flavour python"
    return f"; remedy: orchestrate build {entry.fmu}{option}"


def run_blocks(
    ready: Plan, blocks: Mapping[str, Block], progress: Progress | None = None, compiled: bool = False
) -> Result:
    """Runs a plan on any blocks, and judges its expectations."""
    scenario = ready.scenario
    every = {name: entry.every for name, entry in scenario.blocks.items()}
    parallel = scenario.exchange == "parallel"
    judges = [expectations.Judge(check) for check in ready.checks]
    watchers = [(look, holds.Judge(look.entry.name, look.entry.signal)) for look in ready.holds]
    looks: list[Check | Look] = [*ready.checks, *ready.holds]
    watched = list(dict.fromkeys(node for look in looks for node in look.needed))

    def see(time: Floats, values: Floats) -> None:
        columns = {node: values[:, i] for i, node in enumerate(watched)}
        for judge in judges:
            judge.see(time, columns)
        for look, watcher in watchers:
            holds.see(look, watcher, time, columns)

    between = bool(watched) and ready.clock.interval > 1  # else all of it is recorded
    watch = Watch(watched, ready.clock, see) if between else None
    master = Master(
        blocks, ready.wiring, ready.order, ready.clock, ready.columns, every, parallel, compiled, ready.faults, watch
    )
    recording = master.run(ready.starts, progress)
    if recording.failure and (refused := refusal(scenario, ready.models, recording.failure)):
        raise InputError(refused)
    if watch is None:
        see(recording.time, recording.values[:, [recording.columns.index(node) for node in watched]])
    return Result(
        scenario=scenario,
        models=ready.models,
        time=recording.time,
        samples=recording.values,
        columns=recording.columns,
        outcomes=[judge.outcome for judge in judges],
        holds=[watcher.hold for _, watcher in watchers if len(recording.time)],
        highlights=expectations.highlights(judges),
        warnings=ready.notes,
        steps=recording.steps,
        wall=recording.wall,
        failure=recording.failure,
        interrupted=recording.interrupted,
    )


def locate(fmu: str, folder: Path, flavour: str) -> Path:
    """The file of an FMU: a block of this project by its bare name, built when need be, or a path."""
    if "://" in fmu:
        raise InputError(f"{fmu} is an address; expected the path of an .fmu file")
    if is_path(fmu):
        return (folder / Path(fmu).expanduser()).resolve()
    from fmus.build import BLOCKS, FLAVOURS, BuildError, ensure
    from fmus.interface import load as load_interface

    if fmu not in BLOCKS:
        ending = hint(fmu, BLOCKS)
        raise InputError(f"this project has no block {fmu!r}{ending}; the path of an FMU ends in .fmu")
    if flavour in FLAVOURS and flavour not in (has := load_interface(fmu).flavours):
        there = " or ".join(f"'flavour: {one}'" for one in has)
        raise InputError(f"the block {fmu!r} has no flavour {flavour!r}; remedy: {there} beside it")
    try:
        return ensure(fmu, flavour)
    except BuildError as error:
        raise InputError(f"the block {fmu!r} cannot be built: {error}") from None
    except OSError as error:
        raise InputError(
            f"the block {fmu!r} cannot be built: {error.filename or 'the disk'}: {error.strerror}"
        ) from None
