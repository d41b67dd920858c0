"""Finds what of another team's FMU may stand for a port of ours: variables, and the scalars of a vector.

Tests: tests/orchestration/acceptance/test_suggest.py.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from difflib import SequenceMatcher
from itertools import groupby, product

from ..fmu.model import Model, Variable
from ..quantities import ONE, QuantityError, Unit, parse_unit
from .words import words_of

_INDEX = re.compile(r"([xyzwsXYZWS0-9])(?=_|$)")
"""A letter or digit of a name that may be the index of an element."""
_PAIR = re.compile(r"([0-3xyz])[_.,]?(?:column_?|col_?|c)?([0-3xyz])(?=_|$)")
"""Two digits or letters of a name that may be the indices of a matrix's element: `C11`, `row1_x`, `r1c2`, `xy`."""
_ORDERS = ("xyz", "123", "012", "wxyz", "xyzw", "sxyz", "xyzs", "0123", "1234", "123456789", "012345678")
"""Endings of the scalars of one vector, in its order."""
_IN = re.compile(r"[\[(]([^\[\]()]{1,20})[\])]|\b(?:in|en) ([^\s,;:]{1,20})|, ?([^\s,;:]{1,20})$")
_SIGNS = str.maketrans({"·": ".", "⋅": ".", "*": ".", "²": "2", "µ": "u", "μ": "u", "°": "deg"})
"""Of units as people write them."""
_TOGETHER = 3, 4, 9
"""So many scalars in a row may be one vector, quaternion or matrix, though no index tells it."""


@dataclass(frozen=True)
class Candidate:
    """Something of theirs that may stand for one of ours: a variable, or scalars of one vector."""

    names: tuple[str, ...]
    variable: Variable
    """Of which type, unit and description it is."""
    size: int
    shape: tuple[int, ...]
    stem: str
    """The name, of scalars without the index."""
    in_a_row: bool = False
    """Whether nothing but their place tells that they belong together."""


def candidates(theirs: Model, causality: str) -> list[Candidate]:
    """Returns whole variables, and scalars whose names differ by the index of a vector's elements.

    An index may stand wherever a name has such a letter: of `gyros_x` both the s and the x are tried,
    and only the x has the y and z that make a vector.
    """
    variables = theirs.of(causality)
    found = [Candidate((v.name,), v, v.size, v.shape, v.name) for v in variables]
    stems: dict[str, dict[str, Variable]] = {}
    for variable in variables:
        for match in _INDEX.finditer(variable.name if variable.size == 1 else ""):
            stem = variable.name[: match.start()].rstrip("_.") + variable.name[match.end() :]
            if stem:
                stems.setdefault(stem, {})[match[1].lower()] = variable
    found += _matrices([v for v in variables if v.size == 1])
    for stem, members in stems.items():
        orders = [order for order in _ORDERS if set(order) == set(members)]
        if orders:
            order = "".join(members) if "".join(members) in orders else orders[0]
            chosen = [members[letter] for letter in order]
            found.append(Candidate(tuple(v.name for v in chosen), chosen[0], len(chosen), (len(chosen),), stem))
    return found + _in_a_row(variables, {name for one in found if len(one.names) > 1 for name in one.names})


def _in_a_row(variables: list[Variable], indexed: set[str]) -> list[Candidate]:
    """Returns scalars of one unit that follow each other without an index, such as `p`, `q`, `r`."""
    alone = [None if v.size > 1 or v.name in indexed else (v.type, str(v.unit)) for v in variables]
    found = []
    for kind, group in groupby(range(len(variables)), alone.__getitem__):
        chosen = _in_order([variables[i] for i in group])
        names, n = tuple(v.name for v in chosen), len(chosen)
        if kind is not None and n in _TOGETHER and _alike(names, {v.description for v in chosen}):
            found.append(Candidate(names, chosen[0], n, (3, 3) if n == 9 else (n,), "_".join(names), True))
    return found


def _in_order(scalars: list[Variable]) -> list[Variable]:
    """Returns three scalars in the order of the axes about which roll, pitch and yaw, or p, q and r, turn."""
    for order in (("roll", "pitch", "yaw"), ("p", "q", "r")):
        by_word = {word: v for v in scalars for word in words_of(v.name) if word in order}
        if len(scalars) == 3 and len({v.name for v in by_word.values()}) == 3:
            return [by_word[word] for word in order]
    return scalars


def _alike(names: tuple[str, ...], descriptions: set[str]) -> bool:
    """Returns whether names of one letter, a common beginning or end, or one description speak for one vector."""
    alike = any(len({name[part] for name in names}) == 1 for part in (slice(3), slice(-3, None)))
    return alike or all(len(name) == 1 for name in names) or len(descriptions - {""}) == 1


def _matrices(scalars: list[Variable]) -> list[Candidate]:
    """Returns scalars that are the elements of a matrix of 3 by 3: `C11`, `dcm_1_3`, `R_02`, `dcm_row1_x`."""
    stems: dict[str, dict[str, Variable]] = {}
    for variable in scalars:
        for match in _PAIR.finditer(variable.name):
            stem = variable.name[: match.start()].rstrip("_.") + variable.name[match.end() :]
            stems.setdefault(stem, {})[match[1] + match[2]] = variable
    found = []
    for stem, members in stems.items():
        for rows, columns in product(("123", "012", "xyz"), repeat=2):
            order = [i + j for i in rows for j in columns]
            if stem and set(order) == set(members):
                chosen = [members[key] for key in order]
                found.append(Candidate(tuple(v.name for v in chosen), chosen[0], 9, (3, 3), stem))
    return found


def likeness(ours: str, theirs: str) -> float:
    a, b = ("".join(words_of(name)) or name.lower() for name in (ours, theirs))
    return SequenceMatcher(None, a, b).ratio()


_COMMON = frozenset(
    "a an and at by each for from in is its of on or the their to that which with reading value along where".split()
)


def shared_words(ours: str, theirs: str) -> float:
    """Returns how much two descriptions have in common, by how words begin: `magnetic` is like `magnetometer`."""
    one, other = ({w[:6] for w in words_of(text) if w not in _COMMON and len(w) > 2} for text in (ours, theirs))
    both = sum(any(a.startswith(b[:5]) or b.startswith(a[:5]) for b in other) for a in one)
    return min(0.4 * both, 1.2)


def told_unit(candidate: Candidate, own: Unit) -> Unit | None:
    """Returns a unit that fits ours and that their name or description holds: `rate_dps`, `[nT]`, `in mN.m`."""
    texts = [a or b or c for a, b, c in _IN.findall(candidate.variable.description)]
    texts += re.split(r"[_.]", candidate.stem)[1:]
    for text in texts:
        unit = usual_unit(text.rstrip(".").translate(_SIGNS))
        if unit is not None and own.exponents != ONE.exponents and own.fits(unit):
            return unit
    return None


def usual_unit(name: str) -> Unit | None:
    try:
        return parse_unit(name)
    except QuantityError:
        return None
