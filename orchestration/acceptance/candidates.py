"""What of another team's FMU may stand for a port of ours: variables and groups of scalars, and how much they have in common."""

from __future__ import annotations

import re
from dataclasses import dataclass
from difflib import SequenceMatcher

from ..fmu.model import Model, Variable
from ..quantities import ONE, QuantityError, Unit, parse_unit

_INDEX = re.compile(r"^(.*?)[_.]?([xyzXYZ]|[0-9]|[wsWS])(_.*|)$")
_ORDERS = ("xyz", "123", "012", "wxyz", "xyzw", "sxyz", "xyzs", "0123", "1234", "123456789", "012345678")
"""Endings of the scalars of one vector, in its order."""
_IN = re.compile(r"[\[(]([^\[\]()]{1,20})[\])]|\bin ([^\s,;:]{1,20})")


@dataclass(frozen=True)
class Candidate:
    """Something of theirs that may stand for one of ours: a variable, or scalars of one vector."""

    names: tuple[str, ...]
    variable: Variable
    """Of which type, unit and description it is."""
    size: int
    shape: tuple[int, ...]

    @property
    def stem(self) -> str:
        if len(self.names) == 1:
            return self.names[0]
        match = _INDEX.match(self.names[0])
        return (match[1] + match[3]) if match else self.names[0]


def candidates(theirs: Model, causality: str) -> list[Candidate]:
    """Whole variables, and scalars whose names end as the elements of a vector do."""
    variables = theirs.of(causality)
    found = [Candidate((v.name,), v, v.size, v.shape) for v in variables]
    stems: dict[tuple[str, str], dict[str, Variable]] = {}
    for variable in variables:
        match = _INDEX.match(variable.name)
        if variable.size == 1 and match and (match[1] or match[3]):
            stems.setdefault((match[1], match[3]), {})[match[2].lower()] = variable
    for members in stems.values():
        order = next((o for o in _ORDERS if set(o) == set(members) and "".join(members) == o), None)
        order = order or next((o for o in _ORDERS if set(o) == set(members)), None)
        if order is not None:
            chosen = [members[letter] for letter in order]
            found.append(Candidate(tuple(v.name for v in chosen), chosen[0], len(chosen), (len(chosen),)))
    return found


def _words(text: str) -> list[str]:
    parts = re.sub(r"([a-z])([A-Z])", r"\1 \2", text)
    return [w.lower() for w in re.split(r"[^A-Za-z]+", parts) if w]


def likeness(ours: str, theirs: str) -> float:
    a, b = ("".join(_words(re.sub(r"_[A-Z]+\d*$", "", name))) or name.lower() for name in (ours, theirs))
    return SequenceMatcher(None, a, b).ratio()


_COMMON = frozenset(
    "a an and at by each for from in is its of on or the their to that which with reading value along where".split()
)


def shared_words(ours: str, theirs: str) -> float:
    """How much two descriptions have in common: words by their beginnings, so that `magnetic` is like `magnetometer`."""
    one, other = ({w[:6] for w in _words(text) if w not in _COMMON and len(w) > 2} for text in (ours, theirs))
    both = sum(any(a.startswith(b[:5]) or b.startswith(a[:5]) for b in other) for a in one)
    return min(0.4 * both, 1.2)


def told_unit(candidate: Candidate, own: Unit) -> Unit | None:
    """A unit that fits ours and that their name or description holds: `rate_dps`, `field [nT]`, `in mN.m`."""
    texts = [a or b for a, b in _IN.findall(candidate.variable.description)]
    texts += re.split(r"[_.]", candidate.stem)[1:]
    for text in texts:
        unit = usual_unit(text.rstrip("."))
        if unit is not None and own.exponents != ONE.exponents and own.fits(unit):
            return unit
    return None


def usual_unit(name: str) -> Unit | None:
    try:
        return parse_unit(name)
    except QuantityError:
        return None
