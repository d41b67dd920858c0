"""The verdicts: what runs say of a requirement, and when it is decided.

A requirement asks that a run meets a bound with probability P, shown at confidence C. It is met when the lower bound of
the probability at confidence C is at least P, not met when the upper bound is below P, and undecided between.
Whichever is true, the wrong one of these two words is said with probability 1 - C at most. bounds.py has the bounds.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from .bounds import elsewhere, fixed, runs_needed, sequence


@dataclass(frozen=True)
class Requirement:
    """A run meets this requirement with a probability of at least `probability`, to be shown at `confidence`."""

    name: str
    probability: float
    confidence: float


@dataclass(frozen=True)
class Announced:
    """The plan of a campaign as it was before the first run; it stands in the campaign's folder and does not change."""

    runs: int
    early: bool
    """Whether it may end as soon as all is decided, so that it is looked at after any number of runs."""


@dataclass(frozen=True)
class Verdict:
    """The verdict of runs on a requirement."""

    name: str
    status: Literal["met", "not met", "undecided"]
    share: float | None
    """Share of the runs that meet the requirement; None without runs."""
    low: float
    high: float
    """Bounds of the probability, each for itself at the confidence."""
    flown: int
    met: int
    probability: float
    confidence: float
    text: str
    """The verdict as a sentence."""


def verdicts(
    requirements: Iterable[Requirement], met: Mapping[str, int], flown: int, announced: Announced | None = None
) -> list[Verdict]:
    """Returns what the first `flown` runs say of the requirements; met[name] of them meet one.

    `announced` is what was said before the first run; None where that was `flown` runs.
    """
    return [_verdict(one, met[one.name], flown, announced or Announced(flown, False)) for one in requirements]


def _verdict(requirement: Requirement, met: int, flown: int, announced: Announced) -> Verdict:
    early, other = announced.early, not announced.early and flown != announced.runs
    if other:
        bounds = elsewhere(met, flown, requirement.probability, requirement.confidence, announced.runs)
    else:
        bounds = (sequence if early else fixed)(met, flown, requirement.confidence)
    status: Literal["met", "not met", "undecided"] = "undecided"
    if bounds.low >= requirement.probability:
        status = "met"
    elif bounds.high < requirement.probability:
        status = "not met"
    at = f"at {percent(requirement.confidence)} confidence"
    text = f"{met} of {flown} runs meet it; probability "
    if status == "met":
        text += f"at least {probability(bounds.low)} {at}, required {requirement.probability:g}"
    elif status == "not met":
        text += f"at most {probability(bounds.high, up=True)} {at}, required {requirement.probability:g}"
    else:
        text += f"{ends(bounds.low, bounds.high)}, each {at}, required {requirement.probability:g}"
        least = runs_needed(requirement.probability, requirement.confidence, early)
        if other:
            stopped = "stopped early" if flown < announced.runs else "flown on"
            text += f"; {stopped}: {announced.runs} runs were announced"
        elif flown < least:
            text += f"; {least} runs are needed at least"
    mean = met / flown if flown else None
    return Verdict(
        requirement.name,
        status,
        mean,
        bounds.low,
        bounds.high,
        flown,
        met,
        requirement.probability,
        requirement.confidence,
        text,
    )


def hints(requirements: Iterable[Requirement], runs: int, early: bool = False) -> list[str]:
    """Returns requirements that so many runs cannot show, even if each of them meets the requirement, as sentences."""
    needed = {
        requirement: runs_needed(requirement.probability, requirement.confidence, early) for requirement in requirements
    }
    return [
        f"{requirement.name}: {runs} runs cannot show a probability of {requirement.probability:g} at "
        f"{percent(requirement.confidence)} "
        f"confidence; {least} are needed at least" + (", if it may stop early" if early else "")
        for requirement, least in needed.items()
        if least > runs
    ]


def percent(value: float) -> str:
    """Returns a share as a percentage: 95%, 99.73%."""
    return f"{100.0 * value:.10g}%"


def probability(value: float, up: bool = False) -> str:
    """Returns a bound of a probability, rounded outwards to three figures of its distance from 0 or 1, whichever is
    nearer.
    """
    distance = min(value, 1.0 - value)
    if distance <= 0.0:
        return f"{value:g}"
    places = 2 - int(np.floor(np.log10(distance)))
    scaled = value * 10.0**places
    return f"{(np.ceil(scaled - 1e-6) if up else np.floor(scaled + 1e-6)) / 10.0**places:.{places}f}"


def ends(low: float, high: float) -> str:
    """Returns both bounds of a probability, each for itself: no interval, whose confidence would be less than that of
    each.
    """
    return f"at least {probability(low)}, at most {probability(high, up=True)}"
