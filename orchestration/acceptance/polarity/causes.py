"""Finds what else than a wiring makes an output differ: late, held, stuck, limited, filtered, noisy, coarse or scaled.

Each hypothesis is fitted to one element of an output and leaves a residual. It is named where that is small against the
difference, and small against what every other leaves; else nothing is named.

Longer than 250 lines: one hypothesis after the other, each of some lines, which share their words and thresholds.
Tests: tests/orchestration/acceptance/test_causes.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...fmu.model import Floats
from ...quantities import Unit, with_unit

EXACT = 1e-9
"""A share of an output's size up to which two are the same."""
SHARE = 0.02
"""What a cause may leave of the difference."""
CLEAR = 3.0
"""So many times more has to be left by the next best hypothesis, unless the best leaves nothing."""
LATEST = 40
"""Samples by which an output is looked for."""
_SINGLE = 1e-5
_SPREAD = {"noise": 0.2, "dead": 0.2}
"""By how much estimates of one size differ from element to element, where that is more than 0.02."""
GAINS = 0.1, 10.0
"""Beyond them, and below zero, a factor is a wrong unit or sign: a wiring."""
_NOISE_SHARE, _CORRELATION = 1.0, 4.0
"""Noise is at most this share of the signal; correlations stay within so many times those of white noise."""


@dataclass(frozen=True)
class Cause:
    """Explanation of the difference of an output, or of all outputs."""

    kind: str
    where: str
    """An output of ours, one of its elements, an input, or a parameter."""
    size: float
    """Samples, seconds, a factor, or a value in our unit."""
    text: str
    left: float
    """What differs with it, as a share of the output's size."""
    equally: tuple[tuple[str, float], ...] = ()
    """Other parameters with their factors, or other kinds with their sizes, that explain it as well."""

    def __str__(self) -> str:
        return f"{self.where}: {self.text}"


class _Found(NamedTuple):
    """Explanation of an element's difference, and what is left of it (n,)."""

    kind: str
    size: float
    text: str
    rest: Floats
    equally: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class Series:
    """One element of an output: ours and theirs at the same instants."""

    ours: Floats
    theirs: Floats
    time: Floats
    unit: Unit | None

    @property
    def step(self) -> float:
        return float(self.time[1] - self.time[0]) if len(self.time) > 1 else 0.0


def causes_of(name: str, ours: Floats, theirs: Floats, time: Floats, unit: Unit | None) -> tuple[list[Cause], Floats]:
    """Returns the causes of an output's difference, (n, elements) both, and what they leave (n, elements).

    An element whose difference none explains keeps it.
    """
    left = theirs - ours
    size = float(np.sqrt((ours * ours).mean(axis=0).max())) or 1.0
    if (turned := _turned(name, ours, theirs, size)) is not None:
        return turned
    found: dict[int, list[_Found]] = {}
    for i in range(ours.shape[1]):
        if np.abs(left[:, i]).max() > EXACT * size:
            found[i] = _explained(Series(ours[:, i], theirs[:, i], time, unit), size)
            if found[i]:
                left[:, i] = found[i][-1][3]
    every = [one for some in found.values() for one in some]
    made = [(i, _as_others(one, every)) for i, some in found.items() for one in some]
    causes: list[Cause] = []
    for i, (kind, value, text, rest, equally) in made:
        share = float(np.sqrt((rest * rest).mean())) / size
        alike = [one for one in causes if _is_same(one, kind, value) and not _apart(one, text)]
        if alike and kind not in ("gain", "bias"):
            causes[causes.index(alike[0])] = replace(alike[0], where=name, left=max(share, alike[0].left))
        else:
            where = f"{name}[{i + 1}]" if ours.shape[1] > 1 else name
            causes.append(Cause(kind, where, value, text, share, equally))
    return causes, left


def _is_same(one: Cause | _Found, kind: str, size: float) -> bool:
    """Returns whether a cause is of this kind, and of this size as near as it is known from another element."""
    return one.kind == kind and bool(np.isclose(one.size, size, rtol=_SPREAD.get(kind, 0.02)))


def _apart(cause: Cause, text: str) -> bool:
    """Returns whether elements stick at values of their own, which are told one by one."""
    return cause.kind == "stuck" and cause.text != text


def _as_others(one: _Found, every: Sequence[_Found]) -> _Found:
    """Returns a cause of an element as that which another element has, where this serves equally well."""
    for kind, size in one.equally:
        for other in every:
            if _is_same(other, kind, size) and not other.equally:
                return other._replace(rest=one.rest)
    return one


def _explained(s: Series, size: float) -> list[_Found]:
    """Returns what explains an element's difference; two where it has a gain and a bias; none where nothing does."""
    difference = s.theirs - s.ours
    before = min(float(np.sqrt((x * x).mean())) for x in (difference, s.theirs))  # of what is tiny all is left
    if _is_single(s, size):
        return [_Found("single", 0.0, "in single precision", np.zeros(len(s.ours)))]
    tried: list[tuple[float, list[_Found]]] = []
    for hypothesis in HYPOTHESES:
        for found in hypothesis(s):
            tried.append((float(np.sqrt((found[-1][3] ** 2).mean())), found))
    tried.sort(key=lambda pair: (max(pair[0], EXACT * size), len(pair[1])))
    if tried and tried[0][0] <= SHARE * before:
        best = tried[0][0]
        plain = [pair for pair in tried if pair[0] <= 1.1 * best + EXACT * size]
        tried.insert(0, min(plain, key=lambda pair: len(pair[1])))
        kind = tried[0][1][0][0]
        rivals = [left for left, found in tried[1:] if found[0][0] != kind and len(found) <= len(tried[0][1])]
        if best <= EXACT * size:
            others = [found[0] for left, found in tried[1:] if left <= EXACT * size and len(found) == 1]
            return _with_others(tried[0][1], [one for one in others if one.kind != kind])
        if not rivals or rivals[0] >= CLEAR * best:
            return tried[0][1]
        return []
    return _noise(s)


def _with_others(found: list[_Found], others: Sequence[_Found]) -> list[_Found]:
    """Returns one cause with others that explain all as exactly; two together as they are."""
    if len(found) != 1 or not others:
        return found
    words = "; or equally well ".join([found[0].text, *(one.text for one in others)])
    return [found[0]._replace(text=words, equally=tuple((one.kind, one.size) for one in others))]


def _late(s: Series) -> Iterator[list[_Found]]:
    """By k samples and a part of one, between which the output is a straight line."""
    best: tuple[float, float, Floats] | None = None
    for k in range(min(LATEST, len(s.ours) // 4)):
        a, b = _shifted(s.ours, k), _shifted(s.ours, k + 1)
        change = b - a
        square = float(change @ change)
        part = float(np.clip(change @ (s.theirs - a) / square, 0.0, 1.0)) if square else 0.0
        left = s.theirs - a - part * change
        sum_ = float(left @ left)
        if best is None or sum_ < best[0]:
            best = sum_, k + part, left
    if best is not None and best[1] > 1e-3:
        samples = best[1]
        words = f"{samples:.3g} sample{'s' if samples > 1 else ''} ({samples * s.step:.3g} s) late"
        yield [_Found("delay", samples, words, best[2])]


def _held(s: Series) -> Iterator[list[_Found]]:
    """Taken anew at each k-th sample only."""
    changes = np.flatnonzero(np.diff(s.theirs) != 0.0) + 1
    if len(changes) < 3:
        return
    k = int(np.gcd.reduce(changes))
    if k > 1:
        held = s.ours[np.arange(len(s.ours)) // k * k]
        yield [_Found("hold", float(k), f"taken anew each {k} samples ({k * s.step:.3g} s) only", s.theirs - held)]


def _stuck(s: Series) -> Iterator[list[_Found]]:
    """Constant from an instant on, to the end; from the start at zero or at our first value only, since one at its
    limit does not move either."""
    moving = np.flatnonzero(s.theirs != s.theirs[-1])
    first = int(moving[-1]) + 1 if len(moving) else 0
    limited = not first and s.theirs[-1] != 0.0 and abs(s.theirs[-1] - s.ours[0]) > EXACT * float(np.abs(s.ours).max())
    if len(s.theirs) - first < 10 or np.ptp(s.ours[first:]) == 0.0 or limited:
        return
    stuck = s.ours.copy()
    stuck[first:] = s.theirs[-1]
    at = float(s.time[first])
    yield [
        _Found("stuck", at, f"stuck at {with_unit(float(s.theirs[-1]), _name(s))} from {at:.5g} s", s.theirs - stuck)
    ]


def _limited(s: Series) -> Iterator[list[_Found]]:
    """Saturated at less than ours."""
    limit = float(np.abs(s.theirs).max())
    at = np.count_nonzero(np.abs(s.theirs) >= limit * (1.0 - 1e-9))
    if at >= 3 and 0.0 < limit < 0.999 * float(np.abs(s.ours).max()):
        left = s.theirs - np.clip(s.ours, -limit, limit)
        yield [_Found("limit", limit, f"saturated at {with_unit(limit, _name(s))}", left)]


def _lagging(s: Series) -> Iterator[list[_Found]]:
    """Behind a filter of first order: y += a (ours - y)."""
    change, drive = np.diff(s.theirs), s.ours[1:] - s.theirs[:-1]
    square = float(drive @ drive)
    a = float(change @ drive) / square if square else 0.0
    if 1e-4 < a < 0.999:
        filtered = s.ours.copy()  # the whole course: one step ahead of a slow signal anything would serve
        filtered[0] = s.theirs[0]
        for i in range(1, len(filtered)):
            filtered[i] = filtered[i - 1] + a * (s.ours[i] - filtered[i - 1])
        constant = -s.step / np.log(1.0 - a)
        words = f"behind a filter with a time constant of {constant:.3g} s"
        yield [_Found("lag", constant, words, s.theirs - filtered)]


def _dead(s: Series) -> Iterator[list[_Found]]:
    """Zero where ours is small; beyond that ours, or ours less the zone."""
    zero = s.theirs == 0.0
    if not 3 <= np.count_nonzero(zero) < len(zero) or not (s.ours[zero] != 0.0).any():
        return
    zone = float(np.abs(s.ours[zero]).max())
    outside = np.abs(s.ours[~zero])
    edge = 0.5 * (zone + float(outside.min())) if len(outside) and float(outside.min()) > zone else zone
    for words, left in (
        ("", s.theirs - np.where(np.abs(s.ours) <= zone, 0.0, s.ours)),
        (", less it beyond", s.theirs - np.sign(s.ours) * np.maximum(np.abs(s.ours) - zone, 0.0)),
    ):
        yield [_Found("dead", edge, f"zero below {with_unit(float(f'{edge:.3g}'), _name(s))}{words}", left)]


def _coarse(s: Series) -> Iterator[list[_Found]]:
    """In steps of one size."""
    levels = np.unique(s.theirs)
    gaps = np.diff(levels)
    gaps = gaps[gaps > 1e-6 * max(float(np.abs(levels).max()), 1e-300)] if len(levels) > 1 else gaps
    if not len(gaps) or len(levels) > 0.9 * len(s.theirs):
        return
    step = float(gaps.min())
    counts = np.round(s.theirs / step)
    if np.abs(s.theirs - step * counts).max() > 1e-6 * step * max(float(np.abs(counts).max()), 1.0):
        return
    left = s.theirs - s.ours
    if np.abs(left).max() <= 1.001 * step:  # rounded, or cut off
        exact = s.theirs - step * np.round(s.ours / step)
        cut = s.theirs - step * np.trunc(s.ours / step)
        rest = min((exact, cut), key=lambda x: float(x @ x))
        yield [_Found("quantum", step, f"in steps of {with_unit(float(f'{step:.4g}'), _name(s))}", rest)]


def _scaled(s: Series) -> Iterator[list[_Found]]:
    """With a gain, a bias, or both."""
    n, z, y = len(s.ours), s.ours, s.theirs
    offset = float((y - z).mean())
    square = float(z @ z)
    if square:
        gain = float(z @ y) / square
    if square and GAINS[0] < gain < GAINS[1]:
        yield [_Found("gain", gain, f"times {gain:.5g}", y - gain * z)]
    yield [_Found("bias", offset, f"plus {with_unit(float(f'{offset:.5g}'), _name(s))}", y - z - offset)]
    spread = float(((z - z.mean()) ** 2).sum())
    if n > 3 and spread > 0.0:
        gain = float((z - z.mean()) @ (y - y.mean())) / spread
        if not GAINS[0] < gain < GAINS[1]:
            return
        offset = float(y.mean() - gain * z.mean())
        rest = y - gain * z - offset
        plus = f"plus {with_unit(float(f'{offset:.5g}'), _name(s))}"
        yield [_Found("gain", gain, f"times {gain:.5g}", rest), _Found("bias", offset, plus, rest)]


HYPOTHESES: tuple[Callable[[Series], Iterator[list[_Found]]], ...] = (
    _late,
    _held,
    _stuck,
    _limited,
    _lagging,
    _dead,
    _coarse,
    _scaled,
)


def _noise(s: Series) -> list[_Found]:
    """White noise: of mean zero, like neither itself a sample before nor the signal or its rate."""
    e, n = s.theirs - s.ours, len(s.ours)
    sigma = float(e.std())
    bound = _CORRELATION / np.sqrt(n)
    spread = float(s.ours.std())
    if n < 200 or sigma == 0.0 or sigma > _NOISE_SHARE * spread or abs(float(e.mean())) > bound * sigma:
        return []
    centred = (e - e.mean()) / sigma
    lags = [float(centred[k:] @ centred[:-k]) / n for k in (1, 2, 3, 7)]
    others = [s.ours - s.ours.mean(), np.gradient(s.ours), np.abs(s.ours) - np.abs(s.ours).mean()]
    alike = [float(centred @ x) / n / (float(x.std()) or 1.0) for x in others]
    halves = float(e[: n // 2].std()) / (float(e[n // 2 :].std()) or 1e-300)
    if max(map(abs, lags + alike)) > bound or not 0.8 < halves < 1.25 or np.count_nonzero(e == 0.0) > 0.1 * n:
        return []
    return [
        _Found("noise", sigma, f"with white noise of {with_unit(float(f'{sigma:.3g}'), _name(s))} rms", np.zeros(n))
    ]


def _is_single(s: Series, size: float) -> bool:
    """Returns whether theirs holds numbers of single precision only, and is ours to what computing in it leaves."""
    difference = np.abs(s.theirs - s.ours)
    near = bool((difference <= _SINGLE * size).all())
    return near and bool((s.theirs.astype(np.float32).astype(float) == s.theirs).all()) and bool(difference.any())


def _turned(name: str, ours: Floats, theirs: Floats, size: float) -> tuple[list[Cause], Floats] | None:
    """Returns the axes of theirs as turned by a small angle; None where they are not."""
    if ours.shape[1] != 3 or np.linalg.matrix_rank(ours, tol=1e-6 * size * np.sqrt(len(ours))) < 3:
        return None
    M = np.linalg.lstsq(ours, theirs, rcond=None)[0].T
    left = theirs - ours @ M.T
    orthonormal = np.abs(M @ M.T - np.eye(3)).max() < 1e-6 and np.linalg.det(M) > 0.0
    wiring = np.abs(M - np.round(M)).max() < 1e-6  # none, or other axes and signs
    if not orthonormal or np.abs(left).max() > 1e-6 * size or wiring:
        return None
    axis = np.array([M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1]])
    angle = float(np.degrees(np.arctan2(np.linalg.norm(axis), np.trace(M) - 1.0)))
    axis = axis / (float(np.linalg.norm(axis)) or 1.0)
    words = f"turned by {angle:.4g} deg about {along(axis)}"
    return [Cause("turned", name, angle, words, float(np.sqrt((left * left).mean())) / size)], left


def along(axis: Floats) -> str:
    """Returns a unit vector in words."""
    return f"({', '.join(f'{x + 0.0:g}' for x in np.round(axis, 3))})"


def _shifted(values: Floats, k: int) -> Floats:
    return values if k == 0 else np.concatenate([np.full(k, values[0]), values[:-k]])


def _name(s: Series) -> str:
    return str(s.unit) if s.unit is not None and s.unit.name not in ("", "1") else ""
