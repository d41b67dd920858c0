"""Bounds of a probability that runs show, and of quantiles, for a number of runs that was fixed before and for any
number.

Two kinds of bounds serve. Exact ones (Clopper and Pearson, Biometrika 26, 1934) hold for a number of runs that was
fixed before. Those of a sequence hold after every run at once, so a campaign may look as often as it likes, stop when
it is decided, and go on later where it was not; they ask for about one and a half times as many runs. They come of the
mean likelihood ratio against P over all probabilities on the other side of P, q uniform in (P, 1) for `met`:

    E_n = mean over q of (q/P)^S ((1-q)/(1-P))^(n-S),   S of n runs have met the bound,

a martingale with mean 1 if the probability is P, a supermartingale if it is below, which by Ville's inequality exceeds
1/(1-C) at any n with probability 1-C at most (Darling and Robbins, PNAS 58, 1967; Robbins, Ann. Math. Stat. 41, 1970;
one-sided: Howard et al., Ann. Stat. 49, 2021). The runs must be independent draws, in the order of their index.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass

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


def share(successes: int, runs: int, confidence: float) -> Bounds:
    """Returns the two-sided confidence interval of a probability, of which `successes` of `runs` independent runs are
    known.

    It is Clopper and Pearson's, which never covers less than its confidence. Without runs it is all of [0, 1].
    """
    if runs == 0:
        return Bounds(0.0, 1.0)
    interval = binomtest(successes, runs).proportion_ci(confidence, "exact")
    return Bounds(float(interval.low), float(interval.high))


def fixed(successes: int, runs: int, confidence: float) -> Bounds:
    """Returns a lower and an upper bound of a probability, each for itself at the confidence, for runs fixed in number
    before.
    """
    misses = runs - successes
    low = float(betaincinv(successes, misses + 1, 1.0 - confidence)) if successes else 0.0
    high = float(betaincinv(successes + 1, misses, confidence)) if misses else 1.0
    return Bounds(low, high)


def sequence(successes: int, runs: int, confidence: float) -> Bounds:
    """Returns a lower and an upper bound of a probability, each for itself at the confidence after all numbers of runs
    at once.
    """
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
    """Returns the logarithms of E_n (see above) for a probability above this one, and for one below it."""
    hits, misses = successes, runs - successes
    ratio = betaln(hits + 1, misses + 1) - hits * np.log(probability) - misses * np.log1p(-probability)
    with np.errstate(divide="ignore"):  # no weight at all on a side: no evidence
        above = np.log(betaincc(hits + 1, misses + 1, probability)) - np.log1p(-probability)
        below = np.log(betainc(hits + 1, misses + 1, probability)) - np.log(probability)
    return float(ratio + above), float(ratio + below)


def elsewhere(successes: int, runs: int, required: float, confidence: float, announced: int) -> Bounds:
    """Returns bounds of a probability at any other end than that of the runs that were announced first.

    The look at that end is wrong with a probability that Clopper and Pearson's bounds leave somewhat below 1 - C, since
    counts are whole. Only that rest is left to a confidence sequence here, so whoever chooses the end, before or after
    the announced one, is told something wrong with probability 1 - C at most.
    """
    wrong, p = 1.0 - confidence, required
    met = wrong - float(binom.sf(binom.isf(wrong, announced, p), announced, p))
    not_met = wrong - float(binom.cdf(binom.ppf(wrong, announced, p) - 1.0, announced, p))
    low = sequence(successes, runs, 1.0 - met).low if met > 0.0 else 0.0
    return Bounds(low, sequence(successes, runs, 1.0 - not_met).high if not_met > 0.0 else 1.0)


def looks(runs: int) -> list[int]:
    """Returns counts of runs, ascending, after which early stopping looks; the last is `runs`.

    Each is a seventh above the last.
    """
    counts, count = [], 30.0
    while count < runs:
        counts.append(round(count))
        count *= 8.0 / 7.0
    return [*counts, runs]


def runs_needed(probability: float, confidence: float, repeated: bool) -> int:
    """Returns the least number of runs that shows a requirement as met, when every one of them meets the bound."""
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
    """Returns a quantile of values (n,), and a lower and an upper bound of it, each for itself at the confidence.

    The bounds are order statistics and hold for whatever distribution (Wilks, Ann. Math. Stat. 12, 1941): the k-th
    value is an upper bound where k successes of n runs would show a probability of `share`. One is infinite where there
    are too few values for it. Values may be infinite, but not nan. Without values all is nan.
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
