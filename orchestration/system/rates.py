"""How often a block that cannot vary its step is stepped: several times in a base step, or once in several."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from ..errors import InputError, Problems
from ..fmu.archive import Fmu
from ..fmu.co_simulation import CoSimulation
from ..instances.substeps import Substeps
from ..scenario.load import load
from ..scenario.scenario import Scenario
from ..scenario.source import Key, Source

_SUBSTEPS_MAX = 10_000


@dataclass
class Rates:
    """A scenario in which every block is stepped as its FMU can be stepped."""

    scenario: Scenario
    substeps: dict[str, Substeps] = field(default_factory=dict)
    """Of the blocks that are stepped several times in each of their steps."""
    notes: list[str] = field(default_factory=list)


def rates(scenario: Scenario, fmus: Mapping[str, Fmu]) -> Rates:
    """Finds how often each block is stepped. Raises InputError with every step that does not divide."""
    found = Rates(scenario)
    source = scenario.source
    with Problems() as problems:
        for name, fmu in fmus.items():
            with problems.gathered():
                source = _timed(found, source, name, fmu.kind)
    if source is not scenario.source:
        found.scenario = load(source)
    return found


def _timed(found: Rates, source: Source, name: str, kind: CoSimulation) -> Source:
    scenario = found.scenario
    with scenario.source.naming(("blocks", name, "fmu")):
        own_step = kind.sample_time()
    if own_step is None:
        return source
    entry, base = scenario.blocks[name], Fraction(repr(scenario.step))
    given = entry.every if "every" in entry.model_fields_set else None
    step = base * (given or 1)
    ratio = own_step / step
    inside = kind.steps_inside
    why = f"its FMU {'steps inside by' if inside else 'cannot vary its step of'} {float(own_step):.10g} s"
    key: Key = ("blocks", name, "every") if given else ("blocks", name, "fmu")
    if ratio == 1 or (inside and (1 / ratio).denominator == 1):
        return source
    if 1 / ratio > _SUBSTEPS_MAX:
        message = f"{why}, more than {_SUBSTEPS_MAX} of them in each step of {float(step):.10g} s"
        raise InputError(
            scenario.error(key, f"{message}; remedy: a smaller base step, or a larger stepSize in the FMU")
        )
    if (1 / ratio).denominator == 1:
        found.substeps[name] = Substeps(int(1 / ratio), own_step)
        found.notes.append(f"{name}: {why}: {int(1 / ratio)} of them in each step of {float(step):.10g} s")
        return source
    if given is None and ratio.denominator == 1:
        found.notes.append(f"{name}: {why}: it is stepped once in {int(ratio)} base steps ('every: {int(ratio)}')")
        return source.with_entry(("blocks", name, "every"), int(ratio))
    remedy = f"'every: {int(own_step / base)}'" if (own_step / base).denominator == 1 else _steps(own_step, base)
    message = f"{why}, which is no multiple of the step, {float(step):.10g} s; remedy: {remedy}"
    raise InputError(scenario.error(key, message))


def _steps(own_step: Fraction, base: Fraction) -> str:
    fitting = [own_step / n for n in range(1, 100) if own_step / n <= base]
    return f"a base step that divides it, such as 'step: {float(fitting[0] if fitting else own_step):.10g} s'"
