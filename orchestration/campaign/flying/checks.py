"""Flights on FMUs that were reset, checked at random through a campaign against the same flights on fresh instances.

A reset that brings back the first state at first may leave it later. So of the flights with an FMU whose resets are not
known a share is flown twice, and the last one that each pilot has flown: where that is sound, so are those before it.
The first difference ends the resets, and what each pilot has flown since its last sound check is flown again.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Sequence

SHARE = 0.02
"""The share of flights that are flown twice, beside the last one of each pilot."""


class Checks:
    """Flights to be checked, and those that have been."""

    def __init__(self, seed: int, unchecked: Iterable[Sequence[int]] = ()) -> None:
        """`unchecked` are the flights of pilots of an earlier start."""
        self._random = random.Random(seed)
        self._flown: dict[object, list[int]] = {place: list(flown) for place, flown in enumerate(unchecked)}
        self._asked: set[int] = set()

    @property
    def unchecked(self) -> list[list[int]]:
        """Returns the runs that each pilot has flown since its last sound check, in their order."""
        return [flown for flown in self._flown.values() if flown]

    def took(self, pilot: object, indices: Sequence[int]) -> list[int]:
        """Notes the flights of a pilot, and returns those that are to be checked."""
        self._flown.setdefault(pilot, []).extend(indices)
        return self._ask(index for index in indices if self._random.random() < SHARE)

    def last(self) -> list[int]:
        """Returns the last flights of the pilots, as far as they have not been asked for."""
        return self._ask(flown[-1] for flown in self.unchecked)

    def sound(self, index: int) -> None:
        """Notes that a flight was as on fresh instances, and with it those of its pilot before it."""
        for flown in self._flown.values():
            if index in flown:
                del flown[: flown.index(index) + 1]

    def clear(self) -> list[int]:
        """Returns all flights since the last sound checks, and forgets them: they are flown again."""
        gone = sorted(index for flown in self._flown.values() for index in flown)
        self._flown.clear()
        return gone

    def _ask(self, indices: Iterable[int]) -> list[int]:
        new = [index for index in indices if index not in self._asked]
        self._asked.update(new)
        return new
