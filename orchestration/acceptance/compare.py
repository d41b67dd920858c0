"""Another team's FMU back to back with ours.

Open loop: what our block was given in a run is given to theirs, and output stands against output.
Closed loop: the whole run with theirs in the place, its expectations beside those of ours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from ..errors import BlockError, InputError
from ..expectations.judge import Outcome
from ..fmu.model import TYPES, Variable
from ..quantities import with_unit
from ..results.result import Result
from ..runner.open import open_scenario
from ..runner.read import load
from ..runner.run import execute
from ..scenario.source import Source
from ..swap.own_claims import own_claims
from ..system.starts import taken
from ..system.wiring import fed
from . import playback
from .inputs import given, theirs_alone
from .tolerances import Tolerance, tolerances

ROUNDING = 1e-15
"""A difference this small is rounding, however small the output itself."""


@dataclass
class Difference:
    """How far one output of theirs is from ours, on the same inputs."""

    output: str
    unit: str
    passed: bool
    tolerance: str
    largest: float | None = None
    """The largest of all elements and instants; of a boolean or an enumeration the share of samples that differ."""
    element: str = ""
    time: float | None = None
    share: float | None = None
    """`largest` over our output's largest value."""
    rms: float | None = None
    note: str = ""


@dataclass
class Comparison:
    """Both runs and all differences."""

    block: str
    fmu: str
    ours: Result
    theirs: Result
    played: playback.Played
    differences: list[Difference] = field(default_factory=list)
    interval: float = 0.0
    """From one instant to the next at which outputs are compared, s."""

    @property
    def failure(self) -> BlockError | None:
        return self.played.failure or self.theirs.failure or self.ours.failure

    @property
    def equivalent(self) -> bool:
        return self.played.failure is None and all(d.passed for d in self.differences)

    @property
    def met(self) -> bool:
        """Whether theirs meets every expectation whose signals it has."""
        return self.theirs.passed

    @property
    def passed(self) -> bool:
        return self.equivalent and self.met

    @property
    def claims(self) -> list[tuple[Outcome, Outcome | None]]:
        """Ours and theirs; None where an output that theirs lacks would have been looked at."""
        theirs = {outcome.name: outcome for outcome in self.theirs.outcomes}
        return [(outcome, theirs.get(outcome.name)) for outcome in self.ours.outcomes]


def compare(source: Source, theirs: Source, block: str, wanted: Sequence[str] = ()) -> Comparison:
    """Compares the block of a scenario with that of the same scenario swapped. Raises InputError, and BlockError where ours fails.

    `wanted` are tolerances as `tolerances.tolerances` takes them.
    """
    loaded = load(source)
    if block not in loaded.blocks:
        raise InputError(f"{loaded.source.file or 'scenario'} has no block {block!r}")
    fmu = open_scenario(loaded).fmus[block]
    ports = [v for v in fmu.model.of("input", "output") if v.type in TYPES]
    swapped = open_scenario(load(theirs))  # what does not fit is refused before ours is run
    extra = theirs_alone(swapped, block)
    signals = [f"{block}.{v.name}" for v in ports if v.causality == "input"]
    signals += [f"{node.block}.{node.element.variable}" for link in extra for node in link.source]
    ours = execute(load(_recording(source, block, signals)))
    if ours.failure is not None:
        ours.failure.result = ours
        raise ours.failure
    bounds = tolerances(wanted, ours.models[block])
    with_theirs = load(theirs)
    entry = with_theirs.source.data["blocks"][block]
    inputs = {v.name: ours[f"{block}.{v.name}"] for v in fed(loaded, block, ports) if f"{block}.{v.name}" in ours}
    inputs |= given(ours, extra, swapped)
    if extra:
        mapping = swapped.prepared.fits[block].mapping
        assert mapping is not None
        entry = {**entry, "map": mapping.model_copy(update={"inputs": {}}).model_dump(exclude_none=True)}
    model = swapped.prepared.models[block]
    shared = {str(name): value for name, value in with_theirs.shared.items() if taken(model, name)}
    played = playback.play(block, entry, str(with_theirs.source.folder), ours.time, inputs, shared)
    names = [f"{block}.{v.name}" for v in ports if v.causality == "input" and v.name in played.model.variables]
    other = execute(load(_recording(theirs, block, names)))
    outputs = [v.name for v in other.models[block].of("output")]
    other.warnings += [str(finding) for finding in own_claims(other.scenario, block, outputs)]
    comparison = Comparison(block, str(entry["fmu"]), ours, other, played)
    comparison.differences = _differences(comparison, ports, bounds, loaded.blocks[block].every)
    rows = played.rows
    comparison.interval = float(ours.time[rows[1]] - ours.time[rows[0]]) if len(rows) > 1 else 0.0
    return comparison


def _recording(source: Source, block: str, more: Sequence[str]) -> Source:
    """The scenario, with all that the block gives, and more signals, recorded at every step."""
    record = source.data.get("record") or {}
    signals = [*(record.get("signals") or ["*"]), f"{block}.*", *more]
    return source.with_entry(("record",), {"signals": list(dict.fromkeys(signals))})


def _differences(
    comparison: Comparison, ports: Sequence[Variable], bounds: dict[str, Tolerance], every: int
) -> list[Difference]:
    ours, played = comparison.ours, comparison.played
    chosen = played.rows % every == 0
    rows = played.rows[chosen]
    differences = []
    for variable in (v for v in ports if v.causality == "output"):
        bound = bounds[variable.name]
        unit = str(variable.unit) if variable.unit is not None and str(variable.unit) != "1" else ""
        tolerance = " and ".join(
            f"{b.text}{how}" for b, how in ((bound.largest, ""), (bound.rms, " rms")) if b is not None
        )
        if variable.name not in played.outputs:
            differences.append(Difference(variable.name, unit, True, tolerance, note="theirs lacks it"))
            continue
        a = ours[f"{comparison.block}.{variable.name}"].reshape(len(ours.time), -1)[rows].astype(float)
        b = played.outputs[variable.name][chosen]
        differences.append(_difference(variable, a, b, ours.time[rows], bound, unit, tolerance))
    return differences


def _difference(
    variable: Variable, ours: Any, theirs: Any, time: Any, bound: Tolerance, unit: str, tolerance: str
) -> Difference:
    if not len(time):
        return Difference(variable.name, unit, False, tolerance, note="nothing to compare")
    error = np.abs(theirs - ours)
    if variable.type != "real":
        differing = (error > 0.0).any(axis=1)
        share = float(differing.mean())
        passed = all(share <= b.limit(1.0) for b in (bound.largest, bound.rms) if b is not None)
        first = float(time[differing][0]) if differing.any() else None
        return Difference(
            variable.name,
            "",
            passed,
            tolerance,
            share,
            "",
            first,
            share,
            note=f"{int(differing.sum())} of {len(time)} samples",
        )
    row, column = np.unravel_index(int(error.argmax()), error.shape)
    largest, peak = float(error[row, column]), float(np.abs(ours).max())
    rms = float(np.sqrt((error * error).mean(axis=0).max()))
    pairs = [(largest, bound.largest), (rms, bound.rms)]
    passed = all(value <= max(b.limit(peak), ROUNDING) for value, b in pairs if b is not None)
    element = variable.label(int(column)) if variable.shape else ""
    at = float(time[row]) if largest > 0.0 else None
    return Difference(
        variable.name, unit, passed, tolerance, largest, element, at, largest / peak if peak else None, rms
    )


def summary(comparison: Comparison) -> dict[str, Any]:
    """The comparison as plain data."""
    return {
        "block": comparison.block,
        "fmu": comparison.fmu,
        "passed": comparison.passed,
        "equivalent": comparison.equivalent,
        "claims_hold": comparison.met,
        "failure": None if comparison.failure is None else str(comparison.failure),
        "open_loop": [asdict(difference) for difference in comparison.differences],
        "claims": [
            {"name": a.name, "ours": asdict(a), "theirs": None if b is None else asdict(b)}
            for a, b in comparison.claims
        ],
        "notes": comparison.theirs.warnings,
    }


def verdict(comparison: Comparison) -> str:
    """The verdict in a sentence."""
    compared = [d for d in comparison.differences if d.largest is not None]
    within = sum(d.passed for d in compared)
    outcomes = comparison.theirs.outcomes
    met = sum(outcome.passed for outcome in outcomes)
    left = len(comparison.ours.outcomes) - len(outcomes)
    text = f"{'equivalent' if comparison.equivalent else 'not equivalent'}: {within} of {len(compared)} outputs within tolerance; "
    text += f"{met} of {len(outcomes)} expectations met" + (f", {left} not evaluated" if left else "")
    return f"an FMU failed; {text}" if comparison.failure is not None else text


def rows_of_differences(comparison: Comparison) -> list[tuple[bool, tuple[str, ...]]]:
    """Whether it is within its tolerance, and the cells: output, largest, relative, when, rms, tolerance."""
    rows: list[tuple[bool, tuple[str, ...]]] = []
    for d in comparison.differences:
        if d.largest is None:
            rows.append((d.passed, (d.output, d.note, "", "", "", "")))
        elif d.note:
            at = f"first at {d.time:.5g} s" if d.time is not None else ""
            rows.append((d.passed, (d.output, d.note, f"{d.share:.2g}", at, "", d.tolerance)))
        else:
            at = f"{d.time:.5g} s" if d.time is not None else ""
            where = f"{d.element} " if d.element and d.largest else ""
            share = f"{d.share:.2g}" if d.share is not None else ""
            cells = (
                d.output,
                with_unit(d.largest, d.unit),
                share,
                f"{where}{at}",
                with_unit(d.rms or 0.0, d.unit),
                d.tolerance,
            )
            rows.append((d.passed, cells))
    return rows


DIFFERENCES = ("output", "largest difference", "relative", "when", "rms", "tolerance")
