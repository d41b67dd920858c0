"""Finds as which wrong wiring another team's FMU behaves, and what else explains how it differs from ours.

Wirings are searched on some instants (`identify`); what the nearest of them leave of the whole run is explained by
`causes` and `parameters`. A cause is stated only where little is left with it.

Longer than 250 lines: what is found, when it may be stated, and the order of the search decide on each other.
Tests: tests/orchestration/acceptance/test_polarity.py, tests/torture/polarity.py, tests/vendors.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from itertools import combinations, islice, product
from typing import NamedTuple

import numpy as np

from ...fmu.model import Floats, Variable
from ...scenario.source import Source
from .bench import clock
from .causes import Cause, causes_of
from .fly import Loop
from .frames import Reading, of_two, other_frame, readings
from .identify import ALIKE, CHANGE, COARSE, INSTANTS, MINUS, SAME, Changes, Identifier, Score, key_of, minus_of
from .parameters import changed_parameter
from .ports import Port
from .wrongs import Wrong, left_handed

SMALL = 0.01
"""Share of ours by which theirs may still differ for a cause to be named; beyond it, the difference alone is told."""
TOGETHER = 1e-6
"""The same where several things are stated, or a size that was fitted: two of them together come near to much that is
neither. Those that were right left 5e-9 at most (docs/evidence/vendors.md)."""
_MOST_SAID = 3
"""Of more things that are said together some could make up for others."""
PART = 0.02
"""And part of the difference as wired; of a wiring times that difference, since a small one could be anything."""
_LARGE, _MOST_LEFT = 0.3, 0.15
"""A wiring that leaves so much at most of a difference larger than that is flown, and named where all is met."""
_SOME = 12
"""So many of the nearest wirings are tried on theirs."""
_UNEXPLAINED = 1e-4
"""Of a wiring that is named and leaves more, a frame is looked for besides."""
_FINER = 8
"""Of the wirings nearest with an angle of a coarse grid so many are looked at with a finer one."""
_MIRROR = 1.5 * CHANGE
"""What one mirror of several inputs counts as difference, so that a turn with the opposite sign of one port is taken:
where both serve equally, axes that are left-handed are the less likely."""
_STRUCTURAL = ("frame", "parameter", "input bias", "input gain")
"""Kinds of causes beside which no wiring is looked for."""
SECONDS = 20.0
"""The search of wirings ends after so long, and each of two searches of parameters."""


@dataclass(frozen=True)
class Identified:
    """Explanation of how theirs differs from ours."""

    inputs: Changes
    """By input: the wrong wiring that theirs behaves as."""
    outputs: dict[str, Wrong]
    """By output: what brings theirs to ours."""
    before: float
    after: float
    """Difference on the same inputs, as a share of ours: as wired, and with all that is named."""
    ports: dict[str, Port]
    causes: tuple[Cause, ...] = ()
    first: tuple[str, float] | None = None
    """The output that differs first by a hundredth of its largest value, and when, s."""
    equally: tuple[Changes, ...] = ()
    """Other wirings of as few inputs that serve as well."""
    complete: bool = True
    """Whether the search ended before its time was over."""

    @property
    def likely(self) -> bool:
        """Returns whether a wiring takes most of a large difference away, so that a loop may confirm it."""
        wired = bool(self.inputs or self.outputs) and not self.causes
        return wired and self.before > _LARGE and self.after <= min(_MOST_LEFT, 0.1 * self.before)

    @property
    def named(self) -> bool:
        """Returns whether what is left is small enough for the causes to be stated."""
        part = PART * self.before * (min(self.before, 1.0) if self.inputs or self.outputs else 1.0)
        alone = self.said <= 1 and not any(cause.kind in _STRUCTURAL for cause in self.causes)
        little = self.after <= max(min(SMALL if alone else TOGETHER, part), SAME)
        return self.before > SAME and little and self.said <= _MOST_SAID

    @property
    def said(self) -> int:
        """Number of things that are stated, as one those that several ports have in common."""
        turns = {key_of(wrong) for wrong in self.inputs.values()}
        return len(turns) + len(self.outputs) + len({(c.kind, c.where.partition("[")[0]) for c in self.causes})


_Rest = tuple[tuple[Cause, ...], float]


class _Wired(NamedTuple):
    """Theirs on the whole run as wired: its outputs, and `before` and `first` of `Identified`."""

    outputs: dict[str, Floats]
    before: float
    first: tuple[str, float] | None


class _Framed(NamedTuple):
    """A wiring, and frames in which its inputs are read besides."""

    score: Score
    changes: Changes
    frames: list[Reading]


class Search(Identifier):
    """Looks for what explains the difference."""

    def search(self, seconds: float = SECONDS) -> Identified:
        """Looks at wirings: none, one of each input, one turn of all, pairs; then at what they leave.

        The search of wirings ends after `seconds`.
        """
        theirs = self.theirs_on(self.whole)
        if self.given is None or theirs is None:
            return Identified(self.base, {}, np.inf, np.inf, self.ports)
        before, first = self._as_wired(theirs)
        if before <= SAME:
            return Identified({}, {}, before, before, self.ports)
        wired = _Wired(theirs, before, first)
        ends, complete = clock() + seconds, True
        free = [name for name in self.inputs if name not in self.base]
        singles = [{name: w} for name in free for w in (*self.candidates(name), *self._negated_units(name))]
        tried = self._ranked([{}, *singles, *self.common], INSTANTS)
        if _is_silent(theirs) and (woken := self._woken([pair for pair in tried if pair[1]], wired)) is not None:
            return woken
        best = self._explained(tried, wired)
        if best.named and best.after <= ALIKE:
            return best
        if not best.named:
            best = min(best, self._turned(wired), key=_worth)
        if not best.named:
            best = self._with_frame(best, wired, clock() + seconds)
        if not best.named:
            best = self._with_parameter(best, [], wired, clock() + seconds)
        if best.named and best.causes and best.causes[0].kind in _STRUCTURAL:
            return best
        starts = [self._descend(changes, ends) for _, changes in tried[:4]]
        found = self._explained(sorted(starts, key=lambda pair: pair[0].cost), wired)
        best = min(best, found, key=_worth)
        if not best.named or best.said > 2:
            pairs, complete = self._pairs(ends)
            starts = [self._descend(changes, ends) for _, changes in pairs[:6]]
            found = self._explained(sorted(starts, key=lambda pair: pair[0].cost), wired)
            best = min(best, found, key=_worth)
        if not best.named:
            until = clock() + seconds
            best = self._with_parameter(best, tried[:3], wired, until)
            complete = complete and clock() <= until
        if not best.named or best.after > _UNEXPLAINED:
            framed = self._framed(tried, clock() + seconds / 2)
            best = self._with_frame(best, wired, clock() + seconds / 2, framed)
        return replace(best, complete=complete)

    def _negated_units(self, name: str) -> list[Wrong]:
        """Returns what reads an input in another unit and with the opposite sign."""
        units = [w for w in self.candidates(name) if w.kind == "unit"]
        return [Wrong(f"opposite sign, {w.name}", "axes", -w.matrix) for w in units if w.matrix is not None]

    def _woken(self, tried: Sequence[tuple[Score, Changes]], wired: _Wired) -> Identified | None:
        """Returns what a wiring explains with which something comes out, where nothing does as wired: one change of
        one input, or else nothing is named, since a second one could make up for a first that is wrong. None where no
        wiring brings anything to life."""
        best = self._explained(tried, wired)
        if best.after == np.inf or not best.inputs:
            return None
        alone = len(best.inputs) == 1 and not best.outputs
        return best if best.named and alone else self._found({}, wired, wired.before)

    def _turned(self, wired: _Wired) -> Identified:
        """Looks at one turn of all vectors of a frame on theirs, whose inputs are handed over so that it reads those of
        ours: ours that misreads its inputs may meet limits or a hold that theirs has not."""
        scored = sorted(((self.corrected(c), c) for c in self.common), key=lambda pair: pair[0].cost)
        near = [pair for pair in scored[:4] if pair[0].error < _LARGE]
        return self._explained(near, wired) if near else self._found({}, wired, wired.before)

    def _as_wired(self, theirs: dict[str, Floats]) -> tuple[float, tuple[str, float] | None]:
        """Returns how far theirs is from ours with nothing changed, and which output differs first."""
        ours = self.ours_on(self.whole)
        assert ours is not None
        errors, firsts = {}, []
        for name in self.reference:
            size, largest = float(np.linalg.norm(ours[name])) or 1.0, float(np.abs(ours[name]).max())
            apart = theirs[name] - ours[name]
            errors[name] = float(np.linalg.norm(apart)) / size
            beyond = np.flatnonzero(np.abs(apart).max(axis=1) > SMALL * largest)
            firsts += [(float(beyond[0]) * self._ours.step, name)] if len(beyond) else []
        before = sum(self._weights[n] * min(x, 2.0) for n, x in errors.items()) / sum(self._weights.values())
        if self.base:
            before = max(before, 1.0)
        return before, (min(firsts)[1], min(firsts)[0]) if firsts else None

    def _explained(
        self,
        tried: Sequence[tuple[Score, Changes]],
        wired: _Wired,
        most: int = 4,
    ) -> Identified:
        """Returns the wiring among the nearest that, with causes, leaves least of the whole run."""
        ours = self.ours_on(self.whole)
        plain = [changes for _, changes in tried if not changes][:1]
        chosen = [self.corrected(changes) for _, changes in tried[:_SOME]]
        again = sorted(zip(chosen, (changes for _, changes in tried), strict=False), key=lambda pair: pair[0].cost)
        found: list[Identified] = []
        for score, changes in [*((self.corrected(c), c) for c in plain), *again[:most]]:
            every = {**self.base, **changes}
            read = wired.outputs if not changes else self.theirs_on(self.whole, changes)
            if ours is None or read is None or not np.isfinite(score.error) or (changes and _is_silent(read)):
                continue
            for outputs in ({}, score.outputs) if score.outputs else ({},):
                causes, after = self.explain(ours, read, outputs)
                one = self._found(every, wired, after, causes, outputs)
                if one.named and any(w.kind == "unit" for w in every.values()):
                    one = replace(one, after=max(after, self._forward(every, outputs, wired)))
                found.append(one)
        if not found:
            return self._found({}, wired, wired.before)
        best = min(found, key=_worth)
        alike = [
            one.inputs
            for one in found
            if one.after <= max(ALIKE, 1.05 * best.after)
            and one.said == best.said
            and (not one.outputs or _names(one.outputs) == _names(best.outputs))
            and _names(one.inputs) != _names(best.inputs)
        ]
        known = (best.inputs, *alike) if best.named else ()
        countered = [other for inputs in known for other in self._countered(inputs)]
        return replace(best, equally=(*alike, *countered))

    def _countered(self, inputs: Changes) -> Iterator[Changes]:
        """Yields wirings of one more input that ours cannot tell from this one: two have the opposite sign, where ours
        takes in their product alone."""
        alike = self.ours_on(self.misread(self.whole, {**self.base, **inputs}))
        for name, other in product(inputs, self.inputs):
            matrix = inputs[name].matrix
            if other in inputs or matrix is None or alike is None:
                continue
            negated = self._with(name, -matrix)
            counter = self._with(other, -np.eye(len(self.ports[other].positions)))
            if negated is None or counter is None:
                continue
            changes = {**inputs, name: negated, other: counter}
            ours = self.ours_on(self.misread(self.whole, {**self.base, **changes}))
            if ours is not None and all(np.array_equal(ours[n], alike[n]) for n in self.reference):
                yield changes

    def _with(self, name: str, matrix: Floats) -> Wrong | None:
        """Returns the wrong wiring of an input that multiplies it so; None where it is none of the candidates."""
        for wrong in self.candidates(name):
            if wrong.matrix is not None and wrong.matrix.shape == matrix.shape and np.allclose(wrong.matrix, matrix):
                return wrong
        return None

    def _forward(self, inputs: Changes, outputs: dict[str, Wrong], wired: _Wired) -> float:
        """Returns what is left where ours misreads its inputs so and theirs is handed what it is handed as wired.

        A factor alone could hide what theirs adds to an input: with a thousandth of the field no bias of it shows.
        """
        ours = self.ours_on(self.misread(self.whole, inputs))
        return np.inf if ours is None else self.explain(ours, wired.outputs, outputs)[1]

    def explain(
        self, ours: dict[str, Floats], theirs: dict[str, Floats], outputs: dict[str, Wrong]
    ) -> tuple[tuple[Cause, ...], float]:
        """Returns the causes of what is left of the whole run, and how much they leave."""
        causes: list[Cause] = []
        total = 0.0
        for name in self.reference:
            mended = outputs[name].apply(theirs[name]) if name in outputs else theirs[name]
            time = np.arange(0.0, len(mended)) * self._ours.step
            variable: Variable = self._ours.model.variables[name]
            some, left = causes_of(name, ours[name], mended, time, variable.unit)
            causes += some
            size = min(float(np.linalg.norm(x)) for x in (ours[name], mended)) or 1.0
            total += self._weights[name] * min(float(np.linalg.norm(left)) / size, 2.0)
        return tuple(causes), total / sum(self._weights.values())

    def _found(
        self,
        inputs: Changes,
        wired: _Wired,
        after: float,
        causes: tuple[Cause, ...] = (),
        outputs: dict[str, Wrong] | None = None,
    ) -> Identified:
        return Identified(inputs, outputs or {}, wired.before, after, self.ports, causes, wired.first)

    def _with_parameter(
        self,
        best: Identified,
        tried: Sequence[tuple[Score, Changes]],
        wired: _Wired,
        ends: float,
    ) -> Identified:
        """Looks for a parameter of another value, with no wiring or with one of the nearest, until the time ends."""
        assert self.given is not None
        wirings = [changes for _, changes in tried if changes] or [{}]
        for changes in wirings:
            read = self.misread(self.few, {**self.base, **changes})
            nearest = {n: self.given[n] for n in self.reference}
            made = changed_parameter(self._ours, read, self.misread(self.whole, changes), nearest, wired.outputs, ends)
            if made is not None:
                cause, after = made
                found = self._found({**self.base, **changes}, wired, after, (cause,))
                if found.named:
                    return min(best, found, key=_worth)
        return best

    def _with_frame(
        self, best: Identified, wired: _Wired, ends: float, tried: Sequence[_Framed] | None = None
    ) -> Identified:
        """Looks for a frame in which inputs are read, until the time ends: alone, or with these wirings and causes."""
        assert self.given is not None
        on_few, on_all = self._times()
        for score, changes, allowed in tried or [_Framed(Score(0.0, 0.0), {}, self._readings())]:
            every, outputs = {**self.base, **changes}, score.outputs
            given = [{n: _mended(outputs, n, v[n]) for n in self.reference} for v in (self.given, wired.outputs)]
            few = self.misread(self.few, every), on_few, given[0]
            whole = self.misread(self.whole, every), on_all, given[1]

            def rest(ours: Mapping[str, Floats] | None, theirs: dict[str, Floats] = given[1]) -> _Rest:
                return ((), np.inf) if ours is None else self.explain(dict(ours), theirs, {})

            made = other_frame(self._ours, allowed, few, whole, ends, None if tried is None else rest, rest)
            if made is not None:
                found = self._found(every, wired, made[1], made[0], outputs)
                best = min(best, found, key=_worth) if found.named else best
            if (best.named and best.after <= ALIKE) or clock() > ends:
                break
        return best

    def _times(self) -> tuple[Floats, Floats]:
        """Returns when the instants and the samples of the whole run are, s."""
        samples = len(next(iter(self.whole.values())))
        return np.asarray(self._kept * self._ours.step, np.float64), np.arange(0.0, samples) * self._ours.step

    def _readings(self) -> list[Reading]:
        sizes = {n: float(np.sqrt((self.whole[n] ** 2).mean())) for n in self.inputs}
        return list(readings(self.ports, self._theirs.model.variables, sizes))

    def _framed(self, tried: Sequence[tuple[Score, Changes]], ends: float) -> list[_Framed]:
        """Returns frames, each with the wirings with which it is nearest on some instants, the nearest first.

        A frame from which theirs is turned by little leaves the order of the wirings as it is.
        """
        every = self._readings()
        wirings = [changes for score, changes in tried if np.isfinite(score.cost)]
        made: dict[tuple[str, ...], _Framed] = {}
        for reading in [*every, *of_two(every)]:
            some = [{}] if reading.behind is not None else wirings[:_SOME] if reading.small else wirings
            some = [changes for changes in some if not _of_the_angle(reading, changes)]
            coarse: list[tuple[Score, Changes, tuple[float, ...]]] = []
            for changes in some:
                scores = [(self._read_so(reading, changes, start), start) for start in reading.starts[::2]]
                score, start = min(scores, key=lambda pair: pair[0].cost)
                coarse.append((score, changes, start))
                if clock() > ends:
                    break
            coarse.sort(key=lambda one: one[0].cost)
            chosen = [*coarse[:_FINER], *(one for one in coarse[_FINER:] if not one[1])]
            near = [(self._finer(reading, *one), one[1]) for one in chosen]
            near.sort(key=lambda pair: pair[0].cost)
            for score, changes in [*near[:3], *(pair for pair in near[3:] if not pair[1])]:
                for one in {bool(score.outputs): score, False: Score(score.error, score.cost)}.values():
                    key = *(f"{n}: {w.name}" for n, w in changes.items()), *(w.name for w in one.outputs.values())
                    known = made.get(key, _Framed(one, changes, []))
                    least = min(one, known.score, key=lambda score: score.cost)
                    made[key] = _Framed(least, changes, [*known.frames, reading])
        return sorted(made.values(), key=lambda one: one.score.cost)

    def _finer(self, reading: Reading, score: Score, changes: Changes, start: tuple[float, ...]) -> Score:
        """Returns the score at an angle near one of a coarse grid, where the reading has one angle on a circle."""
        if len(reading.starts) < 2 or len(start) != 1:
            return score
        angle = start[0]
        for step in np.radians((12.0, 6.0, 3.0, 1.5, 0.75, 0.4)):
            tried = [(self._read_so(reading, changes, (a,)), a) for a in (angle - step, angle + step)]
            score, angle = min([(score, angle), *tried], key=lambda pair: pair[0].cost)
        return score

    def _read_so(self, reading: Reading, changes: Changes, unknowns: tuple[float, ...]) -> Score:
        """Returns how far theirs is from ours that reads its inputs in another frame and with a wiring."""
        assert self.given is not None
        read = self.misread(self.few, {**self.base, **changes})
        read |= reading.every(read, self._times()[0], np.array(unknowns, float))
        played = self.ours_on(read)
        return Score(np.inf, np.inf) if played is None else self.scored(played, self.given, changes)

    def _pairs(self, ends: float) -> tuple[list[tuple[Score, Changes]], bool]:
        """Looks at axes and signs of two inputs, those of the fewest first, until a pair explains all."""
        free = [n for n in self.inputs if self.ports[n].kind in ("scalar", "vector", "rotation") and n not in self.base]
        axes = {n: [w for w in self.candidates(n) if w.kind != "unit"] for n in free}
        two = sorted(combinations(free, 2), key=lambda pair: len(axes[pair[0]]) * len(axes[pair[1]]))
        pairs = ({a: one, b: other} for a, b in two for one in axes[a] for other in axes[b])
        found: list[tuple[Score, Changes]] = []
        while part := list(islice(pairs, 200)):
            found = sorted([*found, *self._ranked(part, COARSE)], key=lambda pair: pair[0].cost)[:8]
            if found[0][0].error < ALIKE:
                break
            if clock() > ends:
                return found, False
        return found, True

    def _ranked(self, tried: Sequence[Changes], count: int) -> list[tuple[Score, Changes]]:
        scored = [(self.error(changes, count), changes) for changes in tried]
        return sorted(scored, key=lambda pair: pair[0].cost)

    def _descend(self, changes: Changes, ends: float) -> tuple[Score, Changes]:
        """Takes the best change of one input after the other, as long as the cost gets smaller."""
        score = self.error(changes)
        for _ in range(3):
            before = score.cost
            for name in self.inputs:
                if name in self.base or clock() > ends:
                    continue
                now = changes.get(name)
                others = {n: w for n, w in changes.items() if n != name}
                tried = [others] if now is not None else []
                if score.error > ALIKE:  # else what is changed can only get less
                    tried += [{**others, name: w} for w in self._near(name, now)]
                if not tried:
                    continue
                reached, candidate = self._ranked(tried, INSTANTS)[0]
                if reached.cost < score.cost:
                    score, changes = reached, candidate
            if score.cost >= before:
                break
        return score, changes

    def _near(self, name: str, now: Wrong | None) -> list[Wrong]:
        """Returns every change of an input, and those made of the present one and another."""
        every = self.candidates(name)
        if now is None or now.matrix is None:
            return every
        more = [w for w in every if w.matrix is not None and (w.kind == "unit") != (now.kind == "unit")]
        return every + [
            Wrong(f"{now.name}, {w.name}", "axes", now.matrix @ w.matrix) for w in more if w.matrix is not None
        ]


def _of_the_angle(reading: Reading, changes: Changes) -> bool:
    """Returns whether a wiring turns an input about the Earth's axis, as the angle of the reading does."""
    read = [changes[n].matrix for n in reading.where.split(" and ") if n in changes and len(reading.starts) > 1]
    turns = [M for M in read if M is not None and M.shape == (3, 3) and np.linalg.det(M) > 0.0]
    return any(np.allclose(M[2], (0.0, 0.0, 1.0)) for M in turns)


def _names(changes: Changes) -> dict[str, str]:
    return {name: wrong.name for name, wrong in changes.items()}


def _is_silent(outputs: Mapping[str, Floats]) -> bool:
    """Returns whether nothing ever comes out: any wrong wiring that leads there would explain it."""
    return not any(values.any() for values in outputs.values())


def _mended(outputs: Mapping[str, Wrong], name: str, values: Floats) -> Floats:
    return outputs[name].apply(values) if name in outputs else values


def _worth(found: Identified) -> tuple[bool, float]:
    """Returns what of several explanations is best: whether it may be stated, what is left, and how much is said."""
    left = max(found.after, SAME)
    hands = sum(left_handed(w) for w in found.inputs.values())
    mirror = _MIRROR if hands > 1 else 0.0
    worth = left + CHANGE * found.said + 1e-4 * hands + mirror + MINUS * sum(map(minus_of, found.inputs.values()))
    return not found.named, worth


def open_search(ours: Source, theirs: Source, block: str, stack: ExitStack) -> Search:
    """Opens both for a bench in this process."""
    return Search(Loop(ours), Loop(theirs), block, stack)


def identify(ours: Source, theirs: Source, block: str, seconds: float = SECONDS) -> Identified:
    """Returns what explains how the block of the second scenario differs from ours. Raises InputError."""
    with ExitStack() as stack:
        return open_search(ours, theirs, block, stack).search(seconds)
