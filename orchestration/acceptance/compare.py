"""Compares another team's FMU back to back with ours.

Open loop: what our block was given in a run is given to theirs, and output stands against output.
Closed loop: the whole run with theirs in the place, its expectations beside those of ours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ..errors import BlockError, InputError
from ..expectations.outcomes import Outcome
from ..fmu.model import TYPES, Variable
from ..quantities import shown
from ..results.result import Result
from ..scenario.source import Source
from ..session.open import open_scenario
from ..session.read import load
from ..session.run import whole
from ..swap.own_claims import own_claims
from ..system.starts import taken
from ..system.wiring import fed
from . import playback
from .difference import Difference, difference
from .inputs import given, theirs_alone
from .polarity.mend import Mended, mend
from .tolerances import Tolerance, tolerances


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
    instants: int = 0
    end: float = 0.0
    """The last of these instants, s."""
    mended: Mended | None = None
    """What explains how theirs differs, where it is not equivalent."""

    @property
    def failure(self) -> BlockError | None:
        return self.played.failure or self.theirs.failure or self.ours.failure

    @property
    def equivalent(self) -> bool:
        return self.played.failure is None and all(d.passed for d in self.differences)

    @property
    def met(self) -> bool:
        """Returns whether theirs meets every expectation whose signals it has."""
        return self.theirs.passed

    @property
    def passed(self) -> bool:
        return self.equivalent and self.met

    @property
    def claims(self) -> list[tuple[Outcome, Outcome | None]]:
        """Returns outcomes of ours and theirs; None where theirs lacks an output that is looked at."""
        theirs = {outcome.name: outcome for outcome in self.theirs.outcomes}
        return [(outcome, theirs.get(outcome.name)) for outcome in self.ours.outcomes]


def compare(source: Source, theirs: Source, block: str, wanted: Sequence[str] = ()) -> Comparison:
    """Compares the block of a scenario with that of the same scenario swapped.

    Raises InputError, and BlockError where ours fails.

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
    ours = whole(load(_recording(source, block, signals)))
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
    other = whole(load(_recording(theirs, block, names)))
    outputs = [v.name for v in other.models[block].of("output")]
    other.warnings += [str(finding) for finding in own_claims(other.scenario, block, outputs)]
    comparison = Comparison(block, str(entry["fmu"]), ours, other, played)
    comparison.differences = _differences(comparison, ports, bounds, loaded.blocks[block].every)
    at = ours.time[played.rows]
    comparison.interval = float(at[1] - at[0]) if len(at) > 1 else 0.0
    if not comparison.equivalent and comparison.failure is None:
        comparison.mended = explained(source, theirs, block)
    comparison.instants, comparison.end = len(at), float(at[-1]) if len(at) else 0.0
    return comparison


def explained(source: Source, theirs: Source, block: str) -> Mended | None:
    """Returns what explains how theirs differs from ours; None where the block cannot be played alone."""
    try:
        return mend(source, theirs, block)
    except (BlockError, InputError, ValueError):
        return None


def _recording(source: Source, block: str, more: Sequence[str]) -> Source:
    """Returns the scenario with all that the block gives, and more signals, recorded at every step."""
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
        if variable.name not in played.outputs:
            unit = shown(variable.unit)
            differences.append(Difference(variable.name, unit, True, bound.text, note="theirs lacks it"))
            continue
        a = ours.rows(f"{comparison.block}.{variable.name}")[rows]
        b = played.outputs[variable.name][chosen]
        differences.append(difference(variable, a, b, ours.time[rows], bound))
    return differences
