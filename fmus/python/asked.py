"""A list of value references that a host gives: looked at once, since masters give the same ones in every step.

Carried by every Python FMU, so it needs the standard library only. Tests: tests/fmus/python/test_slave.py.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence, Set
from dataclasses import dataclass
from typing import Any

Values = list[Any]


@dataclass(frozen=True)
class Asked:
    """The variables of a list of value references, looked up before their values are read or set."""

    known: bool
    """Whether all are of the type that is asked for,"""
    settable: bool
    """may be set before the block's first state,"""
    tunable: bool
    """and after it."""
    outputs: bool
    """Whether an output is among them,"""
    parameters: bool
    """a parameter,"""
    bounded: bool
    """or what has limits."""
    take: Callable[[Values], list[Any]]
    put: Callable[[Values, Sequence[Any]], None]


def look(references: Sequence[int], whole: Sequence[frozenset[int]], some: Sequence[Set[int]]) -> Asked:
    """Returns what holds of these value references: all of them in each set of `whole`, some in each of `some`."""
    places = list(references)
    first, after = (places[0], places[-1] + 1) if places else (0, 0)

    def take_each(values: Values) -> list[Any]:
        return [values[r] for r in places]

    def put_each(values: Values, given: Sequence[Any]) -> None:
        for r, value in zip(places, given, strict=True):
            values[r] = value

    def take_run(values: Values) -> list[Any]:
        return values[first:after]

    def put_run(values: Values, given: Sequence[Any]) -> None:
        values[first:after] = given

    run = places == list(range(first, after))
    known, settable, tunable = (among.issuperset(places) for among in whole)
    outputs, parameters, bounded = (not among.isdisjoint(places) for among in some)
    take, put = (take_run, put_run) if run else (take_each, put_each)
    return Asked(known, settable, tunable, outputs, parameters, bounded, take, put)
