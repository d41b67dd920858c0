"""A scenario's expectations, checked against its blocks before the run; outcomes.py holds the run against them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from ..errors import InputError, Problems
from ..fmu.model import Model
from ..quantities import ONE
from ..scenario.expectations import Bound, Expectation
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from ..system.phases import Phase, phases
from ..system.wiring import Node
from .span import Limits, Sight, limits, sight


@dataclass(frozen=True)
class Check:
    """An expectation that fits the blocks: its signals are known, its units converted."""

    expectation: Expectation
    sight: Sight
    limits: Limits
    """The unit of the bound is also that of the outcome; of `zeros`, that of the signal."""
    expected: str
    items: Mapping[float, str] = field(default_factory=dict)
    """Names of the signal's values: those of the scenario's `phases`, or the items of an enumeration."""

    @property
    def needed(self) -> list[Node]:
        return self.sight.needed


def prepare(scenario: Scenario, models: Mapping[str, Model]) -> tuple[list[Check], list[str]]:
    """Checks expectations against the blocks, and remarks on them. Raises InputError with every error.

    One that begins after the end of the run is an error; where the duration was given as an option,
    it is left out with a remark.
    """
    checks: list[Check] = []
    notes: list[str] = []
    known = phases(scenario, models)
    shortened = ("duration",) in scenario.source.options
    first: dict[str, int] = {}
    with Problems() as problems:
        for number, expectation in enumerate(scenario.expect):
            name = " ".join(expectation.name.split())
            if not name or first.setdefault(name, number) != number:
                message = (
                    f"is that of expect[{first[name] + 1}], too; expected another" if name else "must not be blank"
                )
                problems.append(scenario.error(("expect", number, "name"), message))
                continue
            if shortened and expectation.after is not None and expectation.after > scenario.duration:
                notes.append(f"not looked at, since the run ends before {expectation.after:.10g} s: {expectation.name}")
                continue
            with problems.gathered():
                checks.append(_check(scenario, ("expect", number), expectation, models, known))
    return checks, notes


def _check(
    scenario: Scenario, key: Key, expectation: Expectation, models: Mapping[str, Model], known: Mapping[str, Phase]
) -> Check:
    seen = sight(scenario, key, expectation, expectation.signal, models, scenario.duration, known)
    if expectation.zeros is not None:
        if len(seen.nodes) != 1 or seen.variable.type == "boolean" or expectation.measure == "norm":
            message = f"zeros are counted of one number; {expectation.signal} is {seen.variable.kind}"
            raise InputError(scenario.error((*key, "zeros"), message))
        none = Limits(seen.variable.unit or ONE, 1.0, 0.0, 0.0, 0.0, False, "")
        return Check(expectation, seen, none, changes_of_sign(expectation.zeros))
    how = "always" if expectation.always else "ever"
    bound: Bound = getattr(expectation, how)
    with scenario.naming((*key, how, bound.kind)):
        held = limits(expectation.signal, seen.variable, bound)
    items = {float(number): item for item, number in seen.variable.items}
    if bound.kind == "equals" and seen.variable.type == "integer" and len(seen.nodes) == 1:
        items = {phase.value: name for name, phase in known.items() if phase.signal == seen.nodes[0]}
        if held.low in items:
            held = replace(held, text=items[held.low], number=False)
    return Check(expectation, seen, held, f"{how} {held.text}", items)


def changes_of_sign(count: int) -> str:
    """Returns in words what `zeros` expects."""
    return "no change of sign" if count == 0 else f"{count} change{'s' if count > 1 else ''} of sign"
