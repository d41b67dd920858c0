"""Finds inputs that are read in another frame, which no mapping mends: vectors turned by any angle or turning with the
Earth, and a rate relative to LVLH; or with a bias or a gain of each axis.

Ours that reads its inputs so has to give what theirs gives; unknown angles are fitted by Gauss and Newton.
Longer than 250 lines: which frames there are, their words, and the fit of their unknowns decide on each other.
Tests: tests/orchestration/acceptance/test_frames.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np

from ... import rotation
from ...fmu.model import Floats, Variable
from ...quantities import Unit, suffix
from .bench import Bench, clock
from .causes import GAINS, Cause, along
from .ports import Port
from .wrongs import frames_of

EARTH_RATE = 7.292115e-5
"""rad/s, of the Earth's axes."""
_POLE = np.array([0.0, -0.39778, 0.91748])
"""Of the ecliptic, along the axes of the equator: about it these turn by _PRECESSION, rad a year."""
_PRECESSION = np.radians(50.29 / 3600.0)
_SERVES, _NEAR = 1e-4, 0.05
"""Shares of the outputs' size up to which one explains them, and up to which it is looked at on the whole run."""
_PART = 0.02
"""And a share of the difference as wired, up to which one explains it."""
_NEAR_WITH_CAUSES = 0.2
"""The latter where causes are looked for besides."""
_CLEAR, _EXACT = 3.0, 1e-8
"""Another with as few unknowns serves as well where it leaves at most so many times the least, or so much."""
_EXACT_FIT = 1e-9
"""What a frame leaves where nothing else differs."""
_FAR = 10.0
"""One that leaves so many times the least of some instants is not looked at on the whole run."""
_LOOKED, _AGAIN = 2, 8
"""So many are looked at on the whole run where none is clearly nearer, and so many times their fit goes on there."""
_LEAST = 1e-5
"""rad; a turn by less is none."""
_STEP, _TINY, _MOST = 1e-6, 1e-11, 20
"""rad: of differences, and that ends the fit; and so many times it goes on."""

Inputs = Mapping[str, Floats]
Rest = Callable[[Inputs | None], tuple[tuple[Cause, ...], float]]
"""The causes of what outputs of ours leave, and how much those leave; of None, where ours refuses its inputs, all."""


@dataclass(frozen=True)
class Reading:
    """A reading of inputs: `read` gives those that change, of all inputs (n, elements), times (n,) s and unknowns."""

    where: str
    read: Callable[[Inputs, Floats, Floats], dict[str, Floats]]
    words: Callable[[Floats], str]
    starts: tuple[tuple[float, ...], ...] = ((),)
    """Of the unknowns, rad; one is fitted from the best of them."""
    kind: str = "frame"
    unit: float = float(np.degrees(1.0))
    """In which the size of its cause is told, of one in the unknowns."""
    behind: Reading | None = None
    """Another frame, without unknowns, in which what this one gives is read besides."""

    @property
    def unknown(self) -> bool:
        return self.starts != ((),)

    @property
    def small(self) -> bool:
        """Returns whether it is looked for near none."""
        return self.unknown and not any(self.starts[0]) and len(self.starts) == 1

    def every(self, inputs: Inputs, time: Floats, unknowns: Floats) -> dict[str, Floats]:
        """Returns the inputs that change by this frame and by the one behind it."""
        made = self.read(inputs, time, unknowns)
        return made if self.behind is None else made | self.behind.read({**inputs, **made}, time, unknowns[:0])

    def size(self, unknowns: Floats) -> float:
        return self.unit * float(np.linalg.norm(unknowns))


def other_frame(
    ours: Bench,
    allowed: Iterable[Reading],
    few: tuple[Inputs, Floats, Inputs],
    whole: tuple[Inputs, Floats, Inputs],
    ends: float,
    rest: Rest | None = None,
    after: Rest | None = None,
) -> tuple[tuple[Cause, ...], float] | None:
    """Returns the frame in which inputs are read, and what it leaves of the whole run; None where none explains it.

    `few` and `whole` are inputs (instants, elements), their times (instants,) in s, and the outputs of theirs on them.
    None is begun after `ends`, by `clock`, and then none is named: another could serve as well. With `rest`, which
    explains what a reading leaves of the outputs, its causes follow; with `after` only single precision, which leaves
    so little that it does not keep a frame from being found.
    """
    found: list[tuple[float, Reading, Floats, tuple[Cause, ...]]] = []
    as_wired = float(np.linalg.norm(_left(ours, whole[0], {}, whole[2])))
    few_as_wired = float(np.linalg.norm(_left(ours, few[0], {}, few[2])))
    looked = 0
    near: list[tuple[float, Reading, Floats]] = []
    for reading in allowed:
        if clock() > ends:
            return None
        unknowns, left = _fitted(ours, reading, *few, reading.starts, ("all" if rest is None else "freed", "evenly"))
        if not len(unknowns) or (
            left <= (_NEAR if rest is None else _NEAR_WITH_CAUSES) and np.abs(unknowns).max() >= _LEAST
        ):
            near.append((left, reading, unknowns))
    least = min((left for left, _, u in near if len(u)), default=0.0)
    for left, reading, unknowns in sorted(near, key=lambda one: (len(one[2]) > 0, one[0])):
        if len(unknowns) and any(left < _EXACT and not len(u) for left, _, u, _ in found):
            break  # fewer unknowns are preferred
        if len(unknowns) and left > max(_FAR * least, _SERVES):
            break  # on these instants another is much nearer
        looked += bool(len(unknowns))
        if looked > _LOOKED and left > 0.5 * few_as_wired:
            break  # none of them is much nearer than none
        if clock() > ends:
            return None
        tried = [unknowns]
        if len(unknowns) or rest is None:
            start = (tuple(unknowns.tolist()),)
            again, left = _fitted(ours, reading, *whole, start, most=_AGAIN)
            tried = [again]
            if rest is not None:
                tried += [unknowns, _fitted(ours, reading, *whole, start, ("freed",), _AGAIN)[0]]
        causes: tuple[Cause, ...] = ()
        if rest is not None:
            made = [(*rest(_played(ours, whole[0], reading.every(*whole[:2], u))), u) for u in tried]
            causes, left, unknowns = min(made, key=lambda one: one[1])
        else:
            unknowns = tried[0]
        noisy = len(unknowns) > 1 and any(cause.kind == "noise" for cause in causes)  # it would turn with the noise
        if left < min(_SERVES, _PART * as_wired) and not noisy:
            found.append((left, reading, unknowns, causes))
    if not found:
        return None
    most = max(_CLEAR * min(one[0] for one in found), _EXACT)
    found = sorted((one for one in found if one[0] <= most), key=lambda one: (len(one[2]), one[0]))
    left, reading, unknowns, causes = found[0]
    if after is not None and left > _EXACT_FIT:
        more, least = after(_played(ours, whole[0], reading.every(*whole[:2], unknowns)))
        if more and least < 0.1 * left and all(cause.kind == "single" for cause in more):
            causes, left = (*causes, *more), least
    others = [f"{r.where}: {r.words(u)}" for _, r, u, _ in found[1:] if len(u) == len(unknowns)]
    if reading.kind == "input gain" and np.ptp(unknowns) <= _EXACT:
        factor = 1.0 + float(unknowns[0])  # of a product with another input it could as well be that one's
        scaled = {n: {n: v * factor} for n, v in whole[0].items() if n != reading.where}
        alike = [n for n, v in scaled.items() if float(np.linalg.norm(_left(ours, whole[0], v, whole[2]))) <= most]
        others += [f"{n}: read with gains of {factor:.4g}" for n in alike]
    words = "; or equally well ".join([reading.words(unknowns), *others])
    frames = [Cause(reading.kind, reading.where, reading.size(unknowns), words, left)]
    if (behind := reading.behind) is not None:
        frames.append(Cause("frame", behind.where, 0.0, behind.words(unknowns[:0]), left))
    return (*frames, *causes), left


def readings(
    ports: Mapping[str, Port], variables: Mapping[str, Variable], sizes: Mapping[str, float]
) -> Iterator[Reading]:
    """Returns the readings that the inputs of a block allow, by their frames, their units and the sizes they have."""
    frames = {n: frames_of(variables[n]) for n, p in ports.items() if p.causality == "input"}
    vectors = {n: sides[0] for n, sides in frames.items() if ports[n].kind == "vector" and len(sides) == 1}
    matrices = {n: sides for n, sides in frames.items() if ports[n].kind == "rotation" and len(sides) == 2}
    units = {n: str(ports[n].unit) for n in vectors}
    for name, (outer, inner) in matrices.items():
        positions = [n for n in vectors if units[n] == "m" and vectors[n] == outer]
        speeds = [n for n in vectors if units[n] == "m/s" and vectors[n] == outer]
        rates = [n for n in vectors if units[n] == "rad/s" and vectors[n] == inner]
        for rate, r, v, sign in product(rates, positions, speeds, (1.0, -1.0)):
            yield _relative(rate, name, r, v, sign)
    for frame in dict.fromkeys(vectors.values()):
        names = [n for n in vectors if vectors[n] == frame]
        sides = [n for n, pair in matrices.items() if frame in pair]
        for group in [names, *([n] for n in names if len(names) > 1)]:
            against = sides if group == names else [n for n in names if n not in group]
            if frame == "N":
                yield _of_earth(group, against)
            yield _turned(group, against)
    for name, port in ports.items():
        if port.causality == "input" and port.kind in ("vector", "scalar") and sizes.get(name):
            none = ((0.0,) * len(port.positions),)
            yield _biased(name, none, sizes[name], port.unit)
            yield _scaled(name, none)


def of_two(every: Iterable[Reading]) -> list[Reading]:
    """Returns the readings of two frames: one with unknowns, and a rate behind it that the orbit so read gives."""
    some = list(every)
    rates = [r for r in some if not r.unknown]
    turns = [r for r in some if r.unknown and r.kind == "frame"]
    return [replace(r, behind=rate) for r in turns for rate in rates if rate.where != r.where]


def _relative(rate: str, matrix: str, r: str, v: str, sign: float) -> Reading:
    def read(inputs: Inputs, time: Floats, unknowns: Floats) -> dict[str, Floats]:
        R, position = inputs[matrix].reshape(-1, 3, 3), inputs[r]
        orbital = np.cross(position, inputs[v]) / (position * position).sum(axis=1, keepdims=True)
        return {rate: inputs[rate] + sign * np.einsum("nji,nj->ni", R, orbital)}

    wanted, change = ("relative to LVLH", "added") if sign > 0.0 else ("to which that of LVLH is added", "taken off")
    return Reading(rate, read, lambda unknowns: f"taken as a rate {wanted}: r x v / |r|^2 is {change}")


def _of_earth(names: list[str], against: list[str]) -> Reading:
    def read(inputs: Inputs, time: Floats, unknowns: Floats) -> dict[str, Floats]:
        c, s = np.cos(unknowns[0] + EARTH_RATE * time), np.sin(unknowns[0] + EARTH_RATE * time)
        return {n: np.stack([c * x - s * y, s * x + c * y, z], 1) for n in names for x, y, z in [inputs[n].T]}

    def words(unknowns: Floats) -> str:
        angle = float(np.degrees(unknowns[0])) % 360.0
        return f"taken along axes that turn with the Earth{_beside(against)}, at {angle:.5g} deg at the start"

    starts = tuple((angle,) for angle in np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False).tolist())
    return Reading(_all(names), read, words, starts)


def _turned(names: list[str], against: list[str]) -> Reading:
    def read(inputs: Inputs, time: Floats, unknowns: Floats) -> dict[str, Floats]:
        turn = np.array(rotation.of_three(unknowns.tolist(), "rotation vector")).reshape(3, 3)
        return {n: inputs[n] @ turn.T for n in names}

    def words(unknowns: Floats) -> str:
        angle = float(np.linalg.norm(unknowns))
        axis = unknowns / angle
        text = f"turned by {np.degrees(angle):.4g} deg about {along(axis)}{_beside(against)}"
        if abs(float(axis @ _POLE)) > 0.9995 and angle < 0.02:
            text += f", as the equator turns in {angle / _PRECESSION:.3g} years (J2000 and of date)"
        return text

    return Reading(_all(names), read, words, ((0.0, 0.0, 0.0),))


def _biased(name: str, none: tuple[tuple[float, ...], ...], size: float, unit: Unit) -> Reading:
    def read(inputs: Inputs, time: Floats, unknowns: Floats) -> dict[str, Floats]:
        return {name: inputs[name] + size * unknowns}

    def words(unknowns: Floats) -> str:
        return f"read with a bias of {_numbers(size * unknowns, size)}{suffix(unit)}"

    return Reading(name, read, words, none, "input bias", size)


def _scaled(name: str, none: tuple[tuple[float, ...], ...]) -> Reading:
    def read(inputs: Inputs, time: Floats, unknowns: Floats) -> dict[str, Floats]:
        return {name: inputs[name] * (1.0 + unknowns)}

    return Reading(name, read, lambda u: f"read with gains of {_numbers(1.0 + u, 1.0)}", none, "input gain", 1.0)


def _numbers(values: Floats, size: float) -> str:
    """Returns numbers in words, those that are small against this size as zero."""
    told = [f"{x:.4g}" if abs(x) > 1e-7 * size else "0" for x in values]
    return told[0] if len(told) == 1 else f"({', '.join(told)})"


def _beside(against: list[str]) -> str:
    return f", against {_all(against)}" if against else ""


def _all(names: list[str]) -> str:
    return " and ".join(names)


def _played(ours: Bench, inputs: Inputs, read: Inputs) -> Inputs | None:
    """Returns what ours gives where it reads some inputs otherwise."""
    return ours.play({n: v for n, v in {**inputs, **read}.items() if n in ours.model.variables})


def _left(ours: Bench, inputs: Inputs, read: Inputs, given: Inputs, weigh: str = "all") -> Floats:
    """Returns what differs from theirs, in shares of each output, where ours reads some inputs otherwise.

    `weigh` is "all"; "freed" of a gain and a bias of each element, and of the instants at which theirs is at its
    largest, as where it saturates; or "evenly" where each instant counts as much, since some, as near a singular
    field, differ by far.
    """
    played = _played(ours, inputs, read)
    if played is None:
        return np.full(sum(v.size for v in given.values()), 1.0)
    if weigh == "evenly":
        return np.concatenate([_evened(played[n], v).ravel() for n, v in given.items()])
    if weigh == "freed":
        return np.concatenate([_freed(played[n], v).ravel() for n, v in given.items()]) / len(given) ** 0.5
    parts = [(played[n] - v) / (float(np.linalg.norm(v)) or 1.0) for n, v in given.items()]
    return np.concatenate([part.ravel() for part in parts]) / len(given) ** 0.5


def _evened(ours: Floats, theirs: Floats) -> Floats:
    sizes = np.linalg.norm(ours, axis=1, keepdims=True) + np.linalg.norm(theirs, axis=1, keepdims=True)
    return (ours - theirs) / (sizes + 1e-3 * float(np.linalg.norm(theirs)) / len(theirs) ** 0.5 + 1e-300)


def _freed(ours: Floats, theirs: Floats) -> Floats:
    """Returns what of ours no gain and no bias of an element of theirs gives, as a share of ours."""
    within = np.abs(theirs) < (1.0 - 1e-9) * np.abs(theirs).max(axis=0)
    count = np.maximum(within.sum(axis=0), 1)
    one, other = (np.where(within, x - (x * within).sum(axis=0) / count, 0.0) for x in (ours, theirs))
    square = (other * other).sum(axis=0)
    gain = np.clip((one * other).sum(axis=0) / np.where(square > 0.0, square, 1.0), *GAINS)
    return np.asarray((one - gain * other) / (float(np.linalg.norm(one)) or 1.0))


def _fitted(
    ours: Bench,
    reading: Reading,
    inputs: Inputs,
    time: Floats,
    given: Inputs,
    starts: tuple[tuple[float, ...], ...],
    weigh: tuple[str, ...] = ("all",),
    most: int = _MOST,
) -> tuple[Floats, float]:
    """Returns the unknowns with which ours is nearest to theirs, and what is left, as a share of theirs.

    The fit is made with each of some weights; the first tells which is nearest.
    """

    def left(unknowns: Floats, how: str) -> Floats:
        return _left(ours, inputs, reading.every(inputs, time, unknowns), given, how)

    found: list[tuple[float, Floats]] = []
    for how in weigh:
        best = _nearest(partial(left, how=how), starts, most)
        found.append((float(np.linalg.norm(left(best, weigh[0]))), best))
    least, unknowns = min(found, key=lambda pair: pair[0])
    return unknowns, least


def _nearest(left: Callable[[Floats], Floats], starts: tuple[tuple[float, ...], ...], most: int) -> Floats:
    """Returns the unknowns of which least is left, from the best of some starts."""
    best = min((np.array(start, float) for start in starts), key=lambda start: float(np.linalg.norm(left(start))))
    now = left(best)
    for _ in range(most if len(best) else 0):
        slopes = np.stack([(left(best + step) - now) / _STEP for step in _STEP * np.eye(len(best))], axis=1)
        change = np.linalg.lstsq(slopes, -now, rcond=None)[0]
        change *= min(1.0, 1.0 / max(float(np.linalg.norm(change)), 1e-300))
        while np.linalg.norm(then := left(best + change)) > np.linalg.norm(now) and np.linalg.norm(change) > _TINY:
            change = 0.5 * change
        if np.linalg.norm(then) < np.linalg.norm(now):
            best, now = best + change, then
        if np.linalg.norm(change) <= _TINY:
            break
    return best
