"""A sensor by itself: whether it repeats what it has measured, and whether what it measures agrees with the filter.

docs/how/health.md derives each limit. Tests: tests/estimator/test_health.py.

Requirement: ES-4.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .so3 import Array, norm

RATE, FIELD, ORBIT, ATTITUDE, SUN = SENSORS = range(5)
"""As the inputs count them, and the output `health`."""
NONE, GOOD, FROZEN, INCONSISTENT, JUMPED = range(5)
"""The values of the output `health`."""
FEW, REPEATS = 3.0, 20.0
"""Measurements that repeat the last one: that cast a doubt, and that are a failure for each that did so before in
turn."""
AVERAGED = 60.0
"""s over which innovations are averaged."""
LIMIT = 5.0
"""Of an innovation over its deviation, in the average."""
WRONG, RIGHT = 1.5, 0.75
"""Length of the average from which on a sensor is wrong, and below which it is right again."""
CALM = 1500.0
"""s for which a sensor that was wrong has to be right: a quarter of an orbit."""
JUMP, USUAL, JUST = 8.0, 10.0, 30.0
"""Of the root mean square of what is usual, from which on a change is a jump; s over which that is averaged; s from a
jump until the sensor is found to be frozen."""


@dataclass(frozen=True)
class Watch:
    """State of a sensor's watch."""

    last: Array
    """Of its measurement (3,)."""
    run: Array
    """Measurements in turn that repeat an element (3,)."""
    longest: Array
    """The most of them that ended by themselves (3,)."""
    changes: float
    """Measurements that did not, up to REPEATS."""
    seen: bool
    frozen: bool
    suspect: bool
    mean: Array
    """Of its innovations over their deviations (3,)."""
    calm: float
    """s for which that has been small."""
    since: float
    """s from its last measurement."""
    usual: float
    """Mean square of its changes that are not expected."""
    jump: Array
    """The last one that was far beyond (3,)."""
    jumped: float
    """s since."""

    @property
    def trusted(self) -> bool:
        """Returns whether it is to be used."""
        return not (self.frozen or self.suspect)

    @property
    def repeats(self) -> bool:
        """Returns whether it repeats itself, but not yet for long: what it says is not weighed meanwhile."""
        return self.changes == REPEATS and bool((self.run >= FEW).any())

    @property
    def health(self) -> int:
        """One of NONE, GOOD, FROZEN, INCONSISTENT, JUMPED."""
        if self.frozen:
            return FROZEN
        if self.suspect:
            return INCONSISTENT
        if self.jumped < CALM:
            return JUMPED
        return GOOD if self.seen else NONE

    @property
    def jumped_to_rest(self) -> bool:
        """Returns whether it is frozen and jumped just before: to its last value."""
        return self.frozen and self.jumped < JUST


BLANK = Watch(
    np.zeros(3), np.zeros(3), np.zeros(3), 0.0, False, False, False, np.zeros(3), 0.0, 0.0, 0.0, np.zeros(3), CALM
)


def noticed(w: Watch, v: Array, every: bool) -> Watch:
    """After a new measurement, of which v (3,) are elements; `every` of them, or one, has to repeat to the bit."""
    same = (v == w.last) & w.seen
    ended = ~same & (w.run > w.longest) & (not w.frozen)
    longest = np.where(ended, w.run, w.longest)
    run = np.where(same, w.run + 1.0, 0.0)
    still, moved = int((np.floor(run / REPEATS) > longest).sum()), int((~same).sum())
    stands, changed = still >= (3 if every else 1), moved >= (1 if every else 3)
    changes = min(w.changes + changed, REPEATS)
    w = replace(w, last=v, run=run, longest=longest, changes=changes, seen=True)
    if changes == REPEATS and stands != w.frozen:
        return replace(w, frozen=stands, changes=0.0 if stands else REPEATS, mean=np.zeros(3))
    return w


def averaged(mean: Array, value: Array, since: float) -> Array:
    """The mean (3,) after a value (3,), `since` s after the last one; one value counts up to LIMIT."""
    return mean + min(since, 1.0) / AVERAGED * (np.clip(value, -LIMIT, LIMIT) - mean)


def weighed(w: Watch, scaled: Array, within: bool) -> tuple[Watch, bool]:
    """After an innovation over its deviation (3,), and whether their mean is that of a failure.

    `within`: nothing else is wrong with it.
    """
    mean = averaged(w.mean, scaled, w.since)
    size = norm(mean)
    calm = w.calm + w.since if within and size < RIGHT else 0.0
    return replace(w, mean=mean, calm=calm, suspect=w.suspect and not calm > CALM), size > WRONG


def jumped(w: Watch, off: Array, least: float) -> tuple[Watch, bool]:
    """After a change of which `off` (3,) was not expected, and whether that is a jump: longer than `least`, and far
    longer than is usual."""
    square, most = float(off @ off), JUMP * JUMP * w.usual
    jumps = w.changes == REPEATS and square > least * least and square > most
    usual = w.usual + min(w.since, 1.0) / USUAL * ((most if jumps else square) - w.usual)
    w = replace(w, usual=usual)
    return (replace(w, jump=off, jumped=0.0), True) if jumps else (w, False)
