"""What runs say of a probability: shares and quantiles with their bounds, and when a requirement is decided.

A requirement asks that a run meets a bound with probability P, shown at confidence C. It is met when the lower bound of
the probability at confidence C is at least P, not met when the upper bound is below P, and undecided between.
Whichever is true, the wrong one of these two words is said with probability 1 - C at most.

Two kinds of bounds serve. Exact ones (Clopper and Pearson, Biometrika 26, 1934) hold for a number of runs that was fixed
before. Those of a sequence hold after every run at once, so a campaign may look as often as it likes, stop when it is
decided, and go on later where it was not; they ask for about one and a half times as many runs. They come of the mean
likelihood ratio against P over all probabilities on the other side of P, q uniform in (P, 1) for `met`:

    E_n = mean over q of (q/P)^S ((1-q)/(1-P))^(n-S),   S of n runs have met the bound,

a martingale with mean 1 if the probability is P, a supermartingale if it is below, which by Ville's inequality exceeds
1/(1-C) at any n with probability 1-C at most (Darling and Robbins, PNAS 58, 1967; Robbins, Ann. Math. Stat. 41, 1970;
one-sided: Howard et al., Ann. Stat. 49, 2021). The runs must be independent draws, in the order of their index.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import betainc, betaincc, betaincinv, betaln
from scipy.stats import binom, binomtest

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Bounds:
    """A lower and an upper bound."""

    low: float
    high: float


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
    """What runs say of a requirement."""

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


def share(successes: int, runs: int, confidence: float) -> Bounds:
    """The two-sided confidence interval of a probability, of which `successes` of `runs` independent runs are known.

    It is Clopper and Pearson's, which never covers less than its confidence. Without runs it is all of [0, 1].
    """
    if runs == 0:
        return Bounds(0.0, 1.0)
    interval = binomtest(successes, runs).proportion_ci(confidence, "exact")
    return Bounds(float(interval.low), float(interval.high))


def fixed(successes: int, runs: int, confidence: float) -> Bounds:
    """A lower and an upper bound of a probability, each for itself at the confidence, for runs fixed in number before."""
    misses = runs - successes
    low = float(betaincinv(successes, misses + 1, 1.0 - confidence)) if successes else 0.0
    high = float(betaincinv(successes + 1, misses, confidence)) if misses else 1.0
    return Bounds(low, high)


def sequence(successes: int, runs: int, confidence: float) -> Bounds:
    """A lower and an upper bound of a probability, each for itself at the confidence after all numbers of runs at once."""
    if runs == 0:
        return Bounds(0.0, 1.0)
    wanted = -np.log1p(-confidence)
    least, most = np.finfo(float).tiny, float(np.nextafter(1.0, 0.0))
    mean = min(max(successes / runs, least), most)

    def of(side: int) -> Callable[[float], float]:
        return lambda p: evidence(successes, runs, p)[side] - wanted

    low = brentq(of(0), least, mean, xtol=1e-15) if successes and of(0)(least) > 0.0 else 0.0
    high = brentq(of(1), mean, most, xtol=1e-15) if successes < runs and of(1)(most) > 0.0 else 1.0
    return Bounds(low, high)


def evidence(successes: int, runs: int, probability: float) -> tuple[float, float]:
    """The logarithms of E_n (see above) for a probability above this one, and for one below it."""
    hits, misses = successes, runs - successes
    ratio = betaln(hits + 1, misses + 1) - hits * np.log(probability) - misses * np.log1p(-probability)
    with np.errstate(divide="ignore"):  # no weight at all on a side: no evidence
        above = np.log(betaincc(hits + 1, misses + 1, probability)) - np.log1p(-probability)
        below = np.log(betainc(hits + 1, misses + 1, probability)) - np.log(probability)
    return float(ratio + above), float(ratio + below)


def looks(runs: int) -> list[int]:
    """Counts of runs, ascending, after which early stopping looks; the last is `runs`. Each is a seventh above the last."""
    counts, count = [], 30.0
    while count < runs:
        counts.append(round(count))
        count *= 8.0 / 7.0
    return [*counts, runs]


def elsewhere(successes: int, runs: int, requirement: Requirement, announced: int) -> Bounds:
    """Returns bounds of a probability at any other end than that of the runs that were announced first.

    The look at that end is wrong with a probability that Clopper and Pearson's bounds leave somewhat below 1 - C, since
    counts are whole. Only that rest is left to a confidence sequence here, so whoever chooses the end, before or after
    the announced one, is told something wrong with probability 1 - C at most.
    """
    wrong, p = 1.0 - requirement.confidence, requirement.probability
    met = wrong - float(binom.sf(binom.isf(wrong, announced, p), announced, p))
    not_met = wrong - float(binom.cdf(binom.ppf(wrong, announced, p) - 1.0, announced, p))
    low = sequence(successes, runs, 1.0 - met).low if met > 0.0 else 0.0
    return Bounds(low, sequence(successes, runs, 1.0 - not_met).high if not_met > 0.0 else 1.0)


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
        bounds = elsewhere(met, flown, requirement, announced.runs)
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
    """Requirements that so many runs cannot show, even if each of them meets the requirement, as sentences."""
    needed = {
        requirement: runs_needed(requirement.probability, requirement.confidence, early) for requirement in requirements
    }
    return [
        f"{requirement.name}: {runs} runs cannot show a probability of {requirement.probability:g} at {percent(requirement.confidence)} "
        f"confidence; {least} are needed at least" + (", if it may stop early" if early else "")
        for requirement, least in needed.items()
        if least > runs
    ]


def percent(value: float) -> str:
    """A share as a percentage: 95%, 99.73%."""
    return f"{100.0 * value:.10g}%"


def probability(value: float, up: bool = False) -> str:
    """A bound of a probability, rounded outwards to three figures of its distance from 0 or 1, whichever is nearer."""
    distance = min(value, 1.0 - value)
    if distance <= 0.0:
        return f"{value:g}"
    places = 2 - int(np.floor(np.log10(distance)))
    scaled = value * 10.0**places
    return f"{(np.ceil(scaled - 1e-6) if up else np.floor(scaled + 1e-6)) / 10.0**places:.{places}f}"


def ends(low: float, high: float) -> str:
    """Both bounds of a probability, each for itself: no interval, whose confidence would be less than that of each."""
    return f"at least {probability(low)}, at most {probability(high, up=True)}"


def runs_needed(probability: float, confidence: float, repeated: bool) -> int:
    """The least number of runs that shows a requirement as met, when every one of them meets the bound."""
    least = int(np.ceil(np.log1p(-confidence) / np.log(probability) - 1e-9))
    if not repeated:
        return least
    wanted = -np.log1p(-confidence)

    def short(runs: int) -> bool:
        return evidence(runs, runs, probability)[0] < wanted

    low, high = least, 2 * least
    while short(high):
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if short(middle) else (low, middle)
    return high


def quantile(values: Floats, share: float, confidence: float, repeated: bool = False) -> tuple[float, Bounds]:
    """A quantile of values (n,), and a lower and an upper bound of it, each for itself at the confidence.

    The bounds are order statistics and hold for whatever distribution (Wilks, Ann. Math. Stat. 12, 1941): the k-th value
    is an upper bound where k successes of n runs would show a probability of `share`. One is infinite where there are too
    few values for it. Values may be infinite, but not nan. Without values all is nan.
    """
    n = len(values)
    if not n:
        return float("nan"), Bounds(float("nan"), float("nan"))
    bounds = sequence if repeated else fixed
    ordered = np.sort(values)
    above = bisect_left(range(n + 1), True, key=lambda k: bounds(k, n, confidence).low >= share)
    below = bisect_left(range(n + 1), True, key=lambda k: bounds(k, n, confidence).high > share)
    at = ordered[min(max(int(np.ceil(n * share - 1e-9)), 1), n) - 1]
    low = ordered[below - 1] if below else -np.inf
    return float(at), Bounds(float(low), float(ordered[above - 1] if above <= n else np.inf))
