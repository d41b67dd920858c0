"""Proposes a mapping for another team's FMU, from names, units, shapes and descriptions of both sides, as YAML to edit.

What it rests on stands beside each entry, and `unsure` where a second candidate is near or only a name speaks for it.
Signs and axes no description tells: `orchestrate polarity` finds those.

Longer than 250 lines: what each port is matched by, and the text that says so, are of one table of matches.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from ..errors import printable
from ..fmu.interfaces import Interface
from ..fmu.model import Element, Model, Variable, unit_of
from ..quantities import ONE, Unit, parse_unit
from ..scenario.text import written
from ..swap.findings import Fit
from .candidates import Candidate, candidates, likeness, shared_words, told_unit, usual_unit
from .polarity.wrongs import USUAL
from .words import SEQUENCE, asides, axes, direction, meanings, of_orbit, opposite, rotation_form, scalar_last

_UNSURE = 0.4
"""A second candidate with a score this near leaves the first unsure."""
_LEAST = 1.0
_LEAST_NAME = 0.45
"""Of a parameter: how alike the names have to be, since units of limits are alike."""


@dataclass
class _Match:
    ours: Variable
    candidate: Candidate
    score: float
    why: list[str]
    extra: dict[str, Any] = field(default_factory=dict)
    unsure: bool = False
    aside: bool = False
    """Whether theirs is told to be something beside our quantity, so that another candidate goes before."""


def suggest(fitted: Fit) -> str:
    """Returns the mapping as YAML, valid under a block's `map`. `fitted` is how theirs fits without one."""
    return _Suggestion(fitted.reference, fitted.theirs).text()


class _Suggestion:
    def __init__(self, reference: Interface, theirs: Model) -> None:
        self.reference, self.theirs = reference, theirs
        self.ours = reference.model.variables
        self.matches: dict[str, _Match] = {}
        self.same = [
            v.name
            for v in reference.model.of("input", "output", "parameter")
            if (other := theirs.variables.get(v.name)) is not None and _alike(v, other)
        ]
        taken = {Element(name, p) for name in self.same for p in range(theirs.variables[name].size)}
        for causality in ("input", "output", "parameter"):
            for optional in (False, True):
                self._assign(causality, optional, taken)
        for causality in ("input", "output"):
            self._take_what_is_left(causality, taken)

    def _take_what_is_left(self, causality: str, taken: set[Element]) -> None:
        """Takes for what has to be there the one candidate of its type, size and unit that is left."""
        of = [v for v in self.reference.model.of(causality) if not self._stands(v) and not self._spare(v)]
        for ours in of:
            left: dict[tuple[str, ...], _Match] = {}
            for candidate in candidates(self.theirs, causality):
                elements = {e for name in candidate.names for e in self._variable(name).elements}
                match = _Match(ours, candidate, 0.0, ["the only one left of its size and unit"], unsure=True)
                alike = candidate.variable.type == ours.type and candidate.shape == ours.shape
                if alike and not elements & taken and (ours.type != "real" or self._units(match)):
                    left[candidate.names] = match
            rivals = [v for v in of if v is not ours and v.shape == ours.shape and unit_of(v).fits(unit_of(ours))]
            if len(left) == 1 and not rivals:
                self.matches[ours.name] = match = left.popitem()[1]
                match.unsure = True
                taken |= {e for name in match.candidate.names for e in self._variable(name).elements}

    def _assign(self, causality: str, optional: bool, taken: set[Element]) -> None:
        """Takes the best candidate for each of ours, the best pair first; of what has to be there before the rest."""
        of = [v for v in self.reference.model.of(causality) if v.name not in self.same]
        free = [v for v in of if self._spare(v) == optional]
        pairs = [
            match
            for ours in free
            for candidate in candidates(self.theirs, causality)
            if (match := self._match(ours, candidate)) is not None
        ]
        scores: dict[str, list[float]] = {}
        for match in sorted(pairs, key=lambda m: -m.score):
            scores.setdefault(match.ours.name, []).append(match.score)
            elements = {e for name in match.candidate.names for e in self._variable(name).elements}
            if match.ours.name in self.matches or elements & taken:
                continue
            self.matches[match.ours.name] = match
            taken |= elements
        for name, match in self.matches.items():
            near = [s for s in scores.get(name, ()) if s != match.score and abs(s - match.score) < _UNSURE]
            match.unsure = match.unsure or bool(near)

    def _variable(self, name: str) -> Variable:
        """Returns the variable of theirs that has this name, or an element of it."""
        known = self.theirs.variables
        return known[name] if name in known else known[name.partition("[")[0]]

    def _spare(self, variable: Variable) -> bool:
        """Returns whether it goes without: an optional input, or an output that no other block needs."""
        needed = variable.causality != "output" or variable.name in self.reference.needed
        return variable.optional or not needed

    def _match(self, ours: Variable, candidate: Candidate) -> _Match | None:
        theirs = candidate.variable
        if theirs.type != ours.type or theirs.items != ours.items:
            return None
        name = likeness(ours.name, candidate.stem)
        words = shared_words(ours.description, theirs.description)
        if ours.causality == "parameter" and name < _LEAST_NAME:
            return None
        match = _Match(ours, candidate, 2.0 * name + words, [f"names {100 * name:.0f} % alike"])
        if candidate.in_a_row:
            match.why.append("scalars in a row")
        if words:
            match.why.append("descriptions share words")
        if ours.causality != "parameter" and not self._meaning(match):
            return None
        if ours.causality != "parameter":
            self._asides(match)
        quaternion = ours.shape == (3, 3) and candidate.size == 4
        form = rotation_form(f"{candidate.stem} {theirs.description}") if ours.shape == (3, 3) else ""
        if candidate.size == 3 and form:
            return self._three(match, form)
        if candidate.size != ours.size and not quaternion:
            return None
        if len(candidate.names) == 1 and candidate.shape != ours.shape and not quaternion:
            match.extra["matrix"] = [[int(i == j) for j in range(ours.size)] for i in range(ours.size)]
        if quaternion:
            last = scalar_last(candidate.names, theirs.description)
            match.extra["quaternion"] = "scalar last" if last else "scalar first"
            match.unsure = last is None
            if self._backwards(match):
                match.extra["inverse"] = True
            match.score += 2.0
            match.why.append("4 values for a rotation")
        elif ours.type == "real" and not self._units(match):
            return None
        elif candidate.size > 1:
            match.score += 0.5
        if ours.causality != "parameter":
            self._frames(match)
        return self._enough(match)

    def _meaning(self, match: _Match) -> bool:
        """Returns whether the field's words of both sides can mean one thing; what they share counts."""
        ours, theirs = match.ours, match.candidate
        one = meanings(ours.name, ours.description)
        by_name, other = meanings(theirs.stem), meanings(theirs.stem, theirs.variable.description)
        if not one or not other:
            return not ours.optional
        fits = theirs.variable.unit is not None and unit_of(ours).exponents not in (None, ONE.exponents)
        fits = fits and theirs.variable.unit is not None and unit_of(ours).fits(theirs.variable.unit)
        both = one & other
        match.score += 1.2 * len(both) - 0.3 * len(one ^ other) + 0.6 * len(one & by_name)
        if both:
            match.why.append(f"both mean {' and '.join(sorted(both))}")
        return (bool(both) or fits) and (not self._spare(ours) or one == other)

    def _asides(self, match: _Match) -> None:
        """Takes less what is told to be a reference, an earlier value or a bias, or relative to the orbit."""
        ours, theirs = match.ours, match.candidate.variable
        text = f"{match.candidate.stem} {theirs.description}"
        output = ours.causality == "output"
        told = asides(match.candidate.stem, theirs.description, output)
        told -= asides(ours.name, ours.description, output)
        found = [f"their words tell {what}" for what in sorted(told)]
        rotation = ours.shape == (3, 3)
        if of_orbit(text, rotation) and not of_orbit(ours.description, rotation):
            what = "an attitude" if rotation else "a rate"
            found.append(f"their words tell {what} relative to the orbit, which no mapping gives")
        if found:
            match.score, match.aside = match.score - 2.0, True
            match.why += found

    def _three(self, match: _Match, form: str) -> _Match | None:
        """Three numbers for our rotation matrix."""
        theirs = match.candidate.variable
        match.extra["rotation"] = form
        text = f"{match.candidate.stem} {theirs.description}"
        if theirs.unit is None and re.search(r"\[deg\]|\bdeg(?:rees)?\b", text):
            match.extra["unit"] = "deg"
        if self._backwards(match):
            match.extra["inverse"] = True
        match.unsure = form.startswith("euler") and SEQUENCE.search(text) is None
        match.score += 2.0
        match.why.append(f"3 values for a rotation: {form}")
        return self._enough(match)

    def _enough(self, match: _Match) -> _Match | None:
        """The match, unless too little speaks for it; what is told to be something beside goes last, and is unsure."""
        match.unsure = match.unsure or match.aside or match.candidate.in_a_row
        return match if match.score + 2.0 * match.aside >= _LEAST else None

    def _backwards(self, match: _Match) -> bool:
        """Returns whether theirs is told to be the inverse of our rotation matrix."""
        told = direction(match.candidate.variable.description) or direction(match.candidate.stem)
        to, _, from_ = (match.ours.frame or "").partition(" from ")
        return told is not None and told == (to, from_)

    def _frames(self, match: _Match) -> None:
        """Takes what their words tell of a matrix's direction, of a vector's axes and of a torque's side."""
        ours, theirs = match.ours, match.candidate.variable
        if ours.shape == (3, 3) and match.candidate.size == 9 and self._backwards(match):
            names = match.candidate.names
            labels = names if len(names) == 9 else [theirs.label(p).replace("][", ",") for p in range(9)]
            turned = tuple(labels[3 * (i % 3) + i // 3] for i in range(9))
            match.candidate = replace(match.candidate, names=turned)
            match.extra.pop("matrix", None)
            match.why.append("of the inverse rotation")
        told = axes(theirs.description)
        if ours.shape == (3,) and ours.causality == "input" and told and told != ours.frame and ours.frame:
            for other in self.reference.model.of("input"):
                to, _, from_ = (other.frame or "").partition(" from ")
                if other.shape == (3, 3) and not other.optional and {to, from_} == {told, ours.frame}:
                    match.extra |= {"turn": other.name} | ({"inverse": True} if told == from_ else {})
                    match.why.append(f"along the axes of {told}")
        if ours.size == 1 and ours.type == "real" and opposite(ours.description, theirs.description):
            key = "divide" if "divide" in match.extra else "scale"
            value = match.extra.get(key, 1)
            match.extra[key] = f"-{value}" if isinstance(value, str) else -value
            match.unsure = True
            match.why.append("their words tell the other side, so the opposite sign")

    def _units(self, match: _Match) -> bool:
        """Returns whether the units fit, or a factor with a unit makes them."""
        own, unit = unit_of(match.ours), match.candidate.variable.unit
        if unit is None or (unit.exponents == ONE.exponents != own.exponents):
            unit = told_unit(match.candidate, own)
            if unit is None:
                match.unsure = True
                if (near := self._by_size(match, own)) is not None:
                    match.extra["unit"] = str(near)
                    match.why.append(f"their start value is like ours in {near}")
                    return True
                if match.candidate.variable.unit is not None:
                    match.extra["unit"] = str(own)
                match.why.append("their unit is not known" if own.exponents != ONE.exponents else "no unit")
                return True
            match.extra["unit"] = str(unit)
            match.unsure = True
            match.why.append(f"unit {unit} is read from their name or description")
        if unit.exponents is None:
            unit = usual_unit(unit.name) or unit
        if own.fits(unit):
            match.score += 2.0 if own.exponents != ONE.exponents else 0.3
            match.why.append(f"units {own} and {unit}" if str(own) != str(unit) else f"unit {own}")
            return True
        if own.exponents is not None and unit.exponents is not None and own.exponents[:-1] == unit.exponents[:-1]:
            match.extra["unit"] = str(own)
            match.unsure = True
            match.score += 1.0
            match.why.append(f"units {own} and {unit} differ by the radian only")
            return True
        return match.ours.causality != "parameter" and self._factor(match, own, unit)

    def _by_size(self, match: _Match, own: Unit) -> Unit | None:
        """Returns a usual unit in which their start values have the size of ours; None where none or ours has."""
        names = match.candidate.names
        elements = [e for name in names for e in self._variable(name).elements]
        theirs = sum(float(self.theirs.starts.get(e, 0.0) or 0.0) ** 2 for e in elements) ** 0.5
        ours = sum(float(self.reference.starts.get(e, 0.0) or 0.0) ** 2 for e in match.ours.elements) ** 0.5
        if not theirs or not ours or own.exponents == ONE.exponents:
            return None
        family = next((f for f in USUAL if parse_unit(f[0]).exponents == own.exponents), ())
        ratios = {name: abs(math.log(theirs * parse_unit(name).factor / ours / own.factor)) for name in family}
        nearest = min(ratios, key=ratios.__getitem__, default=None)
        if nearest is None or ratios[nearest] > 1.0 or parse_unit(nearest).factor == own.factor:
            return None
        return parse_unit(nearest)

    def _factor(self, match: _Match, own: Unit, unit: Unit) -> bool:
        """Returns whether a parameter, such as an inertia, has the unit by which the two differ."""
        for where, parameter, value in self._scalars():
            by = unit_of(parameter)
            if by.exponents in (None, ONE.exponents) or own.exponents is None or unit.exponents is None or not value:
                continue
            for key, sign in (("divide", -1), ("scale", 1)):
                got = [a + sign * b for a, b in zip(own.exponents, by.exponents or (), strict=True)]
                if tuple(got[:-1]) == unit.exponents[:-1]:
                    match.extra[key] = f"{float(value):.10g} {by}"
                    match.why.append(f"{own} to {unit} by {parameter.name} {where}")
                    match.unsure, match.score = True, match.score + 1.0
                    return True
        return False

    def _scalars(self) -> Iterator[tuple[str, Variable, Any]]:
        """Yields scalar parameters of theirs, then of our blocks, with their values."""
        for variable in self.theirs.of("parameter"):
            if variable.size == 1 and variable.type == "real":
                yield "of theirs", variable, self.theirs.starts.get(variable.elements[0])
        for block, model in self.reference.others.items():
            for variable in model.of("parameter"):
                if variable.size == 1 and variable.type == "real":
                    yield f"of our {block}", variable, model.starts.get(variable.elements[0])

    # ------------------------------------------------------------ text

    def text(self) -> str:
        lines = [
            f"# How {printable(self.theirs.name)} may stand in the place of {self.reference.name}: a proposal, "
            "to be edited.",
            "# Signs and axes are taken to be ours; 'orchestrate polarity' tells where they are not.",
            "ports:" if self.matches else "ports: {}",
        ]
        for name, match in self.matches.items():
            lines.append(f"  {name}: {_entry(match)}  # {_comment(match)}")
        missing = [v for v in self.reference.model.of("input", "output", "parameter") if not self._stands(v)]
        used = {self._variable(name).name for match in self.matches.values() for name in match.candidate.names} | set(
            self.same
        )
        left = [v for v in self.theirs.of("input") if v.name not in used and not v.optional]
        ignore = []
        for variable in missing:
            if variable.name in self.reference.needed:
                lines.append(f"  # {variable.name}: THEIRS  # not found: other blocks need it")
            elif variable.causality == "input" and left and not variable.optional:
                names = ", ".join(written(v.name, flow=True) for v in left)
                lines.append(f"  # {variable.name}: THEIRS  # not found: one of {names}? Else list it under ignore")
            elif not variable.optional:
                ignore.append(variable)
        if left and not any(v.causality == "input" and not v.optional for v in missing):
            lines.append("start:")
            lines += [f"  {written(v.name, flow=True)}: {self._start(v)}  # unsure: {_ALONE}" for v in left]
        if ignore:
            lines.append(f"ignore: [{', '.join(v.name for v in ignore)}]  # theirs has nothing like these")
        return "\n".join(lines) + "\n"

    def _stands(self, variable: Variable) -> bool:
        return variable.name in self.matches or variable.name in self.same

    def _start(self, variable: Variable) -> str:
        values = [self.theirs.starts.get(e, 0) for e in variable.elements]
        return written(values if variable.shape else values[0], flow=True)


_ALONE = "only theirs has this input; or connect it under inputs"


def _alike(ours: Variable, theirs: Variable) -> bool:
    units = theirs.unit is not None and unit_of(ours).fits(theirs.unit)
    return (ours.causality, ours.type, ours.shape) == (theirs.causality, theirs.type, theirs.shape) and (
        ours.type != "real" or units
    )


def _entry(match: _Match) -> str:
    names = match.candidate.names
    theirs = names[0] if len(names) == 1 else list(names)
    return written({"theirs": theirs, **match.extra} if match.extra else theirs, flow=True)


def _comment(match: _Match) -> str:
    return ("unsure: " if match.unsure else "") + printable("; ".join(match.why)).replace("\n", " ")
