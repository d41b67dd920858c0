"""Finds a parameter whose other value makes ours give what theirs gives, by how much, and which others serve as well.

Tests: tests/orchestration/acceptance/test_causes.py.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache

import numpy as np

from ...fmu.model import Element, Floats
from .bench import Bench, clock
from .causes import Cause

_RANGE = 0.4, 2.5
_STARTS = (0.5, 0.8, 1.25, 2.0, *np.geomspace(*_RANGE, 33).tolist())
"""Factors that are tried first: limits and holds make many small steps."""
_GOLDEN = (5.0**0.5 - 1.0) / 2.0
_SERVES = 1e-4
"""A share of the outputs' size up to which a parameter of another value explains them."""
_NEAR, _MOST = 0.05, 6
"""One up to which it is looked at on the whole run, and for so many parameters."""


def changed_parameter(
    ours: Bench,
    few: Mapping[str, Floats],
    whole: Mapping[str, Floats],
    given_few: Mapping[str, Floats],
    given: Mapping[str, Floats],
    ends: float,
) -> tuple[Cause, float] | None:
    """Returns the parameter, and what it leaves of the whole run; None where none explains it.

    `few` and `whole` are inputs (instants, elements), `given_few` and `given` the outputs of theirs on them. No
    parameter is begun after `ends`, by `clock`, and then none is named: another could serve as well.
    """
    found: list[tuple[float, str, float, float]] = []
    for name in _parameters(ours):
        if clock() > ends:
            return None
        left = cache(_left(ours, name, few, given_few))
        if all(left(end) == left(1.0) for end in _RANGE):  # it has no effect on these inputs
            continue
        start = min(_STARTS, key=left)
        if left(start) >= left(1.0):
            start = 1.0
        factor, error = min(_least(left, start, 0.06), (start, left(start)), key=lambda pair: pair[1])
        if error < _NEAR and abs(factor - 1.0) > 1e-4:
            found.append((error, name, factor, start))
    held: list[tuple[float, str, float]] = []
    for _, name, *factors in sorted(found)[:_MOST]:
        left = cache(_left(ours, name, whole, given))
        factor = min(factors, key=left)  # a limit acts at few instants: there the course may be flat
        after = left(factor)
        if _SERVES < after < _NEAR:
            factor, after = _least(left, factor, 0.1)
        held += [(after, name, factor)] if after < _SERVES else []
    if not held:
        return None
    after, name, factor = min(held)
    equally = tuple((n, f) for _, n, f in held if n != name)
    words = " or ".join(f"{n} times {f:.4g}" for n, f in ((name, factor), *equally))
    return Cause("parameter", name, factor, f"a parameter of another value: {words}", after, equally), after


def _parameters(ours: Bench) -> list[str]:
    """Returns the real parameters of ours that are not zero."""
    starts = ours.values()
    reals = [v for v in ours.model.of("parameter") if v.type == "real"]
    return [v.name for v in reals if any(starts.get(e, 0.0) for e in v.elements)]


def _left(
    ours: Bench, name: str, inputs: Mapping[str, Floats], given: Mapping[str, Floats]
) -> Callable[[float], float]:
    starts, elements = ours.values(), ours.model.variables[name].elements

    def left(factor: float) -> float:
        values: dict[Element, float] = {e: float(starts.get(e, 0.0)) * factor for e in elements}
        played = ours.play({n: v for n, v in inputs.items() if n in ours.model.variables}, values)
        if played is None:
            return np.inf
        errors = [
            float(np.linalg.norm(played[n] - v)) / (float(np.linalg.norm(v)) or 1.0)
            for n, v in given.items()
            if n in played
        ]
        return sum(errors) / len(errors)

    return left


def _least(left: Callable[[float], float], start: float, reach: float) -> tuple[float, float]:
    """Returns the factor near a start that leaves least, by the golden section in its logarithm."""
    low, high = np.log(start) - reach, np.log(start) + reach
    a, b = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    one, two = left(float(np.exp(a))), left(float(np.exp(b)))
    for _ in range(34):
        if one < two:
            high, b, two = b, a, one
            a = high - _GOLDEN * (high - low)
            one = left(float(np.exp(a)))
        else:
            low, a, one = a, b, two
            b = low + _GOLDEN * (high - low)
            two = left(float(np.exp(b)))
        if high - low < 1e-7:
            break
    return (float(np.exp(a)), one) if one < two else (float(np.exp(b)), two)
