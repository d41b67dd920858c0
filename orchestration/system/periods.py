"""Parameters that are times of so many steps of their block, such as the period of a sampled law, held against these
steps."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction

from fmus.interface import SAMPLE_PERIOD

from ..errors import InputError, Problem
from ..fmu.interfaces import in_steps
from ..fmu.model import Element, Model
from ..scenario.scenario import Scenario
from .clock import multiples_near, whole
from .starts import Start


def notes(scenario: Scenario, models: Mapping[str, Model], starts: Mapping[str, Sequence[Start]]) -> list[str]:
    """Warnings of times that are too short. Raises InputError with every time that its block's step does not divide.

    An FMU other than of the project's own blocks does not say which of its parameters are such times.
    """
    warnings, problems = list[str](), list[Problem]()
    for block, model in models.items():
        values = {**model.starts, **{start.element: start.value for start in starts[block]}}
        times = in_steps(model.name)
        endless = [n for n in (SAMPLE_PERIOD, *times) if not math.isfinite(float(values.get(Element(n, 0), 0.0)))]
        if endless:
            found = [f"its FMU's start value of {n} is {float(values[Element(n, 0)])}" for n in endless]
            message = f"{'; '.join(found)}; expected a finite time; remedy: give it in start"
            problems.append(scenario.error(("blocks", block), message))
            continue
        every = scenario.blocks[block].every
        step = every * Fraction(repr(scenario.step))
        counted = f" ({every} base steps of {scenario.step:.10g} s)" if every > 1 else ""
        if period := Fraction(repr(float(values.get(Element(SAMPLE_PERIOD, 0), 0.0)))):
            if not whole(period / step):
                warnings.append(
                    f"{block}.{SAMPLE_PERIOD} = {float(period):.10g} s is no multiple of its step, {float(step):.10g} s"
                    f"{counted}; it acts at the step after each of its instants"
                )
            step, counted = period, f" ({SAMPLE_PERIOD})"
        of = f"the step of {block}, {float(step):.10g} s{counted}"
        for name, steps in times.items():
            if (element := Element(name, 0)) not in values:
                continue  # an FMU that has taken the name of a block of ours, without this parameter
            time = float(values[element])
            count = Fraction(repr(time)) / step
            if steps == "whole" and not whole(count):
                message = f"expected a multiple of {of}, found {time:.10g} s; remedy: {multiples_near(time, step)}"
                key = scenario.given(block).get(name, ("blocks", block, "start", name))
                problems.append(scenario.error(key, f"{message}, or another step"))
            elif steps == "at least one" and count < 1 and whole(count) != 1:
                message = f"{block}.{name} = {time:.10g} s is less than {of}; remedy: {float(step):.10g} s or more"
                warnings.append(f"{message}, or a smaller step")
    if problems:
        raise InputError(*problems)
    return warnings
