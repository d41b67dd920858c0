"""Tries what hosts do to an FMU: two plays, resets, states, instances side by side, threads, other steps, bad inputs.

It runs in a process of its own, which leaves its results line by line: so a crash is told with its trial.
Tests: tests/orchestration/acceptance/test_accept.py.
"""

from __future__ import annotations

import json
import multiprocessing
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from ..errors import BlockError
from ..fmu.model import Floats
from ..scenario.source import Source
from .polarity.apart import bound, bounds
from .polarity.bench import Bench
from .polarity.fly import Loop

Inputs = dict[str, Floats]
Outputs = dict[str, Floats]
_LIMIT = 90.0
"""Seconds that all trials may take; a call of them may take what the block's 'timeout' allows."""
_WARM = 20
"""Calls that are not timed at first."""


@dataclass(frozen=True)
class Trial:
    """Result of a trial."""

    name: str
    status: str
    """met, failed, or empty where it could not be tried."""
    text: str


def tried(source: Source, block: str, inputs: Inputs) -> list[Trial]:
    """Returns what became of each trial of a scenario's block on inputs (instants, elements) by name."""
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder, "trials")
        context = multiprocessing.get_context("spawn")
        told, into = context.Pipe(duplex=False)
        process = context.Process(target=_all, args=(source, block, inputs, str(log), into), daemon=True)
        process.start()
        process.join(_LIMIT)
        late = process.is_alive()
        if late:
            process.kill()
            process.join()
        stuck = told.recv() if told.poll() else None
        told.close()
        into.close()
        lines = [json.loads(line) for line in log.read_text("utf-8").splitlines()] if log.exists() else []
    done = [Trial(**line) for line in lines if "status" in line]
    names = [line["name"] for line in lines]
    if names and names[-1] not in [trial.name for trial in done]:
        how = f"did not end within {_LIMIT:g} s" if late else f"ended its process, with status {process.exitcode}"
        if stuck is not None:
            call, seconds = stuck
            how = f"did not return from {call.removeprefix(f'{block}: ')} within {seconds:g} s"
        done.append(Trial(names[-1], "failed", f"the FMU {how}"))
    elif not names:
        done.append(Trial("trials", "failed", "the process of the trials ended before the first"))
    return done


def _all(source: Source, block: str, inputs: Inputs, log: str, into: Connection) -> None:
    bound(into, *bounds(source, block))
    with open(log, "w", encoding="utf-8", buffering=1) as file, ExitStack() as stack:
        loop = Loop(source)
        for name, trial in _trials(loop, block, inputs, stack):
            file.write(json.dumps({"name": name}) + "\n")
            try:
                status, text = trial()
            except BlockError as error:
                status, text = "failed", str(error)
            except MemoryError:
                status, text = "failed", "it used up the memory that the block's 'memory' allows"
            file.write(json.dumps(asdict(Trial(name, status, text))) + "\n")


Tried = Callable[[], tuple[str, str]]


def _trials(loop: Loop, block: str, inputs: Inputs, stack: ExitStack) -> Iterator[tuple[str, Tried]]:
    first = Bench(loop, block, stack)
    kind = loop.opened.fmus[block].kind
    plain = first.played(inputs)

    def again() -> tuple[str, str]:
        other = Bench(loop, block, stack).played(inputs)
        return _same(plain, other, "a fresh instance")

    yield "the same inputs twice give the same bits", again

    def reset() -> tuple[str, str]:
        other = first.played(inputs)
        return _same(plain, other, "after a reset") if first.keeps_instance else ("", "it has no reset")

    yield "after a reset it is as new", reset

    def state() -> tuple[str, str]:
        offers = loop.opened.fmus[block].description.coSimulation
        if not (getattr(offers, "canGetAndSetFMUstate", False) or getattr(offers, "canGetAndSetFMUState", False)):
            return "", "it offers no states (canGetAndSetFMUstate)"
        return _same(*first.restored(inputs), "after its state was restored")

    yield "a saved state is restored whole", state

    def side_by_side() -> tuple[str, str]:
        if kind.alone:
            return "", "it can have one instance in a process only"
        benches = [Bench(loop, block, stack) for _ in range(2)]
        with ThreadPoolExecutor(2) as pool:
            both = list(pool.map(lambda bench: bench.played(inputs), benches))
        statuses = [_same(plain, other, "in two threads at once") for other in both]
        return max(statuses, key=lambda one: one[0] == "failed")

    yield "two instances in two threads do not disturb each other", side_by_side

    def half() -> tuple[str, str]:
        if not kind.variable_step:
            return "", "its step is fixed"
        bench = Bench(loop, block, stack)
        bench.step /= 2
        finer = bench.played({name: np.repeat(values, 2, axis=0)[1:] for name, values in inputs.items()})
        apart = max(
            float(np.abs(finer[n][::2] - plain[n]).max()) / (float(np.abs(plain[n]).max()) or 1.0) for n in plain
        )
        return "met", f"steps of {bench.step:.6g} s too: outputs differ by at most {100 * apart:.2g} %"

    yield "it takes half the step", half

    for label, value in (("zero", 0.0), ("1e6 times as large", 1e6), ("not a number", np.nan)):
        yield f"an input that is {label} does no harm", _bad(loop, block, inputs, value)

    def quick() -> tuple[str, str]:
        bench = Bench(loop, block, stack)
        seconds: list[float] = []
        bench.seconds = seconds
        bench.played(inputs)
        taken = np.array(seconds[_WARM:] or seconds)
        p50, p99, most = (float(f"{1e6 * x:.3g}") for x in (*np.percentile(taken, (50, 99)), taken.max()))
        share = np.percentile(taken, 99) / bench.step
        text = f"Set, DoStep and Get: median {p50:g} us, p99 {p99:g} us, longest {most:g} us of {len(taken)} steps"
        return "met" if share < 1.0 else "failed", f"{text}; p99 is {100 * share:.2g} % of the step"

    yield "the 99th percentile of a step is below its length", quick


def _bad(loop: Loop, block: str, inputs: Inputs, value: float) -> Tried:
    """Each input in turn is so from the middle of the play on."""

    def trial() -> tuple[str, str]:
        refused, passed = [], []
        for name, values in inputs.items():
            if loop.plan.models[block].variables[name].type != "real":
                continue
            bad, half = values.copy(), len(values) // 2
            bad[half:] = value if value == 0.0 or np.isnan(value) else value * bad[half:]
            try:
                with ExitStack() as own:
                    outputs = Bench(loop, block, own).played({**inputs, name: bad})
            except BlockError:
                refused.append(name)
                continue
            if not all(np.isfinite(v).all() for v in outputs.values()):
                passed.append(name)
        texts = [f"refused at {', '.join(refused)}"] if refused else []
        texts += [f"outputs are not finite by {', '.join(passed)}, with status ok"] if passed else []
        return "failed" if passed else "met", "; ".join(texts) or "all outputs stay finite"

    return trial


def _same(one: Outputs, other: Outputs, when: str) -> tuple[str, str]:
    for name, values in one.items():
        differs = np.flatnonzero((values != other[name]).any(axis=1))
        if len(differs):
            largest = float(np.abs(values - other[name]).max())
            return "failed", f"{when} {name} differs by up to {largest:.3g}, first at step {differs[0]}"
    count = sum(values.size for values in one.values())
    return "met", f"{when}: {count} values have the same bits"
